// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/model/assembly/assembly.hpp"

namespace kalfem {

/// The error that a model takes no force although some of its degrees of freedom are held. It names the rigid-body
/// motions ("it can move along x, turn about y through [0.5, 0, 0] m"), or else the degrees of freedom at which it is a
/// mechanism. `held`: positions among the free degrees of freedom of `assembled`.
InvalidInput free_to_move(const FiniteElementModel& model, const AssembledModel& assembled,
                          const std::vector<Eigen::Index>& held);

}  // namespace kalfem
