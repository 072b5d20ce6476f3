// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "kalfem/pipeline/run_study.hpp"
#include "kalfem/report/scene.hpp"

namespace kalfem {

/// Of the mesh of a scene; finer ones are coarsened, so that a page stays small and turns at once.
inline constexpr std::size_t most_scene_faces = 40000;

/// A finite-element substructure of a study with everything that stands on it (sensors, forces, boundary, connectors,
/// springs, masses, supports), its mode shapes, and its motions where the case asks for pictures. Places that stand for
/// several nodes of a coarsened mesh have the weighted mean of their displacements. Nothing where there is no mesh.
std::optional<Scene> structure_scene(const Study& study, const StudyResults& results, const FiniteElementPart& part);

}  // namespace kalfem
