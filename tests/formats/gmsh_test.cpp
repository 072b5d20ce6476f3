// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/gmsh/gmsh.hpp"
#include "base/absent.hpp"
#include "base/places.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>

#include "base/scratch_folder.hpp"
#include "kalfem/base/invalid_input.hpp"
#include "kalfem/formats/gmsh/gmsh_builder.hpp"

namespace kalfem {
namespace {

namespace fs = std::filesystem;
using Indices = std::vector<Eigen::Index>;

// A quadrilateral with a triangle beside it, an edge and a corner, in groups with and without a name.
const std::string ascii2 = R"($MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
2
1 2 "front edge"
2 1 "a plate"
$EndPhysicalNames
$Nodes
5
40 0 0 0
7 1 0 0
1000000 1 1 0
3 0 +1 0
12 2.5 5e-1 -0.25
$EndNodes
$Elements
5
1 15 2 7 3 40
2 1 2 2 1 40 7
3 3 2 1 1 40 7 1000000 3
4 3 2 9 1 40 7 1000000 3
5 2 2 1 1 7 12 1000000
$EndElements
)";

const std::string ascii4 = R"($MeshFormat
4.1 0 8
$EndMeshFormat
$PhysicalNames
2
1 2 "front edge"
2 1 "a plate"
$EndPhysicalNames
$Entities
1 1 1 0
3 0 0 0 1 7
1 0 0 0 1 0 0 1 2 2 1 -2
1 0 0 -0.25 2.5 1 0 2 1 9 4 1 2 3 4
$EndEntities
$Nodes
2 5 3 1000000
1 1 1 2
40
7
0 0 0 0.1
1 0 0 0.9
2 1 0 3
1000000
3
12
1 1 0
0 1 0
2.5 0.5 -0.25
$EndNodes
$Elements
4 4 1 5
0 3 15 1
1 40
1 1 1 1
2 40 7
2 1 3 1
3 40 7 1000000 3
2 1 2 1
5 7 12 1000000
$EndElements
)";

template <typename... Numbers>
std::string bytes(Numbers... numbers) {
  std::string text;
  (text.append(reinterpret_cast<const char*>(&numbers), sizeof numbers), ...);
  return text;
}

std::int32_t i(std::int64_t value) { return static_cast<std::int32_t>(value); }
std::int64_t s(std::int64_t value) { return value; }

const std::string names = "$PhysicalNames\n2\n1 2 \"front edge\"\n2 1 \"a plate\"\n$EndPhysicalNames\n";

std::string binary2() {
  return "$MeshFormat\n2.2 1 8\n" + bytes(i(1)) + "\n$EndMeshFormat\n" + names + "$Nodes\n5\n" +
         bytes(i(40), 0.0, 0.0, 0.0, i(7), 1.0, 0.0, 0.0, i(1000000), 1.0, 1.0, 0.0, i(3), 0.0, 1.0, 0.0, i(12), 2.5,
               0.5, -0.25) +
         "\n$EndNodes\n$Elements\n5\n" + bytes(i(15), i(1), i(2), i(1), i(7), i(3), i(40)) +
         bytes(i(1), i(1), i(2), i(2), i(2), i(1), i(40), i(7)) +
         bytes(i(3), i(2), i(2), i(3), i(1), i(1), i(40), i(7), i(1000000), i(3), i(4), i(9), i(1), i(40), i(7),
               i(1000000), i(3)) +
         bytes(i(2), i(1), i(2), i(5), i(1), i(1), i(7), i(12), i(1000000)) + "\n$EndElements\n";
}

