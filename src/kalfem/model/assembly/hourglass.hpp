// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "kalfem/model/finite_element_model.hpp"

namespace kalfem {

/// Why a model has mechanisms, and what removes them.
struct MechanismReason {
  std::string why, fix;
};

/// Of a model in which find_mechanisms() found some: tells hourglass modes from other mechanisms. A solid of reduced
/// integration has motions that strain none of its few integration points; the model with full integration has fewer
/// mechanisms then.
MechanismReason mechanism_reason(const FiniteElementModel& model);

}  // namespace kalfem
