// Nastran DMIG entries of a bulk data or punch file, in small, large or free fields:
//   DMIG NAME 0 form type-in type-out polar - columns          the header of a matrix
//   DMIG NAME GJ CJ - G1 C1 A1 B1  G2 C2 A2 B2 ...             one column of it
// Component 0 is a scalar or extra point: a generalised coordinate. Other entries of the file are passed over.

#include <algorithm>
#include <map>

#include "kalfem/formats/matrices/entries.hpp"
#include "kalfem/formats/matrices/readers.hpp"

namespace kalfem {
namespace {

std::string_view without_blanks(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(" \t");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t") - begin + 1);
}

/// One entry with all its continuations, a field an element; the first is the name of the entry.
struct BulkEntry {
  std::vector<std::string> fields;
  int line = 0;
};

/// Data fields of a line: eight small ones or four large ones, without the first and the last field of the line.
std::vector<std::string> data_fields(const std::string& line, bool large) {
  const std::size_t count = large ? 4 : 8;
  std::vector<std::string> fields;
  if (line.find(',') != std::string::npos) {
    for (std::size_t begin = line.find(',') + 1; fields.size() < count;) {
      const std::size_t end = std::min(line.find(',', begin), line.size());
      fields.emplace_back(without_blanks(std::string_view(line).substr(begin, end - begin)));
      if (end == line.size()) break;
      begin = end + 1;
    }
  } else {
    const std::size_t width = large ? 16 : 8;
    for (std::size_t begin = 8; fields.size() < count && begin < line.size(); begin += width)
      fields.emplace_back(without_blanks(std::string_view(line).substr(begin, width)));
  }
  fields.resize(count);
  return fields;
}

/// Tabs stand for blanks up to the next column of eight.
std::string expanded(std::string_view line) {
  std::string text;
  for (const char c : line.substr(0, line.find('$'))) {
    if (c == '\t')
      text.append(8 - text.size() % 8, ' ');
    else
      text += c;
  }
  return text;
}

struct Header {
  int form = 0;
  int line = 0;
};

class DmigReader {
public:
  DmigReader(std::string_view text, const std::string& source) : lines_(text), bytes_(text.size()), source_(source) {}

  std::vector<ForeignMatrix> read() {
    while (const auto line = lines_.next()) take(expanded(*line));
    finish_entry();
    std::vector<ForeignMatrix> matrices;
    for (const auto& name : order_) matrices.push_back(finished(name));
    if (matrices.empty()) refuse(0, "the file holds no DMIG matrix", "a DMIG header and columns are needed");
    return matrices;
  }

private:
  void take(const std::string& line) {
    if (without_blanks(line).empty()) return;
    const std::string first =
        lower_case(without_blanks(std::string_view(line).substr(0, std::min<std::size_t>(line.find(','), 8))));
    const bool large = first.ends_with('*');
    if (const bool continuation = first.empty() || first[0] == '+' || first[0] == '*'; !continuation) {
      finish_entry();
      in_dmig_ = first == "dmig" || first == "dmig*";
      if (in_dmig_) entry_.line = lines_.number();
    }
    if (!in_dmig_) return;
    const auto fields = data_fields(line, large || first.starts_with('*'));
    entry_.fields.insert(entry_.fields.end(), fields.begin(), fields.end());
  }

  void finish_entry() {
    if (!entry_.fields.empty()) interpret();
    entry_ = {};
  }

  [[nodiscard]] const std::string& field(std::size_t i) const {
    static const std::string blank;
    return i < entry_.fields.size() ? entry_.fields[i] : blank;
  }

  void interpret() {
    const std::string& name = field(0);
    if (name.empty()) refuse(entry_.line, "a DMIG entry has no name", "its second field names the matrix");
    if (field(1) == "0") {
      add_header(name);
      return;
    }
    const auto header = headers_.find(name);
    if (header == headers_.end())
      refuse(entry_.line, "a column of matrix '" + name + "' has no header before it",
             "the header says whether the matrix is symmetric", "put 'DMIG, " + name + ", 0, 6, 2, 0' before it");
    add_column(name, header->second.form);
  }

  void add_header(const std::string& name) {
    const std::int64_t form = whole(2, "form"), type = whole(3, "type");
    if (form != 1 && form != 2 && form != 6 && form != 9)
      refuse(entry_.line, "matrix '" + name + "' has form " + std::to_string(form),
             "it is 1 (square), 2 or 9 (rectangular) or 6 (symmetric)");
    if (type == 3 || type == 4)
      refuse(entry_.line, "matrix '" + name + "' is complex", "the structures here are real",
             "write stiffness and damping as real matrices");
    if (type != 1 && type != 2)
      refuse(entry_.line, "matrix '" + name + "' has type " + std::to_string(type), "it is 1 or 2 (real)");
    if (!headers_.try_emplace(name, Header{static_cast<int>(form), entry_.line}).second)
      refuse(entry_.line, "matrix '" + name + "' has a second header", "it is not clear which one counts");
    order_.push_back(name);
    if (form == 1 || form == 6) square_.try_emplace(name, source_, name);
  }

