// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <filesystem>
#include <string>
#include <vector>

#include "kalfem/formats/updated_deck.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

/// The deck of a substructure with the updated values.
struct SubstructureDeck {
  std::string substructure;
  UpdatedDeck deck;
  std::string failure = {};  ///< why it could not be read again; empty: it could
};

/// Of every substructure that is made of a deck and has updated parameters.
struct UpdatedDecks {
  std::vector<SubstructureDeck> decks;
  std::filesystem::path folder = "updated_decks";  ///< in that of the results, where it is relative
};

/// The decks at the values of the updated parameters. Materials and thicknesses that the case replaces are written too.
UpdatedDecks updated_decks(const Study& study, const Eigen::VectorXd& values);

}  // namespace kalfem
