// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "base/absent.hpp"
#include "base/places.hpp"
#include "short_case.hpp"

/// What the command prints on a terminal, into a pipe, and of itself.
namespace kalfem::test {
namespace {

/// The output on a terminal that util-linux's `script` plays.
std::string on_terminal(const std::string& arguments, const ScratchFolder& folder, const std::string& environment) {
  const std::string log = (folder / "typescript").string();
  const std::string line =
      environment + " script -qec '" + command_file() + " " + arguments + "' " + log + " >/dev/null 2>&1 </dev/null";
  return WEXITSTATUS(std::system(line.c_str())) == 0 ? read(log) : "";
}

TEST(Terminal, ShowsTheVerdictInColourUnlessTheUserObjects) {
  if (std::system("script -qec true /dev/null >/dev/null 2>&1 </dev/null") != 0)
    KALFEM_ABSENT("`script` is absent, or opens no terminal (is /dev/pts mounted?)");
  const ScratchFolder folder("colour");
  const std::string run = "run " + write_case(folder, "case.yaml", short_case("short"));
  const std::string coloured = on_terminal(run, folder, "env -u NO_COLOR TERM=xterm");
  EXPECT_NE(coloured.find("\x1b[32mVerdict: consistent\x1b[0m"), std::string::npos) << coloured;
  EXPECT_NE(coloured.find("\x1b[1m  parameter"), std::string::npos) << coloured;
  for (const std::string environment : {"NO_COLOR=1 TERM=xterm", "TERM=dumb"}) {
    const std::string plain = on_terminal(run, folder, "env " + environment);
    EXPECT_NE(plain.find("Verdict: consistent"), std::string::npos) << environment;
    EXPECT_EQ(plain.find('\x1b'), std::string::npos) << environment;
  }
  EXPECT_EQ(run_command(run, folder).output.find('\x1b'), std::string::npos);
}

TEST(Terminal, TellsMoreWhenAsked) {
  const ScratchFolder folder("verbose");
  const std::string run = "run " + write_case(folder, "case.yaml", short_case("short"));
  const auto plain = run_command(run, folder), verbose = run_command(run + " --verbose", folder);
  ASSERT_EQ(verbose.code, 0) << verbose.errors;
  for (const std::string words : {"Filters that were tried", "of the last filter pass: predict", "in all"}) {
    EXPECT_EQ(plain.output.find(words), std::string::npos);
    EXPECT_NE(verbose.output.find(words), std::string::npos) << verbose.output;
  }
  EXPECT_EQ(run_command(run + " --verbose --quiet", folder).code, 2);
  EXPECT_EQ(run_command(run + " --verbose --json", folder).code, 2);
}

// Every line of progress states a larger part of the whole job than the one before.
TEST(Terminal, ShowsOneJobIntoAPipe) {
  const ScratchFolder folder("lines");
  std::string text = short_case("long");
  text.replace(text.find("tolerance: 1e-2"), 15, "substeps: 1000");
  text.replace(text.find("duration: 0.5 s"), 15, "duration: 10 s");
  text.replace(text.find("settle: 0.1 s"), 13, "settle: 0.1 s, substeps: 100, diagnose: false");
  const auto outcome = run_command("run " + write_case(folder, "case.yaml", text), folder);
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const std::regex line("(\\d+) %, (?:\\d+ (?:s|min|h) )+left: (simulate|estimate) \\([12] of 2\\)");
  int last = 0, lines = 0;
  for (std::sregex_iterator at(outcome.output.begin(), outcome.output.end(), line), end; at != end; ++at, ++lines) {
    const int percent = std::stoi((*at)[1]);
    EXPECT_GT(percent, last);
    last = percent;
  }
  EXPECT_GE(lines, 1) << outcome.output;
  EXPECT_LE(lines, 10);
}

TEST(Terminal, PrintsItsManualPage) {
  const ScratchFolder folder("manual");
  const auto page = run_command("completion man", folder);
  ASSERT_EQ(page.code, 0) << page.errors;
  EXPECT_TRUE(page.output.starts_with(".TH KALFEM 1 "));
  for (const std::string verb : {"run", "report", "compare", "plot", "modes", "check", "schema"})
    EXPECT_NE(page.output.find(".SS " + verb + "\n"), std::string::npos) << verb;
  EXPECT_NE(page.output.find("\\fB\\-\\-resume\\fR \\fIFOLDER\\fR"), std::string::npos) << page.output;
  EXPECT_NE(page.output.find(".SH EXIT STATUS"), std::string::npos);
}

TEST(Terminal, ChecksACaseWithChanges) {
  const ScratchFolder folder("check-set");
  const std::string check = "check " + write_case(folder, "case.yaml", short_case("short"));
  const auto changed = run_command(check + " --set 'substructures.wheel.masses.w=2.5 kg'", folder);
  EXPECT_EQ(changed.code, 0) << changed.errors;
  EXPECT_NE(changed.output, run_command(check, folder).output);
  const auto wrong = run_command(check + " --set simulate.duration=long", folder);
  EXPECT_EQ(wrong.code, 2);
  EXPECT_NE(wrong.errors.find("set['simulate.duration']"), std::string::npos) << wrong.errors;
}

}  // namespace
}  // namespace kalfem::test
