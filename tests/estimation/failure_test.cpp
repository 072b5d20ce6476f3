// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/failure.hpp"

#include <gtest/gtest.h>

#include "estimation/linear_chain.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// A run that stopped at sample 60: quiet, with its unknown near its prior, unless a test says otherwise.
class Failure : public testing::Test {
protected:
  static constexpr Index samples = 100, stopped = 60;

  Failure() : options_(all_known(chain_.model.system(), LinearChainModel::h)) {
    options_.unknowns.push_back({"strut.k", "N/m", {{0, 0}}, {TransformKind::none, 0.0, 1.0}, 5e3, 1e3});
    input_.measured.sample_rate = 1.0 / LinearChainModel::h;
    input_.measured.channels = {{"a1", "", 1.0}, {"a2", "", 1.0}, {"d", "", 1.0}};
    input_.measured.values = MatrixXd::Zero(3, samples);
    input_.noise = MatrixXd::Identity(3, 3);
    result_.innovation = MatrixXd::Constant(3, samples, 0.5);
    result_.innovation_deviation = MatrixXd::Ones(3, samples);
  }

  EstimationFailure of(FilterOutcome outcome, FilterKind filter = FilterKind::partially_linear,
                       std::optional<Index> connector = {}) {
    const AugmentedModel model(chain_.model.system(), chain_.sensors, {}, options_);
    result_.state.mean = MatrixXd::Zero(model.layout().size(), samples);
    result_.state.mean.row(model.layout().unknown())
        .setConstant(options_.unknowns[0].transform.to_state(std::abs(value_)) * (value_ < 0.0 ? -1.0 : 1.0));
    result_.unknowns.mean = MatrixXd::Constant(1, samples, value_);
    return explain_failure({outcome, stopped, stopped, connector}, model, input_, {.filter = filter}, result_);
  }

  static bool holds(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

  LinearChainModel chain_;
  AugmentedModelOptions options_;
  FilterInput input_;
  EstimationResult result_;
  double value_ = 5.5e3;
};

constexpr auto lost_sign = FilterOutcome::covariance_not_positive_definite;

TEST_F(Failure, NamesTheChannelWhoseInnovationWasLarge) {
  result_.innovation(1, 58) = -40.0;
  const auto failure = of(lost_sign);
  EXPECT_EQ(failure.subject, "a2");
  EXPECT_DOUBLE_EQ(failure.time, 60 * LinearChainModel::h);
  EXPECT_TRUE(holds(failure.cause, "the innovation of 'a2' was 40 times as large as expected at 0.116 s"))
      << failure.cause;
  EXPECT_TRUE(holds(failure.remedy, "check sign, unit, place, clock and noise of 'a2'")) << failure.remedy;
  EXPECT_FALSE(holds(failure.remedy, "square_root")) << failure.remedy;
  EXPECT_TRUE(holds(failure.reason, to_string(lost_sign) + ": ")) << failure.reason;
}

TEST_F(Failure, NamesTheUnknownThatRanOff) {
  value_ = -9e3;
  const auto failure = of(FilterOutcome::model_not_evaluable, FilterKind::unscented, 0);
  EXPECT_EQ(failure.subject, "strut.k");
  EXPECT_TRUE(holds(failure.cause, "'strut.k' stood at -9000 N/m, 14 prior deviations")) << failure.cause;
  EXPECT_TRUE(holds(failure.cause, "connector 'strut'")) << failure.cause;
  EXPECT_TRUE(holds(failure.remedy, "bound 'strut.k' by transform: log")) << failure.remedy;
}

/// What the run does already is no remedy.
TEST_F(Failure, NamesNoRemedyThatTheRunHas) {
  EXPECT_TRUE(holds(of(lost_sign).remedy, "partially_linear_ukf_square_root"));
  EXPECT_TRUE(holds(of(lost_sign).cause, "rounding errors are likely"));
  for (const auto kind : {FilterKind::unscented_square_root, FilterKind::partially_linear_square_root})
    EXPECT_FALSE(holds(of(lost_sign, kind).remedy, "square_root"));
  options_.process_noise.acceleration.setZero();
  EXPECT_TRUE(holds(of(lost_sign).remedy, "give the model process noise")) << of(lost_sign).remedy;
  options_.process_noise.acceleration.setConstant(1e-3);
  EXPECT_TRUE(holds(of(lost_sign).remedy, "state more process noise")) << of(lost_sign).remedy;
  options_.unknowns[0].transform.kind = TransformKind::log;
  const auto bounded = of(FilterOutcome::model_not_evaluable, FilterKind::partially_linear, 1);
  EXPECT_FALSE(holds(bounded.remedy, "transform")) << bounded.remedy;
  EXPECT_EQ(bounded.subject, "tie");
  EXPECT_TRUE(holds(bounded.remedy, "substeps to more than 1")) << bounded.remedy;
}

TEST_F(Failure, NamesTheSensorWithoutNoise) {
  input_.noise(2, 2) = 0.0;
  const auto failure = of(FilterOutcome::innovation_not_positive_definite);
  EXPECT_EQ(failure.subject, "d");
  EXPECT_TRUE(holds(failure.cause, "'d' has no noise")) << failure.cause;
}

TEST_F(Failure, SaysNothingOfSamplesThatWereNotComputed) {
  result_.innovation(0, 70) = 500.0;  // behind the failure
  EXPECT_EQ(of(lost_sign).subject, "");
}

}  // namespace
}  // namespace kalfem
