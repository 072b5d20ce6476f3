// SPDX-License-Identifier: Apache-2.0
#include "kalfem/pictures/density_contour.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

namespace {

constexpr int cells = 64;      ///< of the grid in each direction
constexpr double reach = 5.0;  ///< of the grid about the mean, in deviations

/// One step of a separable Gaussian filter along the columns.
MatrixXd blurred_columns(const MatrixXd& values, double width) {
  const int half = static_cast<int>(std::ceil(3.0 * width));
  MatrixXd result = MatrixXd::Zero(values.rows(), values.cols());
  double sum = 0.0;
  for (int shift = -half; shift <= half; ++shift) {
    const double weight = std::exp(-0.5 * shift * shift / (width * width));
    sum += weight;
    const Index from = std::max(0, -shift), to = std::max(0, shift), count = values.rows() - std::abs(shift);
    if (count > 0) result.middleRows(to, count) += weight * values.middleRows(from, count);
  }
  return result / sum;
}

/// The density above which the given share of the whole lies.
double level_of(const MatrixXd& density, double share) {
  std::vector<double> values(density.data(), density.data() + density.size());
  std::ranges::sort(values, std::greater());
  const double wanted = share * std::accumulate(values.begin(), values.end(), 0.0);
  double sum = 0.0;
  for (const double value : values)
    if ((sum += value) >= wanted) return value;
  return 0.0;
}

/// Marching squares over a grid whose value (i, j) stands at the point (i, j): the pieces of the line at `level`.
std::vector<ContourPiece> marching_squares(const MatrixXd& grid, double level) {
  std::vector<ContourPiece> pieces;
  for (Index i = 0; i + 1 < grid.rows(); ++i)
    for (Index j = 0; j + 1 < grid.cols(); ++j) {
      const std::array<Vector2d, 4> corners{Vector2d(i, j), Vector2d(i + 1, j), Vector2d(i + 1, j + 1),
                                            Vector2d(i, j + 1)};
      const std::array values{grid(i, j), grid(i + 1, j), grid(i + 1, j + 1), grid(i, j + 1)};
      std::vector<Vector2d> crossings;
      for (std::size_t side = 0; side < 4; ++side) {
        const std::size_t next = (side + 1) % 4;
        if ((values[side] >= level) == (values[next] >= level)) continue;
        const double part = (level - values[side]) / (values[next] - values[side]);
        crossings.emplace_back(corners[side] + part * (corners[next] - corners[side]));
      }
      for (std::size_t k = 0; k + 1 < crossings.size(); k += 2) pieces.push_back({crossings[k], crossings[k + 1]});
    }
  return pieces;
}

}  // namespace

// The points lose their correlation by the inverse Cholesky factor of their covariance, so that one width of the kernel
// suits both directions however thin the cloud is; the pieces go back by the factor.
std::vector<ContourPiece> density_contour(const Eigen::Matrix2Xd& points, const VectorXd& weights, double share) {
  const Vector2d mean = points * weights;
  const Eigen::Matrix2Xd centred = points.colwise() - mean;
  const Eigen::Matrix2d covariance = centred * weights.asDiagonal() * centred.transpose();
  const double determinant = covariance.determinant(), size = covariance(0, 0) * covariance(1, 1);
  if (!(size > 0.0) || !(determinant > 1e-12 * size)) return {};
  const Eigen::Matrix2d factor = covariance.llt().matrixL();
  const Eigen::Matrix2Xd plain = factor.triangularView<Eigen::Lower>().solve(centred);
  MatrixXd density = MatrixXd::Zero(cells, cells);
  const double cell = 2.0 * reach / cells;
  for (Index k = 0; k < plain.cols(); ++k) {
    const Vector2d place = (plain.col(k).array() + reach) / cell;
    if (place.minCoeff() >= 0.0 && place.maxCoeff() < cells)
      density(static_cast<Index>(place[0]), static_cast<Index>(place[1])) += weights[k];
  }
  const double width = std::max(1.0, std::pow(1.0 / weights.squaredNorm(), -1.0 / 6.0) / cell);
  density = blurred_columns(blurred_columns(density, width).transpose(), width).transpose();
  auto pieces = marching_squares(density, level_of(density, share));
  for (auto& piece : pieces)
    for (auto& point : piece) point = mean + factor * ((point.array() + 0.5) * cell - reach).matrix();
  return pieces;
}

}  // namespace kalfem
