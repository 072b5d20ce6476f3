// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <filesystem>
#include <string>
#include <vector>

#include "kalfem/formats/matrices.hpp"

namespace kalfem {

struct MatrixWriteOptions {
  bool binary = true;       ///< of OUTPUT4
  bool big_endian = false;  ///< of binary OUTPUT4
};

/// Writes real matrices so that read_matrices() gives them back: Matrix Market (of one matrix; lower triangle where it
/// is symmetric), OUTPUT4 and HDF5 (compressed columns, map of the rows) to the last bit, DMIG with the 12 digits that
/// its fields hold. Generalised coordinates are scalar points of DMIG; where their numbers are those of nodes they are
/// moved beyond them. Matrix Market and OUTPUT4 cannot say what the rows are: see write_dof_map(). Atomic. Throws
/// InvalidInput where the format is not one of these four, a name does not fit, or the file cannot be written.
void write_matrices(const std::filesystem::path& path, const std::vector<ForeignMatrix>& matrices, MatrixFormat format,
                    const MatrixWriteOptions& options = {});

/// One row a line: node and direction 1 ... 6, number and 0 for a generalised coordinate. read_dof_map() reads it.
void write_dof_map(const std::filesystem::path& path, const std::vector<MatrixDof>& dofs);

/// Writes a substructure, such as the model of a Superelement, as matrices K, M and C (where it has damping); its modal
/// damping goes into C. Degrees of freedom "n12.x" are those of nodes, all others generalised coordinates 1, 2, ... in
/// their order. Files: HDF5 and DMIG one (in HDF5 with the names as /names, and /basis where it is given: T of z = T
/// q); OUTPUT4 one and the map beside it (.dof); Matrix Market <stem>_K.mtx, <stem>_M.mtx, <stem>_C.mtx and <stem>.dof.
/// Returns the files that were written. Throws as write_matrices() does.
std::vector<std::filesystem::path> write_superelement(const std::filesystem::path& path, const LinearModel& model,
                                                      MatrixFormat format, const Eigen::MatrixXd& basis = {},
                                                      const MatrixWriteOptions& options = {});

}  // namespace kalfem
