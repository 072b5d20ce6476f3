// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "kalfem/formats/ledger.hpp"
#include "kalfem/model/mesh/mesh.hpp"

namespace kalfem {

/// Reads a Gmsh mesh, MSH 2.2 or 4.1, ASCII or binary (little or big endian as this machine), whole or partitioned.
///
/// Physical groups become regions (their cells) and node sets (the nodes of these cells, ascending), under their name
/// or else "physical<number>"; groups of one name are joined. Cells of the mesh's highest dimension that no group holds
/// make up the region "mesh"; lower cells without a group are boundaries of the geometry and stay without a region.
/// Sections other than names, entities, nodes and elements are not used, nor are partitions and parametric coordinates:
/// `notes` tells those that the file has, groups without cells, and cells without a group that are no region. Extents
/// and boundaries of entities repeat what the mesh says.
///
/// Throws InvalidInput with the file's line (for binary files the byte) for everything that cannot be read: another
/// format or version, a truncated file, unknown or doubled nodes, coordinates that are not finite, cells of a type
/// without a CellShape. The format is described in the Gmsh reference manual, "MSH file format" [GR09].
Mesh read_gmsh(const std::filesystem::path& file, std::vector<DeckNote>* notes = nullptr);

/// The same from a file's content; `source` names it in messages.
Mesh parse_gmsh(std::string content, const std::string& source, std::vector<DeckNote>* notes = nullptr);

struct TableMeshOptions {
  std::optional<double> scale = {};        ///< of the coordinates to metres; only where their titles name no unit
  std::vector<DeckNote>* notes = nullptr;  ///< where columns that are not read are added; null: nowhere
};

/// Reads a mesh of lines from two tables, as stick models are kept in spreadsheets:
///   nodes     id, x, y, z          titles node, id, node_id, number or point, and x, y, z
///   elements  id, node, node, region   titles element, elem, id, element_id or number; node1, node2 (or node_1, n1,
///             from, first ...); region, section, group, property or part
/// A title may name the unit of a coordinate, "x [mm]", "x (mm)" or "x_mm"; without one it is metres, or as the scale
/// says. Columns may stand in any order, others are not read. Tables without titles have their columns in the order
/// above. Cells are separated by semicolon, tab, comma or blanks; comments, quotes and decimal commas are as in CSV.
///
/// Regions are named by their cells: a whole number becomes its digits ("2", also for 2.0). Elements of one region need
/// not be neighbours.
///
/// Throws InvalidInput with file and line, all problems of a table at once: cells that are empty or no (whole, finite)
/// numbers, nodes and elements of one number, unknown nodes, elements of length 0, names of regions that a case file
/// cannot hold (letters, digits, _ and - can), titles or units that are not understood.
Mesh read_table_mesh(const std::filesystem::path& nodes, const std::filesystem::path& elements,
                     const TableMeshOptions& options = {});

}  // namespace kalfem
