// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "base/scratch_folder.hpp"
#include "formats/matrices_refusal.hpp"

namespace kalfem {
namespace {

const std::vector<MatrixDof> expected_dofs = {{7, 0}, {7, 5}, {12, 2}};

const std::string market =
    "%%MatrixMarket matrix coordinate real symmetric\n% a comment\n\n3 3 5\n1 1 4.5\n2 1 -1\n2 2 3D0\n3 2 -2.5e-1\n3 3 "
    "2\n";
const std::string nodal = "7,1, 7,1, 4.5\n7,1, 7,6, -1.\n 7 6 7 6 3.0D+00\n7,6,12,3,-.25\n12,3,12,3,2\n";
const std::string user_element =
    "**\n** GENERATION\n*USER ELEMENT, NODES=   2, LINEAR\n** ELEMENT NODES\n**    7,  12\n 1, 6\n 2, 3\n"
    "*MATRIX, TYPE=STIFFNESS\n 4.5,\n -1., 3.,\n 0., -0.25,\n 2.\n*MATRIX,TYPE=MASS\n1.,0.,1.,0.,0.,1.\n";
const std::string dmig =
    "$ punched\nDMIG    KAAX           0       6       2       0                       3\n"
    "DMIG*   KAAX                           7               1\n"
    "*                      7               1 4.500000000D+00\n"
    "*                      7               6-1.000000000D+00\n"
    "GRID           1       0      0.      0.      0.\n"
    "DMIG    KAAX           7       6               7       6      3.\n"
    "              12       3  -2.5-1\n"
    "DMIG,KAAX,12,3,,12,3,2.0\n"
    "DMIG,MAAX,0,6,1,0\nDMIG,MAAX,12,3,,12,3,1.+1\n";
const std::string op4_text =
    "       3      -3       6       2KAA     1P,3E16.9\n"
    "       1       0       6\n       5       1\n 4.500000000E+00-1.000000000E+00\n"
    "       2       0      10\n       3       1\n-1.000000000E+00\n       5       2\n 3.000000000E+00-2.500000000E-01\n"
    "       3       0       6\n       5       2\n-2.500000000D-01 2.000000000E+00\n"
    "       4       1       1\n 1.000000000E+00\n";

TEST(MatrixText, EveryFormatGivesTheSameMatrix) {
  const struct {
    std::string text, source;
    bool has_dofs;
  } cases[] = {{market, "K.mtx", false},
               {with(market, "%%", "%"), "K.mtx", false},
               {"%%MatrixMarket matrix array real general\n3 3\n4.5\n-1\n0\n-1 3 -0.25\n0\n-0.25\n2\n", "K.txt", false},
               {"%%MatrixMarket matrix array integer symmetric\n3 3\n4.5\n-1\n0\n3 -0.25\n2\n", "K.txt", false},
               {"1 1 4.5\n1 2 -1\n2 2 3\n2 3 -0.25\n3 3 2\n", "K.sti", false},
               {"1,1,4.5\n1,2,-1\n2,1,-1\n2,2,3\n2,3,-0.25\n3,2,-.25\n3,3,2\n", "K.txt", false},
               {nodal, "K.mtx", true},
               {"*MATRIX INPUT, NAME=Stiff, SCALE FACTOR=0.5\n" +
                    with(with(with(with(with(nodal, "4.5", "9"), "-1.", "-2"), "3.0D", "6.0D"), "-.25", "-.5"),
                         "12,3,2", "12,3,4"),
                "K.inp", true},
               {user_element, "K.mtx", true},
               {dmig, "K.pch", true},
               {op4_text, "K.op4", false}};
  for (const auto& [text, source, has_dofs] : cases) {
    const auto matrices = parse_matrices(text, source);
    EXPECT_EQ(dense(matrices[0]), common_matrix) << text;
    EXPECT_EQ(matrices[0].dofs, has_dofs ? expected_dofs : std::vector<MatrixDof>{}) << text;
    std::string windows;
    for (const char c : text) windows += c == '\n' ? std::string("\r\n") : std::string(1, c);
    EXPECT_EQ(dense(parse_matrices(windows, source)[0]), common_matrix) << text;
    expect_no_crash(text, source);
  }
  EXPECT_EQ(parse_matrices(dmig, "x")[1].dofs, (std::vector<MatrixDof>{{12, 2}}));
  EXPECT_EQ(parse_matrices(dmig, "x")[1].matrix.coeff(0, 0), 10.0);
  EXPECT_EQ(parse_matrices(user_element, "x")[1].name, "mass");
}

TEST(MatrixText, Outputs4InItsDenseAndShortForms) {
  const std::string dense_columns =
      "       3       3       2       1KAA     5E16.9\n       1       1       2\n 4.500000000E+00-1.000000000E+00\n"
      "       2       1       3\n-1.000000000E+00 3.000000000E+00-2.500000000E-01\n"
      "       3       2       2\n-2.500000000E-01 2.000000000E+00\n       4       1       1\n 1.000000000E+00\n";
  EXPECT_EQ(dense(parse_matrices(dense_columns, "x.op4")[0]), common_matrix);
  const std::string strings =  // 65536 (words + 1) + row, words of single precision
      "       3       3       6       1KAA     1P,5E16.9\n       1       0       3\n  196609\n"
      " 4.500000000E+00-1.000000000E+00\n       2       0       4\n  262145\n"
      "-1.000000000E+00 3.000000000E+00-2.500000000E-01\n       3       0       3\n  196610\n"
      "-2.500000000E-01 2.000000000E+00\n       4       1       1\n 1.000000000E+00\n";
  EXPECT_EQ(dense(parse_matrices(strings, "x.op4")[0]), common_matrix);
  const std::string wide =
      "               3              -3       6       2KAA     1P,3E16.9|I16" + op4_text.substr(op4_text.find('\n'));
  EXPECT_EQ(dense(parse_matrices(wide, "x.op4")[0]), common_matrix);
  EXPECT_EQ(parse_matrices(op4_text + strings, "x.op4").size(), 2u);
}

TEST(MatrixText, SkewAndRectangularMatrices) {
  const auto skew = parse_matrices("%%MatrixMarket matrix coordinate real skew-symmetric\n2 2 1\n2 1 3\n", "S.mtx");
  EXPECT_EQ(dense(skew[0]), (Eigen::Matrix2d() << 0, -3, 3, 0).finished());
  const auto wide = parse_matrices("%%MatrixMarket matrix coordinate real general\n1 3 1\n1 3 5\n", "B.mtx");
  EXPECT_EQ(dense(wide[0]), Eigen::RowVector3d(0, 0, 5));
  const auto loads = parse_matrices("DMIG,P,0,9,2,0,,,2\nDMIG,P,1,,,4,3,5.0\nDMIG,P,2,,,4,3,6.0\n", "x.bdf");
  EXPECT_EQ(dense(loads[0]), Eigen::RowVector2d(5, 6));
  EXPECT_EQ(loads[0].dofs, (std::vector<MatrixDof>{{4, 2}}));
  const auto scalar = parse_matrices("DMIG,M,0,6,2\nDMIG,M,9001,0,,9001,,1.\n", "x.bdf");
  EXPECT_EQ(scalar[0].dofs, (std::vector<MatrixDof>{{9001, -1}}));
}

TEST(MatrixText, SaysWhatIsWrong) {
  const struct {
    std::string text, source, message;
  } cases[] = {
      {"", "a.mtx", "a.mtx: the file is empty"},
      {"hello\n", "a.txt", "a.txt: the format of this file is unknown"},
      {with(market, "real", "complex"), "a.mtx", "a.mtx:1: the matrix is complex"},
      {with(market, "3 3 5", "3 3 6"), "a.mtx", "a.mtx:9: the file ends after 5 of 6 entries"},
      {with(market, "3 3 5", "3 3 4"), "a.mtx", "a.mtx:9: there are more entries"},
      {with(market, "3 3 5", "-3 3 5"), "a.mtx", "a.mtx:4: matrix 'a' has -3 rows"},
      {with(market, "3 3 5", "999999999 999999999 5"), "a.mtx", "a.mtx:4: matrix 'a' has 999999999 rows"},
      {with(market, "2 1 -1", "2 4 -1"), "a.mtx", "a.mtx:6: entry (2, 4) of matrix 'a' is out of range"},
      {with(market, "2 1 -1", "2 1 nan"), "a.mtx", "a.mtx:6: entry (2, 1) of matrix 'a' is not finite"},
      {with(market, "2 1 -1", "2 1 1e999"), "a.mtx", "a.mtx:6: entry (2, 1) of matrix 'a' is not finite"},
      {with(market, "2 1 -1", "1 1 -1"), "a.mtx", "entry (1, 1) of matrix 'a' is defined twice"},
      {with(market, "3 2 -2.5e-1", "1 2 -2.5e-1"), "a.mtx", "has both entries of a symmetric pair"},
      {with(nodal, "7,6,12", "7,7,12"), "a.mtx", "a.mtx:4: '7, 7' is not a degree of freedom"},
      {with(nodal, "7,6,12", "7,6,-2"), "a.mtx", "a.mtx:4: the matrix has the internal node -2"},
      {with(nodal, "7,6,12,3,-.25", "7,6,12,-.25"), "a.mtx", "a.mtx:4: the line holds 4 numbers"},
      {with(user_element, "NODES=   2", "NODES= 3"), "a.mtx", "*USER ELEMENT has 3 nodes, of which 2 have a number"},
      {with(user_element, " 2.\n", "\n"), "a.mtx", "matrix 'stiffness' has 5 entries: 3 degrees of freedom need 6"},
      {with(dmig, "       6       2", "       6       4"), "a.pch", "a.pch:2: matrix 'KAAX' is complex"},
      {with(dmig, "DMIG,MAAX,0,6,1,0\n", ""), "a.pch", "a.pch:10: a column of matrix 'MAAX' has no header before it"},
      {with(dmig, "1.+1", "1.x1"), "a.pch", "a.pch:11: '1.x1' in matrix 'MAAX' is not a number"},
      {with(dmig, "12,3,,12,3,2.0", "7,6,,7,6,2.0"), "a.pch", "entry (2, 2) of matrix 'KAAX' is defined twice"},
      {with(op4_text, "2KAA", "4KAA"), "a.op4", "a.op4:1: matrix 'KAA' is complex"},
      {op4_text.substr(0, 200), "a.op4", "a.op4:8: the file ends inside a matrix"},
      {with(op4_text, "       5       1\n", "       5       3\n"), "a.op4",
       "a.op4:4: entry (4, 1) of matrix 'KAA' is out of range"},
  };
  for (const auto& [text, source, message] : cases)
    EXPECT_NE(refusal(text, source).find(message), std::string::npos)
        << message << "\n  instead: " << refusal(text, source);
}

TEST(MatrixText, MatricesAreChosenByName) {
  EXPECT_EQ(parse_matrices(dmig, "x", {.names = {"maax"}})[0].name, "MAAX");
  try {
    parse_matrices(dmig, "x.pch", {.names = {"KAAZ"}});
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_STREQ(error.what(), "x.pch: there is no matrix 'KAAZ' (did you mean 'KAAX'?): the file contains KAAX, MAAX");
  }
}

TEST(DofMap, OfEveryForm) {
  const std::vector<MatrixDof> expected_map = {{7, 0}, {7, 5}, {12, 2}};
  for (const std::string text : {"7.1\n7.6\n12.3\n", "7 1\n7 6\n12 3", "node,direction\n7,x\n7,rz\n12,uz\n",
                                 "# comment\nnode;dof\n7;1\n7;6\n12;3\n", "n7.x\nn7.rz\nn12.z\n"})
    EXPECT_EQ(parse_dof_map(text, "map"), expected_map) << text;
  EXPECT_EQ(parse_dof_map("node\n4\n2\n", "map", {.directions = 3}),
            (std::vector<MatrixDof>{{4, 0}, {4, 1}, {4, 2}, {2, 0}, {2, 1}, {2, 2}}));
}

TEST(DofMap, GeneralisedCoordinatesAndCopies) {
  EXPECT_EQ(parse_dof_map("0 0\n0 0\n5 2\n", "map"), (std::vector<MatrixDof>{{1, -1}, {2, -1}, {5, 1}}));
  EXPECT_EQ(parse_dof_map("q4\nn5.y\n", "map"), (std::vector<MatrixDof>{{4, -1}, {5, 1}}));
  EXPECT_EQ(parse_dof_map("5.1\n6.1\n5.1\n", "map"), (std::vector<MatrixDof>{{5, 0, 1}, {6, 0}, {5, 0, 2}}));
}

TEST(DofMap, SaysWhatIsWrong) {
  const auto message = [](const std::string& text, const DofMapOptions& options = {}) -> std::string {
    try {
      parse_dof_map(text, "map", options);
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(message("1 1\n1 9\n").find("map:2: '1 9' is not a degree of freedom"), std::string::npos);
  EXPECT_NE(message("1 1\n2 1\n1 1\n").find("map:3: degree of freedom 1.x is listed twice: it is first in line 1"),
            std::string::npos);
  EXPECT_NE(message("node dof\n").find("lists no degrees of freedom"), std::string::npos);
  EXPECT_NE(message("1\nx\n", {.directions = 3}).find("map:2: 'x' is not a degree of freedom"), std::string::npos);
}

TEST(MatrixText, CalculixMapBesideTheMatrices) {
  const ScratchFolder folder("sti");
  std::ofstream(folder / "job.sti") << "1 1 4.5\n1 2 -1\n2 2 3\n";
  std::ofstream(folder / "job.dof") << "7.1\n7.6\n12.3\n";
  const auto matrices = read_matrices(folder / "job.sti");
  EXPECT_EQ(matrices[0].dofs, expected_dofs);
  EXPECT_EQ(matrices[0].matrix.rows(), 3);  // the last row holds no entry
}

}  // namespace
}  // namespace kalfem
