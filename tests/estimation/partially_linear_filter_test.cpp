// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/partially_linear/partially_linear_filter.hpp"

#include <gtest/gtest.h>

#include "estimation/brute_force.hpp"
#include "estimation/chain_model.hpp"
#include "kalfem/estimation/covariance_filter.hpp"
#include "kalfem/estimation/process_model.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A system with its sensors and all that an augmented model of it needs.
struct Setting {
  std::string name;
  CoupledModel model;
  OutputMap sensors;
  std::vector<MeasurementChain> chains;
  AugmentedModelOptions options;

  [[nodiscard]] AugmentedModel augmented_model(StateCoordinates coordinates) const {
    AugmentedModelOptions chosen = options;
    chosen.coordinates = coordinates;
    return AugmentedModel(model.system(), sensors, chains, chosen);
  }
};

Setting chain(
    const std::string& name,
    const std::function<void(AugmentedModelOptions&)>& change = [](AugmentedModelOptions&) {}) {
  const Chain the_chain;
  auto options = the_chain.options();
  options.process_noise.acceleration.setConstant(0.02);
  change(options);
  return {name, the_chain.model, the_chain.sensors, {}, options};
}

MeasurementChain low_pass(int order, double cut_off) {
  return MeasurementChain({{FilterSection{.order = order, .cutoff = cut_off}}});
}

/// Four Butterworth filters of one kind, repeated eigenvalues, behind the chain's accelerometers.
Setting filtered_sensors() {
  auto setting = chain("filtered sensors");
  setting.chains.assign(4, low_pass(3, 150.0));
  return setting;
}

/// A free body, with its rigid-body mode, on a Bouc-Wen suspension with an internal state and an unknown stiffness.
Setting hysteretic() {
  auto model = quarter_chain(
      10, {{"suspension", "wheel.w", "body.1", make_law("bouc_wen"), values({4e3, 0.3, 1.0, 500.0, 300.0, 1.0, 3.0})}},
      {{"road", InputKind::base_displacement, "wheel.ground"}});
  auto setting = chain("hysteretic");
  setting.options.unknowns.resize(1);
  setting.options.unknowns[0].targets = {{0, 0}};
  setting.options.unknowns[0].initial = 4e3;
  setting.options.unknowns[0].deviation = 1e3;
  setting.options.process_noise.connector_states = values({1e-4});
  setting.options.prior.connector_state_deviation = values({1e-4});
  setting.options.prior.mean = at_rest(11, 1);
  setting.sensors = make_outputs(
      model, {Chain::acceleration("2"), Chain::acceleration("4"), Chain::acceleration("6"), Chain::acceleration("10")});
  setting.model = std::move(model);
  return setting;
}

std::vector<Setting> settings() {
  std::vector<Setting> all;
  all.push_back(chain("plain"));
  all.push_back(chain("four substeps", [](AugmentedModelOptions& options) { options.substeps = 4; }));
  all.push_back(chain("kept initial state", [](AugmentedModelOptions& options) { options.keep_initial_state = true; }));
  all.push_back(chain("measured base acceleration", [](AugmentedModelOptions& options) {
    options.inputs = {{InputModel::integrated}};
    options.process_noise.input.setConstant(0.1);
    options.prior.input_deviation.setConstant(1e-4);
    options.prior.input_rate_deviation.setConstant(1e-2);
  }));
  all.push_back(filtered_sensors());
  all.push_back(hysteretic());
  return all;
}

FilterInput record_of(const Setting& setting, Index samples) {
  const auto road = make_random({.rms = 3e-3, .lower = 0.5, .upper = 30.0, .duration = 5.0, .seed = 7});
  FilterInput record;
  record.inputs = road->sample(0.0, setting.options.step, samples).matrix().transpose();
  RandomStream random(3, "measurements");
  record.measured.values =
      MatrixXd::NullaryExpr(setting.sensors.size(), samples, [&] { return 2.0 * random.normal(); });
  record.noise = 0.25 * MatrixXd::Identity(setting.sensors.size(), setting.sensors.size());
  return record;
}

