// SPDX-License-Identifier: Apache-2.0
#include "kalfem/updating/frf_model.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "kalfem/base/invalid_input.hpp"
#include "updating/chain_model.hpp"

namespace kalfem {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::ChainModel;
using Kind = ChainModel::Kind;

Complex at_frequency(double f, double width = 0.0) { return 2.0 * std::numbers::pi * Complex(width, f); }

/// Ratios one a mode, with the rate 2 zeta omega constant above their limit.
std::vector<double> ratios_of_all(const VectorXd& frequencies, const ModalRatios& ratios) {
  std::vector<double> all;
  for (const double f : frequencies) {
    const bool own = f <= ratios.up_to;
    all.push_back(own ? ratios.values[std::min(all.size(), ratios.values.size() - 1)]
                      : all.back() * frequencies[Index(all.size()) - 1] / f);
  }
  return all;
}

/// (K + s (C + C_m) + s^2 M)^-1, with C_m formed.
MatrixXcd direct_receptance(const ModelAtParameters& at, Complex s) {
  const auto& [model, ratios] = at;
  MatrixXd damping(model.damping);
  if (!ratios.empty()) {
    const NormalModes modes = normal_modes(model.mass, model.stiffness);
    damping += modal_damping(model.mass, modes, ratios_of_all(modes.frequencies, ratios));
  }
  return (MatrixXd(model.stiffness) + s * damping + s * s * MatrixXd(model.mass)).inverse();
}

/// Three floor_names, dashpots that are not proportional, ratios that differ, a parameter of each kind.
std::shared_ptr<ChainModel> small_chain() {
  auto chain = std::make_shared<ChainModel>();
  chain->masses = {2.0, 3.0, 1.0};
  chain->stiffnesses = {4000.0, 2500.0, 3000.0};
  chain->dashpots = {1.0, 0.0, 5.0};
  chain->ratios = {0.01, 0.03};
  chain->parameters = {{Kind::stiffness, {0}}, {Kind::stiffness, {1, 2}}, {Kind::mass, {1}}, {Kind::dashpot, {2}},
                       {Kind::dashpot, {0}},   {Kind::ratio, {0}},        {Kind::ratio, {1}}};
  return chain;
}

VectorXd small_values() { return (VectorXd(7) << 4000.0, 2500.0, 3.0, 5.0, 1.0, 0.01, 0.03).finished(); }

const std::vector<std::string> floor_names = {"floor1", "floor2", "floor3"};

TEST(FrfModel, IsTheDynamicFlexibility) {
  const auto chain = small_chain();
  const std::vector<FrfSet> sets = {
      {FrfInput::force, "floor2", floor_names, ResponseQuantity::displacement},
      {FrfInput::force, "floor3", {"floor1"}, ResponseQuantity::velocity},
      {FrfInput::force, "floor1", {"floor3", "floor1"}, ResponseQuantity::acceleration},
  };
  const FrfModel model(chain, sets, 15.0, small_values());
  const FrfEvaluation evaluation = model.evaluate(small_values(), false);
  for (const double f : {0.0, 3.0, 4.1, 15.0}) {
    const Complex s = at_frequency(f, 0.2);
    const MatrixXcd direct = direct_receptance(chain->at(small_values()), s);
    const double tolerance = 1e-14 * direct.norm();  // rounding
    EXPECT_LT((evaluation.at(0, s).values - direct.col(1)).norm(), tolerance);
    EXPECT_LT(std::abs(evaluation.at(1, s).values[0] - s * direct(0, 2)), std::abs(s) * tolerance);
    EXPECT_LT(std::abs(evaluation.at(2, s).values[0] - s * s * direct(2, 0)), std::norm(s) * tolerance);
  }
}

// H = 1 / (k - m w^2 + i c w) of one mass, and at resonance with a ratio 1 / (2 zeta k) in size.
TEST(FrfModel, IsTheClosedFormOfOneMass) {
  ChainModel chain;
  chain.masses = {2.0};
  chain.stiffnesses = {800.0};
  chain.ratios = {0.02};
  const FrfModel model(std::make_shared<ChainModel>(chain),
                       {{FrfInput::force, "floor1", {"floor1"}, ResponseQuantity::displacement}}, 5.0, VectorXd());
  const Complex resonance = model.evaluate(VectorXd(), false).at(0, Complex(0.0, 20.0)).values[0];
  EXPECT_NEAR(std::abs(resonance - Complex(0.0, -1.0 / (2.0 * 0.02 * 800.0))), 0.0, 1e-15);  // rounding
}

// The ground's motion acts as a force on the absolute motion, and as inertia forces on the relative one:
//     z = H (k_g + s c_g) r = r - H M 1 s^2 r,   H without ratios and with.
TEST(FrfModel, BaseExcitationIsForceExcitation) {
  auto chain = small_chain();
  std::vector<FrfSet> sets = {{FrfInput::ground_acceleration, "base", floor_names, ResponseQuantity::acceleration},
                              {FrfInput::ground_displacement, "base", floor_names, ResponseQuantity::displacement}};
  for (const auto& floor : floor_names)
    sets.push_back({FrfInput::force, floor, floor_names, ResponseQuantity::displacement});
  for (const bool with_ratios : {false, true}) {
    if (!with_ratios) chain->ratios = {0.0, 0.0};
    VectorXd values = small_values();
    if (!with_ratios) values.tail(2).setZero();
    const FrfEvaluation evaluation = FrfModel(chain, sets, 15.0, values).evaluate(values, false);
    for (const double f : {0.01, 3.0, 15.0}) {
      const Complex s = at_frequency(f);
      Eigen::VectorXcd relative = Eigen::VectorXcd::Zero(3);
      for (std::size_t j = 0; j < 3; ++j) relative -= s * s * chain->masses[j] * evaluation.at(2 + j, s).values;
      const Eigen::VectorXcd absolute = relative.array() + 1.0;
      const double tolerance = 3e-14 * absolute.norm();  // rounding
      EXPECT_LT((evaluation.at(0, s).values - absolute).norm(), tolerance) << f;
      EXPECT_LT((evaluation.at(1, s).values - absolute).norm(), tolerance) << f;
      if (with_ratios) continue;
      const Eigen::VectorXcd forced = evaluation.at(2, s).values * (4000.0 + s * 1.0);
      EXPECT_LT((evaluation.at(1, s).values - forced).norm(), tolerance) << f;
    }
  }
}

/// Largest difference of the derivatives from central differences, relative to them or, where a parameter hardly
/// matters, to 1e-4 of H per relative change of it.
double derivative_error(const FrfModel& model, const VectorXd& values, std::size_t set, Complex s) {
  const MatrixXcd analytic = model.evaluate(values, true).at(set, s).derivatives;
  double worst = 0.0;
  for (Index p = 0; p < values.size(); ++p) {
    const double step = 1e-5 * values[p];
    VectorXd above = values, below = values;
    above[p] += step;
    below[p] -= step;
    const auto high = model.evaluate(above, false).at(set, s).values,
               low = model.evaluate(below, false).at(set, s).values;
    const Eigen::VectorXcd difference = (high - low) / (2.0 * step);
    worst =
        std::max(worst, (analytic.col(p) - difference).norm() / (difference.norm() + 1e-4 * high.norm() / values[p]));
  }
  return worst;
}

// Rounding of central differences with a relative step of 1e-5 is about 1e-10, their own error 1e-10 times the third
// derivative, which near resonances is (1 / zeta)^2 = 1e4 larger.
TEST(FrfModel, DerivativesAreThoseOfDifferences) {
  const FrfModel model(small_chain(),
                       {{FrfInput::force, "floor2", floor_names, ResponseQuantity::acceleration},
                        {FrfInput::ground_acceleration, "base", floor_names, ResponseQuantity::acceleration},
                        {FrfInput::ground_displacement, "base", {"floor3"}, ResponseQuantity::velocity}},
                       15.0, small_values());
  for (std::size_t set = 0; set < 3; ++set)
    for (const double f : {0.5, 2.9, 8.0, 15.0})
      for (const double width : {0.0, 0.5})
        EXPECT_LT(derivative_error(model, small_values(), set, at_frequency(f, width)), 1e-6) << set << ", " << f;
}

// The middle one of three modes is the last with a ratio of its own: the third has its rate, not its ratio.
TEST(FrfModel, ModesAboveTheLimitOfTheRatiosShareTheLastRate) {
  const auto chain = small_chain();
  const VectorXd frequencies =
      normal_modes(chain->at(small_values()).model.mass, chain->at(small_values()).model.stiffness).frequencies;
  const std::vector<FrfSet> sets = {{FrfInput::force, "floor2", floor_names, ResponseQuantity::displacement},
                                    {FrfInput::ground_displacement, "base", {"floor3"}, ResponseQuantity::velocity}};
  const Complex s = at_frequency(frequencies[2]);
  const auto of_all = FrfModel(chain, sets, 15.0, small_values()).evaluate(small_values(), false).at(0, s).values;
  for (const Index own : {1, 2}) {
    chain->ratios_up_to = 0.5 * (frequencies[own - 1] + frequencies[own]);
    const FrfModel model(chain, sets, 15.0, small_values());
    const MatrixXcd direct = direct_receptance(chain->at(small_values()), s);
    const auto limited = model.evaluate(small_values(), false).at(0, s).values;
    EXPECT_LT((limited - direct.col(1)).norm(), 1e-12 * direct.norm()) << own;  // rounding
    EXPECT_GT((limited - of_all).norm(), 0.02 * direct.norm()) << own;
    for (std::size_t set = 0; set < 2; ++set)
      for (const double f : {0.5, 2.9, 8.0, 15.0})
        EXPECT_LT(derivative_error(model, small_values(), set, at_frequency(f, 0.1)), 1e-6) << set << ", " << f;
  }
  chain->ratios_up_to = 0.5 * frequencies[0];
  const FrfEvaluation undamped = FrfModel(chain, sets, 15.0, small_values()).evaluate(small_values(), true);
  const MatrixXcd direct = [&] {
    ModelAtParameters at = chain->at(small_values());
    at.modal_ratios = {};
    return direct_receptance(at, s);
  }();
  EXPECT_LT((undamped.at(0, s).values - direct.col(1)).norm(), 1e-12 * direct.norm());
}

/// Any matrices K_0 + theta K_1, M, with one ratio.
class MatrixFamily final : public ParameterisedModel {
public:
  MatrixXd stiffness, stiffness_per_theta, mass;
  std::vector<double> ratios;
  VectorXd ground_stiffness, ground_stiffness_per_theta;  ///< of the ground "base"; empty: none

