// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "kalfem/formats/hdf5/hdf5_file.hpp"
#include "short_case.hpp"

namespace kalfem::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

std::vector<std::string> lines_of(const fs::path& file) {
  std::istringstream text(read(file));
  std::vector<std::string> lines;
  for (std::string line; std::getline(text, line);) lines.push_back(line);
  return lines;
}

class SweepCommand : public testing::Test {
protected:
  [[nodiscard]] Outcome sweep(const std::string& arguments, const std::string& folder = "out") const {
    return run_command("sweep " + file_ + " " + arguments + " --out " + (folder_ / folder).string(), folder_);
  }
  [[nodiscard]] Json run_in(const std::string& folder, std::size_t number) const {
    return Json::parse(lines_of(folder_ / folder / "runs.jsonl").at(number + 1));
  }

  ScratchFolder folder_{"sweep"};
  std::string file_ = write_case(folder_, "case.yaml", short_case("swept"));
};

// Seeds change fastest; a run is that of `kalfem run` with the same changes, to the last bit.
TEST_F(SweepCommand, EveryRunIsThatOfTheRunVerb) {
  const auto outcome = sweep("--seeds 2 --grid estimate.process_noise.acceleration=0.01,0.1");
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  ASSERT_EQ(lines_of(folder_ / "out" / "runs.jsonl").size(), 5U);
  EXPECT_EQ(lines_of(folder_ / "out" / "sweep.csv").size(), 5U);
  const Json third = run_in("out", 3);
  EXPECT_EQ(third["values"], Json({"0.1"}));
  EXPECT_EQ(third["seed"], 2);

  const fs::path alone = folder_ / "alone";
  ASSERT_EQ(run_command("run " + file_ + " --set simulate.seed=2 --set estimate.process_noise.acceleration=0.1 --out " +
                            alone.string(),
                        folder_)
                .code,
            0);
  const Json expected = read_summary(alone);
  EXPECT_EQ(third["summary"]["parameters"], expected["parameters"]);
  EXPECT_EQ(third["summary"]["estimation"]["nis"], expected["estimation"]["nis"]);
  EXPECT_NE(run_in("out", 2)["summary"]["parameters"], expected["parameters"]) << "the seed changes the noise";
}

TEST_F(SweepCommand, TheBytesDoNotDependOnTheDistribution) {
  ASSERT_EQ(sweep("--seeds 5 --threads 1", "one").code, 0);
  for (const std::string threads : {"2", "3"}) {
    ASSERT_EQ(sweep("--seeds 5 --threads " + threads, threads).code, 0);
    for (const char* name : {"runs.jsonl", "sweep.csv"})
      EXPECT_EQ(read(folder_ / "one" / name), read(folder_ / threads / name)) << name;
  }
}

// The last line is cut short, as a killed process leaves it; the run before it is missing.
TEST_F(SweepCommand, GoesOnWithWhatIsFinished) {
  ASSERT_EQ(sweep("--seeds 4").code, 0);
  const fs::path log = folder_ / "out" / "runs.jsonl";
  const std::string whole = read(log);
  const auto lines = lines_of(log);
  std::ofstream(log) << lines[0] << "\n" << lines[1] << "\n" << lines[3] << "\n" << lines[4].substr(0, 100);
  const auto outcome = sweep("--seeds 4");
  EXPECT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_NE(outcome.output.find("2 of 4 runs are known"), std::string::npos) << outcome.output;
  EXPECT_EQ(read(log), whole);
}

// A bit that flips in a number leaves a line of JSON, which must not be believed.
TEST_F(SweepCommand, MakesARunAgainWhoseLineIsDamaged) {
  ASSERT_EQ(sweep("--seeds 3").code, 0);
  const fs::path log = folder_ / "out" / "runs.jsonl";
  const std::string whole = read(log);
  std::string damaged = whole;
  const std::size_t digit = damaged.find_first_of("123456789", damaged.find("\"estimate\":"));
  ASSERT_NE(digit, std::string::npos);
  damaged[digit] = static_cast<char>(damaged[digit] ^ 1);
  std::ofstream(log) << damaged;
  const auto outcome = sweep("--seeds 3");
  EXPECT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_NE(outcome.output.find("2 of 3 runs are known"), std::string::npos) << outcome.output;
  EXPECT_NE(outcome.errors.find("runs.jsonl:2: the line is not what was written"), std::string::npos) << outcome.errors;
  EXPECT_EQ(read(log), whole);
}

TEST_F(SweepCommand, AnotherSweepBeginsAgain) {
  ASSERT_EQ(sweep("--seeds 2").code, 0);
  const auto outcome = sweep("--seeds 2 --set simulate.duration=0.6s");
  EXPECT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_EQ(outcome.output.find("are known"), std::string::npos) << outcome.output;
}

TEST_F(SweepCommand, OneCombinationThatCannotRunSaysSo) {
  const auto outcome = sweep("--grid simulate.duration=0.5s,-1s,0.6s");
  EXPECT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_NE(outcome.errors.find("run 2: set['simulate.duration']"), std::string::npos) << outcome.errors;
  EXPECT_FALSE(run_in("out", 1).contains("summary"));
  EXPECT_EQ(Json::parse(lines_of(folder_ / "out" / "runs.jsonl")[3])["summary"]["status"], "ok");
}

TEST_F(SweepCommand, ArraysHoldWhatTheTableHolds) {
  ASSERT_EQ(sweep("--seeds 3 --grid simulate.duration=0.5s,0.6s").code, 0);
  const auto file = Hdf5File::open((folder_ / "out" / "sweep.h5").string());
  EXPECT_EQ(file.read("/seed"), (Eigen::VectorXd(6) << 1, 2, 3, 1, 2, 3).finished());
  EXPECT_EQ(file.read_strings("/axes/simulate.duration")[5], "0.6s");
  const Json parameters = run_in("out", 4)["summary"]["parameters"];
  for (const auto& [name, parameter] : parameters.items())
    EXPECT_EQ(file.read("/parameters/" + name + "/estimate")[4], parameter["estimate"].get<double>()) << name;
}

TEST_F(SweepCommand, RefusesWhatIsNoSweep) {
  const auto expect = [&](const std::string& arguments, const std::string& words) {
    const auto outcome = sweep(arguments, "refused");
    EXPECT_EQ(outcome.code, 2) << arguments;
    EXPECT_NE(outcome.errors.find(words), std::string::npos) << outcome.errors;
    EXPECT_FALSE(fs::exists(folder_ / "refused" / "runs.jsonl"));
  };
  expect("--grid simulate.duration", "it is no KEY=VALUE,VALUE,...");
  expect("--grid simulate.seed=1,2 --grid simulate.seed=3", "gives 'simulate.seed' twice");
  expect("--grid simulate.duration=1s --set simulate.duration=2s", "gives 'simulate.duration' twice");
  expect("--grid simulate.duraton=1s,2s", "duraton");
  for (const char* wrong : {"--seeds 0", "--seeds -3", "--seeds many", "--threads 0", "--threads -1"})
    expect(wrong, std::string(wrong).substr(0, std::string(wrong).find(' ')));
}

}  // namespace
}  // namespace kalfem::test
