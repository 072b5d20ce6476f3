// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <iostream>
#include <limits>

#include "base/figures.hpp"
#include "estimation/chain_model.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

class PaperChain : public testing::Test {
protected:
  static void SetUpTestSuite() { reference_ = new ConvergedSolution(chain().reference(20.0)); }
  static void TearDownTestSuite() { delete reference_; }
  static const Chain& chain() {
    static const Chain the_chain;
    return the_chain;
  }
  static FilterInput record(Index samples, std::uint64_t seed = 1) {
    auto record = Chain::record(*reference_, seed);
    record.measured.values.conservativeResize(Eigen::NoChange, samples);
    record.inputs.conservativeResize(Eigen::NoChange, samples);
    return record;
  }
  static AugmentedModel augmented_model(const AugmentedModelOptions& options) {
    return AugmentedModel(chain().model.system(), chain().sensors, {}, options);
  }
  static ConvergedSolution* reference_;
};
ConvergedSolution* PaperChain::reference_ = nullptr;

TEST_F(PaperChain, ReferenceConverged) {
  EXPECT_TRUE(reference_->converged);
  // what was asked for
  EXPECT_LE(reference_->last_change, 2e-3);
}

/// The default filter against the plain one, final estimates in the plain one's standard deviations: a tenth is far
/// less than what a test of either could tell.
TEST_F(PaperChain, PartiallyLinearFilterEndsWhereThePlainOneDoes) {
  auto options = chain().options();
  options.substeps = 4;
  const auto all = record(20001);
  const auto plain = estimate(augmented_model(options), all, {.filter = FilterKind::unscented});
  options.coordinates = StateCoordinates::modal;
  const auto fast =
      estimate(augmented_model(options), all, {.filter = FilterKind::partially_linear, .state_deviations = false});
  ASSERT_FALSE(fast.failure) << fast.failure->reason;
  const VectorXd deviation = plain.unknowns.deviation.rightCols(1);
  const VectorXd apart = (fast.unknowns.mean.rightCols(1) - plain.unknowns.mean.rightCols(1)).cwiseQuotient(deviation);
  std::cout << "apart by " << apart.transpose() << " standard deviations; " << 1e6 * plain.time.filter() / 20001
            << " and " << 1e6 * fast.time.filter() / 20001 << " us/step\n";
  test::expect_figure("chain.partially_linear.mu_k1.apart", std::abs(apart[0]));
  test::expect_figure("chain.partially_linear.mu_c1.apart", std::abs(apart[1]));
  EXPECT_LT(apart.cwiseAbs().maxCoeff(), 0.1);
  // found 8e-4: the sigma points of fewer channels
  EXPECT_LT((fast.unknowns.deviation.rightCols(1).cwiseQuotient(deviation).array() - 1.0).abs().maxCoeff(), 2e-3);
}

TEST_F(PaperChain, BothParametersAreIdentifiedFromFourNoisySensors) {
  for (const auto transform : {TransformKind::log, TransformKind::none}) {
    const auto observed = augmented_model(chain().options(transform));
    const auto all = record(20001);
    const auto result = estimate(observed, all, {.monitored = chain().displacement_of_dof_4()});
    ASSERT_FALSE(result.failure) << result.failure->reason;
    const VectorXd estimate = result.unknowns.mean.rightCols(1), deviation = result.unknowns.deviation.rightCols(1);
    const VectorXd early = result.unknowns.mean.col(2000);
    const auto consistency =
        summarise_consistency(result.nis, result.measured, result.innovation, all.noise.diagonal().cwiseSqrt(), 0);
    const Index from = 2000, count = 18001;
    const double displacement = nrmse(result.monitored.mean.row(0).tail(count).transpose(),
                                      reference_->simulation.trajectory.displacement.row(3).tail(count).transpose());
    std::cout << "mu_k1 " << estimate[0] << " +- " << deviation[0] << " (" << early[0] << " at 2 s), mu_c1 "
              << estimate[1] << " +- " << deviation[1] << " (" << early[1] << " at 2 s), mean NIS "
              << consistency.mean_nis << ", in 95 % band " << consistency.fraction_in_95 << ", DOF 4 NRMSE "
              << displacement << ", " << 1e6 * result.time.filter() / 20001 << " us/step, reference substeps "
              << reference_->substeps << "\n";
    // found .08 and .26 %, within one deviation of the noise (.1 and .2 %)
    EXPECT_NEAR(estimate[0], Chain::mu_k1, 0.0025 * Chain::mu_k1);
    EXPECT_NEAR(estimate[1], Chain::mu_c1, 0.006 * Chain::mu_c1);
    // three deviations: one record's noise
    EXPECT_LT(std::abs(estimate[0] - Chain::mu_k1), 3 * deviation[0]);
    EXPECT_LT(std::abs(estimate[1] - Chain::mu_c1), 3 * deviation[1]);
    // after a tenth of the record: found 1.5 and .5 %
    EXPECT_NEAR(early[0], Chain::mu_k1, 0.03 * Chain::mu_k1);
    EXPECT_NEAR(early[1], Chain::mu_c1, 0.02 * Chain::mu_c1);
    // 80004 squared innovations: the mean of a consistent filter has a standard deviation of 0.5 %.
    EXPECT_NEAR(consistency.mean_nis, 4.0, 0.06);
    EXPECT_NEAR(consistency.fraction_in_95, 0.95, 0.005);  // 20,000 samples scatter by .15 %
    // 20,000 samples scatter by .5 %
    EXPECT_LT((consistency.innovation_to_noise.array() - 1.0).abs().maxCoeff(), 0.02);
    // The augmented model's forces are straight over 1 ms, the suspension's relaxation takes 3 ms: that leaves one per
    // cent.
    EXPECT_LT(displacement, 0.015);
    EXPECT_EQ(result.monitored.mean.cols(), from + count);
  }
}

