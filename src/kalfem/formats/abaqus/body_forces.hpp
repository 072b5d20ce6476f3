// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/formats/abaqus/placed_deck.hpp"
#include "kalfem/model/statics/load_case.hpp"

namespace kalfem::abaqus {

/// Whether elements are all that have a mass, so that a load on them acts on the whole model.
bool are_all_masses(const PlacedDeck& deck, const std::vector<Index>& elements);

/// Forces of a field on some elements alone, 6 to a node: those of kalfem::field_forces() and of their lumped masses;
/// `per_volume`: the field is a force per volume, the masses those of the density 1. Nothing, and a
/// problem at `where`, for what has no such matrix: quadratic shells and beams, masses by direction and, per volume,
/// laminates.
std::optional<Eigen::VectorXd> field_forces(PlacedDeck& deck, const FiniteElementModel& model,
                                            const std::vector<Index>& elements, const AccelerationField& field,
                                            bool per_volume, const Where& where);

}  // namespace kalfem::abaqus
