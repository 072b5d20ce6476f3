// SPDX-License-Identifier: Apache-2.0
// Materials that depend on temperature, at the temperature that the deck or the user states.
#include <gtest/gtest.h>

#include "formats/abaqus_decks.hpp"
#include "formats/nastran_decks.hpp"

namespace kalfem {
namespace {

std::string abaqus_cube(const std::string& material, const std::string& more = "") {
  return "*NODE, NSET=ALL\n1, 0, 0, 0\n2, 1, 0, 0\n3, 1, 1, 0\n4, 0, 1, 0\n5, 0, 0, 1\n6, 1, 0, 1\n7, 1, 1, 1\n8, 0, "
         "1, "
         "1\n*ELEMENT, TYPE=C3D8, ELSET=E\n1, 1, 2, 3, 4, 5, 6, 7, 8\n*SOLID SECTION, ELSET=E, MATERIAL=M\n*MATERIAL, "
         "NAME=M\n" +
         material + more;
}

Deck abaqus(const std::string& text, std::optional<double> temperature = {}) {
  return parse_abaqus(text, "deck.inp", {}, {.temperature = temperature});
}

IsotropicMaterial material_of(const Deck& deck) { return deck.model.materials.begin()->second; }

const std::string two_rows = "*ELASTIC\n200., 0.3, 20.\n100., 0.2, 120.\n*DENSITY\n8., 20.\n6., 120.\n";
const std::string warm = "*INITIAL CONDITIONS, TYPE=TEMPERATURE\nALL, 45.\n";

TEST(AbaqusTemperature, IsTheInitialOneOfTheDeck) {
  const auto material = material_of(abaqus(abaqus_cube(two_rows, warm)));
  EXPECT_DOUBLE_EQ(material.youngs_modulus, 175.0);
  EXPECT_DOUBLE_EQ(material.poissons_ratio, 0.275);
  EXPECT_DOUBLE_EQ(material.density, 7.5);
}

TEST(AbaqusTemperature, MayBeStated) {
  const auto modulus = [](double temperature) {
    return material_of(abaqus(abaqus_cube(two_rows, warm), temperature)).youngs_modulus;
  };
  EXPECT_DOUBLE_EQ(modulus(70.0), 150.0);
  EXPECT_DOUBLE_EQ(modulus(-50.0), 200.0);
  EXPECT_DOUBLE_EQ(modulus(500.0), 100.0);
  EXPECT_TRUE(test::has_note(abaqus(abaqus_cube(two_rows), 500.0), "its values go from 20 to 120"));
  EXPECT_FALSE(test::has_note(abaqus(abaqus_cube(two_rows), 120.0), "its values go from"));
}

TEST(AbaqusTemperature, IsZeroWithANoteWhereTheDeckStatesNone) {
  const auto deck = abaqus(abaqus_cube("*ELASTIC\n200., 0.3, -100.\n100., 0.2, 100.\n"));
  EXPECT_DOUBLE_EQ(material_of(deck).youngs_modulus, 150.0);
  EXPECT_TRUE(test::has_note(deck, "states no initial temperature"));
  EXPECT_FALSE(test::has_note(abaqus(abaqus_cube(two_rows), 20.0), "states no initial temperature"));
}

TEST(AbaqusTemperature, MustBeOneForAll) {
  const auto uneven = abaqus_cube(two_rows, warm + "5, 60.\n");
  try {
    abaqus(uneven);
    ADD_FAILURE() << "the deck was read";
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("initial temperatures from 45 to 60"), std::string::npos) << error.what();
  }
  EXPECT_DOUBLE_EQ(material_of(abaqus(uneven, 70.0)).youngs_modulus, 150.0);
  EXPECT_DOUBLE_EQ(material_of(abaqus(abaqus_cube("*ELASTIC\n200., 0.3\n", warm + "5, 60.\n"))).youngs_modulus, 200.0);
}

/// Nine constants stand in two lines, and the temperature behind the ninth.
TEST(AbaqusTemperature, TurnsOrthotropicConstants) {
  const std::string rows =
      "*ELASTIC, TYPE=ENGINEERING CONSTANTS\n10., 20., 30., 0., 0., 0., 4., 5.\n6., 0.\n30., 40., 50., 0., 0., 0., 6., "
      "7.\n8., 100.\n";
  const auto deck = abaqus(abaqus_cube(rows), 50.0);
  const auto& solid = std::get<SolidProperty>(deck.model.properties.begin()->second);
  ASSERT_TRUE(solid.elasticity);
  const Eigen::Vector<double, 6> expected(20.0, 30.0, 40.0, 5.0, 7.0, 6.0);  // xx yy zz xy yz xz
  EXPECT_LE((solid.elasticity->diagonal() - expected).norm(), 1e-13);
}

std::string refusal_of(const std::string& material) {
  try {
    abaqus(abaqus_cube(material));
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

/// Constants that cannot be used are told once, not again by the sections that use the material.
TEST(AbaqusTemperature, NeedsFullRows) {
  const auto refused = refusal_of("*ELASTIC, TYPE=ORTHOTROPIC\n1., 0., 1., 0., 0., 1., 1., 1.\n");
  EXPECT_NE(refused.find("*ELASTIC has 8 constants: its type has 9"), std::string::npos) << refused;
  EXPECT_EQ(std::ranges::count(refused, '\n'), 0) << refused;
}

TEST(AbaqusMaterials, NeedPositiveStrainEnergy) {
  for (const char* constants : {"ORTHOTROPIC\n1., 9., 1., 9., 9., 1., 5., 5.\n5.\n",
                                "ENGINEERING CONSTANTS\n1., 1., 1., .9, .9, .9, 5., 5.\n5.\n"}) {
    const auto refused = refusal_of(std::string("*ELASTIC, TYPE=") + constants);
    EXPECT_NE(refused.find("the elastic constants of 'M' are not positive"), std::string::npos) << refused;
    EXPECT_EQ(std::ranges::count(refused, '\n'), 0) << refused;
  }
}

// --- Nastran ---------------------------------------------------------------------------------------------------------

/// A rod between two nodes; material 1 has E = 70 and depends on temperature by table 5.
std::string rod(const std::string& table, const std::string& more = "") {
  return "GRID,1,,0.,0.,0.,,123456\nGRID,2,,1.,0.,0.,,23456\nMAT1,1,70.,,.3,2.\nMATT1,1,5\nPROD,1,1,1.\nCROD,1,1,1,"
         "2\n" +
         table + more;
}

Deck hot(const std::string& text, std::optional<double> temperature = {}) {
  return parse_nastran(text, "deck.bdf", {}, {.temperature = temperature});
}

double modulus(const std::string& text, std::optional<double> temperature = {}) {
  return material_of(hot(text, temperature)).youngs_modulus;
}

std::string problem(const std::string& text, std::optional<double> temperature = {}) {
  try {
    hot(text, temperature);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

const std::string values = "TABLEM1,5\n,0.,80.,100.,60.,200.,50.,ENDT\n";

/// Within the table and, by its last two points, beyond it.
TEST(NastranTemperature, FollowsTables) {
  EXPECT_DOUBLE_EQ(modulus(rod(values), 50.0), 70.0);
  EXPECT_DOUBLE_EQ(modulus(rod(values), 100.0), 60.0);
  EXPECT_DOUBLE_EQ(modulus(rod(values), 300.0), 40.0);
  EXPECT_DOUBLE_EQ(modulus(rod("TABLEM2,5,20.\n,0.,1.,100.,.5,ENDT\n"), 70.0), 70.0 * 0.75);
  EXPECT_DOUBLE_EQ(modulus(rod("TABLEM3,5,20.,10.\n,0.,1.,10.,.5,ENDT\n"), 70.0), 70.0 * 0.75);
  const std::string polynomial = "TABLEM4,5,20.,10.,0.,100.\n,1.,-.1,.01,ENDT\n";
  EXPECT_DOUBLE_EQ(modulus(rod(polynomial), 40.0), 70.0 * (1.0 - 0.2 + 0.04));
  EXPECT_DOUBLE_EQ(modulus(rod(polynomial), 900.0), 70.0 * (1.0 - 0.8 + 0.64));  // at X4
}

TEST(NastranTemperature, IsThatOfTheChosenSet) {
  const std::string sets = "TEMPD,8,50.\nTEMPD,9,100.\nENDDATA\n";
  EXPECT_DOUBLE_EQ(modulus("SOL 103\nTEMPERATURE(MATERIAL) = 9\nCEND\nBEGIN BULK\n" + rod(values, sets)), 60.0);
  EXPECT_DOUBLE_EQ(modulus("SOL 103\nCEND\nTEMP(BOTH) = 8\nBEGIN BULK\n" + rod(values, sets)), 70.0);
  EXPECT_DOUBLE_EQ(modulus(rod(values, "TEMP,9,1,100.,2,100.\n")), 60.0);  // the only one
  const auto none = hot("SOL 103\nCEND\nTEMP(LOAD) = 8\nBEGIN BULK\n" + rod(values, sets));
  EXPECT_DOUBLE_EQ(material_of(none).youngs_modulus, 70.0);
  EXPECT_TRUE(test::has_note(none, "the values of the MATi cards are used"));
}

TEST(NastranTemperature, IsRefusedWhereItIsNotOne) {
  EXPECT_NE(problem(rod(values, "TEMP,9,1,100.,2,90.\n")).find("go from 90 to 100"), std::string::npos);
  EXPECT_NE(problem(rod(values, "TEMP,9,1,100.\n")).find("grid point 2 has no temperature"), std::string::npos);
  EXPECT_NE(problem(rod(""), 20.0).find("there is no TABLEMi 5"), std::string::npos);
  EXPECT_NE(problem(rod("TABLEM1,5\n,0.,80.,ENDT\n"), 20.0).find("at least two"), std::string::npos);
  EXPECT_NE(problem(rod("TABLEM1,5,LOG\n,1.,80.,2.,70.,ENDT\n"), 20.0).find("logarithmic"), std::string::npos);
  EXPECT_NE(problem(rod(values, "MATT8,1,5\n"), 20.0), "");
  EXPECT_NE(problem(rod(values, "MATT2,2,5\n"), 20.0).find("there is no MAT2 of this number"), std::string::npos);
}

TEST(NastranTemperature, TurnsOrthotropicConstants) {
  const std::string plate =
      "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,1.,1.,0.\nGRID,4,,0.,1.,0.\nCQUAD4,1,1,1,2,3,4,0.\nPCOMP,1\n,1,.01,"
      "0."
      "\nMAT8,1,70.,10.,.3,5.,5.,5.,2.\n";
  const auto stiffness = [&](const std::string& more) {
    const auto deck = hot(plate + more, more.empty() ? std::nullopt : std::optional(100.0));
    return std::get<LaminateProperty>(deck.model.properties.begin()->second).stiffness.membrane;
  };
  const auto nominal = stiffness(""), halved = stiffness("MATT8,1,,,,6\nTABLEM2,6,0.\n,0.,1.,100.,.5,ENDT\n");
  EXPECT_DOUBLE_EQ(halved(2, 2), 0.5 * nominal(2, 2));
  EXPECT_DOUBLE_EQ(halved(0, 0), nominal(0, 0));
  const std::string cube =
      "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,1.,1.,0.\nGRID,4,,0.,1.,0.\nGRID,5,,0.,0.,1.\nGRID,6,,1.,0.,1."
      "\nGRID,7,,"
      "1.,1.,1.\nGRID,8,,0.,1.,1.\nCHEXA,1,1,1,2,3,4,5,6\n,7,8\nPSOLID,1,1\nMAT9,1,9.,1.,1.,,,,9.\n,1.,,,,9.,,,\n,4.,,,"
      "4."
      ",,4.,2.\n";
  const auto deck =
      hot(cube + "MATT9,1,6,7\nTABLEM2,6,0.\n,0.,1.,100.,2.,ENDT\nTABLEM2,7,0.\n,0.,1.,100.,3.,ENDT\n", 100.0);
  const auto& solid = std::get<SolidProperty>(deck.model.properties.begin()->second);
  EXPECT_DOUBLE_EQ((*solid.elasticity)(0, 0), 18.0);
  EXPECT_DOUBLE_EQ((*solid.elasticity)(0, 1), 3.0);
  EXPECT_DOUBLE_EQ((*solid.elasticity)(1, 0), 3.0);
  EXPECT_DOUBLE_EQ((*solid.elasticity)(1, 1), 9.0);
}

}  // namespace
}  // namespace kalfem
