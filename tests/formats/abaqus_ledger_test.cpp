// SPDX-License-Identifier: Apache-2.0
// Every parameter and every field of the keywords that are kept: another value changes the model or its loads, or it is
// told, or refused.
#include <gtest/gtest.h>

#include <set>

#include "formats/abaqus_ledger_decks.hpp"
#include "formats/abaqus_reading.hpp"

namespace kalfem {
namespace {

/// Another value of the same kind.
std::string other(const std::string& field) {
  if (field.empty()) return "1.7";
  char* end = nullptr;
  const double value = std::strtod(field.c_str(), &end);
  if (*end != '\0') return "ZZZ";
  if (field.find_first_of(".eE") == std::string::npos) return std::to_string(std::atoi(field.c_str()) + 1);
  std::ostringstream stream;
  stream << 1.37 * value + 0.11;
  return stream.str();
}

/// *NODE, *ELEMENT and sets define what all others name; *END STEP has no data that counts.
bool is_walked(const std::string& keyword) {
  static const std::set<std::string> passed = {"*NODE", "*ELEMENT", "*NSET", "*END STEP"};
  return !passed.contains(keyword);
}

struct Count {
  std::size_t fields = 0, parameters = 0;
};

TEST(AbaqusLedger, NoFieldOfADataLineIsReadPast) {
  Count count;
  for (const auto& text : ledger_decks) {
    const auto lines = lines_of(text);
    const Reading base(lines);
    ASSERT_FALSE(base.ledger.empty()) << base.text;
    std::string keyword;
    for (std::size_t i = 0; i < lines.size(); ++i) {
      if (lines[i].starts_with('*')) {
        keyword = split(lines[i]).front();
        continue;
      }
      if (!is_walked(keyword)) continue;
      const auto fields = split(lines[i]);
      for (std::size_t field = 0; field <= fields.size(); ++field) {
        auto changed = lines;
        auto own = fields;
        own.resize(std::max(own.size(), field + 1));
        own[field] = other(own[field]);
        changed[i] = joined(own, ", ");
        ++count.fields;
        if (base.admits(keyword, "field " + std::to_string(field + 1))) continue;
        const Reading reading(changed);
        EXPECT_TRUE(reading.text != base.text || reading.admits(keyword, "field " + std::to_string(field + 1)))
            << keyword << ", line " << i + 1 << ": '" << lines[i] << "' and '" << changed[i] << "' are the same";
      }
    }
  }
  EXPECT_GT(count.fields, 300u);
  std::cout << count.fields << " fields\n";
}

/// Parameters of all keywords, those of the deck with another value and every other one given in addition.
TEST(AbaqusLedger, NoParameterIsReadPast) {
  const std::vector<std::string> names = {"AMPLITUDE",
                                          "OFFSET",
                                          "ORIENTATION",
                                          "NODAL THICKNESS",
                                          "DENSITY",
                                          "POISSON",
                                          "STACK DIRECTION",
                                          "ROTARY INERTIA",
                                          "LUMPED",
                                          "TAPER",
                                          "DEPENDENCIES",
                                          "NONLINEAR",
                                          "COMPLEX STIFFNESS",
                                          "LOAD CASE",
                                          "TYPE",
                                          "SYSTEM",
                                          "DEFINITION",
                                          "COMBINE",
                                          "FIXED",
                                          "OP",
                                          "USER",
                                          "FILE",
                                          "SUBMODEL",
                                          "WEIGHTING METHOD",
                                          "COUPLING",
                                          "NO ROTATION",
                                          "CYCLIC SYMMETRY",
                                          "TIED NSET",
                                          "INFLUENCE RADIUS",
                                          "REMOVE",
                                          "UNITS",
                                          "DISTRIBUTION",
                                          "SECTOR",
                                          "FOLLOWER",
                                          "MODULI",
                                          "ALPHA",
                                          "CONTROLS",
                                          "SOMETHING NEW"};
  Count count;
  for (const auto& text : ledger_decks) {
    const auto lines = lines_of(text);
    const Reading base(lines);
    for (std::size_t i = 0; i < lines.size(); ++i) {
      if (!lines[i].starts_with('*')) continue;
      const auto parts = split(lines[i]);
      if (!is_walked(parts.front())) continue;
      const auto expect_change = [&](const std::string& line, const std::string& name) {
        auto changed = lines;
        changed[i] = line;
        ++count.parameters;
        std::string plain = name;
        std::erase(plain, ' ');
        if (base.admits(parts.front(), "parameter " + plain)) return;
        const Reading reading(changed);
        EXPECT_TRUE(reading.text != base.text || reading.admits(parts.front(), "parameter " + plain))
            << "line " << i + 1 << ": '" << lines[i] << "' and '" << line << "' are the same";
      };
      for (std::size_t part = 1; part < parts.size(); ++part) {
        if (parts[part].find('=') == std::string::npos) continue;  // a flag has no value
        auto own = parts;
        own[part] = own[part].substr(0, own[part].find('=')) + "=ZZZ";
        expect_change(joined(own, ", "), parts[part].substr(0, parts[part].find('=')));
      }
      for (const auto& name : names)
        if (lines[i].find(name) == std::string::npos) expect_change(lines[i] + ", " + name + "=ZZZ", name);
    }
  }
  EXPECT_GT(count.parameters, 2000u);
  std::cout << count.parameters << " parameters\n";
}

TEST(AbaqusLedger, ExtraFieldsOfNodesAndRangesAreTold) {
  const auto deck = parse_abaqus(
      "*NODE\n1, 0., 0., 0., 0., 0., 1.\n2, 1., 0., 0.\n*NSET, NSET=N, GENERATE\n1, 2, 1, 5\n" + deck_steel +
          "*ELEMENT, TYPE=T3D2, ELSET=E\n1, 1, 2\n*SOLID SECTION, ELSET=E, "
          "MATERIAL=steel\n1e-4\n",
      "deck.inp", {}, {.ledger = true});
  const auto has = [&](const std::string& what) {
    return std::ranges::any_of(deck.notes, [&](const auto& note) { return note.what == what; });
  };
  EXPECT_TRUE(has("fields behind the coordinates of *NODE"));
  EXPECT_TRUE(has("fields behind the step of *NSET and *ELSET, GENERATE"));
  const auto nodes = std::ranges::find_if(deck.ledger, [](const auto& entry) { return entry.card == "*NODE"; });
  ASSERT_NE(nodes, deck.ledger.end());
}

TEST(AbaqusLedger, WhatNothingRefersToIsToldAndNotRefused) {
  const auto deck = parse_deck("*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n" + deck_steel +
                               "*MATERIAL, NAME=other\n*ELASTIC, COMPRESSION FACTOR=2\n1., 0.3\n*ELEMENT, TYPE=T3D2, "
                               "ELSET=E\n1, 1, 2\n*SOLID SECTION, ELSET=E, MATERIAL=steel\n1e-4\n");
  EXPECT_TRUE(std::ranges::any_of(
      deck.notes, [](const auto& note) { return note.what == "*ELASTIC" && note.kind == DeckNoteKind::unused; }));
  EXPECT_TRUE(std::ranges::none_of(deck.notes, [](const auto& note) { return note.kind == DeckNoteKind::missing; }));
}

}  // namespace
}  // namespace kalfem
