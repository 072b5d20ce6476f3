// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "kalfem/page/page.hpp"
#include "kalfem/steps/correlation/outcome.hpp"

namespace kalfem {

/// "shapes differ as by a stiffness that is wrong by 6.2 %, and by noise of 1.10 times what is stated"; empty without.
std::string mixing_words(const ShapeExpansion& expansion);
/// What an error of the stiffness and noise do, the bands of the modes, and the motion of the reported points.
nlohmann::ordered_json expansion_json(const CorrelatedComparison& comparison);

/// The measured shapes at points without a sensor: on a mesh beside those of the model, and a table of points.
void add_expanded_shapes(const CorrelatedComparison& comparison, Section& section);

/// The expanded shapes and the modes that they are paired with on two copies of the mesh, left and right. Nothing where
/// there is no mesh or no shape.
std::optional<Scene> side_by_side(const CorrelatedComparison& comparison);

}  // namespace kalfem
