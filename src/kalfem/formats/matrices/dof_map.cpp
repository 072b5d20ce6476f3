// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/formats/matrices/entries.hpp"
#include "kalfem/formats/matrices/single_formats.hpp"
#include "kalfem/formats/tables/text_table.hpp"
#include "kalfem/formats/text_file.hpp"
#include "kalfem/formats/unpacked_size.hpp"
#include "kalfem/model/finite_element_model.hpp"

namespace kalfem {
namespace {

/// Direction 0 ... 5 of "1" ... "6", "x", "ux", "rz", "rotz"; -1 of "0", "-1", "q"; nothing for other words.
std::optional<int> direction_of(std::string_view word) {
  std::string name = lower_case(word);
  if (const auto number = whole_number(name)) {
    if (*number < -1 || *number > 6) return {};
    return *number < 1 ? -1 : static_cast<int>(*number) - 1;
  }
  if (name == "q") return -1;
  if (name.starts_with("rot")) name = "r" + name.substr(3);
  if (name.size() == 2 && (name[0] == 'u' || name[0] == 't')) name.erase(0, 1);
  const int direction = direction_index(name);
  return direction < 0 ? std::nullopt : std::optional(direction);
}

// A line is "node direction", "node.direction", or with a fixed number of directions just a node. The first line may
// be a header. Rows of generalised coordinates without a number of their own are counted. If all lines are of the
// joined kind, as CalculiX writes them, a repeated one is a copy; otherwise it is an error.
class MapReader {
public:
  MapReader(const std::string& source, const DofMapOptions& options) : problems_(source), options_(options) {}

  std::vector<MatrixDof> read(std::string_view text) {
    bool first = true;
    for (LineReader lines(text); const auto line = lines.next();) {
      const auto content = line->substr(0, std::min(line->find('#'), line->find('%')));
      const auto words = number_words(content);
      if (words.empty()) continue;
      if (!take(words, lines.number()) && !first)
        problems_.add(
            lines.number(), "'" + std::string(trimmed(content)).substr(0, 60) + "' is not a degree of freedom",
            options_.directions > 0 ? "a node number is expected here" : "a node and a direction are expected here",
            options_.directions > 0 ? "" : "write 'node direction', or state how many directions every node has");
      first = false;
    }
    if (problems_.empty() && dofs_.empty())
      problems_.add(0, "the file lists no degrees of freedom", "one per row of the matrix is required");
    joined_ ? number_copies() : report_doubled();
    problems_.raise();
    return std::move(dofs_);
  }

private:
  /// The degrees of freedom of one line; false where it is none (a header line may be so).
  bool take(const std::vector<std::string_view>& words, int line) {
    if (words.size() > (options_.directions > 0 ? 1U : 2U) && whole_number(words[0]))
      return refuse_more(words.size(), line);
    if (options_.directions > 0) {
      const auto node = whole_number(words[0]);
      if (!node || *node < 1) return false;
      for (int direction = 0; direction < options_.directions; ++direction) add({*node, direction}, line);
      return true;
    }
    joined_ = joined_ && words.size() == 1;
    const auto dof = words.size() == 1 ? joined(words[0]) : pair(words[0], words[1]);
    if (dof) add(*dof, line);
    return dof.has_value();
  }

  /// A third column may be anything: a coordinate system, or the row, with the node behind it.
  bool refuse_more(std::size_t count, int line) {
    problems_.add(line, "the line holds " + std::to_string(count) + " values",
                  options_.directions > 0 ? "a node is expected" : "a node and a direction are expected",
                  "remove the other columns");
    return true;
  }

  static std::optional<MatrixDof> pair(std::string_view node, std::string_view direction) {
    const auto number = whole_number(node);
    const auto axis = direction_of(direction);
    if (!number || !axis || *number < (*axis < 0 ? 0 : 1)) return {};
    return MatrixDof{*number, *axis};
  }

  /// "12.3", "n12.x" or "q4".
  static std::optional<MatrixDof> joined(std::string_view word) {
    if (word.starts_with('q') || word.starts_with('Q')) {
      const auto number = whole_number(word.substr(1));
      return number && *number > 0 ? std::optional(MatrixDof{*number, -1}) : std::nullopt;
    }
    if (word.starts_with('n') || word.starts_with('N')) word.remove_prefix(1);
    const std::size_t dot = word.find('.');
    if (dot == std::string_view::npos) return {};
    return pair(word.substr(0, dot), word.substr(dot + 1));
  }

