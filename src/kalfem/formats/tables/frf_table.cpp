// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/tables/frf_table.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <map>
#include <numbers>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/text.hpp"
#include "kalfem/formats/tables/text_table.hpp"

namespace kalfem {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;

enum class Part { complex, real, imaginary, magnitude, decibel, phase, deviation };

/// The columns that make one FRF, by position.
struct FrfColumns {
  Channel output;
  std::map<Part, std::size_t> parts;
  bool phase_in_radians = false;
};

struct Table {
  std::vector<std::vector<std::string_view>> rows;
  std::vector<int> lines;
  std::vector<Channel> titles;  ///< empty: the file has no header
  int header_line = 0;
  char decimal = '.';
};

/// Place of the sign that parts real and imaginary number: the last one that is neither the first character nor an
/// exponent's.
std::size_t split_place(std::string_view text) {
  for (std::size_t i = text.size(); i-- > 1;)
    if ((text[i] == '+' || text[i] == '-') && text[i - 1] != 'e' && text[i - 1] != 'E') return i;
  return 0;
}

/// "1.2", "1.2+3.4j", "(1.2-3i)", "-4j"; nothing where the cell is no finite number.
std::optional<Complex> parse_complex(std::string_view cell, char decimal) {
  if (cell.size() > 2 && cell.front() == '(' && cell.back() == ')') cell = trimmed(cell.substr(1, cell.size() - 2));
  if (cell.empty()) return std::nullopt;
  const bool has_imaginary = cell.ends_with('j') || cell.ends_with('i');
  const std::size_t split = has_imaginary ? split_place(cell) : cell.size();
  const auto real = split > 0 ? parse_number(cell.substr(0, split), decimal) : 0.0;
  const auto imaginary =
      has_imaginary ? parse_number(cell.substr(split, cell.size() - split - 1), decimal) : std::optional(0.0);
  if (!real || !imaginary || !std::isfinite(*real + *imaginary)) return std::nullopt;
  return Complex(*real, *imaginary);
}

/// The cells of a line, without one that a separator at its end makes.
std::vector<std::string_view> cells_of(const TextLine& line, char separator, std::size_t expected) {
  auto cells = split_cells(line.text, separator);
  if (cells.size() == expected + 1 && cells.back().empty()) cells.pop_back();
  return cells;
}

void check(const FrfTableOptions& options) {
  if (options.separator && std::string_view(";\t, ").find(*options.separator) == std::string_view::npos)
    throw InvalidInput(std::string("the separator is '") + *options.separator + "'",
                       "it must be a semicolon, tab, comma or space", "");
  if (options.decimal && *options.decimal != '.' && (*options.decimal != ',' || options.separator == ','))
    throw InvalidInput(std::string("the decimal sign is '") + *options.decimal + "'",
                       "it must be a point, or a comma if the separator is another", "");
}

/// Cells of all lines; the first line holds names when one of its cells is no number.
Table table_of(const std::vector<TextLine>& lines, const FrfTableOptions& options, FileProblems& problems) {
  const char separator = options.separator.value_or(find_separator(lines));
  Table table;
  table.decimal = options.decimal.value_or(find_decimal(lines, separator));
  auto first = split_cells(lines.front().text, separator);
  if (first.size() > 1 && first.back().empty()) first.pop_back();
  require_columns(first.size(), problems.file(), lines.front().number);
  const bool header = std::ranges::any_of(first, [&](auto cell) { return !parse_complex(cell, table.decimal); });
  if (header) {
    table.header_line = lines.front().number;
    for (const auto cell : first) table.titles.push_back(channel_of(cell));
  }
  for (std::size_t i = header ? 1 : 0; i < lines.size(); ++i) {
    table.rows.push_back(cells_of(lines[i], separator, first.size()));
    table.lines.push_back(lines[i].number);
    if (table.rows.back().size() == first.size()) continue;
    problems.add(lines[i].number,
                 "the line has " + std::to_string(table.rows.back().size()) + " cells, the first line " +
                     std::to_string(first.size()),
                 "every line needs the same number of cells",
                 "correct the line; check the separator and the decimal sign");
  }
  if (table.rows.empty()) problems.add(0, "the file has no lines of numbers", "", "check the path");
  if (first.size() < 2)
    problems.add(lines.front().number, "there is only one column", "an FRF needs a frequency column too");
  return table;
}

Part part_of(FrfColumnContent content) {
  if (content == FrfColumnContent::magnitude) return Part::magnitude;
  return content == FrfColumnContent::decibel ? Part::decibel : Part::complex;
}

// No ending is the end of another one, so their order does not matter.
/// What the end of a column's name says, and the name without it.
std::pair<Part, std::string> part_of(const std::string& name, FrfColumnContent content) {
  constexpr std::array<std::pair<std::string_view, Part>, 13> endings = {{{"_re", Part::real},
                                                                          {"_real", Part::real},
                                                                          {"_im", Part::imaginary},
                                                                          {"_imag", Part::imaginary},
                                                                          {"_magnitude", Part::magnitude},
                                                                          {"_mag", Part::magnitude},
                                                                          {"_abs", Part::magnitude},
                                                                          {"_db", Part::decibel},
                                                                          {"_phase", Part::phase},
                                                                          {"_phase_deg", Part::phase},
                                                                          {"_phase_rad", Part::phase},
                                                                          {"_deviation", Part::deviation},
                                                                          {"_std", Part::deviation}}};
  const std::string lower = lower_case(name);
  for (const auto& [ending, part] : endings)
    if (lower.size() > ending.size() && lower.ends_with(ending))
      return {part, name.substr(0, name.size() - ending.size())};
  return {part_of(content), name};
}

bool phase_in_radians(const std::string& title, const std::string& unit, int line, FileProblems& problems) {
  const std::string lower = lower_case(unit);
  if (lower == "rad" || (unit.empty() && lower_case(title).ends_with("_rad"))) return true;
  if (!(lower.empty() || lower == "deg" || lower == "°" || lower == "degrees"))
    problems.add(line, "the phase '" + title + "' is in '" + unit + "'", "deg and rad are supported");
  return false;
}

void set_unit(FrfColumns& frf, const std::string& unit, int line, FileProblems& problems) {
  if (!frf.output.unit.empty() && frf.output.unit != unit)
    problems.add(line,
                 "the columns of '" + frf.output.name + "' are in '" + frf.output.unit + "' and in '" + unit + "'",
                 "they are parts of the same complex number", "write the same unit for both");
  frf.output.unit = unit;
}

// Columns of one FRF share a name and differ in its ending: _re and _im, _mag or _db and _phase, _std. They are
// gathered by that name in any order; check_parts() then asks that they make exactly one complex number.
/// The FRFs that the columns make up, in the order of their first columns.
std::vector<FrfColumns> frfs_of(const Table& table, std::size_t frequency, FrfColumnContent content,
                                FileProblems& problems) {
  std::vector<FrfColumns> frfs;
  for (std::size_t i = 0; i < table.titles.size(); ++i) {
    if (i == frequency) continue;
    const std::string &title = table.titles[i].name, &unit = table.titles[i].unit;
    auto [part, name] = part_of(title, content);
    const bool decibels = lower_case(unit) == "db";
    if (decibels && part == Part::deviation)
      problems.add(table.header_line, "the deviation '" + title + "' is in dB", "it must be in the unit of the value",
                   "give it in the unit of the values");
    if (decibels && (part == Part::magnitude || part == Part::complex)) part = Part::decibel;
    auto frf = std::ranges::find_if(frfs, [&](const FrfColumns& other) { return other.output.name == name; });
    if (frf == frfs.end()) frf = frfs.insert(frfs.end(), FrfColumns{{name, ""}, {}});
    if (!frf->parts.emplace(part, i).second)
      problems.add(table.header_line, "there are two columns like '" + title + "'", "names must be unique",
                   "rename one of them");
    if (part == Part::phase)
      frf->phase_in_radians = phase_in_radians(title, unit, table.header_line, problems);
    else if (!unit.empty() && !decibels)
      set_unit(*frf, unit, table.header_line, problems);
  }
  return frfs;
}

/// Without a header: columns H1, H2, ...
std::vector<FrfColumns> unnamed_frfs(const Table& table, FrfColumnContent content, FileProblems& problems) {
  std::vector<FrfColumns> frfs;
  const auto& first = table.rows.front();
  for (std::size_t i = 1; i < first.size(); ++i)
    frfs.push_back({{"H" + std::to_string(i), ""}, {{part_of(content), i}}});
  if (content != FrfColumnContent::complex) return frfs;
  const bool any_complex = std::ranges::any_of(first.begin() + 1, first.end(), [](std::string_view cell) {
    return cell.find_first_of("ij") != std::string_view::npos;
  });
  if (!any_complex)
    problems.add(table.lines.front(), "the columns are real and have no names",
                 "they could be real parts, magnitudes or phases",
                 "write a first line such as frequency_hz, H1_re, H1_im or frequency_hz, H1_mag, H1_phase; if they are "
                 "magnitudes or dB, set `values`");
  return frfs;
}

// Exactly one of the forms complex, real and imaginary, magnitude, decibel must be there; a phase needs one of the
// last two.
void check_parts(const FrfColumns& frf, int line, FileProblems& problems) {
  const auto has = [&](Part part) { return frf.parts.contains(part); };
  const int ways =
      has(Part::complex) + (has(Part::real) || has(Part::imaginary)) + has(Part::magnitude) + has(Part::decibel);
  if (has(Part::real) != has(Part::imaginary))
    problems.add(line, "'" + frf.output.name + "' has only one of the columns _re and _im", "both parts are required");
  else if (ways != 1)
    problems.add(line, "'" + frf.output.name + "' is given in " + (ways == 0 ? "no form" : "more than one form"),
                 "an FRF is one complex column, or _re and _im, or _mag (or _db) and _phase", "add or remove columns");
  else if (has(Part::phase) && !has(Part::magnitude) && !has(Part::decibel))
    problems.add(line, "'" + frf.output.name + "' has a phase without a magnitude", "", "remove the phase");
}

void select(std::vector<FrfColumns>& frfs, const std::vector<std::string>& wanted, FileProblems& problems) {
  if (wanted.empty()) return;
  std::vector<Channel> outputs;
  std::vector<std::string> known;
  for (const auto& frf : frfs) {
    outputs.push_back(frf.output);
    known.push_back(frf.output.name);
  }
  std::vector<FrfColumns> selected;
  for (const auto& name : wanted) {
    const auto found = find_channel(outputs, name);
    if (found < 0)
      problems.add(0, "there is no FRF '" + name + "'" + did_you_mean(name, known));
    else
      selected.push_back(frfs[std::size_t(found)]);
  }
  frfs = std::move(selected);
}

/// The numbers of the cells, with the problems of those that are none.
class TableCells {
public:
  TableCells(const Table& table, FileProblems& problems) : table_(table), problems_(problems) {}

