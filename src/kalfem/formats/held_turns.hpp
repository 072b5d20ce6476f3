// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/formats/shell_surfaces.hpp"

namespace kalfem {

/// Frees the rotations about the normal n of smooth surfaces, at nodes that nothing holds in the plane of the surface
/// and whose rotations nothing else acts on (`turned`). Programs in which next to nothing stiffens these rotations
/// need them held, along whatever axes; here they turn with the surface. Of the held directions of rotation V, those
/// at right angles to the normal stay,
///     {v in V: v^T n = 0},
/// what is left of V if the turn about n is free. Returns the number of nodes.
std::size_t release_turns_about_normal(FiniteElementModel& model, const std::vector<NodalSurface>& surfaces,
                                       const std::vector<bool>& turned);

/// Gives the shells nodes of their own where they are smooth surfaces at `wanted` nodes. These are at the same places
/// and follow in all but the turn about the normal. Returns them by node, -1 where there is none.
std::vector<Eigen::Index> separate_shells(FiniteElementModel& model, const std::vector<NodalSurface>& surfaces,
                                          const std::vector<bool>& wanted);

/// n^T (theta' - theta) of the shells' own node against the given one.
DofSum turn_between(Eigen::Index node, Eigen::Index own, const NodalSurface& surface);

}  // namespace kalfem
