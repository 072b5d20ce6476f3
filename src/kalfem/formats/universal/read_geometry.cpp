// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>

#include "kalfem/base/text.hpp"
#include "kalfem/formats/universal/dataset_readers.hpp"
#include "kalfem/formats/universal/fields.hpp"

namespace kalfem {
namespace {

constexpr std::array wide_columns = {25};
constexpr std::array unit_columns = {25};
constexpr std::array narrow_columns = {13};
constexpr std::size_t integer_columns = 10;
constexpr double absolute_zero = 273.15;

/// The whole numbers of a line, at least so many.
std::vector<long> integers(UniversalReading& reading, const std::string& line, std::size_t least, const char* what) {
  auto values = integers_of(line, integer_columns);
  if (!values)
    throw reading.source.problem(std::string(what) + ": '" + line.substr(0, 40) + "' holds no whole numbers",
                                 "the format asks for columns of 10", "export the file again");
  if (values->size() < least) values->resize(least, 0);
  return *values;
}

/// Exactly so many numbers of a line.
std::vector<double> numbers(UniversalReading& reading, std::string_view line, std::span<const int> widths,
                            std::size_t count, const char* what) {
  std::vector<double> values;
  const std::string odd = append_numbers(line, widths, values);
  if (!odd.empty())
    throw reading.source.problem(std::string(what) + ": '" + odd + "' is not a number", "", "export the file again");
  if (values.size() < count)
    throw reading.source.problem(std::string(what) + ": the line has " + std::to_string(values.size()) + " numbers",
                                 std::to_string(count) + " are required", "export the file again");
  return values;
}

/// A node with its coordinates in metres. Its numbers: label, axes of its definition, axes of its motions.
void add_node(UniversalReading& reading, const std::vector<long>& labels, std::span<const double> place) {
  MeasuredNode node{.number = labels[0]};
  for (std::size_t i = 0; i < 3; ++i) {
    node.position[i] = place[i] / reading.units.length;
    if (!std::isfinite(node.position[i]))
      throw reading.source.problem("node " + std::to_string(labels[0]) + " has a coordinate that is no number");
  }
  reading.local_axes = reading.local_axes || labels[1] > 1 || labels[2] > 1;
  reading.file.nodes.push_back(node);
}

bool is_beam(long kind) { return kind == 11 || (kind >= 21 && kind <= 24); }

bool is_none(std::string_view text) { return text.empty() || text == "NONE" || text == "none" || text == "Unknown"; }

}  // namespace

void read_header(UniversalReading& reading) {
  for (int record = 1; const std::string* line = reading.next_line(); ++record) {
    const std::string text = to_utf8(columns(*line, 0, 80));
    if (record > 3 && record != 6) continue;  // dates and numbers of versions
    if (!is_none(text)) reading.file.description += (reading.file.description.empty() ? "" : "; ") + text;
  }
}

// The factors stand on the second line, three or four of them, the offset of temperatures in some files on a third one.
void read_units(UniversalReading& reading) {
  reading.line("the code of the units");
  std::vector<double> factors;
  while (const std::string* line = reading.next_line())
    for (const double factor : numbers(reading, *line, unit_columns, 0, "units")) factors.push_back(factor);
  if (factors.size() < 3)
    throw reading.source.problem("dataset 164 has " + std::to_string(factors.size()) + " factors of units",
                                 "those of length, force and temperature are required", "export the file again");
  for (std::size_t i = 0; i < 3; ++i)
    if (!(factors[i] > 0.0))
      throw reading.source.problem("dataset 164 has a factor of units that is not positive",
                                   "numbers are divided by it", "export the file again");
  reading.units = {factors[0], factors[1], factors[2]};
  if (factors.size() > 3 && std::abs(std::abs(factors[3]) - absolute_zero) > 1.0 && factors[3] != 0.0)
    reading.file.skipped.push_back("line " + std::to_string(reading.begin) +
                                   ": the offset of temperatures of dataset 164 is not used");
}

void read_nodes_15(UniversalReading& reading) {
  while (const std::string* line = reading.next_line()) {
    const std::string text = *line;
    if (words_of(text).empty()) continue;
    constexpr std::size_t labels = 4 * integer_columns;
    const auto words = words_of(text);
    if (words.size() == 7) {  // the usual case, whatever the columns
      std::vector<double> values = numbers(reading, text, narrow_columns, 7, "node");
      add_node(reading, {std::lround(values[0]), std::lround(values[1]), std::lround(values[2])},
               std::span(values).subspan(4));
      continue;
    }
    const auto label = integers(reading, text.substr(0, labels), 4, "node");
    const auto place = numbers(reading, std::string_view(text).substr(std::min(labels, text.size())), narrow_columns, 3,
                               "coordinates");
    add_node(reading, label, place);
  }
}

void read_nodes_2411(UniversalReading& reading) {
  while (const std::string* line = reading.next_line()) {
    if (words_of(*line).empty()) continue;
    const auto label = integers(reading, *line, 4, "node");
    const std::string place = reading.line("the coordinates of node " + std::to_string(label[0]));
    add_node(reading, label, numbers(reading, place, wide_columns, 3, "coordinates"));
  }
}

void read_elements(UniversalReading& reading) {
  while (const std::string* line = reading.next_line()) {
    if (words_of(*line).empty()) continue;
    const auto head = integers(reading, *line, 6, "element");
    MeasuredLine element{.number = head[0], .kind = static_cast<int>(head[1])};
    const std::string name = "element " + std::to_string(head[0]);
    const bool plausible = head.size() == 6 && head[5] > 0 && head[5] <= 100000;
    if (!plausible) throw reading.source.problem(name + " has no number of nodes", "", "export the file again");
    if (is_beam(head[1])) reading.line("the orientation of " + name);
    const auto count = static_cast<std::size_t>(head[5]);
    while (element.nodes.size() < count) {
      const std::string nodes = reading.line("the nodes of " + name);
      const auto more = integers(reading, nodes, 1, "nodes");
      element.nodes.insert(element.nodes.end(), more.begin(), more.end());
    }
    if (element.nodes.size() > count)
      throw reading.source.problem(name + " declares " + std::to_string(count) + " nodes and has " +
                                   std::to_string(element.nodes.size()));
    reading.file.lines.push_back(std::move(element));
  }
}

// A zero lifts the pen: each stroke becomes a line. Lines are filled up with zeros.
void read_trace_line(UniversalReading& reading) {
  const auto head = integers(reading, reading.line("the number of the trace line"), 3, "trace line");
  const std::string name = to_utf8(columns(reading.line("the name of the trace line"), 0, 80));
  std::vector<long> nodes;
  while (const std::string* line = reading.next_line()) {
    const auto more = integers(reading, *line, 0, "nodes");
    nodes.insert(nodes.end(), more.begin(), more.end());
  }
  const auto count = static_cast<std::size_t>(std::max(0L, head[1]));
  if (nodes.size() < count)
    throw reading.source.problem("trace line " + std::to_string(head[0]) + " declares " + std::to_string(count) +
                                     " entries, the dataset has " + std::to_string(nodes.size()),
                                 "the file is truncated", "export it again");
  nodes.resize(count);
  nodes.push_back(0);
  MeasuredLine stroke{.number = head[0], .name = name};
  for (const long node : nodes) {
    if (node != 0) stroke.nodes.push_back(node);
    if (node != 0 || stroke.nodes.empty()) continue;
    reading.file.lines.push_back(stroke);
    stroke.nodes.clear();
  }
}

}  // namespace kalfem
