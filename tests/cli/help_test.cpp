// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <sstream>

#include "base/places.hpp"
#include "command.hpp"

namespace kalfem::test {
namespace {

struct Help : testing::Test {
  const ScratchFolder folder{"help"};

  std::string printed(const std::string& arguments) {
    const auto outcome = run_command(arguments, folder);
    EXPECT_EQ(outcome.code, 0) << arguments << ": " << outcome.errors;
    return outcome.output;
  }

  /// As the completion of bash lists them.
  std::vector<std::string> verbs() {
    const std::string script = printed("completion bash");
    const auto begin = script.find("words=\"run") + 7;
    std::istringstream words(script.substr(begin, script.find('"', begin) - begin));
    return {std::istream_iterator<std::string>(words), {}};
  }
};

TEST_F(Help, ListsEveryVerbWithAnExample) {
  const std::string overview = printed("--help");
  ASSERT_GT(verbs().size(), 15u);
  for (const auto& verb : verbs()) {
    EXPECT_NE(overview.find("\n  " + verb + " "), std::string::npos) << verb;
    EXPECT_NE(overview.find("kalfem " + verb + " "), std::string::npos)
        << "apps/kalfem/help.cpp: an example of " << verb;
  }
  EXPECT_EQ(overview.find("Others"), std::string::npos) << overview;
}

TEST_F(Help, OfAVerbFitsATerminalAndHasAnExample) {
  for (const auto& verb : verbs()) {
    const std::string help = printed(verb + " --help");
    EXPECT_EQ(help.find("kalfem " + verb + ": "), 0u) << help;
    EXPECT_NE(help.find("\nExample\n  "), std::string::npos) << help;
    std::istringstream lines(help);
    for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 80u) << line;
    for (const char* foreign : {" TEXT", " INT", "Excludes", "REQUIRED", "SUBCOMMAND", "Positionals"})
      EXPECT_EQ(help.find(foreign), std::string::npos) << help;
  }
}

TEST_F(Help, AMistakeInTheArgumentsIsOneLine) {
  for (
      const auto& [arguments, said] : std::vector<std::pair<std::string, std::string>>{
          {"", "kalfem: no verb is given; kalfem --help lists the verbs\n"},
          {"estimat", "kalfem: there is no verb 'estimat' (did you mean 'estimate'?); kalfem --help lists the verbs\n"},
          {"run --jsno",
           "kalfem run: there is no option '--jsno' (did you mean '--json'?); kalfem run --help says how it is used\n"},
          {"run a.yaml b.yaml",
           "kalfem run: 'b.yaml' is one argument too many; kalfem run --help says how it is used\n"},
          {"new chain", "kalfem new: 'folder' is missing; kalfem new --help says how it is used\n"}}) {
    const auto outcome = run_command(arguments, folder);
    EXPECT_EQ(outcome.code, 2) << arguments;
    EXPECT_EQ(outcome.errors, said);
  }
}

TEST_F(Help, TheVersionSaysWhatItWasBuiltFrom) {
  const std::string version = printed("--version");
  EXPECT_EQ(version.find("kalfem 0."), 0u) << version;
  for (const char* part : {"(commit ", " processor"}) EXPECT_NE(version.find(part), std::string::npos) << version;
  EXPECT_TRUE(version.ends_with(")\n")) << version;
  EXPECT_EQ(std::ranges::count(version, '\n'), 1);
}

}  // namespace
}  // namespace kalfem::test
