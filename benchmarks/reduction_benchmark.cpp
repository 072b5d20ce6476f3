// SPDX-License-Identifier: Apache-2.0
// Time and memory of the sparse linear algebra and of a Craig-Bampton reduction, for a model of the size and pattern of
// a shell frame. Usage: reduction_benchmark [columns rows]; defaults give 45,540 degrees of freedom.
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <set>
#include <tuple>

#include "kalfem/linalg/blas.hpp"
#include "kalfem/linalg/lowest_modes.hpp"
#include "kalfem/linalg/sparse_operations.hpp"
#include "kalfem/reduction/superelement.hpp"
#include "timing.hpp"

namespace {

using namespace kalfem;
using namespace kalfem::benchmarks;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Grillage of beams along x, y and both diagonals between neighbouring nodes, six degrees of freedom a node, so that
/// each node couples with its eight neighbours as in a shell mesh; folded to a channel so that membrane and bending
/// motion mix. Clamped nowhere: six rigid-body modes.
class Frame {
public:
  Frame(Index columns, Index rows) : columns_(columns), rows_(rows) {
    for (Index x = 0; x < columns; ++x)
      for (Index y = 0; y < rows; ++y)
        for (const auto& [dx, dy] : {std::pair{1, 0}, {0, 1}, {1, 1}, {1, -1}})
          if (x + dx < columns && y + dy >= 0 && y + dy < rows) beam(node(x, y), node(x + dx, y + dy));
  }

  [[nodiscard]] LinearModel model() const {
    const Index n = 6 * columns_ * rows_;
    LinearModel model;
    for (Index i = 0; i < n; ++i)
      model.dofs.push_back(std::to_string(i / 6) + std::array{".x", ".y", ".z", ".rx", ".ry", ".rz"}[i % 6]);
    model.mass = SparseMatrix(n, n);
    model.stiffness = SparseMatrix(n, n);
    model.mass.setFromTriplets(mass_.begin(), mass_.end());
    model.stiffness.setFromTriplets(stiffness_.begin(), stiffness_.end());
    model.damping = 1e-6 * model.stiffness;
    return model;
  }

private:
  [[nodiscard]] Index node(Index x, Index y) const { return x * rows_ + y; }
  [[nodiscard]] Eigen::Vector3d place(Index node) const {
    const double spacing = 0.02;
    const double x = spacing * double(node / rows_), s = spacing * double(node % rows_);
    const double web = spacing * double(rows_ / 3);
    if (s < web) return {x, 0.0, web - s};
    if (s > 2.0 * web) return {x, web, s - 2.0 * web};
    return {x, s - web, 0.0};
  }

  /// Energy (EA e^2 + GA (s - rotation)^2 + EI and GJ rotation differences) / 2 of one beam: rank six, free of strain
  /// in rigid-body motion.
  void beam(Index a, Index b) {
    const Eigen::Vector3d r = place(b) - place(a);
    const double l = r.norm(), area = 2e-5, E = 2.1e11, rho = 7800.0, I = 2e-11;
    Eigen::Matrix<double, 6, 12> B = Eigen::Matrix<double, 6, 12>::Zero();
    Eigen::Matrix3d cross;
    cross << 0, -r.z(), r.y(), r.z(), 0, -r.x(), -r.y(), r.x(), 0;
    B.block<3, 3>(0, 0) = -Eigen::Matrix3d::Identity();
    B.block<3, 3>(0, 6) = Eigen::Matrix3d::Identity();
    B.block<3, 3>(0, 3) = B.block<3, 3>(0, 9) = 0.5 * cross;  // u_b - u_a - (theta_a + theta_b) / 2 x r
    B.block<3, 3>(3, 3) = -Eigen::Matrix3d::Identity();
    B.block<3, 3>(3, 9) = Eigen::Matrix3d::Identity();
    const Eigen::Vector3d t = r / l;
    const double shear = 12.0 * E * I / (l * l * l);
    const Eigen::Matrix3d along = t * t.transpose(), across = Eigen::Matrix3d::Identity() - along;
    Eigen::Matrix<double, 6, 6> D = Eigen::Matrix<double, 6, 6>::Zero();
    D.topLeftCorner<3, 3>() = E * area / l * along + shear * across;
    D.bottomRightCorner<3, 3>() = E * I / l * (across + 0.8 * along);
    const Eigen::Matrix<double, 12, 12> K = B.transpose() * D * B;
    for (Index i = 0; i < 12; ++i)
      for (Index j = 0; j < 12; ++j) stiffness_.emplace_back(dof(a, b, i), dof(a, b, j), K(i, j));
    for (Index i = 0; i < 12; ++i)
      mass_.emplace_back(dof(a, b, i), dof(a, b, i), 0.5 * rho * area * l * (i % 6 < 3 ? 1.0 : l * l / 12.0));
  }

