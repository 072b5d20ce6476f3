// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/vtu.hpp"

#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <set>
#include <span>

#include "kalfem/base/atomic_file.hpp"
#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/text.hpp"

namespace kalfem {

namespace {

/// Numbers of the VTK file formats, in the order of CellShape.
std::uint8_t vtk_type(CellShape shape) {
  static constexpr std::array<std::uint8_t, 13> types = {1, 3, 21, 5, 22, 9, 23, 10, 24, 13, 26, 12, 25};
  return types[static_cast<std::size_t>(shape)];
}

/// VTK looks at wedges from the other side: the first face from outside. Empty: in the same order.
std::span<const std::size_t> vtk_order(CellShape shape) {
  static constexpr std::array<std::size_t, 6> linear = {0, 2, 1, 3, 5, 4};
  static constexpr std::array<std::size_t, 15> quadratic = {0, 2, 1, 3, 5, 4, 8, 7, 6, 11, 10, 9, 12, 14, 13};
  if (shape == CellShape::wedge6) return linear;
  if (shape == CellShape::wedge15) return quadratic;
  return {};
}

const char* type_name(double) { return "Float64"; }
const char* type_name(std::int64_t) { return "Int64"; }
const char* type_name(std::int32_t) { return "Int32"; }
const char* type_name(std::uint8_t) { return "UInt8"; }

/// The XML with its arrays, whose bytes are collected to stand behind it, each after their number in 8 bytes.
class VtkDocument {
public:
  void add(const std::string& xml) { xml_ += xml; }

  template <typename Number>
  void add_array(const std::string& name, std::size_t components, std::span<const Number> values) {
    xml_ += std::string("<DataArray type=\"") + type_name(Number{}) + "\" Name=\"" + escaped(name) +
            "\" NumberOfComponents=\"" + std::to_string(components) + "\" format=\"appended\" offset=\"" +
            std::to_string(bytes_.size()) + "\"/>\n";
    const std::uint64_t size = values.size_bytes();
    bytes_.append(reinterpret_cast<const char*>(&size), sizeof size);
    bytes_.append(reinterpret_cast<const char*>(values.data()), values.size_bytes());
  }

