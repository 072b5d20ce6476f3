// Every parameter and every field of the keywords that are kept: another value changes the model or its loads, or it is
// told, or refused.
#include <gtest/gtest.h>

#include <random>
#include <set>
#include <sstream>

#include "formats/abaqus_decks.hpp"
#include "kalfem/model/statics/load_case.hpp"

namespace kalfem {
namespace {

/// Beams, shells, solids, trusses, springs and masses with everything that joins, holds and loads them.
const std::vector<std::string> decks = {
    R"(*NODE, NSET=ALL
1, 0., 0., 0.
2, 1., 0., 0.1
3, 2., 0.2, 0.
4, 3., 0., 0.
*ELEMENT, TYPE=B31, ELSET=RECTS
1, 1, 2
*ELEMENT, TYPE=B31, ELSET=GENERALS
2, 2, 3
*ELEMENT, TYPE=B31, ELSET=BOXES
3, 3, 4
*BEAM SECTION, ELSET=RECTS, MATERIAL=M, SECTION=RECT
0.02, 0.01
0., 0.3, 1.
*BEAM GENERAL SECTION, ELSET=GENERALS, SECTION=GENERAL, DENSITY=7800.
1e-3, 1e-7, 1e-9, 2e-7, 3e-7
0.1, 0.3, 1.
2e11, 8e10
*CENTROID
0.01, 0.002
*SHEAR CENTER
0.003, 0.001
*BEAM SECTION, ELSET=BOXES, MATERIAL=M, SECTION=BOX
0.2, 0.1, 0.01, 0.02, 0.015, 0.012
0.1, 0.3, 1.
*RELEASE
2, S2, M1
*MATERIAL, NAME=M
*ELASTIC
2.1e11, 0.3
*DENSITY
7850.
*BOUNDARY
1, 1, 6
)",
    R"(*NODE, NSET=ALL
1, 0., 0., 0.
2, 1., 0., 0.
3, 1., 1., 0.
4, 0., 1., 0.
5, 2., 0., 0.
6, 2., 1., 0.1
7, 3., 0., 0.
8, 3., 1., 0.
9, 4., 0., 0.
10, 4., 1., 0.
*ELEMENT, TYPE=S4, ELSET=PLAIN
1, 1, 2, 3, 4
*ELEMENT, TYPE=S4, ELSET=LAYERS
2, 2, 5, 6, 3
*ELEMENT, TYPE=S4, ELSET=DIRECT
3, 5, 7, 8, 6
*ELEMENT, TYPE=M3D4, ELSET=MEMBRANE
4, 7, 9, 10, 8
*ORIENTATION, NAME=O
1., 0.2, 0.1, 0., 1., 0.3
3, 20.
*SHELL SECTION, ELSET=PLAIN, MATERIAL=M, OFFSET=0.2, DENSITY=2.
0.01, 5
*TRANSVERSE SHEAR STIFFNESS
1e6, 2e6, 1e5
*SHELL SECTION, ELSET=LAYERS, COMPOSITE, ORIENTATION=O, OFFSET=SPOS, SYMMETRIC
0.001, 3, LAMINA, 30.
0.002, 3, LAMINA, -40.
*SHELL GENERAL SECTION, ELSET=DIRECT, DENSITY=20.
1e8, 3e7, 1.2e8, 1e5, 2e5, 4e7, 1e2, 1e3
1e2, 900., 1e2, 1e2, 1e2, 300., 1000., 1e2
1e2, 1e2, 20., 30., 400.
*MEMBRANE SECTION, ELSET=MEMBRANE, MATERIAL=LAMINA
0.003
*NONSTRUCTURAL MASS, ELSET=PLAIN, UNITS=MASS PER AREA
3.
*MATERIAL, NAME=M
*ELASTIC
2.1e11, 0.3
*DENSITY
7850.
*MATERIAL, NAME=LAMINA
*ELASTIC, TYPE=LAMINA
1.4e11, 1.e10, 0.3, 5.e9, 4.e9, 3.e9
*DENSITY
1600.
*BOUNDARY
1, ENCASTRE
4, 1, 6
ALL, 6, 6
*STEP
*STATIC
*DLOAD
PLAIN, P, 3.
*CLOAD
10, 3, 2.
*END STEP
)",
    R"(*NODE, NSET=ALL
1, 0, 0, 0
2, 1, 0, 0
3, 1, 1, 0
4, 0, 1, 0
5, 0, 0, 1
6, 1, 0, 1
7, 1, 1, 1.1
8, 0, 1, 1
11, 0, 0, 1
12, 1, 0, 1
13, 1, 1, 1.1
14, 0, 1, 1
15, 0, 0, 2
16, 1, 0, 2
17, 1, 1, 2
18, 0, 1, 2
20, .3, .4, 2.5
21, 3., 3., 3.
22, 4., 3., 3.
30, 0.3, 0.2, 3.
31, 0.7, 0.2, 3.2
*NSET, NSET=TURNED
2
*ELEMENT, TYPE=C3D8, ELSET=LOW
1, 1, 2, 3, 4, 5, 6, 7, 8
*ELEMENT, TYPE=C3D8R, ELSET=HIGH
2, 11, 12, 13, 14, 15, 16, 17, 18
*SURFACE, NAME=LOWER, TYPE=ELEMENT
LOW, S2
*SURFACE, NAME=UPPER
HIGH, S1
*SURFACE, NAME=TOP
HIGH, S2
*SURFACE, NAME=CORNERS, TYPE=NODE
15, 1.
16, 2.
18, 1.
*ORIENTATION, NAME=PLY, SYSTEM=RECTANGULAR
1., 0.2, 0., 0., 1., 0.3
3, 20.
*ORIENTATION, NAME=ROUND, SYSTEM=CYLINDRICAL
0.1, 0.2, 0., 0.3, 0.2, 1.
*TRANSFORM, NSET=TURNED, TYPE=R
1., 0.3, 0., -0.3, 1., 0.2
*SOLID SECTION, ELSET=LOW, MATERIAL=ORTHO, ORIENTATION=PLY
*SOLID SECTION, ELSET=HIGH, MATERIAL=M
*MATERIAL, NAME=ORTHO
*ELASTIC, TYPE=ENGINEERING CONSTANTS
1.4e5, 1.e4, 1.2e4, 0.3, 0.25, 0.4, 5.e3, 4.e3
3.e3, 20.
1.3e5, 0.9e4, 1.1e4, 0.3, 0.25, 0.4, 4.e3, 3.e3
2.e3, 220.
*DENSITY
2.
*MATERIAL, NAME=M
*ELASTIC, TYPE=ISOTROPIC
1.e5, 0.3, 20.
0.8e5, 0.28, 120.
*DENSITY
2., 20.
1.8, 120.
*INITIAL CONDITIONS, TYPE=TEMPERATURE
ALL, 60.
*TIE, NAME=T, POSITION TOLERANCE=0.2
UPPER, LOWER
*COUPLING, CONSTRAINT NAME=C, REF NODE=20, SURFACE=CORNERS, INFLUENCE RADIUS=1.5
*DISTRIBUTING
4, 5
*KINEMATIC COUPLING, REF NODE=21, ORIENTATION=ROUND
17, 1, 2
*MPC
LINEAR, 30, 20, 21
*EQUATION
2
8, 1, 1., 22, 1, -0.5
*ELEMENT, TYPE=MASS, ELSET=POINTS
51, 20
52, 22
53, 21
54, 30
*MASS, ELSET=POINTS
3.
*ELEMENT, TYPE=ROTARYI, ELSET=TURNS
55, 20
56, 21
57, 30
58, 22
*ROTARY INERTIA, ELSET=TURNS
0.1, 0.2, 0.3, 0.01, 0.02, 0.03
*ELEMENT, TYPE=SPRING1, ELSET=GROUNDED
61, 22
*SPRING, ELSET=GROUNDED, ORIENTATION=PLY
2
10.
*ELEMENT, TYPE=SPRING2, ELSET=BETWEEN
62, 21, 22
*SPRING, ELSET=BETWEEN
2, 3
20., , 20.
10., , 120.
*ELEMENT, TYPE=DASHPOTA, ELSET=DAMPERS
63, 21, 22
*DASHPOT, ELSET=DAMPERS

5.
*BOUNDARY
1, 1, 3
4, PINNED
TURNED, 2, 2
22, 4, 6
*STEP
*STATIC
0.1, 1.
*BOUNDARY
3, 1, 1, 0.01
*CLOAD, OP=MOD
8, 3, 2.
*DLOAD
HIGH, P3, 5.
LOW, GRAV, 9.81, 0.1, 0., -1.
HIGH, CENTRIF, 4., 0.1, 0.2, 0., 0., 0.1, 1.
*DSLOAD
TOP, P, 7.
*END STEP
*STEP
*STATIC
*TEMPERATURE
ALL, 60.
*CLOAD, OP=NEW
8, 2, 2.
*BOUNDARY, OP=NEW
1, 1, 3
4, 1, 3
2, 1, 3
*END STEP
)",
    R"(*NODE, NSET=ALL
