// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/gmsh/gmsh.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <map>

#include "kalfem/base/text.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/formats/tables/text_table.hpp"

namespace kalfem {
namespace {

using Titles = std::vector<std::string>;

/// A column by the titles that mean it, the usual one first.
struct Column {
  Titles titles;
  std::optional<std::size_t> place = {};
  double unit = 0.0;  ///< to SI; 0: the title names none
};

/// One of the columns as a title names it: "x [mm]", "x (mm)" and "x_mm" are x and mm.
struct Title {
  std::string name, unit;
};

Title without_brackets(const std::string& text) {
  for (const auto& [open, close] : {std::pair{'[', ']'}, {'(', ')'}})
    if (const auto begin = text.find(open); begin != std::string::npos && begin > 0 && text.ends_with(close))
      return {lower_case(trimmed(std::string_view(text).substr(0, begin))),
              text.substr(begin + 1, text.size() - begin - 2)};
  return {lower_case(text), ""};
}

bool is_coordinate(const std::string& name) { return name == "x" || name == "y" || name == "z"; }

Title title_of(const std::string& text) {
  Title title = without_brackets(text);
  const auto bar = title.name.find('_');
  if (bar != std::string::npos && is_coordinate(title.name.substr(0, bar)))
    title = {title.name.substr(0, bar), text.substr(bar + 1)};
  return title;
}

/// The lines of a file as rows of the wanted columns.
class MeshTable {
public:
  MeshTable(const std::filesystem::path& path, std::vector<Column> columns)
      : problems(path.string()), columns_(std::move(columns)), text_(read_text(path)), lines_(split_lines(text_)) {
    std::erase_if(lines_, [](const TextLine& line) {
      const auto content = trimmed(line.text);
      return content.empty() || content.front() == '#' || content.front() == '%';
    });
    if (!lines_.empty()) {
      separator_ = find_separator();
      place_columns();
    }
    if (lines_.empty()) problems.add(0, "the file has no data", "", "check the path");
    problems.raise();
  }

  /// Calls `visit` with each line's number and the wanted cells.
  template <class Visit>
  void for_each_row(const Visit& visit) {
    const auto furthest = std::ranges::max(columns_, {}, &Column::place).place.value();
    std::vector<std::string_view> wanted(columns_.size());
    for (const auto& line : lines_) {
      const auto cells = split_cells(line.text, separator_);
      if (cells.size() <= furthest) {
        problems.add(line.number, "the line has " + std::to_string(cells.size()) + " cells",
                     "column " + std::to_string(furthest + 1) + " is needed", "complete the line");
        continue;
      }
      for (std::size_t i = 0; i < columns_.size(); ++i) wanted[i] = cells[*columns_[i].place];
      visit(line.number, wanted);
    }
  }

  /// A positive whole number; nothing, and a problem, where the cell holds none.
  std::optional<std::int64_t> whole(int line, std::string_view cell, const std::string& what) {
    const auto value = number_in(cell);
    constexpr double largest = 9e15;  // whole numbers are exact in a double up to here
    if (value && *value >= 1.0 && *value <= largest && *value == std::floor(*value))
      return static_cast<std::int64_t>(*value);
    problems.add(line, what + " '" + std::string(cell.substr(0, 40)) + "' is not a number of one",
                 "nodes and elements are numbered 1, 2, ...", "give a whole number");
    return std::nullopt;
  }

  /// A decimal comma is one where the cells are separated otherwise.
  [[nodiscard]] std::optional<double> number_in(std::string_view cell) const {
    auto value = parse_number(cell, '.');
    if (!value && separator_ != ',') value = parse_number(cell, ',');
    return value && std::isfinite(*value) ? value : std::nullopt;
  }

  /// Tells the columns that are not read.
  void tell(const TableMeshOptions& options, const std::string& consequence) const {
    if (options.notes == nullptr) return;
    for (auto note : unused_) {
      note.consequence = consequence;
      options.notes->push_back(std::move(note));
    }
  }