/// Largest difference of two states in standard deviations, and of two covariances relative to them.
double difference(const Filter& a, const Filter& b) {
  const MatrixXd p = a.covariance(), q = b.covariance();
  const VectorXd deviation = p.diagonal().cwiseMax(0.0).cwiseSqrt();
  const VectorXd scale = (deviation.array() > 0.0).select(deviation.cwiseInverse(), 0.0);
  const double mean = (scale.asDiagonal() * (a.mean() - b.mean())).cwiseAbs().maxCoeff();
  return std::max(mean, (scale.asDiagonal() * (p - q) * scale.asDiagonal()).cwiseAbs().maxCoeff());
}

LinearOutput connector_motion(const AugmentedModel& augmented_model) { return augmented_model.form().motion(); }

/// The estimates of a partially linear filter, with dense matrices.
std::unique_ptr<Filter> dense_filter(const FilterModel& model) {
  return std::make_unique<CovarianceFilter>(model, UnscentedTransform({.points = SigmaPoints::of_arguments}));
}

class TiledFilter : public testing::TestWithParam<std::size_t> {};

/// The same formulas on dense matrices with a Cholesky factor a step. Tolerance: 1e-7 of the standard deviations after
/// 300 steps of a filter that measures little of some states; rounding alone parts them.
TEST_P(TiledFilter, EqualsTheDenseFilterStepByStep) {
  const Setting setting = settings()[GetParam()];
  const AugmentedModel augmented_model = setting.augmented_model(StateCoordinates::modal);
  const FilterInput record = record_of(setting, 300);
  ProcessModel transition(augmented_model), dense_transition(augmented_model);
  MeasurementModel measurement(augmented_model, sensor_outputs), dense_measurement(augmented_model, sensor_outputs);
  MeasurementModel seen(augmented_model, connector_motion), dense_seen(augmented_model, connector_motion);
  const MatrixXd& Q = augmented_model.process_noise();
  const auto tiled = make_filter(FilterKind::partially_linear, {transition, Q, measurement, record.noise, &seen});
  const auto dense = dense_filter({dense_transition, Q, dense_measurement, record.noise, &dense_seen});
  ASSERT_NE(dynamic_cast<PartiallyLinearFilter*>(tiled.get()), nullptr) << setting.name;
  tiled->reset(augmented_model.prior());
  dense->reset(augmented_model.prior());
  Innovation a, b;
  double worst = 0.0;
  for (Index k = 1; k < record.measured.samples(); ++k) {
    for (auto* map : {&transition, &dense_transition}) map->set_inputs(record.inputs.col(k - 1), record.inputs.col(k));
    ASSERT_EQ(tiled->predict(), FilterOutcome::usable) << setting.name << k;
    ASSERT_EQ(dense->predict(), FilterOutcome::usable);
    VectorXd y = record.measured.values.col(k);
    if (k % 50 > 40) y[0] = y[2] = NAN;  // samples that are missing
    if (k % 7 == 0) {                    // predictions in a row
      worst = std::max(worst, difference(*tiled, *dense));
      continue;
    }
    for (auto* map : {&measurement, &dense_measurement}) map->set_inputs(record.inputs.col(k));
    for (int repeat = 0; repeat < (k % 11 == 0 ? 2 : 1); ++repeat) {  // and updates in a row
      ASSERT_EQ(tiled->update(y, a), FilterOutcome::usable);
      ASSERT_EQ(dense->update(y, b), FilterOutcome::usable);
      // rounding of the covariances of hundreds of steps: found 7e-11 of it
      EXPECT_NEAR(a.nis, b.nis, 1e-8 * (1.0 + b.nis));
      EXPECT_NEAR(a.log_likelihood, b.log_likelihood, 1e-8 * (1.0 + std::abs(b.log_likelihood)));
    }
    if (k % 3 == 0) {
      VectorXd mean, deviation, dense_mean, dense_deviation;
      for (auto* map : {&seen, &dense_seen}) map->set_inputs(record.inputs.col(k));
      ASSERT_EQ(tiled->observe(mean, &deviation), FilterOutcome::usable);
      ASSERT_EQ(dense->observe(dense_mean, &dense_deviation), FilterOutcome::usable);
      // found .16 of it where the mean is nearly zero, 1e-9 elsewhere
      EXPECT_LT((mean - dense_mean).norm(), 1e-7 * dense_mean.norm());
      EXPECT_LT((deviation - dense_deviation).norm(), 1e-8 * dense_deviation.norm());
    }
    worst = std::max(worst, difference(*tiled, *dense));
    const VectorXd deviation = dense->standard_deviation();
    EXPECT_LT((tiled->standard_deviation() - deviation).norm(), 1e-9 * deviation.norm());
  }
  RecordProperty("worst", std::to_string(worst));
  EXPECT_LT(worst, 5e-9) << setting.name;  // found 3e-10 standard deviations
}