1, 0., 0., 0.
2, 1., 0., 0.
3, 2., 0., 0.
4, 0.2, 1., 0.
5, 1.1, 1., 0.
6, 2.1, 1., 0.3
7, 5., 5., 5.
8, 1., 2., 0.
*NSET, NSET=BODY
4, 5
*ELEMENT, TYPE=T3D2, ELSET=E
1, 1, 2
2, 2, 3
3, 4, 5
4, 5, 6
5, 6, 3
*SOLID SECTION, ELSET=E, MATERIAL=M
1.E-5
*MATERIAL, NAME=M
*ELASTIC
2.E11, 0.3
*DENSITY
7800.
*RIGID BODY, NSET=BODY, REF NODE=8
*ELEMENT, TYPE=DCOUP3D, ELSET=D
9, 7
*ELEMENT, TYPE=MASS, ELSET=POINTS
51, 7
52, 8
*MASS, ELSET=POINTS, TYPE=ANISOTROPIC, ORIENTATION=O
3., 4., 5.
*ORIENTATION, NAME=O, DEFINITION=NODES
5, 4, 1
*DISTRIBUTING COUPLING, ELSET=D
2, 1.
3, 2.
*AMPLITUDE, NAME=A, TIME=TOTAL TIME
0., 0., 2., 0.7
*BOUNDARY
1, 1, 3
2, 2, 3
*STEP
*STATIC
*CLOAD, AMPLITUDE=A
3, 1, 1000.
*END STEP
)",
    R"(*NODE
