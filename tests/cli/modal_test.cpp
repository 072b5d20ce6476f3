// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "command.hpp"
#include "kalfem/formats/measured_file_reader.hpp"
#include "kalfem/formats/tables/csv.hpp"
#include "modal/ambient_record.hpp"

namespace kalfem::test {
namespace {

/// Five minutes of a frame of four equal storeys, as velocities of its floors.
struct ModalCommand : testing::Test {
  ModalCommand() : folder("modal"), file((folder / "ambient.csv").string()) {
    write_csv(file, ambient_record(structure, 64.0, 20000, 1));
  }
  const AmbientStructure structure = shear_frame(4, 20.0, 0.01);
  ScratchFolder folder;
  std::string file;
};

TEST_F(ModalCommand, FindsTheModesAndWritesThem) {
  const auto out = folder / "out";
  const auto outcome = run_command("modal " + file + " --out " + out.string(), folder);
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_NE(outcome.output.find("4 channels, 20000 samples at 64 Hz"), std::string::npos) << outcome.output;
  const auto json = nlohmann::json::parse(read(out / "modes.json"));
  ASSERT_EQ(json["modes"].size(), 4u);
  const auto table = read_csv_table(out / "modes.csv");
  const auto unv = read_measured_file(out / "modes.unv");
  const auto shapes = read_csv_table(out / "shapes.csv");
  ASSERT_EQ(unv.shapes.size(), 4u);
  ASSERT_EQ(shapes.values.rows(), 4);
  ASSERT_EQ(shapes.values.cols(), 4);
  for (std::size_t i = 0; i < 4; ++i) {
    const auto& mode = json["modes"][i];
    const double frequency = mode["frequency_hz"].get<double>(), deviation = mode["frequency_std_hz"].get<double>();
    const auto row = static_cast<Eigen::Index>(i);
    EXPECT_NEAR(frequency, structure.frequencies()[row], 4.0 * deviation);
    EXPECT_LT(deviation, 2e-3 * frequency);
    EXPECT_EQ(table.values(row, 1), frequency);
    EXPECT_EQ(table.values(row, 2), deviation);
    EXPECT_NEAR(unv.shapes[i].frequency, frequency, 1e-4 * frequency);  // six digits
    EXPECT_NEAR(unv.shapes[i].damping, mode["damping"].get<double>(), 1e-5);
    EXPECT_NEAR(unv.shapes[i].values(3, 0).real(), mode["shape"]["v4"]["real"].get<double>(), 1e-5);
    EXPECT_NEAR(std::abs(shapes.values(3, row)), std::abs(unv.shapes[i].values(3, 0)), 0.02);
  }
}

TEST_F(ModalCommand, ShowsTheStabilisationDiagramOnAPage) {
  const auto page = folder / "page.html";
  ASSERT_EQ(run_command("modal " + file + " --page " + page.string(), folder).code, 0);
  const auto html = read(page);
  EXPECT_NE(html.find("Stabilisation diagram"), std::string::npos);
  const auto count = [&](const std::string& words) {
    std::size_t found = 0;
    for (auto at = html.find(words); at != std::string::npos; at = html.find(words, at + 1)) ++found;
    return found;
  };
  EXPECT_EQ(count("<path class=\"line\""), 4u);  // a line at each mode
  EXPECT_GE(count("<circle class=\"mode\""), 4u * 10u);
}

// The table of the modes and that of the shapes as an updating reads them: with all four modes, the springs come back.
TEST_F(ModalCommand, WritesWhatUpdateReads) {
  ASSERT_EQ(run_command("modal " + file + " --out " + folder.path().string(), folder).code, 0);
  std::ofstream(folder / "case.yaml") << R"(kalfem: 1
substructures:
  frame:
    masses: {1: 1 kg, 2: 1 kg, 3: 1 kg, 4: 1 kg}
    springs:
      - {name: s1, from: ground, to: 1, stiffness: 4000}
      - {name: s2, from: 1, to: 2, stiffness: 5000}
      - {name: s3, from: 2, to: 3, stiffness: 4000}
      - {name: s4, from: 3, to: 4, stiffness: 5000}
update:
  parameters: {frame.s1.stiffness: {}, frame.s2.stiffness: {}, frame.s3.stiffness: {}, frame.s4.stiffness: {}}
  compare:
    ambient:
      modes: frame
      frequencies: {file: modes.csv, column: frequency}
      deviation: 0.1 %
      shapes: {file: shapes.csv, points: ["1", "2", "3", "4"], deviation: 0.02}
)";
  const auto outcome =
      run_command("update " + (folder / "case.yaml").string() + " --out " + (folder / "out").string(), folder);
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const double omega = 2.0 * M_PI * 20.0, stiffness = std::pow(0.5 * omega / std::sin(7.0 * M_PI / 18.0), 2);
  for (const auto& [name, spring] : read_summary(folder / "out")["updating"]["parameters"].items())
    EXPECT_NEAR(spring["estimate"].get<double>(), stiffness, 0.03 * stiffness) << name;
}

TEST_F(ModalCommand, ReadsTheRecordOfACase) {
  std::ofstream(folder / "case.yaml") << R"(kalfem: 1
substructures:
  frame:
    masses: {1: 1 kg, 2: 1 kg, 3: 1 kg, 4: 1 kg}
    springs: [{from: ground, to: 1, stiffness: 4500}, {from: 1, to: 2, stiffness: 4500}, {from: 2, to: 3, stiffness: 4500},
              {from: 3, to: 4, stiffness: 4500}]
sensors:
  low: {velocity: frame.2, channel: v2, noise: 5 %}
  top: {velocity: frame.4, channel: v4, noise: 5 %}
record: {file: ambient.csv}
)";
  const auto outcome = run_command("modal --json " + (folder / "case.yaml").string(), folder);
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const auto json = nlohmann::json::parse(outcome.output);
  EXPECT_EQ(json["channels"], (nlohmann::json{"low", "top"}));
  EXPECT_GE(json["modes"].size(), 3u);
}

