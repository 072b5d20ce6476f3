// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/matrices/write.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <set>

#include "kalfem/base/atomic_file.hpp"
#include "kalfem/base/invalid_input.hpp"
#include "kalfem/formats/hdf5/hdf5_file.hpp"
#include "kalfem/formats/matrices/entries.hpp"
#include "kalfem/formats/matrices/matrix_model.hpp"
#include "kalfem/formats/matrices/single_formats.hpp"

namespace kalfem {
namespace {

using Eigen::Index;

/// The most digits of a number that fit into a field of 16, with the exponent as Nastran takes it: "-1.2345678901-5".
std::string large_field(double value) {
  for (int digits = 14; digits > 0; --digits) {
    const std::string text = fmt::format("{:.{}e}", value, digits);
    const std::size_t at = text.find('e');
    const int exponent = std::stoi(text.substr(at + 1));
    std::string field = text.substr(0, at) + fmt::format("{:+d}", exponent);
    if (field.size() <= 16) return field;
  }
  return "0.0";
}

/// Numbers of the scalar points that stand for generalised coordinates: their own, or beyond all nodes.
std::int64_t scalar_point_shift(const std::vector<ForeignMatrix>& matrices) {
  std::int64_t last_node = 0;
  bool generalised = false;
  for (const auto& matrix : matrices)
    for (const auto& dof : matrix.dofs) {
      if (dof.direction >= 0) last_node = std::max(last_node, dof.node);
      generalised = generalised || dof.direction < 0;
    }
  if (!generalised || last_node == 0) return 0;
  std::int64_t shift = 1000;
  while (shift <= last_node) shift *= 10;
  return shift;
}

// One DMIG header for each matrix, then one card for each column that is not empty, in large fields with one row on a
// line. Form 6 (symmetric) takes the triangle below the diagonal, form 1 all entries.
class DmigWriter {
public:
  explicit DmigWriter(std::int64_t shift) : shift_(shift) {}

  void add(const ForeignMatrix& matrix) {
    const bool symmetric = is_symmetric(matrix.matrix);
    text_ += fmt::format("DMIG    {:<8}{:>8}{:>8}{:>8}{:>8}\n", matrix.name, 0, symmetric ? 6 : 1, 2, 0);
    for (Index column = 0; column < matrix.matrix.outerSize(); ++column) add_column(matrix, column, symmetric);
  }

  [[nodiscard]] const std::string& text() const { return text_; }

private:
  void add_column(const ForeignMatrix& matrix, Index column, bool symmetric) {
    bool begun = false;
    for (SparseMatrix::InnerIterator it(matrix.matrix, column); it; ++it) {
      if (symmetric && it.row() < column) continue;
      if (!begun) text_ += fmt::format("DMIG*   {:<16}{}\n", matrix.name, point(matrix, column));
      begun = true;
      text_ += fmt::format("*       {}{:>16}\n", point(matrix, it.row()), large_field(it.value()));
    }
  }

  [[nodiscard]] std::string point(const ForeignMatrix& matrix, Index row) const {
    const MatrixDof dof = matrix.dofs.empty() ? MatrixDof{row + 1, -1} : matrix.dofs[static_cast<std::size_t>(row)];
    const std::int64_t number = dof.direction < 0 ? dof.node + shift_ : dof.node;
    return fmt::format("{:>16}{:>16}", number, dof.direction + 1);
  }