1, 0., 0., 0.
2, 1., 0., 0.
3, 1., 1., 0.
4, 0., 1., 0.
5, 2., 0., 0.
6, 2., 1., 0.
*ELEMENT, TYPE=S4, ELSET=E
1, 1, 2, 3, 4
2, 2, 5, 6, 3
*SHELL SECTION, ELSET=E, MATERIAL=M, NODAL THICKNESS
0.01
*NODAL THICKNESS
1, 0.02
*MATERIAL, NAME=M
*ELASTIC
2.1e11, 0.3
*DENSITY
7850.
)"};

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

std::string joined(const std::vector<std::string>& parts, const char* by) {
  std::string text;
  for (std::size_t i = 0; i < parts.size(); ++i) text += (i > 0 ? by : "") + parts[i];
  return text;
}

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> fields;
  std::istringstream stream(line);
  for (std::string field; std::getline(stream, field, ',');) {
    const auto first = field.find_first_not_of(' ');
    fields.push_back(first == std::string::npos ? "" : field.substr(first));
  }
  return fields;
}

/// A vector that shows the matrix without its order.
Eigen::VectorXd shadow(const SparseMatrix& matrix) {
  Eigen::VectorXd weights(matrix.cols());
  std::mt19937 random(1);
  for (auto& weight : weights) weight = std::uniform_real_distribution(0.5, 1.5)(random);
  return matrix * weights;
}

std::string text_of(const Eigen::VectorXd& values) {
  std::ostringstream stream;
  stream.precision(10);
  stream << values.transpose() << "\n";
  return stream.str();
}

std::string text_of(const FixedNodes& support) {
  std::string text = support.name;
  for (const auto node : support.nodes) text += " " + std::to_string(node);
  for (const bool held : support.directions) text += held ? "x" : "-";
  return text;
}

/// What a deck is for kalfem: its matrices, load cases and notes, or the problem that it has.
struct Reading {
  std::string text;
  std::vector<LedgerEntry> ledger;

  explicit Reading(const std::vector<std::string>& lines) {
    try {
      const auto deck = parse_abaqus(joined(lines, "\n") + "\n", "deck.inp", {}, {.load_cases = true, .ledger = true});
      ledger = deck.ledger;
      for (const auto& note : deck.notes) text += note_subject(note) + ": " + note.consequence + "\n";
      const auto model = assemble(deck.model);
      text += text_of(shadow(evaluate(model.stiffness, model.parameters)));
      text += text_of(shadow(evaluate(model.mass, model.parameters)));
      for (const auto& each : deck.model.constraints) text += each.name + " ";
      for (const auto& each : deck.model.links) text += each.name + " ";
      for (const auto& each : deck.model.weighted_links) text += each.name + " ";
      for (const auto& spring : deck.model.joints) text += std::to_string(spring.damping);
      for (const auto& support : deck.model.fixed) text += text_of(support);
      for (const auto& load_case : deck.load_cases) add(deck.model, load_case);
    } catch (const InvalidInput& error) {
      text = error.what();
    }
  }

  void add(const FiniteElementModel& model, const LoadCase& load_case) {
    text += text_of(nodal_forces(model, load_case)) + text_of(load_case.gravity);
    if (load_case.rotation) text += std::to_string(load_case.rotation->speed) + text_of(load_case.rotation->axis);
    for (const auto& [dof, value, of_support] : load_case.imposed)
      text += std::to_string(dof.node) + "." + std::to_string(dof.direction) + " " + std::to_string(value);
    if (load_case.supports)
      for (const auto& support : *load_case.supports) text += text_of(support);
  }

  /// Whether a field is one that the reader says not to use.
  [[nodiscard]] bool admits(const std::string& card, const std::string& field) const {
    return std::ranges::any_of(ledger, [&](const auto& entry) {
      return entry.card == card && entry.field == field && entry.fate != FieldFate::used;
    });
  }
};

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

/// *NODE, *ELEMENT and sets define what all others name; *STEP, *STATIC and *END STEP have no data that counts.
bool is_walked(const std::string& keyword) {
  static const std::set<std::string> passed = {"*NODE", "*ELEMENT", "*NSET", "*STATIC", "*END STEP"};
  return !passed.contains(keyword);
}

struct Count {
  std::size_t fields = 0, parameters = 0;
};

TEST(AbaqusLedger, NoFieldOfADataLineIsReadPast) {
  Count count;
  for (const auto& text : decks) {
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
        EXPECT_NE(Reading(changed).text, base.text)
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
  for (const auto& text : decks) {
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
