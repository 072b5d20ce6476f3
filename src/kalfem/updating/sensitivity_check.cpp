// SPDX-License-Identifier: Apache-2.0
#include "kalfem/updating/sensitivity_check.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <fmt/format.h>

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using Verdict = SensitivityComparison::Verdict;

// Derivatives by Ridders' method [Rid82]: difference quotients for steps h, h/2, h/4 ... extrapolated to zero step
// (Richardson), and the entry of the tableau that agrees best with its neighbours is taken, with that difference as its
// error.
struct Derivative {
  VectorXd value;
  double error = std::numeric_limits<double>::infinity();  ///< estimated, of the greatest entry
};

/// The residual along one parameter.
class Line {
public:
  Line(const Residual& residual, const VectorXd& values, Index parameter, const UpdatingParameter& bounds)
      : residual_(residual),
        values_(values),
        parameter_(parameter),
        below_(values[parameter] - bounds.lower),
        above_(bounds.upper - values[parameter]) {}

  /// Difference quotient with an error of order step^2: central where the bounds leave room, else one-sided.
  [[nodiscard]] std::optional<VectorXd> quotient(double step) const {
    if (step <= below_ && step <= above_) {
      const auto left = at(-step), right = at(step);
      if (!left || !right) return std::nullopt;
      return (*right - *left) / (2.0 * step);
    }
    const double inwards = above_ >= below_ ? step : -step;
    const auto here = at(0.0), near = at(inwards), far = at(2.0 * inwards);
    if (!here || !near || !far) return std::nullopt;
    return (-3.0 * *here + 4.0 * *near - *far) / (2.0 * inwards);
  }

  /// The longest step not above `wanted` for which quotient() keeps within the bounds.
  [[nodiscard]] double within_bounds(double wanted) const {
    const double central = std::min(below_, above_), one_sided = 0.5 * std::max(below_, above_);
    return wanted <= central ? wanted : std::min(wanted, std::max(central, one_sided));
  }

private:
  [[nodiscard]] std::optional<VectorXd> at(double change) const {
    VectorXd point = values_;
    point[parameter_] += change;
    auto value = residual_.evaluate(point, false);
    if (!value || !value->values.allFinite()) return std::nullopt;
    return std::move(value->values);
  }

  const Residual& residual_;
  const VectorXd& values_;
  Index parameter_;
  double below_, above_;  ///< room to the bounds
};

/// Row of the tableau that extrapolates quotients of steps h, h/2, h/4 ... to zero, one more entry than the row before.
std::vector<VectorXd> extrapolated(const std::vector<VectorXd>& before, VectorXd quotient) {
  std::vector<VectorXd> row{std::move(quotient)};
  double power = 4.0;
  for (const auto& coarser : before) {
    row.push_back(row.back() + (row.back() - coarser) / (power - 1.0));
    power *= 4.0;
  }
  return row;
}

/// Derivative along a line; nothing where the model has no response beside the point.
std::optional<Derivative> derivative(const Line& line, double first_step, int halvings) {
  Derivative best;
  std::vector<VectorXd> before;
  double step = line.within_bounds(first_step);
  for (int k = 0; k <= halvings; ++k, step *= 0.5) {
    auto quotient = line.quotient(step);
    if (!quotient) {  // begin again nearer to the point
      before.clear();
      continue;
    }
    auto row = extrapolated(before, std::move(*quotient));
    for (std::size_t j = 1; j < row.size(); ++j) {
      const double error =
          std::max((row[j] - row[j - 1]).lpNorm<Eigen::Infinity>(), (row[j] - before[j - 1]).lpNorm<Eigen::Infinity>());
      if (error <= best.error) best = {row[j], error};
    }
    before = std::move(row);
  }
  return best.value.size() > 0 ? std::optional(std::move(best)) : std::nullopt;
}

/// Differences known to less than this say nothing about a derivative: where a residual is rough, two tableaus may
/// differ by more than their estimated error.
constexpr double most_uncertainty = 0.1;

SensitivityComparison compare(const VectorXd& column, const std::optional<Derivative>& differences, double tolerance) {
  SensitivityComparison comparison;
  comparison.verdict = Verdict::no_response;
  if (!differences) return comparison;
  const double largest = differences->value.lpNorm<Eigen::Infinity>(), reference = largest > 0.0 ? largest : 1.0;
  comparison.deviation = (column - differences->value).cwiseAbs().maxCoeff(&comparison.row) / reference;
  comparison.uncertainty = differences->error / reference;
  if (std::isfinite(comparison.deviation) && comparison.uncertainty > std::max(tolerance, most_uncertainty))
    comparison.verdict = Verdict::undecided;
  else if (!std::isfinite(comparison.deviation) || comparison.deviation > tolerance + comparison.uncertainty)
    comparison.verdict = Verdict::deviates;
  else
    comparison.verdict = comparison.uncertainty > tolerance ? Verdict::undecided : Verdict::agrees;
  return comparison;
}

}  // namespace

std::string explain(Verdict verdict) {
  switch (verdict) {
    case Verdict::agrees:
      return "agrees with differences";
    case Verdict::deviates:
      return "deviates from differences";
    case Verdict::undecided:
      return "undecided: the differences scatter";
    case Verdict::no_response:
      return "not checked: the model has no response beside the point";
  }
  return {};
}

namespace {

std::string listed(const std::vector<SensitivityComparison>& comparisons, std::initializer_list<Verdict> wanted) {
  std::string names;
  for (const auto& each : comparisons)
    if (std::ranges::find(wanted, each.verdict) != wanted.end())
      names += (names.empty() ? "'" : ", '") + each.parameter + "'";
  return names;
}

}  // namespace

std::string explain_stall(const std::vector<SensitivityComparison>& comparisons) {
  if (const auto wrong = listed(comparisons, {Verdict::deviates}); !wrong.empty()) {
    double largest = 0.0;
    for (const auto& each : comparisons)
      if (each.verdict == Verdict::deviates) largest = std::max(largest, each.deviation);
    return fmt::format("there, the derivatives by {} differ from finite differences by up to {:.2g} %", wrong,
                       100.0 * largest);
  }
  if (const auto rough = listed(comparisons, {Verdict::undecided, Verdict::no_response}); !rough.empty())
    return "there, finite differences by " + rough + " scatter: the residual is not smooth";
  return "there, the derivatives agree with finite differences: the residual is not smooth over short steps";
}

// A deviation counts only beyond the differences' own estimated error; where that error exceeds the tolerance, nothing
// can be said.
std::vector<SensitivityComparison> check_sensitivities(const Residual& residual,
                                                       const std::vector<UpdatingParameter>& parameters,
                                                       const VectorXd& values, const SensitivityCheckOptions& options) {
  std::vector<SensitivityComparison> comparisons;
  const auto analytic = residual.evaluate(values, true);
  if (!analytic) return comparisons;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const auto& parameter = parameters[i];
    if (!(parameter.lower < parameter.upper)) continue;
    const auto at = static_cast<Index>(i);
    const Line line(residual, values, at, parameter);
    comparisons.push_back(compare(analytic->jacobian.col(at),
                                  derivative(line, options.first_step * parameter.scale(), options.halvings),
                                  options.tolerance));
    comparisons.back().parameter = parameter.name;
  }
  return comparisons;
}

}  // namespace kalfem