  void add(MatrixDof dof, int line) {
    if (dof.direction < 0 && dof.node == 0) dof.node = ++generalised_;
    dofs_.push_back(dof);
    lines_.push_back(line);
  }

  /// CalculiX gives the nodes across an expanded shell or beam the number of the node that they come from.
  void number_copies() {
    std::map<MatrixDof, int> counts;
    for (const auto& dof : dofs_) ++counts[dof];
    std::map<MatrixDof, int> met;
    for (auto& dof : dofs_)
      if (counts.at(dof) > 1) dof.copy = ++met[MatrixDof(dof)];
  }

  void report_doubled() {
    std::vector<std::pair<MatrixDof, int>> sorted;
    for (std::size_t i = 0; i < dofs_.size(); ++i) sorted.emplace_back(dofs_[i], lines_[i]);
    std::ranges::sort(sorted);
    for (std::size_t i = 1; i < sorted.size(); ++i)
      if (sorted[i].first == sorted[i - 1].first)
        problems_.add(sorted[i].second, "degree of freedom " + to_string(sorted[i].first) + " is listed twice",
                      "it is first in line " + std::to_string(sorted[i - 1].second) + "; every row needs its own");
  }

  FileProblems problems_;
  const DofMapOptions& options_;
  std::vector<MatrixDof> dofs_;
  std::vector<int> lines_;
  std::int64_t generalised_ = 0;
  bool joined_ = true;  ///< every line is "node.direction"
};

}  // namespace

std::vector<MatrixDof> dofs_of_map(const Eigen::Ref<const Eigen::MatrixXd>& map, const std::string& source) {
  std::vector<MatrixDof> dofs;
  std::int64_t generalised = 0;
  for (Eigen::Index i = 0; i < map.rows(); ++i) {
    const double node = map(i, 0), direction = map(i, 1);
    const std::string row = "row " + std::to_string(i + 1) + " of the map of degrees of freedom";
    if (!(std::abs(node) < 9e15 && node == std::floor(node) && node >= 0.0) ||
        !(direction >= 0.0 && direction <= 6.0 && direction == std::floor(direction)))
      refuse_matrix(source, 0, row + " is not a degree of freedom",
                    "a node and a direction 1 ... 6, or 0, are required");
    MatrixDof dof{static_cast<std::int64_t>(node), static_cast<int>(direction) - 1};
    if (dof.direction < 0 && dof.node == 0) dof.node = ++generalised;
    dofs.push_back(dof);
  }
  auto sorted = dofs;
  std::ranges::sort(sorted);
  if (const auto twice = std::ranges::adjacent_find(sorted); twice != sorted.end())
    refuse_matrix(source, 0, "degree of freedom " + to_string(*twice) + " is listed twice in the map",
                  "every row needs its own");
  return dofs;
}

std::vector<MatrixDof> parse_dof_map(std::string_view text, const std::string& source, const DofMapOptions& options) {
  if (options.directions < 0 || options.directions > 6)
    throw InvalidInput("a node has " + std::to_string(options.directions) + " directions", "it must have 1 to 6", {});
  if (is_gzip(text)) {
    const std::string content = uncompressed(text, source, most_unpacked(text.size()));
    if (is_gzip(content))
      refuse_matrix(source, 0, "the file is compressed twice", "one compression is read", "unpack it once (gunzip)");
    return parse_dof_map(content, source, options);
  }
  if (text.starts_with("CDF") || looks_like_hdf5(text)) {
    for (const auto& matrix : parse_matrices(text, source))
      if (!matrix.dofs.empty()) return matrix.dofs;
    refuse_matrix(source, 0, "the file has no map of degrees of freedom",
                  "an array of nodes and directions is required");
  }
  require_short_lines(text, source);
  return MapReader(source, options).read(text);
}

std::vector<MatrixDof> read_dof_map(const std::filesystem::path& path, const DofMapOptions& options) {
  return parse_dof_map(read_content(path), path.string(), options);
}

}  // namespace kalfem