  std::int64_t shift_;
  std::string text_;
};

/// Rows that follow one another in a column.
template <typename Visit>
void for_each_string(const SparseMatrix& matrix, Index column, const Visit& visit) {
  std::vector<double> values;
  Index first = 0;
  for (SparseMatrix::InnerIterator it(matrix, column); it; ++it) {
    if (!values.empty() && it.row() != first + static_cast<Index>(values.size())) {
      visit(first, values);
      values.clear();
    }
    if (values.empty()) first = it.row();
    values.push_back(it.value());
  }
  if (!values.empty()) visit(first, values);
}

}  // namespace

bool is_symmetric(const SparseMatrix& matrix) {
  if (matrix.rows() != matrix.cols()) return false;
  const SparseMatrix difference = matrix - SparseMatrix(matrix.transpose());
  return difference.nonZeros() == 0 || difference.coeffs().abs().maxCoeff() == 0.0;
}

// Coordinate format with 17 significant digits, from which a reader gets the same doubles. Symmetric matrices list
// the triangle below the diagonal only.
std::string matrix_market_text(const ForeignMatrix& matrix) {
  const bool symmetric = is_symmetric(matrix.matrix);
  std::string entries;
  Index count = 0;
  for (Index column = 0; column < matrix.matrix.outerSize(); ++column)
    for (SparseMatrix::InnerIterator it(matrix.matrix, column); it; ++it) {
      if (symmetric && it.row() < column) continue;
      entries += fmt::format("{} {} {:.17g}\n", it.row() + 1, column + 1, it.value());
      ++count;
    }
  return fmt::format("%%MatrixMarket matrix coordinate real {}\n{} {} {}\n", symmetric ? "symmetric" : "general",
                     matrix.matrix.rows(), matrix.matrix.cols(), count) +
         entries;
}

std::string dmig_text(const std::vector<ForeignMatrix>& matrices) {
  const std::int64_t shift = scalar_point_shift(matrices);
  DmigWriter writer(shift);
  for (const auto& matrix : matrices) writer.add(matrix);
  if (shift == 0) return writer.text();
  return fmt::format("$ generalised coordinate i is the scalar point {} + i\n", shift) + writer.text();
}

// A negative number of rows announces long strings (BIGMAT). Each column then has a line (column, 0, words) and its
// strings a line (words + 1, row). A double counts as 2 words, the header of a string as 2 more.
std::string op4_text(const std::vector<ForeignMatrix>& matrices) {
  std::string text;
  for (const auto& matrix : matrices) {
    const SparseMatrix& entries = matrix.matrix;
    text += fmt::format("{:>8}{:>8}{:>8}{:>8}{:<8}1P,3E24.16\n", entries.cols(), -entries.rows(),
                        is_symmetric(entries) ? 6 : 2, 2, matrix.name);
    for (Index column = 0; column < entries.outerSize(); ++column) {
      std::string strings;
      std::size_t words = 0;
      for_each_string(entries, column, [&](Index first, const std::vector<double>& values) {
        strings += fmt::format("{:>8}{:>8}\n", 2 * values.size() + 1, first + 1);
        for (std::size_t i = 0; i < values.size(); ++i)
          strings += fmt::format("{:24.16E}{}", values[i], i % 3 == 2 || i + 1 == values.size() ? "\n" : "");
        words += 2 * values.size() + 2;
      });
      if (words > 0) text += fmt::format("{:>8}{:>8}{:>8}\n", column + 1, 0, words) + strings;
    }
    text += fmt::format("{:>8}{:>8}{:>8}\n{:24.16E}\n", entries.cols() + 1, 1, 1, 1.0);
  }
  return text;
}

namespace {

// A record is collected first, as its length stands before and behind it.
/// Fortran's unformatted records in a given order of bytes.
class RecordWriter {
public:
  explicit RecordWriter(bool big_endian) : swap_(big_endian != (std::endian::native == std::endian::big)) {}

