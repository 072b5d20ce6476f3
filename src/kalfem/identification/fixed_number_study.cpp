// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/fixed_number_study.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kalfem/base/parallel.hpp"
#include "kalfem/identification/runs_beside.hpp"
#include "kalfem/identification/white_innovations.hpp"
#include "kalfem/statistics/quantiles.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double most_memory = 1e9;  ///< of gains and derivatives [byte]
constexpr double level = 0.005;      ///< of the test of all numbers together
/// In deviations of an unknown: a number that is wrong moves it by some ten, one that is known to a deviation by more.
constexpr double prior_breadth = 20.0, stated_breadth = 300.0;

/// What the unknowns' narrower priors about the estimates know beyond those of the problem: 1 / variance, in their
/// units at the estimates; 0 where they are not narrower.
VectorXd added_by_priors(const EstimationProblem& problem, const EstimationProblem& about, Index unknowns) {
  VectorXd added = VectorXd::Zero(unknowns);
  for (std::size_t i = 0; i < about.settings.unknowns.size(); ++i) {
    const auto &wide = problem.settings.unknowns[i], &narrow = about.settings.unknowns[i];
    const double before = wide.transform.slope(wide.transform.to_state(wide.initial));
    const double slope = narrow.transform.slope(narrow.transform.to_state(narrow.initial));
    const double deviation = wide.deviation * slope / before;
    if (narrow.deviation < deviation)
      added[static_cast<Index>(i)] = 1.0 / (narrow.deviation * narrow.deviation) - 1.0 / (deviation * deviation);
  }
  return added;
}

/// Whether the number's deviation is stated in parts of its value, which may be meant of the held one or of the true
/// one.
bool is_relative(const FixedNumber& number) { return number.deviation > 0.0 && number.scale == std::abs(number.value); }

/// How far the true value may lie from the held one, as a standard deviation [scale]: where the held one is 20 % of the
/// true one below it, the true one is 25 % of the held one above it.
double reach(const FixedNumber& number) {
  constexpr double largest = 0.5;  // beyond it, what is stated says hardly more than the order of magnitude
  return is_relative(number) ? number.deviation / (1.0 - std::min(number.deviation, largest)) : number.deviation;
}

/// (I + S^-1)^-1 g over the stated numbers but `without`.
VectorXd allowed_changes(const FixedNumberStudy& study, Index without) {
  std::vector<Index> stated;
  for (Index i = 0; i < study.size(); ++i)
    if (i != without && study.numbers[static_cast<std::size_t>(i)].deviation > 0.0) stated.push_back(i);
  VectorXd allowed = VectorXd::Zero(study.size());
  if (stated.empty()) return allowed;
  MatrixXd precision = study.information(stated, stated);
  for (std::size_t s = 0; s < stated.size(); ++s) {
    const double deviation = study.numbers[static_cast<std::size_t>(stated[s])].deviation;
    precision(static_cast<Index>(s), static_cast<Index>(s)) += 1.0 / (deviation * deviation);
  }
  const VectorXd score = study.score(stated), changes = precision.ldlt().solve(score);
  allowed(stated) = changes;
  return allowed;
}

/// Information on number i that is left when the other stated numbers are free within what is stated.
double remaining_information(const FixedNumberStudy& study, Index i) {
  FixedNumberStudy by_column = study;
  by_column.score = study.information.col(i);
  const VectorXd taken = allowed_changes(by_column, i);
  return study.information(i, i) - study.information.col(i).dot(taken);
}

void set_asked(FixedNumberStudy& study) {
  const Index count = study.size();
  study.allowed = allowed_changes(study, -1);
  study.asked = study.gain = VectorXd::Zero(count);
  study.asked_deviation = VectorXd::Constant(count, std::numeric_limits<double>::infinity());
  for (Index i = 0; i < count; ++i) {
    const double information = remaining_information(study, i);
    if (!(information > 1e-12 * study.information(i, i))) continue;
    const double score = study.score[i] - study.information.row(i).dot(allowed_changes(study, i));
    study.asked[i] = score / information;
    study.asked_deviation[i] = 1.0 / std::sqrt(information);
    study.gain[i] = 0.5 * score * score / information;
  }
}

