// SPDX-License-Identifier: Apache-2.0
#include "kalfem/api/live_filter.hpp"

#include <random>

#include "chain.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using testing::HasSubstr;

constexpr double rate = 500.0;

const EstimateOptions options{
    .sensors = chain_sensors(), .unknowns = {{"suspension.mu_k1", {.initial = 10.0, .std = 5.0}}}, .substeps = 4};

Structure live_chain() { return chain_structure().base_displacement("road", "wheel.ground"); }

/// Every channel of the chain's record, the road among them.
std::vector<std::pair<std::string, VectorXd>> channels() {
  const auto& record = chain_record();
  return {{"a3", record.values.row(0).transpose()},
          {"a5", record.values.row(1).transpose()},
          {"road", road()->sample(0.0, 1.0 / rate, record.samples()).col(0).matrix()}};
}

struct Block {
  std::string channel;
  Index first = 0, count = 0;
};

std::vector<Block> blocks_of(Index length) {
  std::vector<Block> blocks;
  for (Index first = 0; first < chain_record().samples(); first += length)
    for (const auto& [name, values] : channels())
      blocks.push_back({name, first, std::min(length, values.size() - first)});
  return blocks;
}

/// What the filter is after the blocks, bit for bit.
std::vector<double> after(const std::vector<Block>& blocks, double horizon = 0.5) {
  LiveFilter live(live_chain(), rate, options, {.horizon = horizon});
  const auto all = channels();
  for (const auto& [channel, first, count] : blocks)
    for (const auto& [name, values] : all)
      if (name == channel) live.push(name, static_cast<double>(first) / rate, values.segment(first, count));
  live.flush();
  const auto parameter = live.filter().parameter("suspension.mu_k1");
  const auto motion = live.filter().state("body.3.displacement");
  return {
      static_cast<double>(live.samples()), parameter.mean, parameter.std, motion.mean, motion.std, live.filter().nis()};
}

TEST(LiveFilter, IsTheOnlineFilterOfTheSameSamples) {
  OnlineFilter filter(live_chain(), rate, options);
  const auto all = channels();
  const auto& [a3, a5, input] = std::tie(all[0].second, all[1].second, all[2].second);
  filter.start(VectorXd::Constant(1, input[0]));
  filter.update(Eigen::Vector2d(a3[0], a5[0]));
  for (Index k = 1; k < a3.size(); ++k) {
    ASSERT_TRUE(filter.predict_values(VectorXd::Constant(1, input[k])));
    ASSERT_TRUE(filter.update(Eigen::Vector2d(a3[k], a5[k])));
  }
  ASSERT_TRUE(filter.finish());
  const auto found = after(blocks_of(100));
  EXPECT_EQ(found[0], static_cast<double>(a3.size()));
  EXPECT_EQ(found[1], filter.parameter("suspension.mu_k1").mean);
  EXPECT_EQ(found[3], filter.state("body.3.displacement").mean);
  EXPECT_NEAR(found[1], 20.0, 3.0 * found[2]);
}

TEST(LiveFilter, GivesTheSameBitsInAnyOrderWithinTheHorizon) {
  const auto expected = after(blocks_of(100));
  EXPECT_EQ(after(blocks_of(37)), expected);
  auto mixed = blocks_of(20);  // 0.04 s each, moved by up to 0.2 s
  std::mt19937 random(3);
  for (std::size_t i = 0; i + 15 <= mixed.size(); i += 15)
    std::shuffle(mixed.begin() + static_cast<std::ptrdiff_t>(i), mixed.begin() + static_cast<std::ptrdiff_t>(i + 15),
                 random);
  EXPECT_EQ(after(mixed), expected);
}

TEST(LiveFilter, GoesOnBehindTheHorizonWithoutASensor) {
  LiveFilter live(live_chain(), rate, options, {.horizon = 0.1});
  const auto all = channels();
  for (Index first = 0; first < 500; first += 25) {
    const double time = static_cast<double>(first) / rate;
    live.push("road", time, all[2].second.segment(first, 25));
    live.push("a3", time, all[0].second.segment(first, 25));
  }
  EXPECT_EQ(live.samples(), 500 - 50 - 1);  // the horizon of 50 samples behind the latest one
  EXPECT_TRUE(live.filter().usable());
  live.push("a5", 0.0, all[1].second.head(25));
  EXPECT_EQ(live.dropped(), 25);
}

TEST(LiveFilter, RefusesWhatItCannotPlace) {
  LiveFilter live(live_chain(), rate, options, {.start = 1.0, .horizon = 0.1});
  const VectorXd block = VectorXd::Zero(10);
  EXPECT_THAT(refusal_of([&] { return live.push("a4", 1.0, block); }), HasSubstr("no channel 'a4' (did you mean"));
  EXPECT_THAT(refusal_of([&] { return live.push("a3", 1.001, block); }), HasSubstr("lies between two samples"));
  EXPECT_THAT(refusal_of([&] { return live.push("a3", 1.0, VectorXd::Zero(60)); }),
              HasSubstr("longer than the horizon"));
  EXPECT_THAT(refusal_of([&] { return live.push("a3", 1e6, block); }), HasSubstr("after the latest ones"));
  EXPECT_THAT(refusal_of([&] { return live.push("road", 1.0, VectorXd::Constant(10, std::nan(""))); }),
              HasSubstr("not finite"));
  EXPECT_THAT(refusal_of([&] { return live.push("a3", VectorXd::Zero(9), block); }),
              HasSubstr("9 times and 10 values"));
  EXPECT_THAT(refusal_of([&] { LiveFilter(live_chain(), rate, options, {.horizon = 0.0}); }),
              HasSubstr("horizon: 0 s"));
}

}  // namespace
}  // namespace kalfem
