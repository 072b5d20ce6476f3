// SPDX-License-Identifier: Apache-2.0
#include "kalfem/updating/frf_residual.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/random.hpp"
#include "kalfem/updating/gauss_newton.hpp"
#include "updating/chain_model.hpp"

namespace kalfem {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::VectorXd;
using test::ChainModel;
using Kind = ChainModel::Kind;

/// Equal floors of 5 kg on springs of 50 kN/m with damping of 0.2 %; every spring and the ratio are parameters.
std::shared_ptr<ChainModel> tower(std::size_t floors) {
  auto chain = std::make_shared<ChainModel>();
  chain->masses.assign(floors, 5.0);
  chain->stiffnesses.assign(floors, 5e4);
  chain->ratios = {0.002};
  for (std::size_t i = 0; i < floors; ++i) chain->parameters.push_back({Kind::stiffness, {i}});
  chain->parameters.push_back({Kind::ratio, {0}});
  return chain;
}

VectorXd truth_of(const ChainModel& chain) {
  VectorXd values = VectorXd::Constant(Index(chain.parameters.size()), 5e4);
  values[values.size() - 1] = chain.ratios[0];
  return values;
}

/// Simulated FRFs of one set with white noise, on lines wider apart than the half-power widths of the lower modes.
MeasuredFrf simulated(const std::shared_ptr<ChainModel>& chain, FrfSet set, double noise, std::uint64_t seed = 1) {
  const VectorXd truth = truth_of(*chain);
  const FrfEvaluation evaluation = FrfModel(chain, {set}, 50.0, truth).evaluate(truth, false);
  FrequencyResponse response;
  response.lines = VectorXd::LinSpaced(1600, 0.03125, 50.0);
  response.values.resize(1600, Index(set.outputs.size()));
  RandomStream stream(seed, "noise");
  for (Index k = 0; k < 1600; ++k) {
    response.values.row(k) = evaluation.at(0, 2.0 * std::numbers::pi * Complex(0.0, response.lines[k])).values;
    for (auto& value : response.values.row(k)) value += noise * Complex(stream.normal(), stream.normal());
  }
  return {"sim.csv", response, std::move(set)};
}

FrfSet top_force(std::size_t floors) {
  FrfSet set{FrfInput::force, "floor" + std::to_string(floors), {}, ResponseQuantity::acceleration};
  for (std::size_t i = 1; i <= floors; ++i) set.outputs.push_back("floor" + std::to_string(i));
  return set;
}

TEST(FrfResidual, IsZeroAtTheTruth) {
  const auto chain = tower(3);
  const VectorXd truth = truth_of(*chain);
  for (const FrfForm form : {FrfForm::log, FrfForm::log_magnitude, FrfForm::complex_difference}) {
    const FrfResidual residual(chain, {simulated(chain, top_force(3), 0.0)}, truth, {.form = form, .bands = {{2, 30}}});
    const auto value = residual.evaluate(truth, false);
    ASSERT_TRUE(value.has_value());
    EXPECT_LT(value->values.cwiseAbs().maxCoeff(), 1e-13);  // rounding of logarithms, over deviations of .01
    EXPECT_EQ(value->values.size(), residual.size());
    EXPECT_EQ(residual.size(), residual.compared()[0].lines.size() * 3 * (form == FrfForm::log_magnitude ? 1 : 2));
  }
}

// In the mean |r|^2 is its length where deviations are those of the noise.
TEST(FrfResidual, IsWhiteAtTheTruth) {
  const auto chain = tower(3);
  const VectorXd truth = truth_of(*chain);
  auto measured = simulated(chain, top_force(3), 0.002);
  measured.response.deviations = Eigen::MatrixXd::Constant(1600, 3, 0.002);
  for (const FrfForm form : {FrfForm::log, FrfForm::complex_difference}) {
    const FrfResidual residual(chain, {measured}, truth,
                               {.form = form, .bands = {{3, 30}}, .relative_deviation = 1e-9});
    const auto value = residual.evaluate(truth, false);
    // 5000 values: the mean square is known to 2 %; the numbers of the stream are the same everywhere.
    EXPECT_NEAR(value->values.squaredNorm() / double(residual.size()), 1.0, 0.02);
  }
}

TEST(FrfResidual, JacobianIsThatOfDifferences) {
  const auto chain = tower(3);
  VectorXd values = truth_of(*chain);
  values.head(3) << 4.6e4, 5.5e4, 5.2e4;
  const std::vector<MeasuredFrf> measured = {
      simulated(chain, top_force(3), 0.01),
      simulated(chain, {FrfInput::ground_acceleration, "base", {"floor2"}, ResponseQuantity::acceleration}, 0.01)};
  for (const FrfForm form : {FrfForm::log, FrfForm::log_magnitude, FrfForm::complex_difference})
    for (const double width : {0.0, 0.4}) {
      const FrfResidual residual(chain, measured, values, {.form = form, .bands = {{2, 30}}, .smoothing = width});
      const auto jacobian = residual.evaluate(values, true)->jacobian;
      for (Index p = 0; p < 4; ++p) {
        const double step = 1e-6 * values[p];
        VectorXd above = values, below = values;
        above[p] += step;
        below[p] -= step;
        const VectorXd difference =
            (residual.evaluate(above, false)->values - residual.evaluate(below, false)->values) / (2.0 * step);
        // Undamped but for 0.2 %: third derivatives are (1 / zeta)^2 times the relative step's square, 2.5e-7: found
        // 2e-8, and 3e-9 where smoothing widens the peaks.
        EXPECT_LT((jacobian.col(p) - difference).norm(), (width > 0.0 ? 1e-8 : 5e-8) * difference.norm())
            << p << " " << int(form);
      }
    }
}

// The measured FRF is carried to sigma + i omega by Poisson's integral: the model's is evaluated there.
TEST(FrfResidual, SmoothsBothAlike) {
  const auto chain = tower(3);
  chain->ratios = {0.005};  // half-power widths of at least two lines, so that sums over lines are integrals
  const VectorXd truth = truth_of(*chain);
  for (const double width : {0.1, 0.5, 2.0}) {
    const FrfResidual residual(chain, {simulated(chain, top_force(3), 0.0)}, truth,
                               {.bands = {{1, 35}}, .smoothing = width});
    const auto& compared = residual.compared()[0];
    const auto model = residual.model_responses(truth)[0];
    // What the kernel takes from beyond the last line is not known: width / (15 pi), 4 % at 35 Hz for 2 Hz.
    EXPECT_LT((compared.values - model).norm(), width / (15.0 * std::numbers::pi) * model.norm()) << width;
    EXPECT_GE(
        (compared.lines.tail(compared.lines.size() - 1) - compared.lines.head(compared.lines.size() - 1)).minCoeff(),
        0.5 * width - 1e-9);
  }
}

/// Springs wrong by up to exp(0.6) either way: frequencies by up to a third.
VectorXd poor_start(const VectorXd& truth, std::uint64_t seed) {
  RandomStream stream(seed, "start");
  const double common = 2.0 * stream.uniform() - 1.0;
  VectorXd start = truth;
  for (Index i = 0; i + 1 < truth.size(); ++i)
    start[i] *= std::exp(0.6 * (0.7 * common + 0.6 * (2.0 * stream.uniform() - 1.0)));
  start[truth.size() - 1] = 0.003;
  return start;
}

/// Largest relative error of the springs after a search with each of the widths.
double error_after(const std::shared_ptr<ChainModel>& chain, const MeasuredFrf& measured, VectorXd point,
                   const std::vector<double>& widths) {
  const VectorXd truth = truth_of(*chain);
  std::vector<UpdatingParameter> parameters;
  for (Index i = 0; i + 1 < point.size(); ++i)
    parameters.push_back({"stiffness" + std::to_string(i + 1), "N/m", point[i], 5e3, 5e5});
  parameters.push_back({"ratio", "", point[point.size() - 1], 2e-4, 5e-2});
  for (const double width : widths) {
    const FrfResidual residual(chain, {measured}, point, {.bands = {{1, 50}}, .smoothing = width, .check_size = false});
    point = minimise(residual, parameters, {.search = {}, .start = point, .watch = {}}).parameters;
  }
  return (point.array() / truth.array() - 1.0).head(point.size() - 1).abs().maxCoeff();
}

// Damping of 0.2 % and frequencies a third off: a search on the FRFs as they are misses in every third case, the
// continuation from a width of 2 Hz finds every one.
TEST(FrfResidual, ContinuationReachesLightlyDampedStructuresFromAfar) {
  const auto chain = tower(6);
  const MeasuredFrf measured = simulated(chain, top_force(6), 0.01);
  int missed = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const VectorXd start = poor_start(truth_of(*chain), seed);
    // noise of 1 % leaves 6e-5
    EXPECT_LT(error_after(chain, measured, start, smoothing_widths(2.0, 0.03)), 2e-4) << seed;
    missed += error_after(chain, measured, start, {0.0}) > 0.01 ? 1 : 0;
  }
  EXPECT_GT(missed, 0);
}

