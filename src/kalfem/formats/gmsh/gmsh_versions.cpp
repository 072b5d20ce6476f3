// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/gmsh/gmsh_builder.hpp"

#include <algorithm>
#include <string>
#include <utility>

namespace kalfem {
namespace {

constexpr const char* in_partitions = "the mesh is read as one, whatever process it was made for";

}  // namespace
}  // namespace kalfem

namespace kalfem::gmsh2 {

namespace {

/// The count in a section's second line, which is text in binary files too.
std::int64_t read_count(GmshScanner& in, const char* items, std::size_t words, std::size_t bytes) {
  const std::size_t start = in.start();
  const std::int64_t count = in.text_integer((std::string("the number of ") + items).c_str());
  in.line();
  return in.check_count(count, items, start, words, bytes);
}

/// Type and number of tags that elements have in common.
struct Kind {
  const GmshType* type = nullptr;
  std::int64_t tags = 0;
};

const GmshType& read_type(GmshScanner& in) {
  const std::size_t start = in.start();
  const std::int64_t number = in.int32("an element's type");
  if (const GmshType* type = find_gmsh_type(number)) return *type;
  in.fail(start, "an element is of type " + std::to_string(number), "the Gmsh format has no such type",
          "export the mesh again");
}

std::int64_t read_tag_count(GmshScanner& in) {
  const std::size_t start = in.start();
  return in.check_count(in.int32("the number of an element's tags"), "tags of an element", start, 1, 4);
}

/// Reads elements one after another. An element of several groups stands in the file once for each of them, in a row.
class ElementReader {
public:
  ElementReader(GmshScanner& in, GmshBuilder& mesh) : in_(in), mesh_(mesh) {}

  /// What follows the element's kind (and, in ASCII files, its number).
  void read(const Kind& kind, std::int64_t id, std::size_t start) {
    std::int64_t physical = 0, entity = 0;
    for (std::int64_t i = 0; i < kind.tags; ++i) {
      const std::int64_t tag = in_.int32("an element's tag");
      if (i == 0) physical = tag;
      if (i == 1) entity = tag;
    }
    if (kind.tags > 2 && !std::exchange(told_tags_, true))
      mesh_.tell(start, "further tags of elements (partitions)", in_partitions);
    nodes_.clear();
    for (int i = 0; i < kind.type->nodes; ++i) nodes_.push_back(in_.int32("an element's node"));
    add(kind, id, physical, entity, start);
  }

private:
  // Version 2.2 repeats an element of several physical groups as one record for each group. Records in a row that
  // differ in their group alone are one cell.
  void add(const Kind& kind, std::int64_t id, std::int64_t physical, std::int64_t entity, std::size_t start) {
    const bool same = kind.type == last_type_ && entity == last_entity_ && physical != last_physical_ &&
                      last_physical_ != 0 && physical != 0 && nodes_ == last_nodes_;
    last_type_ = kind.type;
    last_entity_ = entity;
    last_physical_ = physical;
    last_nodes_ = nodes_;
    if (same && kind.type->shape) return mesh_.add_last_to(mesh_.group(kind.type->dimension, physical));
    groups_.clear();
    if (physical != 0) groups_.push_back(mesh_.group(kind.type->dimension, physical));
    mesh_.add_element(*kind.type, id, nodes_, groups_, start);
  }

