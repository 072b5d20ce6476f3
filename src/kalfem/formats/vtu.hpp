// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "kalfem/model/mesh/mesh.hpp"

namespace kalfem {

/// A field over the nodes of a mesh: a displacement, a rotation, a temperature.
struct NodalField {
  std::string name;
  Eigen::MatrixXd values;  ///< components x nodes
};

/// A field over the cells of a mesh: a stress, a strain. Order of tensors: xx yy zz xy yz xz.
struct CellField {
  std::string name;
  Eigen::MatrixXd values;  ///< components x cells
};

/// Writes a mesh and fields over its nodes and cells as a VTK unstructured grid (.vtu, numbers as raw bytes behind the
/// XML), which ParaView reads. The arrays "node" and "cell" hold the numbers of the mesh's file, "region" of a cell the
/// position of its region in the alphabetical list "regions" among the field data, -1 for a cell of none; a cell of
/// several regions counts to the first. Throws InvalidInput when a field does not fit the mesh, when names are empty or
/// double, or when the file cannot be written. The format is described in "VTK File Formats" of the VTK user's guide
/// [SML06].
void write_vtu(const std::filesystem::path& file, const Mesh& mesh, const std::vector<NodalField>& fields,
               const std::vector<CellField>& cell_fields = {});

/// One moment of a series.
struct SeriesEntry {
  double time = 0.0;  ///< [s]
  std::string file;   ///< the .vtu file, as seen from the folder of the collection
};

/// Writes a series of .vtu files as one ParaView collection (.pvd). Throws InvalidInput when a time is not finite or
/// the file cannot be written.
void write_pvd(const std::filesystem::path& file, const std::vector<SeriesEntry>& entries);

}  // namespace kalfem
