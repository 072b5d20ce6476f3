#pragma once

#include <Eigen/Dense>
#include <string>
#include <vector>

#include "kalfem/verdict/verdict.hpp"

namespace kalfem {

/// One unknown of the filter at the end of a run, beside its prior. Moves and deviations are those of the filter's
/// state, which is the parameter or its transform.
struct EstimatedUnknown {
  std::string name, unit;
  double initial = 0.0, estimate = 0.0;  ///< [unit]
  double moved = 0.0;                    ///< from the prior's mean, in prior standard deviations
  double shrinkage = 0.0;                ///< posterior over prior standard deviation
  double deviation = 0.0;                ///< [unit]
  double widening = 1.0;                 ///< robust over stated standard deviation
  bool drifts = false;                   ///< it may change along the record: its prior is soon forgotten
};

/// What contradicts the priors of the unknowns: an estimate further from its first guess than four prior deviations
/// ("far_from_prior"), with the other sign ("sign_changed"), one that the record says nothing about ("not_identified"),
/// two that it cannot tell apart ("correlated"), and deviations that are too small because innovations are correlated
/// ("deviation_too_small").
/// `correlation`: of the unknowns at the end, p x p. `nis_ratio`: mean NIS over the expected one. The filter linearises
/// about its estimate: one that travelled far while the innovations are a fifth too large is not to be trusted.
std::vector<Reason> unknown_reasons(const std::vector<EstimatedUnknown>& unknowns,
                                    const Eigen::Ref<const Eigen::MatrixXd>& correlation, double nis_ratio);

}  // namespace kalfem
