// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "identification/chain_structure.hpp"
#include "kalfem/base/parallel.hpp"
#include "kalfem/identification/candidate_information.hpp"
#include "kalfem/identification/open_loop.hpp"
#include "kalfem/information/sensor_placement.hpp"

// All 330 sets of four accelerometers on the eleven degrees of freedom of the chain, ranked by the Cramer-Rao bound of
// the suspension's two unknowns, and the filter over many records for some of them.

namespace kalfem::test {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Set = std::vector<std::size_t>;

constexpr std::size_t dofs = 11;
constexpr std::size_t sampled_sets = 33;

/// Degree of freedom 1 is the wheel, 2 to 11 are the body's masses.
Sensor accelerometer_at(std::size_t dof) {
  return accelerometer("a" + std::to_string(dof), dof == 1 ? "wheel.w" : "body." + std::to_string(dof - 1), 0.15);
}

std::string text_of(const Set& set) {
  std::string text;
  for (const auto i : set) text += (text.empty() ? "" : "-") + std::to_string(i + 1);
  return text;
}

/// The sets by the mean relative bound of the two unknowns, the best first: sqrt((b_k^2 + b_c^2) / 2).
struct Ranking {
  std::vector<Set> sets;
  std::vector<double> bound;

  [[nodiscard]] std::size_t rank(const Set& set) const {
    return static_cast<std::size_t>(std::ranges::find(sets, set) - sets.begin()) + 1;
  }
  [[nodiscard]] double bound_of(const Set& set) const { return bound[rank(set) - 1]; }
};

Record time_of(double duration, double rate) {
  Record time{.sample_rate = rate};
  time.values.resize(0, static_cast<Index>(std::llround(duration * rate)) + 1);
  return time;
}

Ranking ranking(const EstimationProblem& problem, double duration = 20.0, double absolute_noise = 0.0) {
  std::vector<CandidateSensor> sensors;
  for (std::size_t dof = 1; dof <= dofs; ++dof) {
    Sensor sensor = accelerometer_at(dof);
    if (absolute_noise > 0.0) {
      sensor.relative_noise = false;
      sensor.noise = absolute_noise;
    }
    sensors.push_back({sensor.name, {sensor}});
  }
  std::vector<std::string> names;
  VectorXd theta(static_cast<Index>(problem.settings.unknowns.size()));
  for (const auto& each : problem.settings.unknowns) {
    theta[static_cast<Index>(names.size())] = *each.truth;
    names.push_back(each.name);
  }
  const auto information =
      candidate_information(shared(problem), time_of(duration, problem.sample_rate), sensors, names, theta);
  std::vector<SensorCandidate> candidates;
  for (std::size_t i = 0; i < dofs; ++i) candidates.push_back({sensors[i].name, {information.value()[i]}});
  const auto placement = place_sensors(
      candidates,
      {.sensors = 4, .criterion = PlacementCriterion::expected_deviation, .scale = theta, .parameters = {0, 1}});
  Ranking ranked;
  for (const auto& [set, criterion] : placement.sets) {
    ranked.sets.push_back(set);
    ranked.bound.push_back(-criterion);
  }
  return ranked;
}

EstimationProblem two_unknowns(double rate = chain_rate, int substeps = 4) {
  EstimationProblem problem = chain_problem();
  problem.structure = chain_structure(chain_parts(), "road");  // that of examples/chain/place.yaml
  problem.sample_rate = rate;
  problem.settings.initial_state.clear();  // at rest
  problem.settings.substeps = substeps;
  return problem;
}

EstimationProblem with_unknown(std::initializer_list<std::string> names) {
  EstimationProblem problem = two_unknowns();
  for (const auto& name : names) {
    const double value = parameter(*problem.structure, name).value;
    problem.settings.unknowns.push_back(unknown(*problem.structure, name, value, 0.1 * value));
  }
  return problem;
}

/// Positions in ascending order; no value occurs twice.
VectorXd ranks(const std::vector<double>& values) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, {}, [&](std::size_t i) { return values[i]; });
  VectorXd ranks(static_cast<Index>(values.size()));
  for (std::size_t i = 0; i < order.size(); ++i) ranks[static_cast<Index>(order[i])] = static_cast<double>(i);
  return ranks;
}

/// Spearman's.
double rank_correlation(const std::vector<double>& a, const std::vector<double>& b) {
  VectorXd x = ranks(a), y = ranks(b);
  x.array() -= x.mean();
  y.array() -= y.mean();
  return x.dot(y) / (x.norm() * y.norm());
}

/// Four sensors side by side, the first at each degree of freedom from 1 to 8.
std::vector<Set> clusters() {
  std::vector<Set> sets;
  for (std::size_t first = 0; first + 4 <= dofs; ++first) sets.push_back({first, first + 1, first + 2, first + 3});
  return sets;
}

