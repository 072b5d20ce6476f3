// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/excess.hpp"

#include <gtest/gtest.h>

#include "estimation/linear_chain.hpp"
#include "kalfem/estimation/smoother/smoother.hpp"
#include "kalfem/system/signals/deterministic.hpp"

// Two constant forces as unknowns: what monitored quantities move by with them is the difference of filters and
// smoothers that know the forces, which hold no unknown at all. Exact, as all is linear.

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double h = 2e-3;  // [s]
constexpr Index samples = 300;

CoupledModel chain_with(double on_wheel, double on_body) {
  return quarter_chain(2,
                       {{"strut", "wheel.w", "body.1", make_law("linear"), values({5e3, 20.0})},
                        {"load_1", "wheel.ground", "wheel.w", make_law("preload"), values({on_wheel})},
                        {"load_2", "wheel.ground", "body.2", make_law("preload"), values({on_body})}},
                       {{"road", InputKind::base_displacement, "wheel.ground"}});
}

struct Loaded {
  explicit Loaded(double on_wheel = 0.0, double on_body = 0.0) : model(chain_with(on_wheel, on_body)) {}
  CoupledModel model;
  OutputMap sensors =
      make_outputs(model, {Chain::acceleration("1"), {"d", ObservedQuantity::displacement, {{"body.1", 1.0}}}});
  OutputMap monitored = make_outputs(model, {{"d2", ObservedQuantity::displacement, {{"body.2", 1.0}}},
                                             {"f", ObservedQuantity::connector_force, {{"strut", 1.0}}},
                                             {"f1", ObservedQuantity::connector_force, {{"load_1", 1.0}}}});

  [[nodiscard]] AugmentedModelOptions options(bool unknown) const {
    auto options = all_known(model.system(), h);
    options.prior.displacement_deviation.setConstant(1e-3);
    options.prior.velocity_deviation.setConstant(0.05);
    options.process_noise.acceleration.setConstant(0.5);
    if (unknown)
      options.unknowns = {{"on_wheel", "N", {{1, 0}}, {TransformKind::none}, 0.0, 40.0},
                          {"on_body", "N", {{2, 0}}, {TransformKind::none}, 0.0, 20.0}};
    return options;
  }
};

FilterInput record() {
  FilterInput input{{.values = MatrixXd(2, samples)}, {}, Eigen::Vector2d(0.04, 1e-8).asDiagonal()};
  RandomStream random(5, "measured");
  for (Index k = 0; k < samples; ++k) input.measured.values.col(k) << random.normal(), 1e-3 * random.normal();
  input.inputs = make_sine({.amplitude = 3e-3, .frequency = 6.0})->sample(0.0, h, samples).matrix().transpose();
  return input;
}

struct Series {
  MatrixXd filtered, smoothed;
};

/// Monitored quantities of a filter that knows both forces.
Series known(FilterKind kind, double on_wheel, double on_body) {
  const Loaded chain(on_wheel, on_body);
  const AugmentedModel model(chain.model.system(), chain.sensors, {}, chain.options(false));
  const EstimationOptions run{.filter = kind, .monitored = chain.monitored};
  const auto found = estimate(model, record(), run);
  const auto smoothed = smooth(model, record(), run, found);
  return {found.monitored.mean, smoothed->monitored.mean};
}

class Excess : public testing::TestWithParam<FilterKind> {};

TEST_P(Excess, MovesMonitoredQuantitiesAsKnownForcesDo) {
  const MatrixXd factor{{3.0, 0.0}, {-1.0, 2.0}};  // [N]
  const Loaded chain;
  const AugmentedModel model(chain.model.system(), chain.sensors, {}, chain.options(true));
  const EstimationOptions run{
      .filter = GetParam(), .keep_unknowns = true, .excess = factor, .monitored = chain.monitored};
  const auto found = estimate(model, record(), run);
  const auto smoothed = smooth(model, record(), run, found);
  ASSERT_TRUE(smoothed.has_value());

  const auto nothing = known(GetParam(), 0.0, 0.0);
  MatrixXd filtered_variance = MatrixXd::Zero(3, samples), smoothed_variance = filtered_variance;
  for (Index column = 0; column < 2; ++column) {
    const auto moved = known(GetParam(), factor(0, column), factor(1, column));
    filtered_variance += (moved.filtered - nothing.filtered).cwiseAbs2();
    smoothed_variance += (moved.smoothed - nothing.smoothed).cwiseAbs2();
  }
  // Of the largest along the record: the sigma points of a linear force round at 1e-9 of it.
  const auto expect_near = [](const MatrixXd& added, const MatrixXd& variance) {
    const MatrixXd error = added - variance.cwiseSqrt();
    for (Index i = 0; i < error.rows(); ++i)
      EXPECT_LT(error.row(i).cwiseAbs().maxCoeff(), 1e-7 * variance.row(i).cwiseSqrt().maxCoeff()) << i;
  };
  expect_near(found.monitored_excess, filtered_variance);
  expect_near(smoothed->monitored_excess, smoothed_variance);
  EXPECT_GT(filtered_variance.row(0).maxCoeff(), 0.0);
}

INSTANTIATE_TEST_SUITE_P(Kinds, Excess,
                         testing::Values(FilterKind::unscented, FilterKind::unscented_square_root, FilterKind::extended,
                                         FilterKind::partially_linear, FilterKind::partially_linear_square_root));

TEST(Excess, OfAnotherNumberOfUnknownsIsRefused) {
  const Loaded chain;
  const AugmentedModel model(chain.model.system(), chain.sensors, {}, chain.options(true));
  EXPECT_THROW(estimate(model, record(), {.excess = MatrixXd::Ones(1, 1), .monitored = chain.monitored}), InvalidInput);
}

}  // namespace
}  // namespace kalfem
