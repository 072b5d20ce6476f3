// SPDX-License-Identifier: Apache-2.0
#include "kalfem/information/identifiability.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double rounding = 1e-12;  ///< of the largest eigenvalue: smaller ones are zero

/// With ones on the diagonal where the parameter is informed.
MatrixXd scaled(const MatrixXd& information) {
  const VectorXd scale =
      information.diagonal().unaryExpr([](double value) { return value > 0.0 ? 1.0 / std::sqrt(value) : 1.0; });
  return scale.asDiagonal() * information * scale.asDiagonal();
}

void check(const MatrixXd& information, const std::vector<InformedParameter>& parameters) {
  IssueList issues;
  const auto n = static_cast<Index>(parameters.size());
  if (n == 0 || information.rows() != n || information.cols() != n) {
    issues.add(
        {},
        fmt::format("an information matrix of {} x {} for {} parameters", information.rows(), information.cols(), n),
        "it has a row and a column for each", "");
    issues.raise();
  }
  if (!information.allFinite() ||
      !(information - information.transpose()).isZero(1e-8 * information.cwiseAbs().maxCoeff()))
    issues.add({}, "the information matrix is not finite and symmetric", "it is a covariance of scores", "");
  else if (const double least = Eigen::SelfAdjointEigenSolver<MatrixXd>(scaled(information)).eigenvalues()[0];
           least < -1e-8)
    issues.add({}, fmt::format("the information matrix has the relative eigenvalue {:.2g}", least),
               "it is a covariance of scores, never negative", "");
  for (const auto& [name, value, deviation] : parameters) {
    if (!std::isfinite(value) || !(deviation > 0.0))
      issues.add({}, fmt::format("'{}' has the value {} and the prior deviation {}", name, value, deviation),
                 "the value must be finite and the deviation positive", "without a prior, give infinity");
    else if (value == 0.0 && std::isinf(deviation))
      issues.add({}, fmt::format("'{}' is zero and has no prior", name), "nothing tells its scale",
                 "give it a prior deviation");
  }
  issues.raise();
}

VectorXd scales(const std::vector<InformedParameter>& parameters) {
  VectorXd scale(static_cast<Index>(parameters.size()));
  for (Index i = 0; i < scale.size(); ++i) {
    const auto& [name, value, deviation] = parameters[static_cast<std::size_t>(i)];
    scale[i] = std::isfinite(deviation) ? deviation : std::abs(value);
  }
  return scale;
}

/// The ratio of small integers near `value`, zero among them.
std::optional<double> simple_ratio(double value, const IdentifiabilityOptions& options) {
  for (int denominator = 1; denominator <= options.largest_exponent; ++denominator) {
    const double numerator = std::round(value * denominator);
    if (std::abs(numerator) <= options.largest_exponent &&
        std::abs(numerator / denominator - value) <= options.exponent_error)
      return numerator / denominator;
  }
  return {};
}

/// Exponents e of prod theta_i^e_i along a direction of the logarithms, the largest 1; empty where they are not simple.
std::vector<double> exponents_of(const VectorXd& logarithmic, const IdentifiabilityOptions& options) {
  Index largest = 0;
  logarithmic.cwiseAbs().maxCoeff(&largest);
  std::vector<double> exponents;
  for (const double each : logarithmic) {
    const auto simple = simple_ratio(each / logarithmic[largest], options);
    if (!simple) return {};
    exponents.push_back(*simple);
  }
  return exponents;
}

std::string power(const std::string& name, double exponent) {
  return exponent == 1.0 ? name : fmt::format("{}^{:.3g}", name, exponent);
}

/// "k / m", "a b^2 / c"
std::string product(const std::vector<double>& exponents, const std::vector<InformedParameter>& parameters) {
  std::string above, below;
  for (std::size_t i = 0; i < exponents.size(); ++i)
    if (exponents[i] != 0.0) {
      std::string& side = exponents[i] > 0.0 ? above : below;
      side += (side.empty() ? "" : " ") + power(parameters[i].name, std::abs(exponents[i]));
    }
  return (above.empty() ? "1" : above) + (below.empty() ? "" : " / " + below);
}

std::string joined(const std::vector<std::string>& names) {
  std::string text = names.front();
  for (std::size_t i = 1; i < names.size(); ++i) text += (i + 1 == names.size() ? " and " : ", ") + names[i];
  return text;
}

