// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <numeric>

#include "kalfem/base/random.hpp"
#include "kalfem/modal/block_covariance.hpp"
#include "kalfem/modal/shape_measures.hpp"
#include "kalfem/modal/state_space_poles.hpp"
#include "modal/ambient_record.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

TEST(OutputCorrelations, AreMeansOfProductsOverBlocks) {
  RandomStream random(1, "outputs");
  const MatrixXd y = MatrixXd::NullaryExpr(3, 205, [&] { return random.normal(); });
  const auto found = output_correlations(y, {2, 0}, 4, 10, 1);
  ASSERT_EQ(found.block_length, 20);
  MatrixXd sum = MatrixXd::Zero(3, 2);
  for (Index k = 0; k < 200; ++k) {
    sum.col(0) += y.col(k + 3) * y(2, k) / 200.0;
    sum.col(1) += y.col(k + 3) * y(0, k) / 200.0;
  }
  EXPECT_LT((found.at(3) - sum).cwiseAbs().maxCoeff(), 1e-14);
  MatrixXd off = MatrixXd::Zero(3, 2);
  for (std::size_t block = 0; block < 10; ++block) off += found.deviation(block, 3);
  EXPECT_LT(off.cwiseAbs().maxCoeff(), 1e-14);
  const auto threads = output_correlations(y, {2, 0}, 4, 10, 3);
  EXPECT_EQ(threads.mean, found.mean);
}

/// Poles of a frame's record, and of the same correlations moved a little along what one block adds.
class PoleDeviations : public ::testing::TestWithParam<SubspaceMethod> {
protected:
  static constexpr Index rows = 8, order = 8;
  const test::AmbientStructure structure = test::shear_frame(4, 20.0, 0.01);
  const Record record = test::ambient_record(structure, 64.0, 40000, 3, 0.01);
  const VectorXd scale = record.values.rowwise().norm() / std::sqrt(40000.0);
  const std::vector<Index> references = {0, 1, 2, 3};
  const OutputCorrelations correlations = output_correlations(record.values, references, 2 * rows - 1, 40, 1);
  const PoleOptions options{.sample_rate = 64.0, .block_length = correlations.block_length};

  [[nodiscard]] Subspace moved(std::size_t block, double step) const {
    auto other = correlations;
    other.mean += step * correlations.deviations[block];
    return make_subspace(other, GetParam(), rows, 12, scale, references, 1);
  }
};

// Central differences of the poles themselves, of a step of a hundredth of a block: errors of the third order, and the
// limit of rotations (a thousandth at this order's gap of singular values).
TEST_P(PoleDeviations, AreDerivativesOfThePoles) {
  const auto subspace = moved(0, 0.0);
  const auto poles = poles_of_order(subspace, order, options);
  ASSERT_EQ(poles.size(), 4u);
  for (const std::size_t block : {0u, 7u, 39u}) {
    const double step = 1e-3;
    const auto up = poles_of_order(moved(block, step), order, options),
               down = poles_of_order(moved(block, -step), order, options);
    for (std::size_t i = 0; i < poles.size(); ++i) {
      const auto at = static_cast<Index>(block);
      const double frequency = (up[i].frequency - down[i].frequency) / (2.0 * step),
                   damping = (up[i].damping - down[i].damping) / (2.0 * step);
      const double size = std::sqrt(40.0) * 5e-3;  // relative to the scatter of the blocks
      EXPECT_NEAR(poles[i].deviations(0, at), frequency, size * 6.0 * poles[i].frequency_std);
      EXPECT_NEAR(poles[i].deviations(1, at), damping, size * 6.0 * poles[i].damping_std);
      const MatrixXd shapes = shape_deviations(subspace, poles[i], options);
      const Eigen::VectorXcd shape = (up[i].shape - down[i].shape) / (2.0 * step);
      const double scatter = shapes.norm() / std::sqrt(static_cast<double>(shapes.size()));
      EXPECT_LT((shapes.col(at).head(4) - shape.real()).norm(), 0.03 * scatter);
      EXPECT_LT((shapes.col(at).tail(4) - shape.imag()).norm(), 0.03 * scatter);
    }
  }
}

TEST_P(PoleDeviations, ParticipationsAreSharesOfTheVariance) {
  const auto poles = poles_of_order(moved(0, 0.0), order, options);
  const VectorXd expected = structure.participations();
  for (std::size_t i = 0; i < poles.size(); ++i)  // deviation of a variance over 600 s: some per cent
    EXPECT_NEAR(poles[i].participation, expected[static_cast<Index>(i)], 0.15 * expected[static_cast<Index>(i)]);
}

