// SPDX-License-Identifier: Apache-2.0
// Matrices in HDF5 files: datasets of two dimensions; groups of triplets (rows, cols, values) or of compressed rows or
// columns (data, indices, indptr, shape; jc and ir of MATLAB 7.3). MATLAB's full matrices stand column by column.

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/formats/hdf5/hdf5_file.hpp"
#include "kalfem/formats/matrices/entries.hpp"
#include "kalfem/formats/matrices/single_formats.hpp"
#include "kalfem/formats/unpacked_size.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Names = std::vector<std::string>;

/// Deflate shrinks by at most 1032; a dataset that claims more was never written.
constexpr double most_compression = 1100.0;
constexpr Index small_dataset = 1 << 16;

// Two passes over the datasets. First each group is tried as a sparse matrix, by the usual names of its members; then
// every dataset of two dimensions that no sparse matrix used is a dense one. A map of degrees of freedom is attached
// to all matrices of its length.
class Hdf5Reader {
public:
  Hdf5Reader(std::string_view bytes, const std::string& source)
      : file_(Hdf5File::open_bytes(bytes, source)), source_(source), bytes_(bytes.size()), names_(file_.datasets()) {
    for (const auto& name : names_) {
      const std::size_t slash = name.find_last_of('/');
      groups_[name.substr(0, slash)].insert(lower_case(name.substr(slash + 1)));
    }
  }

  std::vector<ForeignMatrix> read() {
    std::vector<ForeignMatrix> matrices;
    std::set<std::string> used;
    for (const auto& [group, members] : groups_) {
      asked_.clear();
      if (auto matrix = sparse(group)) {
        matrices.push_back(std::move(*matrix));
        used.insert(asked_.begin(), asked_.end());
      }
    }
    for (const auto& name : names_) {
      if (used.contains(name) || is_map(name)) continue;
      if (file_.holds_numbers(name) && file_.shape(name).size() == 2)
        matrices.push_back(dense(name));
      else
        others_.push_back(plain(name));
    }
    std::erase_if(matrices, [&](const ForeignMatrix& matrix) {
      if (matrix.matrix.size() == 0) others_.push_back(matrix.name);
      return matrix.matrix.size() == 0;
    });
    if (matrices.empty())
      refuse("the file has no matrix",
             "a dataset of two dimensions or a group with data, indices and indptr is required");
    attach_map(matrices);
    if (!others_.empty()) {
      std::string names;
      for (const auto& name : others_) names += (names.empty() ? "" : ", ") + name;
      matrices.front().notes.push_back("datasets that are no matrices and are not used: " + names);
    }
    return matrices;
  }

private:
  [[nodiscard]] bool is_map(const std::string& name) const {
    if (!is_map_name(name) || !file_.holds_numbers(name)) return false;
    const auto shape = file_.shape(name);
    return shape.size() == 2 && shape[1] == 2;
  }

  /// The dataset of a group under one of several usual names, "" where there is none.
  [[nodiscard]] std::string member(const std::string& group, const Names& usual) {
    for (const auto& name : names_) {
      if (name.substr(0, name.find_last_of('/')) != group) continue;
      const std::string last = lower_case(name.substr(name.find_last_of('/') + 1));
      if (std::ranges::find(usual, last) != usual.end() && file_.holds_numbers(name) && file_.shape(name).size() < 3) {
        asked_.insert(name);
        return name;
      }
    }
    return {};
  }

  [[nodiscard]] std::optional<ForeignMatrix> sparse(const std::string& group) {
    const std::string values = member(group, {"data", "values", "vals", "val", "value", "v", "pr"});
    if (values.empty()) return {};
    if (const std::string starts = member(group, {"indptr", "jc", "ptr", "colptr", "rowptr", "row_ptr", "col_ptr"}),
        indices = member(group, {"indices", "ir", "idx", "index", "rowval", "colval"});
        !starts.empty() && !indices.empty())
      return compressed(group, values, indices, starts);
    const std::string rows = member(group, {"row", "rows", "i", "irow", "row_indices"});
    const std::string columns = member(group, {"col", "cols", "column", "columns", "j", "icol", "col_indices"});
    if (rows.empty() || columns.empty()) return {};
    return triplets(group, values, rows, columns);
  }

