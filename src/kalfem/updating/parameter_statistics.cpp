// SPDX-License-Identifier: Apache-2.0
#include "kalfem/updating/parameter_statistics.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double zero_column = 1e-14;  // of the longest: rounding
constexpr double part_in_null = 1e-3;  // a parameter with a smaller part in a null direction is determined
/// |r|^2 has the mean N - trace(J^T J H^-1), however small; where less is left than this, r is what the search leaves.
constexpr double least_freedom = 1e-3;
constexpr double part_unidentifiable = 0.1;  // of the greatest change: a smaller one is not worth a word

// Statistics of the estimate from the linearised problem at the minimum [SW89], in parts of the parameters' scales:
//   1. J diag(scale) = Q R; H = R^T R + P^2 with the prior's P; covariance H^-1 by a singular value decomposition of
//      [R; P] with columns of unit length. Directions below the rank tolerance are not determined.
//   2. Residuals larger than stated inflate the part of the variance that comes from the data, by the reduced
//      chi-squared: H^-1 + (inflation - 1) H^-1 R^T R H^-1. The prior's part is not inflated.
//   3. Directions that the data do not determine are given as combinations of as few parameters as can be.
//   4. Each parameter is judged: seen well, poorly (its deviation against the prior's), not at all, or held.
/// The linearised problem of the free parameters in parts of their scales: |r + R d|^2 + |P d|^2.
struct Linearised {
  std::vector<Index> free;   ///< parameters without equal bounds, and not at one
  VectorXd scale, prior;     ///< of the free ones; P = scale / deviation
  MatrixXd factor;           ///< R of the Jacobian
  std::vector<bool> unseen;  ///< column of zeros

  Linearised(const std::vector<UpdatingParameter>& parameters, const std::vector<bool>& at_bound,
             const MatrixXd& jacobian) {
    for (std::size_t i = 0; i < parameters.size(); ++i)
      if (parameters[i].lower < parameters[i].upper && !at_bound[i]) free.push_back(static_cast<Index>(i));
    const auto count = static_cast<Index>(free.size());
    scale.resize(count);
    prior.resize(count);
    for (Index k = 0; k < count; ++k) {
      const auto& p = parameters[static_cast<std::size_t>(free[static_cast<std::size_t>(k)])];
      scale[k] = p.scale();
      prior[k] = p.scale() / p.deviation;
    }
    const MatrixXd scaled = jacobian(Eigen::all, free) * scale.asDiagonal();
    const Index rows = std::min(count, scaled.rows());
    factor = MatrixXd::Zero(count, count);
    if (rows > 0)
      factor.topRows(rows) =
          Eigen::HouseholderQR<MatrixXd>(scaled).matrixQR().topRows(rows).triangularView<Eigen::Upper>();
    const VectorXd length = scaled.colwise().norm();
    for (Index k = 0; k < count; ++k) unseen.push_back(!(length[k] > zero_column * length.maxCoeff()));
  }
};

/// Inverse of H and which parameters it does not determine.
struct Inverse {
  MatrixXd matrix;  ///< of the free parameters; null directions enter with a large finite variance
  std::vector<bool> undetermined;
  double effective_parameters = 0.0;  ///< trace(J^T J H^-1)

  Inverse(const Linearised& problem, double rank_tolerance) {
    const Index count = problem.factor.cols();
    undetermined.assign(static_cast<std::size_t>(count), false);
    matrix = MatrixXd::Zero(count, count);
    if (count == 0) return;
    MatrixXd both(2 * count, count);
    both << problem.factor, MatrixXd(problem.prior.asDiagonal());
    VectorXd length = both.colwise().norm();
    length = (length.array() > 0.0).select(length, 1.0);
    both *= length.cwiseInverse().asDiagonal();
    const Eigen::JacobiSVD<MatrixXd> svd(both, Eigen::ComputeThinV);
    const VectorXd& sigma = svd.singularValues();
    const double least = sigma[0] > 0.0 ? rank_tolerance * sigma[0] : rank_tolerance;
    const MatrixXd directions = length.cwiseInverse().asDiagonal() * svd.matrixV();
    for (Index k = 0; k < count; ++k) {
      const VectorXd direction = directions.col(k) / std::max(sigma[k], least);
      matrix += direction * direction.transpose();
      if (sigma[k] > least)
        effective_parameters += (problem.factor * direction).squaredNorm();
      else
        for (Index i = 0; i < count; ++i)
          if (std::abs(svd.matrixV()(i, k)) > part_in_null) undetermined[static_cast<std::size_t>(i)] = true;
    }
  }
};

