// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "kalfem/page/page.hpp"
#include "kalfem/study/updated_decks.hpp"

namespace kalfem {

/// Writes each deck below UpdatedDecks::folder/SUBSTRUCTURE, and changes.csv beside with every changed field, and every
/// value that no field states. `folder`: of the results.
void write_updated_decks(const std::filesystem::path& folder, const UpdatedDecks& decks);

/// The array "decks" of "updating" in summary.json.
nlohmann::ordered_json updated_decks_summary(const UpdatedDecks& decks);
/// Every changed field; without rows where there is none.
Table updated_decks_table(const UpdatedDecks& decks);
/// Where the decks are, and what they do not state, a line each.
std::string updated_decks_words(const UpdatedDecks& decks);

}  // namespace kalfem
