// SPDX-License-Identifier: Apache-2.0
#include "kalfem/watch/stream_clock.hpp"

#include <gmock/gmock.h>

#include <random>

#include "kalfem/base/binary_archive.hpp"
#include "kalfem/base/invalid_input.hpp"

namespace kalfem {
namespace {

constexpr double rate = 500.0, horizon = 2.0, longest_gap = 3600.0;
constexpr int block = 10;

StreamClock clock_of_two() { return {rate, 2, horizon, longest_gap}; }

/// Sends blocks one after the other, and keeps where the filter has them.
struct Sender {
  StreamClock clock = clock_of_two();
  std::optional<double> newest;
  std::vector<std::string> words;
  double jump = 0.0;
  int refused = 0;

  /// Sample of a block's first value; -1 where it is not used.
  long send(double time, std::size_t channel = 0) try {
    const auto placed = clock.place(channel, time - jump, block, newest);
    jump += placed.jump;
    if (!placed.words.empty()) words.push_back(placed.words);
    if (!placed.time) return -1;
    newest = std::max(newest.value_or(-1.0), *placed.time + (block - 1) / rate);
    return std::lround(*placed.time * rate);
  } catch (const InvalidInput&) {
    ++refused;
    return -1;
  }
};

TEST(StreamClock, LosesNoSampleOfAClockThatDrifts) {
  for (const double ppm : {-500.0, -50.0, 50.0, 500.0}) {
    Sender sender;
    std::mt19937 random(3);
    std::uniform_real_distribution<double> jitter(-0.03, 0.03);
    for (long k = 0; k < 200'000; ++k) {
      const double time = static_cast<double>(k * block) / rate * (1.0 + 1e-6 * ppm) + jitter(random) / rate;
      ASSERT_EQ(sender.send(time), k * block) << ppm << " ppm";
    }
    EXPECT_TRUE(sender.words.empty());
  }
}

TEST(StreamClock, TakesThePhaseOfAClockThatWasSet) {
  Sender sender;
  sender.send(0.0);
  EXPECT_EQ(sender.send(0.02), block);
  EXPECT_EQ(sender.send(5.0008), -1);  // 0.4 of a sample
  EXPECT_EQ(sender.send(5.0208), 2510);
  EXPECT_EQ(sender.send(5.0408), 2520);
  ASSERT_EQ(sender.words.size(), 1U);
  EXPECT_EQ(sender.words[0], "its clock has moved by 0.4 of a sample");
  EXPECT_EQ(sender.refused, 1);
}

TEST(StreamClock, RefusesASingleBlockBetweenTwoSamples) {
  Sender sender;
  for (long k = 0; k < 100; ++k) {
    EXPECT_EQ(sender.send(static_cast<double>(k * block) / rate), k * block);
    if (k % 10 == 0) EXPECT_EQ(sender.send(static_cast<double>(k * block) / rate + 0.0008), -1);
  }
  EXPECT_TRUE(sender.words.empty());
}

TEST(StreamClock, RefusesAChannelThatBeginsBetweenTwoSamples) {
  Sender sender;
  sender.send(0.0);
  EXPECT_EQ(sender.send(0.0008, 1), -1);
  EXPECT_EQ(sender.refused, 1);
}

TEST(StreamClock, GoesOnAfterAJumpByYears) {
  for (const double years : {50.0, -0.01}) {
    Sender sender;
    const double there = years * 365.25 * 86400.0;
    long k = 0;
    for (; k < 500; ++k) sender.send(static_cast<double>(k * block) / rate);  // 10 s
    long first_used = -1;
    for (; k < 5000; ++k) {
      const long sample = sender.send(there + static_cast<double>(k * block) / rate);
      if (sample > 500 * block && first_used < 0) first_used = sample;
    }
    ASSERT_EQ(sender.words.size(), 1U) << years;
    EXPECT_THAT(sender.words[0], testing::HasSubstr("the clock has jumped by"));
    EXPECT_NEAR(sender.jump, there, 0.1);
    EXPECT_NEAR(static_cast<double>(first_used) / rate, 10.0 + (years > 0.0 ? 10.0 : 60.0), 0.1);
    EXPECT_NEAR(*sender.newest, 100.0, 0.1);  // as much as has passed
    EXPECT_LE(sender.refused, 1);             // told once
  }
}

TEST(StreamClock, TakesASingleTimeThatIsWrongForAMistake) {
  Sender sender;
  for (long k = 0; k < 5000; ++k) {
    const double time = static_cast<double>(k * block) / rate;
    EXPECT_EQ(sender.send(time), k * block);
    if (k % 7 == 3) sender.send(time + 1e6);
    if (k % 11 == 5) sender.send(time - 30.0);
  }
  EXPECT_EQ(sender.jump, 0.0);
  EXPECT_TRUE(sender.words.empty());
}

TEST(StreamClock, RefusesTimesThatAreNone) {
  Sender sender;
  for (const double time : {1e300, -1e300, std::nan(""), 1e13}) EXPECT_EQ(sender.send(time), -1);
}

TEST(StreamClock, GoesOnFromAnArchive) {
  Sender sender;
  for (long k = 0; k < 700; ++k)
    sender.send(static_cast<double>(k * block) / rate * (1.0 + 5e-5) + (k > 500 ? 1e5 : 0.0));
  ArchiveWriter writer;
  StreamClock::transfer(sender.clock, writer);
  const std::string bytes = writer.take();
  Sender again = sender;
  again.clock = clock_of_two();
  ArchiveReader reader(bytes);
  StreamClock::transfer(again.clock, reader);
  for (long k = 700; k < 2000; ++k) {
    const double time = static_cast<double>(k * block) / rate * (1.0 + 5e-5) + 1e5;
    ASSERT_EQ(sender.send(time), again.send(time));
  }
  EXPECT_NE(sender.jump, 0.0);
  EXPECT_EQ(sender.jump, again.jump);
}

}  // namespace
}  // namespace kalfem
