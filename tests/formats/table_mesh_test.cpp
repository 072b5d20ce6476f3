// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/gmsh/gmsh.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "base/scratch_folder.hpp"
#include "kalfem/base/invalid_input.hpp"

namespace kalfem {
namespace {

namespace fs = std::filesystem;

class TableMesh : public testing::Test {
protected:
  Mesh read(const std::string& nodes, const std::string& elements, const TableMeshOptions& options = {}) const {
    std::ofstream(folder_ / "nodes.csv", std::ios::binary) << nodes;
    std::ofstream(folder_ / "elements.csv", std::ios::binary) << elements;
    return read_table_mesh(folder_ / "nodes.csv", folder_ / "elements.csv", options);
  }

  std::string message(const std::string& nodes, const std::string& elements,
                      const TableMeshOptions& options = {}) const {
    try {
      read(nodes, elements, options);
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "";
  }

  ScratchFolder folder_{"table-mesh"};
};

const std::string two_nodes = "node,x,y,z\n1,0,0,0\n2,1,0,0\n";
const std::string one_element = "element,node1,node2,region\n1,1,2,bar\n";

void expect_parts(const std::string& text, const std::vector<std::string>& parts) {
  for (const auto& part : parts) EXPECT_NE(text.find(part), std::string::npos) << part << "\n" << text;
}

TEST_F(TableMesh, ReadsNodesElementsAndRegions) {
  const auto mesh = read("node,x_m,y_m,z_m\n7,0.5,-1,2e-1\n3,1,0,0\n12,.25,0,0\n",
                         "elem,node1,node2,section\n5,7,3,2\n9,3,12,tail\n8,12,7,2.0\n");
  EXPECT_EQ(mesh.node_ids, (std::vector<std::int64_t>{7, 3, 12}));
  EXPECT_EQ(mesh.nodes, (Eigen::Matrix3d{{0.5, 1.0, 0.25}, {-1.0, 0.0, 0.0}, {0.2, 0.0, 0.0}}));
  ASSERT_EQ(mesh.cells.size(), 3u);
  EXPECT_EQ(mesh.cells[1].id, 9);
  EXPECT_EQ(mesh.cells[1].shape, CellShape::line2);
  EXPECT_EQ(mesh.connectivity, (std::vector<Eigen::Index>{0, 1, 1, 2, 2, 0}));
  EXPECT_EQ(mesh.regions, (std::map<std::string, std::vector<Eigen::Index>>{{"2", {0, 2}}, {"tail", {1}}}));
}

TEST_F(TableMesh, ReadsWhatSpreadsheetsWrite) {
  // Decimal commas, titles in another order and with units, a column of remarks, Windows line ends, quotes.
  const auto mesh = read(
      "\xEF\xBB\xBF# exported\r\n\"Z [mm]\";\"remark; free\";Point;Y (mm);X_mm\r\n"
      "1,5;here;1;-2;1000\r\n0;;2;0;0\r\n",
      "from\tto\tgroup\tnumber\n2\t1\tleft-wing_1\t4\n");
  EXPECT_LT((mesh.nodes.col(0) - Eigen::Vector3d(1.0, -0.002, 0.0015)).norm(), 1e-15);
  EXPECT_EQ(mesh.connectivity, (std::vector<Eigen::Index>{1, 0}));
  EXPECT_TRUE(mesh.regions.contains("left-wing_1"));
  EXPECT_EQ(mesh.cells[0].id, 4);
}

TEST_F(TableMesh, ReadsTablesWithoutTitlesInTheirOrder) {
  const auto mesh = read("1 0 0 0\n2 100 0 0\n", "1 1 2 bar\n", {.scale = 0.01});
  EXPECT_EQ(mesh.nodes(0, 1), 1.0);
  EXPECT_TRUE(mesh.regions.contains("bar"));
}

TEST_F(TableMesh, ColumnsThatAreNotReadAreTold) {
  std::vector<DeckNote> notes;
  read("node,x,y,z\n1,0,0,0\n2,1,0,0\n", one_element, {.notes = &notes});
  EXPECT_TRUE(notes.empty());
  read("node,x,y,z,temperature\n1,0,0,0,20\n2,1,0,0,20\n", "element,node1,node2,region,roll\n1,1,2,bar,30\n",
       {.notes = &notes});
  ASSERT_EQ(notes.size(), 2u);
  EXPECT_EQ(notes[0].what, "column 'temperature'");
  EXPECT_EQ(notes[1].what, "column 'roll'");
  EXPECT_NE(notes[1].where.file.find("elements.csv"), std::string::npos);
}

TEST_F(TableMesh, ScaleAndUnitsExcludeEachOther) {
  EXPECT_EQ(read(two_nodes, one_element, {.scale = 0.001}).nodes(0, 1), 0.001);
  expect_parts(message("node,x_mm,y,z\n1,0,0,0\n", one_element, {.scale = 0.001}),
               {"nodes.csv", "'x' states its unit, and a scale is given too", "remove the scale"});
}

TEST_F(TableMesh, ProblemsOfTheNodesAreToldTogether) {
  expect_parts(message("node,x,y,z\n1,0,0,0\n1,1,0,0\n2.5,0,,0\n3,0,nan,1e999\n4,0\n", one_element),
               {"nodes.csv:3: node 1 is defined twice", "line 2 already defines it", "nodes.csv:4: node '2.5'",
                "nodes.csv:4: y is ''", "nodes.csv:5: y is 'nan'", "nodes.csv:5: z is '1e999'",
                "nodes.csv:6: the line has 2 cells"});
}

TEST_F(TableMesh, ProblemsOfTheElementsAreToldTogether) {
  const std::string elements =
      "element,node1,node2,region\n1,1,2,bar\n1,1,3,bar\n2,1,1,bar\n3,x,2,bar\n4,1,2,wing tip\n5,1,2,\n";
  expect_parts(message(two_nodes, elements),
               {"elements.csv:3: element 1 is defined twice", "elements.csv:3: there is no node 3",
                "elements.csv:4: element 2 has the length 0", "elements.csv:5: node 'x' is not a number",
                "elements.csv:6: the region is 'wing tip'", "elements.csv:7: the region is ''"});
  EXPECT_NE(message("node,x,y,z\n1,1e3,0,0\n2,1000,0,0\n", one_element).find("has the length 0"), std::string::npos);
}

TEST_F(TableMesh, TitlesAndUnitsThatAreNotUnderstoodAreNamed) {
  expect_parts(message("node,x_kg,y,w\n1,0,0,0\n", one_element),
               {"nodes.csv:1: the column 'x' is in 'kg'", "nodes.csv:1: there is no column 'z'"});
  expect_parts(message("node,x,x,y,z\n1,0,0,0,0\n", one_element), {"two columns are named 'x'"});
  expect_parts(message(two_nodes, "element,node1,nod2,region\n1,1,2,bar\n"),
               {"elements.csv:1: there is no column 'node2' (did you mean 'nod2'?)"});
  expect_parts(message("", one_element), {"nodes.csv", "has no data"});
  EXPECT_NE(message(two_nodes, "# nothing\nelement,n1,n2,region\n").find("has no data"), std::string::npos);
}

TEST_F(TableMesh, MissingFilesAreNamed) {
  EXPECT_THROW(read_table_mesh(folder_ / "none.csv", folder_ / "none.csv"), InvalidInput);
}

}  // namespace
}  // namespace kalfem
