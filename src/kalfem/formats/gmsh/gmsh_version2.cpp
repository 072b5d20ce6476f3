#include <algorithm>

#include "kalfem/formats/gmsh/gmsh_versions.hpp"

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
  in.fail(start, "an element is of type " + std::to_string(number), "Gmsh's format has no such type",
          "write the mesh again");
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
    nodes_.clear();
    for (int i = 0; i < kind.type->nodes; ++i) nodes_.push_back(in_.int32("an element's node"));
    add(kind, id, physical, entity, start);
  }

private:
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
              "there must be one at least, and " + std::to_string(count - done) + " at most", "write the mesh again");
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