  [[nodiscard]] std::string text() const {
    const char* const order = std::endian::native == std::endian::little ? "LittleEndian" : "BigEndian";
    return "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"" +
           std::string(order) + "\" header_type=\"UInt64\">\n<UnstructuredGrid>\n" + xml_ +
           "</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_" + bytes_ + "\n</AppendedData>\n</VTKFile>\n";
  }

private:
  std::string xml_, bytes_;
};

/// Names and sizes of the fields over the `count` nodes or cells (`what`), which have arrays of these names already.
template <class Field>
void check(const std::vector<Field>& fields, Eigen::Index count, const std::string& what, std::set<std::string> names,
           IssueList& issues) {
  for (const auto& field : fields) {
    if (field.name.empty()) issues.add({}, "a field has no name", "ParaView needs names for fields", "name it");
    if (!names.insert(field.name).second)
      issues.add({}, "the field '" + field.name + "' is given twice or has the name of the numbers of " + what + "s",
                 "names must differ", "rename it");
    if (field.values.cols() != count || field.values.rows() < 1)
      issues.add(
          {},
          "the field '" + field.name + "' is of size " + std::to_string(field.values.rows()) + " x " +
              std::to_string(field.values.cols()),
          "it needs one column for each of the " + std::to_string(count) + " " + what + "s, and at least one row",
          "give a matrix of components x " + what + "s");
  }
}

template <class Field>
void add_fields(VtkDocument& document, const std::vector<Field>& fields) {
  for (const auto& field : fields)
    document.add_array<double>(field.name, static_cast<std::size_t>(field.values.rows()),
                               {field.values.data(), static_cast<std::size_t>(field.values.size())});
}

/// Names as VTK writes strings in ASCII: the codes of their characters, each name closed by a zero.
void add_region_names(VtkDocument& document, const Mesh& mesh) {
  if (mesh.regions.empty()) return;
  document.add("<FieldData>\n<DataArray type=\"String\" Name=\"regions\" NumberOfTuples=\"" +
               std::to_string(mesh.regions.size()) + "\" format=\"ascii\">\n");
  for (const auto& [name, cells] : mesh.regions) {
    std::string codes;
    for (const unsigned char c : name) codes += std::to_string(c) + " ";
    document.add(codes + "0\n");
  }
  document.add("</DataArray>\n</FieldData>\n");
}

void add_nodes(VtkDocument& document, const Mesh& mesh, const std::vector<NodalField>& fields) {
  document.add("<PointData>\n");
  document.add_array<std::int64_t>("node", 1, mesh.node_ids);
  add_fields(document, fields);
  document.add("</PointData>\n<Points>\n");
  document.add_array<double>("points", 3, {mesh.nodes.data(), static_cast<std::size_t>(mesh.nodes.size())});
  document.add("</Points>\n");
}

void add_cells(VtkDocument& document, const Mesh& mesh) {
  std::vector<std::int64_t> nodes, ends, numbers;
  std::vector<std::uint8_t> types;
  for (const auto& cell : mesh.cells) {
    const auto own = mesh.nodes_of(cell);
    const auto order = vtk_order(cell.shape);
    for (std::size_t i = 0; i < own.size(); ++i) nodes.push_back(own[order.empty() ? i : order[i]]);
    ends.push_back(static_cast<std::int64_t>(nodes.size()));
    types.push_back(vtk_type(cell.shape));
    numbers.push_back(cell.id);
  }
  document.add("<Cells>\n");
  document.add_array<std::int64_t>("connectivity", 1, nodes);
  document.add_array<std::int64_t>("offsets", 1, ends);
  document.add_array<std::uint8_t>("types", 1, types);
  document.add("</Cells>\n<CellData Scalars=\"region\">\n");
  document.add_array<std::int64_t>("cell", 1, numbers);
}

// A cell has one region number, the first in the order of the names, while regions may overlap; -1 is none.
void add_cell_regions(VtkDocument& document, const Mesh& mesh) {
  std::vector<std::int32_t> region_of(mesh.cells.size(), -1);
  std::int32_t position = 0;
  for (const auto& [name, cells] : mesh.regions) {
    for (const auto cell : cells)
      if (auto& region = region_of[static_cast<std::size_t>(cell)]; region < 0) region = position;
    ++position;
  }
  document.add_array<std::int32_t>("region", 1, region_of);
}

std::string shortest(double value) {
  std::array<char, 32> digits{};
  return {digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr};
}

}  // namespace

// Writes the parts in the order of the VTK XML schema: field data, then one piece with point data, points, cells and
// cell data. Arrays are stored raw behind the XML (appended data), so no digits are lost and the file is read at
// once.
void write_vtu(const std::filesystem::path& file, const Mesh& mesh, const std::vector<NodalField>& fields,
               const std::vector<CellField>& cell_fields) {
  IssueList issues;
  check(fields, mesh.node_count(), "node", {"node"}, issues);
  check(cell_fields, static_cast<Eigen::Index>(mesh.cells.size()), "cell", {"cell", "region"}, issues);
  issues.raise();
  VtkDocument document;
  add_region_names(document, mesh);
  document.add("<Piece NumberOfPoints=\"" + std::to_string(mesh.node_count()) + "\" NumberOfCells=\"" +
               std::to_string(mesh.cells.size()) + "\">\n");
  add_nodes(document, mesh, fields);
  add_cells(document, mesh);
  add_cell_regions(document, mesh);
  add_fields(document, cell_fields);
  document.add("</CellData>\n</Piece>\n");
  write_file_atomically(file, document.text());
}

void write_pvd(const std::filesystem::path& file, const std::vector<SeriesEntry>& entries) {
  std::string text = "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>\n";
  for (const auto& entry : entries) {
    if (!std::isfinite(entry.time))
      throw InvalidInput("the time of '" + entry.file + "' is not finite",
                         "a series needs a finite time for every file", "give it in s");
    text += "<DataSet timestep=\"" + shortest(entry.time) + "\" part=\"0\" file=\"" + escaped(entry.file) + "\"/>\n";
  }
  write_file_atomically(file, text + "</Collection>\n</VTKFile>\n");
}

}  // namespace kalfem