  void add_column(const std::string& name, int form) {
    const bool numbered = form == 9;
    MatrixDof column{whole(1, "column's point"), 0};
    if (!numbered) column = dof(1, 2);
    for (std::size_t i = 4; i < entry_.fields.size(); i += 4) {
      if (field(i).empty() && field(i + 2).empty()) continue;
      const MatrixDof row = dof(i, i + 1);
      const auto value = fortran_number(field(i + 2));
      if (!value)
        refuse(entry_.line, "'" + field(i + 2) + "' in matrix '" + name + "' is no number", "an entry is needed");
      if (!field(i + 3).empty() && fortran_number(field(i + 3)) != 0.0)
        refuse(entry_.line, "an entry of matrix '" + name + "' has an imaginary part", "the structures here are real");
      if (form == 1 || form == 6)
        square_.at(name).add(row, column, *value, entry_.line);
      else
        rectangular_[name].push_back({row, column, *value, entry_.line});
    }
  }

  [[nodiscard]] MatrixDof dof(std::size_t point, std::size_t component) const {
    const std::int64_t number = whole(point, "point");
    const std::int64_t direction = field(component).empty() ? 0 : whole(component, "component");
    if (number < 1 || direction < 0 || direction > 6)
      refuse(
          entry_.line,
          "point " + std::to_string(number) + ", component " + std::to_string(direction) + " is no degree of freedom",
          "points are positive, components 1 ... 6, or 0 for scalar points");
    return {number, static_cast<int>(direction) - 1};
  }

  [[nodiscard]] std::int64_t whole(std::size_t i, const std::string& meaning) const {
    const auto value = whole_number(field(i));
    if (!value) refuse(entry_.line, "'" + field(i) + "' is no " + meaning, "a whole number is needed");
    return *value;
  }

  [[nodiscard]] ForeignMatrix finished(const std::string& name) const {
    const Header header = headers_.at(name);
    if (header.form == 6) return nonempty(square_.at(name).finish(Storage::one_triangle, bytes_), header);
    if (header.form == 1) return nonempty(square_.at(name).finish(Storage::full, bytes_), header);
    return rectangle(name, header);
  }

  /// Rows by degree of freedom; columns in ascending order of their points.
  [[nodiscard]] ForeignMatrix rectangle(const std::string& name, const Header& header) const {
    const auto found = rectangular_.find(name);
    if (found == rectangular_.end()) return nonempty({name, {}, {}, false}, header);
    std::map<MatrixDof, std::int64_t> rows, columns;
    for (const auto& entry : found->second) rows[entry.row], columns[entry.column];
    const auto number = [](auto& places) {
      std::int64_t next = 0;
      for (auto& [dof, place] : places) place = next++;
      return next;
    };
    const std::int64_t height = number(rows), width = number(columns);
    MatrixEntries entries(source_, name, height, width, bytes_, header.line);
    for (const auto& entry : found->second)
      entries.add(rows.at(entry.row), columns.at(entry.column), entry.value, entry.line);
    ForeignMatrix matrix = entries.finish(Storage::full);
    for (const auto& [dof, place] : rows) matrix.dofs.push_back(dof);
    return matrix;
  }

  [[nodiscard]] ForeignMatrix nonempty(ForeignMatrix matrix, const Header& header) const {
    if (matrix.matrix.rows() == 0)
      refuse(header.line, "matrix '" + matrix.name + "' has a header but no columns", "its entries are needed");
    return matrix;
  }

  [[noreturn]] void refuse(int line, std::string what, std::string why, std::string fix = {}) const {
    refuse_matrix(source_, line, std::move(what), std::move(why), std::move(fix));
  }

  struct Entry {
    MatrixDof row, column;
    double value;
    int line;
  };

  LineReader lines_;
  std::size_t bytes_;
  const std::string& source_;
  BulkEntry entry_;
  bool in_dmig_ = false;
  std::map<std::string, Header> headers_;
  std::vector<std::string> order_;
  std::map<std::string, NodalEntries> square_;
  std::map<std::string, std::vector<Entry>> rectangular_;
};

}  // namespace

std::vector<ForeignMatrix> parse_dmig(std::string_view text, const std::string& source) {
  return DmigReader(text, source).read();
}

}  // namespace kalfem
