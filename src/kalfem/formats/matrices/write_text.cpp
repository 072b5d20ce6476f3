#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "kalfem/formats/matrices/entries.hpp"
#include "kalfem/formats/matrices/writers.hpp"

namespace kalfem {
namespace {

using Eigen::Index;

/// The most digits of a number that fit into a field of 16, with the exponent as Nastran takes it: "-1.2345678901-5".
std::string large_field(double value) {
  for (int digits = 14; digits > 0; --digits) {
    const std::string text = fmt::format("{:.{}e}", value, digits);
    const std::size_t at = text.find('e');
    const int exponent = std::stoi(text.substr(at + 1));
    const std::string field = text.substr(0, at) + fmt::format("{:+d}", exponent);
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

}  // namespace kalfem