  static Index dof(Index a, Index b, Index i) { return i < 6 ? 6 * a + i : 6 * b + i - 6; }

  Index columns_, rows_;
  std::vector<Eigen::Triplet<double>> mass_, stiffness_;
};

/// The fastest of some repetitions: what the machine can do.
template <typename Work>
double best_of(int repetitions, Work work) {
  double best = seconds(work);
  for (int i = 1; i < repetitions; ++i) best = std::min(best, seconds(work));
  return best;
}

}  // namespace

int main(int argc, char** argv) {
  const Index columns = argc > 2 ? std::atol(argv[1]) : 165, rows = argc > 2 ? std::atol(argv[2]) : 46;
  const LinearModel model = Frame(columns, rows).model();
  std::vector<std::string> boundary;
  for (const Index node : {Index{0}, rows - 1, (columns - 1) * rows, columns * rows - 1})  // the corners
    for (Index i = 6 * node; i < 6 * node + 6; ++i) boundary.push_back(model.dofs[static_cast<std::size_t>(i)]);
  line("degrees of freedom", double(model.size()), "");
  line("entries of K", double(model.stiffness.nonZeros()), "");
  std::printf("%-58s %10s\n", "BLAS kernels", blas_kernels().c_str());
  if (const auto warning = blas_warning()) std::printf("%s\n", warning->c_str());

  std::set<std::string> kept(boundary.begin(), boundary.end());
  std::vector<Index> interior;
  for (Index i = 0; i < model.size(); ++i)
    if (!kept.contains(model.dofs[static_cast<std::size_t>(i)])) interior.push_back(i);
  const SparseMatrix K_ii = select(model.stiffness, interior, interior);
  std::unique_ptr<SparseFactor> factor;
  const double first = seconds([&] { factor = std::make_unique<SparseFactor>(K_ii); });
  line("ordering, analysis and factor of K_ii", first, "s");
  line("refactor", best_of(3, [&] { factor->refactor(K_ii); }), "s");
  line("entries of L", factor->nonzeros(), "");
  line("memory of L", factor->bytes() / 1e6, "MB");
  MatrixXd block = MatrixXd::Random(factor->size(), 24), solution = block;
  const double single = best_of(5, [&] { factor->solve(block.col(0), solution.col(0)); });
  line("solve, one right-hand side", 1e3 * single, "ms");
  for (const Index width : {8, 24})
    std::printf(
        "solve, %2d right-hand sides, per vector %31.4g ms\n", int(width),
        1e3 / double(width) * best_of(3, [&] { factor->solve(block.leftCols(width), solution.leftCols(width)); }));
  const double eight = best_of(3, [&] { factor->solve(block.leftCols(8), solution.leftCols(8)); }) / 8.0;
  factor.reset();

  LowestModes modes;
  line("40 lowest modes of the free model, with factor, no check",
       seconds([&] { modes = lowest_modes(model.stiffness, model.mass, {.count = 40, .check = ModeCheck::none}); }),
       "s");
  line("  back-solves", double(modes.solves), "");
  line("40 lowest modes of the free model, with factor",
       seconds([&] { modes = lowest_modes(model.stiffness, model.mass, {.count = 40}); }), "s");
  line("  back-solves", double(modes.solves), "");
  line("  rigid-body modes", double((modes.values.array() == 0.0).count()), "");
  line("  first elastic", std::sqrt(modes.values[6]) / (2.0 * std::numbers::pi), "Hz");
  line("  fortieth", std::sqrt(modes.values[39]) / (2.0 * std::numbers::pi), "Hz");

  Superelement element;
  const double reduction =
      seconds([&] { element = craig_bampton(model, boundary, {.modes = {.count = 60}, .error_indicators = false}); });
  line("Craig-Bampton, 24 + 60, without evidence", reduction, "s");
  line("  back-solves", double(element.error_indicators.solves), "");
  line("  highest kept", element.error_indicators.highest_kept, "Hz");
  line("  static error", element.error_indicators.static_error, "");
  line("  ratio to one factorisation and its back-solves",
       reduction / (first + double(element.error_indicators.solves) * eight), "");
  line("  ratio to one factorisation and single back-solves",
       reduction / (first + double(element.error_indicators.solves) * single), "");
  line("peak memory", memory_megabytes("VmHWM"), "MB");
  const double compared = seconds([&] { element = craig_bampton(model, boundary, {.modes = {.count = 60}}); });
  line("Craig-Bampton with evidence", compared, "s");
  for (const auto& mode : element.error_indicators.modes)
    std::printf("  %9.3f Hz full %9.3f Hz reduced, MAC %.4f, residual %.1e\n", mode.full, mode.reduced, mode.mac,
                mode.residual);
  return 0;
}