  [[nodiscard]] const Column& column(std::size_t i) const { return columns_[i]; }

  FileProblems problems;

private:
  // The second line is taken, since titles in the first may hold blanks or commas in brackets. Candidates are tried
  // from the least ambiguous one on: a comma may be decimal and blanks may surround other separators.
  [[nodiscard]] char find_separator() const {
    const auto line = trimmed(lines_[std::min<std::size_t>(1, lines_.size() - 1)].text);
    for (const char candidate : {';', '\t', ',', ' '})
      if (line.find(candidate) != std::string_view::npos) return candidate;
    return ',';
  }

  /// By the titles of the first line, or in order where that is data.
  void place_columns() {
    const auto cells = split_cells(lines_.front().text, separator_);
    if (number_in(cells.front())) {
      for (std::size_t i = 0; i < columns_.size(); ++i) columns_[i].place = i;
      return;
    }
    Titles unknown;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const auto title = title_of(std::string(cells[i]));
      const auto meant = std::ranges::find_if(columns_, [&](const Column& column) {
        return std::ranges::find(column.titles, title.name) != column.titles.end();
      });
      if (meant != columns_.end())
        place_column(*meant, i, title);
      else
        unknown.push_back(title.name);
    }
    for (const auto& name : unknown)
      unused_.push_back({{problems.file(), lines_.front().number}, "column '" + name + "'", "", 1});
    for (const auto& column : columns_)
      if (!column.place)
        problems.add(
            lines_.front().number,
            "there is no column '" + column.titles.front() + "'" + did_you_mean(column.titles.front(), unknown), "",
            "name the columns in the first line");
    lines_.erase(lines_.begin());
  }

  void place_column(Column& column, std::size_t place, const Title& title) {
    const int line = lines_.front().number;
    if (column.place)
      problems.add(line, "two columns are named '" + title.name + "'", "names must differ", "rename one of them");
    column.place = place;
    if (title.unit.empty() || !is_coordinate(title.name)) return;
    try {
      column.unit = to_si("1 " + title.unit, "m");
    } catch (const InvalidInput&) {
      problems.add(line, "the column '" + title.name + "' is in '" + title.unit + "'", "a coordinate must be a length",
                   "write m, mm, ...");
    }
  }

  std::vector<Column> columns_;
  std::vector<DeckNote> unused_;
  std::string text_;
  std::vector<TextLine> lines_;
  char separator_ = ',';
};

/// Adds a number and the line that has it; a problem where another line had it before.
void add_once(std::map<std::int64_t, int>& seen, std::int64_t number, int line, const std::string& kind,
              FileProblems& problems) {
  const auto [first, is_new] = seen.try_emplace(number, line);
  if (!is_new)
    problems.add(line, kind + " " + std::to_string(number) + " is defined twice",
                 "line " + std::to_string(first->second) + " already defines it", "renumber one of them");
}

/// Metres per number of the column.
double metres(const Column& column, const TableMeshOptions& options, FileProblems& problems) {
  if (column.unit == 0.0) return options.scale.value_or(1.0);
  if (options.scale)
    problems.add(0, "the column '" + column.titles.front() + "' states its unit, and a scale is given too",
                 "only one of them can apply", "remove the scale");
  return column.unit;
}

void read_nodes(const std::filesystem::path& path, const TableMeshOptions& options, Mesh& mesh) {
  MeshTable table(path, {{{"node", "id", "node_id", "number", "point"}}, {{"x"}}, {{"y"}}, {{"z"}}});
  Eigen::Vector3d scale;
  for (std::size_t i = 0; i < 3; ++i)
    scale[static_cast<Eigen::Index>(i)] = metres(table.column(i + 1), options, table.problems);
  table.problems.raise();
  std::map<std::int64_t, int> seen;
  std::vector<double> places;
  table.for_each_row([&](int line, const std::vector<std::string_view>& cells) {
    const auto id = table.whole(line, cells[0], "node");
    if (id) add_once(seen, *id, line, "node", table.problems);
    mesh.node_ids.push_back(id.value_or(0));
    for (std::size_t i = 0; i < 3; ++i) {
      const auto value = table.number_in(cells[i + 1]);
      if (!value)
        table.problems.add(line, std::string(1, "xyz"[i]) + " is '" + std::string(cells[i + 1].substr(0, 40)) + "'",
                           "a coordinate must be a finite number", "");
      places.push_back(value.value_or(0.0) * scale[static_cast<Eigen::Index>(i)]);
    }
  });
  table.problems.raise();
  table.tell(options, "of the nodes, number, x, y and z are used");
  mesh.nodes = Eigen::Map<const Eigen::Matrix3Xd>(places.data(), 3, static_cast<Eigen::Index>(mesh.node_ids.size()));
}

// Two-node lines for beams: each row is a number, two nodes and a region. A region given as a number, even as 1.0, is
// named by its digits.
class ElementReader {
public:
  ElementReader(const std::filesystem::path& path, Mesh& mesh)
      : table_(path, {{{"element", "elem", "id", "element_id", "number"}},
                      {{"node1", "node_1", "n1", "from", "first"}},
                      {{"node2", "node_2", "n2", "to", "second"}},
                      {{"region", "section", "group", "property", "part"}}}),
        mesh_(mesh),
        finder_(mesh) {}

