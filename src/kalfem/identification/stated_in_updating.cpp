// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/stated_in_updating.hpp"

#include <algorithm>
#include <cmath>

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// dr/d(theta, c) of the comparisons at one point, a number counted in its scale.
struct WideDerivatives {
  MatrixXd by_parameters, by_numbers;
};

class WideComparisons {
public:
  WideComparisons(const std::vector<FixedNumber>& numbers, const std::vector<ResidualSum::Term>& terms)
      : numbers_(numbers), terms_(terms) {}

  /// `changes`: of the numbers, in their scales; gains keep theirs. Nothing where the model has no response.
  [[nodiscard]] std::optional<WideDerivatives> at(const VectorXd& values, const VectorXd& changes) const {
    std::vector<double> all(values.begin(), values.end());
    Index rows = 0;
    for (std::size_t i = 0; i < numbers_.size(); ++i)
      if (numbers_[i].parameter) all.push_back(numbers_[i].value + numbers_[i].scale * changes[static_cast<Index>(i)]);
    for (const auto& term : terms_) rows += term.residual->size();
    WideDerivatives found{MatrixXd(rows, values.size()), MatrixXd::Zero(rows, std::ssize(numbers_))};
    Index row = 0;
    for (const auto& [residual, weight] : terms_) {
      if (!add(*residual, std::sqrt(weight), VectorXd::Map(all.data(), std::ssize(all)), row, found))
        return std::nullopt;
      row += residual->size();
    }
    return found;
  }

private:
  bool add(const Residual& residual, double factor, const VectorXd& all, Index row, WideDerivatives& found) const {
    const auto value = residual.evaluate(all, true);
    const auto by_gain = residual.by_gains(all);
    if (!value || !by_gain) return false;
    const auto gains = residual.gains();
    const Index size = residual.size(), updated = found.by_parameters.cols();
    found.by_parameters.middleRows(row, size) = factor * value->jacobian.leftCols(updated);
    Index column = updated;
    for (std::size_t i = 0; i < numbers_.size(); ++i) {
      auto by = found.by_numbers.col(static_cast<Index>(i)).segment(row, size);
      const auto own = std::ranges::find(gains, numbers_[i].name, &ComparedGain::name);
      if (numbers_[i].parameter)
        by = factor * numbers_[i].scale * value->jacobian.col(column++);
      else if (own != gains.end())
        by = factor * numbers_[i].scale * by_gain->col(own - gains.begin());
    }
    return true;
  }

  const std::vector<FixedNumber>& numbers_;
  const std::vector<ResidualSum::Term>& terms_;
};

VectorXd within_bounds(const std::vector<UpdatingParameter>& parameters, VectorXd values) {
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    double& value = values[static_cast<Index>(i)];
    value = std::clamp(value, parameters[i].lower, parameters[i].upper);
  }
  return values;
}

}  // namespace

UpdatingSetup with_numbers(UpdatingSetup updating, const std::vector<FixedNumber>& numbers) {
  for (const auto& number : numbers) {
    if (!number.parameter) continue;
    updating.bindings.push_back({std::ssize(updating.parameters), *number.parameter});
    updating.parameters.push_back({.name = number.name, .unit = number.unit, .initial = number.value});
    updating.true_parameters.emplace_back();
  }
  return updating;
}

std::vector<StructureBinding> connectors_of(const std::vector<StructureBinding>& bindings) {
  std::vector<StructureBinding> own;
  std::ranges::copy_if(bindings, std::back_inserter(own),
                       [](const StructureBinding& each) { return each.target.of_connector(); });
  return own;
}

std::optional<Considered> consider_stated(const std::vector<FixedNumber>& numbers,
                                          const std::vector<UpdatingParameter>& parameters, const VectorXd& values,
                                          const ParameterStatistics& statistics, const ResidualValue& value,
                                          const std::vector<ResidualSum::Term>& wide) {
  VectorXd sigma(std::ssize(numbers));
  for (std::size_t i = 0; i < numbers.size(); ++i) sigma[static_cast<Index>(i)] = numbers[i].deviation;
  const WideComparisons comparisons(numbers, wide);
  const auto here = comparisons.at(values, VectorXd::Zero(sigma.size()));
  if (!here) return std::nullopt;
  const Considered first = consider(parameters, statistics, value, here->by_numbers, sigma);
  const auto between =
      comparisons.at(within_bounds(parameters, values + 0.5 * first.shift * first.allowed), 0.5 * first.allowed);
  if (!between) return first;
  return consider(parameters, statistics, {value.values, between->by_parameters}, between->by_numbers, sigma);
}

}  // namespace kalfem