const Set of_the_paper = {2, 4, 6, 10};  // degrees of freedom 3, 5, 7, 11

/// What the filter gives for a set over the seeds, relative to the truth, both unknowns together.
struct FilterFigures {
  double stated = 0.0;  ///< root mean square of the deviations that it states at the end
  double error = 0.0;   ///< root mean square of its errors
  double bias = 0.0;    ///< root mean square of the two mean errors, a part of `error`
};

class Chain {
public:
  Chain(double duration, EstimationProblem problem) : problem_(std::move(problem)) {
    for (std::size_t dof = 1; dof <= dofs; ++dof) sensors_.push_back(accelerometer_at(dof));
    const CoupledModel model = couple(problem_.structure->reference_parts());
    clean_ = simulate_open_loop({model.system(), model, sensors_, problem_.structure->signals},
                                at_rest(model.system().size(), 0), time_of(duration, problem_.sample_rate))
                 .sensors;
  }

  /// One filter over many records of a set.
  [[nodiscard]] FilterFigures figures(const Set& set, int seeds) const {
    EstimationProblem problem = problem_;
    problem.sensors.clear();
    for (const auto i : set) problem.sensors.push_back(sensors_[i]);
    const auto given = shared(std::move(problem));
    IssueList issues;
    const auto setup = make_augmented_model_setup(*given, given->structure->parts, {}, issues);
    issues.raise();
    FilterRun run = make_filter_run(given, setup, record(set, 1));
    FilterFigures sum;
    Eigen::Array2d mean = Eigen::Array2d::Zero();
    for (int seed = 1; seed <= seeds; ++seed) {
      run.input.measured = record(set, static_cast<std::uint64_t>(seed));
      const auto result =
          estimate(*run.choice.augmented_model, run.input, {.filter = run.choice.filter, .state_deviations = false});
      const Eigen::Array2d truth(true_mu_k1, true_mu_c1);
      const Eigen::Array2d stated = result.unknowns.deviation.rightCols(1).array() / truth,
                           error = result.unknowns.mean.rightCols(1).array() / truth - 1.0;
      sum.stated += stated.square().mean() / seeds;
      sum.error += error.square().mean() / seeds;
      mean += error / seeds;
    }
    return {std::sqrt(sum.stated), std::sqrt(sum.error), std::sqrt(mean.square().mean())};
  }

private:
  [[nodiscard]] Record record(const Set& set, std::uint64_t seed) const {
    Record record{.sample_rate = problem_.sample_rate,
                  .values = MatrixXd(static_cast<Index>(set.size()), clean_.cols())};
    for (std::size_t i = 0; i < set.size(); ++i) {
      const auto& sensor = sensors_[set[i]];
      auto row = record.values.row(static_cast<Index>(i));
      row = clean_.row(static_cast<Index>(set[i]));
      const double noise = sensor.deviation(rms(row.transpose()));
      record.channels.push_back({sensor.name, sensor.unit, noise});
      RandomStream random(seed, text_of(set) + " " + sensor.name);  // sets do not share their luck
      for (double& sample : row) sample += noise * random.normal();
    }
    return record;
  }

  EstimationProblem problem_;
  std::vector<Sensor> sensors_;
  MatrixXd clean_;  ///< 11 x samples
};

/// What the bound says of the filter, over sets that are spread evenly over the ranking.
struct Agreement {
  double stated = 0.0, error = 0.0;  ///< rank correlations of the bound with the filter's figures
  double largest = 0.0;              ///< |stated deviation / bound - 1|
  double ratio = 0.0;                ///< root mean square of error / bound
  double bias = 0.0;                 ///< root mean square of bias / bound; of chance alone 1 / sqrt(seeds)
};

Agreement agreement(double duration, const EstimationProblem& problem, int seeds) {
  const Ranking ranked = ranking(problem, duration);
  EXPECT_EQ(ranked.sets.size(), 330U);
  std::vector<Set> sample;
  for (std::size_t i = 0; i < sampled_sets; ++i) sample.push_back(ranked.sets[i * 329 / (sampled_sets - 1)]);
  const Chain chain(duration, problem);
  std::vector<FilterFigures> figures(sample.size());
  for_each_index(sample.size(), processors(), [&](std::size_t i) { figures[i] = chain.figures(sample[i], seeds); });
  std::vector<double> bound, stated, error;
  Agreement found;
  std::printf("rank  set          bound  stated   error  [%% of the truth; %g s at %g Hz, %d seeds]\n", duration,
              problem.sample_rate, seeds);
  for (std::size_t i = 0; i < sample.size(); ++i) {
    bound.push_back(ranked.bound_of(sample[i]));
    stated.push_back(figures[i].stated);
    error.push_back(figures[i].error);
    std::printf("%4zu  %-10s %7.4f %7.4f %7.4f\n", ranked.rank(sample[i]), text_of(sample[i]).c_str(), 100.0 * bound[i],
                100.0 * stated[i], 100.0 * error[i]);
    found.largest = std::max(found.largest, std::abs(stated[i] / bound[i] - 1.0));
    found.ratio += error[i] * error[i] / (bound[i] * bound[i]);
    found.bias += figures[i].bias * figures[i].bias / (bound[i] * bound[i]);
  }
  found.bias = std::sqrt(found.bias / static_cast<double>(sample.size()));
  found.ratio = std::sqrt(found.ratio / static_cast<double>(sample.size()));
  found.stated = rank_correlation(bound, stated);
  found.error = rank_correlation(bound, error);
  std::printf("rank correlation of the bound with the stated deviation %.4f, with the error over the seeds %.4f\n",
              found.stated, found.error);
  std::printf("stated deviation / bound - 1: at most %.4f; rms error / bound over all runs %.4f, of its mean %.4f\n",
              found.largest, found.ratio, found.bias);
  return found;
}

