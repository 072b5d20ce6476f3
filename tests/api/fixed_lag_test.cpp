// SPDX-License-Identifier: Apache-2.0
// The fixed-lag smoother of a live filter beside the fixed-interval smoother over the record that ends where it stands.
#include "kalfem/live/fixed_lag.hpp"

#include "base/scratch_folder.hpp"
#include "cantilever.hpp"
#include "kalfem/api/online_problem.hpp"
#include "kalfem/estimation/smoother/smoother.hpp"
#include "kalfem/identification/filter_run.hpp"
#include "kalfem/identification/unknown_inputs.hpp"
#include "kalfem/live/state_file.hpp"

namespace kalfem {
namespace {

using Eigen::Index;

constexpr double rate = 500.0;
const std::vector<std::pair<std::string, PointPrior>> nearly_at_rest{
    {"all", {.displacement_std = 1e-4, .velocity_std = 0.01}}};

/// A filter's problem with a record, and the inputs that drive it.
struct Streamed {
  FilterProblem problem;
  std::vector<OnlineInput> inputs;
  Record record;

  [[nodiscard]] OnlineSteps filter(int lag, const std::optional<GateOptions>& gates = {}) const {
    return {problem, inputs, {.window = 100, .lag = lag, .gates = gates}};
  }
  [[nodiscard]] Record begin_of_record(Index samples) const {
    Record part = record;
    part.values = record.values.leftCols(samples).eval();
    return part;
  }
};

Streamed streamed(const Structure& structure, const EstimateOptions& options, double duration = 0.16) {
  return {
      online_problem(structure, rate, options), online_inputs(structure),
      simulate(structure, {.sensors = options.sensors, .duration = duration, .sample_rate = rate, .seed = 3}).record};
}

/// A suspension whose law has an unknown, and a spring whose stiffness the linear part follows: it is relinearised.
Streamed nonlinear_chain(std::optional<FilterKind> kind = {}) {
  return streamed(driven_chain(), {.sensors = chain_sensors(),
                                   .unknowns = {{"suspension.mu_k1", {.initial = 10.0, .std = 5.0}},
                                                {"body.2-3.stiffness", {.initial = 2e4, .std = 8e3}}},
                                   .outputs = {{"spring", displacement("body.2")}},
                                   .initial_state = nearly_at_rest,
                                   .filter = kind});
}

/// A force that was not measured, on a mass with a progressive spring.
Streamed unknown_force(std::optional<FilterKind> kind = {}, double duration = 0.06) {
  const EstimateOptions options{.sensors = {{"a1", acceleration("s.1"), 0.05}, {"x2", displacement("s.2"), 1e-5}},
                                .initial_state = nearly_at_rest,
                                .process_noise = 0.1,
                                .filter = kind};
  const auto force = make_random({.rms = 20.0, .lower = 0.5, .upper = 12.0, .duration = 4.0, .seed = 5});
  Structure s;
  s.add(lumped("s").mass("1", 2.0).mass("2", 3.0).spring("k2", "1", "2", 2e4, 8.0));
  s.add(lumped("base").mass("b", 50.0).spring("k", "ground", "b", 1e6, 500.0));
  s.connect("mount", "base.b", "s.1", law("polynomial", {{"k1", 2e4}, {"k3", 3e8}, {"c1", 10.0}}));
  s.force("wind", "s.2", force);
  Streamed all = streamed(s, options, duration);
  auto problem = std::make_shared<EstimationProblem>(*all.problem.problem);
  UnknownInput wind{.name = "wind", .process = {.order = 2, .correlation_time = 0.03}, .deviation = 20.0, .unit = "N"};
  wind.density = wind.process.density(wind.deviation);
  problem->settings.unknown_inputs = {wind};
  IssueList issues;
  all.problem.setup = make_augmented_model_setup(*problem, problem->structure->parts, {}, issues);
  issues.raise();
  all.problem.problem = problem;
  return all;
}

/// Linear finite elements with a gauge that is no sensor.
Streamed beam_with_virtual_gauge(std::optional<FilterKind> kind = {}) {
  auto beam = cantilever();
  beam.gauge({.name = "root_gauge",
              .place = Eigen::Vector3d(0.05, 0.0, 0.0),
              .direction = Eigen::Vector3d(1, 0, 0),
              .fibre = Eigen::Vector2d(0.0, 0.005)});
  Structure s;
  s.add(beam);
  s.force("shaker", "beam.tip.z", make_random({.rms = 3.0, .lower = 1.0, .upper = 80.0, .duration = 1.0, .seed = 2}));
  return streamed(s, {.sensors = {{"a", acceleration("beam.tip.z"), 0.5}},
                      .initial_state = nearly_at_rest,
                      .process_noise = 0.2,
                      .filter = kind});
}

SmoothedRecord smoothed_offline(const Streamed& all, Index samples) {
  const auto& [problem, setup, monitored] = all.problem;
  const FilterRun run = make_filter_run(problem, setup, all.begin_of_record(samples));
  const EstimationOptions options{
      .filter = run.choice.filter,
      .unscented = problem->settings.unscented,
      .monitored = with_inputs(make_outputs(*setup.model, monitored), held_by(problem->settings.unknown_inputs, setup),
                               *setup.model)};
  const auto filtered = estimate(*run.choice.augmented_model, run.input, options);
  return smooth(*run.choice.augmented_model, run.input, options, filtered).value();
}

/// Largest difference of means, in |mean| + std, and of deviations, in these.
double difference(const PresentEstimate& found, double mean, double deviation) {
  return std::max(std::abs(found.mean - mean) / (std::abs(mean) + deviation), std::abs(found.std / deviation - 1.0));
}

void move_to(OnlineSteps& filter, const Streamed& all, Index k) {
  if (k > 0) ASSERT_TRUE(filter.predict());
  ASSERT_TRUE(filter.update(all.record.values.col(k)));
}

/// At every sample k, and with the lag itself, the estimates of sample k - N.
double largest_difference(const Streamed& all, int lag) {
  OnlineSteps filter = all.filter(lag);
  double largest = 0.0;
  for (Index k = 0; k < all.record.samples(); ++k) {
    move_to(filter, all, k);
    const auto found = filter.loop().smoothed().value();
    const Index of = std::max<Index>(0, k - lag);
    EXPECT_DOUBLE_EQ(found.time, double(of) / rate);
    const auto whole = smoothed_offline(all, k + 1);
    for (std::size_t i = 0; i < found.parameters.size(); ++i)
      largest =
          std::max(largest, difference({found.parameters[i].mean, found.parameters[i].std},
                                       whole.unknowns.mean(Index(i), of), whole.unknowns.deviation(Index(i), of)));
    EXPECT_EQ(std::ssize(found.outputs), whole.monitored.mean.rows());
    for (std::size_t i = 0; i < found.outputs.size(); ++i)
      largest = std::max(largest, difference(found.outputs[i].second, whole.monitored.mean(Index(i), of),
                                             whole.monitored.deviation(Index(i), of)));
  }
  return largest;
}

/// The partially linear filter widens variances by 1e-13 of themselves at each downdate, and square roots round
/// otherwise where smooth() starts its filter anew at checkpoints. Differences of covariances magnify that.
constexpr double of_rounding = 1e-5;

class FixedLagOf : public testing::TestWithParam<std::pair<FilterKind, double>> {
protected:
  void expect_smoother(const Streamed& all, int lag) {
    const double found = largest_difference(all, lag);
    RecordProperty("difference", std::to_string(found));
    std::cout << "largest difference: " << found << "\n";
    EXPECT_LT(found, GetParam().second);
  }
};

TEST_P(FixedLagOf, ANonlinearChainIsTheSmootherOverTheRecordSoFar) {
  Streamed all = nonlinear_chain(GetParam().first);
  all.record.values.row(0).segment(6, 5).setConstant(std::nan(""));
  all.record.values.col(20).setConstant(std::nan(""));
  expect_smoother(all, 10);
}

TEST_P(FixedLagOf, AnUnknownForceIsTheSmootherOverTheRecordSoFar) {
  const Streamed all = unknown_force(GetParam().first);
  EXPECT_EQ(all.filter(1).loop().observed().back(), "wind");
  expect_smoother(all, 10);
}

TEST_P(FixedLagOf, AVirtualStrainIsTheSmootherOverTheRecordSoFar) {
  Streamed all = beam_with_virtual_gauge(GetParam().first);
  all.record = all.begin_of_record(12);
  EXPECT_THAT(all.filter(1).loop().observed(), testing::Contains("beam.root_gauge.strain"));
  expect_smoother(all, 5);
}

INSTANTIATE_TEST_SUITE_P(Kinds, FixedLagOf,
                         testing::Values(std::pair{FilterKind::unscented, 1e-9}, std::pair{FilterKind::extended, 1e-9},
                                         std::pair{FilterKind::unscented_square_root, of_rounding},
                                         std::pair{FilterKind::partially_linear, of_rounding},
                                         std::pair{FilterKind::partially_linear_square_root, of_rounding}));

TEST(FixedLag, LeavesTheBitsOfTheFilter) {
  const Streamed all = nonlinear_chain();
  OnlineSteps with = all.filter(10), without = all.filter(0);
  for (Index k = 0; k < all.record.samples(); ++k) {
    move_to(with, all, k);
    move_to(without, all, k);
    EXPECT_TRUE(with.loop().smoothed().has_value());
    EXPECT_FALSE(without.loop().smoothed().has_value());
    EXPECT_EQ(with.loop().nis(), without.loop().nis());
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_EQ(with.loop().parameter(i).mean, without.loop().parameter(i).mean);
      EXPECT_EQ(with.loop().parameter(i).std, without.loop().parameter(i).std);
    }
  }
}

std::vector<double> bits_of(OnlineSteps& filter) {
  const auto found = filter.loop().smoothed().value();
  std::vector<double> bits{found.time};
  for (const auto& each : found.parameters) bits.insert(bits.end(), {each.mean, each.std, each.lower, each.upper});
  for (const auto& [name, each] : found.outputs) bits.insert(bits.end(), {each.mean, each.std});
  return bits;
}

TEST(FixedLag, GoesOnWithTheSameBitsAfterARestart) {
  const ScratchFolder folder("fixed_lag_restart");
  const Streamed all = nonlinear_chain();
  for (const Index at : {3, 15, 16, 25}) {
    OnlineSteps whole = all.filter(15), first = all.filter(15), second = all.filter(15);
    for (Index k = 0; k <= at; ++k) move_to(first, all, k);
    write_state_file(folder / "state", first.fingerprint(), first);
    read_state_file(folder / "state", second.fingerprint(), second);
    for (Index k = 0; k < all.record.samples(); ++k) {
      move_to(whole, all, k);
      if (k > at) move_to(second, all, k);
      if (k >= at) EXPECT_EQ(bits_of(second), bits_of(whole)) << at << " " << k;
    }
  }
  OnlineSteps other = all.filter(14);
  EXPECT_THROW(read_state_file(folder / "state", other.fingerprint(), other), InvalidInput);
}

TEST(FixedLag, BeginsAnewWhereTheFilterDoes) {
  Streamed all = nonlinear_chain();
  OnlineSteps filter = all.filter(15, GateOptions{.warm_up = 10, .memory = 20, .patience = 5});
  for (Index k = 18; k < all.record.samples(); ++k) all.record.values.col(k).array() += 50.0;
  long begun = 0;
  for (Index k = 0; k < all.record.samples(); ++k) {
    move_to(filter, all, k);
    begun = std::max(begun, filter.loop().changed());
    const auto found = filter.loop().smoothed().value();
    EXPECT_DOUBLE_EQ(found.time, double(std::max(begun, long(k) - 15)) / rate);
    for (const auto& [name, each] : found.outputs) EXPECT_TRUE(std::isfinite(each.mean) && each.std > 0.0) << name;
  }
  EXPECT_GT(begun, 18);
}

TEST(FixedLag, FollowsTheFilterIntoPhysicalCoordinates) {
  const double stiffness = 1000.0, damping = 63.308798756570944;  // four poles within 5 % of each other
  Structure s;
  s.add(lumped("s")
            .mass("a", 1.0)
            .mass("b", 1.0)
            .spring("k1", "ground", "a", stiffness, damping)
            .spring("k2", "ground", "b", 1.001 * stiffness, damping)
            .spring("k3", "a", "b", 1e-3));
  s.connect("n", "s.a", "s.b", law("cubic", {{"k3", 1e3}}));
  s.force("f", "s.a", make_random({.rms = 10.0, .lower = 0.5, .upper = 30.0, .duration = 2.0, .seed = 7}));
  const EstimateOptions options{.sensors = {{"x", acceleration("s.b"), 1e-6}},
                                .unknowns = {{"n.k3", {.initial = 500.0, .std = 300.0}}},
                                .initial_state = {{"all", {.displacement_std = 10.0, .velocity_std = 1e-6}}},
                                .step_order = 2};
  Streamed all = streamed(s, options);
  all.record = simulate(s, {.sensors = options.sensors, .duration = 1.0, .sample_rate = rate, .seed = 1}).record;
  const ScratchFolder folder("fixed_lag_physical");
  OnlineSteps filter = all.filter(20);
  bool has_moved = false;
  for (Index k = 0; k < all.record.samples(); ++k) {
    move_to(filter, all, k);
    const auto found = filter.loop().smoothed().value();
    EXPECT_DOUBLE_EQ(found.time, double(std::max<Index>(0, k - 20)) / rate);
    if (std::exchange(has_moved, filter.loop().in_physical_coordinates()) || !has_moved) continue;
    OnlineSteps again = all.filter(20);
    write_state_file(folder / "state", filter.fingerprint(), filter);
    read_state_file(folder / "state", again.fingerprint(), again);
    EXPECT_EQ(bits_of(again), bits_of(filter));
  }
  EXPECT_TRUE(has_moved);
  const auto last = filter.loop().smoothed().value();
  EXPECT_NEAR(last.parameters[0].mean, filter.loop().parameter(0).mean, 0.5 * last.parameters[0].std);
}

TEST(FixedLag, NarrowsTheBandOfAnUnknownForce) {
  const Streamed all = unknown_force({}, 1.0);
  OnlineSteps filter = all.filter(25);
  for (Index k = 0; k < all.record.samples(); ++k) move_to(filter, all, k);
  const double now = filter.loop().observe("wind").std, later = filter.loop().smoothed()->output("wind").std;
  RecordProperty("deviation_now", std::to_string(now));
  RecordProperty("deviation_smoothed", std::to_string(later));
  std::cout << "deviation of the force: " << now << " N now, " << later << " N 25 samples later\n";
  EXPECT_LT(later, 0.5 * now);
}

TEST(FixedLag, IsRefusedOutOfItsRange) {
  const auto filter = [](int lag) {
    return OnlineFilter(driven_chain(), rate, {.sensors = chain_sensors()}, {.lag = lag});
  };
  EXPECT_THAT(refusal_of([&] { return filter(-1); }), testing::HasSubstr("lag: -1 samples"));
  EXPECT_THAT(refusal_of([] { return FixedLag(1000, 1000, {}); }),
              testing::HasSubstr("lag: 1000 samples of 1000 states need 8 GB: each sample keeps the covariance"));
  OnlineFilter live = filter(3);
  EXPECT_FALSE(live.smoothed().has_value());
  live.update(chain_record().values.col(0));
  EXPECT_EQ(live.smoothed()->output("body.2.velocity").std, live.state("body.2.velocity").std);
  EXPECT_THAT(refusal_of([&] { return live.smoothed()->output("body.2.speed"); }), testing::HasSubstr("no state"));
  EXPECT_THAT(refusal_of([&] { return live.smoothed()->parameter("mu"); }), testing::HasSubstr("no parameter 'mu'"));
}

}  // namespace
}  // namespace kalfem
