// SPDX-License-Identifier: Apache-2.0
// The output folder, the standard streams and the disk, as a user meets them.
#include <gtest/gtest.h>

#include <array>
#include <cstdio>

#include "base/places.hpp"
#include "formats/plate_msh.hpp"
#include "kalfem/base/output_folder.hpp"
#include "short_case.hpp"

namespace kalfem::test {
namespace {

namespace fs = std::filesystem;

/// Runs a line of the shell; stdout and stderr come through a pipe, which no limit of file sizes touches.
Outcome through_pipe(const std::string& line) {
  Outcome outcome;
  std::FILE* pipe = popen(("{ " + line + "; } 2>&1").c_str(), "r");
  std::array<char, 4096> part{};
  while (const auto size = std::fread(part.data(), 1, part.size(), pipe)) outcome.output.append(part.data(), size);
  const int status = pclose(pipe);
  outcome.code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return outcome;
}

const std::string command = command_file();

TEST(Output, ARunIntoAFolderInUseIsRefusedAndNamesTheOther) {
  const ScratchFolder folder("in-use");
  const auto file = write_case(folder, "case.yaml", short_case("A"));
  const std::string line = "run " + file + " --out " + (folder / "out").string();
  {
    const OutputFolder held(folder / "out");
    const auto outcome = run_command(line, folder);
    EXPECT_EQ(outcome.code, 2);
    EXPECT_NE(outcome.errors.find("process " + std::to_string(getpid())), std::string::npos) << outcome.errors;
    EXPECT_FALSE(fs::exists(folder / "out" / "summary.json"));
  }
  EXPECT_EQ(run_command(line, folder).code, 0);
}

TEST(Output, OfTwoRunsAtOnceTheResultsAreThoseOfOne) {
  const ScratchFolder folder("two-runs");
  const auto one = write_case(folder, "one.yaml", short_case("A")),
             two = write_case(folder, "two.yaml", short_case("B"));
  const std::string out = " --out " + (folder / "out").string() + " >/dev/null";
  for (int i = 0; i < 3; ++i) {
    const auto outcome = through_pipe(command + " run " + one + out + " & p=$!; " + command + " run " + two + out +
                                      "; b=$?; wait $p; echo codes $? $b");
    const bool known = outcome.output.find("codes 0 0") != std::string::npos ||
                       outcome.output.find("codes 2 0") != std::string::npos ||
                       outcome.output.find("codes 0 2") != std::string::npos;
    EXPECT_TRUE(known) << outcome.output;
    EXPECT_EQ(identity_of(folder / "out").size(), 16U) << identity_of(folder / "out");
    EXPECT_EQ(files_of(folder / "out"), (std::set<std::string>{"case.identified.yaml", "case.resolved.yaml",
                                                               "report.html", "results.h5", "summary.json"}));
  }
}

TEST(Output, TheSameRunAgainHasTheSameIdentityAnotherVerbHasNot) {
  const ScratchFolder folder("identity");
  const auto file = write_case(folder, "case.yaml", short_case("A"));
  std::vector<std::string> identities;
  for (const std::string verb : {"run", "run", "simulate"}) {
    ASSERT_EQ(run_command(verb + " " + file + " --out " + (folder / "out").string(), folder).code, 0);
    identities.push_back(identity_of(folder / "out"));
    EXPECT_EQ(identities.back().size(), 16U) << identities.back();
  }
  EXPECT_EQ(identities[0], identities[1]);
  EXPECT_NE(identities[0], identities[2]);
}

TEST(Output, NothingOfAFormerRunStaysBesideTheNewOne) {
  const ScratchFolder folder("former");
  const auto file = write_case(folder, "case.yaml", short_case("A"));
  const std::string out = (folder / "out").string();
  ASSERT_EQ(run_command("run " + file + " --out " + out, folder).code, 0);
  std::ofstream(folder / "out" / "notes.txt") << "mine";
  std::ofstream(folder / "out" / "update.checkpoint.json") << "of an updating that was killed";
  const auto outcome = run_command("modes " + file + " --out " + out, folder);
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_NE(outcome.output.find("Results in " + out + ": report.html, summary.json, case.resolved.yaml\n"),
            std::string::npos)
      << outcome.output;
  EXPECT_NE(outcome.output.find("earlier run): results.h5, case.identified.yaml"), std::string::npos) << outcome.output;
  EXPECT_EQ(files_of(folder / "out"), (std::set<std::string>{"case.resolved.yaml", "notes.txt", "report.html",
                                                             "summary.json", "update.checkpoint.json"}));
}

const std::string plate_case = R"(kalfem: 1
substructures:
  wheel: {masses: {z: 3 kg}, springs: [{from: ground, to: z, stiffness: 1e5}]}
  plate:
    finite_elements:
      mesh: plate.msh
      materials: {steel: {youngs_modulus: 210 GPa, density: 7850 kg/m^3}}
      regions: {plate: {material: steel, shell: {thickness: 5 mm}}}
      nodes: {f: far}
      fixed: {clamp: {nodes: edge}}
    reduction: {modes: 4, truncation_vectors: false}
connectors:
  mount: {from: wheel.z, to: plate.f.z, law: linear, parameters: {k: 1e4, c: 10}}
)";

TEST(Output, SuperelementsAreThoseOfTheRunAndTimesAddUp) {
  const ScratchFolder folder("superelements");
  std::ofstream(folder / "plate.msh") << plate_msh;
  const std::string out = " --out " + (folder / "out").string();
  const auto with = write_case(folder, "with.yaml", plate_case + "report: {superelements: [op4, matrix_market]}\n");
  const auto without = write_case(folder, "without.yaml", plate_case);
  const auto first = run_command("modes " + with + out, folder);
  ASSERT_EQ(first.code, 0) << first.errors;
  for (const std::string name : {"plate_reduced.op4", "plate_reduced_K.mtx", "plate_reduced.dof", "plate_modes.vtu"}) {
    EXPECT_TRUE(fs::exists(folder / "out" / name)) << name;
    EXPECT_NE(first.output.find(name), std::string::npos) << first.output;
  }
  const auto second = run_command("modes " + without + out, folder);
  ASSERT_EQ(second.code, 0) << second.errors;
  EXPECT_EQ(files_of(folder / "out"),
            (std::set<std::string>{"case.resolved.yaml", "plate_modes.vtu", "report.html", "summary.json"}));
  const auto timing = read_summary(folder / "out")["timing"];
  double parts = 0.0;
  for (const auto& [name, seconds] : timing.items())
    if (name != "total_s" && seconds.is_number()) parts += seconds.get<double>();
  EXPECT_GT(timing["reduce_s"].get<double>(), 0.0);
  EXPECT_GE(timing["total_s"].get<double>(), parts);
}

/// An earlier version did not list its files.
TEST(Output, FilesOfASummaryWithoutAListGoToo) {
  const ScratchFolder folder("unlisted");
  std::ofstream(folder / "plate.msh") << plate_msh;
  const auto out = folder / "out";
  const auto with = write_case(folder, "with.yaml", plate_case + "report: {superelements: [op4]}\n");
  ASSERT_EQ(run_command("modes " + with + " --out " + out.string(), folder).code, 0);
  auto summary = read_summary(out);
  summary.erase("files");
  std::ofstream(out / "summary.json") << summary.dump();
  std::ofstream(out / "other_reduced.op4") << "of a substructure that the former run did not have";
  const auto without = write_case(folder, "without.yaml", plate_case);
  ASSERT_EQ(run_command("modes " + without + " --out " + out.string(), folder).code, 0);
  EXPECT_EQ(files_of(out), (std::set<std::string>{"case.resolved.yaml", "other_reduced.op4", "plate_modes.vtu",
                                                  "report.html", "summary.json"}));
}

TEST(Output, PointsAtRestAreLeftOutAndCaptionsNameTheBand) {
  const ScratchFolder folder("at-rest");
  std::ofstream(folder / "plate.msh") << plate_msh;
  const auto file = write_case(folder, "case.yaml", plate_case + R"(excitation:
  road: {base_displacement: wheel.ground, random: {rms: 1 mm, band: [0.5, 30 Hz], fade_in: 0.05 s}}
sensors: {a: {acceleration: plate.f.z, noise: 5 %}}
simulate: {duration: 0.5 s, sample_rate: 1 kHz, tolerance: 1e-2}
estimate: {unknown: {mount.k: {initial: 11 kN/m, std: 1 kN/m}}, settle: 0.1 s}
predict: {substructure: plate}
)");
  const auto outcome = run_command("run " + file + " --out " + (folder / "out").string(), folder);
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  // The plate bends out of its plane: z, rx, ry.
  const auto points = read_summary(folder / "out")["prediction"]["plate"];
  for (const std::string still : {"f.x", "f.y", "f.rz"})
    EXPECT_TRUE(points[still]["acceleration_nrmse"].is_null()) << still;
  for (const std::string moves : {"f.z", "f.rx", "f.ry"})
    EXPECT_TRUE(points[moves]["acceleration_nrmse"].is_number()) << moves;
  EXPECT_EQ(outcome.output.find("plate.f.x "), std::string::npos) << "a point at rest has no line:\n" << outcome.output;
  EXPECT_NE(outcome.output.find("plate.f.z "), std::string::npos);
  const auto page = read(folder / "out" / "report.html");
  EXPECT_TRUE(std::regex_search(
      page.substr(page.find("<main")),
      std::regex("NRMSE [0-9.]+ % in the band of the excitation, 0.5 to 30 Hz; [0-9.]+ % over the whole signal")));
  EXPECT_EQ(page.find("Acceleration of plate.f.x"), std::string::npos);
}

TEST(Output, ASummaryFromElsewhereRemovesNothingOfTheUser) {
  const ScratchFolder folder("hostile");
  const auto file = write_case(folder, "case.yaml", short_case("A"));
  std::ofstream(folder / "mine.txt") << "mine";
  for (const auto& summary : std::vector<std::string>{
           R"({"files": ["../mine.txt", "notes.txt", "../out/notes.txt", "./notes.txt", 3]})", R"({"files": 3})", "[]",
           R"({"model": [1]})", R"({"model": {"substructures": [1]}})", R"({"model": {"substructures": {"notes": 1}}})",
           "{\"files\": [\"" + std::string(1'000'000, 'a') + "_modes.vtu\"]}", "\xFF", ""}) {
    fs::create_directories(folder / "out");
    std::ofstream(folder / "out" / "notes.txt") << "mine";
    std::ofstream(folder / "out" / "summary.json") << summary;
    const auto outcome = run_command("modes " + file + " --out " + (folder / "out").string(), folder);
    ASSERT_EQ(outcome.code, 0) << summary.substr(0, 100) << outcome.errors;
    EXPECT_EQ(read(folder / "mine.txt"), "mine");
    EXPECT_EQ(read(folder / "out" / "notes.txt"), "mine");
    EXPECT_EQ(identity_of(folder / "out").size(), 16U);
  }
}

/// Limits in blocks of 512 bytes, as POSIX counts them: in the middle of the series, of the page, of the smaller files.
TEST(Output, AFullDiskIsOneMessageAndLeavesTheFormerSet) {
  const ScratchFolder folder("full");
  const std::string out = (folder / "out").string();
  const auto former = write_case(folder, "former.yaml", short_case("A")),
             next = write_case(folder, "next.yaml", short_case("B"));
  ASSERT_EQ(run_command("run " + former + " --out " + out, folder).code, 0);
  const auto files = files_of(out);
  const std::string identity = identity_of(out);
  for (const int blocks : {0, 1, 4, 40, 300, 500}) {
    const auto outcome =
        through_pipe("ulimit -f " + std::to_string(blocks) + "; " + command + " run " + next + " --out " + out);
    EXPECT_EQ(outcome.code, 1) << blocks << outcome.output;
    EXPECT_NE(outcome.output.find("cannot write '" + out + "/"), std::string::npos) << outcome.output;
    EXPECT_NE(outcome.output.find("(ulimit -f)"), std::string::npos) << outcome.output;
    for (const char* piece : {"HDF5-DIAG", "internal error", "Segmentation", "/.kalfem/new"})
      EXPECT_EQ(outcome.output.find(piece), std::string::npos) << outcome.output;
    EXPECT_EQ(files_of(out), files) << blocks;
    EXPECT_EQ(identity_of(out), identity) << blocks;
  }
}

TEST(Output, AnUpdatingOnAFullDiskStopsWithItsLastPlaceKept) {
  const ScratchFolder folder("full-update");
  const auto file = write_case(folder, "case.yaml", R"(kalfem: 1
substructures:
  frame: {masses: {1: 1 kg, 2: 1 kg}, springs: [{name: s1, from: ground, to: 1, stiffness: 1.3 kN/m}, {name: s2, from: 1, to: 2, stiffness: 0.8 kN/m}]}
update:
  parameters: {frame.s1.stiffness: {}, frame.s2.stiffness: {}}
  compare: {modes: {modes: frame, frequencies: [3.1105, 8.1434], deviation: 0.1 %}}
)");
  const std::string line = command + " update " + file + " --out " + (folder / "out").string();
  const auto full = through_pipe("ulimit -f 1; " + line);
  EXPECT_EQ(full.code, 1) << full.output;
  EXPECT_NE(full.output.find("out/update.checkpoint.json'"), std::string::npos) << full.output;
  EXPECT_FALSE(fs::exists(folder / "out"));
  const auto after = through_pipe(line);
  EXPECT_EQ(after.code, 0) << after.output;
  EXPECT_EQ(after.output.find("update.checkpoint.json"), std::string::npos) << after.output;
  EXPECT_EQ(files_of(folder / "out"), (std::set<std::string>{"case.identified.yaml", "case.resolved.yaml",
                                                             "report.html", "results.h5", "summary.json"}));
}

TEST(Output, APlaceThatCannotBeWrittenIsFoundBeforeTheComputation) {
  const ScratchFolder folder("place");
  // A minute of computing, if it came to that.
  std::string text = short_case("A");
  text.replace(text.find("0.5 s, sample"), 5, "5000 s");
  const auto file = write_case(folder, "case.yaml", text);
  fs::create_directories(folder / "out" / "results.h5");
  for (const std::string place : {"/out", "/case.yaml", "/case.yaml/below"}) {
    const auto outcome =
        through_pipe("timeout 20 " + command + " run " + file + " --out " + folder.path().string() + place);
    EXPECT_EQ(outcome.code, 2) << outcome.output;
    EXPECT_EQ(outcome.output.find("internal error"), std::string::npos) << outcome.output;
  }
  for (const std::string stream : {">/dev/full", ">&-"}) {
    const auto outcome =
        through_pipe("timeout 20 " + command + " run " + file + " --out " + (folder / "new").string() + " " + stream);
    EXPECT_EQ(outcome.code, 1) << stream << outcome.output;
    EXPECT_NE(outcome.output.find("standard output"), std::string::npos) << outcome.output;
    EXPECT_FALSE(fs::exists(folder / "new"));
  }
}

TEST(Output, AStandardOutputThatTakesNothingIsNoInternalError) {
  const ScratchFolder folder("stdout");
  const auto file = write_case(folder, "case.yaml", short_case("A"));
  for (const auto& verb :
       std::vector<std::string>{"schema", "schema --json", "schema --laws", "--help", "--version", "check " + file}) {
    for (const std::string stream : {" >/dev/full", " >&-"}) {
      const auto outcome = through_pipe(command + " " + verb + stream);
      EXPECT_EQ(outcome.code, 1) << verb << stream << outcome.output;
      EXPECT_NE(outcome.output.find("cannot write to the standard output"), std::string::npos) << outcome.output;
    }
    EXPECT_EQ(through_pipe("{ " + command + " " + verb + "; echo code $? >&2; } | head -c 1 >/dev/null").output,
              "code 0\n")
        << verb;
  }
  EXPECT_EQ(through_pipe(command + " check " + file + " --page /dev/full").code, 1);
  EXPECT_EQ(through_pipe(command + " check " + file + " --page " + folder.path().string()).code, 2);
}

TEST(Output, AReaderThatLeavesDoesNotEndTheRun) {
  const ScratchFolder folder("pipe");
  const auto file = write_case(folder, "case.yaml", short_case("A"));
  const auto outcome = through_pipe("{ " + command + " run " + file + " --out " + (folder / "out").string() +
                                    "; echo code $? >&2; } | true");
  EXPECT_EQ(outcome.output, "code 0\n");
  EXPECT_EQ(identity_of(folder / "out").size(), 16U);
}

bool holds_control_characters(const std::string& text) {
  return std::ranges::any_of(text, [](unsigned char c) { return (c < 0x20 && c != '\n' && c != '\t') || c == 0x7F; }) ||
         text.find("\xC2\x9B") != std::string::npos;
}

TEST(Output, ControlCharactersReachNeitherTerminalNorFiles) {
  const ScratchFolder folder("escapes");
  const std::string title = R"("\e[31mred\e]0;x\a \x9b2J </script> \u202e")";
  const auto file = write_case(folder, "case.yaml", short_case(title));
  for (const std::string verb : {"run", "check"}) {
    const auto outcome = run_command(verb + " " + file, folder);
    EXPECT_EQ(outcome.code, 0) << outcome.errors;
    EXPECT_FALSE(holds_control_characters(outcome.output)) << outcome.output;
    EXPECT_NE(outcome.output.find(R"(\x1b[31mred)"), std::string::npos) << outcome.output;
  }
  const auto out = folder / "case.kalfem-out";
  EXPECT_EQ(read_summary(out)["title"],
            "\x1b[31mred\x1b]0;x\a \xC2\x9B"
            "2J </script> \xE2\x80\xAE");
  EXPECT_FALSE(holds_control_characters(read(out / "summary.json")));
  EXPECT_FALSE(holds_control_characters(read(out / "case.resolved.yaml")));
  const auto page = read(out / "report.html");
  EXPECT_FALSE(holds_control_characters(page.substr(0, page.find("<style>"))));
  // The resolved case has the same title.
  fs::copy(out / "case.resolved.yaml", folder / "again.yaml");
  ASSERT_EQ(run_command("modes " + (folder / "again.yaml").string(), folder).code, 0);
  EXPECT_EQ(read_summary(folder / "again.kalfem-out")["title"], read_summary(out)["title"]);
}

TEST(Output, MessagesShowControlCharactersOfKeysValuesAndPaths) {
  const ScratchFolder folder("escaped-keys");
  std::string text = short_case("A") + R"("\e[2Jkey": 1
"two\nlines": {"\r": "\e]52;c;x\a"}
)";
  const auto file = write_case(folder, "case.yaml", text);
  const auto outcome = run_command("run " + file, folder);
  EXPECT_EQ(outcome.code, 2);
  EXPECT_FALSE(holds_control_characters(outcome.errors)) << outcome.errors;
  EXPECT_NE(outcome.errors.find(R"(\x1b[2Jkey)"), std::string::npos) << outcome.errors;
  EXPECT_NE(outcome.errors.find(R"(two\nlines)"), std::string::npos) << outcome.errors;
  const auto named = through_pipe(command + " run \"$(printf 'no\\033[31m.yaml')\"");
  EXPECT_EQ(named.code, 2);
  EXPECT_FALSE(holds_control_characters(named.output)) << named.output;
  const auto argument = through_pipe(command + " run x \"$(printf '\\033[31m')\"");
  EXPECT_EQ(argument.code, 2);
  EXPECT_FALSE(holds_control_characters(argument.output)) << argument.output;
}

TEST(Output, TextThatIsNoUtf8IsNamedByLineBeforeAnythingRuns) {
  const ScratchFolder folder("no-utf8");
  for (const std::string bytes :
       {"\xED\xA0\x80", "\xC0\xAF", "\xE0\x80\xAF", "\xF0\x80\x80\xAF", "\xF4\x90\x80\x80", "\xE4", "\xE2\x82"}) {
    const auto outcome = run_command("run " + write_case(folder, "case.yaml", short_case("A" + bytes)), folder);
    EXPECT_EQ(outcome.code, 2) << outcome.errors;
    EXPECT_NE(outcome.errors.find("case.yaml:2"), std::string::npos) << outcome.errors;
    EXPECT_NE(outcome.errors.find("UTF-8"), std::string::npos) << outcome.errors;
  }
}

}  // namespace
}  // namespace kalfem::test
