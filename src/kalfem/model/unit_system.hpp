// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/model/finite_element_model.hpp"
#include "kalfem/model/statics/load_case.hpp"

namespace kalfem {

/// The units that the numbers of a foreign model are in; force is mass length / time^2. Default: SI.
struct UnitSystem {
  double length = 1.0;  ///< [m]
  double mass = 1.0;    ///< [kg]
  double time = 1.0;    ///< [s]
};

/// Numbers of a model from its units to SI: coordinates, materials, sections, masses, springs, matrices.
void to_si(FiniteElementModel& model, const UnitSystem& units);
/// The same of loads and imposed motions.
void to_si(LoadCase& load_case, const UnitSystem& units);

/// Factors d_i with which matrices over displacements of the kinds given become SI,
///     K_SI = mass / time^2 diag(d) K diag(d),  C_SI = mass / time diag(d) C diag(d),  M_SI = mass diag(d) M diag(d):
/// 1 at a translation, the length at a rotation, and 1 / sqrt(mass) at a generalised coordinate (of a mass-normalised
/// mode). `directions`: 0 .. 5, -1 at a generalised coordinate.
Eigen::VectorXd unit_factors(const std::vector<int>& directions, const UnitSystem& units);

/// unit diag(d) A diag(d).
Eigen::SparseMatrix<double> scaled(const Eigen::SparseMatrix<double>& matrix, double unit,
                                   const Eigen::VectorXd& factors);

}  // namespace kalfem