/// The estimate in modal coordinates is that in physical ones: the sigma points of w do not depend on coordinates.
TEST_P(TiledFilter, EstimatesDoNotDependOnTheCoordinates) {
  const Setting setting = settings()[GetParam()];
  const FilterInput record = record_of(setting, 200);
  const auto modal =
      estimate(setting.augmented_model(StateCoordinates::modal), record, {.filter = FilterKind::partially_linear});
  const auto physical =
      estimate(setting.augmented_model(StateCoordinates::physical), record, {.filter = FilterKind::partially_linear});
  ASSERT_FALSE(modal.failure) << modal.failure->reason;
  ASSERT_FALSE(physical.failure) << physical.failure->reason;
  for (Index i = 0; i < modal.state.mean.rows(); ++i) {
    // rounding of the modes and of the covariances in other coordinates: found 2e-9
    EXPECT_LT((modal.state.mean.row(i) - physical.state.mean.row(i)).norm(), 1e-7 * physical.state.mean.row(i).norm())
        << setting.name << " state " << i;
    EXPECT_LT((modal.state.deviation.row(i) - physical.state.deviation.row(i)).norm(),
              1e-7 * physical.state.deviation.row(i).norm())
        << setting.name << " state " << i;
  }
  EXPECT_NEAR(modal.log_likelihood, physical.log_likelihood, 1e-8 * std::abs(physical.log_likelihood));
}

/// A stable block diagonal matrix with blocks of the given sizes, its states in an order of their own.
MatrixXd blocks_of(RandomStream& random, const std::vector<Index>& sizes) {
  Index n = 0, begin = 0;
  for (const Index size : sizes) n += size;
  MatrixXd A = MatrixXd::Zero(n, n);
  for (const Index size : sizes) {
    const MatrixXd block = random_matrix(random, size, size);
    A.block(begin, begin, size, size) = block * (0.9 / block.norm());
    begin += size;
  }
  Eigen::PermutationMatrix<-1> order(static_cast<int>(n));
  for (Index i = 0; i < n; ++i) order.indices()[i] = static_cast<int>((7 * i) % n);
  return order * A * order.transpose();
}

