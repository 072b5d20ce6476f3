// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "kalfem/page/page.hpp"
#include "kalfem/steps/statics/outcome.hpp"
#include "kalfem/study/statics_plan.hpp"

namespace kalfem {

/// The object "statics" of summary.json: by load case the displacements and stresses of the reported points, the
/// reactions with their sum and its difference from the loads, and the largest displacement and stresses; all SI.
nlohmann::ordered_json statics_summary(const StaticsPlan& plan, const StaticsOutcome& outcome);

/// "2 static load cases; the largest stress is 301 MPa (von Mises) in 'plate', load case pull."
std::string statics_answer(const StaticsOutcome& outcome);

/// Displacements and stresses of the reported points.
Table static_points_table(const StaticsOutcome& outcome);
/// Reactions of every support, and their sum.
Table reactions_table(const StaticsOutcome& outcome);
/// The most stressed place of every region.
Table stresses_table(const StaticsPlan& plan, const StaticsOutcome& outcome);

/// As a person reads it on a terminal.
std::string console_statics(const StaticsPlan& plan, const StaticsOutcome& outcome);

/// The page: tables, and for each load case a picture of the deformed mesh in bands of stress.
Section statics_section(const StaticsPlan& plan, const StaticsOutcome& outcome);

/// <substructure>_static.vtu for ParaView: for each load case the displacement and the von Mises stress of the nodes
/// (means; the largest of layers and regions), stress and strain at the centre of each cell (of a shell in the layer
/// with the larger stress), and the axial stress of beams. NaN where there is none.
void write_static_fields(const std::filesystem::path& folder, const StaticsPlan& plan, const StaticsOutcome& outcome);

}  // namespace kalfem
