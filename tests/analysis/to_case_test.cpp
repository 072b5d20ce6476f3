// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "kalfem/analysis/analysis.hpp"
#include "kalfem/api/simulate.hpp"

// A case of a structure that was built in a program: what it holds, what it cannot hold, and that it comes back.

namespace kalfem::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

Eigen::VectorXd rising_sine(Eigen::Index count, double rate, double size) {
  return Eigen::VectorXd::NullaryExpr(count, [=](Eigen::Index k) {
    const double t = static_cast<double>(k) / rate;
    return size * std::min(t, 1.0) * std::sin(30.0 * t * (1.0 + t));
  });
}

constexpr double rate = 500.0;
constexpr Eigen::Index samples = 501;

/// Two bodies of which one has named directions, a stop, a formula with a state, two grounds and all kinds of inputs.
Structure machine() {
  Structure machine;
  machine.add(
      lumped("base").mass("x", 2.5).spring("k", "ground", "x", 2e4, 12.0).ground("wall").rayleigh_damping(0.1, 1e-5));
  machine.add(chain("arm", 3, 0.7, 1e5).modal_damping({0.01, 0.02}));
  machine.connect("mount", "base.x", "arm.1",
                  expression("k*x + k3*x^3 + c*v", {{"k", 3e4 / 7.0}, {"k3", 1e8}, {"c", 15.0}}));
  machine.connect("stop", "base.wall", "arm.3",
                  law("gap", {{"k_stop", 1e5}, {"gap_upper", 1e-3}, {"k", 100.0}, {"c", 1.0}}));
  machine.base_displacement("road", "base.ground", Samples{rising_sine(samples, rate, 2e-3), rate});
  machine.force("push", "arm.2", Samples{rising_sine(samples, rate, 20.0), rate});
  return machine;
}

Analysis analysis_of_machine() {
  Analysis analysis{.title = "a machine", .structure = machine()};
  auto& options = analysis.estimate.emplace();
  options.sensors = {{"a1", acceleration("arm.1"), 0.05, {{FilterSection{.order = 2, .cutoff = 200.0}}}},
                     {"d3", displacement("arm.3"), 1e-5}};
  analysis.record = simulate(analysis.structure, {.sensors = options.sensors,
                                                  .duration = static_cast<double>(samples - 1) / rate,
                                                  .sample_rate = rate,
                                                  .seed = 3})
                        .record;
  analysis.record->values(0, 40) = std::numeric_limits<double>::quiet_NaN();
  options.unknowns = {
      {"mount.k3", {.initial = 1.3e8, .std = 3e7}},
      {"mount.k", {.initial = 4000.0, .std = 500.0, .transform = ParameterTransform{TransformKind::logit, 1e3, 1e4}}},
      {"arm", {.initial = 9e4, .std = 1e4, .applies_to = {"arm.1-2.stiffness", "arm.2-3.stiffness"}}},
      {"sensors.a1.offset", {.initial = 0.0, .std = 0.01, .random_walk = 1e-3}}};
  options.initial_state = {{"arm.1", {.displacement_std = 1e-6, .velocity_std = 1e-4}}};
  options.process_noise = 1e-4;
  options.substeps = 2;
  options.deviation_stride = 5;  // what a case has at this rate
  options.diagnose = false;
  options.known_to = {{.name = "base.x.mass", .deviation = 0.01}};
  return analysis;
}

/// An empty folder that is gone at the end.
struct Folder {
  fs::path path = fs::path(testing::TempDir()) / "to_case test";
  Folder() { fs::remove_all(path), fs::create_directories(path); }
  ~Folder() { fs::remove_all(path); }
};

TEST(ToCase, AStructureOfAProgramComesBackWithTheSameNumbers) {
  const Analysis analysis = analysis_of_machine();
  const Folder folder;
  write_case(analysis, folder.path / "machine.yaml");
  EXPECT_TRUE(fs::exists(folder.path / "machine.csv"));
  EXPECT_TRUE(fs::exists(folder.path / "machine.road.csv"));
  const Analysis again = read_case(folder.path / "machine.yaml");
  EXPECT_EQ(again.title, "a machine");
  EXPECT_TRUE(again.left_out.empty());
  EXPECT_EQ(again.structure.parameters(), analysis.structure.parameters());
  EXPECT_EQ(again.structure.value("mount.k"), 3e4 / 7.0);
  ASSERT_EQ(again.estimate->known_to.size(), 1u);
  EXPECT_EQ(again.estimate->known_to[0].deviation, 0.01);
  EXPECT_TRUE(again.estimate->known_to[0].relative);
  const auto first = estimate(analysis.structure, *analysis.record, *analysis.estimate);
  const auto second = estimate(again.structure, *again.record, *again.estimate);
  ASSERT_FALSE(first.failure.has_value()) << first.failure->reason;
  EXPECT_EQ(first.log_likelihood, second.log_likelihood);
  ASSERT_EQ(first.parameters.size(), second.parameters.size());
  for (std::size_t i = 0; i < first.parameters.size(); ++i) {
    EXPECT_EQ(first.parameters[i].name, second.parameters[i].name);
    EXPECT_EQ(first.parameters[i].mean, second.parameters[i].mean);
    EXPECT_EQ(first.parameters[i].std, second.parameters[i].std);
  }
}