/// The same space of directions, each with as few parameters as can be (elimination with complete pivoting).
void make_sparse(MatrixXd& directions) {
  for (Index done = 0; done < directions.cols(); ++done) {
    Index row = 0, column = 0;
    directions.rightCols(directions.cols() - done).cwiseAbs().maxCoeff(&row, &column);
    directions.col(done).swap(directions.col(done + column));
    directions.col(done) /= directions(row, done);
    for (Index other = 0; other < directions.cols(); ++other)
      if (other != done) directions.col(other) -= (directions(row, other) * directions.col(done)).eval();
  }
}

/// Directions in which the residual tells less than the prior, or in which both leave a deviation of a whole scale.
MatrixXd unidentifiable_directions(const Linearised& problem, double variance_inflation,
                                   const ParameterStatisticsOptions& options) {
  std::vector<Index> seen;
  for (Index k = 0; k < problem.factor.cols(); ++k)
    if (!problem.unseen[static_cast<std::size_t>(k)]) seen.push_back(k);
  const auto count = static_cast<Index>(seen.size());
  if (count == 0) return {problem.factor.cols(), 0};
  const Eigen::JacobiSVD<MatrixXd> svd(MatrixXd(problem.factor(Eigen::all, seen)), Eigen::ComputeThinV);
  MatrixXd found = MatrixXd::Zero(problem.factor.cols(), count);
  Index unidentifiable = 0;
  for (Index k = 0; k < count; ++k) {
    const double sigma = svd.singularValues()[k], told = sigma / std::sqrt(variance_inflation);
    const double prior = problem.prior(seen).cwiseProduct(svd.matrixV().col(k)).norm();
    const bool null = sigma <= options.rank_tolerance * svd.singularValues()[0];
    const bool below_prior = prior > options.poor_ratio * std::hypot(told, prior);
    const bool below_scale = std::hypot(told, prior) * options.poor_deviation < 1.0;
    if (!null && !below_prior && !below_scale) continue;
    for (std::size_t i = 0; i < seen.size(); ++i)
      found(seen[i], unidentifiable) = svd.matrixV()(static_cast<Index>(i), k);
    ++unidentifiable;
  }
  found.conservativeResize(Eigen::NoChange, unidentifiable);
  make_sparse(found);
  return found;
}

/// Names the parameters of a unidentifiable direction. One alone is poorly seen, but no combination.
void add_unidentifiable(ParameterStatistics& statistics, const Linearised& problem, const VectorXd& direction) {
  std::vector<Index> order;
  for (Index k = 0; k < direction.size(); ++k)
    if (std::abs(direction[k]) > part_unidentifiable * direction.cwiseAbs().maxCoeff()) order.push_back(k);
  std::stable_sort(order.begin(), order.end(),
                   [&](Index a, Index b) { return std::abs(direction[a]) > std::abs(direction[b]); });
  UnidentifiableCombination combination;
  for (const Index k : order) {
    const Index parameter = problem.free[static_cast<std::size_t>(k)];
    combination.parameters.push_back(parameter);
    combination.changes.push_back(direction[k] / direction[order.front()]);
    statistics.seen[static_cast<std::size_t>(parameter)] = Seen::poorly;
  }
  if (order.size() > 1) statistics.unidentifiable.push_back(std::move(combination));
}

bool is_unidentifiable_pair(const ParameterStatistics& statistics, Index first, Index second) {
  return std::any_of(statistics.unidentifiable.begin(), statistics.unidentifiable.end(),
                     [&](const UnidentifiableCombination& combination) {
                       const auto has = [&](Index i) {
                         return std::find(combination.parameters.begin(), combination.parameters.end(), i) !=
                                combination.parameters.end();
                       };
                       return has(first) && has(second);
                     });
}

/// Fills in deviations, covariance and correlation of all parameters from those of the free ones.
void fill_covariance(ParameterStatistics& statistics, const Linearised& problem, const MatrixXd& covariance,
                     const std::vector<bool>& undetermined) {
  for (std::size_t a = 0; a < problem.free.size(); ++a)
    for (std::size_t b = 0; b < problem.free.size(); ++b) {
      const auto at = static_cast<Index>(a), bt = static_cast<Index>(b);
      const Index i = problem.free[a], j = problem.free[b];
      const double product = std::sqrt(covariance(at, at) * covariance(bt, bt));
      statistics.correlation(i, j) = i == j ? 1.0 : covariance(at, bt) / product;
      if (!undetermined[a] && !undetermined[b])
        statistics.covariance(i, j) = covariance(at, bt) * problem.scale[at] * problem.scale[bt];
      else if (i == j)
        statistics.covariance(i, j) = std::numeric_limits<double>::infinity();
    }
  statistics.deviations = statistics.covariance.diagonal().cwiseSqrt();
  for (std::size_t i = 0; i < statistics.at_bound.size(); ++i)
    if (statistics.at_bound[i]) statistics.deviations[static_cast<Index>(i)] = std::nan("");
}

