#pragma once

#include <string>
#include <vector>

#include "kalfem/model/finite_element_model.hpp"

namespace kalfem {

/// Why a model has mechanisms, and what removes them.
struct MechanismReason {
  std::string why, fix;
};

/// Tells hourglass modes from other mechanisms, those of find_mechanisms(). A solid of reduced integration has motions
/// that strain none of its few integration points; the model with full integration has fewer mechanisms then.
MechanismReason mechanism_reason(const FiniteElementModel& model, const std::vector<std::string>& mechanisms);

}  // namespace kalfem
