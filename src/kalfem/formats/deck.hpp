// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/formats/ledger.hpp"
#include "kalfem/model/finite_element_model.hpp"
#include "kalfem/model/statics/load_case.hpp"

namespace kalfem {

/// A model out of another code's input file, in the file's own units, with what was left out of it.
struct Deck {
  FiniteElementModel model;
  std::vector<DeckNote> notes;            ///< in the order of their first places
  std::vector<LoadCase> load_cases = {};  ///< if they are asked for, see DeckOptions
  std::optional<LoadCase> preload = {};   ///< whose stresses the structure carries in the deck's own modes
  bool is_static_analysis = false;        ///< it asks for statics alone, which need no mass
  std::vector<LedgerEntry> ledger = {};   ///< if it is asked for
};

/// Notes of the kind `missing` that are not accepted become issues; accepted ones stay, as doubtful notes. Names are
/// compared without regard to case, blanks and a leading '*'. Returns the accepted names that the deck does not hold.
std::vector<std::string> accept_missing(std::vector<DeckNote>& notes, const std::vector<std::string>& accepted,
                                        IssueList& issues);

enum class DeckFormat { automatic, abaqus, nastran };

/// Whether a file's name ends as those of decks do: .inp, .bdf, .dat, .nas, .blk, in any case.
bool is_deck(const std::filesystem::path& file);

struct DeckOptions {
  DeckFormat format = DeckFormat::automatic;  ///< a name that ends in .inp is of Abaqus or CalculiX, others of Nastran
  std::optional<double> temperature = {};     ///< at which materials are taken, in the deck's unit; empty: the deck's
                                              ///< initial temperature
  std::optional<std::int64_t> subcase = {};   ///< SUBCASE of Nastran whose structure is meant; empty: the first one
                                              ///< with METHOD, or the first one
  bool load_cases = false;                    ///< read the static load cases too
  bool ledger = false;                        ///< keep what became of every field
};

/// Reads another code's input file, see abaqus.hpp and nastran.hpp.
Deck read_deck(const std::filesystem::path& file, const DeckOptions& options = {});

}  // namespace kalfem
