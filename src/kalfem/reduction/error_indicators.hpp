#pragma once

#include "kalfem/reduction/superelement.hpp"

namespace kalfem {

/// Full and reduced modes up to a frequency [Hz], place by place.
std::vector<ModeComparison> compare_modes(const LinearModel& full, const LinearModel& reduced,
                                          const Eigen::MatrixXd& basis, double up_to);

}  // namespace kalfem
