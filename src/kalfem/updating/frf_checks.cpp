// SPDX-License-Identifier: Apache-2.0
#include "kalfem/updating/frf_residual.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::VectorXd;

namespace {

constexpr double beyond = 3.0;            ///< of the model's highest frequency
constexpr double gravity = 9.81;          ///< [m/s^2]
constexpr double like_gravity = 1.15;     ///< factor either way
constexpr double impossible = 100.0;      ///< factor that no start is off by
constexpr double scatter_of_power = 0.5;  ///< of ln(|H| / |H_model| / omega^p) against that without the power
constexpr double least_octaves = 1.0;     ///< width of the lines that tells a power

std::string title(const MeasuredFrf& frf) { return "FRF '" + frf.name + "'"; }

void check_response(const MeasuredFrf& frf, const FrfResidualOptions& options, IssueList& issues) {
  const auto& [lines, outputs, values, deviations, magnitudes_only, coherence] = frf.response;
  if (values.rows() != lines.size() || values.cols() != static_cast<Index>(frf.set.outputs.size()))
    issues.add({},
               fmt::format("{} has {} x {} values for {} lines and {} points", title(frf), values.rows(), values.cols(),
                           lines.size(), frf.set.outputs.size()),
               "every column needs a point", "name one point per column, or select columns");
  if (deviations.size() > 0 && (deviations.rows() != values.rows() || deviations.cols() != values.cols()))
    issues.add({}, title(frf) + " has standard deviations of a different size from its values",
               "every value needs its own");
  else if (!deviations.allFinite() || (deviations.array() < 0.0).any())
    issues.add({}, title(frf) + " has standard deviations that are negative or not finite");
  if (!lines.allFinite() || !values.allFinite())
    issues.add({}, title(frf) + " has values that are not finite", "", "remove those lines");
  for (Index k = 1; k < lines.size(); ++k)
    if (!(lines[k] > lines[k - 1])) {
      issues.add({},
                 fmt::format("{}: line {} at {} Hz follows a line at {} Hz", title(frf), k + 1, lines[k], lines[k - 1]),
                 "frequencies must be in ascending order", "sort the lines");
      break;
    }
  if (magnitudes_only && options.form != FrfForm::log_magnitude)
    issues.add({}, title(frf) + " has no phases", "this comparison needs phases", "use compare: log_magnitude");
  if (magnitudes_only && options.smoothing > 0.0)
    issues.add({}, title(frf) + " has no phases", "smoothing needs phases", "set the smoothing to 0");
}

void check_options(const FrfResidualOptions& options, IssueList& issues) {
  const auto not_negative = [&](double value, const char* what) {
    if (!(value >= 0.0 && std::isfinite(value)))
      issues.add({}, fmt::format("the {} is {}", what, value), "it must not be negative");
  };
  not_negative(options.smoothing, "smoothing width");
  not_negative(options.relative_deviation, "relative standard deviation of FRFs");
  not_negative(options.floor, "floor of the standard deviation of FRFs");
  if (options.relative_deviation == 0.0 && options.floor == 0.0)
    issues.add({}, "relative standard deviation and floor of FRFs are both 0", "the residual is divided by them");
  if (options.scale != FrfScale::fixed && options.form == FrfForm::complex_difference)
    issues.add({}, "the scale of FRFs is free, but differences are compared", "a free factor needs logarithms",
               "compare logarithm or log_magnitude, or fix the scale");
  for (const auto& [from, to] : options.bands)
    if (!(from >= 0.0 && to > from))
      issues.add({}, fmt::format("a band goes from {} to {} Hz", from, to),
                 "its upper limit must exceed its lower one");
}

// A wrong unit or quantity shows as a level: the ratios |H| / |H_model| of all lines are about one constant, or one
// power of omega, apart from 1. Medians are used, because near resonances single ratios mean nothing. A power is
// believed where it halves the scatter of the ratios over at least an octave; a factor where it is g, or beyond any
// start.
/// ln |H| - ln |H_model| with ln omega, of all lines and outputs of a set.
struct LogRatios {
  std::vector<double> values, log_omega;
};

/// Values of 0, whose logarithm is infinite, are left out.
LogRatios log_ratios(const FrequencyResponse& measured, const MatrixXcd& model) {
  LogRatios ratios;
  for (Index k = 0; k < model.rows(); ++k)
    for (Index j = 0; j < model.cols(); ++j) {
      const double ratio = std::log(std::abs(measured.values(k, j)) / std::abs(model(k, j)));
      if (!std::isfinite(ratio)) continue;
      ratios.values.push_back(ratio);
      ratios.log_omega.push_back(std::log(2.0 * std::numbers::pi * measured.lines[k]));
    }
  return ratios;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

/// Median of the ratios less p ln omega, and the median distance from it.
struct Level {
  double middle = 0.0, scatter = 0.0;
};

Level level_of(const LogRatios& ratios, double power) {
  std::vector<double> values = ratios.values;
  for (std::size_t i = 0; i < values.size(); ++i) values[i] -= power * ratios.log_omega[i];
  const double middle = median(values);
  for (double& value : values) value = std::abs(value - middle);
  return {middle, median(values)};
}

/// The power of omega that explains the ratios clearly better than none; 0 where there is none. With `any_level` it
/// need not leave a factor near 1.
int power_of(const LogRatios& ratios, bool any_level) {
  const auto [lowest, highest] = std::ranges::minmax(ratios.log_omega);
  if (highest - lowest < least_octaves * std::numbers::ln2) return 0;
  int best = 0;
  double scatter = scatter_of_power * level_of(ratios, 0.0).scatter;
  for (const int power : {-2, -1, 1, 2})
    if (const Level level = level_of(ratios, power);
        level.scatter < scatter && (any_level || std::exp(std::abs(level.middle)) < 10.0)) {
      best = power;
      scatter = level.scatter;
    }
  return best;
}

std::string unit_hint(double factor, const FrfSet& set) {
  const std::string motion = set.quantity == ResponseQuantity::acceleration ? "mm/s^2"
                             : set.quantity == ResponseQuantity::velocity   ? "mm/s"
                                                                            : "mm";
  const auto near = [&](double value) { return factor > value / 2.0 && factor < value * 2.0; };
  if (near(1000.0)) return "is it in " + motion + (set.input == FrfInput::force ? ", or per kN" : "") + "?";
  if (near(1e6)) return "is it in " + motion + " per kN?";
  if (near(1e-3)) return "is it per mN?";
  return "check its unit and the points at which it was measured";
}

bool is_like(double factor, double value) { return factor < value * like_gravity && factor > value / like_gravity; }

// Tried in order: a power of omega (displacement, velocity or acceleration taken for each other), the factor g, a
// factor that no parameter of a model explains. The message proposes the unit that would account for it.
void check_level(const MeasuredFrf& frf, const LogRatios& ratios, bool any_level, IssueList& issues) {
  if (ratios.values.empty()) return;
  constexpr const char* why = "measurement and model are compared in m, s, N";
  if (const int power = power_of(ratios, any_level); power != 0) {
    issues.add({}, fmt::format("the ratio of {} to the model's response varies as omega^{}", title(frf), power), why,
               "is it " + std::string(std::abs(power) == 2 ? "a displacement for an acceleration" : "a velocity") +
                   ", or the other way round?");
    return;
  }
  if (any_level) return;
  const double factor = std::exp(level_of(ratios, 0.0).middle);
  if (is_like(factor, gravity) || is_like(factor, 1.0 / gravity))
    issues.add({},
               fmt::format("{} is {} than the model's by a factor of {:.3g} everywhere", title(frf),
                           factor > 1.0 ? "larger" : "smaller", std::max(factor, 1.0 / factor)),
               why, factor > 1.0 ? "is its input in kgf, or in g?" : "is it in g?");
  else if (factor > impossible || factor < 1.0 / impossible)
    issues.add({},
               fmt::format("{} is {} than the model's by a factor of about {:.2g} everywhere", title(frf),
                           factor > 1.0 ? "larger" : "smaller", std::max(factor, 1.0 / factor)),
               why, unit_hint(factor, frf.set));
}

}  // namespace

void check_measured(const std::vector<MeasuredFrf>& measured, const FrfResidualOptions& options) {
  IssueList issues;
  if (measured.empty()) issues.add({}, "no FRF is given", "there is nothing to compare with");
  check_options(options, issues);
  for (const auto& frf : measured) check_response(frf, options, issues);
  issues.raise();
}

// An exact zero is a value that was filled in: its logarithm is infinite, and a deviation of zero divides the residual.
void check_lines(const std::vector<MeasuredFrf>& measured, const std::vector<FrequencyResponse>& compared,
                 const FrfResidualOptions& options) {
  IssueList issues;
  for (std::size_t i = 0; i < measured.size(); ++i) {
    const VectorXd& lines = measured[i].response.lines;
    if (compared[i].lines.size() == 0)
      issues.add({},
                 lines.size() == 0 ? title(measured[i]) + " has no lines"
                                   : fmt::format("{} has no line in the bands; its lines run from {} to {} Hz",
                                                 title(measured[i]), lines[0], lines[lines.size() - 1]),
                 options.smoothing > 0.0 ? "smoothing also removes lines near the ends" : "", "change the bands");
    else if ((compared[i].deviations.array() == 0.0).any() || (compared[i].values.array() == 0.0).any())
      issues.add({}, title(measured[i]) + " is exactly 0 at a line in the bands", "such a value was not measured",
                 "exclude it by bands");
  }
  issues.raise();
}

// Beyond the highest natural frequency of a lumped model its response is that of masses alone, which no structure has.
void check_range(const std::vector<MeasuredFrf>& measured, const std::vector<FrequencyResponse>& compared,
                 const ResponseBasis& basis, const ResponseBasisOptions& options) {
  if (basis.shapes.rows() > options.exact_up_to || basis.modes == 0) return;
  const double highest = basis.circular_frequencies().maxCoeff() / (2.0 * std::numbers::pi);
  IssueList issues;
  for (std::size_t i = 0; i < measured.size(); ++i) {
    const double last = compared[i].lines[compared[i].lines.size() - 1];
    if (highest > 0.0 && last > beyond * highest)
      issues.add({},
                 fmt::format("{} is used up to {:.4g} Hz, but the model's highest natural frequency is {:.4g} Hz",
                             title(measured[i]), last, highest),
                 "the model has no resonances there", fmt::format("give bands up to about {:.3g} Hz", 1.5 * highest));
  }
  issues.raise();
}

void check_size(const std::vector<MeasuredFrf>& measured, const std::vector<FrequencyResponse>& compared,
                const std::vector<MatrixXcd>& model, const FrfResidualOptions& options) {
  IssueList issues;
  for (std::size_t i = 0; i < measured.size(); ++i)
    check_level(measured[i], log_ratios(compared[i], model[i]), options.scale != FrfScale::fixed, issues);
  issues.raise();
}

}  // namespace kalfem