TEST(ToCase, AReadStructureKeepsItsWordsAndTakesNewValuesAndParts) {
  const Folder folder;
  std::ofstream(folder.path / "read.yaml") << R"(kalfem: 1
substructures:
  body: {chain: {masses: 4, mass: 1 kg, stiffness: 30 kN/m}}
connectors:
  mount: {from: ground, to: body.1, law: linear, parameters: {k: 10 kN/m, c: 5}}
excitation:
  push: {force: body.4, random: {rms: 3 N, band: [1, 40], seed: 4}}
simulate: {duration: 2 s, sample_rate: 200}
sensors:
  a: {acceleration: body.2, noise: 1 %}
report: {zoom: 2 s}
)";
  const Analysis read = read_case(folder.path / "read.yaml");
  EXPECT_THAT(read.left_out, testing::ElementsAre("report"));
  Structure moved = read.structure.at({{"mount.k", 12345.678}, {"body.2-3.stiffness", 2.5e4}});
  moved.add(lumped("rider").mass("m", 0.2))
      .connect("seat", "body.4", "rider.m", law("linear", {{"k", 500.0}, {"c", 1.0}}));
  const CaseText text = to_case({.structure = moved});
  EXPECT_TRUE(text.files.empty());  // a random force needs no samples
  EXPECT_THAT(text.yaml, HasSubstr("duration: 2"));
  std::ofstream(folder.path / "again.yaml") << text.yaml;
  const Structure again = read_case(folder.path / "again.yaml").structure;
  EXPECT_EQ(again.parameters(), moved.parameters());
  EXPECT_EQ(again.value("mount.k"), 12345.678);
  EXPECT_EQ(again.value("body.2-3.stiffness"), 2.5e4);
  EXPECT_EQ(again.value("seat.k"), 500.0);
}

std::string problems_of(const Analysis& analysis) try {
  to_case(analysis);
  return "";
} catch (const InvalidInput& error) {
  std::string all;
  for (const auto& issue : error.issues()) all += to_string(issue) + "\n";
  return all;
}

TEST(ToCase, NamesAllThatACaseCannotSay) {
  Analysis analysis = analysis_of_machine();
  SparseMatrix mass(1, 1);
  mass.insert(0, 0) = 1.0;
  analysis.structure.add(lumped("block", {.dofs = {"1"}, .mass = mass}))
      .connect("own", "block.1", "ground", law("own", {{"k", 1.0}}, [](double x, double, auto p) { return p[0] * x; }))
      .force("live", "block.1");
  analysis.estimate->outputs = {{"tip", displacement("arm.3")}};
  const std::string problems = problems_of(analysis);
  EXPECT_THAT(problems, HasSubstr("substructure 'block' is given by matrices"));
  EXPECT_THAT(problems, HasSubstr("connector 'own' has the law 'own' of a program"));
  EXPECT_THAT(problems, HasSubstr("input 'live' has no signal"));
  EXPECT_THAT(problems, HasSubstr("virtual sensors are asked for: 'tip'"));
}

TEST(ToCase, AFunctionWithTheNameOfALawIsNotThatLaw) {
  Structure structure;
  structure.add(lumped("m").mass("x", 1.0))
      .connect("k", "ground", "m.x",
               law("linear", {{"k", 1.0}, {"c", 1.0}}, [](double x, double, auto p) { return p[0] * x; }));
  EXPECT_THAT(problems_of({.structure = structure}), HasSubstr("connector 'k' has the law 'linear' of a program"));
}

TEST(ReadCase, NamesTheKeysThatOptionsCannotExpress) {
  const Folder folder;
  std::ofstream(folder.path / "read.yaml") << R"(kalfem: 1
substructures:
  body: {chain: {masses: 2, mass: 1 kg, stiffness: 30 kN/m}}
connectors:
  mount: {from: ground, to: body.1, law: linear, parameters: {k: 10 kN/m, c: 5}}
excitation:
  push: {force: body.2, random: {rms: 3 N, band: [1, 40]}, unknown: {std: 3 N}}
simulate: {duration: 1 s, sample_rate: 200}
sensors:
  a: {acceleration: body.2, noise: 1 %}
estimate:
  smooth: true
  alpha: 0.5
  diagnose: false
)";
  try {
    read_case(folder.path / "read.yaml");
    ADD_FAILURE() << "it is read";
  } catch (const InvalidInput& error) {
    std::string all;
    for (const auto& issue : error.issues()) all += to_string(issue) + "\n";
    EXPECT_THAT(all, HasSubstr("estimate.smooth has no word in the options"));
    EXPECT_THAT(all, HasSubstr("estimate.alpha has no word in the options"));
    EXPECT_THAT(all, HasSubstr("excitation.push.unknown has no word in the options"));
    EXPECT_EQ(all.find("estimate.diagnose"), std::string::npos);
    EXPECT_GT(error.issues().front().location.line, 0);
  }
}

}  // namespace
}  // namespace kalfem::test
