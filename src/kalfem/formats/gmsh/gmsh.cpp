// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/gmsh/gmsh.hpp"

#include <map>
#include <set>

#include "kalfem/formats/gmsh/gmsh_builder.hpp"

namespace kalfem {

namespace {

/// Reads the sections of one file in their order.
class GmshReader {
public:
  GmshReader(std::string content, const std::string& source) : in_(std::move(content), source), mesh_(in_) {}

  Mesh read() {
    skip_comments();
    read_format();
    while (!in_.at_end()) read_section();
    if (!mesh_.has_nodes() || seen_.count("Elements") == 0)
      in_.fail(in_.start(), std::string("the file has no $") + (mesh_.has_nodes() ? "Elements" : "Nodes") + " section",
               "a mesh needs nodes and elements", "export the mesh again, without parametric nodes in version 2.2");
    return mesh_.finish();
  }
  [[nodiscard]] DeckNotes& notes() { return mesh_.notes(); }

private:
  void skip_comments();
  void read_format();
  std::string_view next_line();
  void check_byte_order();
  void read_section();
  void read_known_section(const std::string& name, std::size_t start);
  void read_names();

  GmshScanner in_;
  GmshBuilder mesh_;
  std::set<std::string> seen_;
  gmsh4::EntityGroups groups_;
  bool version4_ = false;
  std::size_t line_start_ = 0;
};

/// Comments may stand before the format.
void GmshReader::skip_comments() {
  while (in_.next_is("$Comments")) in_.skip_section("Comments", in_.start());
}

/// $MeshFormat: version, 0 for ASCII or 1 for binary, bytes of a real number.
void GmshReader::read_format() {
  if (next_line() != "$MeshFormat")
    in_.fail(line_start_, "this is not a readable Gmsh mesh", "it must begin with $MeshFormat",
             "export it from Gmsh as .msh, version 4.1 (gmsh -format msh41) or 2.2");
  const std::size_t at = in_.start();
  const auto words = split_cells(in_.line(), ' ');
  const std::string version = words.empty() ? "" : printable(words[0]);
  version4_ = version == "4.1";
  if (!version4_ && version != "2.2")
    in_.fail(at, "the mesh has format version '" + version + "'", "versions 2.2 and 4.1 are supported",
             "export it again (gmsh -format msh41 -save, Mesh.MshFileVersion = 4.1)");
  if (words.size() != 3 || (words[1] != "0" && words[1] != "1") || words[2] != "8")
    in_.fail(at, "the format line cannot be understood",
             "it must hold the version, 0 (ASCII) or 1 (binary), and 8, the size of a number", "export the mesh again");
  if (words[1] == "1") check_byte_order();
  in_.end_section("MeshFormat");
}

/// The next line that is not blank.
std::string_view GmshReader::next_line() {
  in_.at_end();
  line_start_ = in_.start();
  return in_.line();
}

// Binary files have the integer 1 behind the format line; read in the wrong byte order it is another number.
void GmshReader::check_byte_order() {
  in_.set_binary();
  const std::size_t start = in_.start();
  if (in_.int32("the mark of the byte order") != 1)
    in_.fail(start, "the mesh has the byte order of another machine",
             "the mark after the format line must be the number 1",
             "export it on a machine like this one, or as ASCII");
}

/// What it means that a section is not used.
std::string consequence_of(const std::string& section) {
  static const std::map<std::string, std::string> known{
      {"Periodic", "nodes of periodic entities are not coupled"},
      {"NodeData", "results at nodes are not read"},
      {"ElementData", "results at elements are not read"},
      {"ElementNodeData", "results at elements are not read"},
      {"InterpolationScheme", "results are not read"},
      {"GhostElements", "copies of elements in other partitions; the elements themselves are read once"},
      {"Parametrizations", "the geometry behind the mesh is not used"}};
  const auto found = known.find(section);
  return found == known.end() ? "the MSH format has no such section" : found->second;
}

// Only five sections make a mesh. All others are passed over and told, comments aside.
void GmshReader::read_section() {
  const std::string_view line = next_line();
  const std::size_t start = line_start_;
  if (line.size() < 2 || line.front() != '$' || line.starts_with("$End"))
    in_.fail(start, "a section was expected here", "a section begins with $ and its name",
             "remove the text between the sections");
  const std::string name(line.substr(1));
  static const std::set<std::string> needed{"PhysicalNames", "Entities", "PartitionedEntities", "Nodes", "Elements"};
  if (!needed.contains(name)) {
    if (name != "Comments") mesh_.tell(start, "$" + printable(name), consequence_of(name));
    return in_.skip_section(name, start);
  }
  if (!seen_.insert(name).second)
    in_.fail(start, "there is more than one section $" + name, "a mesh may have only one", "export the mesh again");
  read_known_section(name, start);
  in_.end_section(name);
}

void GmshReader::read_known_section(const std::string& name, std::size_t start) {
  if (name == "PhysicalNames") return read_names();
  if (name == "Entities" && version4_) return gmsh4::read_entities(in_, mesh_, groups_);
  if (name == "PartitionedEntities" && version4_) return gmsh4::read_partitioned_entities(in_, mesh_, groups_);
  if (name == "Nodes") return version4_ ? gmsh4::read_nodes(in_, mesh_) : gmsh2::read_nodes(in_, mesh_);
  if (name != "Elements")
    in_.fail(start, "there is a section $" + name, "version 2.2 of the format does not have it",
             "export the mesh again");
  if (!mesh_.has_nodes())
    in_.fail(start, "the elements stand before the nodes", "the section $Nodes must come first",
             "export the mesh again");
  version4_ ? gmsh4::read_elements(in_, mesh_, groups_) : gmsh2::read_elements(in_, mesh_);
}

/// $PhysicalNames, text in binary files too: a count, then dimension, number and quoted name in each line.
void GmshReader::read_names() {
  const std::size_t start = in_.start();
  const std::int64_t announced = in_.text_integer("the number of physical names");
  in_.line();
  const std::int64_t count = in_.check_count(announced, "physical names", start, 3, 6);
  for (std::int64_t i = 0; i < count; ++i) {
    in_.at_end();
    const std::size_t line = in_.start();
    const std::int64_t dimension = in_.text_integer("the dimension of a physical group");
    const std::int64_t number = in_.text_integer("the number of a physical group");
    const auto name = in_.line();
    if (name.size() < 3 || name.front() != '"' || name.back() != '"')
      in_.fail(line, "the name of physical group " + std::to_string(number) + " cannot be read",
               "it must be in quotation marks", "correct the line");
    mesh_.name_group(dimension, number, std::string(name.substr(1, name.size() - 2)));
  }
}

}  // namespace

Mesh read_gmsh(const std::filesystem::path& file, std::vector<DeckNote>* notes) {
  return parse_gmsh(read_content(file), file.string(), notes);
}

Mesh parse_gmsh(std::string content, const std::string& source, std::vector<DeckNote>* notes) {
  GmshReader reader(std::move(content), source);
  Mesh mesh = reader.read();
  if (notes != nullptr) *notes = reader.notes().take();
  mesh.source = source;
  return mesh;
}

}  // namespace kalfem
