// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <span>

#include "kalfem/base/atomic_file.hpp"
#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/text.hpp"
#include "kalfem/formats/universal/universal.hpp"
#include "kalfem/formats/universal/universal_text.hpp"

namespace kalfem {
namespace {

using Eigen::Index;

std::string header_dataset(const MeasuredFile& file) {
  std::string content = text_column(file.description, 80) + "\n";
  for (int record = 2; record <= 7; ++record) content += text_column("", 80) + "\n";
  return dataset(151, content);
}

/// Fortran's letter of a double.
std::string double_column(double value, int width, int decimals) {
  std::string text = real_column(value, width, decimals);
  std::ranges::replace(text, 'E', 'D');
  return text;
}

std::string units_dataset() {
  std::string content = integer_column(1, 10) + text_column("SI: Meter (newton)", 20) + integer_column(2, 10) + "\n";
  for (int factor = 0; factor < 3; ++factor) content += double_column(1.0, 25, 17);
  return dataset(164, content + "\n" + double_column(273.15, 25, 17) + "\n");
}

std::string nodes_dataset(const std::vector<MeasuredNode>& nodes) {
  std::string content;
  for (const auto& node : nodes) {
    content +=
        integer_column(node.number, 10) + integer_column(1, 10) + integer_column(1, 10) + integer_column(11, 10) + "\n";
    for (const double coordinate : node.position) {
      if (!std::isfinite(coordinate))
        throw InvalidInput("node " + std::to_string(node.number) + " has a coordinate that is not finite",
                           "the format holds numbers only", "");
      content += double_column(coordinate, 25, 16);
    }
    content += "\n";
  }
  return dataset(2411, content);
}

std::string node_records(const std::vector<long>& nodes) {
  std::string records;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    records += integer_column(nodes[i], 10);
    if (i % 8 == 7 || i + 1 == nodes.size()) records += "\n";
  }
  return records;
}

bool is_beam(int kind) { return kind == 11 || (kind >= 21 && kind <= 24); }

std::string elements_dataset(const std::vector<MeasuredLine>& lines) {
  std::string content;
  for (const auto& line : lines) {
    if (line.kind == 0) continue;
    for (const long value :
         {line.number, static_cast<long>(line.kind), 1L, 1L, 7L, static_cast<long>(line.nodes.size())})
      content += integer_column(value, 10);
    content += "\n";
    if (is_beam(line.kind)) content += node_records({0, 1, 1});
    content += node_records(line.nodes);
  }
  return content.empty() ? content : dataset(2412, content);
}

std::string trace_datasets(const std::vector<MeasuredLine>& lines) {
  std::string datasets;
  for (const auto& line : lines)
    if (line.kind == 0)
      datasets +=
          dataset(82, integer_column(line.number, 10) + integer_column(static_cast<long>(line.nodes.size()), 10) +
                          integer_column(7, 10) + "\n" + text_column(line.name, 80) + "\n" + node_records(line.nodes));
  return datasets;
}

std::string real_records(std::span<const double> values) {
  std::string records;
  for (std::size_t i = 0; i < values.size(); ++i) {
    records += real_column(values[i], 13, 5);
    if (i % 6 == 5 || i + 1 == values.size()) records += "\n";
  }
  return records;
}

/// Records 7 and 8: a static shape, a normal mode by frequency and damping ratio, a complex mode by its eigenvalue.
std::string analysis_records(const MeasuredShape& shape, int analysis, long number) {
  if (analysis == 1) return node_records({1, 1, number}) + real_records(std::array{0.0});
  const double omega = 2.0 * std::numbers::pi * shape.frequency, zeta = shape.damping;
  if (analysis == 2) return node_records({2, 4, 0, number}) + real_records(std::array{shape.frequency, 1.0, zeta, 0.0});
  const double damped = omega * std::sqrt(std::max(0.0, 1.0 - zeta * zeta));
  return node_records({2, 6, 0, number}) + real_records(std::array{-zeta * omega, damped, 0.0, 0.0, 0.0, 0.0});
}

std::string shape_dataset(const MeasuredShape& shape, long number) {
  const auto rows = static_cast<Index>(shape.nodes.size()), columns = shape.values.cols();
  if (shape.values.rows() != rows || (columns != 3 && columns != 6) || !shape.values.allFinite())
    throw InvalidInput("the shape '" + shape.name + "' has values of " + std::to_string(shape.values.rows()) + " x " +
                           std::to_string(columns) + " for " + std::to_string(rows) +
                           " nodes, or one that is not finite",
                       "finite values of 3 or 6 directions a node are required", "");
  const bool complex = !shape.values.imag().isZero(0.0);
  const int analysis = shape.frequency == 0.0 ? 1 : complex ? 3 : 2;
  std::string content = text_column(shape.name, 80) + "\n";
  for (int line = 2; line <= 5; ++line) content += text_column("", 80) + "\n";
  content += node_records({1, analysis, columns == 3 ? 2 : 3, 8, complex ? 5 : 2, columns}) +
             analysis_records(shape, analysis, number);
  for (Index row = 0; row < rows; ++row) {
    std::vector<double> values;
    for (Index column = 0; column < columns; ++column) {
      values.push_back(shape.values(row, column).real());
      if (complex) values.push_back(shape.values(row, column).imag());
    }
    content += integer_column(shape.nodes[static_cast<std::size_t>(row)], 10) + "\n" + real_records(values);
  }
  return dataset(55, content);
}

/// The descriptor of dataset 2412 of a shape of cells.
int descriptor(CellShape shape) {
  constexpr std::array kinds = {161, 21, 24, 91, 92, 94, 95, 111, 118, 112, 113, 115, 116};
  return kinds[static_cast<std::size_t>(shape)];
}

/// Places of the cell's nodes in the order of dataset 2412; empty: the same order.
std::span<const std::size_t> node_order(CellShape shape) {
  static constexpr std::array<std::size_t, 3> line = {0, 2, 1};
  static constexpr std::array<std::size_t, 6> triangle = {0, 3, 1, 4, 2, 5};
  static constexpr std::array<std::size_t, 8> quadrilateral = {0, 4, 1, 5, 2, 6, 3, 7};
  static constexpr std::array<std::size_t, 10> tetrahedron = {0, 4, 1, 5, 2, 6, 7, 8, 9, 3};
  static constexpr std::array<std::size_t, 15> wedge = {0, 6, 1, 7, 2, 8, 12, 13, 14, 3, 9, 4, 10, 5, 11};
  static constexpr std::array<std::size_t, 20> hexahedron = {0,  8,  1, 9,  2, 10, 3, 11, 16, 17,
                                                             18, 19, 4, 12, 5, 13, 6, 14, 7,  15};
  switch (shape) {
    case CellShape::line3:
      return line;
    case CellShape::triangle6:
      return triangle;
    case CellShape::quadrilateral8:
      return quadrilateral;
    case CellShape::tetrahedron10:
      return tetrahedron;
    case CellShape::wedge15:
      return wedge;
    case CellShape::hexahedron20:
      return hexahedron;
    default:
      return {};
  }
}

}  // namespace

