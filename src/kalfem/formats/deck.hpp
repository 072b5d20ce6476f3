#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "kalfem/model/finite_element_model.hpp"
#include "kalfem/model/statics/load_case.hpp"

namespace kalfem {

/// How much a note matters for the model.
enum class DeckNoteKind {
  unused,    ///< loads, output, other analyses: the model is complete without it
  doubtful,  ///< the model may be another one than the deck means
  missing    ///< stiffness, mass or a connection that the model lacks: refused unless the user accepts it
};

/// "error", "warning" or "not used", as a person reads it.
const char* to_string(DeckNoteKind kind);

/// Something that a deck holds and the reader does not use as it stands, with what that means for the result.
struct DeckNote {
  SourceLocation where;  ///< its first place
  std::string what;      ///< "*FRICTION", "PLOAD4", "field 12 of CQUAD4"
  std::string consequence;
  std::size_t count = 1;  ///< how often it stands in the deck
  DeckNoteKind kind = DeckNoteKind::unused;
};

/// A model out of another code's input file, in the file's own units, with what was left out of it.
struct Deck {
  FiniteElementModel model;
  std::vector<DeckNote> notes;            ///< in the order of their first places
  std::vector<LoadCase> load_cases = {};  ///< if they are asked for, see DeckOptions
};

/// Notes by kind: the first place is kept, further ones are counted.
class DeckNotes {
public:
  void add(const SourceLocation& where, const std::string& what, const std::string& consequence,
           DeckNoteKind kind = DeckNoteKind::unused);
  [[nodiscard]] std::vector<DeckNote> take() { return std::move(notes_); }

private:
  std::vector<DeckNote> notes_;
  std::unordered_map<std::string, std::size_t> index_;  ///< by what and consequence
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
  bool load_cases = false;                    ///< read the static load cases too
};

/// Reads another code's input file, see abaqus.hpp and nastran.hpp.
Deck read_deck(const std::filesystem::path& file, const DeckOptions& options = {});

}  // namespace kalfem
