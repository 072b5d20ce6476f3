// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "casefile/case_run.hpp"
#include "kalfem/steps/table.hpp"

namespace kalfem {
namespace {

using Names = std::vector<std::string>;

/// Everything that runs do: one mass on a spring, seen from all sides.
constexpr const char* case_text = R"(
kalfem: 1
substructures:
  s: {masses: {m: 1.0}, springs: [{name: k, from: ground, to: m, stiffness: 400}], damping: {modal: 1 %}}
excitation:
  f: {force: s.m, random: {rms: 1, band: [0.5, 8]}}
sensors:
  y: {displacement: s.m, noise: 2 %}
simulate: {duration: 2 s, sample_rate: 100 Hz}
estimate: {unknown: {s.k.stiffness: {initial: 380, std: 40}}}
modifications: {stiffer: {substructure: s, set: {k.stiffness: 500}}}
infer: {}
)";

Names names_of(std::string_view verb, const std::string& text = case_text) {
  Names names;
  for (const auto* step : steps_of(verb, test::study_of(text))) names.emplace_back(step->name);
  return names;
}

TEST(RunSteps, AVerbTakesWhatItNeedsInTheOrderOfTheTable) {
  EXPECT_EQ(names_of("modes"), Names{"modes"});
  EXPECT_EQ(names_of("simulate"), (Names{"modes", "simulate"}));
  EXPECT_EQ(names_of("estimate"), (Names{"modes", "simulate", "estimate"}));
  EXPECT_EQ(names_of("predict"), (Names{"modes", "simulate", "estimate", "predict"}));
  EXPECT_EQ(names_of("infer"), (Names{"modes", "simulate", "estimate", "infer"}));
  EXPECT_EQ(names_of(every_step), (Names{"modes", "simulate", "estimate", "predict", "infer"}));
}

TEST(RunSteps, OnlyThoseAreTakenThatTheCaseAsksFor) {
  const auto without = test::changed(case_text, "infer: {}\n", "");
  EXPECT_EQ(names_of("infer", without), (Names{"modes", "simulate", "estimate"}));
  EXPECT_EQ(names_of("place"), Names{"modes"});
  EXPECT_TRUE(names_of("static").empty());
}

TEST(RunSteps, AnUnknownVerbIsRefused) { EXPECT_THROW(names_of("guess"), std::invalid_argument); }

TEST(RunSteps, EachEntryIsWhole) {
  std::set<std::string_view> names;
  for (const auto& step : run_steps()) {
    EXPECT_TRUE(names.insert(step.name).second) << step.name;
    EXPECT_NE(step.ran, nullptr) << step.name;
    if (step.run) EXPECT_NE(step.asked_for, nullptr) << step.name;
    if (step.has_verb()) EXPECT_NE(step.run, nullptr) << step.name;
    for (const auto& others : {step.with, step.after})
      for (const auto other : others) EXPECT_NE(find_step(other), nullptr) << step.name << " names " << other;
  }
}

TEST(RunSteps, WhatDidNotRunIsNotThere) {
  const StudyResults none;
  for (const auto* step : steps_that_ran(none)) EXPECT_TRUE(step->name == "modes" || step->name == "record");
}

TEST(Outcomes, AreKeptByTheirTypes) {
  Outcomes outcomes;
  EXPECT_FALSE(outcomes.has<int>());
  EXPECT_THROW((void)outcomes.get<int>(), std::logic_error);
  outcomes.put(3);
  outcomes.put(std::string("three"));
  EXPECT_EQ(outcomes.get<int>(), 3);
  *outcomes.find<int>() = 4;
  const Outcomes copy = outcomes;
  outcomes.put(5);
  EXPECT_EQ(copy.get<int>(), 4);
  EXPECT_EQ(outcomes.get<int>(), 5);
  EXPECT_EQ(copy.get<std::string>(), "three");
}

}  // namespace
}  // namespace kalfem
