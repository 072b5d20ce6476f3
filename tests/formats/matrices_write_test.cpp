// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/matrices/write.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <random>

#include "base/scratch_folder.hpp"
#include "kalfem/base/invalid_input.hpp"
#include "kalfem/formats/hdf5/hdf5_file.hpp"
#include "kalfem/formats/matrices/matrix_model.hpp"

namespace kalfem {
namespace {

namespace fs = std::filesystem;
using Eigen::Index;

/// A random sparse matrix with entries of all sizes; symmetric and diagonally dominant where it is wanted.
SparseMatrix random_matrix(Index rows, Index columns, bool symmetric, unsigned seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> digits(-1.0, 1.0), exponent(-12.0, 6.0);
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(rows, columns);
  for (Index i = 0; i < rows; ++i)
    for (Index j = 0; j < columns; ++j)
      if (generator() % 3 == 0) dense(i, j) = digits(generator) * std::pow(10.0, exponent(generator));
  if (symmetric) {
    dense = (dense + dense.transpose()).eval();
    dense.diagonal().setConstant(1e8 / 3.0);
  }
  return dense.sparseView();
}

/// The 16 characters of a number on a DMIG card hold 11 digits or more: half a unit of the last, relative.
constexpr double eleven_digits = 5.1e-11;

class MatrixFiles : public testing::Test {
protected:
  /// Largest difference, relative to each entry.
  static double difference(const SparseMatrix& one, const SparseMatrix& other) {
    if (one.rows() != other.rows() || one.cols() != other.cols()) return 1.0;
    const Eigen::ArrayXXd a = Eigen::MatrixXd(one), b = Eigen::MatrixXd(other);
    return ((a - b).abs() / b.abs().max(1e-300)).maxCoeff();
  }

  ScratchFolder folder_{"matrices-written"};
};

TEST_F(MatrixFiles, EveryFormatGivesTheMatricesBack) {
  const std::vector<MatrixDof> dofs = {{3, 0}, {3, 5}, {7, 2}, {12, 1}, {1, -1}, {2, -1}};
  const ForeignMatrix symmetric{"KAA", random_matrix(6, 6, true, 1), dofs, true};
  const ForeignMatrix general{"B", random_matrix(6, 6, false, 2), dofs, false};
  const struct {
    MatrixFormat format;
    MatrixWriteOptions options;
    double tolerance;
    bool with_map;
  } cases[] = {{MatrixFormat::op4, {.binary = true}, 0.0, false},
               {MatrixFormat::op4, {.binary = true, .big_endian = true}, 0.0, false},
               {MatrixFormat::op4, {.binary = false}, 0.0, false},
               {MatrixFormat::hdf5, {}, 0.0, true},
               {MatrixFormat::dmig, {}, eleven_digits, true}};
  for (const auto& [format, options, tolerance, with_map] : cases) {
    const auto file = folder_ / "matrices.dat";
    write_matrices(file, {symmetric, general}, format, options);
    const auto read = read_matrices(file);  // without a word on the format
    ASSERT_EQ(read.size(), 2u);
    for (const auto& [ours, theirs] : {std::pair(symmetric, "KAA"), std::pair(general, "B")}) {
      const auto found = read_matrices(file, {.names = {theirs}});
      const auto at = static_cast<int>(format);
      EXPECT_LE(difference(found[0].matrix, ours.matrix), tolerance) << at << theirs;
      if (with_map && format != MatrixFormat::dmig) {
        EXPECT_EQ(found[0].dofs, dofs) << at;
      }
    }
  }
}

TEST_F(MatrixFiles, MatrixMarketKeepsEveryBit) {
  for (const bool symmetric : {true, false}) {
    const ForeignMatrix matrix{"A", random_matrix(9, symmetric ? 9 : 5, symmetric, 3), {}, symmetric};
    write_matrices(folder_ / "A.mtx", {matrix}, MatrixFormat::matrix_market);
    const auto read = read_matrices(folder_ / "A.mtx");
    EXPECT_EQ(difference(read[0].matrix, matrix.matrix), 0.0);
    EXPECT_EQ(read[0].symmetric, symmetric);
    EXPECT_EQ(read[0].name, "A");
  }
}

TEST_F(MatrixFiles, ASuperelementComesBackFromEveryFormat) {
  LinearModel model;
  model.dofs = {"n7.x", "n7.rz", "mode1", "mode2"};
  model.stiffness = random_matrix(4, 4, true, 4);
  model.mass = random_matrix(4, 4, true, 5);
  model.damping = random_matrix(4, 4, true, 6);
  for (const auto format : {MatrixFormat::matrix_market, MatrixFormat::op4, MatrixFormat::hdf5, MatrixFormat::dmig}) {
    const auto files = write_superelement(folder_ / "element.dat", model, format, Eigen::MatrixXd::Ones(10, 4));
    SuperelementReadOptions options;
    std::vector<fs::path> matrices = files;
    if (files.back().extension() == ".dof") {
      options.dof_map = files.back();
      matrices.pop_back();
    }
    const LinearModel read = read_superelement(matrices, options).model;
    const bool dmig = format == MatrixFormat::dmig;
    EXPECT_EQ(read.dofs, (std::vector<std::string>{"n7.x", "n7.rz", dmig ? "q1001" : "q1", dmig ? "q1002" : "q2"}));
    const double tolerance = dmig ? eleven_digits : 0.0;
    EXPECT_LE(difference(read.stiffness, model.stiffness), tolerance);
    EXPECT_LE(difference(read.mass, model.mass), tolerance);
    EXPECT_LE(difference(read.damping, model.damping), tolerance);
    if (format == MatrixFormat::hdf5) {
      const auto file = Hdf5File::open(files[0].string());
      EXPECT_EQ(file.read_strings("/names"), model.dofs);
      EXPECT_EQ(file.read_matrix("/basis"), Eigen::MatrixXd::Ones(10, 4));
    }
  }
}

TEST_F(MatrixFiles, WhatCannotBeWrittenIsRefused) {
  const SparseMatrix square = random_matrix(3, 3, true, 7);
  SparseMatrix broken = square;
  broken.coeffs()[0] = std::nan("");
  const auto refused = [&](const std::vector<ForeignMatrix>& matrices, MatrixFormat format) {
    EXPECT_THROW(write_matrices(folder_ / "x", matrices, format), InvalidInput);
    EXPECT_FALSE(fs::exists(folder_ / "x"));
  };
  refused({{"A", square, {}, true}}, MatrixFormat::op2);
  refused({{"A", square, {}, true}, {"A", square, {}, true}}, MatrixFormat::op4);
  refused({{"a_long_name", square, {}, true}}, MatrixFormat::dmig);
  refused({{"A", square, {}, true}, {"B", square, {}, true}}, MatrixFormat::matrix_market);
  refused({{"A", broken, {}, true}}, MatrixFormat::hdf5);
  refused({{"A", random_matrix(3, 2, false, 8), {}, false}}, MatrixFormat::dmig);
}

}  // namespace
}  // namespace kalfem
