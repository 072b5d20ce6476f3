// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "kalfem/formats/gmsh/gmsh.hpp"

// What stands in a Gmsh file is used, or told: each section and field is added to a small mesh in turn.
namespace kalfem {
namespace {

const std::string names = "$PhysicalNames\n1\n2 1 \"plate\"\n$EndPhysicalNames\n";
const std::string entities = "$Entities\n0 0 1 0\n1 0 0 0 1 1 0 1 1 0\n$EndEntities\n";
const std::string nodes = "$Nodes\n1 4 1 4\n2 1 0 4\n1\n2\n3\n4\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n$EndNodes\n";
const std::string elements = "$Elements\n1 1 1 1\n2 1 3 1\n1 1 2 3 4\n$EndElements\n";
const std::string head4 = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n", head2 = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n";
const std::string nodes2 = "$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n$EndNodes\n";

std::vector<DeckNote> notes_of(const std::string& text) {
  std::vector<DeckNote> notes;
  const Mesh mesh = parse_gmsh(text, "mesh.msh", &notes);
  EXPECT_EQ(mesh.regions.at("plate").size(), 1u) << text;
  return notes;
}

/// The only note.
std::string told(const std::string& text) {
  const auto notes = notes_of(text);
  return notes.size() == 1 ? notes[0].what + ": " + notes[0].consequence : std::to_string(notes.size()) + " notes";
}

TEST(GmshNotes, AreEmptyForAMeshThatIsUsedWhole) {
  EXPECT_TRUE(notes_of(head4 + names + entities + nodes + elements).empty());
  EXPECT_TRUE(notes_of("$Comments\nby hand\n$EndComments\n" + head4 + names + entities + nodes + elements).empty());
  EXPECT_TRUE(notes_of(head2 + names + nodes2 + "$Elements\n1\n1 3 2 1 1 1 2 3 4\n$EndElements\n").empty());
}

TEST(GmshNotes, NameEverySectionThatIsNotUsed) {
  for (const std::string section : {"Periodic", "NodeData", "ElementData", "ElementNodeData", "InterpolationScheme",
                                    "GhostElements", "Parametrizations", "SomethingNew"}) {
    const auto notes =
        notes_of(head4 + names + entities + nodes + elements + "$" + section + "\n0\n$End" + section + "\n");
    ASSERT_EQ(notes.size(), 1u) << section;
    EXPECT_EQ(notes[0].what, "$" + section);
    EXPECT_FALSE(notes[0].consequence.empty()) << section;
    EXPECT_EQ(notes[0].where.line, 29) << section;
    EXPECT_EQ(notes[0].kind, DeckNoteKind::unused) << section;
  }
}

TEST(GmshNotes, NameFieldsThatAreNotUsed) {
  const std::string parametric =
      "$Nodes\n1 4 1 4\n2 1 1 4\n1\n2\n3\n4\n0 0 0 .1 .2\n1 0 0 .1 .2\n1 1 0 .1 .2\n0 1 0 .1 .2\n$EndNodes\n";
  EXPECT_NE(told(head4 + names + entities + parametric + elements).find("parametric coordinates"), std::string::npos);
  const std::string ghosts = "$PartitionedEntities\n2\n1\n7 1\n0 0 0 0\n$EndPartitionedEntities\n";
  EXPECT_NE(told(head4 + names + entities + ghosts + nodes + elements).find("ghost entities"), std::string::npos);
  const std::string parts =
      "$PartitionedEntities\n2\n0\n0 0 1 0\n1 2 1 1 1 0 0 0 1 1 0 1 1 0\n$EndPartitionedEntities\n";
  EXPECT_NE(told(head4 + names + parts + nodes + elements).find("partitions of entities"), std::string::npos);
  EXPECT_NE(told(head2 + names + nodes2 + "$Elements\n1\n1 3 4 1 1 1 2 1 2 3 4\n$EndElements\n")
                .find("further tags of elements"),
            std::string::npos);
}

TEST(GmshNotes, NameGroupsWithoutCellsAndCellsWithoutGroup) {
  const std::string two = "$PhysicalNames\n2\n2 1 \"plate\"\n3 4 \"block\"\n$EndPhysicalNames\n";
  EXPECT_NE(told(head4 + two + entities + nodes + elements).find("physical group 'block'"), std::string::npos);
  EXPECT_NE(told(head2 + names + nodes2 + "$Elements\n2\n1 3 2 1 1 1 2 3 4\n2 1 2 0 1 1 2\n$EndElements\n")
                .find("1 cells without a physical group"),
            std::string::npos);
}

// Every number of a node or an element that has a meaning for the mesh changes it.
TEST(GmshNotes, NoFieldOfNodesAndElementsIsReadPast) {
  const auto mesh_of = [](const std::string& text) { return parse_gmsh(text, "mesh.msh"); };
  const Mesh mesh = mesh_of(head4 + names + entities + nodes + elements);
  for (const auto& [from, to] : {std::pair<std::string, std::string>{"1 1 0\n", "1 1 .5\n"},
                                 {"1 0 0\n", "1.5 0 0\n"},
                                 {"0 1 0\n", "0 1.5 0\n"}}) {
    std::string changed = nodes;
    changed.replace(changed.rfind("\n" + from) + 1, from.size(), to);
    EXPECT_NE(mesh_of(head4 + names + entities + changed + elements).nodes, mesh.nodes) << from;
  }
  EXPECT_NE(mesh_of(head4 + names + entities + nodes + "$Elements\n1 1 1 1\n2 1 3 1\n1 2 3 4 1\n$EndElements\n")
                .nodes_of(mesh.cells[0])[0],
            mesh.nodes_of(mesh.cells[0])[0]);
  EXPECT_THROW(mesh_of(head4 + names + entities + nodes + "$Elements\n1 1 1 1\n2 1 99 1\n1 1 2 3 4\n$EndElements\n"),
               InvalidInput);
}

}  // namespace
}  // namespace kalfem
