// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "kalfem/model/finite_element_model.hpp"

namespace kalfem {

/// The elements that a name means: a set of elements, a region of the mesh, all of a material, one element by its
/// number ("17") or several ("101-250"). Throws InvalidInput where it means none, or different ones.
std::vector<Eigen::Index> elements_named(const FiniteElementModel& model, const std::string& name);

/// Gives the model a factor of the elements that these names mean, see elements_named(); an element that several names
/// hold counts once. Throws InvalidInput with every name that means none, where the model has a factor of that name,
/// and where no element that it names is part of the model.
void add_element_factor(FiniteElementModel& model, const std::string& factor, const std::vector<std::string>& names,
                        FactorOf of = FactorOf::stiffness, double value = 1.0);

/// Gives the model a factor of matrices between its nodes. Throws InvalidInput where it has one of that name.
void add_matrix_factor(FiniteElementModel& model, const std::string& factor, NodalMatrices matrices,
                       double value = 1.0);

/// The product of the factors of each element's stiffness or mass, at their values; empty where the model has none.
std::vector<double> factors_of_cells(const FiniteElementModel& model, FactorOf what);

}  // namespace kalfem