  GmshScanner& in_;
  GmshBuilder& mesh_;
  std::vector<std::int64_t> nodes_, last_nodes_;
  std::vector<std::size_t> groups_;
  const GmshType* last_type_ = nullptr;
  std::int64_t last_physical_ = 0, last_entity_ = 0;
  bool told_tags_ = false;
};

void read_text_elements(GmshScanner& in, ElementReader& elements, std::int64_t count) {
  for (std::int64_t i = 0; i < count; ++i) {
    const std::size_t start = in.start();
    const std::int64_t id = in.int32("an element's number");
    Kind kind;
    kind.type = &read_type(in);
    kind.tags = read_tag_count(in);
    elements.read(kind, id, start);
    in.end_record(start, "an element of this type");
  }
}

/// In binary files elements of one kind may share its description.
void read_binary_elements(GmshScanner& in, ElementReader& elements, std::int64_t count) {
  for (std::int64_t done = 0; done < count;) {
    const std::size_t start = in.start();
    Kind kind;
    kind.type = &read_type(in);
    const std::int64_t block = in.int32("a number of elements");
    if (block < 1 || block > count - done)
      in.fail(start, "a block has " + std::to_string(block) + " elements",
              "it must have at least one and " + std::to_string(count - done) + " at most", "export the mesh again");
    kind.tags = read_tag_count(in);
    for (std::int64_t i = 0; i < block; ++i) {
      const std::size_t own = in.start();
      elements.read(kind, in.int32("an element's number"), own);
    }
    done += block;
  }
}

}  // namespace

void read_nodes(GmshScanner& in, GmshBuilder& mesh) {
  const std::int64_t count = read_count(in, "nodes", 4, 28);
  mesh.reserve_nodes(count);
  for (std::int64_t i = 0; i < count; ++i) {
    const std::size_t start = in.start();
    const std::int64_t id = in.int32("a node's number");
    Eigen::Vector3d place;
    for (double& coordinate : place) coordinate = in.real("a node's coordinate");
    in.end_record(start, "a node");
    mesh.add_node(id, place, start);
  }
  mesh.finish_nodes();
}

void read_elements(GmshScanner& in, GmshBuilder& mesh) {
  const std::int64_t count = read_count(in, "elements", 4, 8);
  ElementReader elements(in, mesh);
  if (in.binary())
    read_binary_elements(in, elements, count);
  else
    read_text_elements(in, elements, count);
}

}  // namespace kalfem::gmsh2