  [[nodiscard]] ModelAtParameters at(const VectorXd& theta) const override {
    ModelAtParameters at;
    for (Index i = 0; i < mass.rows(); ++i) at.model.dofs.push_back("z" + std::to_string(i + 1));
    at.model.points["mean"] = {{"z1", 0.5}, {"z2", 0.5}};
    at.model.stiffness = MatrixXd(stiffness + theta[0] * stiffness_per_theta).sparseView();
    at.model.mass = mass.sparseView();
    at.model.damping.resize(mass.rows(), mass.rows());
    at.modal_ratios = {ratios};
    if (ground_stiffness.size() > 0)
      at.model.grounds.push_back(
          {"base", ground_stiffness + theta[0] * ground_stiffness_per_theta, VectorXd::Zero(mass.rows())});
    return at;
  }
  [[nodiscard]] std::vector<ModelDerivative> derivatives(const VectorXd&) const override {
    ModelDerivative derivative;
    derivative.stiffness = stiffness_per_theta.sparseView();
    return {derivative};
  }
};

TEST(FrfModel, HoldsForRepeatedModes) {
  auto family = std::make_shared<MatrixFamily>();
  family->mass = MatrixXd::Identity(3, 3);
  family->stiffness = Eigen::Vector3d(900.0, 900.0, 2500.0).asDiagonal();
  family->stiffness_per_theta = MatrixXd::Constant(3, 3, 1.0);
  family->ratios = {0.02};
  const VectorXd zero = VectorXd::Zero(1);
  const std::vector<FrfSet> sets = {
      {FrfInput::force, "z1", {"z1", "z2", "z3", "mean"}, ResponseQuantity::displacement}};
  const FrfModel model(family, sets, 10.0, zero);
  const Complex s = at_frequency(4.7);
  const MatrixXcd analytic = model.evaluate(zero, true).at(0, s).derivatives;
  const VectorXd step = VectorXd::Constant(1, 1e-3);
  const Eigen::VectorXcd difference =
      (model.evaluate(step, false).at(0, s).values - model.evaluate(-step, false).at(0, s).values) / 2e-3;
  // roundings over the step, 1e-6 of the stiffness: found 2e-9
  EXPECT_LT((analytic.col(0) - difference).norm(), 1e-8 * difference.norm());
  EXPECT_NEAR(std::abs(analytic(3, 0) - 0.5 * (analytic(0, 0) + analytic(1, 0))), 0.0, 1e-14 * difference.norm());
}

// Held by a second place that does not move, the structure follows the ground in a shape that depends on the parameter.
TEST(FrfModel, FollowsTheGroundInAShapeThatTheParameterChanges) {
  auto family = std::make_shared<MatrixFamily>();
  family->mass = MatrixXd::Identity(2, 2);
  family->stiffness = (MatrixXd(2, 2) << 900, -400, -400, 700).finished();
  family->stiffness_per_theta = Eigen::Vector2d(1.0, 0.0).asDiagonal();  // the spring between z1 and the ground
  family->ground_stiffness = Eigen::Vector2d(500.0, 0.0);
  family->ground_stiffness_per_theta = Eigen::Vector2d(1.0, 0.0);
  family->ratios = {0.2};
  const std::vector<FrfSet> sets = {
      {FrfInput::ground_displacement, "base", {"z1", "z2"}, ResponseQuantity::displacement}};
  const VectorXd theta = VectorXd::Constant(1, 50.0);
  const FrfModel model(family, sets, 10.0, theta);
  // rounding over the step: found 8e-10
  for (const double f : {2.0, 4.0, 8.0}) EXPECT_LT(derivative_error(model, theta, 0, at_frequency(f)), 3e-9) << f;
}

TEST(FrfModel, HoldsForDegreesOfFreedomWithoutMass) {
  auto family = std::make_shared<MatrixFamily>();
  family->mass = Eigen::Vector3d(2.0, 0.0, 1.0).asDiagonal();
  family->stiffness = (MatrixXd(3, 3) << 900, -400, 0, -400, 800, -400, 0, -400, 400).finished();
  family->stiffness_per_theta = Eigen::Vector3d(0.0, 1.0, 0.0).asDiagonal();
  const VectorXd zero = VectorXd::Zero(1);
  const std::vector<FrfSet> sets = {{FrfInput::force, "z2", {"z1", "z2", "z3"}, ResponseQuantity::displacement}};
  const FrfModel model(family, sets, 10.0, zero);
  const Complex s = at_frequency(2.0);
  const Eigen::VectorXcd direct = (family->stiffness + s * s * family->mass).inverse().col(1);
  const FrfLine line = model.evaluate(zero, true).at(0, s);
  // rounding
  EXPECT_LT((line.values - direct).norm(), 3e-14 * direct.norm());
  EXPECT_LT((line.derivatives.col(0) + direct * direct[1]).norm(), 3e-14 * (direct * direct[1]).norm());
}

TEST(FrfModel, HoldsForFreeStructures) {
  ChainModel chain;
  chain.masses.assign(4, 1.5);
  chain.stiffnesses = {0.0, 1e3, 2e3, 1e3};
  chain.ratios = {0.01};
  chain.parameters = {{Kind::stiffness, {1}}, {Kind::mass, {2}}};
  const VectorXd values = Eigen::Vector2d(1e3, 1.5);
  const FrfModel model(std::make_shared<ChainModel>(chain), {{FrfInput::force, "floor1", {"floor1", "floor4"}}}, 15.0,
                       values);
  const FrfEvaluation evaluation = model.evaluate(values, false);
  // the flexibility of the springs adds 2e-6 at 0.01 Hz
  EXPECT_NEAR(std::abs(evaluation.at(0, at_frequency(0.01)).values[1]), 1.0 / 6.0, 4e-6);
  const Complex s = at_frequency(4.0);
  const Eigen::VectorXcd direct = s * s * direct_receptance(chain.at(values), s).col(0);
  EXPECT_LT(std::abs(evaluation.at(0, s).values[1] - direct[3]), 1e-14 * direct.norm());  // rounding
  EXPECT_LT(derivative_error(model, values, 0, s), 5e-9);  // rounding over the step: found 1e-9
}

/// A longer chain, its modes cut off, against the same with all modes: worst relative errors up to `highest`.
struct TruncationErrors {
  double values = 0.0, derivatives = 0.0;
};

TruncationErrors truncation_errors(double multiple, const std::vector<double>& ratios, bool free = false) {
  auto chain = std::make_shared<ChainModel>();
  chain->masses.assign(60, 1.0);
  chain->stiffnesses.assign(60, 1e5);
  if (free) chain->stiffnesses[0] = 0.0;
  chain->dashpots.assign(60, 0.0);
  chain->dashpots[30] = 20.0;
  chain->ratios = ratios;
  chain->parameters = {{Kind::stiffness, {20, 21, 22}}, {Kind::mass, {45}}, {Kind::dashpot, {30}}, {Kind::ratio, {0}}};
  const VectorXd values = Eigen::Vector4d(1e5, 1.0, 20.0, ratios[0]);
  const std::vector<FrfSet> sets = {{FrfInput::force, "floor25", {"floor25", "floor60"}}};
  const FrfEvaluation exact = FrfModel(chain, sets, 10.0, values).evaluate(values, true);
  const FrfEvaluation cut =
      FrfModel(chain, sets, 10.0, values, {.exact_up_to = 0, .multiple = multiple}).evaluate(values, true);
  EXPECT_LT(cut.basis.size(), 40);
  TruncationErrors worst;
  for (double f = 1.0; f <= 10.0; f += 0.25) {
    const FrfLine reference = exact.at(0, at_frequency(f)), line = cut.at(0, at_frequency(f));
    worst.values = std::max(worst.values, (line.values - reference.values).norm() / reference.values.norm());
    for (Index p = 0; p < 4; ++p)
      worst.derivatives = std::max(worst.derivatives, (line.derivatives.col(p) - reference.derivatives.col(p)).norm() /
                                                          reference.derivatives.col(p).norm());
  }
  return worst;
}

// Modes above three times the highest line are left out. Without K^-1 M U and K^-1 C Phi in the basis the values are
// off by 1e-3, derivatives by 1e-1.
TEST(FrfModel, ErrorsOfTheTruncatedBasisAreSmall) {
  for (const bool free : {false, true})
    for (const std::vector<double>& ratios : {std::vector{0.01}, std::vector{0.01, 0.02, 0.005}}) {
      const TruncationErrors two = truncation_errors(2.0, ratios, free), three = truncation_errors(3.0, ratios, free);
      // found 2e-5 and 9e-4 where the chain is free, 5e-6 and 3e-4 where it is held
      EXPECT_LT(three.values, free ? 5e-5 : 1.2e-5) << free;
      EXPECT_LT(three.derivatives, free ? 2e-3 : 7e-4) << free;
      // found .21 to .26 and .35 to .56
      EXPECT_LT(three.values, 0.5 * two.values) << free;
      EXPECT_LT(three.derivatives, 0.7 * two.derivatives) << free;
    }
}

TEST(FrfModel, NamesUnknownPlaces) {
  const std::vector<FrfSet> sets = {{FrfInput::force, "flor1", {"floor1", "roof"}},
                                    {FrfInput::ground_acceleration, "bas", {"floor1"}}};
  try {
    FrfModel(small_chain(), sets, 15.0, small_values());
    FAIL();
  } catch (const InvalidInput& error) {
    ASSERT_EQ(error.issues().size(), 3u);
    EXPECT_NE(to_string(error.issues()[0]).find("did you mean 'floor1'"), std::string::npos);
    EXPECT_NE(to_string(error.issues()[2]).find("did you mean 'base'"), std::string::npos);
  }
}

}  // namespace
}  // namespace kalfem
