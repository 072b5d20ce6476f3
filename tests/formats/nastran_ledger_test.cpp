// SPDX-License-Identifier: Apache-2.0
// Every field of every card: what is set to another value changes the model, is told, or is refused.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <set>

#include "formats/nastran_card_samples.hpp"
#include "formats/nastran_decks.hpp"
#include "kalfem/formats/nastran/card_readers.hpp"

namespace kalfem {
namespace {

using test::card_samples;
using test::card_text;
using test::CardSample;

/// All numbers and names of what a deck became; empty where it is refused.
class Fingerprint {
public:
  static std::string of(const Deck& deck) {
    Fingerprint print;
    const auto& model = deck.model;
    print.add(model.mesh.nodes);
    for (const auto id : model.mesh.node_ids) print.add(static_cast<double>(id));
    for (const auto& cell : model.mesh.cells) print.add(static_cast<double>(cell.id));
    for (const auto& [name, nodes] : model.mesh.node_sets) print.add(name);
    for (const auto& fixed : model.fixed)
      for (const auto node : fixed.nodes) print.add(static_cast<double>(node));
    for (const auto& joint : model.joints) print.add(joint.name);
    for (const auto& mass : model.masses) print.add(mass.name);
    for (const auto& link : model.links) print.add(link.name);
    for (const auto& link : model.weighted_links) print.add(link.name);
    for (const auto& constraint : model.constraints) print.add(constraint.name);
    const auto assembled = assemble(model);
    print.add(Eigen::MatrixXd(evaluate(assembled.stiffness, assembled.parameters)));
    print.add(Eigen::MatrixXd(evaluate(assembled.mass, assembled.parameters)));
    print.add(Eigen::MatrixXd(assembled.damping));
    print.add(Eigen::MatrixXd(assembled.expansion));
    for (const auto& load_case : deck.load_cases) {
      print.add(load_case.name);
      print.add(nodal_forces(model, load_case));
      print.add(load_case.gravity);
      if (load_case.rotation) {
        print.add(load_case.rotation->axis);
        print.add(load_case.rotation->about);
        print.add(load_case.rotation->speed);
      }
      for (const auto& imposed : load_case.imposed)
        print.add(Eigen::Vector3d(static_cast<double>(imposed.dof.node), imposed.dof.direction, imposed.value));
    }
    return print.text_;
  }

private:
  void add(const Eigen::MatrixXd& matrix) {
    text_.append(reinterpret_cast<const char*>(matrix.data()),
                 static_cast<std::size_t>(matrix.size()) * sizeof(double));
  }
  void add(double value) { add(Eigen::MatrixXd::Constant(1, 1, value)); }
  void add(const std::string& name) { text_ += name + '\n'; }

