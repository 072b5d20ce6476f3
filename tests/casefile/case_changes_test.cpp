// SPDX-License-Identifier: Apache-2.0
#include "kalfem/yaml/case_changes.hpp"

#include <gtest/gtest.h>

#include "base/scratch_folder.hpp"
#include "kalfem/base/atomic_file.hpp"
#include "kalfem/formats/hdf5/hdf5_file.hpp"
#include "kalfem/report/run_case.hpp"
#include "kalfem/yaml/case_reader.hpp"

namespace kalfem {
namespace {

std::string after(const std::string& text, const std::vector<CaseChange>& changes) {
  IssueList issues;
  return to_yaml(*changed(parse_yaml(text, "case.yaml", process_environment(), issues), changes));
}

std::string refusal(const std::string& text, const std::vector<CaseChange>& changes) {
  try {
    after(text, changes);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

TEST(CaseChanges, ReplaceAddAndRemoveKeys) {
  const std::string text = "simulate:\n  duration: 20 s\n  seed: 1\n";
  EXPECT_EQ(after(text, {{"simulate.duration", "4 s"}}), "simulate:\n  duration: 4 s\n  seed: 1\n");
  EXPECT_EQ(after(text, {{"simulate.tolerance", "1e-4"}}),
            "simulate:\n  duration: 20 s\n  seed: 1\n  tolerance: 1e-4\n");
  EXPECT_EQ(after(text, {{"simulate.seed", std::nullopt}}), "simulate:\n  duration: 20 s\n");
  EXPECT_EQ(after(text, {{"report.displacements", "[body.3, body.4]"}}),
            text + "report:\n  displacements: [body.3, body.4]\n");
}

TEST(CaseChanges, FindKeysWithDotsAndItemsOfLists) {
  const std::string text = "unknown:\n  mount.k:\n    initial: 1\nsprings:\n  - name: k_w\n    stiffness: 2\n";
  EXPECT_NE(after(text, {{"unknown.mount.k.initial", "3"}}).find("initial: 3"), std::string::npos);
  EXPECT_NE(after(text, {{"springs.k_w.stiffness", "4"}}).find("stiffness: 4"), std::string::npos);
  EXPECT_NE(after(text, {{"springs.0.stiffness", "5"}}).find("stiffness: 5"), std::string::npos);
}

TEST(CaseChanges, NameTheChangeThatDoesNotFit) {
  const std::string text = "a: 1\nb:\n  - name: c\n";
  const std::string words = refusal(text, {{"a.x", "1"}, {"b.d", "1"}, {"e", std::nullopt}, {"a", "[1, 2"}});
  EXPECT_NE(words.find("set['a.x']: there is no key 'x' in '1'"), std::string::npos) << words;
  EXPECT_NE(words.find("set['b.d']: the list has no item 'd'"), std::string::npos) << words;
  EXPECT_NE(words.find("set['e']: there is no such key"), std::string::npos) << words;
  EXPECT_NE(words.find("set['a']: this is not YAML"), std::string::npos) << words;
}

constexpr const char* small_case = R"(
kalfem: 1
substructures: {m: {masses: {a: 2 kg}, springs: [{name: k, from: ground, to: a, stiffness: 3 kN/m, damping: 4 N s/m}]}}
excitation: {f: {force: m.a, random: {rms: 5 N, band: [0.5, 20 Hz]}}}
sensors: {y: {acceleration: m.a, noise: 2 %}, x: {displacement: m.a, noise: 2 %}}
simulate: {duration: 2 s, sample_rate: 200 Hz}
estimate: {unknown: {m.k.stiffness: {initial: 2500, std: 20 %}}, settle: 0.5 s}
)";

TEST(CaseRun, GivesInMemoryWhatItWritesIntoFiles) {
  const ScratchFolder folder("case_changes");
  write_file_atomically(folder / "case.yaml", small_case);
  const CaseRun written(folder / "case.yaml", {.folder = folder / "out", .set = {{"simulate.duration", "1 s"}}});
  const CaseRun kept(folder / "case.yaml", {.set = {{"simulate.duration", "1 s"}}});
  EXPECT_TRUE(kept.result().files.empty());
  EXPECT_EQ(read_text_file((folder / "out/summary.json").string()), written.summary());
  const auto file = Hdf5File::open((folder / "out/results.h5").string());
  std::size_t count = 0;
  kept.visit([&](const CaseSeries& series) {
    ++count;
    const Eigen::VectorXd expected = file.read(series.path);
    ASSERT_EQ(series.values.size(), expected.size()) << series.path;
    EXPECT_TRUE(((series.values.array() == expected.array()) || series.values.array().isNaN()).all()) << series.path;
    EXPECT_EQ(file.text_attribute(series.path, "unit"), series.unit);
  });
  EXPECT_EQ(file.datasets().size(), count);
  EXPECT_EQ(file.read("/time").size(), 201);
  const auto [covariances, sensors] = kept.innovation_covariance();
  ASSERT_EQ(sensors, 2);
  const Eigen::VectorXd deviation = file.read("/innovation/deviation/x");
  EXPECT_TRUE(covariances.row(2).cwiseSqrt().isApprox(deviation.transpose(), 1e-15));
}

TEST(CaseRun, StopsAfterTheStepThatIsAskedFor) {
  const ScratchFolder folder("case_changes");
  write_file_atomically(folder / "case.yaml", small_case);
  const CaseRun run(folder / "case.yaml", {.last_step = "simulate"});
  run.visit([](const CaseSeries& series) { EXPECT_FALSE(series.path.starts_with("/estimate")) << series.path; });
  try {
    CaseRun(folder / "case.yaml", {.set = {{"simulate.duration", "4 kg"}, {"simulate.durations", "1"}}});
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("set['simulate.duration']: simulate.duration: "), std::string::npos)
        << error.what();
    EXPECT_EQ(error.issues().size(), 2U);
  }
}

}  // namespace
}  // namespace kalfem
