// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <regex>

#include "base/scratch_folder.hpp"
#include "casefile/base_cases.hpp"
#include "casefile/case_mutations.hpp"
#include "kalfem/casefile/case_schema.hpp"
#include "kalfem/steps/run_study.hpp"
#include "kalfem/yaml/case_reader.hpp"

namespace kalfem::test {
namespace {

/// The case as `kalfem check` takes it; throws InvalidInput.
Study load(const ScratchFolder& folder, const std::string& text) {
  std::ofstream(folder / "case.yaml") << text;
  return load_study((folder / "case.yaml").string());
}

/// What is wrong with how a refusal is told; empty where nothing is.
std::string fault_of(const InvalidInput& error) {
  const std::string text = error.what();
  const auto lines = 1 + std::ranges::count(text, '\n');
  if (lines >= 20) return std::to_string(lines) + " lines";
  if (text.size() > 20'000) return std::to_string(text.size()) + " bytes";
  for (const auto& issue : error.issues()) {
    if (issue.location.file.empty() || issue.location.line < 1) return "no place: " + to_string(issue);
    std::smatch found;
    static const std::regex suggestion("'([^']*)'[^']*\\(did you mean '([^']*)'");
    if (std::regex_search(issue.what, found, suggestion) && found[1] == found[2]) return "suggests what was written";
  }
  return "";
}

/// Whether one of the problems names the key, or what stands there now.
bool speaks_of(const Mutation& mutation, const InvalidInput& error) {
  const auto name = mutation.key.substr(mutation.key.rfind('.') + 1), bare = name.substr(0, name.find('['));
  return std::ranges::any_of(error.issues(), [&](const Issue& issue) {
    const std::string text = to_string(issue);
    return text.find(bare) != std::string::npos ||
           std::ranges::any_of(wrong_names, [&](const char* wrong) { return text.find(wrong) != std::string::npos; });
  });
}

class GeneratedMistakes : public testing::TestWithParam<BaseCase> {
protected:
  GeneratedMistakes() { write_case_files(folder_); }
  ScratchFolder folder_{"mistakes-" + GetParam().name};
};

std::vector<Mutation> all_mutations(const std::string& text, std::set<std::string>& reached) {
  IssueList issues;
  const auto root = parse_yaml(text, "case.yaml", process_environment(), issues);
  return mutations_of(root, description::case_schema().json_schema(), reached);
}

TEST_P(GeneratedMistakes, TheCaseItselfIsSoundAndRuns) {
  IssueList issues;
  const auto root = parse_yaml(GetParam().text, "case.yaml", process_environment(), issues);
  const Study study = load(folder_, to_yaml(*root));
  const StudyResults results = run_study(study, "update");
  EXPECT_TRUE(results.complete()) << results.failure;
}

TEST_P(GeneratedMistakes, AreRefusedWithTheirPlace) {
  std::set<std::string> reached;
  int refused = 0;
  for (const auto& mutation : all_mutations(GetParam().text, reached)) {
    SCOPED_TRACE(mutation.kind + " of " + mutation.key);
    try {
      const Study study = load(folder_, mutation.text);
      EXPECT_FALSE(mutation.wrong) << "accepted:\n" << mutation.text;
      EXPECT_NO_THROW(run_study(study, "update")) << "run refuses what check accepts:\n" << mutation.text;
    } catch (const InvalidInput& error) {
      ++refused;
      EXPECT_EQ(fault_of(error), "") << error.what();
      EXPECT_TRUE(!mutation.wrong || speaks_of(mutation, error)) << mutation.key << "\n" << error.what();
    }
  }
  RecordProperty("refused", refused);
  std::printf("%s: %d refused\n", GetParam().name.c_str(), refused);
}

INSTANTIATE_TEST_SUITE_P(Cases, GeneratedMistakes, testing::ValuesIn(base_cases()),
                         [](const auto& each) { return each.param.name; });

TEST(GeneratedMistakes, ReachEveryKeyOfTheSchemaAndAreMany) {
  std::set<std::string> reached;
  std::size_t count = 0;
  for (const auto& each : base_cases()) count += all_mutations(each.text, reached).size();
  for (const auto& key : keys_of(description::case_schema().json_schema()))
    EXPECT_TRUE(reached.contains(key)) << key << ": no case of base_cases() holds the section that it stands in";
  EXPECT_GE(count, 600U);
  std::printf("%zu cases with a mistake\n", count);
}

}  // namespace
}  // namespace kalfem::test
