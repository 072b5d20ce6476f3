// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "formats/abaqus_decks.hpp"

namespace kalfem {
namespace {

using Eigen::Index;

const std::string bar =
    "*PART, NAME=Bar\n*NODE\n1,0,0,0\n2,1,0,0\n3,2,0,0\n*ELEMENT, TYPE=B31, ELSET=All\n1,1,2\n2,2,3\n*NSET, "
    "NSET=End\n3\n"
    "*BEAM SECTION, ELSET=All, MATERIAL=steel, SECTION=RECT\n0.1, 0.2\n0., 0., 1.\n*END PART\n";

Index node_of(const Mesh& mesh, std::int64_t id) { return NodeFinder(mesh).find(id); }

TEST(AbaqusAssembly, OneInstanceKeepsItsNumbers) {
  const auto deck = parse_deck(bar +
                               "*ASSEMBLY, NAME=A\n*INSTANCE, NAME=Bar-1, PART=bar\n5., 0., 0.\n*END INSTANCE\n"
                               "*NSET, NSET=Tip, INSTANCE=Bar-1\n3\n*END ASSEMBLY\n" +
                               deck_steel + "*BOUNDARY\nBar-1.1, ENCASTRE\n");
  const auto& mesh = deck.model.mesh;
  EXPECT_EQ(mesh.node_ids, (std::vector<std::int64_t>{1, 2, 3}));
  EXPECT_TRUE(mesh.nodes.col(2).isApprox(Eigen::Vector3d(7, 0, 0)));
  EXPECT_EQ(mesh.node_sets.at("Tip"), std::vector<Index>{2});
  EXPECT_EQ(mesh.node_sets.at("Bar-1.End"), std::vector<Index>{2});
  EXPECT_EQ(mesh.regions.at("Bar-1.All").size(), 2u);
  ASSERT_EQ(deck.model.fixed.size(), 1u);
  EXPECT_EQ(deck.model.fixed.front().nodes, std::vector<Index>{0});
  EXPECT_TRUE(deck.notes.empty());
}

// First the translation, then the rotation by 90 degrees about a line along z through (1, 0, 0).
const std::string two_bars =
    bar +
    "*ASSEMBLY, NAME=A\n*INSTANCE, NAME=Bar-1, PART=Bar\n*END INSTANCE\n*INSTANCE, NAME=Bar-2, PART=Bar\n"
    "1., 0., 0.\n1., 0., 0., 1., 0., 1., 90.\n*END INSTANCE\n*NODE\n1, 9., 9., 9.\n"
    "*ELEMENT, TYPE=SPRING2, ELSET=s\n7, Bar-1.3, Bar-2.3\n*SPRING, ELSET=s\n3, 3\n100.\n"
    "*ELEMENT, TYPE=SPRING1, ELSET=g\n8, 1\n*SPRING, ELSET=g\n1\n5.\n*END ASSEMBLY\n" +
    deck_steel;

TEST(AbaqusAssembly, CollidingNumbersAreRaisedByPowersOfTen) {
  const auto deck = parse_deck(two_bars);
  const auto& mesh = deck.model.mesh;
  ASSERT_EQ(mesh.node_count(), 7);
  EXPECT_EQ(mesh.nodes(0, node_of(mesh, 3)), 2.0);                                    // first instance
  EXPECT_TRUE(mesh.nodes.col(node_of(mesh, 13)).isApprox(Eigen::Vector3d(1, 2, 0)));  // second, raised by 10
  EXPECT_TRUE(mesh.nodes.col(node_of(mesh, 21)).isApprox(Eigen::Vector3d(9, 9, 9)));  // outside of instances
  EXPECT_EQ(deck.notes.size(), 2u);
}

TEST(AbaqusAssembly, ElementsOfTheAssemblyTakeNodesOfInstances) {
  const auto deck = parse_deck(two_bars);
  ASSERT_EQ(deck.model.springs.size(), 2u);
  const auto& spring = deck.model.springs[0];
  EXPECT_EQ(deck.model.mesh.node_ids[static_cast<std::size_t>(spring.from.node)], 3);
  EXPECT_EQ(deck.model.mesh.node_ids[static_cast<std::size_t>(spring.to->node)], 13);
}

// Sections turn with their instance: direction 1 stays z here, and the second bar runs along y.
TEST(AbaqusAssembly, AnInstanceTurnsItsDirections) {
  std::string deck = two_bars;
  deck.replace(deck.find("0., 0., 1.\n*END PART"), 10, "0., 1., 0.");
  const auto model = parse_deck(deck).model;
  EXPECT_TRUE(
      std::get<BeamProperty>(model.properties.at("Bar-2.All")).placement(0).up.isApprox(-Eigen::Vector3d::UnitX()));
}

TEST(AbaqusAssembly, UnknownPartsAndInstancesAreTold) {
  try {
    parse_deck(bar + "*ASSEMBLY, NAME=A\n*INSTANCE, NAME=I, PART=None\n*END INSTANCE\n*END ASSEMBLY\n" + deck_steel +
               "*BOUNDARY\nNowhere.1, 1\n");
    FAIL() << "the deck was read";
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("unknown part 'None'"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace kalfem