std::string binary4() {
  return "$MeshFormat\n4.1 1 8\n" + bytes(i(1)) + "\n$EndMeshFormat\n" + names + "$Entities\n" +
         bytes(s(1), s(1), s(1), s(0), i(3), 0.0, 0.0, 0.0, s(1), i(7)) +
         bytes(i(1), 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, s(1), i(2), s(2), i(1), i(-2)) +
         bytes(i(1), 0.0, 0.0, -0.25, 2.5, 1.0, 0.0, s(2), i(1), i(9), s(1), i(4)) + "\n$EndEntities\n$Nodes\n" +
         bytes(s(2), s(5), s(3), s(1000000), i(1), i(1), i(1), s(2), s(40), s(7), 0.0, 0.0, 0.0, 0.1, 1.0, 0.0, 0.0,
               0.9) +
         bytes(i(2), i(1), i(0), s(3), s(1000000), s(3), s(12), 1.0, 1.0, 0.0, 0.0, 1.0, 0.0, 2.5, 0.5, -0.25) +
         "\n$EndNodes\n$Elements\n" + bytes(s(4), s(4), s(1), s(5), i(0), i(3), i(15), s(1), s(1), s(40)) +
         bytes(i(1), i(1), i(1), s(1), s(2), s(40), s(7)) +
         bytes(i(2), i(1), i(3), s(1), s(3), s(40), s(7), s(1000000), s(3)) +
         bytes(i(2), i(1), i(2), s(1), s(5), s(7), s(12), s(1000000)) + "\n$EndElements\n";
}

Mesh read(const std::string& text) { return parse_gmsh(text, "mesh.msh"); }