TEST(PlacementOverSeeds, TheBoundIsTheDeviationThatTheFilterStates) {
  const auto found = agreement(20.0, two_unknowns(), 10);
  EXPECT_GE(found.stated, 0.9);
  EXPECT_LT(found.largest, 0.01);  // found 0.0018
  EXPECT_NEAR(found.ratio, 1.0, 0.1);
}

/// Bounds differ by a factor of 1.5 only. With errors that scatter exactly as the bounds say, 10 seeds give rank
/// correlations of 0.54 (0.27 to 0.75 in 95 %), 100 seeds 0.90 (0.84 to 0.95), 200 seeds 0.95 (0.91 to 0.97).
/// The chain's highest mode lies at 55 Hz and the road ends at 30 Hz, so 250 Hz show the same motion as 1 kHz. With
/// four substeps as at 1 kHz, though, the estimates have a bias of half a bound; with eight there is none to be seen.
TEST(PlacementOverSeeds, TheBoundRanksSetsAsErrorsDo) {
  const auto found = agreement(5.0, two_unknowns(250.0, 8), 200);
  EXPECT_GE(found.error, 0.9);
  EXPECT_NEAR(found.ratio, 1.0, 0.05);
  EXPECT_LT(found.bias, 0.15);  // found 0.138, of chance alone 0.07
}

void print_ranking(const char* name, const Ranking& ranked) {
  std::printf("%s: best %s %.4f %%, median %.4f %%, worst %s %.4f %%\n", name, text_of(ranked.sets.front()).c_str(),
              100.0 * ranked.bound.front(), 100.0 * ranked.bound[165], text_of(ranked.sets.back()).c_str(),
              100.0 * ranked.bound.back());
  std::printf("  the paper's %s: rank %zu, %.4f %%\n", text_of(of_the_paper).c_str(), ranked.rank(of_the_paper),
              100.0 * ranked.bound_of(of_the_paper));
  for (const auto& set : clusters())
    std::printf("  cluster %s: rank %zu, %.4f %%\n", text_of(set).c_str(), ranked.rank(set),
                100.0 * ranked.bound_of(set));
  std::vector<double> spread;
  for (const auto& set : ranked.sets) {
    const double mean = static_cast<double>(set[0] + set[1] + set[2] + set[3]) / 4.0;
    double variance = 0.0;
    for (const auto i : set) variance += (static_cast<double>(i) - mean) * (static_cast<double>(i) - mean);
    spread.push_back(variance + 1e-9 * static_cast<double>(spread.size()));  // no two are equal
  }
  std::printf("  rank correlation of the bound with the spread along the chain %.3f\n",
              rank_correlation(ranked.bound, spread));
}

TEST(PlacementOverSeeds, PlacesThePapersSetAndClusters) {
  const Ranking known = ranking(two_unknowns());
  print_ranking("noise 15 % of each channel", known);
  const auto better = std::ranges::count_if(
      clusters(), [&](const Set& set) { return known.bound_of(set) < known.bound_of(of_the_paper); });
  EXPECT_GE(better, 6);                                      // found 7 of 8
  EXPECT_LT(known.bound.back() / known.bound.front(), 1.8);  // found 1.59: no set fails
  print_ranking("noise 1 m/s^2 on each", ranking(two_unknowns(), 20.0, 1.0));
  print_ranking("15 %, nine springs of the body unknown",
                ranking(with_unknown({"body.1-2.stiffness", "body.2-3.stiffness", "body.3-4.stiffness",
                                      "body.4-5.stiffness", "body.5-6.stiffness", "body.6-7.stiffness",
                                      "body.7-8.stiffness", "body.8-9.stiffness", "body.9-10.stiffness"})));
  print_ranking("15 %, all six numbers of the suspension unknown",
                ranking(with_unknown({"suspension.k", "suspension.c", "suspension.mu_k2", "suspension.mu_c2"})));
}

}  // namespace
}  // namespace kalfem::test
