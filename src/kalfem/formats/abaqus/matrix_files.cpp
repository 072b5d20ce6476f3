// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "kalfem/formats/abaqus/elements.hpp"
#include "kalfem/formats/matrices.hpp"
#include "kalfem/formats/text_file.hpp"

namespace kalfem::abaqus {

namespace {

using Triplets = std::vector<Eigen::Triplet<double>>;

/// Entries of files over the degrees of freedom that occur in any of them.
class MatrixFiles {
public:
  explicit MatrixFiles(PlacedDeck& deck) : deck_(deck) {}

  Triplets read(const std::string& text, const Where& where, const std::string& what);
  [[nodiscard]] std::vector<NodalDof> dofs() const {
    std::vector<NodalDof> list(columns_.size());
    for (const auto& [dof, column] : columns_) list[static_cast<std::size_t>(column)] = dof;
    return list;
  }

private:
  /// Column of a degree of freedom, -1 where the deck has no such node.
  int column(const MatrixDof& dof);

  PlacedDeck& deck_;
  std::map<NodalDof, int> columns_;
};

int MatrixFiles::column(const MatrixDof& dof) {
  const auto node = dof.direction < 0 ? -1 : deck_.place(0).nodes.find(dof.node);
  if (node < 0) return -1;
  return columns_.try_emplace(NodalDof{node, dof.direction}, static_cast<int>(columns_.size())).first->second;
}

// Stiffness and mass may list different degrees of freedom, so both number them in one list. A row of a node that the
// deck does not have has no place, and the matrix is refused.
Triplets MatrixFiles::read(const std::string& text, const Where& where, const std::string& what) {
  Triplets entries;
  if (text.empty()) return entries;
  try {
    for (const auto& matrix : parse_matrices(text, what, {.format = MatrixFormat::nodal}))
      for (Eigen::Index j = 0; j < matrix.matrix.outerSize(); ++j)
        for (SparseMatrix::InnerIterator it(matrix.matrix, j); it; ++it) {
          const auto& row_dof = matrix.dofs[static_cast<std::size_t>(it.row())];
          const int row = column(row_dof), col = column(matrix.dofs[static_cast<std::size_t>(it.col())]);
          if (row >= 0 && col >= 0) {
            entries.emplace_back(row, col, it.value());
            continue;
          }
          deck_.problems.add(where, "the " + what + " file names a node that the deck does not have",
                             "its rows must be degrees of freedom of the deck's nodes",
                             "correct the file or add the node");
          return {};
        }
  } catch (const InvalidInput& error) {
    for (const auto& issue : error.issues())
      deck_.problems.add(where,
                         "line " + std::to_string(issue.location.line) + " of the " + what +
                             " file: " + without_quotations(issue.what),
                         issue.why, issue.fix);
  }
  return entries;
}

}  // namespace

void add_matrices(const RawDeck& raw, PlacedDeck& deck, FiniteElementModel& model) {
  for (const auto& matrix : raw.matrices) {
    MatrixFiles files(deck);
    const Triplets stiffness = files.read(matrix.stiffness, matrix.where, "stiffness");
    const Triplets mass = files.read(matrix.mass, matrix.where, "mass");
    NodalMatrices result;
    result.name = matrix.name.empty() ? "matrix." + std::to_string(matrix.where.line) : matrix.name;
    result.dofs = files.dofs();
    const auto size = static_cast<Index>(result.dofs.size());
    const auto fill = [&](const Triplets& entries, Eigen::SparseMatrix<double>& target) {
      if (entries.empty()) return;
      target.resize(size, size);
      target.setFromTriplets(entries.begin(), entries.end());
    };
    fill(stiffness, result.stiffness);
    fill(mass, result.mass);
    if (size > 0) model.matrices.push_back(std::move(result));
  }
}

}  // namespace kalfem::abaqus
