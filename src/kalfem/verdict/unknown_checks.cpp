// SPDX-License-Identifier: Apache-2.0
#include "kalfem/verdict/checks.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

constexpr double far = 4.0;              ///< prior standard deviations
constexpr double conflicting_nis = 1.2;  ///< mean NIS over the expected one
constexpr double hardly_shrunk = 0.9;    ///< posterior over prior deviation
constexpr double high_correlation = 0.99;
constexpr double at_bound = 0.01;      ///< of the range between the bounds
constexpr double at_bound_move = 2.0;  ///< prior deviations: a first guess that stood there is no finding
constexpr double redundant = 0.02;     ///< eigenvalue of the correlation matrix: known 50 times better than its parts
constexpr double member = 0.3;         ///< of the largest part of a direction
constexpr double still_wide = 0.3;     ///< posterior over prior deviation: below it, each is known well enough
constexpr double well_known = 0.05;    ///< the same of two that are highly correlated
constexpr double certain = 4.0;        ///< deviations from zero of an estimate of the other sign

std::string value_of(double value, const std::string& unit) {
  return fmt::format("{:.4g}{}{}", value, unit.empty() ? "" : " ", unit);
}

void check_prior(const EstimatedUnknown& unknown, double mean_nis, double expected_nis, std::vector<Reason>& reasons) {
  if (unknown.drifts || !(unknown.moved > far)) return;
  const bool conflict = mean_nis > conflicting_nis * expected_nis;
  reasons.push_back(
      {"far_from_prior", unknown.name,
       fmt::format("unknown '{}' ended at {}, {:.3g} prior standard deviations from its initial value {:.4g}{}",
                   unknown.name, value_of(unknown.estimate, unknown.unit), unknown.moved, unknown.initial,
                   conflict ? fmt::format(", and the mean NIS is {:.3g} (expected {:.3g}): do not trust the estimates",
                                          mean_nis, expected_nis)
                            : ""),
       fmt::format("start again from about {:.2g}, increase its std, or set transform: log", unknown.estimate),
       conflict ? VerdictState::unusable : VerdictState::suspicious, unknown.moved});
}

/// A value that its nature forbids, and by more than its deviation explains: the model is another one than it says.
bool is_out_of_range(const EstimatedUnknown& unknown) {
  return unknown.estimate < unknown.least - certain * unknown.deviation ||
         unknown.estimate > unknown.greatest + certain * unknown.deviation;
}

void check_range(const EstimatedUnknown& unknown, std::vector<Reason>& reasons) {
  if (!is_out_of_range(unknown)) return;
  const bool below = unknown.estimate < unknown.least;
  const double limit = below ? unknown.least : unknown.greatest, away = std::abs(unknown.estimate - limit);
  reasons.push_back({"out_of_range", unknown.name,
                     fmt::format("unknown '{}' ended at {}, and by its nature it must be {} {:.3g}", unknown.name,
                                 value_of(unknown.estimate, unknown.unit), below ? ">=" : "<=", limit),
                     "check signs and units of the record and of the excitation and the values that are held fixed; "
                     "transform: log or "
                     "bounds keep it in its range, but do not mend the cause",
                     VerdictState::unusable,
                     std::max(unusable_widening, away / std::max(unknown.deviation, 1e-3 * away))});
}

void check_bounds(const EstimatedUnknown& unknown, std::vector<Reason>& reasons) {
  const double range = unknown.upper_bound - unknown.lower_bound;
  if (!std::isfinite(range) || !(unknown.moved > at_bound_move)) return;
  const double below = (unknown.estimate - unknown.lower_bound) / range;
  if (below > at_bound && below < 1.0 - at_bound) return;
  reasons.push_back({"at_bound", unknown.name,
                     fmt::format("unknown '{}' ended at {}, which is its {} bound {:.4g}", unknown.name,
                                 value_of(unknown.estimate, unknown.unit), below <= at_bound ? "lower" : "upper",
                                 below <= at_bound ? unknown.lower_bound : unknown.upper_bound),
                     "widen its bounds; where these are right, the model or the record is wrong",
                     VerdictState::suspicious, suspicious_widening});
}

void check_sign(const EstimatedUnknown& unknown, std::vector<Reason>& reasons) {
  if (is_out_of_range(unknown)) return;
  if (unknown.initial * unknown.estimate >= 0.0 || !(std::abs(unknown.estimate) > certain * unknown.deviation)) return;
  reasons.push_back({"sign_changed", unknown.name,
                     fmt::format("unknown '{}' ended at {}, with the other sign than its initial value {:.4g}",
                                 unknown.name, value_of(unknown.estimate, unknown.unit), unknown.initial),
                     "check the signs and units of the record and of the excitation; set transform: log for what is "
                     "positive by nature",
                     VerdictState::suspicious, far});
}

void check_information(const EstimatedUnknown& unknown, std::vector<Reason>& reasons) {
  if (unknown.drifts || !(unknown.shrinkage > hardly_shrunk)) return;
  reasons.push_back(
      {"not_identified", unknown.name,
       fmt::format("the record says nothing about unknown '{}': its standard deviation is still {:.0f} % of "
                   "the prior's",
                   unknown.name, 100.0 * unknown.shrinkage),
       "excite what it belongs to, place a sensor near it, or hold it at its value by leaving it out",
       VerdictState::suspicious, 1.0});
}

