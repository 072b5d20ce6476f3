// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kalfem/casefile/description.hpp"
#include "kalfem/identification/finite_element_part.hpp"

namespace kalfem {

/// Nodes of a mesh that a place of a candidate sensor stands for, and the directions that it names.
struct CandidateNodes {
  std::vector<Eigen::Index> nodes;
  std::vector<int> directions;  ///< x, y and z where the place names none
  bool of_region = false;
};

/// The nodes of "p5" (a named node), "n12" (a node by its number) or "rails" (the corner nodes of a region or a group),
/// each with or without a direction behind it: "p5.z". Of a region's nodes only those are taken that lie at least
/// `spacing` [m] from those before. Empty where there is no such place.
std::optional<CandidateNodes> candidate_nodes(const FiniteElementPart& part, const std::string& place, double spacing);

/// Name of a node as the place of a sensor: its own, or "n12".
std::string name_of_node(const FiniteElementPart& part, Eigen::Index node);

/// Adds the motions of nodes without a name at which sensors may be placed to the points of the full model, so that its
/// reductions keep them.
void add_candidate_points(const description::Case& given, FiniteElementPart& part);

}  // namespace kalfem