namespace kalfem::gmsh4 {

namespace {

constexpr std::size_t size_bytes = 8, int_bytes = 4, real_bytes = 8;

/// A count of items of so many words, or bytes, each at least.
std::int64_t read_count(GmshScanner& in, const char* items, std::size_t words, std::size_t bytes) {
  const std::size_t start = in.start();
  return in.check_count(in.int64((std::string("the number of ") + items).c_str()), items, start, words, bytes);
}

void skip_ints(GmshScanner& in, const char* what) {
  const std::int64_t count = read_count(in, what, 1, int_bytes);
  for (std::int64_t i = 0; i < count; ++i) in.int32(what);
}

/// One entity: its number, where `partitioned` its parent and partitions, its extent, its physical groups, its
/// boundary.
void read_entity(GmshScanner& in, GmshBuilder& mesh, EntityGroups& groups, int dimension, bool partitioned) {
  const std::int64_t number = in.int32("an entity's number");
  if (partitioned) {
    in.int32("the dimension of an entity's parent");
    in.int32("the number of an entity's parent");
    mesh.tell(in.start(), "partitions of entities", in_partitions);
    skip_ints(in, "partitions of an entity");
  }
  for (int i = 0; i < (dimension == 0 ? 3 : 6); ++i) in.real("an entity's extent");
  const std::int64_t count = read_count(in, "physical groups of an entity", 1, int_bytes);
  auto& own = groups[{dimension, number}];
  for (std::int64_t i = 0; i < count; ++i) own.push_back(mesh.group(dimension, in.int32("a physical group")));
  if (dimension > 0) skip_ints(in, "bounding entities");
}

void read_all_entities(GmshScanner& in, GmshBuilder& mesh, EntityGroups& groups, bool partitioned) {
  std::int64_t counts[4];
  for (auto& count : counts) count = read_count(in, "entities", 5, int_bytes + 3 * real_bytes + size_bytes);
  for (int dimension = 0; dimension < 4; ++dimension)
    for (std::int64_t i = 0; i < counts[dimension]; ++i) read_entity(in, mesh, groups, dimension, partitioned);
}

/// The head of nodes or elements: blocks and items in all. The lowest and highest number that follow are not needed.
struct Head {
  std::int64_t blocks = 0, items = 0;
};

Head read_head(GmshScanner& in, const char* items, std::size_t words, std::size_t bytes) {
  Head head;
  head.blocks = read_count(in, "blocks", 4, 3 * int_bytes + size_bytes);
  head.items = read_count(in, items, words, bytes);
  in.int64("the lowest number");
  in.int64("the highest number");
  return head;
}

/// The count in a block's head, which must not go beyond what the section announced.
std::int64_t read_block_count(GmshScanner& in, const char* items, std::int64_t left) {
  const std::size_t start = in.start();
  const std::int64_t count = in.int64((std::string("the number of ") + items + " of a block").c_str());
  if (count < 0 || count > left)
    in.fail(start, "a block announces " + std::to_string(count) + " " + items,
            "the section has " + std::to_string(left) + " left", "export the mesh again");
  return count;
}

void check_left(GmshScanner& in, const char* items, std::int64_t left) {
  if (left > 0)
    in.fail(in.start(), "the blocks end " + std::to_string(left) + " " + items + " early",
            "they must have as many entries as the section announces", "export the mesh again");
}

struct NumberInFile {
  std::int64_t number = 0;
  std::size_t start = 0;
};

/// Numbers of the nodes first, then their coordinates, with those in the entity's own parameters where it says so.
std::int64_t read_node_block(GmshScanner& in, GmshBuilder& mesh, std::int64_t left,
                             std::vector<NumberInFile>& numbers) {
  const std::size_t start = in.start();
  const std::int64_t dimension = in.int32("an entity's dimension");
  if (dimension < 0 || dimension > 3)
    in.fail(start, "an entity's dimension is " + std::to_string(dimension), "it must be 0, 1, 2 or 3",
            "export the mesh again");
  in.int32("an entity's number");
  const std::int64_t parameters = in.int32("whether nodes are parametric") != 0 ? dimension : 0;
  if (parameters > 0)
    mesh.tell(start, "parametric coordinates of nodes", "the nodes have their places; the geometry behind is not used");
  const std::int64_t count = read_block_count(in, "nodes", left);
  numbers.clear();
  for (std::int64_t i = 0; i < count; ++i) {
    const std::size_t own = in.start();
    numbers.push_back({in.int64("a node's number"), own});
  }
  for (const auto& node : numbers) {
    const std::size_t line = in.start();
    Eigen::Vector3d place;
    for (double& coordinate : place) coordinate = in.real("a node's coordinate");
    for (std::int64_t i = 0; i < parameters; ++i) in.real("a node's parametric coordinate");
    in.end_record(line, "a node");
    mesh.add_node(node.number, place, node.start);
  }
  return count;
}

// In version 4.1 elements stand in blocks of one entity and one type; the physical groups are those of the entity.
std::int64_t read_element_block(GmshScanner& in, GmshBuilder& mesh, const EntityGroups& groups, std::int64_t left,
                                std::vector<std::int64_t>& nodes) {
  const std::int64_t dimension = in.int32("an entity's dimension");
  const std::int64_t entity = in.int32("an entity's number");
  const std::size_t start = in.start();
  const std::int64_t number = in.int32("an element type");
  const GmshType* type = find_gmsh_type(number);
  if (!type)
    in.fail(start, "elements are of type " + std::to_string(number), "the Gmsh format has no such type",
            "export the mesh again");
  const std::int64_t count = read_block_count(in, "elements", left);
  const auto found = groups.find({dimension, entity});
  const auto own = found == groups.end() ? std::span<const std::size_t>() : found->second;
  nodes.resize(static_cast<std::size_t>(type->nodes));
  for (std::int64_t i = 0; i < count; ++i) {
    const std::size_t line = in.start();
    const std::int64_t id = in.int64("an element's number");
    for (auto& node : nodes) node = in.int64("an element's node");
    in.end_record(line, "an element of this type");
    mesh.add_element(*type, id, nodes, own, line);
  }
  return count;
}

}  // namespace

void read_entities(GmshScanner& in, GmshBuilder& mesh, EntityGroups& groups) {
  read_all_entities(in, mesh, groups, false);
}

void read_partitioned_entities(GmshScanner& in, GmshBuilder& mesh, EntityGroups& groups) {
  in.int64("the number of partitions");
  const std::int64_t ghosts = read_count(in, "ghost entities", 2, 2 * int_bytes);
  if (ghosts > 0)
    mesh.tell(in.start(), "ghost entities", "copies of elements in other partitions; those are read once");
  for (std::int64_t i = 0; i < 2 * ghosts; ++i) in.int32("a ghost entity");
  read_all_entities(in, mesh, groups, true);
}

void read_nodes(GmshScanner& in, GmshBuilder& mesh) {
  const Head head = read_head(in, "nodes", 4, size_bytes + 3 * real_bytes);
  mesh.reserve_nodes(head.items);
  std::vector<NumberInFile> numbers;
  std::int64_t left = head.items;
  for (std::int64_t i = 0; i < head.blocks; ++i) left -= read_node_block(in, mesh, left, numbers);
  check_left(in, "nodes", left);
  mesh.finish_nodes();
}

void read_elements(GmshScanner& in, GmshBuilder& mesh, const EntityGroups& groups) {
  const Head head = read_head(in, "elements", 2, 2 * size_bytes);
  std::vector<std::int64_t> nodes;
  std::int64_t left = head.items;
  for (std::int64_t i = 0; i < head.blocks; ++i) left -= read_element_block(in, mesh, groups, left, nodes);
  check_left(in, "elements", left);
}

}  // namespace kalfem::gmsh4
