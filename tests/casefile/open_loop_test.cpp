// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "casefile/record_cases.hpp"
#include "kalfem/report/console_report.hpp"
#include "kalfem/report/result_set.hpp"
#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/steps/run_study.hpp"

// The record again from the estimates alone.
namespace kalfem::record_cases {
namespace {

class OpenLoop : public RecordCase {};

TEST_F(OpenLoop, IsDrivenFromTheRecordsOwnStart) {
  write_record(si_columns());
  for (const std::string start : {"0 s", "1.37 s"}) {
    const Study study = load({{"{file: record.csv}\nest", "{file: record.csv, start: " + start + "}\nest"}});
    const auto results = run_study(study, "predict");
    ASSERT_TRUE(results.usable()) << results.failure;
    const auto& outcome = results.get<EstimationOutcome>();
    ASSERT_TRUE(outcome.open_loop);
    // The force is interpolated by a spline between 40 samples a period.
    // found 9e-4
    for (const double error : outcome.open_loop_nrmse) EXPECT_LT(error, 2e-3) << start;
  }
}

/// A structure that is unstable on its own: the filter follows the record, the simulation leaves it.
TEST_F(OpenLoop, ThatDivergesIsAnOutcome) {
  write_record(si_columns());
  const auto with = [&](const std::string& force) {
    return load({{"excitation:", "connectors:\n  c: {from: s.ground, to: s.m, law: expression, force: '" + force +
                                     "', parameters: {d: 1}}\nexcitation:"},
                 {"s.k.stiffness: {initial: 760 N/m, std: 20 %}", "c.d: {initial: 1, std: 1e-6}"},
                 {"settle: 0.5 s", "settle: 0.5 s\n  step_order: 2\n  process_noise: {acceleration: 30}"}});
  };
  // Growth without bound, a softening spring that gives way, and steps too coarse to see the growth in full.
  // The last is so far from the record that its estimates contradict their prior as well.
  const std::string untrusted = "-2000*d*v";
  for (const std::string& force :
       {std::string("-300*d*v"), std::string("-60*d*v"), std::string("-60*d*v - 1e6*d*x*x*x"), untrusted}) {
    SCOPED_TRACE(force);
    const Study study = with(force);
    const auto results = run_study(study, "predict");
    EXPECT_EQ(results.usable(), force != untrusted) << results.failure;
    EXPECT_FALSE(results.get<EstimationOutcome>().open_loop);
    const auto summary = summarise(study, results);
    EXPECT_EQ(summary["status"], force == untrusted ? "unusable" : "ok");
    EXPECT_NE(results.get<EstimationOutcome>().open_loop_failure.find("the simulation with the estimates "),
              std::string::npos);
    EXPECT_EQ(summary["estimation"]["open_loop_failure"], results.get<EstimationOutcome>().open_loop_failure);
    EXPECT_FALSE(summary["estimation"].contains("open_loop"));
    EXPECT_NE(console_report(study, results).find("No open-loop comparison: "), std::string::npos);
  }
}

TEST_F(OpenLoop, TheSummarySaysWhichPartOfTheRecordWasUsed) {
  write_record(si_columns());
  const Study study = load({{"{file: record.csv}\nest", "{file: record.csv, start: 1 s, end: 3 s}\nest"}});
  const auto record = summarise(study, run_study(study, "modes"))["record"];
  EXPECT_EQ(record["start_s"], 1.0);
  EXPECT_EQ(record["end_s"], 3.0);
  EXPECT_EQ(record["samples"], 201);
  EXPECT_FALSE(record.contains("release_s"));
}

}  // namespace
}  // namespace kalfem::record_cases