  [[nodiscard]] Complex complex(std::size_t row, std::size_t column) const {
    const std::string_view cell = table_.rows[row][column];
    if (const auto number = parse_complex(cell, table_.decimal)) return *number;
    add(row, column, cell.empty() ? "is empty" : "holds '" + std::string(cell.substr(0, 40)) + "'",
        "every value must be a finite number");
    return 0.0;
  }

  [[nodiscard]] double real(std::size_t row, std::size_t column) const {
    const Complex number = complex(row, column);
    if (number.imag() != 0.0) add(row, column, "has a complex number", "the column is real elsewhere");
    return number.real();
  }

  [[nodiscard]] double not_negative(std::size_t row, std::size_t column, const std::string& quantity) const {
    const double number = real(row, column);
    if (number < 0.0) add(row, column, "is negative", "a " + quantity + " is not");
    return number;
  }

private:
  void add(std::size_t row, std::size_t column, const std::string& what, const std::string& why) const {
    const std::string name =
        table_.titles.empty() ? std::to_string(column + 1) : "'" + table_.titles[column].name + "'";
    problems_.add(table_.lines[row], "column " + name + " " + what, why);
  }

  const Table& table_;
  FileProblems& problems_;
};

// Decibels are 20 log10 |H|. Without a phase the magnitude stands as a real number, and the table is marked so.
Complex value_of(const TableCells& cells, const FrfColumns& frf, std::size_t row) {
  const auto& parts = frf.parts;
  if (parts.contains(Part::complex)) return cells.complex(row, parts.at(Part::complex));
  if (parts.contains(Part::real))
    return {cells.real(row, parts.at(Part::real)), cells.real(row, parts.at(Part::imaginary))};
  const double magnitude = parts.contains(Part::decibel)
                               ? std::pow(10.0, cells.real(row, parts.at(Part::decibel)) / 20.0)
                               : cells.not_negative(row, parts.at(Part::magnitude), "magnitude");
  if (!parts.contains(Part::phase)) return magnitude;
  const double phase = cells.real(row, parts.at(Part::phase));
  return std::polar(magnitude, frf.phase_in_radians ? phase : phase * std::numbers::pi / 180.0);
}

bool is_magnitude_only(const FrfColumns& frf) {
  return !frf.parts.contains(Part::phase) && (frf.parts.contains(Part::magnitude) || frf.parts.contains(Part::decibel));
}

/// Position of the frequencies and the factor that makes them Hz.
std::pair<std::size_t, double> frequency_of(const Table& table, const std::string& asked, FileProblems& problems) {
  std::vector<std::string> names;
  for (const auto& title : table.titles) names.push_back(title.name);
  const Index found = asked.empty() ? 0 : find_channel(table.titles, asked);
  if (found < 0) problems.add(0, "there is no column '" + asked + "'" + did_you_mean(asked, names));
  if (found < 0 || table.titles.empty()) return {0, 1.0};
  const auto column = std::size_t(found);
  const std::string unit = lower_case(table.titles[column].unit);
  if (unit == "khz") return {column, 1000.0};
  if (unit == "rad/s") return {column, 0.5 / std::numbers::pi};
  if (!unit.empty() && unit != "hz")
    problems.add(table.header_line, "the frequencies are in '" + unit + "'", "Hz, kHz and rad/s are supported");
  return {column, 1.0};
}

Eigen::VectorXd read_lines(const TableCells& cells, const Table& table, std::size_t column, double unit,
                           FileProblems& problems) {
  Eigen::VectorXd lines(Index(table.rows.size()));
  for (Index k = 0; k < lines.size(); ++k) {
    const auto row = std::size_t(k);
    lines[k] = unit * cells.not_negative(row, column, "frequency");
    if (k > 0 && !(lines[k] > lines[k - 1]))
      problems.add(table.lines[row], "the frequency does not exceed the previous one",
                   "frequencies must be in ascending order", "sort the lines and keep one line per frequency");
  }
  return lines;
}

void check_phases(const std::vector<FrfColumns>& frfs, int line, FileProblems& problems) {
  const auto without = std::ranges::count_if(frfs, is_magnitude_only);
  if (without != 0 && std::size_t(without) != frfs.size())
    problems.add(line, std::to_string(without) + " of the FRFs have no phase",
                 "a table must hold either magnitudes only or complex FRFs only", "read them separately, by `outputs`");
}

}  // namespace