std::vector<std::string> members(const VectorXd& direction, const std::vector<InformedParameter>& parameters,
                                 double significant) {
  std::vector<std::string> names;
  for (Index i = 0; i < direction.size(); ++i)
    if (std::abs(direction[i]) >= significant * direction.cwiseAbs().maxCoeff())
      names.push_back(parameters[static_cast<std::size_t>(i)].name);
  return names;
}

class Judgement {
public:
  Judgement(const MatrixXd& information, const std::vector<InformedParameter>& parameters,
            const IdentifiabilityOptions& options)
      : options_(options) {
    result_.parameters = parameters;
    result_.scale = scales(parameters);
    scaled_ = result_.scale.asDiagonal() * information * result_.scale.asDiagonal();
    prior_ = VectorXd::Zero(scaled_.rows());
    for (Index i = 0; i < prior_.size(); ++i)
      prior_[i] = std::isfinite(parameters[static_cast<std::size_t>(i)].prior_deviation) ? 1.0 : 0.0;
  }

  Identifiability judge() {
    combine();
    result_.cramer_rao = deviations(scaled_).cwiseProduct(result_.scale);
    const MatrixXd posterior = scaled_ + MatrixXd(prior_.asDiagonal());
    result_.posterior_deviation = deviations(posterior).cwiseProduct(result_.scale);
    result_.posterior_correlation = correlation(posterior);
    say();
    return std::move(result_);
  }

private:
  [[nodiscard]] static double floor_of(const VectorXd& eigenvalues) {
    return rounding * std::max(eigenvalues.maxCoeff(), std::numeric_limits<double>::min());
  }

  /// Square roots of the diagonal of the inverse; infinite along directions without information.
  [[nodiscard]] static VectorXd deviations(const MatrixXd& information) {
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(information);
    const double floor = floor_of(eigen.eigenvalues());
    VectorXd variance = VectorXd::Zero(information.rows());
    for (Index j = 0; j < variance.size(); ++j)
      for (Index i = 0; i < variance.size(); ++i) {
        const double share = eigen.eigenvectors()(i, j) * eigen.eigenvectors()(i, j);
        if (eigen.eigenvalues()[j] > floor)
          variance[i] += share / eigen.eigenvalues()[j];
        else if (share > rounding)
          variance[i] = infinity;
      }
    return variance.cwiseSqrt();
  }

  /// Of the determined directions.
  [[nodiscard]] static MatrixXd correlation(const MatrixXd& information) {
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(information);
    const double floor = floor_of(eigen.eigenvalues());
    const VectorXd inverse = eigen.eigenvalues().unaryExpr([&](double value) { return 1.0 / std::max(value, floor); });
    const MatrixXd covariance = eigen.eigenvectors() * inverse.asDiagonal() * eigen.eigenvectors().transpose();
    const VectorXd deviation = covariance.diagonal().cwiseSqrt();
    return covariance.cwiseQuotient(deviation * deviation.transpose());
  }

  void combine() {
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(scaled_);
    const double floor = floor_of(eigen.eigenvalues());
    for (Index j = scaled_.rows(); j-- > 0;) {
      const double value = eigen.eigenvalues()[j];
      ParameterCombination combination{.direction = eigen.eigenvectors().col(j)};
      Index largest = 0;
      combination.direction.cwiseAbs().maxCoeff(&largest);
      if (combination.direction[largest] < 0.0) combination.direction *= -1.0;
      combination.deviation = value > floor ? 1.0 / std::sqrt(value) : infinity;
      const double prior = combination.direction.cwiseAbs2().dot(prior_);
      combination.posterior_deviation =
          std::max(value, 0.0) + prior > floor ? 1.0 / std::sqrt(std::max(value, 0.0) + prior) : infinity;
      combination.determined = combination.deviation < options_.weak;
      combination.exponents = exponents_along(combination);
      result_.combinations.push_back(std::move(combination));
    }
  }

