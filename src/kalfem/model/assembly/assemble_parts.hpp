#pragma once

#include <vector>

#include "kalfem/model/linear_model.hpp"

namespace kalfem {

/// Primal assembly: degrees of freedom of equal name are one, in the order in which they are met first. With the
/// Boolean matrix L_s that picks those of part s,
///     M = sum_s L_s^T M_s L_s,  C and K alike,
/// grounds of equal name add their pulls, and points keep their names.
///
/// Modal damping of a part acts through that part's own mass matrix, C_m = M_s Phi r Phi^T M_s, which is not of that
/// form for the assembly. Of a part of at most `dense_damping_up_to` degrees of freedom it is carried over exactly, as
/// entries of C. Throws InvalidInput where a larger part has some (unless it is the only part), and with every point
/// that two parts define differently or that has the name of another part's degree of freedom.
LinearModel assemble_parts(const std::vector<const LinearModel*>& parts, Eigen::Index dense_damping_up_to = 1000);

}  // namespace kalfem