/// Whether the gradient of cost and prior pulls a parameter beyond a bound that it stands at; standing there by chance
/// is no finding.
std::vector<bool> held_by_bounds(const std::vector<UpdatingParameter>& parameters, const VectorXd& values,
                                 const VectorXd& gradient) {
  std::vector<bool> held;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const auto at = static_cast<Index>(i);
    const auto& [name, unit, initial, lower, upper, prior] = parameters[i];
    const double pull = gradient[at] + (values[at] - initial) / (prior * prior);
    held.push_back(lower < upper && ((values[at] == lower && pull > 0.0) || (values[at] == upper && pull < 0.0)));
  }
  return held;
}

void judge_parameters(ParameterStatistics& statistics, const std::vector<UpdatingParameter>& parameters,
                      const ParameterStatisticsOptions& options) {
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const auto at = static_cast<Index>(i);
    if (statistics.seen[i] == Seen::held) continue;
    const double deviation = statistics.deviations[at], prior = parameters[i].deviation;
    if (std::isfinite(prior)) statistics.to_prior[at] = deviation / prior;
    const bool poorly = std::isfinite(prior) ? statistics.to_prior[at] > options.poor_ratio
                                             : deviation > options.poor_deviation * parameters[i].scale();
    if (poorly) statistics.seen[i] = Seen::poorly;
  }
}

void find_correlated(ParameterStatistics& statistics, double high) {
  const Index count = statistics.correlation.rows();
  for (Index i = 0; i < count; ++i)
    for (Index j = i + 1; j < count; ++j)
      if (std::abs(statistics.correlation(i, j)) > high && !is_unidentifiable_pair(statistics, i, j))
        statistics.correlated.push_back({i, j, statistics.correlation(i, j)});
}

}  // namespace

ParameterStatistics parameter_statistics(const std::vector<UpdatingParameter>& parameters, const VectorXd& values,
                                         const ResidualValue& value, const ParameterStatisticsOptions& options) {
  const auto count = static_cast<Index>(parameters.size());
  assert(value.jacobian.cols() == count && value.jacobian.rows() == value.values.size());
  ParameterStatistics statistics;
  statistics.at_bound = held_by_bounds(parameters, values, value.jacobian.transpose() * value.values);
  const Linearised problem(parameters, statistics.at_bound, value.jacobian);
  const Inverse inverse(problem, options.rank_tolerance);
  statistics.covariance = statistics.correlation = MatrixXd::Zero(count, count);
  statistics.to_prior = VectorXd::Zero(count);
  statistics.seen.assign(parameters.size(), Seen::held);
  for (const Index i : problem.free) statistics.seen[static_cast<std::size_t>(i)] = Seen::well;

  statistics.degrees_of_freedom = static_cast<double>(value.values.size()) - inverse.effective_parameters;
  if (statistics.degrees_of_freedom >= 1.0)
    statistics.reduced_chi_squared = value.values.squaredNorm() / statistics.degrees_of_freedom;
  if (statistics.degrees_of_freedom >= least_freedom)
    statistics.variance_inflation = std::max(1.0, value.values.squaredNorm() / statistics.degrees_of_freedom);

  const MatrixXd told = problem.factor * inverse.matrix;
  fill_covariance(statistics, problem, inverse.matrix + (statistics.variance_inflation - 1.0) * told.transpose() * told,
                  inverse.undetermined);
  const MatrixXd unidentifiable = unidentifiable_directions(problem, statistics.variance_inflation, options);
  for (Index k = 0; k < unidentifiable.cols(); ++k) add_unidentifiable(statistics, problem, unidentifiable.col(k));
  judge_parameters(statistics, parameters, options);
  for (std::size_t k = 0; k < problem.free.size(); ++k)
    if (problem.unseen[k]) statistics.seen[static_cast<std::size_t>(problem.free[k])] = Seen::not_at_all;
  find_correlated(statistics, options.high_correlation);
  return statistics;
}

