// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "kalfem/model/statics/load_case.hpp"

namespace kalfem {

/// Faces of one cell on which pressure can act: of a solid all, seen from outside; of a shell itself; none of others.
std::vector<LoadedFace> faces_of_cell(const Mesh& mesh, const Cell& cell);

}  // namespace kalfem