/// Collects what the runs beside the numbers tell, number by number.
class Collection {
public:
  /// `added`: see added_by_priors().
  Collection(const RunsBeside& runs, const EstimationResult& result, const RecordEstimate& estimate,
             const VectorXd& added)
      : added_(added),
        judged_(result.innovation.cols() - estimate.settled),
        whiten_(result),
        innovation_(judged(result.innovation)),
        slope_(slopes(estimate)) {
    auto& study = found_.study;
    study.numbers = runs.numbers();
    study.stands_at = runs.stand_at();
    const Index count = std::ssize(study.numbers), samples = result.innovation.cols();
    study.shift = study.considered = MatrixXd::Zero(slope_.size(), count);
    study.score = VectorXd::Zero(count);
    study.confirmed = VectorXd::Constant(count, std::numeric_limits<double>::quiet_NaN());
    white_.setZero(innovation_.size(), count);
    late_shift_ = study.shift;
    first_ = estimate.settled;
    const auto& mean = result.unknowns.mean;
    late_move_ = mean.rightCols(1) -
                 (first_ > 0 ? mean.col(first_ - 1).eval()
                             : estimate.result.unknowns.mean.col(estimate.result.unknowns.mean.cols() - 1).eval());
    if (!study.any_stated()) return;
    const Index quantities = estimate.result.monitored.mean.rows() + std::ssize(estimate.inputs);
    found_.considered = {MatrixXd::Zero(quantities, samples), MatrixXd::Zero(result.innovation.rows(), samples)};
  }

  void take(std::size_t n, const NumberDerivative& found) {
    auto& study = found_.study;
    const auto& derivative = found.means;
    const auto i = static_cast<Index>(n);
    if (!derivative || !derivative->innovation.allFinite() || !derivative->unknowns.allFinite()) {
      study.failed.push_back(study.numbers[n].name);
      return;
    }
    if (found.by_run) study.by_runs.push_back(study.numbers[n].name);
    const VectorXd moved = judged(derivative->innovation);
    white_.col(i) = moved.cast<float>();
    study.score[i] = -moved.dot(innovation_);
    study.shift.col(i) = slope_.cwiseProduct(derivative->unknowns.rightCols(1));
    late_shift_.col(i) = study.shift.col(i);
    if (first_ > 0) late_shift_.col(i) -= slope_.cwiseProduct(derivative->unknowns.col(first_ - 1));
    if (study.numbers[n].deviation > 0.0) stated_.push_back({i, derivative->innovation, derivative->monitored});
  }

  FixedNumberResult finish() && {
    found_.study.information = (white_.transpose() * white_).cast<double>();
    auto& [study, considered] = found_;
    if (study.any_stated()) take_out_priors();
    study.score += study.information * study.stands_at;
    set_asked(study);
    for (const auto& each : stated_)
      considered.innovation += (study.allowed[each.number] - study.stands_at[each.number]) * each.innovation;
    const MatrixXd root = root_of_stated();
    for (std::size_t s = 0; s < stated_.size(); ++s) {
      VectorXd unknowns = VectorXd::Zero(slope_.size());
      MatrixXd monitored = MatrixXd::Zero(considered.monitored.rows(), considered.monitored.cols());
      for (std::size_t r = 0; r < stated_.size(); ++r) {
        const double part = root(static_cast<Index>(r), static_cast<Index>(s));
        if (part == 0.0) continue;
        unknowns += part * study.shift.col(stated_[r].number);
        monitored += part * stated_[r].monitored;
      }
      study.considered.col(stated_[s].number) = unknowns.cwiseAbs();
      considered.monitored += monitored.cwiseAbs2();
    }
    considered.monitored = considered.monitored.cwiseSqrt();
    return std::move(found_);
  }

private:
  /// d nu / d c of a stated number, and that of the monitored quantities.
  struct Stated {
    Index number;
    MatrixXd innovation, monitored;
  };

  /// The narrow priors hold the unknowns back as if the record did. As long as they know far less than the record tells
  /// in the end, the unknowns' shifts s behind the settling, and their moves m, tell by how much:
  /// I_ij -= s_i^T B s_j, g_i += s_i^T B m, B what the priors add.
  void take_out_priors() {
    auto& study = found_.study;
    study.information -= late_shift_.transpose() * added_.asDiagonal() * late_shift_;
    study.score += late_shift_.transpose() * added_.cwiseProduct(late_move_);
    for (Index i = 0; i < study.size(); ++i) study.information(i, i) = std::max(study.information(i, i), 0.0);
  }

  /// Symmetric square root of the covariance of the stated numbers: of what is stated, or, where the estimation stands
  /// at what the record says of them, of the posterior.
  [[nodiscard]] MatrixXd root_of_stated() const {
    const auto& study = found_.study;
    std::vector<Index> stated;
    VectorXd deviation(std::ssize(stated_));
    for (Index s = 0; s < deviation.size(); ++s) {
      stated.push_back(stated_[static_cast<std::size_t>(s)].number);
      deviation[s] = reach(study.numbers[static_cast<std::size_t>(stated.back())]);
    }
    if (!study.is_moved()) return deviation.asDiagonal();
    const auto scale = deviation.asDiagonal();
    const MatrixXd precision = scale * study.information(stated, stated) * scale;
    const Eigen::SelfAdjointEigenSolver<MatrixXd> modes(precision);
    const VectorXd root = (modes.eigenvalues().array().max(0.0) + 1.0).rsqrt();
    return scale * modes.eigenvectors() * root.asDiagonal() * modes.eigenvectors().transpose();
  }

