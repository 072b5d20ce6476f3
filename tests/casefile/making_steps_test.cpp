// SPDX-License-Identifier: Apache-2.0
#include "kalfem/study/making_steps.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "kalfem/casefile/case_schema.hpp"
#include "kalfem/yaml/case_reader.hpp"

namespace kalfem {
namespace {

using enum StudyItem;

/// A file with `sensors` on line 2 and `estimate` on line 3.
CaseSource source() {
  IssueList none;
  const auto root = parse_yaml("kalfem: 1\nsensors: {}\nestimate: {}\n", "case.yaml", process_environment(), none);
  return {"case.yaml", root};
}

void fail(IssueList&) { throw InvalidInput("it fails", "", ""); }

TEST(MakingSteps, KnowEverySectionOfACase) {
  const JsonSchema schema = description::case_schema().json_schema();
  for (const auto& [key, section] : schema.json().at("properties").items())
    EXPECT_NE(section_with_key(key), other_keys) << key;
  EXPECT_EQ(section_with_key("sensors"), sensors);
  EXPECT_EQ(section_with_key("sensor"), other_keys);
}

TEST(MakingSteps, AProblemMakesItsResultAndItsSectionUnsound) {
  MakingSteps steps(source(), {});
  steps.run({model, {}, {"sensors"}}, fail);
  ASSERT_EQ(steps.issues().issues().size(), 1U);
  EXPECT_EQ(steps.issues().issues().front().location.line, 2);  // it states no place, so that of the step's key
  EXPECT_FALSE(steps.is_sound(model));
  EXPECT_FALSE(steps.is_sound(sensors));
  EXPECT_TRUE(steps.is_sound(estimate));
  EXPECT_TRUE(steps.was_read(sensors));
}

TEST(MakingSteps, AStepIsSkippedWithAllThatNeedIt) {
  MakingSteps steps(source(), {});
  steps.run({model, {}, {"sensors"}}, fail);
  steps.run({filter, {model}, {"estimate"}}, fail);
  steps.run({driven_substructure, {filter}, {"estimate"}}, fail);
  EXPECT_EQ(steps.issues().issues().size(), 1U);
  EXPECT_FALSE(steps.is_sound(driven_substructure));
  EXPECT_TRUE(steps.is_sound(estimate));  // nothing was found in it
}

TEST(MakingSteps, IndependentProblemsAreToldTogether) {
  MakingSteps steps(source(), {});
  steps.run({model, {}, {"sensors"}}, fail);
  steps.run({parameters, {estimate}, {"estimate"}}, [&](IssueList& issues) {
    issues.add({"case.yaml", 3}, "one");
    issues.add({"case.yaml", 3}, "two");
  });
  EXPECT_EQ(steps.issues().issues().size(), 3U);
}

TEST(MakingSteps, SectionsThatTheReaderRefusedAreUnsoundFromTheStart) {
  IssueList found;
  found.add({"case.yaml", 3}, "the reader refused it");
  MakingSteps steps(source(), found);
  EXPECT_FALSE(steps.was_read(estimate));
  EXPECT_TRUE(steps.was_read(sensors));
  bool has_run = false;
  steps.run({parameters, {estimate}, {"estimate"}}, [&](IssueList&) { has_run = true; });
  EXPECT_FALSE(has_run);
  EXPECT_EQ(steps.issues().issues().size(), 1U);
}

}  // namespace
}  // namespace kalfem