TEST_F(PaperChain, BiasOfTheParametersIsOfSecondOrderInTheAugmentedModelsStep) {
  const auto bias = [&](double rate) {
    const auto reference = chain().reference(10.0, rate);
    auto exact = Chain::record(reference, 1);
    exact.measured.values = reference.sensors;  // without noise what is left is bias
    Chain::thin_out(exact, static_cast<Index>(rate / Chain::rate));
    const auto result = estimate(augmented_model(chain().options(TransformKind::log, rate)), exact, {});
    EXPECT_FALSE(result.failure);
    return std::abs(result.unknowns.mean(0, exact.measured.values.cols() - 1) - Chain::mu_k1);
  };
  const double coarse = bias(1000.0), fine = bias(4000.0);
  std::cout << "bias of mu_k1: " << coarse << " N at 1 ms, " << fine << " N at 0.25 ms\n";
  // found .3 %
  EXPECT_LT(coarse, 0.005 * Chain::mu_k1);
  // found 1/77; 16 is second order, of a smooth law
  EXPECT_LT(fine, coarse / 16);
}

TEST_F(PaperChain, SquareRootFormGivesTheSameEstimates) {
  const auto observed = augmented_model(chain().options());
  const auto part = record(400);
  for (const double alpha : {1.0, 0.6}) {  // with a centre weight of 0 and with a negative one
    const UnscentedOptions unscented{.alpha = alpha};
    const auto plain = estimate(observed, part, {.filter = FilterKind::unscented, .unscented = unscented});
    const auto root = estimate(observed, part, {.filter = FilterKind::unscented_square_root, .unscented = unscented});
    ASSERT_FALSE(plain.failure) << plain.failure->reason;
    ASSERT_FALSE(root.failure) << root.failure->reason;
    // in standard deviations; P - J J^T loses digits that the root keeps
    const double error =
        ((plain.state.mean - root.state.mean).array() / plain.state.deviation.array()).abs().maxCoeff();
    EXPECT_LT(error, 1e-8) << alpha;
    EXPECT_LT((plain.state.deviation.array() / root.state.deviation.array() - 1.0).abs().maxCoeff(), 1e-8) << alpha;
    EXPECT_LT(((plain.unknowns.mean - root.unknowns.mean).array() / plain.unknowns.mean.array()).abs().maxCoeff(),
              2e-10);
    EXPECT_NEAR(plain.log_likelihood, root.log_likelihood, 1e-12 * std::abs(plain.log_likelihood));
  }
}

TEST_F(PaperChain, ExtendedFilterFindsThemFromANearerGuess) {
  auto options = chain().options(TransformKind::none);
  for (auto& unknown : options.unknowns) unknown.initial *= 1.2, unknown.deviation *= 0.6;
  const auto result = estimate(augmented_model(options), record(8001), {.filter = FilterKind::extended});
  ASSERT_FALSE(result.failure) << result.failure->reason << " at " << result.failure->time;
  // found .5 and .2 %: two deviations of a shorter record
  EXPECT_NEAR(result.unknowns.mean(0, 8000), Chain::mu_k1, 0.015 * Chain::mu_k1);
  EXPECT_NEAR(result.unknowns.mean(1, 8000), Chain::mu_c1, 0.01 * Chain::mu_c1);
}

TEST_F(PaperChain, KnownStatesStayKnownUntilTheParametersMoveThem) {
  auto options = chain().options();
  options.prior.displacement_deviation.setZero();
  options.prior.velocity_deviation.setZero();
  for (const auto kind : {FilterKind::unscented, FilterKind::unscented_square_root}) {
    const auto result = estimate(augmented_model(options), record(3000), {.filter = kind});
    ASSERT_FALSE(result.failure) << result.failure->reason << " at " << result.failure->time;
    EXPECT_EQ(result.state.deviation.col(0).head(22).norm(), 0.0);
    EXPECT_GT(result.state.deviation.col(2999).head(22).minCoeff(), 0.0);
    // found 1.3 %: three seconds of the record
    EXPECT_NEAR(result.unknowns.mean(0, 2999), Chain::mu_k1, 0.04 * Chain::mu_k1);
  }
}

