// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "kalfem/model/finite_element_model.hpp"

namespace kalfem::rewriting {

/// All numbers of a model that its deck's cards state, by what they belong to, so that two models can be compared
/// whatever their materials are called.
struct ModelNumbers {
  /// E, rho and nu of the material, then thickness or section, offsets, added masses and stiffnesses.
  std::map<std::string, std::vector<double>> regions;
  std::map<std::string, double> others;  ///< springs and masses by their parameters
  std::size_t nodes = 0, cells = 0, equations = 0;
};

ModelNumbers numbers_of(const FiniteElementModel& model);

/// The first number that is not as expected, in words; empty where all are. Numbers of fields that are written may be
/// rounded: 2e-5, Poisson's ratio by E and G 1e-4.
std::string difference(const ModelNumbers& expected, const ModelNumbers& found);

}  // namespace kalfem::rewriting
