// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "base/scratch_folder.hpp"
#include "formats/matrices_refusal.hpp"
#include "kalfem/formats/hdf5/hdf5_file.hpp"
#include "kalfem/formats/matrices/matrix_model.hpp"

// What stands in a file of matrices is used, told or refused: each field of a small file is given another value in
// turn, and then the matrices change, or a note or a refusal names it.
namespace kalfem {
namespace {

/// A text with one of its words, and another value for that word.
struct Change {
  std::string text, from, to, source;
};

std::string described(const std::vector<ForeignMatrix>& matrices) {
  std::ostringstream words;
  for (const auto& matrix : matrices) {
    words << matrix.name << "\n" << dense(matrix) << "\n";
    for (const auto& dof : matrix.dofs) words << dof.node << "." << dof.direction << " ";
    for (const auto& note : matrix.notes) words << note << "\n";
  }
  return words.str();
}

std::string outcome(const std::string& text, const std::string& source) {
  try {
    return described(parse_matrices(text, source));
  } catch (const InvalidInput& error) {
    return std::string("refused: ") + error.what();
  }
}

const std::string market = "%%MatrixMarket matrix coordinate real symmetric\n2 2 3\n1 1 4\n2 1 -1\n2 2 3\n";
const std::string nodal = "*MATRIX INPUT, NAME=K\n7, 1, 7, 1, 4.\n7, 1, 8, 2, -1.\n8, 2, 8, 2, 3.\n";
const std::string element =
    "*USER ELEMENT, NODES=2, LINEAR\n** ELEMENT NODES\n** 7, 12\n1\n2, 3\n*MATRIX, TYPE=STIFFNESS\n4.\n-1., 3.\n";
const std::string op4 =
    "       2       2       6       2KAA     1P,3E16.9\n       1       1       2\n 4.000000000E+00-1.000000000E+00\n"
    "       2       2       1\n 3.000000000E+00\n       3       1       1\n 1.000000000E+00\n";

TEST(MatrixLedger, EveryFieldIsUsedToldOrRefused) {
  const Change changes[] = {
      {market, "symmetric", "symmetric packed", "K.mtx"},
      {market, "symmetric", "general", "K.mtx"},
      {market, "coordinate", "array", "K.mtx"},
      {market, "real", "complex", "K.mtx"},
      {market, "real", "pattern", "K.mtx"},
      {market, "matrix", "vector", "K.mtx"},
      {market, "2 2 3\n", "3 3 3\n", "K.mtx"},
      {market, "2 2 3\n", "2 2 2\n", "K.mtx"},
      {market, "2 1 -1", "2 1 -1 0", "K.mtx"},
      {nodal, "NAME=K", "NAME=M", "K.inp"},
      {nodal, "NAME=K", "NAME=K, SCALE FACTOR=2", "K.inp"},
      {nodal, "NAME=K", "NAME=K, INPUT=other.mtx", "K.inp"},
      {nodal, "NAME=K", "NAME=K, TYPE=UNSYMMETRIC", "K.inp"},
      {nodal, "NAME=K", "NAME=K, OPERATION=CONJUGATE", "K.inp"},
      {nodal, "7, 1, 8, 2", "7, 1, 9, 2", "K.inp"},
      {nodal, "7, 1, 8, 2", "7, 1, 8, 3", "K.inp"},
      {nodal, "-1.", "-1., 0.", "K.inp"},
      {element, "NODES=2", "NODES=3", "K.mtx"},
      {element, "LINEAR", "LINEAR, UNSYMM", "K.mtx"},
      {element, "LINEAR", "LINEAR, COORDINATES=3", "K.mtx"},
      {element, "** 7, 12", "** 7, 13", "K.mtx"},
      {element, "2, 3", "2, 2", "K.mtx"},
      {element, "TYPE=STIFFNESS", "TYPE=MASS", "K.mtx"},
      {element, "TYPE=STIFFNESS", "TYPE=STIFFNESS, SCALE=2", "K.mtx"},
      {element, "*MATRIX", "*UEL PROPERTY, ELSET=E, ALPHA=1.\n*MATRIX", "K.mtx"},
      {element, "*USER", "*ELEMENT, TYPE=U1\n1, 7, 12\n*USER", "K.mtx"},
      {element, "*USER", "5.\n*USER", "K.mtx"},
      {element, "3.\n", "3.\n*CLOAD\n7, 1, 5.\n", "K.mtx"},
      {op4, "       6       2KAA", "       1       2KAA", "K.op4"},
      {op4, "       6       2KAA", "       5       2KAA", "K.op4"},
      {op4, "       6       2KAA", "       6       4KAA", "K.op4"},
      {op4, "KAA ", "MAA ", "K.op4"},
      {op4, "       2       2       6", "       2       3       6", "K.op4"},
  };
  for (const auto& [text, from, to, source] : changes) {
    ASSERT_NE(text.find(from), std::string::npos) << from;
    const std::string before = outcome(text, source), after = outcome(with(text, from, to), source);
    EXPECT_EQ(before.find("refused"), std::string::npos) << before;
    EXPECT_NE(before, after) << "read past: " << to;
  }
}

TEST(MatrixLedger, MapsOfDegreesOfFreedomHaveNoFurtherColumns) {
  const auto said = [](const std::string& text, int directions) -> std::string {
    try {
      (void)parse_dof_map(text, "map", {.directions = directions});
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(said("node dof\n7 1\n8 2\n", 0), "");
  EXPECT_NE(said("row node dof\n1 7 1\n2 8 2\n", 0).find("map:2: the line holds 3 values"), std::string::npos);
  EXPECT_NE(said("7 1 4\n", 0).find("map:1: the line holds 3 values"), std::string::npos);
  EXPECT_EQ(said("node\n7\n8\n", 3), "");
  EXPECT_NE(said("7 0. 0. 0.\n", 3).find("the line holds 4 values"), std::string::npos);
}

TEST(MatrixLedger, DatasetsBesideTheMatricesAreToldAndPackedOnesRefused) {
  const auto bytes = [](bool packed) {
    auto file = Hdf5File::create_in_memory("m.h5");
    file.write_matrix("/K", Eigen::Matrix2d::Identity());
    file.write("/frequencies", Eigen::Vector3d(1, 2, 3));
    if (packed) file.set_attribute("/K", "scale_factor", 2.0);
    return file.bytes();
  };
  const auto matrices = parse_matrices(bytes(false), "m.h5");
  ASSERT_EQ(matrices.at(0).notes.size(), 1u);
  EXPECT_EQ(matrices[0].notes[0], "datasets that are no matrices and are not used: frequencies");
  EXPECT_NE(refusal(bytes(true), "m.h5").find("'K' is packed (scale_factor)"), std::string::npos);
}

// Matrices that no role of the model takes, and what the files hold beside matrices, reach the notes of the model.
TEST(MatrixLedger, WhatAModelDoesNotUseIsInItsNotes) {
  const ScratchFolder folder("matrix_ledger");
  std::ofstream(folder / "part.mtx") << element << "*MATRIX, TYPE=MASS\n1.\n0., 1.\n*MATRIX, TYPE=OTHER\n1.\n0., 1.\n"
                                     << "*CLOAD\n7, 1, 5.\n";
  const auto model = read_superelement({folder / "part.mtx"});
  ASSERT_EQ(model.notes.size(), 2u);
  EXPECT_EQ(model.notes[0], "part.mtx: keywords that are not used: *cload");
  EXPECT_EQ(model.notes[1], "part.mtx: matrix 'other' is not used");
}

}  // namespace
}  // namespace kalfem