void check_widening(const EstimatedUnknown& unknown, std::vector<Reason>& reasons) {
  const VerdictState state = state_of(unknown.widening);
  if (state == VerdictState::consistent) return;
  if (unknown.too_sure) {
    reasons.push_back({"too_sure", unknown.name,
                       fmt::format("the filter is {:.2g} times too sure of unknown '{}': it linearised about estimates "
                                   "that moved; about the last ones, the record leaves a standard deviation of {}",
                                   unknown.widening, unknown.name, value_of(unknown.deviation, unknown.unit)),
                       "rely on std_robust and interval_95, or on `infer` for the whole posterior; where the record "
                       "cannot tell two unknowns apart, hold one of them",
                       VerdictState::suspicious, unknown.widening});
    return;
  }
  reasons.push_back({"deviation_too_small", unknown.name,
                     fmt::format("the standard deviation of unknown '{}' is {:.2g} times too small, because the "
                                 "innovations are larger than expected or correlated",
                                 unknown.name, unknown.widening),
                     "rely on std_robust in the place of std, and look for what the model misses", state,
                     unknown.widening});
}

void check_pairs(const std::vector<EstimatedUnknown>& unknowns, const Eigen::Ref<const MatrixXd>& correlation,
                 std::vector<Reason>& reasons) {
  for (Index i = 0; i < correlation.rows(); ++i)
    for (Index j = 0; j < i; ++j) {
      const auto &one = unknowns[static_cast<std::size_t>(j)], &other = unknowns[static_cast<std::size_t>(i)];
      const bool both_known = std::max(one.shrinkage, other.shrinkage) < well_known;
      if (both_known || !(std::abs(correlation(i, j)) > high_correlation)) continue;
      reasons.push_back({"correlated", one.name + ", " + other.name,
                         fmt::format("the record cannot tell unknowns '{}' and '{}' apart: their correlation is {:.4f}",
                                     one.name, other.name, correlation(i, j)),
                         "hold one of them at its value, or excite the structure so that they act differently",
                         VerdictState::suspicious, 1.0});
    }
}

/// "'a', 'b' and 'c'"
std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i)
    text += (i == 0 ? "'" : i + 1 == names.size() ? " and '" : ", '") + names[i] + "'";
  return text;
}

/// Three and more of which no two are highly correlated can still depend on each other: an eigenvector of the
/// correlation matrix with a small eigenvalue is a combination that the record knows far better than its members
/// (Belsley, Kuh and Welsch 1980, chapter 3).
void check_combinations(const std::vector<EstimatedUnknown>& unknowns, const Eigen::Ref<const MatrixXd>& correlation,
                        std::vector<Reason>& reasons) {
  if (correlation.rows() < 3 || !correlation.allFinite()) return;
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(correlation);
  for (Index k = 0; k < correlation.rows() && eigen.eigenvalues()[k] < redundant; ++k) {
    const Eigen::VectorXd direction = eigen.eigenvectors().col(k).cwiseAbs();
    std::vector<std::string> names;
    double widest = 0.0;
    bool paired = false;
    for (Index i = 0; i < direction.size(); ++i) {
      if (direction[i] < member * direction.maxCoeff()) continue;
      const auto& unknown = unknowns[static_cast<std::size_t>(i)];
      names.push_back(unknown.name);
      widest = std::max(widest, unknown.shrinkage);
      for (Index j = 0; j < i; ++j)
        paired =
            paired || (direction[j] >= member * direction.maxCoeff() && std::abs(correlation(i, j)) > high_correlation);
    }
    if (names.size() < 3 || paired || widest < still_wide) continue;
    const double known = 1.0 / std::sqrt(std::max(eigen.eigenvalues()[k], 1e-12));
    reasons.push_back(
        {"combination", fmt::format("{}", fmt::join(names, ", ")),
         fmt::format("the record cannot tell unknowns {} apart: it knows a combination of them {:.2g} times "
                     "better than each",
                     listed(names), known),
         "hold one of them at its value, give it a narrow prior, or add a sensor that separates them",
         VerdictState::suspicious, 1.0});
  }
}

}  // namespace

std::vector<Reason> unknown_reasons(const std::vector<EstimatedUnknown>& unknowns,
                                    const Eigen::Ref<const Eigen::MatrixXd>& correlation, double mean_nis,
                                    double expected_nis) {
  std::vector<Reason> reasons;
  for (const auto& unknown : unknowns) {
    check_prior(unknown, mean_nis, expected_nis, reasons);
    check_range(unknown, reasons);
    check_sign(unknown, reasons);
    check_bounds(unknown, reasons);
    check_information(unknown, reasons);
    check_widening(unknown, reasons);
  }
  check_pairs(unknowns, correlation, reasons);
  check_combinations(unknowns, correlation, reasons);
  return reasons;
}

}  // namespace kalfem