// Steps: cells of all lines; which columns belong to which FRF; checks of the columns; frequencies; values. Problems
// are raised after each stage that later ones rest on, so one run tells many of them. Deviations are used only if
// every FRF has them.
FrequencyResponse read_frf_table(const std::filesystem::path& path, const FrfTableOptions& options) {
  check(options);
  FileProblems problems(path.string());
  const std::string text = read_text(path);
  const auto content = content_lines(text);
  if (content.empty()) throw InvalidInput(Issue{{path.string(), 0}, "the file has no data", "", "check the path"});
  const Table table = table_of(content, options, problems);
  problems.raise();
  const auto [frequency, unit] = frequency_of(table, options.frequency_column, problems);
  auto frfs = table.titles.empty() ? unnamed_frfs(table, options.content, problems)
                                   : frfs_of(table, frequency, options.content, problems);
  select(frfs, options.outputs, problems);
  for (const auto& frf : frfs) check_parts(frf, table.header_line, problems);
  check_phases(frfs, table.header_line, problems);
  problems.raise();

  const TableCells cells(table, problems);
  FrequencyResponse response;
  response.lines = read_lines(cells, table, frequency, unit, problems);
  const Index rows = response.lines.size(), columns = Index(frfs.size());
  response.values.resize(rows, columns);
  response.magnitudes_only = is_magnitude_only(frfs.front());
  const bool deviations =
      std::ranges::all_of(frfs, [](const auto& frf) { return frf.parts.contains(Part::deviation); });
  if (deviations) response.deviations.resize(rows, columns);
  for (Index j = 0; j < columns; ++j) {
    const FrfColumns& frf = frfs[std::size_t(j)];
    response.outputs.push_back(frf.output);
    for (Index k = 0; k < rows; ++k) {
      response.values(k, j) = value_of(cells, frf, std::size_t(k));
      if (deviations)
        response.deviations(k, j) = cells.not_negative(std::size_t(k), frf.parts.at(Part::deviation), "deviation");
    }
  }
  problems.raise();
  return response;
}

}  // namespace kalfem