  /// White, of the samples that are judged, channels and then samples.
  [[nodiscard]] VectorXd judged(const MatrixXd& innovation) const {
    return whiten_(innovation).rightCols(judged_).reshaped();
  }

  /// d theta / d x of every unknown at its last estimate.
  static VectorXd slopes(const RecordEstimate& estimate) {
    const auto& state = estimate.result.state.mean;
    const auto& unknowns = estimate.augmented_model->options().unknowns;
    VectorXd slope(std::ssize(unknowns));
    for (Index j = 0; j < slope.size(); ++j)
      slope[j] = unknowns[static_cast<std::size_t>(j)].transform.slope(
          state(estimate.augmented_model->layout().unknown() + j, state.cols() - 1));
    return slope;
  }

  VectorXd added_;
  Index judged_;  ///< samples
  WhiteInnovations whiten_;
  VectorXd innovation_;
  VectorXd slope_;
  Eigen::MatrixXf white_;  ///< d nu / d c, white, one column a number
  std::vector<Stated> stated_;
  Index first_ = 0;      ///< that is judged
  MatrixXd late_shift_;  ///< d theta / d c from there on
  VectorXd late_move_;   ///< of the unknowns from there on
  FixedNumberResult found_;
};

}  // namespace

bool FixedNumberStudy::is_significant(Index i) const {
  const double expected = std::hypot(numbers[static_cast<std::size_t>(i)].deviation, asked_deviation[i]);
  const double limit = normal_quantile(1.0 - 0.5 * level / static_cast<double>(size()));
  return std::isfinite(expected) && std::abs(asked[i]) > limit * expected * room(i);
}

/// 20 % of the held value are less than of what is asked for.
double FixedNumberStudy::room(Index i) const {
  return is_relative(numbers[static_cast<std::size_t>(i)]) ? std::max(1.0, 1.0 + asked[i]) : 1.0;
}

double FixedNumberStudy::promised_rise(Index i) const {
  const double step = (asked[i] - stands_at[i]) / asked_deviation[i];
  return 0.5 * step * step;
}

VectorXd FixedNumberStudy::with_asked(Index i, double most) const {
  FixedNumberStudy given = *this;
  const double change = std::clamp(asked[i], stands_at[i] - most, stands_at[i] + most);
  given.score -= change * information.col(i);
  VectorXd changes = allowed_changes(given, i);
  changes[i] = change;
  return changes;
}

bool FixedNumberStudy::any_stated() const {
  return std::ranges::any_of(numbers, [](const FixedNumber& number) { return number.deviation > 0.0; });
}

std::optional<FixedNumberResult> study_fixed_numbers(const EstimationProblemPtr& problem,
                                                     const AugmentedModelSetup& setup, const Record& record,
                                                     const RecordEstimate& estimate,
                                                     const RecordEstimateOptions& options, StepBudget& budget,
                                                     const ChangedNumbers& changed) try {
  const EstimationProblemPtr about =
      about_estimates(*problem, estimate, problem->settings.known_to.empty() ? prior_breadth : stated_breadth);
  RunsBeside runs(about, setup, record, estimate, options, changed);
  if (runs.numbers().empty() || runs.memory() > most_memory) return std::nullopt;
  if (!budget.take(runs.steps())) return std::nullopt;

  const FilterRun& filter = runs.filter();
  EstimationOptions options_of_filter = rerun_options(filter.choice.filter, problem->settings, estimate);
  options_of_filter.keep_gains = true;
  EstimationResult result = kalfem::estimate(*filter.choice.augmented_model, filter.input, options_of_filter);
  if (result.failure || !runs.run_base(std::move(result.gains))) return std::nullopt;
  Collection collection(runs, result, estimate, added_by_priors(*problem, *about, result.unknowns.mean.rows()));
  const auto groups = runs.groups();
  const auto at_once = static_cast<std::size_t>(filter_threads(problem->settings));
  for (std::size_t first = 0; first < groups.size(); first += at_once) {
    std::vector<std::vector<NumberDerivative>> derivatives(std::min(at_once, groups.size() - first));
    for_each_index(derivatives.size(), static_cast<int>(at_once),
                   [&](std::size_t g) { derivatives[g] = runs.derivatives(groups[first + g]); });
    for (std::size_t g = 0; g < derivatives.size(); ++g)
      for (std::size_t n = 0; n < derivatives[g].size(); ++n) collection.take(groups[first + g][n], derivatives[g][n]);
  }
  return std::move(collection).finish();
} catch (const InvalidInput&) {
  return std::nullopt;  // at the estimates there is no structure
}

}  // namespace kalfem