TEST_F(ModalCommand, TakesThePolesThatAPersonChose) {
  const auto outcome = run_command("modal --json --pole 3.7:20 --pole 20 " + file, folder);
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const auto modes = nlohmann::json::parse(outcome.output)["modes"];
  ASSERT_EQ(modes.size(), 2u);
  EXPECT_EQ(modes[0]["order"], 20);
  EXPECT_NEAR(modes[1]["frequency_hz"].get<double>(), 20.0, 0.1);
}

// Six records of a frame that is .1 % softer per degree, and scatters by .3 % beside.
TEST_F(ModalCommand, FollowsModesOverTemperature) {
  std::string files, table = "temperature [degC]\n";
  const double off[] = {0.003, -0.002, 0.004, -0.004, 0.001, -0.002};
  for (int i = 0; i < 6; ++i) {
    const double temperature = 4.0 * i;
    AmbientStructure then = structure;
    then.omega *= 1.0 - 0.001 * temperature + off[i];
    const auto name = (folder / ("day" + std::to_string(i) + ".csv")).string();
    write_csv(name, ambient_record(then, 64.0, 12000, 10 + static_cast<std::uint64_t>(i)));
    files += name + " ";
    table += std::to_string(temperature) + "\n";
  }
  std::ofstream(folder / "weather.csv") << table;
  const auto out = folder / "tracked";
  const auto outcome = run_command("modal " + files + "--track --covariates " + (folder / "weather.csv").string() +
                                       " --out " + out.string() + " --page " + (out / "page.html").string(),
                                   folder);
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_NE(outcome.output.find("% of f per temperature [degC]"), std::string::npos) << outcome.output;
  const auto json = nlohmann::json::parse(read(out / "tracks.json"));
  ASSERT_EQ(json["tracks"].size(), 4u) << outcome.output;
  for (std::size_t m = 0; m < 4; ++m) {
    const auto& found = json["tracks"][m]["frequency_hz"];
    const double f = structure.frequencies()[static_cast<Eigen::Index>(m)];
    const auto holds = [](const nlohmann::json& told, double x) {
      return told["interval"][0] <= x && x <= told["interval"][1];
    };
    EXPECT_TRUE(holds(found["slopes"][0], -0.001 * f)) << m << found;
    EXPECT_TRUE(holds(found["spread"], 0.003 * f)) << m << found;
    EXPECT_NEAR(found["mean"]["median"], 0.99 * f, 0.01 * f);
    EXPECT_EQ(json["tracks"][m]["records"].size(), 6u);
  }
  EXPECT_EQ(read_csv_table(out / "tracks.csv").values.cols(), 2 + 4 * 4);
  EXPECT_NE(read(out / "page.html").find("Frequencies over the records"), std::string::npos);
}

TEST_F(ModalCommand, RefusesInOneSentenceEach) {
  const auto refuses = [&](const std::string& arguments, const std::string& words) {
    const auto outcome = run_command("modal " + arguments, folder);
    EXPECT_EQ(outcome.code, 2) << arguments;
    EXPECT_NE(outcome.errors.find(words), std::string::npos) << outcome.errors;
    EXPECT_EQ(std::count(outcome.errors.begin(), outcome.errors.end(), '\n'), 1) << outcome.errors;
  };
  refuses(file + " --channel v1", "1 channel is given");
  refuses(file + " --channel v1 --channel v9", "there is no channel 'v9'");
  refuses(file + " --reference v7", "there is no channel 'v7'");
  refuses(file + " --band 3 50", "band: 3 to 50 Hz");
  refuses(file + " --blocks 1", "blocks: 1");
  refuses(file + " --block-rows 2000", "the record has 20000 samples");
  refuses(file + " --covariates " + file, "only --track takes them");
  refuses(file + " --track", "one record given");
  refuses(file + " --pole 3.7@24", "write HZ or HZ:ORDER");
  refuses(file + " --pole 300", "there is no pole at 300 Hz");
  refuses((folder / "none.csv").string(), "there is no such file");
}

}  // namespace
}  // namespace kalfem::test
