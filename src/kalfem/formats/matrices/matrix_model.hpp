// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/formats/matrices.hpp"

namespace kalfem {

struct MatrixModelOptions {
  std::vector<MatrixDof> dofs = {};  ///< of the rows, where the matrices do not say; else the order of the model
  double rounding = 1e-9;            ///< |a_ij - a_ji| up to this part of the largest entry is taken for rounding
  bool symmetrise = false;           ///< take (A + A^T) / 2 where the difference is larger, with a note, and not refuse
};

/// A structure of which only the matrices are known.
struct MatrixModel {
  LinearModel model;            ///< degrees of freedom "n12.x", generalised coordinates "q3", rows without a map "r1"
  std::vector<MatrixDof> dofs;  ///< of the rows; empty where no map was given
  std::vector<std::string> notes;  ///< what was mended or is unusual, in sentences
};

/// M z'' + C z' + K z from matrices of another code. Matrices whose rows are known need not have the same ones: entries
/// that one of them lacks are 0, and the rows are in the order of `options.dofs`, or by node and direction. Copies of a
/// degree of freedom (see MatrixDof) are "n12#1.x", "n12#2.x", and their mean is the point "n12.x".
/// Throws InvalidInput with everything that is wrong: a matrix that is not square or of another size, not symmetric, or
/// with a number that is not finite; a negative diagonal entry of K or M, or one of 0 in M or K beside entries in its
/// row (the matrix is not positive semi-definite then); a mass matrix without any mass.
MatrixModel matrix_model(const ForeignMatrix& stiffness, const ForeignMatrix& mass,
                         const std::optional<ForeignMatrix>& damping = {}, const MatrixModelOptions& options = {});

/// Matrices of a part of a structure, which need be neither all there nor positive semi-definite. Rows are those of
/// `options.dofs` or of the matrices, otherwise `rows` of them in an order that the caller knows.
/// Throws InvalidInput with everything that is wrong, as matrix_model() does, and where the rows are not known.
MatrixModel part_matrices(const std::optional<ForeignMatrix>& stiffness, const std::optional<ForeignMatrix>& mass,
                          const std::optional<ForeignMatrix>& damping, const MatrixModelOptions& options,
                          std::optional<Eigen::Index> rows);

struct SuperelementReadOptions {
  MatrixFormat format = MatrixFormat::automatic;
  std::string stiffness =
      {};  ///< name of the matrix in its file; empty: by the usual names (K, KAA, Kr, stiffness, ...)
  std::string mass = {};
  std::string damping = {};
  std::optional<std::filesystem::path> dof_map = {};  ///< where the files do not say what the rows are
  DofMapOptions map = {};
  MatrixModelOptions model = {};
};

/// A superelement, or any substructure of matrices, that another code made: stiffness, mass and, where there is one,
/// damping from the matrices of all files together, by name or, where a file holds one matrix, by the name of the file.
/// Throws InvalidInput where stiffness or mass cannot be told, naming the matrices that there are.
MatrixModel read_superelement(const std::vector<std::filesystem::path>& files,
                              const SuperelementReadOptions& options = {});

/// The degree of freedom that a name of a MatrixModel means ("n12.x", "q3"), nothing for other names.
std::optional<MatrixDof> matrix_dof(const std::string& name);

/// The name of a degree of freedom in a MatrixModel.
std::string dof_name(const MatrixDof& dof);

}  // namespace kalfem