std::string refusal(const std::string& text) {
  try {
    read(text);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

class GmshFiles : public testing::Test {
protected:
  fs::path file(const std::string& text, const std::string& name = "mesh.msh") const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return folder_ / name;
  }

  ScratchFolder folder_{"gmsh"};
};

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

Indices nodes_of_cell(const Mesh& mesh, std::size_t cell) {
  const auto nodes = mesh.nodes_of(mesh.cells[cell]);
  return {nodes.begin(), nodes.end()};
}

void expect_plate(const Mesh& mesh) {
  EXPECT_EQ(mesh.node_ids, (std::vector<std::int64_t>{40, 7, 1000000, 3, 12}));
  EXPECT_EQ(mesh.nodes, (Eigen::Matrix3Xd(3, 5) << 0, 1, 1, 0, 2.5, 0, 0, 1, 1, 0.5, 0, 0, 0, 0, -0.25).finished());
  ASSERT_EQ(mesh.cells.size(), 4u);
  EXPECT_EQ(mesh.cells[0].shape, CellShape::point1);
  EXPECT_EQ(mesh.cells[1].shape, CellShape::line2);
  EXPECT_EQ(mesh.cells[2].shape, CellShape::quadrilateral4);
  EXPECT_EQ(mesh.cells[3].shape, CellShape::triangle3);
  EXPECT_EQ(mesh.cells[3].id, 5);
  EXPECT_EQ(nodes_of_cell(mesh, 2), (Indices{0, 1, 2, 3}));
  EXPECT_EQ(nodes_of_cell(mesh, 3), (Indices{1, 4, 2}));
  EXPECT_EQ(mesh.regions.at("front edge"), (Indices{1}));
  EXPECT_EQ(mesh.regions.at("physical7"), (Indices{0}));
  EXPECT_EQ(mesh.node_sets.at("front edge"), (Indices{0, 1}));
  EXPECT_EQ(mesh.node_sets.at("a plate"), (Indices{0, 1, 2, 3, 4}));
}

TEST_F(GmshFiles, ReadsVersion2InBothEncodings) {
  for (const auto& text : {ascii2, binary2()}) {
    const Mesh mesh = read_gmsh(file(text));
    expect_plate(mesh);
    EXPECT_EQ(mesh.source, (folder_ / "mesh.msh").string());
    EXPECT_EQ(mesh.regions.at("a plate"), (Indices{2, 3}));
    EXPECT_EQ(mesh.regions.at("physical9"), (Indices{2}));  // stands twice in the file, once for each group
    EXPECT_EQ(mesh.regions.size(), 4u);
  }
}

TEST_F(GmshFiles, ReadsVersion4InBothEncodings) {
  for (const auto& text : {ascii4, binary4()}) {
    const Mesh mesh = read(text);
    expect_plate(mesh);
    EXPECT_EQ(mesh.regions.at("a plate"), (Indices{2, 3}));
    EXPECT_EQ(mesh.regions.at("physical9"), (Indices{2, 3}));
    EXPECT_EQ(mesh.regions.size(), 4u);
  }
}

TEST(GmshText, SkipsWhatAMeshDoesNotNeed) {
  const std::string data = "$Comments\n$Nodes are not meant here\n$EndComments\n\n";
  const std::string view = "$NodeData\n1\n\"a view\"\n1\n0.0\n3\n0\n1\n0\n$EndNodeData\n";
  expect_plate(read(data + ascii2));
  expect_plate(read(replaced(ascii2, "$Nodes", data + "$Nodes") + view));
  expect_plate(
      read(replaced(binary4(), "$Nodes", "$Periodic\n" + bytes(s(0), s(-1)) + "\n$EndPeriodic\n$Nodes") + view));
}

TEST(GmshText, ReadsLinesOfEitherKindAndHugeNumbers) {
  std::string text;
  for (const char c : ascii4) text += c == '\n' ? std::string("\r\n") : std::string(1, c);
  expect_plate(read(text));
  const std::string huge = "9223372036854775807";
  text = ascii4;
  for (std::size_t at = 0; (at = text.find("1000000", at)) != std::string::npos;) text.replace(at, 7, huge);
  const Mesh mesh = read(text);
  EXPECT_EQ(mesh.node_ids[2], INT64_MAX);
  EXPECT_EQ(nodes_of_cell(mesh, 3), (Indices{1, 4, 2}));
}

TEST(GmshText, CellsWithoutAGroupMakeTheRegionMesh) {
  const std::string bare =
      replaced(ascii4, ascii4.substr(ascii4.find("$Phys"), ascii4.find("$Nodes") - ascii4.find("$Phys")), "");
  const Mesh mesh = read(bare);
  EXPECT_EQ(mesh.regions, (std::map<std::string, Indices>{{"mesh", {2, 3}}}));
  EXPECT_EQ(mesh.node_sets.at("mesh").size(), 5u);
  const Mesh partly = read(replaced(ascii2, "5 2 2 1 1 7 12", "5 2 2 0 1 7 12"));
  EXPECT_EQ(partly.regions.at("mesh"), (Indices{3}));
  EXPECT_EQ(partly.regions.at("a plate"), (Indices{2}));
}

TEST(GmshText, GroupsOfOneNameAreJoined) {
  const Mesh mesh = read(replaced(ascii2, "front edge", "a plate"));
  EXPECT_EQ(mesh.regions.at("a plate"), (Indices{1, 2, 3}));
}

TEST(GmshText, SaysWhatIsWrongInAnAsciiFile) {
  const struct {
    std::string text, message;
  } cases[] = {
      {"", "mesh.msh:1: this is not a readable Gmsh mesh"},
      {"solid cube\n", "mesh.msh:1: this is not a readable Gmsh mesh"},
      {"$NOD\n1\n1 0 0 0\n$ENDNOD\n", "mesh.msh:1: this is not a readable Gmsh mesh"},
      {replaced(ascii4, "4.1 0 8", "4 0 8"), "mesh.msh:2: the mesh has format version '4'"},
      {replaced(ascii4, "4.1 0 8", "3 0 8"), "mesh.msh:2: the mesh has format version '3'"},
      {replaced(ascii4, "4.1 0 8", "4.1 0 4"), "mesh.msh:2: the format line cannot be understood"},
      {replaced(ascii2, "$Nodes\n5", "$Nodes\n-5"), "mesh.msh:10: -5 nodes are announced: a count cannot be negative"},
      {replaced(ascii2, "$Nodes\n5", "$Nodes\n900000000000"),
       "mesh.msh:10: 900000000000 nodes are announced: the rest"},
      {replaced(ascii2, "$Nodes\n5", "$Nodes\n4"), "mesh.msh:15: there is '12 2.5 5e-1 -0.25' where $EndNodes"},
      {replaced(ascii2, "$Nodes\n5", "$Nodes\n6"), "mesh.msh:16: the section ends instead of a node's number"},
      {replaced(ascii2, "7 1 0 0", "7 1 0"), "mesh.msh:12: the line holds too few numbers for a node"},
      {replaced(ascii2, "7 1 0 0", "7 1 0 0 0"), "mesh.msh:12: the line holds too many numbers for a node"},
      {replaced(ascii2, "7 1 0 0", "7 1 zero 0"), "mesh.msh:12: a node's coordinate is 'zero': it must be a number"},
      {replaced(ascii2, "7 1 0 0", "7.5 1 0 0"), "mesh.msh:12: a node's number is '7.5': it must be a whole"},
      {replaced(ascii2, "7 1 0 0", "7 nan 0 0"), "mesh.msh:12: node 7 has a coordinate that is not finite"},
      {replaced(ascii2, "7 1 0 0", "7 1e999 0 0"), "mesh.msh:12: node 7 has a coordinate that is not finite"},
      {replaced(ascii2, "7 1 0 0", "40 1 0 0"), "mesh.msh:12: node 40 is defined twice"},
      {replaced(ascii2, "5 2 2 1 1 7 12", "5 2 2 1 1 7 13"), "mesh.msh:23: element 5 names the node 13"},
      {replaced(ascii2, "5 2 2 1 1 7 12", "5 777 2 1 1 7 12"), "mesh.msh:23: an element is of type 777"},
      {replaced(ascii2, "5 2 2 1 1 7 12", "5 2 -2 1 1 7 12"), "mesh.msh:23: -2 tags of an element are announced"},
      {replaced(ascii2, "$EndElements", "$EndElement"), "mesh.msh:24: there is '$EndElement' where $EndElements"},
      {replaced(ascii2, "$Nodes", "stray\n$Nodes"), "mesh.msh:9: a section was expected here"},
      {replaced(ascii2, "\"a plate\"", "plate"), "mesh.msh:7: the name of physical group 1 cannot be read"},
      {replaced(ascii4, "1 1 1 2\n40", "1 1 1 6\n40"),
       "mesh.msh:17: a block announces 6 nodes: the section has 5 left"},
      {replaced(ascii4, "1 1 1 2\n40", "7 1 1 2\n40"), "mesh.msh:17: an entity's dimension is 7"},
      {replaced(ascii4, "2 5 3 1000000", "2 6 3 1000000"), "mesh.msh:29: the blocks end 1 nodes early"},
      {replaced(ascii4, "2 1 3 1\n", "2 1 500 1\n"), "mesh.msh:36: elements are of type 500"},
      {replaced(ascii4, "3 40 7 1000000 3", "3 40 7 1000000"), "mesh.msh:37: the line holds too few numbers"},
      {ascii4.substr(0, ascii4.find("$Elements")), "mesh.msh:30: the file has no $Elements section"},
      {ascii4.substr(0, ascii4.find("$Nodes")), "mesh.msh:15: the file has no $Nodes section"},
      {replaced(ascii4, "$EndElements\n", "$EndElements\n$Nodes\n"),
       "mesh.msh:41: there is more than one section $Nodes"},
      {ascii4 + "$Periodic\n1\n", "mesh.msh:41: the section $Periodic has no end"},
  };
  for (const auto& [text, message] : cases) EXPECT_EQ(refusal(text).substr(0, message.size()), message);
}

TEST(GmshText, SaysWhatIsWrongInABinaryFile) {
  const std::string good = binary4();
  const auto swapped = replaced(good, "4.1 1 8\n" + bytes(i(1)), "4.1 1 8\n" + bytes(i(0x01000000)));
  EXPECT_EQ(refusal(swapped).substr(0, 58), "mesh.msh: the mesh has the byte order of another machine (");
  EXPECT_NE(refusal(swapped).find("(byte 20)"), std::string::npos);
  const auto doubled = replaced(good, bytes(s(40), s(7)), bytes(s(40), s(40)));
  EXPECT_NE(refusal(doubled).find("node 40 is defined twice (byte "), std::string::npos);
  const auto countless = replaced(good, bytes(s(2), s(5), s(3)), bytes(s(2), s(INT64_MAX), s(3)));
  EXPECT_NE(refusal(countless).find("9223372036854775807 nodes are announced (byte "), std::string::npos);
  const auto negative = replaced(good, bytes(s(2), s(5), s(3)), bytes(s(-2), s(5), s(3)));
  EXPECT_NE(refusal(negative).find("-2 blocks are announced"), std::string::npos);
  const auto empty_block = replaced(binary2(), bytes(i(3), i(2), i(2), i(3)), bytes(i(3), i(0), i(2), i(3)));
  EXPECT_NE(refusal(empty_block).find("a block has 0 elements"), std::string::npos);
}

TEST(GmshText, EveryTruncationIsRefused) {
  for (const auto& text : {ascii2, binary2(), ascii4, binary4()})
    for (std::size_t size = 0; size + 1 < text.size(); ++size) EXPECT_NE(refusal(text.substr(0, size)), "") << size;
}

TEST(GmshText, ListsTypesThatCannotBeRead) {
  const std::string message = refusal(replaced(
      ascii2, "5\n1 15 2 7 3 40",
      "8\n7 20 2 1 1 40 7 3 12 40 7 3 12 40\n8 20 2 1 1 40 7 3 12 40 7 3 12 40\n9 7 2 1 1 40 7 3 12 40\n1 15 2 7 3 "
      "40"));
  EXPECT_NE(message.find("mesh.msh:19: the mesh has 2 cells of Gmsh type 20 (9-node triangle)"), std::string::npos);
  EXPECT_NE(message.find("mesh with order 1"), std::string::npos);
  EXPECT_NE(message.find("mesh.msh:21: the mesh has 1 cells of Gmsh type 7 (pyramid)"), std::string::npos);
}

TEST(GmshText, ProblemsAreReportedTogether) {
  try {
    read(replaced(replaced(ascii2, "7 1 0 0", "7 inf 0 0"), "5 2 2 1 1 7 12", "5 2 2 1 1 8 13"));
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_EQ(error.issues().size(), 3u);
  }
}

TEST(GmshText, NumbersAreFoundWhetherDenseOrSparse) {
  for (const auto& numbers :
       {std::vector<std::int64_t>{5, 3, 4, 3, 9, 5}, {INT64_MIN, 3, 0, 3, INT64_MAX, INT64_MIN}}) {
    const NumberLookup lookup(numbers);
    EXPECT_EQ(lookup.find(numbers[0]), 0);
    EXPECT_EQ(lookup.find(numbers[1]), 1);
    EXPECT_EQ(lookup.find(numbers[4]), 4);
    EXPECT_EQ(lookup.find(7), -1);
    EXPECT_EQ(lookup.find(-1000), -1);
    EXPECT_EQ(lookup.repeated(), (std::vector<std::pair<Eigen::Index, Eigen::Index>>{{3, 1}, {5, 0}}));
  }
  EXPECT_EQ(NumberLookup().find(0), -1);
}

bool is_sound(const Mesh& mesh) {
  const auto good = [&](Eigen::Index node) { return node >= 0 && node < mesh.node_count(); };
  for (const auto& cell : mesh.cells)
    if (!std::ranges::all_of(mesh.nodes_of(cell), good)) return false;
  for (const auto& [name, cells] : mesh.regions)
    for (const auto cell : cells)
      if (cell < 0 || cell >= static_cast<Eigen::Index>(mesh.cells.size())) return false;
  return mesh.nodes.allFinite();
}

/// One of the small damages that files suffer.
std::string damaged(std::string text, std::mt19937& random) {
  const auto below = [&](std::size_t bound) {
    return std::uniform_int_distribution<std::size_t>(0, bound - 1)(random);
  };
  const std::size_t at = below(text.size()), size = std::min<std::size_t>(1 + below(12), text.size() - at);
  static const std::string words[] = {"-1", "0",     "99999999999999999999", "4000000000", "nan", "$",
                                      "\n", "1e400", "\xff\xff\xff\xff"};
  switch (below(4)) {
    case 0:
      text[at] = static_cast<char>(below(256));
      break;
    case 1:
      text.erase(at, size);
      break;
    case 2:
      text.insert(below(text.size()), text.substr(at, size));
      break;
    default:
      text.replace(at, size, words[below(std::size(words))]);
  }
  return text;
}

TEST(GmshText, DamagedFilesAreReadOrRefused) {
  std::mt19937 random(20170615);
  int refused = 0;
  const std::string originals[] = {ascii2, binary2(), ascii4, binary4()};
  for (int k = 0; k < 4000; ++k) {
    std::string text = damaged(originals[k % 4], random);
    if (k % 3 == 0) text = damaged(text, random);
    try {
      ASSERT_TRUE(is_sound(read(text))) << text;
    } catch (const InvalidInput&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 1000);
}

TEST(GmshExamples, TheVehicleFrameHasItsNodesGroupsAndPoints) {
  const Mesh mesh = read_gmsh(fs::path(test::source_folder()) / "examples/vehicle/frame.msh");
  EXPECT_EQ(mesh.node_count(), 7594);  // 45,564 degrees of freedom
  EXPECT_TRUE(is_sound(mesh));
  EXPECT_EQ(mesh.regions.size(), 12u);
  for (const auto* name : {"rails", "cross_members", "brackets", "upper"})
    EXPECT_GT(mesh.regions.at(name).size(), 300u);
  const auto& front_left = mesh.node_sets.at("p1");
  ASSERT_EQ(front_left.size(), 1u);
  EXPECT_LT((mesh.nodes.col(front_left[0]) - Eigen::Vector3d(1.74, 0.78, -0.08)).norm(), 1e-15);  // decimals as written
  for (const auto* name : {"p2", "p3", "p4", "p5", "p6", "p7", "p8"}) EXPECT_EQ(mesh.node_sets.at(name).size(), 1u);
}

TEST_F(GmshFiles, AgreesWithTheProgramInAllFormats) {
  if (std::system("gmsh --version > /dev/null 2>&1") != 0) KALFEM_ABSENT("the command gmsh is not on the path");
  const auto geometry = file(R"(SetFactory("Built-in");
Point(1) = {0, 0, 0, 0.3}; Point(2) = {1, 0, 0, 0.2}; Point(3) = {1, 2, 0.5, 0.3}; Point(4) = {0, 2, 0.5, 0.3};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1}; Line(5) = {1, 3};
Curve Loop(1) = {1, 2, -5}; Curve Loop(2) = {5, 3, 4}; Plane Surface(1) = {1}; Plane Surface(2) = {2};
Recombine Surface{2};
Physical Surface("triangles") = {1}; Physical Surface("both parts") = {1, 2};
Physical Curve("rim") = {1, 2}; Physical Point(17) = {3};
)",
                             "plate.geo");
  std::vector<Mesh> meshes;
  for (const std::string format :
       {"msh22", "msh22 -bin", "msh41", "msh41 -bin", "msh41 -parametric", "msh41 -bin -parametric"}) {
    const fs::path out = folder_ / "out.msh";
    const std::string command =
        "gmsh -2 -format " + format + " -o '" + out.string() + "' '" + geometry.string() + "' > /dev/null 2>&1";
    if (std::system(command.c_str()) != 0) KALFEM_ABSENT("this gmsh cannot mesh: " + command);
    meshes.push_back(read_gmsh(out));
  }
  for (const auto& mesh : meshes) {
    EXPECT_EQ(mesh.node_ids, meshes[0].node_ids);
    EXPECT_LT((mesh.nodes - meshes[0].nodes).cwiseAbs().maxCoeff(), 2e-15);  // 16 digits are written
    EXPECT_EQ(mesh.connectivity, meshes[0].connectivity);
    EXPECT_EQ(mesh.regions, meshes[0].regions);
    EXPECT_EQ(mesh.node_sets, meshes[0].node_sets);
  }
  const Mesh& mesh = meshes[0];
  EXPECT_TRUE(is_sound(mesh));
  double area = 0.0;  // of the region of all surfaces, by halves of the cross products of diagonals or edges
  for (const auto cell : mesh.regions.at("both parts")) {
    const auto n = nodes_of_cell(mesh, static_cast<std::size_t>(cell));
    const Eigen::Vector3d a = mesh.nodes.col(n[2]) - mesh.nodes.col(n[0]);
    const Eigen::Vector3d b = mesh.nodes.col(n.size() == 4 ? n[3] : n[2]) - mesh.nodes.col(n[1]);
    area += 0.5 * a.cross(b).norm();
  }
  EXPECT_NEAR(area, std::sqrt(4.25), 1e-14);  // a rectangle of 1 by |(0, 2, 0.5)|, whose boundaries are straight
  EXPECT_EQ(mesh.node_sets.at("physical17").size(), 1u);
}

}  // namespace
}  // namespace kalfem