/// Blocks larger than a pair, whole tiles among them, and rows that pick a state or equal each other.
TEST(PartiallyLinearFilter, BlocksOfAnySizeUpToATile) {
  RandomStream random(5, "blocks");
  const auto phi = [](const VectorXd& w) { return values({std::sin(w[0]) + 0.1 * w[2], w[1] * w[1]}); };
  const std::vector<Index> sizes{8, 5, 3, 4, 2, 2, 1, 1, 3, 2};
  FunctionMap transition = random_map(random, 31, 31, 3, 2, phi), measurement = random_map(random, 4, 31, 3, 2, phi);
  transition.linear = blocks_of(random, sizes);
  transition.selection *= 0.2;
  transition.gain *= 0.1;
  measurement.gain *= 0.1;
  measurement.selection.row(0) = transition.selection.row(0);
  transition.selection.row(2) = MatrixXd::Identity(31, 31).row(17);
  ASSERT_FALSE(tile_layout(MatrixXd::Ones(9, 9)));  // nine states that cannot be separated
  const MatrixXd root = random_matrix(random, 31, 31), noise_root = 0.1 * random_matrix(random, 31, 12);
  const Gaussian prior{random_matrix(random, 31, 1), root * root.transpose()};
  const FilterModel model{transition, noise_root * noise_root.transpose(), measurement, MatrixXd::Identity(4, 4)};
  const auto tiled = make_filter(FilterKind::partially_linear, model);
  const auto dense = dense_filter(model);
  ASSERT_NE(dynamic_cast<PartiallyLinearFilter*>(tiled.get()), nullptr);
  Innovation a, b;
  for (auto* filter : {tiled.get(), dense.get()}) filter->reset(prior);
  for (int k = 0; k < 40; ++k) {
    const VectorXd y = random_matrix(random, 4, 1);
    ASSERT_EQ(tiled->predict(), FilterOutcome::usable);
    ASSERT_EQ(dense->predict(), FilterOutcome::usable);
    ASSERT_EQ(tiled->update(y, a), FilterOutcome::usable);
    ASSERT_EQ(dense->update(y, b), FilterOutcome::usable);
    EXPECT_LT(difference(*tiled, *dense), 1e-10) << k;  // well-conditioned: rounding of forty steps
  }
}

/// Parts of a pass are summed in one order whoever takes them.
TEST(PartiallyLinearFilter, ResultsDoNotDependOnTheNumberOfThreads) {
  const int masses = 200;
  const auto model =
      quarter_chain(masses, {{"suspension", "wheel.w", "body.1", make_law("saturating"), saturating_parameters()}},
                    {{"road", InputKind::base_displacement, "wheel.ground"}});
  auto options = all_known(model.system(), 1e-3);
  options.coordinates = StateCoordinates::modal;
  options.unknowns = Chain().options().unknowns;
  options.prior.displacement_deviation.setConstant(1e-4);
  options.process_noise.acceleration.setConstant(0.01);
  const auto sensors = make_outputs(model, {Chain::acceleration("2"), Chain::acceleration("150")});
  const AugmentedModel augmented_model(model.system(), sensors, {}, options);
  const Chain chain;
  const MatrixXd inputs = chain.inputs(1000.0, 20);
  ProcessModel transition(augmented_model);
  MeasurementModel measurement(augmented_model, sensor_outputs);
  const FilterModel filter_model{transition, augmented_model.process_noise(), measurement, MatrixXd::Identity(2, 2)};
  std::vector<std::unique_ptr<Filter>> filters;
  for (const int threads : {1, 2, 3}) {
    filters.push_back(make_filter(FilterKind::partially_linear, filter_model, {}, threads));
    filters.back()->reset(augmented_model.prior());
    Innovation innovation;
    for (Index k = 1; k < inputs.cols(); ++k) {
      transition.set_inputs(inputs.col(k - 1), inputs.col(k));
      ASSERT_EQ(filters.back()->predict(), FilterOutcome::usable);
      measurement.set_inputs(inputs.col(k));
      ASSERT_EQ(filters.back()->update(VectorXd::Constant(2, 0.1 * double(k)), innovation), FilterOutcome::usable);
    }
    EXPECT_TRUE(filters.back()->mean() == filters.front()->mean()) << threads;
    EXPECT_TRUE(filters.back()->covariance() == filters.front()->covariance()) << threads;
  }
}

INSTANTIATE_TEST_SUITE_P(PartiallyLinear, TiledFilter, testing::Range(std::size_t{0}, settings().size()));

}  // namespace
}  // namespace kalfem