  // Line k holds the entries from starts[k] up to starts[k + 1]; a line is a row (CSR) or a column (CSC). An
  // attribute states the kind (format, encoding-type of anndata, h5sparse_format); jc of MATLAB and colptr of Julia
  // are columns by their name.
  [[nodiscard]] ForeignMatrix compressed(const std::string& group, const std::string& values,
                                         const std::string& indices, const std::string& starts) {
    const Eigen::VectorXd data = numbers(values);
    const auto inner = whole_numbers(indices), outer = whole_numbers(starts);
    const auto size = stated_size(group);
    const std::string kind = stated_kind(group, starts);
    const std::int64_t lines = static_cast<std::int64_t>(outer.size()) - 1;
    if (lines < 1 || outer.front() != 0 || outer.back() != data.size() ||
        inner.size() != static_cast<std::size_t>(data.size()))
      refuse("the sparse matrix '" + group + "' is inconsistent",
             "its starts must rise from 0 to the number of its values, each of which needs an index");
    // Without a word on it, the shape tells rows from columns, and a square matrix is taken by rows.
    const bool by_columns = kind == "csc" || (kind.empty() && size && (*size)[0] != lines && (*size)[1] == lines);
    const std::int64_t across = inner.empty() ? lines : *std::ranges::max_element(inner) + 1;
    const std::array<std::int64_t, 2> shape = size         ? *size
                                              : by_columns ? std::array{std::max(across, lines), lines}
                                                           : std::array{lines, std::max(across, lines)};
    if ((by_columns ? shape[1] : shape[0]) != lines)
      refuse("the sparse matrix '" + group + "' has " + std::to_string(lines) + " lines",
             "its shape is " + std::to_string(shape[0]) + " x " + std::to_string(shape[1]));
    MatrixEntries entries(source_, plain(group), shape[0], shape[1], bytes_);
    for (std::int64_t line = 0; line < lines; ++line) {
      const std::int64_t begin = outer[static_cast<std::size_t>(line)], end = outer[static_cast<std::size_t>(line) + 1];
      if (begin > end || end > data.size())
        refuse("the starts of the sparse matrix '" + group + "' do not increase", "they delimit its rows or columns");
      for (std::int64_t i = begin; i < end; ++i) {
        const std::int64_t index = inner[static_cast<std::size_t>(i)];
        by_columns ? entries.add(index, line, data[i]) : entries.add(line, index, data[i]);
      }
    }
    return entries.finish(Storage::triangle_or_full);
  }

  [[nodiscard]] ForeignMatrix triplets(const std::string& group, const std::string& values, const std::string& rows,
                                       const std::string& columns) {
    const Eigen::VectorXd data = numbers(values);
    const auto row = whole_numbers(rows), column = whole_numbers(columns);
    if (row.size() != static_cast<std::size_t>(data.size()) || column.size() != row.size() || row.empty())
      refuse("the sparse matrix '" + group + "' is inconsistent", "every value needs a row and a column");
    const auto size = stated_size(group);
    const std::int64_t last_row = *std::ranges::max_element(row), last_column = *std::ranges::max_element(column);
    // From 1 where 0 never occurs and the size, if there is one, is reached; from 0 otherwise.
    const bool from_zero = std::ranges::min(*std::ranges::min_element(row), *std::ranges::min_element(column)) == 0 ||
                           (size && last_row < (*size)[0] && last_column < (*size)[1]);
    const std::int64_t first = from_zero ? 0 : 1;
    const std::int64_t square = std::max(last_row, last_column) + 1 - first;
    const auto shape = size.value_or(std::array{square, square});
    MatrixEntries entries(source_, plain(group), shape[0], shape[1], bytes_);
    for (std::size_t i = 0; i < row.size(); ++i)
      entries.add(row[i] - first, column[i] - first, data[static_cast<Index>(i)]);
    return entries.finish(Storage::triangle_or_full);
  }

  // MATLAB writes its columns as HDF5's rows, so its matrices appear transposed.
  [[nodiscard]] ForeignMatrix dense(const std::string& name) const {
    const auto shape = file_.shape(name);
    require_stored(name);
    for (const char* packed : {"scale_factor", "add_offset"})
      if (file_.has_attribute(name, packed))
        refuse("matrix '" + plain(name) + "' is packed (" + packed + ")", "its numbers are not those of the matrix");
    Eigen::MatrixXd values = file_.read_matrix(name);
    if (file_.has_attribute(name, "MATLAB_class")) values.transposeInPlace();
    if (!values.allFinite())
      refuse("matrix '" + plain(name) + "' has an entry that is not finite", "every entry must be a finite number");
    return {plain(name), values.sparseView(), {}, false};
  }

