#pragma once

#include "kalfem/pipeline/run_study.hpp"

namespace kalfem {

/// Modes of every substructure that has degrees of freedom: all of a lumped one, the lowest `count` of finite elements.
std::vector<SubstructureModes> substructure_modes(const Study& study, Eigen::Index count);

}  // namespace kalfem
