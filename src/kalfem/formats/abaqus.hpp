// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>

#include "kalfem/formats/deck.hpp"

namespace kalfem {

/// Gives the text of a file that a deck includes. Throws InvalidInput where there is none.
using DeckLoader = std::function<std::string(const std::filesystem::path&)>;

/// Reads an Abaqus or CalculiX input deck (.inp) as a linear model, in the deck's own units.
///
/// * Names are found in any case and keep the spelling of their first place. Node and element numbers stay as they are
///   unless those of several instances collide: then those of the second instance are raised by 10^m, of the third by
///   2 * 10^m and so on, with 10^m the first power of ten beyond the largest number of the deck.
/// * Sets and sections of an instance carry its name, "Wing-1.Skin". Every section's element set is a region; where
///   its elements need several properties (kinds of solids, axes of a material), the first keeps the name and further
///   ones are "NAME.2", "NAME.3". A later section over the same elements replaces an earlier one.
/// * Boundary conditions hold that stand outside of steps or in the first step (OP=NEW there lifts the earlier ones);
///   a prescribed motion counts as held. Everything else in steps is passed over, but for the loads of static steps
///   where load cases are asked for.
/// * Materials that depend on temperature are taken at one, see DeckOptions.
/// * 8-node and 6-node shells and 3-node beams become linear elements on the same nodes (replace_quadratic), trusses
///   springs along their axis with half their mass at each end.
/// * Boundary conditions, equations and ties of nodes that follow others act on what leads them.
///
/// What has no part in the result stands in the notes. What the model would be incomplete without, and what cannot be
/// understood, throws InvalidInput with file and line, up to 20 problems together.
Deck read_abaqus(const std::filesystem::path& file, const DeckOptions& options = {});

/// The keyword that states a region's section, by the region's name, and that of a stiffness or mass, by its parameter:
/// "skin", "mounts.17.stiffness".
using DeckOrigins = std::map<std::string, SourceLocation>;

/// The same from text. `source` names it in messages and is what included files are looked up beside;
/// `origins`, where it is given, gets the keywords.
Deck parse_abaqus(std::string content, const std::string& source, const DeckLoader& loader,
                  const DeckOptions& options = {}, DeckOrigins* origins = nullptr);

}  // namespace kalfem