TEST_F(PaperChain, SecondPassStartsFromTheFirst) {
  auto options = chain().options();
  const auto part = record(3000);
  options.keep_initial_state = true;
  const auto observed = augmented_model(options);
  const auto first = estimate(observed, part, {}), second = estimate(observed, part, {.passes = 2});
  ASSERT_FALSE(first.failure) << first.failure->reason << " at " << first.failure->time;
  ASSERT_FALSE(second.failure) << second.failure->reason;
  // The first update at rest moves nothing: the second pass begins where the first ended.
  EXPECT_NEAR(second.unknowns.mean(0, 0), first.unknowns.mean(0, 2999), 1e-12 * Chain::mu_k1);
  // found 1.4 %
  EXPECT_NEAR(second.unknowns.mean(0, 2999), Chain::mu_k1, 0.04 * Chain::mu_k1);
  EXPECT_GT(second.log_likelihood, first.log_likelihood);
}

TEST_F(PaperChain, RecordsThatDoNotFitAreRefused) {
  const auto observed = augmented_model(chain().options());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto refuses = [&](const std::function<void(FilterInput&)>& spoil, const EstimationOptions& options = {}) {
    auto spoilt = record(10);
    spoil(spoilt);
    EXPECT_THROW(estimate(observed, spoilt, options), InvalidInput);
  };
  refuses([](FilterInput& r) { r.measured.values.conservativeResize(3, Eigen::NoChange); });
  refuses([](FilterInput& r) { r.inputs.conservativeResize(Eigen::NoChange, 9); });
  refuses([&](FilterInput& r) { r.inputs(0, 4) = nan; });
  refuses([&](FilterInput& r) { r.noise(0, 0) = nan; });
  refuses([](FilterInput& r) { r.noise(0, 0) = -1.0; });
  refuses([](FilterInput& r) { r.measured.values.resize(4, 0), r.inputs.resize(3, 0); });
  refuses([](FilterInput&) {}, {.passes = 0});
  for (const UnscentedOptions& bad : {UnscentedOptions{0.0, 2.0, 0.0}, UnscentedOptions{nan, 2.0, 0.0},
                                      UnscentedOptions{1.0, nan, 0.0}, UnscentedOptions{1.0, 2.0, -24.0}})
    refuses([](FilterInput&) {}, {.unscented = bad});
}

TEST_F(PaperChain, MeasurementsThatAreNotANumberAreLeftOut) {
  const auto observed = augmented_model(chain().options());
  auto gaps = record(1500);
  gaps.measured.values.row(2).setConstant(std::numeric_limits<double>::quiet_NaN());
  gaps.measured.values.middleCols(700, 100).setConstant(std::numeric_limits<double>::infinity());
  const auto result = estimate(observed, gaps, {});
  ASSERT_FALSE(result.failure) << result.failure->reason;
  EXPECT_TRUE(result.state.mean.allFinite());
  EXPECT_EQ(result.measured[10], 3);
  EXPECT_EQ(result.measured[750], 0);
}

TEST_F(PaperChain, ModelThatCannotBeEvaluatedEndsTheRunByName) {
  auto options = chain().options(TransformKind::none);
  options.unknowns[0].deviation = 1e300;
  const auto result = estimate(augmented_model(options), record(50), {});
  ASSERT_TRUE(result.failure);
  EXPECT_FALSE(result.failure->reason.empty());
  EXPECT_TRUE(std::isnan(result.state.mean(0, 49)));
}

TEST_F(PaperChain, UnsuitableAugmentedModelsAreRefused) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto refuses = [&](const std::function<void(AugmentedModelOptions&)>& spoil) {
    auto options = chain().options();
    spoil(options);
    EXPECT_THROW((void)augmented_model(options), InvalidInput);
  };
  refuses([](auto& o) { o.unknowns[0].initial = -1.0; });
  refuses([&](auto& o) { o.unknowns[0].initial = nan; });
  refuses([](auto& o) { o.unknowns[0].deviation = 0.0; });
  refuses([](auto& o) { o.unknowns[0].random_walk = INFINITY; });
  refuses([](auto& o) { o.unknowns[0].targets = {{0, 6}}; });
  refuses([](auto& o) { o.unknowns[0].targets = {}; });
  refuses([](auto& o) { o.unknowns[0].transform = {TransformKind::logit, 30.0, 40.0}; });
  refuses([](auto& o) { o.unknowns[0].transform = {TransformKind::logit, 0.0, INFINITY}; });
  refuses([](auto& o) { o.prior.displacement_deviation[3] = -1.0; });
  refuses([&](auto& o) { o.prior.velocity_deviation[3] = nan; });
  refuses([&](auto& o) { o.prior.mean.velocity[3] = nan; });
  refuses([](auto& o) { o.prior.sensor_state_deviation = -1.0; });
  refuses([&](auto& o) { o.process_noise.acceleration[0] = nan; });
  refuses([](auto& o) { o.process_noise.acceleration.resize(3); });
  refuses([](auto& o) { o.step = 0.0; });
  refuses([&](auto& o) { o.step = nan; });
}

}  // namespace
}  // namespace kalfem