  std::string text_;
};

struct Outcome {
  std::string print;    ///< empty: refused
  std::string problem;  ///< of a refused deck
  std::set<std::string> notes;
  std::vector<LedgerEntry> ledger;
};

Outcome outcome(const CardSample& sample, const std::vector<std::string>& fields) {
  try {
    const auto text =
        sample.control + test::sample_nodes() + sample.others + card_text(sample.name, fields) + "ENDDATA\n";
    const Deck deck = parse_nastran(text, "deck.bdf", {}, {.load_cases = true, .ledger = true});
    Outcome found{.print = Fingerprint::of(deck), .problem = {}, .notes = {}, .ledger = deck.ledger};
    for (const auto& note : deck.notes)
      found.notes.insert(note.what + ": " + note.consequence + " " + std::to_string(note.count));
    return found;
  } catch (const InvalidInput& error) {
    return {.print = {}, .problem = error.what(), .notes = {}, .ledger = {}};
  }
}

/// Other values to try: of a number another one, of a blank a whole and a real number.
std::vector<std::string> other_values(const CardSample& sample, std::size_t i) {
  const std::string field = i <= sample.fields.size() ? sample.fields[i - 1] : "";
  if (const auto given = sample.other_values.find(i); given != sample.other_values.end()) return {given->second};
  if (field.empty()) return {"2", ".37"};
  if (const auto whole = nastran::parse_integer(field)) return {std::to_string(*whole + 1)};
  const auto real = nastran::parse_real(field);
  if (!real) return {"XYZ"};
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.6E", 1.21 * *real + (*real == 0.0 ? 1.0 : 0.0));
  return {text.data()};
}

/// As the ledger names it: lines beyond the fourth together.
std::string ledger_field(std::size_t i) {
  return i <= 32 ? nastran::place_on_card(i) : "line 5 and beyond, field " + std::to_string((i - 1) % 8 + 2);
}

/// Numbers of masses that become a matrix, which has no names in it, and of grid points that all have one temperature.
bool is_plain_number(const std::string& card, std::size_t i) {
  return (i == 1 && (card.starts_with("CMASS") || card == "CONM1")) || (card == "TEMP" && i > 1 && i % 2 == 0);
}

std::size_t reader_count() {
  std::size_t count = 0;
  for (const auto list : {nastran::node_cards(), nastran::shell_cards(), nastran::beam_cards(), nastran::scalar_cards(),
                          nastran::material_cards(), nastran::temperature_cards(), nastran::property_cards(),
                          nastran::section_cards(), nastran::constraint_cards(), nastran::matrix_cards()})
    for (const auto& reader : list) {
      ++count;
      const auto is_of_reader = [&](const CardSample& sample) { return sample.name == reader.name; };
      const auto samples = card_samples();
      EXPECT_TRUE(std::ranges::any_of(samples, is_of_reader)) << reader.name << " has no sample";
    }
  // Of the loads those that load cases hold; the others are refused as a whole.
  for (const auto& reader : nastran::load_cards()) {
    const std::array read = {"FORCE",  "MOMENT", "FORCE1", "MOMENT1", "FORCE2", "MOMENT2", "SLOAD", "PLOAD",
                             "PLOAD1", "PLOAD2", "PLOAD4", "GRAV",    "RFORCE", "LOAD",    "SPCD"};
    count += static_cast<std::size_t>(std::ranges::count(read, reader.name));
  }
  return count;
}

TEST(NastranLedger, NoFieldOfAnyCardIsReadPast) {
  std::size_t cards = 0, fields = 0, changed = 0, told = 0, refused = 0;
  EXPECT_GE(reader_count(), 70u);
  for (const auto& sample : card_samples()) {
    const auto base = outcome(sample, sample.fields);
    EXPECT_FALSE(base.print.empty()) << sample.name << ": " << base.problem;
    ++cards;
    // three fields behind the card's last one, too
    for (std::size_t i = 1; i <= sample.fields.size() + 3; ++i) {
      for (const auto& value : other_values(sample, i)) {
        auto set = sample.fields;
        if (set.size() < i) set.resize(i);
        set[i - 1] = value;
        const auto found = outcome(sample, set);
        ++fields;
        const bool is_told = std::ranges::any_of(found.ledger, [&](const LedgerEntry& entry) {
          return entry.card == sample.name && entry.fate == FieldFate::told && entry.field == ledger_field(i);
        });
        if (found.print.empty())
          ++refused;
        else if (found.print != base.print || is_plain_number(sample.name, i))
          ++changed;
        else if ((is_told && !found.notes.empty()) || found.notes != base.notes)
          ++told;
        else
          ADD_FAILURE() << sample.name << ", " << nastran::place_on_card(i) << " set to '" << value
                        << "': nothing changes, and nothing is told";
      }
    }
  }
  std::printf("%zu cards, %zu fields: %zu change the model, %zu are told, %zu refused\n", cards, fields, changed, told,
              refused);
  RecordProperty("cards", static_cast<int>(cards));
  RecordProperty("fields", static_cast<int>(fields));
  EXPECT_GT(changed, 300u);
}

/// Fields without effect are told; a zero in them is none of a warning.
TEST(NastranLedger, FieldsWithoutEffectAreNotes) {
  const std::string deck = "GRID,1\nGRID,2,,1.\nPROD,1,1,1.-3,,.5\nCROD,1,1,1,2\nMAT1,1,7.E10,,.3,2700.,1.-5\n";
  const auto kind_of = [](const Deck& read, const std::string& what) -> std::optional<DeckNoteKind> {
    const auto note = std::ranges::find(read.notes, what, &DeckNote::what);
    return note == read.notes.end() ? std::nullopt : std::optional(note->kind);
  };
  const auto read = test::nastran(deck);
  EXPECT_EQ(kind_of(read, "C of PROD"), DeckNoteKind::unused);
  EXPECT_EQ(kind_of(read, "A, TREF of MAT1"), DeckNoteKind::unused);
  const auto odd = test::nastran(deck + "CONM2,9,1,,1.,,,,7.\n");
  EXPECT_EQ(kind_of(odd, "line 1, field 9 of CONM2"), DeckNoteKind::doubtful);
  EXPECT_EQ(kind_of(test::nastran(deck + "CONM2,9,1,,1.,,,,0.\n"), "line 1, field 9 of CONM2"), DeckNoteKind::unused);
}

TEST(NastranLedger, HoldsEveryFieldThatIsFilled) {
  const auto deck = parse_nastran(
      "GRID,1\nGRID,2,,1.\nCONM2,9,1,,1.\nCONM2,8,2,,1.\nCELAS2,1,5.,1,1,2,1,.02\nEIGRL,5,,,10\nENDDATA\n", "deck.bdf",
      {}, {.ledger = true});
  std::map<std::string, std::map<std::string, FieldFate>> fates;
  std::size_t count = 0;
  for (const auto& entry : deck.ledger) fates[entry.card][entry.field] = entry.fate, count += entry.count;
  EXPECT_EQ(count, 3u + 6u + 7u + 2u);
  EXPECT_EQ(fates["CONM2"]["line 1, field 5"], FieldFate::used);
  EXPECT_EQ(fates["CELAS2"]["line 1, field 8"], FieldFate::told);
  EXPECT_EQ(fates["EIGRL"]["line 1, field 2"], FieldFate::told);
  EXPECT_TRUE(test::nastran("GRID,1\nCONM2,9,1,,1.\n").ledger.empty());
}

}  // namespace
}  // namespace kalfem
