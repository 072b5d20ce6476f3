// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "kalfem/formats/gmsh/gmsh_scanner.hpp"
#include "kalfem/formats/ledger.hpp"
#include "kalfem/model/mesh/mesh.hpp"

namespace kalfem {

/// A type of element of the MSH format.
struct GmshType {
  int number = 0;
  int dimension = 0;
  int nodes = 0;
  std::string name;
  std::optional<CellShape> shape = {};  ///< nothing where the program has no such cell
  std::array<int, 20> order = {};  ///< where each of the shape's nodes stands in the file; all 0: in the same order
};

/// The type of this number, nullptr where the format has none.
const GmshType* find_gmsh_type(std::int64_t number);

/// Finds positions in a list of distinct numbers: by a table where they are dense, by bisection where they are not.
class NumberLookup {
public:
  NumberLookup() = default;
  explicit NumberLookup(const std::vector<std::int64_t>& numbers);
  /// Position of the number, -1 where there is none.
  [[nodiscard]] Eigen::Index find(std::int64_t number) const;
  /// Position of an earlier equal number for each number that stands a second time, as (later, earlier), ascending.
  [[nodiscard]] const std::vector<std::pair<Eigen::Index, Eigen::Index>>& repeated() const { return repeated_; }

private:
  void fill_table(const std::vector<std::int64_t>& numbers, std::uint64_t span);
  void sort_numbers(const std::vector<std::int64_t>& numbers);

  std::int64_t lowest_ = 0;
  std::vector<Eigen::Index> table_;
  std::vector<std::pair<std::int64_t, Eigen::Index>> sorted_;
  std::vector<std::pair<Eigen::Index, Eigen::Index>> repeated_;
};

/// Puts a mesh together from what the sections of a Gmsh file say, in their order: names, nodes, elements. Notes what
/// is wrong with the scanner, by the position in the file.
class GmshBuilder {
public:
  explicit GmshBuilder(GmshScanner& in) : in_(in) {}

  void name_group(std::int64_t dimension, std::int64_t number, std::string name);
  /// Index of the physical group of this dimension and number, made where it is new.
  std::size_t group(std::int64_t dimension, std::int64_t number);

  void reserve_nodes(std::int64_t count);
  /// Notes coordinates that are not finite; `start`: position of the node's number in the file.
  void add_node(std::int64_t id, const Eigen::Vector3d& place, std::size_t start);
  /// Notes nodes that stand twice.
  void finish_nodes();
  [[nodiscard]] bool has_nodes() const { return has_nodes_; }

  /// Adds a cell to its groups; notes nodes that do not exist and types without a CellShape.
  void add_element(const GmshType& type, std::int64_t id, std::span<const std::int64_t> nodes,
                   std::span<const std::size_t> groups, std::size_t start);
  /// Adds the last cell to one more group.
  void add_last_to(std::size_t group);
  [[nodiscard]] bool has_cells() const { return !mesh_.cells.empty(); }

  /// Tells that what stands at a position of the file is not used.
  void tell(std::size_t position, const std::string& what, const std::string& consequence);
  [[nodiscard]] DeckNotes& notes() { return notes_; }

  /// Throws InvalidInput with everything noted.
  Mesh finish();

private:
  struct Group {
    std::string name;
    std::vector<Eigen::Index> cells;
  };
  struct Refused {
    std::size_t first = 0;
    std::int64_t count = 0;
  };

  void add_cells_without_group();
  void add_regions();
  void note_refused();
  void tell_what_no_group_holds(const std::vector<bool>& grouped, int highest);
  void tell_empty_groups();

  GmshScanner& in_;
  DeckNotes notes_;
  Mesh mesh_;
  std::vector<Eigen::Vector3d> places_;
  std::vector<std::size_t> node_starts_;
  NumberLookup lookup_;
  bool has_nodes_ = false;
  std::map<std::pair<std::int64_t, std::int64_t>, std::string> names_;
  std::map<std::pair<std::int64_t, std::int64_t>, std::size_t> group_indices_;
  std::vector<Group> groups_;
  std::map<const GmshType*, Refused> refused_;
  std::vector<Eigen::Index> found_;  ///< workspace of add_element
};

}  // namespace kalfem

/// The sections of a Gmsh file as the versions 2.2 and 4.1 of the format write them; each reader begins behind the
/// section's first line and stops before its last one.
namespace kalfem::gmsh2 {

void read_nodes(GmshScanner& in, GmshBuilder& mesh);
void read_elements(GmshScanner& in, GmshBuilder& mesh);

}  // namespace kalfem::gmsh2

namespace kalfem::gmsh4 {

/// Groups (as the builder numbers them) of each entity, by its dimension and number.
using EntityGroups = std::map<std::pair<std::int64_t, std::int64_t>, std::vector<std::size_t>>;

void read_entities(GmshScanner& in, GmshBuilder& mesh, EntityGroups& groups);
void read_partitioned_entities(GmshScanner& in, GmshBuilder& mesh, EntityGroups& groups);
void read_nodes(GmshScanner& in, GmshBuilder& mesh);
void read_elements(GmshScanner& in, GmshBuilder& mesh, const EntityGroups& groups);

}  // namespace kalfem::gmsh4
