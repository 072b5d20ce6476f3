// SPDX-License-Identifier: Apache-2.0
#include "kalfem/dynamics/converged_solution.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/parallel.hpp"
#include "kalfem/records/record.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr std::size_t most_extrapolations = 2;
/// Change of a refinement to that two refinements before, above which they lead nowhere.
constexpr double stagnant_ratio = 0.7;
/// Smaller changes come from rounding and from the solution for the connector forces.
constexpr double stagnant_change = 1e-4;

/// Steps of the k-th solution, in those of the first: 1, 2, 3, 6, 12 ...
Index refinement(Index k) { return k < 2 ? k + 1 : Index{3} << (k - 2); }

/// Steps of the first so many solutions together, in those of the first one.
Index cost_of(Index solutions) {
  Index cost = 0;
  for (Index k = 0; k < solutions; ++k) cost += refinement(k);
  return cost;
}

MatrixXd every(const MatrixXd& fine, Index substeps) { return fine(Eigen::all, Eigen::seq(0, Eigen::last, substeps)); }

/// Passes the fine-step outputs through the measurement chains, then samples them.
MatrixXd record(const MatrixXd& fine, const std::vector<MeasurementChain>& chains, double fine_rate, Index substeps) {
  MatrixXd filtered = fine;
  for (std::size_t i = 0; i < chains.size(); ++i)
    filtered.row(static_cast<Index>(i)) =
        chains[i].filter(fine.row(static_cast<Index>(i)).transpose(), fine_rate).transpose();
  return every(filtered, substeps);
}

double largest_change(const MatrixXd& finer, const MatrixXd& coarser) {
  double change = 0.0;
  for (Index j = 0; j < finer.rows(); ++j)
    change = std::max(change, nrmse(coarser.row(j).transpose(), finer.row(j).transpose()));
  return change;
}

/// Steps a sample of the solutions that are extrapolated, coarsest first: n_0 ... n_k.
using Refinements = std::vector<Index>;

/// Change from S_k-1,j to S_k,j in errors of S_k,j, which are of order (n_k-j ... n_k)^-2.
double change_in_errors(const Refinements& steps, std::size_t j) {
  const double ratio = static_cast<double>(steps.back()) / static_cast<double>(steps[steps.size() - 2 - j]);
  return ratio * ratio - 1.0;
}

/// The change from S_k-2,j to S_k-1,j over that from S_k-1,j to S_k,j if they err by (n_k-j ... n_k)^-power.
double ratio_of_changes(const Refinements& steps, std::size_t j, int power) {
  const auto error = [&](std::size_t before_last) {
    double product = 1.0;
    for (std::size_t i = 0; i <= j; ++i) product *= static_cast<double>(steps[steps.size() - 1 - before_last - i]);
    return std::pow(product, -power);
  };
  return (error(2) - error(1)) / (error(1) - error(0));
}

/// A solution at the record's samples.
struct Sampled {
  SimulationResult simulation;
  MatrixXd sensors;

  /// This one less its error, which is `part` of its change from the coarser one.
  [[nodiscard]] Sampled extrapolated(const Sampled& coarser, double part) const {
    const auto extrapolate = [&](MatrixXd& finer, const MatrixXd& other) { finer += part * (finer - other); };
    Sampled result = *this;
    extrapolate(result.sensors, coarser.sensors);
    extrapolate(result.simulation.every_sample, coarser.simulation.every_sample);
    for (const auto motion : {&Trajectory::displacement, &Trajectory::velocity, &Trajectory::acceleration,
                              &Trajectory::force, &Trajectory::connector_states})
      extrapolate(result.simulation.trajectory.*motion, coarser.simulation.trajectory.*motion);
    return result;
  }
};

/// The solutions S_k,0 ... S_k,j with n_k steps, from the plain one and S_k-1,0 ... S_k-1,j-1.
std::vector<Sampled> extrapolations(Sampled plain, const std::vector<Sampled>& coarser, const Refinements& steps) {
  std::vector<Sampled> row{std::move(plain)};
  for (std::size_t j = 0; j < std::min(coarser.size(), most_extrapolations); ++j)
    row.push_back(row[j].extrapolated(coarser[j], 1.0 / change_in_errors(steps, j)));
  return row;
}

/// How far the last refinement of the step has moved the sensors' records.
struct Movement {
  std::vector<double> changes = {};  ///< from S_k-1,j to S_k,j for each j
  double least = 1.0;                ///< three times the error of the S_k,j that errs least
  std::size_t extrapolations = 0;    ///< j
};

