// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "kalfem/identification/finite_element_part.hpp"
#include "kalfem/page/page.hpp"
#include "kalfem/pictures/scene.hpp"
#include "kalfem/steps/modes/outcome.hpp"
#include "kalfem/steps/study_results.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

/// Natural frequencies of every substructure; of a reduced one also the frequency, the modal assurance criterion and
/// the relative residual of every mode that the reduction keeps. The caption says why modes have none of these. After
/// an updating, the columns say which values they belong to.
Table modes_table(const Study& study, const StudyResults& results);

/// Natural frequencies of the joined structure; no rows where nothing is joined.
Table joined_modes_table(const Study& study, const StudyResults& results);

/// Mass of a substructure with its unit, and the part that is free to move where some of it is held:
/// "15.7 kg (11.8 kg of it free to move)".
std::string mass_text(const FiniteElementPart& part);

/// Both for a terminal.
std::string console_modes(const Study& study, const StudyResults& results);

/// The object "model" of summary.json: sizes, frequencies, and how the reductions keep them.
nlohmann::ordered_json model_summary(const Study& study, const StudyResults& results);

/// Writes <part>_modes.vtu: the mesh with the translations of its nodes in each mode, for ParaView. With `updated`
/// those of both models, named "updated mode 01: ..." and "initial mode 01: ...".
void write_modes(const std::filesystem::path& folder, const FiniteElementPart& part, const SubstructureModes& modes,
                 const SubstructureModes* updated = nullptr);

/// Of the mesh of a scene; finer ones are coarsened, so that a page stays small and turns at once.
inline constexpr std::size_t most_scene_faces = 40000;

/// A finite-element substructure of a study with everything that stands on it (sensors, forces, boundary, connectors,
/// springs, masses, supports), its mode shapes, and its motions where the case asks for pictures. Places that stand for
/// several nodes of a coarsened mesh have the weighted mean of their displacements. Nothing where there is no mesh.
std::optional<Scene> structure_scene(const Study& study, const StudyResults& results, const FiniteElementPart& part);

}  // namespace kalfem
