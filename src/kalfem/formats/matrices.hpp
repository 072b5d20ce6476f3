// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "kalfem/model/linear_model.hpp"

namespace kalfem {

/// What one row of a matrix of another code is.
struct MatrixDof {
  std::int64_t node = 0;  ///< the other code's number of the node, or of the generalised coordinate
  int direction = 0;      ///< 0 ... 5 for x, y, z, rx, ry, rz; -1 for a generalised coordinate
  int copy = 0;           ///< 1, 2, ... of rows to which the other code gives one number, such as the two sides of a
                          ///< shell that CalculiX expands to solids; 0: the row is the only one

  bool operator==(const MatrixDof&) const = default;
  auto operator<=>(const MatrixDof&) const = default;
};

/// A matrix that another code wrote.
struct ForeignMatrix {
  std::string name;                     ///< as in the file, or the name of the file
  SparseMatrix matrix;                  ///< rows x columns; both triangles where it is symmetric
  std::vector<MatrixDof> dofs;          ///< of its rows; empty: the file does not say
  bool symmetric = false;               ///< the file says so; both triangles are filled in any case
  std::vector<std::string> notes = {};  ///< what the file holds and is not used; at its first matrix
};

/// How matrices are written down.
enum class MatrixFormat {
  automatic,      ///< by the content of the file, then by the end of its name
  matrix_market,  ///< .mtx: coordinate and array [BPR96]
  triplets,       ///< .sti, .mas of CalculiX: "row column value", one triangle, rows in the .dof file beside it
  nodal,   ///< "node, direction, node, direction, value", alone or below keyword lines such as *MATRIX, TYPE=STIFFNESS
  dmig,    ///< Nastran bulk data or punch file with DMIG entries
  op4,     ///< Nastran OUTPUT4, text or binary
  op2,     ///< Nastran OUTPUT2, matrix data blocks
  hdf5,    ///< datasets, groups of triplets or compressed rows or columns; netCDF-4; MATLAB 7.3
  netcdf,  ///< netCDF classic, as the superelements of Sierra SD are
  matlab   ///< MATLAB 5 to 7 files
};

/// The format by its name as a user writes it ("matrix_market", "op4", ...); empty where there is none of that name.
std::optional<MatrixFormat> matrix_format(std::string_view name);

struct MatrixReadOptions {
  MatrixFormat format = MatrixFormat::automatic;
  std::vector<std::string> names = {};  ///< matrices that are wanted, whatever their case; empty: all that are there
};

/// Matrices of a file in the order of the file. A file that ends in .gz is uncompressed first. Duplicates of an entry
/// are summed where the format says so, and refused otherwise.
/// Throws InvalidInput where the file cannot be understood, is cut off, holds a number that is not finite, an index out
/// of range or complex values, or lacks a matrix that is asked for by name (naming those that are there).
std::vector<ForeignMatrix> read_matrices(const std::filesystem::path& path, const MatrixReadOptions& options = {});

/// The same from the bytes of a file; `source` names it in messages and decides by its end where the bytes do not.
std::vector<ForeignMatrix> parse_matrices(std::string_view bytes, const std::string& source,
                                          const MatrixReadOptions& options = {});

struct DofMapOptions {
  int directions = 0;  ///< of every node of a list of node numbers: 3 for x, y, z, 6 with rotations;
                       ///< 0: the file names the direction of every row
};

/// What the rows of a matrix are: one a line as "node.direction" (CalculiX), "node direction" in columns or separated
/// by commas, with or without a header line; directions 1 ... 6 or x, y, z, rx, ry, rz; 0, -1 or q for a generalised
/// coordinate. With `directions` every line is one node. netCDF files give the map of their superelement.
/// A degree of freedom that "node.direction" names several times has copies, see MatrixDof.
/// Throws InvalidInput with every line that cannot be understood or names a degree of freedom again.
std::vector<MatrixDof> read_dof_map(const std::filesystem::path& path, const DofMapOptions& options = {});
std::vector<MatrixDof> parse_dof_map(std::string_view text, const std::string& source,
                                     const DofMapOptions& options = {});

}  // namespace kalfem
