// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "casefile/record_cases.hpp"
#include "kalfem/formats/hdf5/hdf5_file.hpp"
#include "kalfem/report/console_report.hpp"
#include "kalfem/report/result_set.hpp"
#include "kalfem/steps/run_study.hpp"
#include "kalfem/steps/validation/outcome.hpp"

/// `validate`: the estimates on data that they were not found from.
namespace kalfem::record_cases {
namespace {

using Changes = std::vector<std::pair<std::string, std::string>>;

const std::string first_half = "record: {file: record.csv, end: 2 s}\n";

/// The sound case, estimated from the first two seconds; `validate` stands on the line behind its record.
Changes validated(const std::string& validate, Changes more = {}) {
  more.insert(more.begin(), {"record: {file: record.csv}\n", first_half + "validate: {" + validate + "}\n"});
  return more;
}

/// Columns of the record with its motion times a factor, and the force that belongs to `force_factor` of it.
std::vector<Column> columns_times(double factor, double force_factor) {
  return {
      {"F", written(force, force_factor)}, {"x", written(displacement, factor)}, {"a", written(acceleration, factor)}};
}

class Validation : public RecordCase {
protected:
  void SetUp() override { write_record(si_columns()); }
  void write_file(const std::string& name, const std::vector<Column>& columns) {
    std::ofstream(folder_ / name) << table(columns);
  }
  StudyResults run(const Changes& changes) {
    StudyResults results = run_study(load(changes), "update");
    EXPECT_TRUE(results.complete()) << results.failure;
    EXPECT_TRUE(results.has<ValidationOutcome>());
    return results;
  }
  static std::vector<std::string> codes(const StudyResults& results) {
    std::vector<std::string> found;
    for (const auto& reason : results.verdict.reasons()) found.push_back(reason.code + " " + reason.subject);
    return found;
  }
};

TEST_F(Validation, PredictsAnotherPartOfTheSameRecord) {
  const auto results = run(validated("start: 2.01 s"));
  const auto &held_back = results.get<ValidationOutcome>().held_back, &own = results.get<ValidationOutcome>().own;
  EXPECT_EQ(held_back.failure, "");
  EXPECT_EQ(held_back.measured.samples(), 200);
  EXPECT_EQ(held_back.first, 20);  // a tenth of the part
  for (const double error : held_back.nrmse) EXPECT_LT(error, 0.01);
  for (const double error : own.nrmse) EXPECT_LT(error, 0.01);
  for (const auto& code : codes(results)) EXPECT_FALSE(code.starts_with("validation")) << code;
}

/// In the middle of a motion nothing is at rest.
TEST_F(Validation, EstimatesTheInitialStateUnlessItIsAtRest) {
  const auto estimated = run(validated("start: 2.05 s, lead_in: 0.3 s"));
  const auto resting = run(validated("start: 2.05 s, initial: rest"));
  EXPECT_EQ(estimated.get<ValidationOutcome>().held_back.first, 30);
  EXPECT_EQ(resting.get<ValidationOutcome>().held_back.first, 0);
  EXPECT_LT(estimated.get<ValidationOutcome>().held_back.nrmse[0], 0.01);
  EXPECT_GT(resting.get<ValidationOutcome>().held_back.nrmse[0], 0.1);
}

TEST_F(Validation, PredictsAnotherRecordUnderItsOwnInput) {
  write_file("other.csv", columns_times(3.0, 3.0));
  const auto results = run(validated("record: {file: other.csv}, start: 1 s, end: 3 s"));
  const auto& held_back = results.get<ValidationOutcome>().held_back;
  EXPECT_EQ(held_back.measured.samples(), 201);
  EXPECT_NEAR(held_back.measured.values.row(0).maxCoeff(), 3.0 * amplitude, 1e-3);
  EXPECT_LT(held_back.nrmse[0], 0.01);
}

TEST_F(Validation, TakesAnInputFromTheFileThatTheCaseNames) {
  write_file("motion.csv", {{"x", written(displacement, 2.0)}, {"a", written(acceleration, 2.0)}});
  write_file("blows.csv", {{"F", written(force, 2.0)}});
  const auto results = run(validated("record: {file: motion.csv}, excitation: {F: blows.csv}"));
  EXPECT_LT(results.get<ValidationOutcome>().held_back.nrmse[0], 0.01);
}

/// The stiffness is wrong and not estimated: the structure would move against the force.
TEST_F(Validation, AWrongParameterIsAReason) {
  const auto results =
      run(validated("start: 2.01 s",
                    {{"stiffness: 800 N/m", "stiffness: 100 N/m"},
                     {"s.k.stiffness: {initial: 760 N/m, std: 20 %}", "s.k.damping: {initial: 2 N s/m, std: 20 %}"}}));
  EXPECT_GT(results.get<ValidationOutcome>().held_back.nrmse[0], 0.9);
  const auto found = codes(results);
  EXPECT_TRUE(std::ranges::any_of(found, [](const auto& code) { return code.starts_with("validation_error"); }))
      << results.get<ValidationOutcome>().held_back.nrmse[0];
}

/// The other record is of a structure that moves three times as far under the same force.
TEST_F(Validation, AnErrorMuchLargerThanOnTheOwnPartIsAReason) {
  write_file("other.csv", columns_times(3.0, 1.0));
  const auto results = run(validated("record: {file: other.csv}"));
  EXPECT_GT(results.get<ValidationOutcome>().held_back.nrmse[0], 0.6);  // two thirds, and a vibration from the start
  EXPECT_LT(results.get<ValidationOutcome>().held_back.nrmse[0], 0.9);
  const auto found = codes(results);
  EXPECT_NE(std::ranges::find(found, "validation_worse x"), found.end());
  EXPECT_EQ(results.verdict.state(), VerdictState::suspicious);
}

TEST_F(Validation, StandsInEveryResult) {
  const Changes changes = validated("start: 2.01 s", {{"  settle: 0.5 s", "  settle: 0.5 s\n  second_thoughts: full"}});
  const Study study = load(changes);
  const auto results = run_study(study, "estimate");
  const auto summary = summarise(study, results);
  const auto& held_back = results.get<ValidationOutcome>().held_back;
  EXPECT_EQ(summary["validation"]["x"]["nrmse"].get<double>(), held_back.nrmse[0]);
  EXPECT_EQ(summary["validation"]["a"]["nrmse_estimated_part"].get<double>(),
            results.get<ValidationOutcome>().own.nrmse[1]);
  // The model is right: one sample ahead, and open loop, all that is left is noise.
  ASSERT_EQ(held_back.one_step.size(), held_back.nrmse.size());
  EXPECT_EQ(summary["validation"]["a"]["one_step_nrmse"].get<double>(), held_back.one_step[1]);
  for (std::size_t j = 0; j < held_back.nrmse.size(); ++j)
    EXPECT_LT(held_back.one_step[j], 1.5 * held_back.noise[j]) << held_back.nrmse[j];
  EXPECT_EQ(summary["validation_record"]["start_s"].get<double>(), 2.01);
  EXPECT_EQ(summary["validation_record"]["end_s"].get<double>(), 4.0);
  EXPECT_EQ(summary["validation_record"]["compared_from_s"].get<double>(), 2.21);
  EXPECT_NE(console_report(study, results).find("Validation: 2.01 s to 4 s of record.csv"), std::string::npos)
      << console_report(study, results);
  const auto page = make_page(study, results);
  const auto section = std::ranges::find(page.sections, "Validation", &Section::heading);
  ASSERT_NE(section, page.sections.end());
  EXPECT_EQ(section->items.size(), 5U);  // a table, and each sensor as a whole and zoomed
  const auto file = (folder_ / "results.h5").string();
  write_results(file, study, results, "0");
  EXPECT_TRUE(Hdf5File::open(file).read("/validation/x/simulated").isApprox(held_back.simulated.row(0).transpose()));
}

/// An updating by a frequency, without a filter: the structure is simulated with the updated spring.
TEST_F(Validation, IsPossibleOfAnUpdatingAlone) {
  const std::string estimate = sound_case.substr(sound_case.find("estimate:"));
  const auto results = run(validated("start: 2.01 s", {{estimate,
                                                        "update: {parameters: {s.k.stiffness: {initial: 780 N/m}}, "
                                                        "compare: {f: {modes: s, frequencies: [3.18309886 Hz]}}}\n"}}));
  EXPECT_LT(results.get<ValidationOutcome>().held_back.nrmse[0], 0.02);
}

TEST_F(Validation, RefusesPartsThatCannotBe) {
  expect_in(errors(validated("start: 1.5 s")),
            {"case.yaml:10: validate: its part, 1.5 s to 4 s, overlaps the part that is estimated from, 0 s to 2 s"});
  expect_in(errors(validated("start: 3 s, end: 2.5 s")), {"case.yaml:10: validate.start, validate.end"});
  expect_in(errors(validated("start: 7 s")), {"case.yaml:10: validate.start, validate.end"});
  expect_in(errors(validated("initial: rest")), {"case.yaml:10: validate: nothing says which data to use"});
  expect_in(errors(validated("start: 3 s, lead_in: 2 s")),
            {"case.yaml:10: validate.lead_in is 2 s, but the part is 1 s long"});
  expect_in(errors(validated("start: 3 s, lead_in: 0.2 s, initial: rest")), {"validate.lead_in is given with"});
  EXPECT_EQ(errors(validated("start: 2.01 s")), "");
}

TEST_F(Validation, RefusesRecordsWithoutWhatItNeeds) {
  write_file("motion.csv", {{"x", written(displacement)}, {"a", written(acceleration)}});
  write_file("forced.csv", {{"F", written(force)}, {"x", written(displacement)}});
  expect_in(errors(validated("record: {file: motion.csv}")), {"excitation.F", "'F'"});
  expect_in(errors(validated("record: {file: forced.csv}")), {"'a'"});
  expect_in(errors(validated("record: {file: nothing.csv}")), {"validate.record.file", "no file"});
  expect_in(errors(validated("record: {file: record.csv, start: 3 s}, start: 3 s")), {"its part is given twice"});
  expect_in(errors(validated("record: {file: record.csv, start: 1 s}")), {"overlaps"});
  expect_in(errors(validated("record: {file: motion.csv}, excitation: {G: forced.csv}")),
            {"there is no excitation 'G'"});
  const std::string sine = "F: {force: s.m, sine: {amplitude: 1, frequency: 2}}";
  write_file("other.csv", si_columns());
  expect_in(errors(validated("record: {file: other.csv}", {{"F: {force: s.m, file: record.csv, channel: F}", sine}})),
            {"excitation 'F' is not measured"});
  expect_in(errors(validated("start: 3 s, excitation: {F: forced.csv}")), {"excitation is given without a record"});
  EXPECT_EQ(errors(validated("record: {file: record.csv, start: 3 s}")), "");
}

TEST_F(Validation, RefusesCasesWithoutEstimatesOrMeasuredData) {
  const std::string estimate = sound_case.substr(sound_case.find("estimate:"));
  expect_in(errors(validated("start: 2.01 s", {{estimate, ""}})), {"validate: the case estimates nothing"});
  expect_in(errors({{"record: {file: record.csv}\n",
                     "simulate: {duration: 1 s, sample_rate: 100 Hz}\nvalidate: {start: 2 s}\n"}}),
            {"case.yaml:10: validate: the case simulates its record"});
}

}  // namespace
}  // namespace kalfem::record_cases
