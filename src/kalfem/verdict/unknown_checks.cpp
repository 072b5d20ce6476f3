#include "kalfem/verdict/checks.hpp"

#include <cmath>

#include <fmt/format.h>

namespace kalfem {

using Eigen::Index;

namespace {

constexpr double far = 4.0;              ///< prior standard deviations
constexpr double conflicting_nis = 1.2;  ///< mean NIS over the expected one
constexpr double hardly_shrunk = 0.9;    ///< posterior over prior deviation
constexpr double high_correlation = 0.99;
constexpr double certain = 4.0;  ///< deviations from zero of an estimate of the other sign

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

void check_sign(const EstimatedUnknown& unknown, std::vector<Reason>& reasons) {
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
  reasons.push_back({"deviation_too_small", unknown.name,
                     fmt::format("the standard deviation of unknown '{}' is {:.2g} times too small, because the "
                                 "innovations are larger than expected or correlated",
                                 unknown.name, unknown.widening),
                     "rely on std_robust in the place of std, and look for what the model misses",
                     VerdictState::suspicious, unknown.widening});
}

}  // namespace

std::vector<Reason> unknown_reasons(const std::vector<EstimatedUnknown>& unknowns,
                                    const Eigen::Ref<const Eigen::MatrixXd>& correlation, double mean_nis,
                                    double expected_nis) {
  std::vector<Reason> reasons;
  for (const auto& unknown : unknowns) {
    check_prior(unknown, mean_nis, expected_nis, reasons);
    check_sign(unknown, reasons);
    check_information(unknown, reasons);
    check_widening(unknown, reasons);
  }
  for (Index i = 0; i < correlation.rows(); ++i)
    for (Index j = 0; j < i; ++j) {
      if (!(std::abs(correlation(i, j)) > high_correlation)) continue;
      const auto &one = unknowns[static_cast<std::size_t>(j)].name, &other = unknowns[static_cast<std::size_t>(i)].name;
      reasons.push_back({"correlated", one + ", " + other,
                         fmt::format("the record cannot tell unknowns '{}' and '{}' apart: their correlation is {:.4f}",
                                     one, other, correlation(i, j)),
                         "hold one of them at its value, or excite the structure so that they act differently",
                         VerdictState::suspicious, 1.0});
    }
  return reasons;
}

}  // namespace kalfem
