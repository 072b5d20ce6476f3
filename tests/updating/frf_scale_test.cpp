// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <numbers>

#include "base/data_folder.hpp"
#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/random.hpp"
#include "kalfem/formats/tables/frf_table.hpp"
#include "kalfem/updating/frf_residual.hpp"
#include "kalfem/updating/gauss_newton.hpp"
#include "updating/chain_model.hpp"

// Responses whose size is not known: magnitudes in dB of an unknown reference, sensors that were not calibrated.

namespace kalfem {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::VectorXd;
using test::ChainModel;
using Kind = ChainModel::Kind;

std::shared_ptr<ChainModel> three_floors(double mass, double stiffness) {
  auto chain = std::make_shared<ChainModel>();
  chain->masses.assign(3, mass);
  chain->stiffnesses.assign(3, stiffness);
  chain->ratios = {0.004};
  for (std::size_t i = 0; i < 3; ++i) chain->parameters.push_back({Kind::stiffness, {i}});
  chain->parameters.push_back({Kind::ratio, {0}});
  return chain;
}

const std::vector<std::string> floors = {"floor1", "floor2", "floor3"};

VectorXd truth() { return Eigen::Vector4d(4.5e4, 5.5e4, 5e4, 0.004); }

/// Accelerances per force at a floor, each response times a factor of its own.
MeasuredFrf uncalibrated(const std::string& force, const Eigen::Vector3d& factors) {
  const auto chain = three_floors(5.0, 5e4);
  const FrfSet set{FrfInput::force, force, floors, ResponseQuantity::acceleration};
  const FrfEvaluation evaluation = FrfModel(chain, {set}, 40.0, truth()).evaluate(truth(), false);
  FrequencyResponse response;
  response.lines = VectorXd::LinSpaced(800, 0.05, 40.0);
  response.values.resize(800, 3);
  RandomStream stream(3, force);
  for (Index k = 0; k < 800; ++k) {
    response.values.row(k) = evaluation.at(0, 2.0 * std::numbers::pi * Complex(0.0, response.lines[k])).values;
    for (auto& value : response.values.row(k)) value *= 1.0 + 0.01 * Complex(stream.normal(), stream.normal());
    response.values.row(k) = response.values.row(k).cwiseProduct(factors.transpose().cast<Complex>());
  }
  return {"sim.csv", response, set};
}

std::vector<MeasuredFrf> two_inputs() {
  return {uncalibrated("floor3", {30.0, 30.0, 30.0}), uncalibrated("floor1", {0.002, 0.002, 0.002})};
}

class FreeScale : public testing::TestWithParam<std::tuple<FrfForm, FrfScale>> {};

TEST_P(FreeScale, ResidualsDoNotSeeTheSizeOfWhatIsMeasured) {
  const auto [form, scale] = GetParam();
  const auto chain = three_floors(5.0, 5e4);
  const VectorXd start = Eigen::Vector4d(5e4, 5e4, 5e4, 0.003);
  const FrfResidualOptions options{.form = form, .scale = scale, .bands = {{2, 35}}};
  const auto scaled = [&](double factor) {
    auto measured = two_inputs();
    measured[1].response.values *= factor;
    return FrfResidual(chain, measured, start, options).evaluate(start, false)->values;
  };
  EXPECT_LT((scaled(1000.0) - scaled(1.0)).norm(), 1e-13 * scaled(1.0).norm());  // rounding
}

/// The best factor moves with the parameters: derivatives hold that as well.
TEST_P(FreeScale, JacobianIsThatOfDifferences) {
  const auto [form, scale] = GetParam();
  const VectorXd values = Eigen::Vector4d(4.6e4, 5.5e4, 5.2e4, 0.005);
  const FrfResidual residual(three_floors(5.0, 5e4), two_inputs(), values,
                             {.form = form, .scale = scale, .bands = {{2, 35}}});
  const auto jacobian = residual.evaluate(values, true)->jacobian;
  for (Index p = 0; p < 4; ++p) {
    const VectorXd step = 1e-6 * values[p] * VectorXd::Unit(4, p);
    const VectorXd difference =
        (residual.evaluate(values + step, false)->values - residual.evaluate(values - step, false)->values) /
        (2e-6 * values[p]);
    // roundings over the step: found 2e-8 of the ratio, 4e-10 of stiffnesses
    EXPECT_LT((jacobian.col(p) - difference).norm(), 7e-8 * difference.norm()) << p;
  }
}

/// The factor is the one that a search over it would find.
TEST_P(FreeScale, TheFactorIsTheBest) {
  const auto [form, scale] = GetParam();
  const auto chain = three_floors(5.0, 5e4);
  const VectorXd values = Eigen::Vector4d(4.6e4, 5.5e4, 5.2e4, 0.005);
  const FrfResidualOptions free{.form = form, .scale = scale, .bands = {{2, 35}}};
  const FrfResidual residual(chain, two_inputs(), values, free);
  const auto scales = residual.scales(residual.model_responses(values));
  const auto cost_with = [&](double factor) {
    auto measured = two_inputs();
    for (std::size_t i = 0; i < 2; ++i)
      for (Index j = 0; j < 3; ++j) measured[i].response.values.col(j) /= scales[i][j] * factor;
    const FrfResidual fixed(chain, measured, values, {.form = form, .bands = {{2, 35}}, .check_size = false});
    return fixed.evaluate(values, false)->values.squaredNorm();
  };
  const double best = residual.evaluate(values, false)->values.squaredNorm();
  EXPECT_NEAR(cost_with(1.0), best, 1e-14 * best);  // rounding
  EXPECT_GT(cost_with(1.001), best);
  EXPECT_GT(cost_with(0.999), best);
}

INSTANTIATE_TEST_SUITE_P(Forms, FreeScale,
                         testing::Combine(testing::Values(FrfForm::log, FrfForm::log_magnitude),
                                          testing::Values(FrfScale::per_input, FrfScale::per_response)));

TEST(FrfScale, FindsStiffnessAndFactorsOfUncalibratedSensors) {
  const auto chain = three_floors(5.0, 5e4);
  auto measured = uncalibrated("floor3", {30.0, 0.5, 2.0});
  measured.response.values = measured.response.values.cwiseAbs().cast<Complex>().eval();
  measured.response.magnitudes_only = true;
  const VectorXd start = Eigen::Vector4d(4.8e4, 5.2e4, 5e4, 0.003);
  const FrfResidual residual(chain, {measured}, start,
                             {.form = FrfForm::log_magnitude, .scale = FrfScale::per_response, .bands = {{2, 35}}});
  std::vector<UpdatingParameter> parameters;
  for (Index i = 0; i < 3; ++i) parameters.push_back({"k" + std::to_string(i), "N/m", start[i], 2e4, 1e5});
  parameters.push_back({"ratio", "", start[3], 1e-3, 2e-2});
  const auto outcome = minimise(residual, parameters, {.search = {}, .start = start, .watch = {}});
  ASSERT_TRUE(outcome.usable()) << outcome.reason();
  // 1 % of noise on 660 lines leaves 4e-4 to a factor; found 3e-5 to stiffnesses, 8e-4 to the ratio and a factor
  for (Index i = 0; i < 3; ++i) EXPECT_NEAR(outcome.parameters[i] / truth()[i], 1.0, 8e-5) << i;
  EXPECT_NEAR(outcome.parameters[3], 0.004, 1e-5);
  const auto scales = residual.scales(residual.model_responses(outcome.parameters));
  EXPECT_NEAR(scales[0][0], 30.0, 0.05);
  EXPECT_NEAR(scales[0][1], 0.5, 4e-4);
  EXPECT_NEAR(scales[0][2], 2.0, 1.2e-3);
}

TEST(FrfScale, IsRefusedWhereDifferencesAreCompared) {
  const VectorXd start = truth();
  try {
    const FrfResidual residual(three_floors(5.0, 5e4), two_inputs(), start,
                               {.form = FrfForm::complex_difference, .scale = FrfScale::per_input});
    FAIL() << "it was accepted";
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("the scale of FRFs is free"), std::string::npos) << error.what();
  }
}