  /// Of a determined combination those of the product that grows along it: d ln f = sum e_i d ln theta_i = sum e_i
  /// (scale_i / value_i) dq_i, whose gradient is the direction. Of another those by which parameters move along it:
  /// d ln theta_i = (scale_i / value_i) dq_i.
  [[nodiscard]] std::vector<double> exponents_along(const ParameterCombination& combination) const {
    VectorXd logarithmic = combination.direction;
    for (Index i = 0; i < logarithmic.size(); ++i) {
      const double at = result_.parameters[static_cast<std::size_t>(i)].value;
      if (!(at > 0.0)) return {};
      logarithmic[i] *= combination.determined ? at / result_.scale[i] : result_.scale[i] / at;
    }
    return exponents_of(logarithmic, options_);
  }

  void say() {
    for (auto& combination : result_.combinations)
      combination.words = combination.determined ? determined(combination) : undetermined(combination);
    for (const auto& combination : result_.combinations)
      if (!combination.determined) result_.text += (result_.text.empty() ? "" : " ") + combination.words;
    if (result_.text.empty()) result_.text = fmt::format("The {} determines every parameter.", options_.data);
  }

  [[nodiscard]] std::vector<std::string> names_of(const ParameterCombination& combination) const {
    return members(combination.direction, result_.parameters, options_.significant);
  }

  [[nodiscard]] std::string determined(const ParameterCombination& combination) const {
    const auto names = names_of(combination);
    if (names.size() == 1)
      return fmt::format("The {} determines {} to {:.2g} of its {}.", options_.data, names.front(),
                         combination.deviation, unit());
    if (!combination.exponents.empty())
      return fmt::format("The {} determines {}.", options_.data, product(combination.exponents, result_.parameters));
    return fmt::format("The {} determines a combination of {} to {:.2g} {}s.", options_.data, joined(names),
                       combination.deviation, unit());
  }

  [[nodiscard]] std::string undetermined(const ParameterCombination& combination) const {
    const auto names = names_of(combination);
    if (names.size() == 1) return little_of(combination);
    const bool nothing = std::isinf(combination.deviation);
    if (is_common_factor(combination, names.size()))
      return fmt::format(
          "Only {} determined: the {} {} when {} are multiplied by the same factor.",
          names.size() == 2 ? names[0] + " / " + names[1] + " is" : "ratios of " + joined(names) + " are",
          options_.data, nothing ? "does not change" : "hardly changes", names.size() == 2 ? "both" : "all");
    const std::string by = nothing ? "without any limit" : fmt::format("by {:.2g} {}s", combination.deviation, unit());
    return fmt::format("{} cannot be told apart: they may move together {}.", joined(names), by);
  }

  /// Whether all that move do so in proportion to their values.
  [[nodiscard]] bool is_common_factor(const ParameterCombination& combination, std::size_t moving) const {
    const auto ones = std::ranges::count(combination.exponents, 1.0);
    return static_cast<std::size_t>(ones) == moving &&
           ones + std::ranges::count(combination.exponents, 0.0) == std::ssize(combination.exponents);
  }

  /// Of a combination that is one parameter.
  [[nodiscard]] std::string little_of(const ParameterCombination& combination) const {
    Index i = 0;
    combination.direction.cwiseAbs().maxCoeff(&i);
    const auto& name = result_.parameters[static_cast<std::size_t>(i)].name;
    const std::string start = fmt::format("The {} says {} of {}", options_.data,
                                          std::isinf(combination.deviation) ? "nothing" : "little", name);
    const double left = result_.posterior_deviation[i] / result_.scale[i];
    const std::string why = "the excitation is too weak for it, no sensor sees it, or another parameter acts alike";
    if (prior_[i] > 0.0)
      return fmt::format("{}: its deviation stays {:.0f} % of the prior's; {}.", start, 100.0 * left, why);
    if (std::isinf(left)) return fmt::format("{}: {}.", start, why);
    return fmt::format("{}: its deviation is {:.0f} % of its value; {}.", start, 100.0 * left, why);
  }

  /// Of the scaled parameters, in words.
  [[nodiscard]] std::string unit() const {
    if (prior_.minCoeff() == 1.0) return "prior deviation";
    return prior_.maxCoeff() == 0.0 ? "value" : "scale";
  }

  const IdentifiabilityOptions& options_;
  MatrixXd scaled_;
  VectorXd prior_;
  Identifiability result_;
};

}  // namespace

Identifiability identifiability(const MatrixXd& information, const std::vector<InformedParameter>& parameters,
                                const IdentifiabilityOptions& options) {
  check(information, parameters);
  return Judgement(information, parameters, options).judge();
}

}  // namespace kalfem
