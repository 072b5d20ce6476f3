// SPDX-License-Identifier: Apache-2.0
#include "kalfem/verdict/reason_kinds.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>
#include <string>

#include "base/places.hpp"

namespace kalfem {
namespace {

std::string text_of(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

std::string codes_of(const ReasonKind& kind) {
  std::string codes;
  for (const auto code : kind.codes) codes += (codes.empty() ? "`" : ", `") + std::string(code) + "`";
  return codes;
}

std::string row_of(const ReasonKind& kind) {
  return "| " + codes_of(kind) + " | " + std::string(kind.contradiction) + " | " +
         std::string(to_string(kind.gravity)) + " |\n";
}

std::set<std::string> codes_in_table() {
  std::set<std::string> codes;
  for (const auto kinds : {reason_kinds(), mistake_kinds()})
    for (const auto& kind : kinds) codes.insert(kind.codes.begin(), kind.codes.end());
  return codes;
}

/// Codes of the reasons that the sources form.
std::set<std::string> codes_in_sources() {
  const std::filesystem::path source = test::source_folder() + "/src/kalfem";
  std::vector<std::filesystem::path> files{source / "api/update.cpp", source / "steps/run_verdict.cpp"};
  for (const char* folder : {"verdict", "diagnosis"})
    for (const auto& entry : std::filesystem::directory_iterator(source / folder)) files.push_back(entry.path());
  const std::regex formed(R"re((?:reasons_?\.push_back\(\s*\{|return \{\{?|\.code = |\.add\(\s*\{)\s*"([a-z_]+)")re");
  std::set<std::string> codes;
  for (const auto& file : files) {
    const std::string text = text_of(file);
    for (std::sregex_iterator found(text.begin(), text.end(), formed), end; found != end; ++found)
      codes.insert((*found)[1]);
  }
  return codes;
}

TEST(ReasonKinds, HoldEveryCodeThatTheSourcesForm) {
  const auto known = codes_in_table(), formed = codes_in_sources();
  EXPECT_GT(formed.size(), 40U);
  for (const auto& code : formed) EXPECT_TRUE(known.contains(code)) << code;
  std::set<std::string> composed;  // "sensor_" and the kind of an event; one of two words
  for (const auto& code : known)
    if (!formed.contains(code)) composed.insert(code);
  EXPECT_THAT(composed, testing::UnorderedElementsAre("parameter_drift", "parameter_jump", "sensor_dead", "sensor_off",
                                                      "sensor_stuck"));
}

TEST(ReasonKinds, AreTheTablesOfTheDocumentation) {
  const std::string page = text_of(test::source_folder() + "/docs/verdict.md");
  std::string rules, mistakes;
  for (const auto& kind : reason_kinds()) rules += row_of(kind);
  for (const auto& kind : mistake_kinds())
    mistakes += "| " + codes_of(kind) + " | " + std::string(kind.contradiction) + " |\n";
  EXPECT_NE(page.find(rules), std::string::npos) << "the table of rules is:\n" << rules;
  EXPECT_NE(page.find(mistakes), std::string::npos) << "the table of mistakes is:\n" << mistakes;
}

TEST(ReasonKinds, HoldAReasonToWhatItsRuleLeadsTo) {
  Verdict verdict;
  verdict.add({"record_too_short", "", "", "", VerdictState::unusable});
  EXPECT_EQ(verdict.state(), VerdictState::suspicious);
  verdict.add({"innovation_large", "a", "", "", VerdictState::suspicious});
  EXPECT_EQ(verdict.state(), VerdictState::suspicious);
  verdict.add({"unphysical_sign", "k", "", "", VerdictState::suspicious});
  EXPECT_EQ(verdict.state(), VerdictState::unusable);
}

}  // namespace
}  // namespace kalfem
