#pragma once

#include <string>
#include <vector>

#include "kalfem/model/assembly/assembly.hpp"

namespace kalfem {

/// The motions of a model that take no force although some of its degrees of freedom are held, in words: the rigid-body
/// motions ("it can move along x, and turn about y through [0.5, 0, 0] m"), or else the degrees of freedom at which it
/// is a mechanism. `held`: positions among the free degrees of freedom of `assembled`.
std::string free_motions_in_words(const FiniteElementModel& model, const AssembledModel& assembled,
                                  const std::vector<Eigen::Index>& held);

}  // namespace kalfem