  template <typename T>
  void add(T value) {
    char bytes[sizeof(T)];
    std::memcpy(bytes, &value, sizeof(T));
    if (swap_) std::reverse(bytes, bytes + sizeof(T));
    record_.append(bytes, sizeof(T));
  }
  void add_text(const std::string& text, std::size_t width) {
    record_ += text;
    record_.append(width - text.size(), ' ');
  }
  void end_record() {
    const std::string content = std::move(record_);
    record_.clear();
    add(static_cast<std::int32_t>(content.size()));
    const std::string length = std::move(record_);
    record_.clear();
    file_ += length + content + length;
  }
  [[nodiscard]] const std::string& bytes() const { return file_; }

private:
  bool swap_;
  std::string record_, file_;
};

// The order of the text form in records with integers of 4 bytes: header, columns with entries, a column beyond the
// last.
void add_op4(const ForeignMatrix& matrix, RecordWriter& writer) {
  const SparseMatrix& entries = matrix.matrix;
  for (const Index number : {entries.cols(), -entries.rows(), Index{is_symmetric(entries) ? 6 : 2}, Index{2}})
    writer.add(static_cast<std::int32_t>(number));
  writer.add_text(matrix.name, 8);
  writer.end_record();
  for (Index column = 0; column < entries.outerSize(); ++column) {
    const Index count = entries.col(column).nonZeros();
    if (count == 0) continue;
    // One string an entry: 2 words of header, 2 of number.
    for (const Index number : {column + 1, Index{0}, 4 * count}) writer.add(static_cast<std::int32_t>(number));
    for (SparseMatrix::InnerIterator it(entries, column); it; ++it) {
      writer.add(std::int32_t{3});
      writer.add(static_cast<std::int32_t>(it.row() + 1));
      writer.add(it.value());
    }
    writer.end_record();
  }
  for (const Index number : {entries.cols() + 1, Index{1}, Index{2}}) writer.add(static_cast<std::int32_t>(number));
  writer.add(1.0);
  writer.end_record();
}

Eigen::MatrixXd map_rows(const std::vector<MatrixDof>& dofs) {
  Eigen::MatrixXd rows(static_cast<Index>(dofs.size()), 2);
  for (Index i = 0; i < rows.rows(); ++i) {
    const auto& dof = dofs[static_cast<std::size_t>(i)];
    rows.row(i) << static_cast<double>(dof.node), dof.direction + 1;
  }
  return rows;
}

// Compressed columns by the names of scipy.sparse: data, indices, indptr, shape, and the format as an attribute.
void add_hdf5(const ForeignMatrix& matrix, Hdf5File& file) {
  SparseMatrix entries = matrix.matrix;
  entries.makeCompressed();
  const std::string group = "/" + matrix.name;
  const Index count = entries.nonZeros();
  using Integers = Eigen::Map<const Eigen::VectorXi>;
  file.write(group + "/data", Eigen::Map<const Eigen::VectorXd>(entries.valuePtr(), count));
  file.write(group + "/indices", Integers(entries.innerIndexPtr(), count).cast<double>());
  file.write(group + "/indptr", Integers(entries.outerIndexPtr(), entries.outerSize() + 1).cast<double>());
  file.write(group + "/shape",
             Eigen::Vector2d(static_cast<double>(entries.rows()), static_cast<double>(entries.cols())));
  file.set_attribute(group, "format", std::string("csc"));
}

}  // namespace

std::string op4_bytes(const std::vector<ForeignMatrix>& matrices, bool big_endian) {
  RecordWriter writer(big_endian);
  for (const auto& matrix : matrices) add_op4(matrix, writer);
  return writer.bytes();
}

std::string hdf5_bytes(const std::vector<ForeignMatrix>& matrices, const Eigen::MatrixXd& basis,
                       const std::vector<std::string>& names) {
  Hdf5File file = Hdf5File::create_in_memory("matrices.h5");
  for (const auto& matrix : matrices) add_hdf5(matrix, file);
  if (!matrices.empty() && !matrices.front().dofs.empty())
    file.write_matrix("/dof_map", map_rows(matrices.front().dofs));
  if (!names.empty()) file.write_strings("/names", names);
  if (basis.size() > 0) file.write_matrix("/basis", basis);
  return file.bytes();
}

namespace {

namespace fs = std::filesystem;

// Names of Nastran have at most 8 letters, and Matrix Market holds one matrix without a name.
void check(const std::vector<ForeignMatrix>& matrices, MatrixFormat format, const fs::path& path) {
  const bool nastran = format == MatrixFormat::dmig || format == MatrixFormat::op4;
  if (!nastran && format != MatrixFormat::matrix_market && format != MatrixFormat::hdf5)
    throw InvalidInput(Issue{{path.string(), 0},
                             "matrices cannot be written in this format",
                             "matrix_market, dmig, op4 and hdf5 can be written",
                             "choose one of them"});
  IssueList issues;
  if (format == MatrixFormat::matrix_market && matrices.size() != 1)
    issues.add({path.string(), 0}, std::to_string(matrices.size()) + " matrices for a Matrix Market file",
               "such a file holds one matrix");
  std::set<std::string> names;
  for (const auto& matrix : matrices) {
    if (nastran && (matrix.name.empty() || matrix.name.size() > 8))
      issues.add({path.string(), 0}, "the matrix name '" + matrix.name + "' is not valid in Nastran",
                 "it must have 1 to 8 letters", "rename it");
    if (!names.insert(matrix.name).second)
      issues.add({path.string(), 0}, "two matrices have the name '" + matrix.name + "'", "names must differ",
                 "rename one");
    if (matrix.matrix.nonZeros() > 0 && !matrix.matrix.coeffs().allFinite())
      issues.add({path.string(), 0}, "matrix '" + matrix.name + "' has an entry that is not finite",
                 "other codes could not read it");
    if (format == MatrixFormat::dmig && matrix.matrix.rows() != matrix.matrix.cols())
      issues.add({path.string(), 0}, "matrix '" + matrix.name + "' is not square",
                 "only square matrices can be written as DMIG");
    if (std::ranges::any_of(matrix.dofs, [](const MatrixDof& dof) { return dof.copy > 0; }))
      issues.add({path.string(), 0}, "rows of matrix '" + matrix.name + "' have the same degree of freedom",
                 "every row needs its own");
  }
  issues.raise();
}

/// Nodes by their names, all others generalised coordinates in their order.
std::vector<MatrixDof> dofs_of(const LinearModel& model) {
  std::vector<MatrixDof> dofs;
  std::int64_t generalised = 0;
  for (const auto& name : model.dofs) {
    const auto dof = matrix_dof(name);
    dofs.push_back(dof && dof->direction >= 0 ? *dof : MatrixDof{++generalised, -1});
  }
  return dofs;
}

// Modal damping is kept as modes and rates; here it becomes the matrix that gives the same force, D = F(I).
std::vector<ForeignMatrix> matrices_of(const LinearModel& model) {
  const auto dofs = dofs_of(model);
  SparseMatrix damping = model.damping;
  if (model.modal_damping.rates.size() > 0)
    damping += SparseMatrix(
        damping_force(model.modal_damping, model.mass, Eigen::MatrixXd::Identity(model.size(), model.size()))
            .sparseView());
  std::vector<ForeignMatrix> matrices{{"K", model.stiffness, dofs, true}, {"M", model.mass, dofs, true}};
  if (damping.nonZeros() > 0) matrices.push_back({"C", damping, dofs, true});
  return matrices;
}

std::string dof_map_text(const std::vector<MatrixDof>& dofs) {
  std::string text = "# node direction; number 0: generalised coordinate\n";
  for (const auto& dof : dofs) text += fmt::format("{} {}\n", dof.node, dof.direction + 1);
  return text;
}

}  // namespace

void write_matrices(const fs::path& path, const std::vector<ForeignMatrix>& matrices, MatrixFormat format,
                    const MatrixWriteOptions& options) {
  check(matrices, format, path);
  std::string bytes;
  if (format == MatrixFormat::matrix_market)
    bytes = matrix_market_text(matrices.front());
  else if (format == MatrixFormat::dmig)
    bytes = dmig_text(matrices);
  else if (format == MatrixFormat::hdf5)
    bytes = hdf5_bytes(matrices, {}, {});
  else
    bytes = options.binary ? op4_bytes(matrices, options.big_endian) : op4_text(matrices);
  write_file_atomically(path, bytes);
}

void write_dof_map(const fs::path& path, const std::vector<MatrixDof>& dofs) {
  write_file_atomically(path, dof_map_text(dofs));
}

// HDF5 and DMIG take all matrices in one file: HDF5 with map, names and basis, DMIG with its points as the map.
// Matrix Market holds one matrix a file. It and OUTPUT4 know no degrees of freedom, so a map is written beside them.
std::vector<fs::path> write_superelement(const fs::path& path, const LinearModel& model, MatrixFormat format,
                                         const Eigen::MatrixXd& basis, const MatrixWriteOptions& options) {
  const auto matrices = matrices_of(model);
  if (format == MatrixFormat::hdf5) {
    check(matrices, format, path);
    write_file_atomically(path, hdf5_bytes(matrices, basis, model.dofs));
    return {path};
  }
  std::vector<fs::path> files;
  const fs::path stem = path.parent_path() / path.stem();
  if (format == MatrixFormat::matrix_market) {
    for (const auto& matrix : matrices) {
      files.emplace_back(stem.string() + "_" + matrix.name + ".mtx");
      write_matrices(files.back(), {matrix}, format, options);
    }
  } else {
    write_matrices(path, matrices, format, options);
    files.push_back(path);
  }
  if (format == MatrixFormat::dmig) return files;
  files.emplace_back(stem.string() + ".dof");
  write_dof_map(files.back(), matrices.front().dofs);
  return files;
}

}  // namespace kalfem
