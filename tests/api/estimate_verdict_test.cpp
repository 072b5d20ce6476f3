// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include "base/scratch_folder.hpp"
#include "chain.hpp"
#include "diagnosis/case_family.hpp"
#include "kalfem/report/result_set.hpp"
#include "kalfem/report/run_case.hpp"
#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/steps/run_study.hpp"

// Whether the numbers of an estimation can be trusted: the library says the same as the command does of the same
// record.

namespace kalfem::test {
namespace {

std::vector<std::string> codes_of(const Verdict& verdict) {
  std::vector<std::string> codes;
  for (const auto& reason : verdict.reasons()) codes.push_back(reason.code + " " + reason.subject);
  return codes;
}

/// The case of a measured chain.
std::filesystem::path case_of_chain(double sign_of_a7, const std::filesystem::path& folder) {
  CaseFamily family = chain_family();
  family.duration = 2.0;
  family.noise = 0.05;
  auto measured = measure(family, {}, 1, folder);
  measured.sensors.values.row(2) *= sign_of_a7;
  return write_case(family, measured, {}, folder);
}

/// The chain, its record and what drives it as the command reads them, and what the command says.
struct Command {
  Study study;
  StudyResults results;
  nlohmann::ordered_json summary;

  explicit Command(double sign_of_a7) : study(study_of_chain(sign_of_a7)), results(run_study(study, "estimate")) {
    summary = summarise(study, results);
  }

private:
  static Study study_of_chain(double sign_of_a7) {
    const ScratchFolder folder("api-verdict");
    return load_study(case_of_chain(sign_of_a7, folder).string());
  }
};

/// The same with a7 of the wrong sign.
const Command& with_wrong_sign() {
  static const Command command(-1.0);
  return command;
}

/// The same structure and record in the library's words.
EstimateResult estimate_of(const Study& study, bool diagnose = true) {
  Structure s;
  s.add(lumped("wheel").mass("w", 1.5).spring("k_w", "ground", "w", 2e4));
  s.add(chain("body", 10, 1.0, 3e4).modal_damping(0.01));
  s.connect("suspension", "wheel.w", "body.1", suspension_law(20.0));
  s.base_displacement("road", "wheel.ground", study.structure->signals[0]);
  const Record& record = study.record->record;
  std::vector<SensorDescription> sensors;
  for (const auto& [name, point] :
       {std::pair{"a3", "body.2"}, {"a5", "body.4"}, {"a7", "body.6"}, {"a11", "body.10"}}) {
    const auto channel = static_cast<std::size_t>(record.find(name));
    sensors.push_back({name, acceleration(point), record.channels[channel].noise});
  }
  return estimate(s, record,
                  {.sensors = sensors,
                   .unknowns = {{"suspension.mu_k1", {.initial = 15.0, .std = 7.5}},
                                {"suspension.mu_c1", {.initial = 13.0, .std = 6.5}}},
                   .settle = 1.0,
                   .diagnose = diagnose,
                   .second_thoughts = std::numeric_limits<double>::infinity()});
}

void expect_same_numbers(const EstimateResult& found, const nlohmann::ordered_json& summary) {
  const auto near = [](double value, const nlohmann::ordered_json& expected) {
    EXPECT_NEAR(value, expected.get<double>(), 1e-9 * std::abs(value) + 1e-12);
  };
  for (const auto& parameter : found.parameters) {
    const auto& expected = summary["parameters"][parameter.name];
    near(parameter.mean, expected["estimate"]);
    near(parameter.std, expected["std"]);
    near(parameter.std_robust, expected["std_robust"]);
    near(parameter.interval_95.lower, expected["interval_95"][0]);
    near(parameter.interval_95.upper, expected["interval_95"][1]);
  }
  for (const auto& sensor : found.sensors) {
    const auto& expected = summary["estimation"]["innovations"][sensor.sensor];
    near(sensor.rms, expected["rms_over_expected"]);
    near(sensor.largest_part, expected["largest_part"]);
    near(sensor.correlation, expected["correlation"]);
    near(sensor.beyond_half_gate, expected["beyond_half_gate"]);
  }
}

TEST(EstimateVerdict, IsThatOfTheCommandWhereAllIsRight) {
  const Command command(1.0);
  const auto result = estimate_of(command.study);
  EXPECT_EQ(result.verdict.state(), VerdictState::consistent) << testing::PrintToString(codes_of(result.verdict));
  EXPECT_EQ(command.results.verdict.state(), VerdictState::consistent);
  EXPECT_TRUE(result.usable());
  EXPECT_FALSE(result.diagnosis);
  EXPECT_EQ(result.parameters.size(), 2);
  EXPECT_EQ(result.sensors.size(), 4);
  expect_same_numbers(result, command.summary);
  for (const auto& parameter : result.parameters) EXPECT_NEAR(parameter.std_robust / parameter.std, 1.0, 0.5);
}

TEST(EstimateVerdict, NamesASensorOfTheWrongSignAsTheCommandDoes) {
  const Command& command = with_wrong_sign();
  const auto result = estimate_of(command.study);
  EXPECT_EQ(result.verdict.state(), VerdictState::unusable);
  EXPECT_FALSE(result.usable());
  EXPECT_FALSE(result.failure);
  EXPECT_EQ(codes_of(result.verdict).front(), "sensor_sign a7");
  EXPECT_EQ(codes_of(result.verdict), codes_of(command.results.verdict));
  const auto reasons = result.verdict.reasons(), expected = command.results.verdict.reasons();
  EXPECT_EQ(reasons.front().text, expected.front().text);
  EXPECT_EQ(reasons.front().remedy, expected.front().remedy);
  expect_same_numbers(result, command.summary);
  // Every mistake that was tested, best first.
  const auto& tested = command.results.get<EstimationOutcome>().diagnosis->tested;
  ASSERT_EQ(result.diagnosis->tested.size(), tested.size());
  for (std::size_t i = 0; i < tested.size(); ++i) EXPECT_EQ(result.diagnosis->tested[i].code, tested[i].code);
  EXPECT_EQ(result.diagnosis->cause()->subject, "a7");
}

TEST(EstimateVerdict, HasTheSymptomsOnlyWhereNoCauseIsLookedFor) {
  const auto result = estimate_of(with_wrong_sign().study, false);
  EXPECT_FALSE(result.diagnosis);
  EXPECT_EQ(result.verdict.state(), VerdictState::unusable);
  EXPECT_THAT(codes_of(result.verdict), testing::Contains("innovation_large a7"));
  EXPECT_THAT(codes_of(result.verdict), testing::Not(testing::Contains("sensor_sign a7")));
}

/// A parameter that may drift has no constant value whose scores could be summed up.
TEST(EstimateVerdict, AParameterWithARandomWalkHasNoRobustDeviation) {
  const auto result = estimate(driven_chain(), chain_record(),
                               {.sensors = chain_sensors(),
                                .unknowns = {{"suspension.mu_k1", {.initial = 15, .std = 5, .random_walk = 0.1}}},
                                .substeps = 4,
                                .diagnose = false});
  const auto& parameter = result.parameters[0];
  EXPECT_TRUE(std::isnan(parameter.std_robust));
  EXPECT_NEAR(parameter.interval_95.upper - parameter.mean, 1.96 * parameter.std, 1e-3 * parameter.std);
}

EstimateOptions options_of_chain() {
  return {.sensors = chain_sensors(),
          .unknowns = {{"suspension.mu_k1", {.initial = 15, .std = 5}}},
          .substeps = 4,
          .diagnose = false};
}

TEST(EstimateVerdict, IsNeverConsistentOfFewerThanFiftyValues) {
  Record record = chain_record();
  const auto sensors = static_cast<Eigen::Index>(chain_sensors().size());
  for (const Eigen::Index values : {Eigen::Index{40}, Eigen::Index{60}}) {
    record.values = chain_record().values.leftCols((values + sensors - 1) / sensors).eval();
    const auto result = estimate(driven_chain(), record, options_of_chain());
    const auto codes = codes_of(result.verdict);
    const bool told = std::ranges::find(codes, "record_too_short ") != codes.end();
    EXPECT_EQ(told, values < 50);
    if (told) EXPECT_NE(result.verdict.state(), VerdictState::consistent);
  }
}

/// The case file's rule: at once from a known start, otherwise after a tenth of the record at the latest.
TEST(EstimateVerdict, RestsOnEverySampleOfAKnownStart) {
  Record record = chain_record();
  EXPECT_EQ(estimate(driven_chain(), record, options_of_chain()).settled, 0);
  EstimateOptions stated = options_of_chain();
  stated.settle = 0.1;
  EXPECT_EQ(estimate(driven_chain(), record, stated).settled, std::llround(0.1 * record.sample_rate));
  record.start = 1.0;  // what came before is not known
  const auto moving = estimate(driven_chain(), record, options_of_chain()).settled;
  EXPECT_GT(moving, 0);
  EXPECT_LE(moving, record.samples() / 10 + 1);
}

TEST(EstimateVerdict, AnOnlineFilterHasNoTimeToSettle) {
  const auto refused = refusal_of(
      [] { return OnlineFilter(driven_chain(), 500.0, {.sensors = chain_sensors(), .settle = 1.0}).time(); });
  EXPECT_THAT(refused, testing::HasSubstr("settle needs a whole record"));
}

TEST(CaseVerdict, IsInTheResultOfACaseThatAProgramRuns) {
  const ScratchFolder folder("case-verdict");
  const auto result = run_case(case_of_chain(-1.0, folder), folder / "results");
  EXPECT_FALSE(result.usable());
  EXPECT_EQ(result.verdict.state(), VerdictState::unusable);
  EXPECT_EQ(codes_of(result.verdict), codes_of(with_wrong_sign().results.verdict));
  EXPECT_EQ(result.estimated.at(0).std_robust, with_wrong_sign().results.get<EstimationOutcome>().robust_deviation[0]);
}

}  // namespace
}  // namespace kalfem::test
