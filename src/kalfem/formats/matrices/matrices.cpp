// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/matrices.hpp"

#include <algorithm>
#include <array>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/formats/matrices/entries.hpp"
#include "kalfem/formats/matrices/single_formats.hpp"
#include "kalfem/formats/tables/text_table.hpp"
#include "kalfem/formats/text_file.hpp"
#include "kalfem/formats/unpacked_size.hpp"

namespace kalfem {
namespace {

constexpr std::array<std::pair<std::string_view, MatrixFormat>, 10> format_names = {{
    {"automatic", MatrixFormat::automatic},
    {"matrix_market", MatrixFormat::matrix_market},
    {"triplets", MatrixFormat::triplets},
    {"nodal", MatrixFormat::nodal},
    {"dmig", MatrixFormat::dmig},
    {"op4", MatrixFormat::op4},
    {"op2", MatrixFormat::op2},
    {"hdf5", MatrixFormat::hdf5},
    {"netcdf", MatrixFormat::netcdf},
    {"matlab", MatrixFormat::matlab},
}};

bool ends_with_any(const std::string& name, std::initializer_list<const char*> ends) {
  return std::ranges::any_of(ends, [&](const char* end) { return name.ends_with(end); });
}

/// Whether a line of the text is a keyword line that begins so (blanks and case do not count).
bool has_keyword(std::string_view text, std::string_view keyword) {
  LineReader lines(text);
  while (const auto line = lines.next()) {
    if (!line->starts_with('*') || line->starts_with("**")) continue;
    std::string start = lower_case(line->substr(0, 200));
    std::erase_if(start, [](char c) { return c == ' ' || c == '\t'; });
    if (start.starts_with(keyword)) return true;
  }
  return false;
}

// Five numbers in a line are node, direction, node, direction, value; three are row, column, value.
/// The format of a text without a signature: by the end of its name, then by its first line that says something.
MatrixFormat text_format(std::string_view text, const std::string& name) {
  require_short_lines(text, name);
  if (ends_with_any(name, {".op4"}) || looks_like_op4_text(text)) return MatrixFormat::op4;
  if (ends_with_any(name, {".pch", ".dmig", ".bdf", ".nas"})) return MatrixFormat::dmig;
  LineReader lines(text);
  while (const auto line = lines.next()) {
    const auto words = number_words(*line);
    if (words.empty() || words[0].starts_with("**") || words[0].starts_with('#') || words[0].starts_with('%')) continue;
    if (line->starts_with('$') || lower_case(words[0]).starts_with("dmig")) return MatrixFormat::dmig;
    if (line->starts_with('*') || words.size() == 5) return MatrixFormat::nodal;
    if (words.size() == 3 && whole_number(words[0])) return MatrixFormat::triplets;
    break;
  }
  return lower_case(text.substr(0, 1 << 20)).find("\ndmig") != std::string::npos ? MatrixFormat::dmig
                                                                                 : MatrixFormat::automatic;
}

// Signatures come first, as they are certain: HDF5, netCDF ("CDF" and a version byte), MATLAB, Matrix Market, the
// record lengths of OUTPUT2 and OUTPUT4. Text is told by its extension, then by its first line.
MatrixFormat format_of(std::string_view bytes, const std::string& source) {
  const std::string name = lower_case(source);
  if (looks_like_hdf5(bytes)) return MatrixFormat::hdf5;
  if (bytes.starts_with("CDF") && bytes.size() > 3 && bytes[3] < ' ') return MatrixFormat::netcdf;
  if (bytes.starts_with("MATLAB 5.0") || ends_with_any(name, {".mat"})) return MatrixFormat::matlab;
  if (bytes.starts_with('%') && lower_case(bytes.substr(0, 14)).find("%matrixmarket") < 2)
    return MatrixFormat::matrix_market;
  if (looks_like_op2(bytes)) return MatrixFormat::op2;
  if (looks_like_op4_binary(bytes)) return MatrixFormat::op4;
  return text_format(bytes, name);
}

bool is_text(MatrixFormat format, std::string_view bytes) {
  return format == MatrixFormat::matrix_market || format == MatrixFormat::triplets || format == MatrixFormat::nodal ||
         format == MatrixFormat::dmig || (format == MatrixFormat::op4 && !looks_like_op4_binary(bytes));
}

std::vector<ForeignMatrix> parse_as(MatrixFormat format, std::string_view bytes, const std::string& source) {
  if (is_text(format, bytes)) require_short_lines(bytes, source);
  switch (format) {
    case MatrixFormat::matrix_market:
      return parse_matrix_market(bytes, source);
    case MatrixFormat::triplets:
      return parse_triplets(bytes, source);
    case MatrixFormat::nodal:
      return has_keyword(bytes, "*userelement") ? parse_user_element(bytes, source) : parse_nodal(bytes, source);
    case MatrixFormat::dmig:
      return parse_dmig(bytes, source);
    case MatrixFormat::op4:
      return looks_like_op4_binary(bytes) ? parse_op4_binary(bytes, source) : parse_op4_text(bytes, source);
    case MatrixFormat::op2:
      return parse_op2(bytes, source);
    case MatrixFormat::hdf5:
      return parse_hdf5(bytes, source);
    case MatrixFormat::netcdf:
      return parse_netcdf(bytes, source);
    case MatrixFormat::matlab:
      return parse_matlab(bytes, source);
    case MatrixFormat::automatic:
      break;
  }
  refuse_matrix(source, 0, "the format of this file is unknown",
                "supported: Matrix Market, CalculiX, Abaqus, DMIG, OUTPUT4, OUTPUT2, HDF5, netCDF and MATLAB",
                "state the format");
}

// A name is compared exactly first and without regard to case after that.
/// The matrices of the given names, in their order.
std::vector<ForeignMatrix> wanted(std::vector<ForeignMatrix> all, const std::vector<std::string>& names,
                                  const std::string& source) {
  if (names.empty()) return all;
  std::vector<std::string> known;
  for (const auto& matrix : all) known.push_back(matrix.name);
  std::string list;
  for (const auto& name : known) list += (list.empty() ? "" : ", ") + name;
  IssueList issues;
  std::vector<ForeignMatrix> chosen;
  for (const auto& name : names) {
    auto found = std::ranges::find(all, name, &ForeignMatrix::name);
    if (found == all.end())
      found = std::ranges::find_if(
          all, [&](const ForeignMatrix& matrix) { return lower_case(matrix.name) == lower_case(name); });
    if (found == all.end()) {
      issues.add({source, 0}, "there is no matrix '" + name + "'" + did_you_mean(name, known),
                 "the file contains " + list);
      continue;
    }
    chosen.push_back(*found);
    found->notes.clear();
  }
  issues.raise();
  for (const auto& other : all)  // what the file holds beside matrices stands at one of them, which may not be wanted
    chosen.front().notes.insert(chosen.front().notes.end(), other.notes.begin(), other.notes.end());
  return chosen;
}

/// A text whose last line holds numbers and has no end may be cut off inside the last of them. Compressed files tell
/// their length themselves.
void require_last_line_end(std::string_view text, const std::string& source, MatrixFormat given) {
  if (text.empty() || text.ends_with('\n') || is_gzip(text)) return;
  const MatrixFormat format = given == MatrixFormat::automatic ? format_of(text, source) : given;
  if (format != MatrixFormat::matrix_market && format != MatrixFormat::triplets && format != MatrixFormat::nodal &&
      format != MatrixFormat::dmig)
    return;
  const auto last = trimmed(text.substr(text.rfind('\n') + 1));
  if (last.empty() ||
      std::string_view(format == MatrixFormat::dmig ? "$" : "%#*").find(last.front()) != std::string_view::npos ||
      lower_case(last).starts_with("enddata"))
    return;
  refuse_matrix(source, static_cast<int>(std::ranges::count(text, '\n')) + 1,
                "the last line of the file has no line end",
                "the file may be truncated: its last number may lack digits",
                "export the file again, or add a line end if the line is complete");
}

/// CalculiX writes what the rows are into a file of its own beside the matrices.
void attach_neighbouring_map(std::vector<ForeignMatrix>& matrices, const std::filesystem::path& path) {
  auto map = path;
  if (map.extension() == ".gz") map.replace_extension();
  map.replace_extension(".dof");
  std::error_code ignored;
  if (map == path || !std::filesystem::is_regular_file(map, ignored)) return;
  const auto dofs = read_dof_map(map);
  bool fits = false;
  for (auto& matrix : matrices) {
    if (!matrix.dofs.empty() || matrix.matrix.rows() > static_cast<Eigen::Index>(dofs.size())) continue;
    // The last rows may hold no entry.
    const auto n = static_cast<Eigen::Index>(dofs.size());
    if (matrix.matrix.rows() == matrix.matrix.cols()) matrix.matrix.conservativeResize(n, n);
    if (matrix.matrix.rows() != n) continue;
    matrix.dofs = dofs;
    fits = true;
  }
  if (!fits && !matrices.empty())
    matrices.front().notes.push_back("'" + map.filename().string() + "' beside the file lists " +
                                     std::to_string(dofs.size()) +
                                     " degrees of freedom and is not used: no matrix without a list of its own has as "
                                     "many rows");
}

}  // namespace

std::optional<MatrixFormat> matrix_format(std::string_view name) {
  const auto found = std::ranges::find(format_names, name, [](const auto& pair) { return pair.first; });
  return found == format_names.end() ? std::nullopt : std::optional(found->second);
}

std::string name_from(const std::string& source) {
  auto name = std::filesystem::path(source).filename();
  while (name.has_extension() && name.stem() != name) name = name.stem();
  return name.string();
}

std::vector<ForeignMatrix> parse_matrices(std::string_view bytes, const std::string& source,
                                          const MatrixReadOptions& options) {
  if (is_gzip(bytes)) {
    const std::string name = source.ends_with(".gz") ? source.substr(0, source.size() - 3) : source;
    const std::string content = uncompressed(bytes, source, most_unpacked(bytes.size()));
    if (is_gzip(content))
      refuse_matrix(source, 0, "the file is compressed twice", "one compression is read", "unpack it once (gunzip)");
    return parse_matrices(content, name, options);
  }
  if (bytes.empty()) refuse_matrix(source, 0, "the file is empty", "it should contain matrices");
  const MatrixFormat format = options.format == MatrixFormat::automatic ? format_of(bytes, source) : options.format;
  return wanted(parse_as(format, bytes, source), options.names, source);
}

std::vector<ForeignMatrix> read_matrices(const std::filesystem::path& path, const MatrixReadOptions& options) {
  const std::string text = read_content(path);
  require_last_line_end(text, path.string(), options.format);
  auto matrices = parse_matrices(text, path.string(), options);
  attach_neighbouring_map(matrices, path);
  return matrices;
}

}  // namespace kalfem