  void read(const TableMeshOptions& options) {
    table_.for_each_row([&](int line, const std::vector<std::string_view>& cells) { add(line, cells); });
    table_.problems.raise();
    table_.tell(options, "of the elements, number, two nodes and region are used");
  }

private:
  void add(int line, const std::vector<std::string_view>& cells) {
    const auto id = table_.whole(line, cells[0], "element");
    if (id) add_once(seen_, *id, line, "element", table_.problems);
    const std::array ends = {find_node(line, cells[1]), find_node(line, cells[2])};
    const std::string region = region_name(line, cells[3]);
    if (ends[0] < 0 || ends[1] < 0) return;
    const Eigen::Matrix3Xd& nodes = mesh_.nodes;
    const double length = (nodes.col(ends[0]) - nodes.col(ends[1])).norm();
    // Nodes nearer than rounding of their coordinates leave the element without a direction.
    if (!(length > 1e-12 * nodes.cwiseAbs().maxCoeff()))
      table_.problems.add(line, "element " + std::string(cells[0]) + " has the length 0",
                          "its two nodes are at the same place", "connect other nodes or remove it");
    mesh_.regions[region].push_back(mesh_.add_cell(CellShape::line2, id.value_or(0), ends));
  }

  Eigen::Index find_node(int line, std::string_view cell) {
    const auto id = table_.whole(line, cell, "node");
    if (!id) return -1;
    const auto index = finder_.find(*id);
    if (index < 0)
      table_.problems.add(line, "there is no node " + std::to_string(*id),
                          "an element must connect two nodes of the table", "add it to the nodes or name another one");
    return index;
  }

  std::string region_name(int line, std::string_view cell) {
    const auto number = table_.number_in(cell);
    if (number && *number >= 0.0 && *number < 1e15 && *number == std::floor(*number))
      return std::to_string(static_cast<std::int64_t>(*number));
    const auto fits = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '-'; };
    std::string name(cell);
    if (name.empty() || !std::ranges::all_of(name, fits))
      table_.problems.add(line, "the region is '" + name.substr(0, 40) + "'", "its name is used in case files",
                          "use letters, digits, _ and -");
    return name;
  }

  MeshTable table_;
  Mesh& mesh_;
  NodeFinder finder_;
  std::map<std::int64_t, int> seen_;
};

}  // namespace

Mesh read_table_mesh(const std::filesystem::path& nodes, const std::filesystem::path& elements,
                     const TableMeshOptions& options) {
  Mesh mesh;
  mesh.source = elements.string();
  read_nodes(nodes, options, mesh);
  ElementReader(elements, mesh).read(options);
  return mesh;
}

}  // namespace kalfem