TEST(FrfResidual, HasNoValueWhereThereIsNoModel) {
  const auto chain = tower(2);
  const VectorXd truth = truth_of(*chain);
  const FrfResidual residual(chain, {simulated(chain, top_force(2), 0.0)}, truth, {.bands = {{2, 30}}});
  EXPECT_FALSE(residual.evaluate(Eigen::Vector3d(-5e4, 5e4, 0.002), true).has_value());
}

/// The messages of a residual that cannot be made.
std::string refusal(std::vector<MeasuredFrf> measured, const FrfResidualOptions& options = {.bands = {{2, 30}}}) {
  const auto chain = tower(3);
  try {
    FrfResidual(chain, std::move(measured), truth_of(*chain), options);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

TEST(FrfResidual, SaysWhatDoesNotFitTheModel) {
  const auto good = simulated(tower(3), top_force(3), 0.01);
  EXPECT_EQ(refusal({good}), "");
  const auto changed = [&](auto change) {
    MeasuredFrf frf = good;
    change(frf);
    return refusal({frf});
  };
  const auto contains = [](const std::string& text, const std::string& words) {
    EXPECT_NE(text.find(words), std::string::npos) << words << " in: " << text;
  };
  const auto scaled = [&](double factor) { return changed([&](MeasuredFrf& frf) { frf.response.values *= factor; }); };
  contains(scaled(1000.0), "larger than the model's by a factor of about 1e+03 everywhere");
  contains(scaled(1000.0), "mm/s^2");
  contains(scaled(1.0 / 9.81), "is it in g?");
  contains(scaled(9.81), "in kgf, or in g?");
  EXPECT_EQ(scaled(1.5), "");
  contains(changed([](MeasuredFrf& frf) { frf.set.quantity = ResponseQuantity::displacement; }), "omega^2");
  contains(changed([](MeasuredFrf& frf) { frf.set.quantity = ResponseQuantity::velocity; }), "omega^1");
  contains(changed([](MeasuredFrf& frf) { frf.set.outputs[1] = "flor2"; }), "did you mean 'floor2'");
  contains(changed([](MeasuredFrf& frf) { frf.set.outputs.pop_back(); }), "every column needs a point");
  contains(changed([](MeasuredFrf& frf) { frf.set.input = FrfInput::ground_acceleration; }), "no ground 'floor3'");
  contains(changed([](MeasuredFrf& frf) { std::swap(frf.response.lines[5], frf.response.lines[6]); }), "ascending");
  contains(changed([](MeasuredFrf& frf) { frf.response.values(700, 0) = NAN; }), "not finite");
  contains(changed([](MeasuredFrf& frf) { frf.response.values(700, 0) = 0.0; }), "exactly 0");
  contains(changed([](MeasuredFrf& frf) { frf.response.magnitudes_only = true; }), "log_magnitude");
}

TEST(FrfResidual, SaysWhichLinesDoNotFit) {
  auto good = simulated(tower(3), top_force(3), 0.01);
  EXPECT_NE(refusal({good}, {.bands = {{60, 70}}}).find("its lines run from 0.03125 to 50 Hz"), std::string::npos);
  EXPECT_NE(refusal({good}, {.bands = {{7, 5}}}).find("must exceed its lower one"), std::string::npos);
  EXPECT_NE(refusal({good}, {.smoothing = -1.0}).find("smoothing width is -1"), std::string::npos);
  EXPECT_NE(refusal({}, {}).find("no FRF"), std::string::npos);
  good.response.lines *= 10.0;
  EXPECT_NE(refusal({good}, {.check_size = false}).find("highest natural frequency"), std::string::npos);
}

TEST(FrfResidual, WidthsEndWithNone) {
  EXPECT_EQ(smoothing_widths(0.9, 0.1).size(), 4u);
  EXPECT_DOUBLE_EQ(smoothing_widths(0.9, 0.1)[2], 0.1);
  EXPECT_EQ(smoothing_widths(0.9, 0.1).back(), 0.0);
}

}  // namespace
}  // namespace kalfem
