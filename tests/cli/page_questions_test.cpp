// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <sstream>
#include <vector>

#include "base/absent.hpp"
#include "base/data_folder.hpp"
#include "base/places.hpp"
#include "command.hpp"

// The page answers what people ask: every element that docs/page-questions.md names stands on the page of the example
// in whose column it says yes, and nowhere else. The records are short: the answers need not be good, but there.

namespace kalfem::test {
namespace {

constexpr std::size_t element_column = 4, first_example = 5;

std::vector<std::string> split(const std::string& text, const std::string& separator) {
  std::vector<std::string> parts;
  std::size_t begin = 0;
  for (std::size_t end = text.find(separator); end != std::string::npos; end = text.find(separator, begin)) {
    parts.push_back(text.substr(begin, end - begin));
    begin = end + separator.size();
  }
  parts.push_back(text.substr(begin));
  return parts;
}

struct Question {
  std::string number;
  std::vector<std::string> elements;  ///< one of them answers it
  std::vector<std::string> answered;  ///< by example: "yes", or why not
};

std::vector<Question> questions() {
  std::vector<Question> all;
  std::istringstream text(read(source_folder() + "/docs/page-questions.md"));
  for (std::string line; std::getline(text, line);) {
    if (line.size() < 3 || line[0] != '|' || !std::isdigit(static_cast<unsigned char>(line[2]))) continue;
    const auto cells = split(line.substr(2, line.size() - 4), " | ");
    Question question{.number = cells.at(0)};
    const auto quoted = split(cells.at(element_column), "`");
    for (std::size_t i = 1; i < quoted.size(); i += 2) question.elements.push_back(quoted[i]);
    question.answered = {cells.begin() + first_example, cells.end()};
    all.push_back(question);
  }
  return all;
}

struct Example {
  const char* name;
  const char* arguments;  ///< of `kalfem run`, below examples/
  const char* data;       ///< below the folder of measured data; empty: none
};

void PrintTo(const Example& example, std::ostream* stream) { *stream << example.name; }

const Example examples[] = {
    {"chain", "chain/chain.yaml --set simulate.duration=4s", ""},
    {"vehicle", "vehicle/vehicle.yaml --set simulate.duration=3s --set simulate.reference=superelement", ""},
    {"halfcar", "halfcar/halfcar.yaml", "halfcar-rig/halfcar_500Hz.h5"},
    {"garteur", "garteur/wing.yaml", "garteur/nodes.csv"},
};

class PageOf : public testing::TestWithParam<Example> {};

TEST_P(PageOf, AnswersTheQuestions) {
  const auto& [name, arguments, data] = GetParam();
  if (*data && !std::filesystem::exists(data_folder(data)))
    KALFEM_ABSENT("no measured data in " + data_folder(data).string());
  const ScratchFolder folder(std::string("page-of-") + name);
  const auto outcome = run_command("run --quiet " + example(arguments) + " --out " + (folder / "out").string(), folder);
  ASSERT_TRUE(outcome.code == 0 || outcome.code == 3) << outcome.errors;
  const std::string page = read(folder / "out/report.html");
  const auto column =
      static_cast<std::size_t>(std::ranges::find(examples, std::string(name), &Example::name) - examples);
  for (const auto& question : questions()) {
    const bool found = std::ranges::any_of(
        question.elements, [&](const auto& element) { return page.find(element) != std::string::npos; });
    EXPECT_EQ(found, question.answered.at(column) == "yes")
        << "question " << question.number << " on the page of " << name;
  }
}

INSTANTIATE_TEST_SUITE_P(Examples, PageOf, testing::ValuesIn(examples),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(PageQuestions, AreTwentyThree) {
  const auto all = questions();
  ASSERT_EQ(all.size(), 23U);
  for (const auto& question : all) {
    EXPECT_FALSE(question.elements.empty()) << question.number;
    EXPECT_EQ(question.answered.size(), std::size(examples)) << question.number;
  }
}

}  // namespace
}  // namespace kalfem::test