std::string integer_column(long value, int width) {
  std::string digits = std::to_string(value);
  const auto columns = static_cast<std::size_t>(width);
  if (digits.size() > columns)
    throw InvalidInput("the number " + digits, "a universal file has " + std::to_string(width) + " columns for it", "");
  return std::string(columns - digits.size(), ' ') + digits;
}

std::string real_column(double value, int width, int decimals) {
  std::array<char, 64> text{};
  const int size = std::snprintf(text.data(), text.size(), "%*.*E", width, decimals, value);
  if (size > width) std::snprintf(text.data(), text.size(), "%*.*E", width, decimals - (size - width), value);
  return text.data();
}

std::string text_column(const std::string& text, std::size_t width) {
  std::string line = text.empty() ? "NONE" : text;
  std::ranges::replace_if(
      line, [](char c) { return c == '\n' || c == '\r'; }, ' ');
  std::size_t size = 0;
  for (std::size_t next = 0; size < line.size(); size = next) {
    next = size + std::max<std::size_t>(1, utf8_length(line, size));
    if (next > width) break;
  }
  line.resize(std::min(size, line.size()));
  return line + std::string(width - std::min(width, line.size()), ' ');
}

std::string dataset(int number, const std::string& content) {
  return "    -1\n" + integer_column(number, 6) + "\n" + content + "    -1\n";
}

void write_universal(const std::filesystem::path& path, const MeasuredFile& file,
                     const UniversalWriteOptions& options) {
  std::string text = header_dataset(file) + units_dataset();
  if (!file.nodes.empty()) text += nodes_dataset(file.nodes);
  text += elements_dataset(file.lines) + trace_datasets(file.lines);
  for (std::size_t i = 0; i < file.shapes.size(); ++i) text += shape_dataset(file.shapes[i], static_cast<long>(i) + 1);
  for (const auto& channel : file.channels) text += function_dataset(channel, options.binary);
  for (const auto& function : file.functions) text += function_dataset(function, options.binary);
  write_file_atomically(path, text);
}

MeasuredFile geometry_of(const Mesh& mesh) {
  MeasuredFile file{.format = "universal file"};
  for (Index i = 0; i < mesh.node_count(); ++i)
    file.nodes.push_back({.number = static_cast<long>(mesh.node_ids[static_cast<std::size_t>(i)]),
                          .position = {mesh.nodes(0, i), mesh.nodes(1, i), mesh.nodes(2, i)}});
  for (const auto& cell : mesh.cells) {
    const auto own = mesh.nodes_of(cell);
    const auto order = node_order(cell.shape);
    MeasuredLine element{.number = static_cast<long>(cell.id), .kind = descriptor(cell.shape)};
    for (std::size_t i = 0; i < own.size(); ++i)
      element.nodes.push_back(
          static_cast<long>(mesh.node_ids[static_cast<std::size_t>(own[order.empty() ? i : order[i]])]));
    file.lines.push_back(std::move(element));
  }
  return file;
}

}  // namespace kalfem
