// SPDX-License-Identifier: Apache-2.0
// Shells of layers and of one material in static decks that give no density: a strip that is pulled and bent.
#include <gtest/gtest.h>

#include "kalfem/formats/abaqus.hpp"
#include "kalfem/formats/nastran.hpp"
#include "kalfem/model/statics/statics.hpp"

namespace kalfem::test {
namespace {

/// A grid of points over 1 m x 0.2 m; of quadratic elements those that have midside nodes.
struct Grid {
  int step;  ///< points a side: 2 of quadratic elements

  [[nodiscard]] int number(int i, int j) const { return 1 + i * (2 * step + 1) + j; }
  [[nodiscard]] int count_u() const { return 10 * step; }
  [[nodiscard]] int count_v() const { return 2 * step; }
  /// Calls visit(corners and midsides of a square, around from its first corner).
  template <typename Visit>
  void for_each_square(const Visit& visit) const {
    for (int i = 0; i < count_u(); i += step)
      for (int j = 0; j < count_v(); j += step) visit(i, j);
  }
  /// Parts of a force that is spread over the end, along the shape functions.
  [[nodiscard]] double share(int j) const {
    if (step == 1) return (j == 0 || j == 2 ? 0.25 : 0.5);
    return j % 2 == 1 ? 1.0 / 3.0 : (j == 0 || j == 4 ? 1.0 / 12.0 : 1.0 / 6.0);
  }
};

constexpr double pull = 1e4, lift = 1.0, width = 0.2, young = 1e10, core = 2e9;

/// E A and E I of faces of 2 mm and a core of 6 mm, or of one material, 10 mm.
struct Stiffness {
  double axial, bending;
};
constexpr Stiffness sandwich = {width * (young * 0.004 + core * 0.006),
                                width*(young*(1e-6 - 0.216e-6) + core * 0.216e-6) / 12.0};
constexpr Stiffness plate = {width * young * 0.01, width* young * 1e-6 / 12.0};

void expect_strip(const Deck& deck, std::int64_t tip, const Stiffness& stiffness, bool bends = true) {
  ASSERT_EQ(deck.load_cases.size(), 1u);
  const auto moved = solve_statics(deck.model, deck.load_cases[0]).displacements;
  const auto node = NodeFinder(deck.model.mesh).find(tip);
  EXPECT_NEAR(moved[6 * node] * stiffness.axial / pull, 1.0, 1e-6);
  if (bends) {
    EXPECT_NEAR(moved[6 * node + 2] * 3.0 * stiffness.bending / lift, 1.0, 4e-3);
  }
}

std::string composite_deck(const std::string& type) {
  const bool is_triangle = type[1] == '3' || type[1] == '6';
  const Grid grid{type[1] == '6' || type[1] == '8' ? 2 : 1};
  std::string cells, nodes, root, loads;
  std::vector<bool> used(static_cast<std::size_t>(grid.number(grid.count_u(), grid.count_v())) + 1, false);
  int count = 0;
  const auto add = [&](int i, int j, const std::vector<std::pair<int, int>>& places) {
    cells += std::to_string(++count);
    for (const auto& [u, v] : places) {
      const int number = grid.number(i + u, j + v);
      used[static_cast<std::size_t>(number)] = true;
      cells += ", " + std::to_string(number);
    }
    cells += "\n";
  };
  grid.for_each_square([&](int i, int j) {
    if (type[1] == '3') {
      add(i, j, {{0, 0}, {1, 0}, {1, 1}});
      add(i, j, {{0, 0}, {1, 1}, {0, 1}});
    } else if (type[1] == '6') {
      add(i, j, {{0, 0}, {2, 0}, {2, 2}, {1, 0}, {2, 1}, {1, 1}});
      add(i, j, {{0, 0}, {2, 2}, {0, 2}, {1, 1}, {1, 2}, {0, 1}});
    } else if (type[1] == '4') {
      add(i, j, {{0, 0}, {1, 0}, {1, 1}, {0, 1}});
    } else {
      add(i, j, {{0, 0}, {2, 0}, {2, 2}, {0, 2}, {1, 0}, {2, 1}, {1, 2}, {0, 1}});
    }
  });
  for (int i = 0; i <= grid.count_u(); ++i)
    for (int j = 0; j <= grid.count_v(); ++j) {
      const int number = grid.number(i, j);
      if (!used[static_cast<std::size_t>(number)]) continue;
      nodes += std::to_string(number) + ", " + std::to_string(1.0 * i / grid.count_u()) + ", " +
               std::to_string(0.2 * j / grid.count_v()) + ", 0.\n";
      if (i == 0) root += std::to_string(number) + ", 1, 6\n";
      if (i == grid.count_u())
        for (const auto& [direction, force] : {std::pair{1, pull}, {3, lift}})
          loads += std::to_string(number) + ", " + std::to_string(direction) + ", " +
                   std::to_string(grid.share(j) * force) + "\n";
    }
  EXPECT_EQ(count, is_triangle ? 40 : 20);
  return "*NODE\n" + nodes + "*ELEMENT, ELSET=E, TYPE=" + type + "\n" + cells +
         "*MATERIAL, NAME=FACE\n*ELASTIC\n1e10, 0.\n*MATERIAL, NAME=CORE\n*ELASTIC\n2e9, 0.\n*ORIENTATION, NAME=O\n1., "
         "0., 0., 0., 1., 0.\n*SHELL SECTION, ELSET=E, COMPOSITE, ORIENTATION=O\n.002, , FACE, O\n.006, , CORE, O\n"
         ".002, , FACE, O\n*BOUNDARY\n" +
         root + "*STEP\n*STATIC\n*CLOAD\n" + loads + "*END STEP\n";
}

class CompositeStatics : public testing::TestWithParam<std::string> {};

TEST_P(CompositeStatics, NeedNoDensity) {
  const Grid grid{GetParam()[1] == '6' || GetParam()[1] == '8' ? 2 : 1};
  const auto deck = parse_abaqus(composite_deck(GetParam()), "deck.inp", {}, {.load_cases = true});
  expect_strip(deck, grid.number(grid.count_u(), grid.count_v() / 2), sandwich);
}

INSTANTIATE_TEST_SUITE_P(Elements, CompositeStatics, testing::Values("S3", "S3R", "S4", "S4R", "S6", "S8", "S8R"),
                         [](const auto& each) { return each.param; });

struct NastranShell {
  const char* name;
  std::string cards;
  Stiffness stiffness;
  bool bends;
};
void PrintTo(const NastranShell& shell, std::ostream* stream) { *stream << shell.name; }

std::string nastran_deck(const NastranShell& shell, bool triangles) {
  const Grid grid{1};
  std::string text = "SOL 101\nCEND\nSPC = 1\nLOAD = 2\nBEGIN BULK\n" + shell.cards;
  for (int i = 0; i <= 10; ++i)
    for (int j = 0; j <= 2; ++j)
      text += "GRID," + std::to_string(grid.number(i, j)) + ",," + std::to_string(0.1 * i) + "," +
              std::to_string(0.1 * j) + ",0.\n";
  int count = 0;
  const auto add = [&](const char* card, std::initializer_list<int> nodes) {
    text += card + std::string(",") + std::to_string(++count) + ",1";
    for (const int node : nodes) text += "," + std::to_string(node);
    text += ",0.\n";
  };
  grid.for_each_square([&](int i, int j) {
    const int a = grid.number(i, j), b = grid.number(i + 1, j), c = grid.number(i + 1, j + 1),
              d = grid.number(i, j + 1);
    if (triangles) {
      add("CTRIA3", {a, b, c});
      add("CTRIA3", {a, c, d});
    } else {
      add("CQUAD4", {a, b, c, d});
    }
  });
  text += "SPC1,1,123456,1,2,3\n";
  if (!shell.bends) text += "SPC1,1,345,4,THRU,33\n";
  for (int j = 0; j <= 2; ++j)
    text += "FORCE,2," + std::to_string(grid.number(10, j)) + ",," + std::to_string(grid.share(j)) + ",1.+4,0.," +
            (shell.bends ? "1.\n" : "0.\n");
  return text + "ENDDATA\n";
}

class NastranShellStatics : public testing::TestWithParam<NastranShell> {};

TEST_P(NastranShellStatics, NeedNoDensity) {
  for (const bool triangles : {false, true}) {
    const auto deck = parse_nastran(nastran_deck(GetParam(), triangles), "deck.bdf", {}, {.load_cases = true});
    expect_strip(deck, Grid{1}.number(10, 1), GetParam().stiffness, GetParam().bends);
  }
}

const std::string mat8 = "MAT8,1,1.+10,1.+10,0.,5.+9,5.+9,5.+9\n";
INSTANTIATE_TEST_SUITE_P(
    Properties, NastranShellStatics,
    testing::Values(NastranShell{"MembraneOfMat1", "MAT1,1,1.+10,,0.\nPSHELL,1,1,.01\n", plate, false},
                    NastranShell{"MembraneOfMat8", mat8 + "PSHELL,1,1,.01\n", plate, false},
                    NastranShell{"PlateOfMat1", "MAT1,1,1.+10,,0.\nPSHELL,1,1,.01,1,,1\n", plate, true},
                    NastranShell{"PlateOfMat2", "MAT2,1,1.+10,0.,0.,1.+10,0.,5.+9\nPSHELL,1,1,.01,1\n", plate, true},
                    NastranShell{"PlateOfMat8", mat8 + "PSHELL,1,1,.01,1,,1\n", plate, true},
                    NastranShell{"Pcomp", mat8 + "MAT1,2,2.+9,,0.\nPCOMP,1\n,1,.002,0.,,2,.006,0.\n,1,.002,0.\n",
                                 sandwich, true}),
    [](const auto& each) { return std::string(each.param.name); });

}  // namespace
}  // namespace kalfem::test
