// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "casefile/probes.hpp"
#include "kalfem/report/result_set.hpp"
#include "kalfem/steps/run_study.hpp"
#include "kalfem/steps/updating/checkpoint.hpp"

/// The file in which an updating keeps its place.
namespace kalfem::wiring {
namespace {

using Json = nlohmann::json;

class Checkpoint : public testing::Test {
protected:
  ScratchFolder folder{"checkpoint"};
  std::filesystem::path file = folder / "update.checkpoint.json";
  UpdatingCheckpoint checkpoint{folder, "this case", 2};

  /// No two numbers alike, so that no two fields can be exchanged.
  static UpdatingCheckpoint::Content content() {
    GaussNewtonState state;
    state.parameters = vector({1.0 / 3.0, -2e-7});
    state.radius = 0.37;
    state.known = GaussNewtonState::Known::derivatives;
    state.residual_cost = 12.5 + 1e-15;
    state.jacobian_factor = Eigen::Matrix2d{{3.0, 0.1}, {0.0, 7.0 / 9.0}};
    state.projected_residual = vector({0.25, -11.0});
    state.factored_at = vector({0.3, -3e-7});
    state.second_order = Eigen::Matrix2d{{1.5, -0.2}, {-0.2, 4.0 / 7.0}};
    state.with_second_order = true;
    state.evaluations = 9;
    state.iterations = 5;
    state.without_response = 3;
    state.refused = 2;
    return {state,
            {{true, vector({1, 2}), vector({3, 4}), 0.5, 6.25}, {false, vector({5, 6}), vector({7, 8}), 0.75, 8.5}}};
  }

  [[nodiscard]] Json written() const {
    checkpoint.write(content());
    return Json::parse(std::ifstream(file));
  }