INSTANTIATE_TEST_SUITE_P(By, PoleDeviations, ::testing::Values(SubspaceMethod::covariance, SubspaceMethod::data),
                         [](const auto& method) {
                           return method.param == SubspaceMethod::data ? "Data" : "Covariance";
                         });

// The singular vectors are those of the future's projection onto the past in the data matrix itself: Y_f Y_p^T (Y_p
// Y_p^T)^-1 Y_p, whose columns at the record's ends differ a little.
TEST(Subspace, ByDataIsTheProjectionOfTheFutureOntoThePast) {
  constexpr Index rows = 6, order = 8, samples = 40000;
  const auto record = test::ambient_record(test::shear_frame(4, 20.0, 0.01), 64.0, samples, 3, 0.05);
  const VectorXd scale = record.values.rowwise().norm() / std::sqrt(double(samples));
  const MatrixXd y = scale.cwiseInverse().asDiagonal() * record.values;
  const Index columns = samples - 2 * rows;
  MatrixXd future(4 * rows, columns), past(4 * rows, columns);
  for (Index i = 0; i < rows; ++i) {
    future.middleRows(4 * i, 4) = y.middleCols(rows + i, columns);
    past.middleRows(4 * i, 4) = y.middleCols(rows - 1 - i, columns);
  }
  const MatrixXd cross = future * past.transpose();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> projected(
      cross * (past * past.transpose()).llt().solve(cross.transpose()) / double(columns));
  const auto correlations = output_correlations(record.values, {0, 1, 2, 3}, 2 * rows - 1, 40, 1);
  const auto found = make_subspace(correlations, SubspaceMethod::data, rows, order, scale, {0, 1, 2, 3}, 1);
  for (Index i = 0; i < order; ++i) {
    EXPECT_NEAR(found.values[i], std::sqrt(projected.eigenvalues().reverse()[i]), 2e-3 * found.values[0]);
  }
  const MatrixXd space = projected.eigenvectors().rightCols(order);
  const MatrixXd outside = found.left.leftCols(order) - space * (space.transpose() * found.left.leftCols(order));
  EXPECT_LT(outside.norm(), 0.02);
}

// Means of blocks of a first-order autoregression: blocks that are as long as two decays.
TEST(BlockCovariance, IsWithoutBiasWhereBlocksAreCorrelated) {
  constexpr int blocks = 100, length = 20, repetitions = 400;
  const double decay = std::exp(-0.1), exact = 1.0 / ((1.0 - decay) * (1.0 - decay)) / (blocks * length);
  double mean = 0.0, plain = 0.0;
  RandomStream random(5, "autoregression");
  for (int repetition = 0; repetition < repetitions; ++repetition) {
    MatrixXd series(1, blocks);
    double x = 0.0;
    for (int k = -200; k < 0; ++k) x = decay * x + random.normal();
    for (int block = 0; block < blocks; ++block) {
      double sum = 0.0;
      for (int k = 0; k < length; ++k) sum += x = decay * x + random.normal();
      series(0, block) = sum / length;
    }
    series.array() -= series.mean();
    mean += block_covariance(series, 2).of_mean(0, 0) / repetitions;
    plain += series.squaredNorm() / (blocks * (blocks - 1)) / repetitions;
  }
  EXPECT_NEAR(mean / exact, 1.0, 0.06);  // deviation of the mean 1.5 %, bias of the floor 2 %
  EXPECT_LT(plain / exact, 0.65);        // of blocks that count as independent
}

TEST(ShapeMeasures, TellPhasesAndAgreement) {
  Eigen::VectorXcd real(3), turning(3);
  real << std::complex(1.0, 0.0), std::complex(-2.0, 0.0), std::complex(0.5, 0.0);
  turning << 1.0, std::polar(1.0, 2.0943951023931953), std::polar(1.0, -2.0943951023931953);
  EXPECT_NEAR(phase_collinearity(real * std::polar(3.0, 0.7)), 1.0, 1e-14);
  EXPECT_NEAR(phase_collinearity(turning), 0.0, 1e-14);
  EXPECT_NEAR(mac(real, real * std::polar(0.2, 2.0)), 1.0, 1e-14);
  EXPECT_EQ(mac(real, Eigen::VectorXcd::Zero(3)), 0.0);
}

}  // namespace
}  // namespace kalfem
