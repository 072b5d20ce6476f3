// SPDX-License-Identifier: Apache-2.0
// Every reader takes a sign of its own before a number, and none beside it.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>

#include "base/scratch_folder.hpp"
#include "kalfem/formats/gmsh/gmsh.hpp"
#include "kalfem/formats/matrices/entries.hpp"
#include "kalfem/formats/nastran/card.hpp"
#include "kalfem/formats/tables/text_table.hpp"

namespace kalfem {
namespace {

constexpr std::array wrong = {"+-1.5", "-+1.5", "++1.5", "--1.5", "1.5e+-2", "1.5e-+2"};
constexpr std::array right = {"+1.5", "-1.5", "1.5e+2", "1.5e-2"};

std::string mesh(const std::string& coordinate) {
  return "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n2\n1 0 0 0\n2 " + coordinate +
         " 0 0\n$EndNodes\n$Elements\n1\n1 1 2 1 1 1 2\n$EndElements\n";
}

bool reads_mesh(const std::string& coordinate) {
  try {
    return std::abs(parse_gmsh(mesh(coordinate), "signs.msh").nodes(0, 1)) > 0.0;
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("signs.msh:7"), std::string::npos) << error.what();
    return false;
  }
}

TEST(NumberSigns, StandAloneInEveryReader) {
  for (const char* text : wrong) {
    EXPECT_FALSE(reads_mesh(text)) << text;
    EXPECT_FALSE(fortran_number(text)) << text;
    EXPECT_FALSE(nastran::parse_real(text)) << text;
    EXPECT_FALSE(parse_number(text, '.')) << text;
  }
  for (const char* text : right) {
    EXPECT_TRUE(reads_mesh(text)) << text;
    EXPECT_TRUE(fortran_number(text)) << text;
    EXPECT_TRUE(nastran::parse_real(text)) << text;
    EXPECT_TRUE(parse_number(text, '.')) << text;
  }
  EXPECT_DOUBLE_EQ(fortran_number("1.5+2").value_or(0.0), 150.0);
  EXPECT_DOUBLE_EQ(nastran::parse_real("-1.5-2").value_or(0.0), -0.015);
}

TEST(NumberSigns, StandAloneBeforeWholeNumbers) {
  EXPECT_FALSE(whole_number("+-3"));
  EXPECT_FALSE(nastran::parse_integer("+-3"));
  EXPECT_EQ(whole_number("+3"), 3);
  EXPECT_EQ(nastran::parse_integer("+3"), 3);
}

/// A text that is cut off inside its last number has no line end behind it.
TEST(CutOffMatrices, AreRefusedAtTheirLastLine) {
  const ScratchFolder folder("cut-matrices");
  const auto reads = [&](const std::string& name, const std::string& text) {
    std::ofstream(folder / name) << text;
    try {
      return !read_matrices(folder / name).empty();
    } catch (const InvalidInput& error) {
      EXPECT_NE(std::string(error.what()).find("no line end"), std::string::npos) << error.what();
      return false;
    }
  };
  const std::string market = "%%MatrixMarket matrix coordinate real symmetric\n1 1 1\n1 1 2.5";
  EXPECT_TRUE(reads("K.mtx", market + "e9\n"));
  EXPECT_FALSE(reads("K.mtx", market));
  EXPECT_TRUE(reads("K.sti", "1 1 4.5\n"));
  EXPECT_FALSE(reads("K.sti", "1 1 4."));
  const std::string punched =
      "DMIG    K              0       6       1       0                       1\n"
      "DMIG*   K                              1               1\n*                      1               1";
  EXPECT_TRUE(reads("K.pch", punched + " 2.500000000D+03\n"));
  EXPECT_FALSE(reads("K.pch", punched + " 2.5"));
}

}  // namespace
}  // namespace kalfem
