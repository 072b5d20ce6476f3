// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "kalfem/report/page.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

/// The structure with its named sensors, connectors, excitations and grounds: the mesh of the largest finite-element
/// substructure where there is one, otherwise a schematic of masses. Nothing where there is nothing to draw.
std::optional<Picture> structure_picture(const Study& study);

/// The schematic of the whole structure, finite-element substructures as boxes.
std::optional<Picture> schematic_picture(const Study& study);

}  // namespace kalfem