/// Whether two successive changes of S_.,j are nearer to those of its order, two in each step, than to those of one.
bool shows_order(const Refinements& steps, std::size_t j, const std::vector<double>& before,
                 const std::vector<double>& changes) {
  if (j >= before.size()) return false;
  const double expected = ratio_of_changes(steps, j, 2), of_first_order = ratio_of_changes(steps, j, 1);
  return std::abs(before[j] / changes[j] - expected) < 0.5 * (expected - of_first_order);
}

/// `before`: the changes in the refinement before. S_k,j is trusted to err by what its change tells if the less
/// extrapolated ones show their order; otherwise it counts as no better than the last one of these for its change.
Movement movement(const std::vector<Sampled>& finer, const std::vector<Sampled>& coarser, const Refinements& steps,
                  const std::vector<double>& before) {
  Movement moved;
  std::size_t trusted = 0;
  for (std::size_t j = 0; j < coarser.size(); ++j) {
    moved.changes.push_back(largest_change(finer[j].sensors, coarser[j].sensors));
    if (j > 0 && trusted == j - 1 && shows_order(steps, trusted, before, moved.changes)) trusted = j;
    const double tripled_error = 3.0 / change_in_errors(steps, trusted) * moved.changes[j];
    if (j == 0 || tripled_error <= moved.least) moved.least = tripled_error, moved.extrapolations = j;
  }
  return moved;
}

void check(const ConvergenceOptions& options) {
  IssueList issues;
  if (!(options.sample_rate > 0.0) || !std::isfinite(options.sample_rate))
    issues.add({}, "the sampling rate is " + std::to_string(options.sample_rate) + " Hz", "it must be positive");
  if (options.first_substeps < 1 || options.max_substeps < options.first_substeps)
    issues.add({},
               "the time steps per sample go from " + std::to_string(options.first_substeps) + " to " +
                   std::to_string(options.max_substeps),
               "the first must be at least 1, and the last at least the first");
  if (!(options.tolerance > 0.0))
    issues.add({}, "the tolerance of the simulation is " + std::to_string(options.tolerance), "it must be positive");
  issues.raise();
}

/// Simulations of one system with different steps, some of them made ahead.
class Simulations {
public:
  Simulations(const LocallyNonlinearSystem& system, const std::vector<SignalPtr>& signals, const InitialState& initial,
              SimulationOptions options, const ConvergenceOptions& convergence)
      : system_(system),
        signals_(signals),
        initial_(initial),
        options_(std::move(options)),
        convergence_(convergence) {}

  [[nodiscard]] double step(Index substeps) const {
    return 1.0 / (convergence_.sample_rate * static_cast<double>(substeps));
  }

  /// The coarsest solutions side by side in two threads: those with `first` and 2 `first` steps a sample, which tell
  /// together whether a finer one is needed; where they disagree over the begin of the record already, the one with
  /// 3 `first` steps too, which takes as long as both.
  void make_ahead(Index first, const std::vector<MeasurementChain>& chains) {
    std::vector<Index> finest_first{2 * first, first};
    if (3 * first <= convergence_.max_substeps && disagree_soon(first, chains))
      finest_first.insert(finest_first.begin(), 3 * first);
    for (auto& [substeps, made] : side_by_side(finest_first, options_.duration, progress_of(finest_first[0])))
      ahead_[substeps] = std::move(made);
  }

  SimulationResult take(Index substeps) {
    const auto made = ahead_.extract(substeps);
    return made ? std::move(made.mapped()) : simulated(substeps, progress_of(substeps), options_.duration);
  }

private:
  using Solutions = std::map<Index, SimulationResult>;

  [[nodiscard]] Solutions side_by_side(const std::vector<Index>& substeps, double duration,
                                       const Progress& of_the_first) const {
    std::vector<SimulationResult> made(substeps.size());
    for_each_index(substeps.size(), 2, [&](std::size_t i) {
      made[i] = simulated(substeps[i], i == 0 ? of_the_first : Progress{}, duration);
    });
    Solutions solutions;
    for (std::size_t i = 0; i < substeps.size(); ++i) solutions[substeps[i]] = std::move(made[i]);
    return solutions;
  }

  [[nodiscard]] bool disagree_soon(Index first, const std::vector<MeasurementChain>& chains) const {
    constexpr double begin = 0.05, least_samples = 20.0;
    const double samples = std::round(begin * options_.duration * convergence_.sample_rate);
    if (samples < least_samples) return false;
    const Solutions made = side_by_side({2 * first, first}, samples / convergence_.sample_rate, {});
    if (std::ranges::any_of(made, [](const auto& solution) { return solution.second.failure.has_value(); }))
      return false;
    const auto recorded = [&](Index substeps) {
      return record(made.at(substeps).every_step, chains, 1.0 / step(substeps), substeps);
    };
    return largest_change(recorded(2 * first), recorded(first)) > convergence_.tolerance;
  }

