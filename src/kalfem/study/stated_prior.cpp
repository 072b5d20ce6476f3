// SPDX-License-Identifier: Apache-2.0
#include "kalfem/study/stated_prior.hpp"

#include <cmath>

#include "kalfem/study/spread.hpp"
#include "kalfem/yaml/bounds.hpp"

namespace kalfem {
namespace {

namespace d = description;

using Ends = std::array<Quantity, 2>;

Support in_unit(const Ends& ends, const std::string& unit, const Located<d::Prior>& given, const std::string& key) {
  const auto end = [&](std::size_t side) {
    return checked_number({ends[side], given.location, given.path + "." + key}, unit);
  };
  const Support support{end(0), end(1)};
  if (!(support.lower < support.upper))
    throw InvalidInput(given.issue(
        key + ": the lower bound " + shortest(support.lower) + " is not below the upper one " + shortest(support.upper),
        "", "write [lower, upper]"));
  return support;
}

MarginalPrior shape_of(const d::NormalPrior& given, const std::string& unit) {
  const double mean = checked_number(given.mean, unit);
  const double deviation = spread_about(given.std, unit, mean);
  if (!(deviation > 0.0)) throw InvalidInput(given.std.issue("it is 0", "a known parameter is no unknown"));
  return NormalPrior{.mean = mean, .deviation = deviation};
}

MarginalPrior shape_of(const d::LogNormalPrior& given, const std::string& unit) {
  return LogNormalPrior{.median = checked_number(given.median, unit, Bounds::positive()), .log_deviation = given.std};
}

}  // namespace

MarginalPrior stated_prior(const Located<d::Prior>& given, const std::string& unit) {
  if (const auto* uniform = std::get_if<d::UniformPrior>(&given.value.shape)) {
    Support support = in_unit(uniform->between, unit, given, "uniform");
    if (given.value.bounds)
      throw InvalidInput(given.issue("a uniform prior has bounds of its own", "", "remove `bounds`"));
    return UniformPrior{support.lower, support.upper};
  }
  MarginalPrior prior = std::holds_alternative<d::NormalPrior>(given.value.shape)
                            ? shape_of(std::get<d::NormalPrior>(given.value.shape), unit)
                            : shape_of(std::get<d::LogNormalPrior>(given.value.shape), unit);
  if (!given.value.bounds) return prior;
  const Support cut = in_unit(*given.value.bounds, unit, given, "bounds");
  std::visit(
      [&](auto& marginal) {
        marginal.lower = std::max(marginal.lower, cut.lower);
        marginal.upper = cut.upper;
      },
      prior);
  return prior;
}

PriorCentre centre_of(const Located<d::Prior>& given) {
  const auto like = [&](const Quantity& model, double value, const std::string& key) {
    return d::Value{{value, model.dimension, model.bare}, given.location, given.path + key};
  };
  if (const auto* normal = std::get_if<d::NormalPrior>(&given.value.shape)) return {normal->mean, normal->std};
  if (const auto* lognormal = std::get_if<d::LogNormalPrior>(&given.value.shape)) {
    const auto& median = lognormal->median.value;
    return {lognormal->median, like(median, lognormal->std * median.value, ".lognormal")};
  }
  const auto& [lower, upper] = std::get<d::UniformPrior>(given.value.shape).between;
  return {like(lower, 0.5 * (lower.value + upper.value), ".uniform"),
          like(lower, 0.5 * std::abs(upper.value - lower.value), ".uniform")};
}

}  // namespace kalfem
