#include "kalfem/formats/matrices/write.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "kalfem/base/atomic_file.hpp"
#include "kalfem/base/invalid_input.hpp"
#include "kalfem/formats/matrices/entries.hpp"
#include "kalfem/formats/matrices/matrix_model.hpp"
#include "kalfem/formats/matrices/single_formats.hpp"

namespace kalfem {
namespace {

namespace fs = std::filesystem;

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
      issues.add({path.string(), 0}, "two matrices have a number '" + matrix.name + "'", "names must differ",
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

std::vector<ForeignMatrix> matrices_of(const LinearModel& model) {
  const auto dofs = dofs_of(model);
  SparseMatrix damping = model.damping;
  if (model.modal_damping.rates.size() > 0)
    damping += SparseMatrix(
        damping_force(model.modal_damping, model.mass, Eigen::MatrixXd::Identity(model.size(), model.size()))
            .sparseView());
  std::vector<ForeignMatrix> matrices{{"K", model.stiffness, dofs, true}, {"M", model.mass, dofs, true}};
  if (damping.nonZeros() > 0) matrices.push_back({"C", std::move(damping), dofs, true});
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
