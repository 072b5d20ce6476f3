// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/model/finite_element_model.hpp"

namespace kalfem {

/// Replaces the cells with nodes amid their sides that have no element here by linear ones over the same nodes, in
/// regions with a shell or laminate property and with a beam property:
/// * an 8-node quadrilateral by four quadrilaterals with a new node in the middle, placed by the shape functions,
///   x = (2 sum of the nodes amid the sides - sum of the corners) / 4;
/// * a 6-node triangle by four triangles;
/// * a 3-node line by two lines, whose placements share the offset of the middle evenly and keep the hinges of their
///   ends.
/// The nodes amid the sides of shells become the model's `side_middles`, so that nodal forces keep their meaning.
/// Placements and directions of cells pass to their parts. The first part keeps the cell's number, the others and the
/// new nodes take numbers beyond the largest; all parts stand in every region, set and factor that held the cell; node
/// sets are kept. Solids and linear cells stay as they are.
///
/// Accuracy: cells of half the size, whose error falls with h^2 where that of quadratic shells falls faster. The first
/// six frequencies of a cantilevered square plate of 4 x 4 (8 x 8) quadrilaterals come out up to 3.9 % (1.0 %) above
/// the converged ones, the first two 0.6 % (0.2 %); with two triangles for each, 7.0 % (1.8 %) and 1.1 % (0.3 %). Beams
/// are exact under end loads either way; curved 3-node lines become two chords.
void replace_quadratic(FiniteElementModel& model);

}  // namespace kalfem
