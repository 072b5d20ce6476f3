// SPDX-License-Identifier: Apache-2.0
#include "kalfem/verdict/updating_checks.hpp"

#include <gtest/gtest.h>
#include <algorithm>

namespace kalfem {
namespace {

/// An updating that nothing speaks against.
UpdatingRecord sound() {
  UpdatingRecord record;
  record.comparisons = {{.name = "modes", .rms = 1.1, .degrees_of_freedom = 20.0},
                        {.name = "record", .rms = 1.02, .degrees_of_freedom = 20000.0}};
  record.parameters = {{.name = "frame.k",
                        .unit = "N/m",
                        .initial = 1000.0,
                        .value = 900.0,
                        .prior_deviation = 100.0,
                        .widening = 1.2,
                        .widening_freedom = 1000.0,
                        .positive_by_nature = true}};
  return record;
}

bool has(const UpdatingRecord& record, const std::string& code, VerdictState state = VerdictState::suspicious) {
  return std::ranges::any_of(updating_reasons(record),
                             [&](const Reason& each) { return each.code == code && each.state == state; });
}

TEST(UpdatingChecks, NothingSpeaksAgainstASoundOne) { EXPECT_TRUE(updating_reasons(sound()).empty()); }

std::string remedy_of(const UpdatingRecord& record, const std::string& code) {
  for (const auto& each : updating_reasons(record))
    if (each.code == code) return each.remedy;
  return "";
}

TEST(UpdatingChecks, APriorIsAdvisedOnlyWhereNoneIsStated) {
  auto record = sound();
  record.parameters.push_back({.name = "frame.m", .prior_deviation = 1.0});
  record.not_told_apart = {{"frame.k", "frame.m"}};
  record.not_identified = {"frame.m"};
  for (const std::string code : {"correlated", "not_identified"}) {
    EXPECT_FALSE(remedy_of(record, code).empty());
    EXPECT_EQ(remedy_of(record, code).find("prior"), std::string::npos) << remedy_of(record, code);
  }
  record.parameters[1].prior_deviation.reset();
  EXPECT_NE(remedy_of(record, "correlated").find("give 'frame.m' a prior"), std::string::npos);
  EXPECT_NE(remedy_of(record, "not_identified").find("give it a prior"), std::string::npos);
}

TEST(UpdatingChecks, ALargeResidualIsSuspiciousAndAVeryLargeOneUnusable) {
  auto record = sound();
  record.comparisons[1].rms = 1.6;
  EXPECT_TRUE(has(record, "residual_large"));
  record.comparisons[1].rms = 14.0;
  EXPECT_TRUE(has(record, "residual_large", VerdictState::unusable));
  record.comparisons = {{.name = "one value", .rms = 1.9, .degrees_of_freedom = 1.0}};
  EXPECT_TRUE(updating_reasons(record).empty()) << "chance gives as much for a single value";
}

TEST(UpdatingChecks, ASmallResidualSaysThatDeviationsAreTooLarge) {
  auto record = sound();
  record.comparisons[1].rms = 0.4;
  EXPECT_TRUE(has(record, "residual_small"));
  record.comparisons[1].has_bounds = true;
  EXPECT_FALSE(has(record, "residual_small"));
  record.comparisons = {{.name = "modes", .rms = 0.4, .degrees_of_freedom = 3.0}};
  EXPECT_FALSE(has(record, "residual_small")) << "chance";
}

TEST(UpdatingChecks, ASearchWithoutEndIsNamed) {
  auto record = sound();
  record.converged = false;
  record.termination = "the limit on evaluations was reached";
  EXPECT_TRUE(has(record, "not_converged"));
}

TEST(UpdatingChecks, ABoundAPriorAndASignAreNamed) {
  auto record = sound();
  record.parameters[0].at_bound = true;
  EXPECT_TRUE(has(record, "at_bound"));
  record = sound();
  record.parameters[0].value = 1450.0;
  EXPECT_TRUE(has(record, "far_from_prior"));
  record.parameters[0].prior_deviation.reset();
  EXPECT_TRUE(updating_reasons(record).empty()) << "without a prior any value is as good";
  record.parameters[0].value = -3.0;
  EXPECT_TRUE(has(record, "unphysical_sign", VerdictState::unusable));
  record.parameters[0].positive_by_nature = false;
  EXPECT_TRUE(updating_reasons(record).empty());
}

TEST(UpdatingChecks, ADeviationThatIsTooSmallIsNamedWhereTheModelDoesNotFollowAndTheRobustOneIsSure) {
  auto record = sound();
  record.parameters[0].widening = 3.0;
  EXPECT_TRUE(updating_reasons(record).empty()) << "the interval is that of the robust one";
  record.comparisons[1].rms = 1.6;
  EXPECT_TRUE(has(record, "deviation_too_small"));
  record.parameters[0].widening_freedom = 1.0;
  EXPECT_FALSE(has(record, "deviation_too_small"));
}

TEST(UpdatingChecks, WhatTheDataCannotTellApartAndPoorPairsAreNamed) {
  auto record = sound();
  record.not_told_apart = {{"frame.k", "frame.m"}};
  record.not_identified = {"frame.c"};
  record.comparisons[0].poor_pairs = {"12.3 Hz (MAC 0.31)"};
  EXPECT_TRUE(has(record, "correlated"));
  EXPECT_TRUE(has(record, "not_identified"));
  EXPECT_TRUE(has(record, "poor_pairs"));
}

}  // namespace
}  // namespace kalfem