namespace {

using Parameters = std::vector<UpdatingParameter>;

constexpr double notable_inflation = 1.5;  // of variances: below it, mere chance or not worth a word

// A finding is one sentence for the user: a parameter that the residual does not see, sees poorly, or that ended at a
// bound; combinations that cannot be told apart; pairs that are highly correlated; residuals larger than stated. A
// parameter that is part of an unidentifiable combination is named there only.
const UpdatingParameter& at(const Parameters& parameters, Index i) { return parameters[static_cast<std::size_t>(i)]; }

/// "a", "a and b", "a, b and c"
std::string listed(const std::vector<std::string>& items) {
  std::string text;
  for (std::size_t i = 0; i < items.size(); ++i)
    text += (i == 0 ? "" : i + 1 == items.size() ? " and " : ", ") + items[i];
  return text;
}

/// "rails.E by +10 %", or in units where a percentage has no meaning.
std::string change_in_words(const UpdatingParameter& p, double parts) {
  if (p.initial != 0.0) return fmt::format("{} by {:+.2g} %", p.name, 100.0 * parts);
  return fmt::format("{} by {:+.2g} {}", p.name, parts * p.scale(), p.unit);
}

std::string unidentifiable_in_words(const UnidentifiableCombination& combination, const Parameters& parameters) {
  constexpr double shown = 0.1;  // size of the greatest change in the sentence
  std::vector<std::string> names, changes;
  for (std::size_t k = 0; k < combination.parameters.size(); ++k) {
    const auto& parameter = at(parameters, combination.parameters[k]);
    names.push_back(parameter.name);
    changes.push_back(change_in_words(parameter, shown * combination.changes[k]));
  }
  std::vector<std::string> without_prior;
  for (const Index i : combination.parameters)
    if (!std::isfinite(at(parameters, i).deviation)) without_prior.push_back(at(parameters, i).name);
  const std::string told_apart_by =
      without_prior.empty()
          ? "their priors decide how it is shared: fix one of them or add measurements that separate them"
          : fmt::format(
                "fix one of them, state a prior of {} (std), or add measurements that separate "
                "them",
                listed(without_prior));
  return fmt::format("{} cannot be identified separately: changing {} together hardly changes the residual; {}",
                     listed(names), listed(changes), told_apart_by);
}

bool is_unidentifiable(const ParameterStatistics& statistics, Index i) {
  for (const auto& combination : statistics.unidentifiable)
    for (const Index member : combination.parameters)
      if (member == i) return true;
  return false;
}

std::string poorly_in_words(const UpdatingParameter& p, const ParameterStatistics& statistics, Index i) {
  if (std::isfinite(p.deviation))
    return fmt::format(
        "the data hardly identify {}: its standard deviation is {:.0f} % of the prior's, so its value comes mostly "
        "from the prior",
        p.name, 100.0 * statistics.to_prior[i]);
  if (!std::isfinite(statistics.deviations[i]))
    return fmt::format("the data do not identify {}: it has no finite standard deviation", p.name);
  return fmt::format("the data hardly identify {}: its standard deviation is {:.2g} {}", p.name,
                     statistics.deviations[i], p.unit);
}

std::string bound_in_words(const UpdatingParameter& p, double value) {
  return fmt::format(
      "{} ended at its {} bound, {:g} {}: the residual would be smaller beyond it; it has no standard deviation, and "
      "those of the others hold with it there",
      p.name, value == p.lower ? "lower" : "upper", value, p.unit);
}

}  // namespace

std::vector<std::string> parameter_findings(const Parameters& parameters, const Eigen::VectorXd& values,
                                            const ParameterStatistics& statistics) {
  std::vector<std::string> findings;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const auto index = static_cast<Index>(i);
    if (statistics.seen[i] == Seen::not_at_all)
      findings.push_back(parameters[i].name +
                         " cannot be identified: no measurement depends on it, so it keeps its initial value");
    if (statistics.seen[i] == Seen::poorly && !is_unidentifiable(statistics, index))
      findings.push_back(poorly_in_words(parameters[i], statistics, index));
    if (statistics.at_bound[i]) findings.push_back(bound_in_words(parameters[i], values[index]));
  }
  for (const auto& combination : statistics.unidentifiable)
    findings.push_back(unidentifiable_in_words(combination, parameters));
  for (const auto& [first, second, correlation] : statistics.correlated)
    findings.push_back(
        fmt::format("{} and {} have a correlation of {:.4f}: an error of one is compensated by the other",
                    at(parameters, first).name, at(parameters, second).name, correlation));
  if (statistics.variance_inflation > notable_inflation)
    findings.push_back(
        fmt::format("residuals are {:.2g} times as large as the stated standard deviations: the standard deviations of "
                    "the parameters are increased accordingly",
                    std::sqrt(statistics.variance_inflation)));
  return findings;
}

// Before the search: a parameter whose column is rounding beside the largest cannot be found, whatever the data say.
std::vector<std::string> without_effect(const Parameters& parameters, const Eigen::MatrixXd& jacobian) {
  constexpr double rounding = 1e-10;  // of the largest column
  std::vector<std::string> names;
  Eigen::VectorXd effects = jacobian.colwise().norm();
  for (std::size_t i = 0; i < parameters.size(); ++i) effects[static_cast<Index>(i)] *= parameters[i].scale();
  for (std::size_t i = 0; i < parameters.size(); ++i)
    if (parameters[i].lower < parameters[i].upper && effects[static_cast<Index>(i)] <= rounding * effects.maxCoeff())
      names.push_back(parameters[i].name);
  return names;
}

}  // namespace kalfem