/// A power of omega is no factor: a displacement for an acceleration is refused all the same.
TEST(FrfScale, AWrongQuantityIsStillRefused) {
  auto measured = two_inputs();
  measured[0].set.quantity = ResponseQuantity::displacement;
  try {
    const FrfResidual residual(three_floors(5.0, 5e4), measured, truth(),
                               {.scale = FrfScale::per_input, .bands = {{2, 35}}});
    FAIL() << "it was accepted";
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("omega^2"), std::string::npos) << error.what();
  }
}

/// The measured bench frame in dB, without names and without phases, gives the storeys that its complex FRFs give.
TEST(FrfScale, SouthamptonFrameInDecibel) {
  const auto file = data_folder("southampton-3storey") / "ExpDataSo.csv";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "no " << file << "; set KALFEM_DATA to its parent's folder";
  const auto chain = three_floors(5.201, 4.6e4);
  MeasuredFrf measured{file.string(),
                       read_frf_table(file, {.content = FrfColumnContent::decibel}),
                       {FrfInput::force, "floor1", floors, ResponseQuantity::acceleration}};
  EXPECT_TRUE(measured.response.magnitudes_only);
  const VectorXd start = Eigen::Vector4d(4.4e4, 4.8e4, 4.8e4, 0.002);
  const FrfResidual residual(chain, {measured}, start,
                             {.form = FrfForm::log_magnitude, .scale = FrfScale::per_input, .bands = {{4, 32}}});
  std::vector<UpdatingParameter> parameters;
  for (Index i = 0; i < 3; ++i) parameters.push_back({"k" + std::to_string(i), "N/m", start[i], 2e4, 1e5});
  parameters.push_back({"ratio", "", start[3], 2e-4, 2e-2});
  const auto outcome = minimise(residual, parameters, {.search = {}, .start = start, .watch = {}});
  ASSERT_TRUE(outcome.usable()) << outcome.reason();
  // As StoreysAreFoundFromBeamTheory finds them in the complex FRFs of three inputs, to 60 N/m.
  EXPECT_NEAR(outcome.parameters[0], 42.7e3, 150.0);
  EXPECT_NEAR(outcome.parameters[1], 48.4e3, 150.0);
  EXPECT_NEAR(outcome.parameters[2], 38.0e3, 150.0);
  const double scale = residual.scales(residual.model_responses(outcome.parameters))[0][0];
  EXPECT_NEAR(scale, 1.0, 0.03);  // calibrations of the runs differ by as much
  std::printf("storeys %.1f %.1f %.1f N/m, ratio %.5f, factor %.3f\n", outcome.parameters[0], outcome.parameters[1],
              outcome.parameters[2], outcome.parameters[3], scale);
}

}  // namespace
}  // namespace kalfem
