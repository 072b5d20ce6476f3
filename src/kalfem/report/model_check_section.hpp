// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "kalfem/formats/deck.hpp"
#include "kalfem/model/checks/model_check.hpp"
#include "kalfem/page/page.hpp"
#include "kalfem/study/finite_element_part.hpp"

namespace kalfem {

/// Health of a substructure: of its elements, or of matrices of another code, whose nodes have no places.
ModelCheckReport model_check_of(const FiniteElementPart& part, const ModelCheckOptions& options = {});

/// What was found, worst first: severity, fact, what follows, what to do.
Table findings_table(const ModelCheckReport& report);
/// Mass, centre of gravity, inertia, box, grounding, matrices.
Table properties_table(const ModelCheckReport& report);
/// Regions with what they are made of, how large and how heavy they are.
Table regions_table(const ModelCheckReport& report);
/// Materials with their values and what they resemble.
Table materials_table(const ModelCheckReport& report);
/// Shapes of the cells of each region: the worst value of each measure, and how many cells are beyond its limit.
Table quality_table(const ModelCheckReport& report);
/// The named nodes of a substructure: number, place, and how far it lies from the place that the case gives.
Table places_table(const FiniteElementPart& part);
/// The element under each strain gauge, and what it measures there.
Table gauges_table(const FiniteElementPart& part);
/// What a deck holds that was not used, what may change the model first.
Table notes_table(const std::vector<DeckNote>& notes);

/// As a person reads it on a terminal: findings and notes as sentences, then the tables.
std::string model_check_text(const ModelCheckReport& report, const std::vector<DeckNote>& notes);
/// All tables that have rows as a section of a page, below a picture of the mesh (where there is one).
Section model_check_section(const std::string& name, const FiniteElementModel& model, const ModelCheckReport& report,
                            const std::vector<DeckNote>& notes);

}  // namespace kalfem
