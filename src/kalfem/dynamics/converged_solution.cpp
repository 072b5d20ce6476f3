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
/// Of successive changes of plain solutions, where their order of two shows: four, but for what the next power adds.
constexpr double least_ratio = 3.0, most_ratio = 5.0;
/// Change of a halving to that two halvings before, above which they lead nowhere.
constexpr double stagnant_ratio = 0.7;
/// Smaller changes come from rounding and from the solution for the connector forces.
constexpr double stagnant_change = 1e-4;

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

/// A solution at the record's samples.
struct Sampled {
  SimulationResult simulation;
  MatrixXd sensors;

  /// This one and `coarser`, of twice the step, with the error of order h^(2 power) taken out.
  [[nodiscard]] Sampled extrapolated(const Sampled& coarser, Index power) const {
    const double weight = 1.0 / (std::pow(4.0, static_cast<double>(power)) - 1.0);
    const auto extrapolate = [&](MatrixXd& finer, const MatrixXd& other) { finer += weight * (finer - other); };
    Sampled result = *this;
    extrapolate(result.sensors, coarser.sensors);
    extrapolate(result.simulation.every_sample, coarser.simulation.every_sample);
    for (const auto motion : {&Trajectory::displacement, &Trajectory::velocity, &Trajectory::acceleration,
                              &Trajectory::force, &Trajectory::connector_states})
      extrapolate(result.simulation.trajectory.*motion, coarser.simulation.trajectory.*motion);
    return result;
  }
};

/// What is left of the error of S_k,j when the step is halved, where plain solutions err by a third of their last
/// change: a change of S_k,j counts as one of S_k,0 with the same error.
double gain(std::size_t extrapolations) { return 3.0 / (std::pow(4.0, static_cast<double>(extrapolations + 1)) - 1.0); }

/// The solutions S_k,0 ... S_k,j of one step, from the plain one and those of twice the step.
std::vector<Sampled> extrapolations(Sampled plain, const std::vector<Sampled>& coarser) {
  std::vector<Sampled> row{std::move(plain)};
  for (std::size_t j = 1; j <= std::min(coarser.size(), most_extrapolations); ++j)
    row.push_back(row[j - 1].extrapolated(coarser[j - 1], static_cast<Index>(j)));
  return row;
}

/// How far the last halving of the step has moved the sensors' records.
struct Movement {
  double plain = 1.0;              ///< of S_k,0
  double least = 1.0;              ///< of the S_k,j that has moved least, by its gain
  std::size_t extrapolations = 0;  ///< j
};

/// `before`: the change of the plain solutions in the halving before.
Movement movement(const std::vector<Sampled>& finer, const std::vector<Sampled>& coarser, double before) {
  Movement moved;
  if (coarser.empty()) return moved;
  moved.plain = moved.least = largest_change(finer[0].sensors, coarser[0].sensors);
  const bool second_order = before > least_ratio * moved.plain && before < most_ratio * moved.plain;
  for (std::size_t j = 1; j < coarser.size(); ++j) {
    const double change = (second_order ? gain(j) : 1.0) * largest_change(finer[j].sensors, coarser[j].sensors);
    if (change <= moved.least) moved.least = change, moved.extrapolations = j;
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
  /// together whether a finer one is needed; the finer one too where they disagree over the begin of the record
  /// already.
  void make_ahead(Index first, const std::vector<MeasurementChain>& chains) {
    std::vector<Index> finest_first{2 * first, first};
    if (4 * first <= convergence_.max_substeps && disagree_soon(first, chains))
      finest_first.insert(finest_first.begin(), 4 * first);
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

  /// Of all solutions while the one with so many substeps is made, which takes as long as all coarser ones together.
  /// How many will be needed is not known: most often `expected`; each further one takes half of what is left.
  [[nodiscard]] Progress progress_of(Index substeps) const {
    if (!options_.progress || !convergence_.refine) return options_.progress;
    constexpr int expected = 4;
    constexpr double up_to_expected = 0.9;
    const auto number = [&](Index steps) {
      int halvings = 1;
      for (Index k = convergence_.first_substeps; 2 * k <= steps; k *= 2) ++halvings;
      return halvings;
    };
    const auto done_after = [](int solutions) {
      return solutions <= expected
                 ? up_to_expected * (std::ldexp(1.0, solutions) - 1.0) / (std::ldexp(1.0, expected) - 1.0)
                 : 1.0 - (1.0 - up_to_expected) * std::ldexp(1.0, expected - solutions);
    };
    const int current = number(substeps);
    return [whole = part_of(options_.progress, done_after(current - 1), done_after(current)),
            words = "reference " + std::to_string(current) + " of at most " +
                    std::to_string(number(convergence_.max_substeps))](std::string_view, double fraction) {
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
  std::vector<double> changes;
  Movement moved;
  simulation.every_step = sensors;
  const bool ahead = options.refine && options.threads > 1 && !simulation.snapshot && sensors.size() > 0 &&
                     2 * options.first_substeps <= options.max_substeps;
  Simulations simulations(system, signals, initial, std::move(simulation), options);
  if (ahead) simulations.make_ahead(options.first_substeps, chains);
  for (Index substeps = options.first_substeps; substeps <= options.max_substeps; substeps *= 2) {
    reference = {.simulation = simulations.take(substeps), .substeps = substeps, .last_change = 1.0};
    if (reference.simulation.failure) {
      coarser.clear();
      changes.clear();
      moved = {};
      if (!options.refine) break;
      continue;  // a smaller step may converge
    }
    Sampled plain{std::move(reference.simulation), {}};
    plain.sensors = record(plain.simulation.every_step, chains, 1.0 / simulations.step(substeps), substeps);
    plain.simulation.every_step.resize(0, 0);
    auto row = extrapolations(std::move(plain), coarser);
    moved = movement(row, coarser, moved.plain);
    reference.simulation = row[moved.extrapolations].simulation;
    reference.sensors = row[moved.extrapolations].sensors;
    reference.extrapolations = static_cast<Index>(moved.extrapolations);
    reference.last_change = moved.least;
    if (!coarser.empty()) changes.push_back(moved.least);
    reference.changes = changes;
    reference.converged = !coarser.empty() && moved.least <= options.tolerance;
    coarser = std::move(row);
    if (reference.converged || sensors.size() == 0 || !options.refine) break;
  }
  return reference;
}

}  // namespace kalfem