  /// "shape" as a dataset or an attribute, MATLAB's number of rows.
  [[nodiscard]] std::optional<std::array<std::int64_t, 2>> stated_size(const std::string& group) {
    const std::string owner = group.empty() ? "/" : group;
    if (const std::string shape = member(group, {"shape", "size", "dims"}); !shape.empty()) {
      const auto values = whole_numbers(shape);
      if (values.size() == 2) return std::array{values[0], values[1]};
    }
    if (file_.has_attribute(owner, "shape")) {
      const Eigen::VectorXd values = file_.numbers_attribute(owner, "shape");
      if (values.size() == 2) return std::array{whole(values[0]), whole(values[1])};
    }
    if (file_.has_attribute(owner, "MATLAB_sparse")) {
      const std::string starts = member(group, {"jc"});
      if (!starts.empty())
        return std::array{whole(file_.number_attribute(owner, "MATLAB_sparse")),
                          static_cast<std::int64_t>(whole_numbers(starts).size()) - 1};
    }
    return {};
  }

  /// "csr" or "csc" where an attribute or the name of the starts says so.
  [[nodiscard]] std::string stated_kind(const std::string& group, const std::string& starts) const {
    const std::string last = lower_case(starts.substr(starts.find_last_of('/') + 1));
    if (last == "jc" || last == "colptr" || last == "col_ptr") return "csc";
    if (last == "rowptr" || last == "row_ptr") return "csr";
    for (const std::string name : {"format", "encoding-type", "h5sparse_format", "type"}) {
      const std::string owner = group.empty() ? "/" : group;
      if (!file_.has_attribute(owner, name)) continue;
      std::string text;
      try {
        text = lower_case(file_.text_attribute(owner, name));
      } catch (const InvalidInput&) {
        continue;  // an attribute of that name that is no text says nothing
      }
      if (text.find("csc") != std::string::npos) return "csc";
      if (text.find("csr") != std::string::npos) return "csr";
    }
    return {};
  }

  void require_stored(const std::string& name) const {
    double count = 1.0;
    for (const Index length : file_.shape(name)) count *= static_cast<double>(length);
    if (count > small_dataset && count > most_compression * static_cast<double>(file_.stored_bytes(name)))
      refuse("'" + name + "' claims " + std::to_string(count) + " values, but the file is too short for them",
             "the file is damaged");
    if (count * 8.0 > static_cast<double>(most_unpacked(bytes_)))
      refuse("'" + name + "' unpacks to " + std::to_string(std::llround(count * 8e-6)) + " MB, far more than the file",
             "store it sparse, or without compression");
  }

  [[nodiscard]] Eigen::VectorXd numbers(const std::string& name) const {
    require_stored(name);
    return file_.read(name);
  }

  [[nodiscard]] std::int64_t whole(double value) const {
    if (!(value >= 0.0 && value < 9e15 && value == std::floor(value)))
      refuse("a size or an index is " + std::to_string(value), "it must be a whole number");
    return static_cast<std::int64_t>(value);
  }

  [[nodiscard]] std::vector<std::int64_t> whole_numbers(const std::string& name) const {
    std::vector<std::int64_t> result;
    for (const double value : numbers(name)) result.push_back(whole(value));
    return result;
  }

  /// A map that is as long as no matrix is one of the others.
  void attach_map(std::vector<ForeignMatrix>& matrices) {
    for (const auto& name : names_) {
      if (!is_map(name)) continue;
      require_stored(name);
      const auto map = dofs_of_map(file_.read_matrix(name), source_);
      bool fits = false;
      for (auto& matrix : matrices) {
        if (!matrix.dofs.empty() || matrix.matrix.rows() != static_cast<Index>(map.size())) continue;
        matrix.dofs = map;
        fits = true;
      }
      if (!fits) others_.push_back(plain(name));
    }
  }

  static std::string plain(const std::string& path) {
    return path.empty() ? "matrix" : path.starts_with('/') ? path.substr(1) : path;
  }

  [[noreturn]] void refuse(std::string what, std::string why) const {
    refuse_matrix(source_, 0, std::move(what), std::move(why));
  }

  Hdf5File file_;
  const std::string& source_;
  std::size_t bytes_;
  Names names_;
  std::map<std::string, std::set<std::string>> groups_;
  std::set<std::string> asked_;  ///< datasets of the group that is tried as a sparse matrix
  Names others_;                 ///< datasets that are not used
};

}  // namespace

bool looks_like_hdf5(std::string_view bytes) {
  // The signature stands at 0, 512, 1024, 2048 ...: a block of the user's own may come before it.
  constexpr std::string_view signature = "\x89HDF\r\n\x1a\n";
  for (std::size_t at = 0; at < bytes.size(); at = at == 0 ? 512 : 2 * at)
    if (bytes.substr(at).starts_with(signature)) return true;
  return false;
}

std::vector<ForeignMatrix> parse_hdf5(std::string_view bytes, const std::string& source) {
  return Hdf5Reader(bytes, source).read();
}

}  // namespace kalfem