  /// Whether the file is still taken after a change of it.
  template <class Change>
  [[nodiscard]] bool taken_after(const Change& change) const {
    Json json = written();
    change(json);
    std::ofstream(file) << json.dump();
    return checkpoint.read().has_value();
  }
};

TEST_F(Checkpoint, ReadsBackEveryFieldToTheLastBit) {
  checkpoint.write(content());
  const auto found = checkpoint.read();
  ASSERT_TRUE(found);
  const auto expected = content();
  const auto& [a, b] = std::pair(found->state, expected.state);
  EXPECT_EQ(a.parameters, b.parameters);
  EXPECT_EQ(a.radius, b.radius);
  EXPECT_EQ(a.known, b.known);
  EXPECT_EQ(a.residual_cost, b.residual_cost);
  EXPECT_EQ(a.jacobian_factor, b.jacobian_factor);
  EXPECT_EQ(a.projected_residual, b.projected_residual);
  EXPECT_EQ(a.factored_at, b.factored_at);
  EXPECT_EQ(a.second_order, b.second_order);
  EXPECT_EQ(a.with_second_order, b.with_second_order);
  EXPECT_EQ(a.evaluations, b.evaluations);
  EXPECT_EQ(a.iterations, b.iterations);
  EXPECT_EQ(a.without_response, b.without_response);
  EXPECT_EQ(a.refused, b.refused);
  ASSERT_EQ(found->trace.size(), expected.trace.size());
  for (std::size_t i = 0; i < expected.trace.size(); ++i) {
    EXPECT_EQ(found->trace[i].accepted, expected.trace[i].accepted);
    EXPECT_EQ(found->trace[i].tried, expected.trace[i].tried);
    EXPECT_EQ(found->trace[i].parameters, expected.trace[i].parameters);
    EXPECT_EQ(found->trace[i].residual, expected.trace[i].residual);
    EXPECT_EQ(found->trace[i].seconds, expected.trace[i].seconds);
  }
}

TEST_F(Checkpoint, OfEveryStateOfTheSearchIsTaken) {
  for (const auto known :
       {GaussNewtonState::Known::nothing, GaussNewtonState::Known::cost, GaussNewtonState::Known::derivatives,
        GaussNewtonState::Known::no_response, GaussNewtonState::Known::no_derivatives}) {
    auto each = content();
    each.state.known = known;
    if (known != GaussNewtonState::Known::derivatives) {
      each.state.jacobian_factor.resize(0, 0);
      each.state.projected_residual.resize(0);
      each.state.factored_at.resize(0);
    }
    checkpoint.write(each);
    const auto found = checkpoint.read();
    ASSERT_TRUE(found) << int(known);
    EXPECT_EQ(found->state.known, known);
  }
}

TEST_F(Checkpoint, OfAnotherCaseIsNotTaken) {
  checkpoint.write(content());
  EXPECT_TRUE(checkpoint.read());
  EXPECT_FALSE(UpdatingCheckpoint(folder, "another case", 2).read());
  EXPECT_FALSE(UpdatingCheckpoint(folder, "this case", 3).read());
  EXPECT_FALSE(UpdatingCheckpoint("", "this case", 2).read());
  std::filesystem::remove(file);
  EXPECT_FALSE(checkpoint.read());
}

TEST_F(Checkpoint, OfWrongSizesOrValuesIsNotTaken) {
  EXPECT_TRUE(taken_after([](Json&) {}));
  const Json three{{"rows", 3}, {"values", {1.0, 2.0, 3.0}}}, wide{{"rows", 1}, {"values", {1.0, 2.0}}};
  EXPECT_FALSE(taken_after([&](Json& json) { json["state"]["parameters"] = three; }));
  EXPECT_FALSE(taken_after([&](Json& json) { json["state"]["projected_residual"] = three; }));
  EXPECT_FALSE(taken_after([&](Json& json) { json["state"]["jacobian_factor"] = three; }));
  EXPECT_FALSE(taken_after([&](Json& json) { json["state"]["factored_at"] = three; }));
  EXPECT_FALSE(taken_after([&](Json& json) { json["state"]["second_order"] = three; }));
  EXPECT_FALSE(taken_after([&](Json& json) { json["state"]["jacobian_factor"] = wide; }));
  for (const int columns : {1, 3}) {
    const Json of_two{{"rows", 2}, {"values", std::vector<double>(std::size_t(2 * columns), 1.0)}};
    EXPECT_FALSE(taken_after([&](Json& json) { json["state"]["jacobian_factor"] = of_two; })) << columns;
  }
  EXPECT_FALSE(taken_after([&](Json& json) { json["state"]["parameters"]["rows"] = -2; }));
  EXPECT_FALSE(taken_after([&](Json& json) { json["state"]["parameters"]["rows"] = 0; }));
  for (const char* field : {"tried", "parameters"})
    EXPECT_FALSE(taken_after([&](Json& json) { json["trace"][1][field] = three; })) << field;
  EXPECT_FALSE(taken_after([](Json& json) { json["state"]["radius"] = 0.0; }));
  EXPECT_FALSE(taken_after([](Json& json) { json["state"]["radius"] = nullptr; }));  // infinite
  EXPECT_FALSE(taken_after([](Json& json) { json["state"]["residual_cost"] = -1.0; }));
  for (const int known : {-1, 5, 99})
    EXPECT_FALSE(taken_after([&](Json& json) { json["state"]["known"] = known; })) << known;
  for (const char* count : {"evaluations", "iterations", "without_response", "refused"})
    EXPECT_FALSE(taken_after([&](Json& json) { json["state"][count] = -1; })) << count;
  const Json state = written()["state"];
  EXPECT_GT(state.size(), 5u);
  for (const auto& [key, value] : state.items())
    EXPECT_FALSE(taken_after([&key = key](Json& json) { json["state"].erase(key); })) << "without " << key;
  EXPECT_FALSE(taken_after([](Json& json) { json.erase("trace"); }));
}

TEST_F(Checkpoint, ThatIsCutOffIsNotTaken) {
  const std::string whole = written().dump();
  for (std::size_t length = 0; length < whole.size(); length += 7) {
    std::ofstream(file) << whole.substr(0, length);
    EXPECT_FALSE(checkpoint.read()) << length;
  }
}

/// Everything that the course of the updating depends on.
TEST(CheckpointFingerprint, IsOfTheWholeCaseAndItsFirstResidual) {
  const auto fingerprint = [](const Sections& changed, double residual = 1.5) {
    return fingerprint_of(study_of(estimated_case(changed)), residual);
  };
  const std::string base = fingerprint({});
  EXPECT_EQ(fingerprint({}), base);
  EXPECT_NE(fingerprint({}, std::nextafter(1.5, 2.0)), base);
  EXPECT_NE(fingerprint({{"sensors", "{y: {displacement: s.b, noise: 0.2 mm}}"}}), base);
  EXPECT_NE(fingerprint({{"estimate", "{unknown: {c.k: {initial: 400 N/m, std: 100 N/m}}, settle: 0.2 s}"}}), base);
}

/// A search goes on where an earlier one was stopped, with its trace, and ends at the same place by the same steps.
TEST(ResumedUpdating, EndsAtTheSameBits) {
  const ScratchFolder folder("resumed");
  const auto study = study_of(lumped_case(
      {{"substructures",
        "{s: {masses: {a: 2, b: 3}, springs: [{name: k, from: ground, to: a, stiffness: 800}, {name: m, from: "
        "a, to: b, stiffness: 500}]}}"},
       {"connectors", ""},
       {"excitation", ""},
       {"sensors", ""},
       {"simulate", ""},
       {"update",
        "{parameters: {s.k.stiffness: {initial: 500}, s.m.stiffness: {initial: 900}}, compare: {f: {modes: s, "
        "frequencies: [1.55, 4.2]}}}"}}));
  const auto whole = run(study, "update").get<UpdatingOutcome>();
  ASSERT_GT(whole.evaluations, 4);
  struct Stopped {};
  RunOptions options;
  options.folder = folder;
  options.on_updating_step = [](int number, const UpdatingStep&) {
    if (number == 3) throw Stopped();
  };
  EXPECT_THROW(run_study(study, "update", options), Stopped);
  ASSERT_TRUE(std::filesystem::exists(folder / "update.checkpoint.json"));
  options.on_updating_step = {};
  const auto results = run_study(study, "update", options);
  const auto& resumed = results.get<UpdatingOutcome>();
  EXPECT_EQ(resumed.resumed_at, 2);  // the third was not written yet
  EXPECT_EQ(resumed.values, whole.values);
  EXPECT_EQ(resumed.evaluations, whole.evaluations);
  EXPECT_EQ(resumed.iterations, whole.iterations);
  ASSERT_EQ(resumed.trace.size(), whole.trace.size());
  for (std::size_t i = 0; i < whole.trace.size(); ++i) {
    EXPECT_EQ(resumed.trace[i].tried, whole.trace[i].tried) << i;
    EXPECT_EQ(resumed.trace[i].parameters, whole.trace[i].parameters) << i;
    EXPECT_EQ(resumed.trace[i].residual, whole.trace[i].residual) << i;
    EXPECT_EQ(resumed.trace[i].accepted, whole.trace[i].accepted) << i;
  }
  // What comes behind the updating may still fail: it goes when the results stand in the folder.
  EXPECT_TRUE(std::filesystem::exists(folder / "update.checkpoint.json"));
  OutputFolder results_folder(folder);
  write_result_set(results_folder, study, results, Stopwatch());
  EXPECT_TRUE(std::filesystem::exists(folder / "summary.json"));
  EXPECT_FALSE(std::filesystem::exists(folder / "update.checkpoint.json"));
}

}  // namespace
}  // namespace kalfem::wiring
