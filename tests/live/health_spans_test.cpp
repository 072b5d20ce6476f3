// SPDX-License-Identifier: Apache-2.0
#include "kalfem/live/health_spans.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "kalfem/base/binary_archive.hpp"

namespace kalfem {
namespace {

using enum FilterCondition;

constexpr double step = 0.1;
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

Verdict stuck(const std::string& sensor) {
  Verdict verdict;
  verdict.add({"sensor_stuck", sensor, "", "", VerdictState::suspicious});
  return verdict;
}

/// So many seconds of ten samples each.
void pass(HealthSpans& spans, int seconds, FilterCondition condition, const Verdict& verdict = {}, double nis = 2.0) {
  for (int sample = 0; sample < 10 * seconds; ++sample)
    if (spans.add(nis, std::isfinite(nis) ? 2 : 0)) spans.look(condition, verdict);
}

TEST(HealthSpans, TellSharesOfTheLatestMinuteHourAndDay) {
  HealthSpans spans(step);
  EXPECT_EQ(spans.of(HealthSpan::minute).duration, 0.0);
  pass(spans, 3600, consistent);
  pass(spans, 900, suspicious, stuck("a"), 6.0);
  pass(spans, 30, consistent);
  const auto minute = spans.of(HealthSpan::minute), hour = spans.of(HealthSpan::hour), day = spans.of(HealthSpan::day);
  EXPECT_DOUBLE_EQ(minute.duration, 60.0);
  EXPECT_DOUBLE_EQ(minute.share(suspicious), 0.5);
  EXPECT_DOUBLE_EQ(minute.mean_nis, 4.0);
  EXPECT_DOUBLE_EQ(minute.expected_nis, 2.0);
  EXPECT_DOUBLE_EQ(hour.duration, 3630.0);  // 60 minutes that are over, and the present one
  EXPECT_DOUBLE_EQ(hour.share(suspicious), 900.0 / 3630.0);
  EXPECT_DOUBLE_EQ(day.duration, 4530.0);
  ASSERT_EQ(day.reasons.size(), 1U);
  EXPECT_EQ(day.reasons[0].subject, "a");
  EXPECT_DOUBLE_EQ(day.reasons[0].share, 900.0 / 4530.0);
}

TEST(HealthSpans, ForgetWhatIsOlderThanADay) {
  HealthSpans spans(step);
  pass(spans, 3600, unusable, stuck("a"));
  for (int hour = 0; hour < 24; ++hour) pass(spans, 3600, consistent);
  const auto day = spans.of(HealthSpan::day);
  EXPECT_DOUBLE_EQ(day.duration, 86400.0);
  EXPECT_DOUBLE_EQ(day.share(consistent), 1.0);
  EXPECT_TRUE(day.reasons.empty());
}

TEST(HealthSpans, CountSilenceWithoutANis) {
  HealthSpans spans(step);
  pass(spans, 60, silent, {}, not_a_number);
  const auto minute = spans.of(HealthSpan::minute);
  EXPECT_DOUBLE_EQ(minute.share(silent), 1.0);
  EXPECT_TRUE(std::isnan(minute.mean_nis));
}

TEST(HealthSpans, NameTheMostFrequentReasonFirst) {
  HealthSpans spans(step);
  pass(spans, 10, suspicious, stuck("rare"));
  pass(spans, 20, suspicious, stuck("often"));
  for (int i = 0; i < 200; ++i) pass(spans, 1, suspicious, stuck("sensor " + std::to_string(i)));
  const auto hour = spans.of(HealthSpan::hour);
  EXPECT_EQ(hour.reasons.at(0).subject, "often");
  EXPECT_LE(hour.reasons.size(), 50U * 60U);
}

TEST(HealthSpans, GoOnFromAnArchive) {
  HealthSpans spans(step), again(step);
  pass(spans, 4000, consistent);
  pass(spans, 77, suspicious, stuck("a"), 3.0);
  spans.add(1.0, 2);
  ArchiveWriter writer;
  HealthSpans::transfer(spans, writer);
  const std::string bytes = writer.take();
  ArchiveReader reader(bytes);
  HealthSpans::transfer(again, reader);
  for (auto* each : {&spans, &again}) pass(*each, 100, unusable);
  for (const auto span : {HealthSpan::minute, HealthSpan::hour, HealthSpan::day}) {
    EXPECT_EQ(spans.of(span).duration, again.of(span).duration);
    EXPECT_EQ(spans.of(span).shares, again.of(span).shares);
    EXPECT_EQ(spans.of(span).mean_nis, again.of(span).mean_nis);
  }
}

}  // namespace
}  // namespace kalfem
