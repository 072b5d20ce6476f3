#pragma once

#include <filesystem>
#include <string>

#include "kalfem/model/mesh/mesh.hpp"

namespace kalfem {

/// Reads a Gmsh mesh, MSH 2.2 or 4.1, ASCII or binary (little or big endian as this machine), whole or partitioned.
///
/// Physical groups become regions (their cells) and node sets (the nodes of these cells, ascending), under their name
/// or else "physical<number>"; groups of one name are joined. Cells of the mesh's highest dimension that no group holds
/// make up the region "mesh"; lower cells without a group are boundaries of the geometry and stay without a region.
/// Sections other than names, entities, nodes and elements are skipped.
///
/// Throws InvalidInput with the file's line (for binary files the byte) for everything that cannot be read: another
/// format or version, a truncated file, unknown or doubled nodes, coordinates that are not finite, cells of a type
/// without a CellShape. The format is described in the Gmsh reference manual, "MSH file format" [GR09].
Mesh read_gmsh(const std::filesystem::path& file);

/// The same from a file's content; `source` names it in messages.
Mesh parse_gmsh(std::string content, const std::string& source);

}  // namespace kalfem
