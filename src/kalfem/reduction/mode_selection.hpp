#pragma once

#include "kalfem/linalg/lowest_modes.hpp"
#include "kalfem/reduction/partition.hpp"
#include "kalfem/reduction/superelement.hpp"

namespace kalfem {

/// Fixed-interface modes of the interior that a selection keeps, and why.
struct SelectedModes {
  LowestModes modes;
  Eigen::Index rigid = 0;  ///< how many of them are rigid-body modes
  std::string reason;
};

/// Throws InvalidInput where no criterion is given, or a value is out of its range. `boundary_names` tell the
/// directions. Rigid-body modes are kept in any case.
SelectedModes select_modes(const Partition& parts, const std::vector<std::string>& boundary_names,
                           const ShiftedStiffness& factored, const ModeSelection& selection);

}  // namespace kalfem