  /// Of all solutions while the one with so many substeps is made. How many will be needed is not known: most often
  /// `expected`; each further one takes half of what is left.
  [[nodiscard]] Progress progress_of(Index substeps) const {
    if (!options_.progress || !convergence_.refine) return options_.progress;
    constexpr Index expected = 4;
    constexpr double up_to_expected = 0.9;
    const auto solutions_up_to = [&](Index steps) {
      Index solutions = 0;
      while (convergence_.first_substeps * refinement(solutions) <= steps) ++solutions;
      return solutions;
    };
    const auto done_after = [](Index solutions) {
      return solutions <= expected
                 ? up_to_expected * static_cast<double>(cost_of(solutions)) / static_cast<double>(cost_of(expected))
                 : 1.0 - (1.0 - up_to_expected) * std::ldexp(1.0, static_cast<int>(expected - solutions));
    };
    const Index current = solutions_up_to(substeps);
    return [whole = part_of(options_.progress, done_after(current - 1), done_after(current)),
            words = "reference " + std::to_string(current) + " of at most " +
                    std::to_string(solutions_up_to(convergence_.max_substeps))](std::string_view, double fraction) {
      whole(words, fraction);
    };
  }

  [[nodiscard]] SimulationResult simulated(Index substeps, const Progress& progress, double duration) const {
    SimulationOptions options = options_;
    options.duration = duration;
    options.step = step(substeps);
    options.keep_every = substeps;
    options.progress = progress;
    return simulate(system_, signals_, initial_, options);
  }

  const LocallyNonlinearSystem& system_;
  const std::vector<SignalPtr>& signals_;
  const InitialState& initial_;
  SimulationOptions options_;
  const ConvergenceOptions& convergence_;
  Solutions ahead_;
};

}  // namespace

bool ConvergedSolution::stagnates() const {
  return changes.size() >= 3 && changes.back() > stagnant_change &&
         changes.back() > stagnant_ratio * changes[changes.size() - 3];
}

ConvergedSolution simulate_converged(const LocallyNonlinearSystem& system, const std::vector<SignalPtr>& signals,
                                     const InitialState& initial, const OutputMap& sensors,
                                     const std::vector<MeasurementChain>& chains, SimulationOptions simulation,
                                     const ConvergenceOptions& options) {
  check(options);
  ConvergedSolution reference;
  std::vector<Sampled> coarser;
  Refinements steps;
  std::vector<double> changes;
  Movement moved;
  simulation.every_step = sensors;
  const bool ahead = options.refine && options.threads > 1 && !simulation.snapshot && sensors.size() > 0 &&
                     2 * options.first_substeps <= options.max_substeps;
  Simulations simulations(system, signals, initial, std::move(simulation), options);
  if (ahead) simulations.make_ahead(options.first_substeps, chains);
  for (Index k = 0; options.first_substeps * refinement(k) <= options.max_substeps; ++k) {
    const Index substeps = options.first_substeps * refinement(k);
    reference = {.simulation = simulations.take(substeps), .substeps = substeps, .last_change = 1.0};
    if (reference.simulation.failure) {
      coarser.clear();
      steps.clear();
      moved = {};
      changes.clear();
      if (!options.refine) break;
      continue;  // a smaller step may converge
    }
    Sampled plain{std::move(reference.simulation), {}};
    plain.sensors = record(plain.simulation.every_step, chains, 1.0 / simulations.step(substeps), substeps);
    plain.simulation.every_step.resize(0, 0);
    steps.push_back(substeps);
    auto row = extrapolations(std::move(plain), coarser, steps);
    moved = movement(row, coarser, steps, moved.changes);
    reference.simulation = row[moved.extrapolations].simulation;
    reference.sensors = row[moved.extrapolations].sensors;
    reference.extrapolations = static_cast<Index>(moved.extrapolations);
    reference.last_change = moved.least;
    if (!coarser.empty()) changes.push_back(moved.changes.front());
    reference.changes = changes;
    reference.converged = !coarser.empty() && moved.least <= options.tolerance;
    coarser = std::move(row);
    if (reference.converged || sensors.size() == 0 || !options.refine) break;
  }
  return reference;
}

}  // namespace kalfem
