// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "casefile/record_cases.hpp"
#include "kalfem/report/record_check.hpp"
#include "kalfem/study/study.hpp"

// The record of a case beside what its model expects of it, before anything is estimated.
namespace kalfem::record_cases {
namespace {

using Change = std::pair<std::string, std::string>;

class RecordChecks : public RecordCase {
protected:
  RecordCheck check_of(const std::vector<Change>& changes = {}) {
    const Study study = load(changes);
    return check_record(study, expectation_of_record(study));
  }
  static std::string words(const RecordCheck& check) {
    std::string all;
    for (const auto& finding : check.findings) all += finding + "\n";
    return all;
  }
};

// The motion has no transient in the record; the model, from rest, has one: correlations are below 1.
TEST_F(RecordChecks, FindNothingInASoundRecord) {
  write_record(si_columns());
  const auto check = check_of();
  EXPECT_EQ(words(check), "");
  ASSERT_EQ(check.table.rows.size(), 2U);
  EXPECT_EQ(check.table.rows[0][0], "x");
  EXPECT_EQ(check.table.rows[0][5], "2.5");  // Hz
}

TEST_F(RecordChecks, TellASignAndAUnit) {
  write_record(
      {{"F", written(force)}, {"x", written(displacement, -1.0)}, {"a", written(acceleration, 1.0 / 9.80665)}});
  const std::string findings = words(check_of());
  expect_in(findings, {"x: the model moves the other way", "a: its rms is 0.08"});
}

TEST_F(RecordChecks, TellAPointThatDoesNotMove) {
  write_record(si_columns());
  const std::string findings = words(
      check_of({{"force: s.m, file: record.csv, channel: F}", "force: s.m, file: record.csv, channel: F, scale: 0}"}}));
  expect_in(findings, {"x: in the model nothing moves there"});
}

TEST_F(RecordChecks, SayWhyThereIsNoExpectation) {
  write_record(si_columns());
  const std::string findings =
      words(check_of({{"excitation:\n  F: {force: s.m, file: record.csv, channel: F}\n", ""}}));
  expect_in(findings, {"No expectation of the model: the case has no excitation"});
}

}  // namespace
}  // namespace kalfem::record_cases
