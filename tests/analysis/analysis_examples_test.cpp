// SPDX-License-Identifier: Apache-2.0
#include <fstream>

#include "base/absent.hpp"
#include "base/data_folder.hpp"
#include "base/places.hpp"
#include "kalfem/analysis/analysis.hpp"
#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/steps/run_study.hpp"
#include "kalfem/steps/updating/outcome.hpp"

// Every example that estimates: the command's run of the case, the library's estimate from what read_case() gives, and
// both again from the case that to_case() writes of it. Parameters, innovations and likelihood are the same, bit for
// bit: they come from the same structure, record and settings.

namespace kalfem::test {
namespace {

using Changes = std::vector<std::pair<std::string, std::optional<std::string>>>;
namespace fs = std::filesystem;

/// An example, cut so that the whole comparison takes seconds.
struct Example {
  std::string file;
  Changes changes;
  std::string data = {};  ///< its folder below shared/data; empty: it needs none
};

void PrintTo(const Example& example, std::ostream* out) { *out << example.file; }

const Changes simulated_second{{"simulate.duration", "1 s"}, {"estimate.settle", "0.1 s"}};

const std::vector<Example> examples{
    {"start/chain/case.yaml", simulated_second},
    {"start/component/case.yaml", {{"record.end", "1 s"}}},
    {"start/measured/case.yaml", {{"record.end", "2 s"}}},
    {"start/vehicle/case.yaml", simulated_second},
    {"chain/chain.yaml", simulated_second},
    {"chain/bouc_wen.yaml", simulated_second},
    {"chain/clustered.yaml", simulated_second},
    {"chain/expression.yaml", simulated_second},
    {"chain/infer.yaml", simulated_second},
    {"chain/place.yaml", simulated_second},
    {"painter-street/painter_street.yaml", {{"record.end", "6 s"}}, "painter-street"},
    {"friction-damper/friction_damper.yaml", {{"record.end", "3 s"}}, "friction-damper"},
    {"friction-damper/laws.yaml", {{"record.end", "3 s"}}, "friction-damper"},
    {"halfcar/halfcar.yaml", {{"estimate.passes", "1"}}, "halfcar-rig"},
    {"halfcar/raw.yaml", {{"estimate.passes", "1"}}, "halfcar-rig"},
    {"halfcar/laws.yaml", {}, "halfcar-rig"},
    {"sysid-benchmarks/silverbox.yaml", {{"record.end", "3 s"}}, "sysid-benchmarks"},
    {"sysid-benchmarks/bouc_wen.yaml", {{"record.end", "2 s"}}, "sysid-benchmarks"},
    {"mr-damper/mr_damper.yaml", {{"record.end", "1 s"}}, "mr-damper"},
    {"mr-damper/laws.yaml", {{"record.end", "1 s"}}, "mr-damper"},
    {"shake-table-frames/one_storey.yaml", {{"record.end", "4 s"}}, "shake-table-frames"},
    {"shake-table-frames/three_storeys.yaml", {{"record.end", "4 s"}}, "shake-table-frames"},
};

/// Without second thoughts, and without the sections of other steps.
Changes with_short_run(Changes changes, const std::string& path) {
  for (const auto& [key, value] :
       Changes{{"estimate.diagnose", "false"}, {"estimate.second_thoughts", "none"}, {"estimate.substeps", "1"}})
    changes.emplace_back(key, value);
  std::ifstream file(path);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  for (const std::string section : {"validate", "predict", "infer", "place", "report"})
    if (text.find("\n" + section + ":") != std::string::npos) changes.emplace_back(section, std::nullopt);
  return changes;
}

/// The same bits, or not a number in both.
void expect_same(const Eigen::Ref<const Eigen::MatrixXd>& found, const Eigen::Ref<const Eigen::MatrixXd>& expected,
                 const std::string& of) {
  ASSERT_EQ(found.rows(), expected.rows()) << of;
  ASSERT_EQ(found.cols(), expected.cols()) << of;
  const auto same = (found.array() == expected.array()) || (found.array().isNaN() && expected.array().isNaN());
  EXPECT_TRUE(same.all()) << of << ": " << (!same).count() << " of " << found.size() << " numbers differ";
}

void expect_same(const EstimateResult& found, const EstimationOutcome& run) {
  EXPECT_FALSE(found.failure.has_value()) << found.failure->reason;
  EXPECT_EQ(found.log_likelihood, run.result.log_likelihood);
  expect_same(found.innovation, run.result.innovation, "innovation");
  const auto& unknowns = run.augmented_model->options().unknowns;
  const auto likelihood = run.likelihood ? run.likelihood->unknowns.size() : 0;
  ASSERT_EQ(found.parameters.size(), unknowns.size() + likelihood);
  for (std::size_t i = 0; i < unknowns.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    EXPECT_EQ(found.parameters[i].name, unknowns[i].name);
    expect_same(found.parameters[i].mean_history, run.result.unknowns.mean.row(row).transpose(), unknowns[i].name);
    expect_same(found.parameters[i].std_history, run.result.unknowns.deviation.row(row).transpose(),
                unknowns[i].name + " std");
  }
  for (std::size_t i = 0; i < likelihood; ++i) {
    EXPECT_EQ(found.parameters[unknowns.size() + i].mean, run.likelihood->values[static_cast<Eigen::Index>(i)]);
    EXPECT_EQ(found.parameters[unknowns.size() + i].name, run.likelihood->unknowns[i].name);
  }
  for (const auto& point : run.points)
    if (point.quantity == ObservedQuantity::displacement || point.quantity == ObservedQuantity::velocity) {
      const std::string name =
          point.point + (point.quantity == ObservedQuantity::displacement ? ".displacement" : ".velocity");
      // A product of matrices rounds by the place of a row, and the command monitors more of them: the last bits
      // differ.
      EXPECT_LE((found.state(name).mean - point.mean).cwiseAbs().maxCoeff(), 1e-13 * point.mean.cwiseAbs().maxCoeff())
          << name;
    }
}

EstimationOutcome run_of(const std::string& file, const Changes& changes) {
  std::vector<CaseChange> keys;
  for (const auto& [key, value] : changes) keys.push_back({key, value});
  const StudyResults results = run_study(load_study(file, keys), "estimate");
  EXPECT_TRUE(results.has<EstimationOutcome>()) << results.failure;
  return results.get<EstimationOutcome>();
}

class AnalysisOfExample : public testing::TestWithParam<Example> {};

TEST_P(AnalysisOfExample, GivesTheNumbersOfItsRunAndComesBackTheSame) {
  const auto& [file, own_changes, data] = GetParam();
  if (!data.empty() && !fs::exists(data_folder(data))) KALFEM_ABSENT("the record is absent");
  const std::string path = source_folder() + "/examples/" + file;
  const Changes changes = with_short_run(own_changes, path);
  const EstimationOutcome run = run_of(path, changes);
  const Analysis read = read_case(path, {.set = changes});
  expect_same(estimate(read.structure, *read.record, *read.estimate), run);

  if (read.record
          ->used) {  // a free response: the filter learns from its first part, which a case cannot say of a table
    EXPECT_THROW(to_case(read), InvalidInput);
    return;
  }
  const fs::path folder = fs::path(testing::TempDir()) / ("analysis " + std::to_string(std::hash<std::string>{}(file)));
  fs::create_directories(folder);
  const fs::path written = folder / "written.yaml";
  write_case(read, written);
  const Analysis again = read_case(written);
  SCOPED_TRACE(written.string());
  expect_same(again.record->values, read.record->values, "record");
  expect_same(estimate(again.structure, *again.record, *again.estimate), run);
  expect_same(estimate(read.structure, *read.record, *read.estimate), run_of(written.string(), {}));
  EXPECT_TRUE(again.left_out.empty());
  EXPECT_EQ(to_case(again, "written").yaml, to_case(read, "written").yaml);
  fs::remove_all(folder);
}

/// An updating by natural frequencies: of the command, of the library, and both again from what to_case() writes.
void expect_same_updating(const std::string& file) {
  const std::string path = source_folder() + "/examples/" + file;
  const StudyResults run = run_study(load_study(path), "update");
  ASSERT_TRUE(run.has<UpdatingOutcome>()) << run.failure;
  const auto& expected = run.get<UpdatingOutcome>();
  const Analysis read = read_case(path);
  const fs::path folder = fs::path(testing::TempDir()) / ("update " + std::to_string(std::hash<std::string>{}(file)));
  fs::create_directories(folder);
  write_case(read, folder / "written.yaml");
  const Analysis again = read_case(folder / "written.yaml");
  for (const Analysis* each : {&read, &again}) {
    const auto result = update(each->structure, *each->update);
    ASSERT_EQ(std::ssize(result.parameters), expected.values.size());
    for (Eigen::Index i = 0; i < expected.values.size(); ++i) {
      EXPECT_EQ(result.parameters[static_cast<std::size_t>(i)].value, expected.values[i]);
      EXPECT_EQ(result.parameters[static_cast<std::size_t>(i)].std, expected.statistics.deviations[i]);
    }
  }
  fs::remove_all(folder);
}

TEST(AnalysisOfUpdating, ThePlateComesBackTheSame) { expect_same_updating("start/plate/case.yaml"); }

TEST(AnalysisOfUpdating, TheGarteurWingComesBackTheSame) {
  if (!fs::exists(data_folder("garteur"))) KALFEM_ABSENT("the measured frequencies are absent");
  expect_same_updating("garteur/wing.yaml");
}

INSTANTIATE_TEST_SUITE_P(All, AnalysisOfExample, testing::ValuesIn(examples), [](const auto& info) {
  std::string name = info.param.file;
  std::ranges::replace_if(
      name, [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); }, '_');
  return name;
});

}  // namespace
}  // namespace kalfem::test
