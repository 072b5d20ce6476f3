// SPDX-License-Identifier: Apache-2.0
// A mass between two elements in line under tension: f = sqrt((2 T / L + k) / m) / (2 pi), by element of either
// language. Beams have no kink at the mass: those of either language are tested against cables and columns elsewhere.
#include <gtest/gtest.h>

#include "formats/abaqus_decks.hpp"
#include "formats/nastran_decks.hpp"
#include "kalfem/model/statics/geometric_stiffness.hpp"
#include "model/fe_models.hpp"

namespace kalfem {
namespace {

constexpr double tension = 1000.0, length = 1.0, mass = 2.0, side_spring = 10.0;

struct ElementText {
  const char* name;
  std::string text;
};

/// First frequency of the mass across the elements [Hz].
double frequency(const Deck& deck) {
  const auto preload = preload_of(deck.model, deck.load_cases.front());
  const auto assembled = assemble(deck.model);
  const SparseMatrix stiffness =
      evaluate(assembled.stiffness, assembled.parameters) +
      SparseMatrix(assembled.expansion.transpose() * preload.stiffness * assembled.expansion);
  const auto modes = lowest_modes(stiffness, evaluate(assembled.mass, assembled.parameters), {.count = 1});
  return std::sqrt(modes.values[0]) / (2.0 * std::numbers::pi);
}

double expected() { return std::sqrt((2.0 * tension / length + side_spring) / mass) / (2.0 * std::numbers::pi); }

Deck abaqus_line(const std::string& elements) {
  return parse_abaqus(
      "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 2., 0., 0.\n11, .5, 0., 0.\n12, 1.5, 0., 0.\n"
      "*MATERIAL, NAME=M\n*ELASTIC\n2.E11, 0.3\n" +
          elements +
          "*ELEMENT, TYPE=MASS, ELSET=MM\n9, 2\n*MASS, ELSET=MM\n2.\n"
          "*ELEMENT, TYPE=SPRING1, ELSET=S\n8, 2\n*SPRING, ELSET=S\n2\n10.\n"
          "*BOUNDARY\n1, 1, 3\n3, 2, 3\n2, 3, 3\n*STEP\n*STATIC\n*CLOAD\n3, 1, 1000.\n*END STEP\n",
      "deck.inp", {}, {.load_cases = true});
}

Deck nastran_line(const std::string& elements) {
  return parse_nastran("SOL 101\nCEND\nSPC=1\nLOAD=5\nBEGIN BULK\nGRID,1\nGRID,2,,1.\nGRID,3,,2.\nMAT1,1,2.E11,,.3\n" +
                           elements +
                           "CONM2,9,2,,2.\nCELAS2,8,10.,2,2\nSPC1,1,123456,1\nSPC1,1,3,2\nSPC1,1,23,3\nSPC1,1,4,2,3\n"
                           "FORCE,5,3,,1000.,1.,0.,0.\nENDDATA\n",
                       "deck.bdf", {}, {.load_cases = true});
}

TEST(PreloadOfElements, EveryAxialElementOfAbaqusStiffensAcross) {
  const std::string truss = "1, 1, 2\n2, 2, 3\n";
  for (const auto& [name, text] :
       {ElementText{"T3D2", "*ELEMENT, TYPE=T3D2, ELSET=E\n" + truss + "*SOLID SECTION, ELSET=E, MATERIAL=M\n1.E-5\n"},
        ElementText{"SPRINGA", "*ELEMENT, TYPE=SPRINGA, ELSET=E\n" + truss + "*SPRING, ELSET=E\n\n2.E6\n"}})
    EXPECT_NEAR(frequency(abaqus_line(text)), expected(), 2e-3 * expected()) << name;
}

TEST(PreloadOfElements, EveryAxialElementOfNastranStiffensAcross) {
  for (const auto& [name, text] : {ElementText{"CROD", "PROD,1,1,1.-5\nCROD,1,1,1,2\nCROD,2,1,2,3\n"},
                                   ElementText{"CONROD", "CONROD,1,1,2,1,1.-5\nCONROD,2,2,3,1,1.-5\n"},
                                   ElementText{"CTUBE", "PTUBE,1,1,.01,.0004\nCTUBE,1,1,1,2\nCTUBE,2,1,2,3\n"}})
    EXPECT_NEAR(frequency(nastran_line(text)), expected(), 2e-3 * expected()) << name;
}

// Springs along fixed directions do not turn with their nodes: their force stiffens nothing, and that is said.
TEST(PreloadOfElements, ForcesInSpringsAlongFixedDirectionsAreNamed) {
  for (const auto& [name, text] :
       {ElementText{"celas",
                    "CELAS2,1,2.+6,1,1,2,1\nCELAS2,2,2.+6,2,1,3,1\nCBAR,5,5,1,2,0.,1.,0.\n"
                    "PBAR,5,1,1.-12,1.-18,1.-18,1.-18\nCBAR,6,5,2,3,0.,1.,0.\n"},
        ElementText{"cbush",
                    "PBUSH,1,K,2.+6\nCBUSH,1,1,1,2,0.,1.,0.\nCBUSH,2,1,2,3,0.,1.,0.\nCBAR,5,5,1,2,0.,1.,0.\n"
                    "PBAR,5,1,1.-12,1.-18,1.-18,1.-18\nCBAR,6,5,2,3,0.,1.,0.\n"}}) {
    const auto deck = nastran_line(text);
    const auto preload = preload_of(deck.model, deck.load_cases.front());
    ASSERT_EQ(preload.ignored.size(), 2u) << name;
    EXPECT_EQ(preload.ignored[0].find(name), 0u) << preload.ignored[0];
    EXPECT_LT(frequency(deck), 0.5 * expected()) << name;
  }
}

}  // namespace
}  // namespace kalfem
