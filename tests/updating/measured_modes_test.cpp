// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <complex>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/updating/modal_residual.hpp"
#include "kalfem/updating/modes_of_set.hpp"
#include "updating/affine_model.hpp"

/// What is known of measured modes entry by entry: gaps, deviations, covariances, dampings, complex shapes.
namespace kalfem {
namespace {

using namespace test;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using testing::HasSubstr;

constexpr double none = std::numeric_limits<double>::quiet_NaN();

/// ground - a - b - c with dashpots; parameters: the stiffness k1, the dashpot of k2, the mass of c, the factors of
/// Rayleigh damping and the modal ratio.
std::shared_ptr<const ParameterisedModel> tower(const LumpedSubstructure& given) {
  std::vector<ParameterBinding<LumpedParameter>> bindings;
  const std::vector<std::string> names = {
      "k1.stiffness", "k2.damping", "c.mass", "damping.mass_factor", "damping.stiffness_factor", "damping.modal"};
  for (const auto& [name, parameter] : parameters_of(given))
    if (const auto at = std::ranges::find(names, name); at != names.end())
      bindings.push_back({at - names.begin(), parameter});
  return std::make_shared<ParameterisedLumped>(given, bindings, std::ssize(names));
}

LumpedSubstructure three_masses(double dashpot = 0.0, double modal = 0.0) {
  LumpedSubstructure given{
      .name = "t",
      .masses = {{"a", 2.0}, {"b", 1.0}, {"c", 1.5}},
      .springs = {{"k1", "ground", "a", 3000.0, dashpot}, {"k2", "a", "b", 2000.0, dashpot}, {"k3", "b", "c", 1500.0}}};
  if (modal > 0.0) given.modal_damping = {modal};
  return given;
}

VectorXd start(double dashpot, double mass_factor, double stiffness_factor, double modal) {
  VectorXd values(6);
  values << 3000.0, dashpot, 1.5, mass_factor, stiffness_factor, modal;
  return values;
}

const std::vector<DofCombination> at_masses = {{{"a", 1.0}}, {{"b", 1.0}}, {{"c", 1.0}}};

NormalModes modes_at(const ParameterisedModel& model, const VectorXd& parameters) {
  const auto at = model.at(parameters).model;
  return normal_modes(at.mass, at.stiffness);
}

/// The first two modes, a little off.
std::vector<MeasuredMode> measurement(const NormalModes& modes) {
  std::vector<MeasuredMode> measured;
  for (Index i = 0; i < 2; ++i) {
    MeasuredMode mode{.frequency = 1.01 * modes.frequencies[i], .deviation = 0.1};
    mode.shape = 2.0 * modes.shapes.col(i) + Eigen::Vector3d(0.02, -0.01, 0.03);
    mode.shape_deviation = 0.02;
    measured.push_back(mode);
  }
  return measured;
}

VectorXd values_of(const ModalResidual& residual, const VectorXd& at) { return residual.evaluate(at, false)->values; }

void expect_jacobian(const ModalResidual& residual, const VectorXd& at) {
  const auto value = residual.evaluate(at, true);
  ASSERT_TRUE(value);
  const MatrixXd differences =
      jacobian_by_differences([&](const VectorXd& parameters) { return values_of(residual, parameters); }, at, 1e-3);
  const MatrixXd scaled = value->jacobian * at.asDiagonal();
  for (Index row = 0; row < scaled.rows(); ++row)  // differences of fourth order with steps of .001: found 4e-11
    EXPECT_LT((scaled.row(row) - differences.row(row) * at.asDiagonal()).norm(), 1e-9 * scaled.norm()) << row;
}

/// An entry that was not measured counts as if its point were not there.
TEST(MeasuredModes, MissingEntriesAreLeftOut) {
  const auto model = tower(three_masses());
  const VectorXd at = start(0, 0, 0, 0);
  auto measured = measurement(modes_at(*model, at));
  measured.resize(1);
  auto gap = measured;
  gap[0].shape[1] = none;
  measured[0].shape = Eigen::Vector2d(measured[0].shape[0], measured[0].shape[2]);
  const ModalResidual with_gap(model, gap, at_masses, at), without(model, measured, {at_masses[0], at_masses[2]}, at);
  EXPECT_EQ(with_gap.size(), 3);
  EXPECT_EQ(with_gap.layout().step.size(), 3U);
  EXPECT_LT((values_of(with_gap, at) - values_of(without, at)).norm(), 1e-12);  // rounding
  EXPECT_NEAR(with_gap.compare(at).pairs[0].mac, without.compare(at).pairs[0].mac, 1e-14);
}

/// The scale is fitted with the deviations as weights: c = sum(a p / d^2) / sum(a^2 / d^2).
TEST(MeasuredModes, EachEntryCountsByItsDeviation) {
  const auto model = tower(three_masses());
  const VectorXd at = start(0, 0, 0, 0);
  const auto modes = modes_at(*model, at);
  auto measured = measurement(modes);
  measured[0].shape_deviations = Eigen::Vector3d(0.01, 0.1, 0.03);
  const VectorXd a = modes.shapes.col(0), p = measured[0].shape,
                 w = measured[0].shape_deviations.cwiseAbs2().cwiseInverse();
  const double c = a.cwiseProduct(w).dot(p) / a.cwiseProduct(w).dot(a);
  const VectorXd expected = (c * a - p).cwiseQuotient(measured[0].shape_deviations);
  const ModalResidual residual(model, measured, at_masses, at);
  EXPECT_LT((values_of(residual, at).segment(2, 3) - expected).norm(), 1e-12 * expected.norm());  // rounding
}

/// Independent errors of a shape that was then divided by its second entry: its covariance is singular, and says the
/// same as the errors did. To first order in the misfit, which is .001 here.
TEST(MeasuredModes, ACovarianceDoesNotDependOnTheNormalisation) {
  const Eigen::Vector3d phi(0.5, 1.0, -0.7), deviations(0.01, 0.03, 0.02), a = phi + Eigen::Vector3d(4e-4, -1e-3, 8e-4);
  const auto misfit = [&](const ShapeErrors& errors) {
    const VectorXd A = errors.whitened(a), t = errors.whitened(phi);
    return (A * (A.dot(t) / A.squaredNorm()) - t).squaredNorm();
  };
  MatrixXd normalising = MatrixXd::Identity(3, 3);
  normalising.col(1) -= phi;
  const MatrixXd covariance = normalising * deviations.cwiseAbs2().asDiagonal() * normalising.transpose();
  EXPECT_EQ(covariance(1, 1), 0.0);
  const double independent = misfit({phi, deviations}), normalised = misfit(ShapeErrors::correlated(phi, covariance));
  EXPECT_GT(independent, 1e-3);
  EXPECT_NEAR(normalised, independent, 5e-3 * independent);
}

TEST(MeasuredModes, JacobianOfAllThatIsKnownAgreesWithDifferences) {
  auto given = three_masses(4.0, 0.01);
  const auto model = tower(given);
  const VectorXd at = start(4.0, 0.3, 2e-4, 0.01);
  auto measured = measurement(modes_at(*model, at));
  measured[0].shape[2] = none;
  measured[0].shape_deviations = Eigen::Vector3d(0.01, 0.1, none);
  measured[1].shape_covariance = Eigen::Matrix3d{{4e-4, 1e-4, 0}, {1e-4, 9e-4, -2e-4}, {0, -2e-4, 1e-4}};
  for (auto& mode : measured) mode.damping = 0.02, mode.damping_deviation = 0.001;
  const ModalResidual residual(model, measured, at_masses, at);
  EXPECT_EQ(residual.size(), 2 + 2 + 3 + 2);
  expect_jacobian(residual, at);
}

/// Rayleigh damping has zeta = alpha / (2 omega) + beta omega / 2, beside the ratio of modal damping.
TEST(MeasuredModes, DampingsAreThoseOfTheModel) {
  auto given = three_masses(0.0, 0.01);
  const auto model = tower(given);
  const VectorXd at = start(0.0, 0.3, 2e-4, 0.01);
  const auto modes = modes_at(*model, at);
  auto measured = measurement(modes);
  for (auto& mode : measured) mode.damping = 0.02, mode.damping_deviation = 0.001;
  const ModalResidual residual(model, measured, at_masses, at);
  const VectorXd values = values_of(residual, at).tail(2);
  for (Index i = 0; i < 2; ++i) {
    const double omega = 2.0 * M_PI * modes.frequencies[i], zeta = 0.3 / (2.0 * omega) + 2e-4 * omega / 2.0 + 0.01;
    EXPECT_NEAR(values[i], (zeta - 0.02) / 0.001, 1e-9);  // rounding over a deviation of .001
    EXPECT_NEAR(*residual.compare(at).pairs[static_cast<std::size_t>(i)].model_damping, zeta, 1e-12);
  }
}

/// Dashpots that couple the modes: the ratio of the complex mode, to second order in the coupling.
TEST(MeasuredModes, DampingsOfDashpotsAreNearThoseOfComplexModes) {
  const auto model = tower(three_masses(4.0));
  const VectorXd at = start(4.0, 0, 0, 0);
  const auto linear = model->at(at).model;
  MatrixXd A = MatrixXd::Zero(6, 6);
  const MatrixXd inverse = MatrixXd(linear.mass).inverse();
  A.topRightCorner(3, 3).setIdentity();
  A.bottomLeftCorner(3, 3) = -inverse * linear.stiffness;
  A.bottomRightCorner(3, 3) = -inverse * linear.damping;
  auto measured = measurement(modes_at(*model, at));
  for (auto& mode : measured) mode.damping = 0.02, mode.damping_deviation = 0.001;
  const auto pairs = ModalResidual(model, measured, at_masses, at).compare(at).pairs;
  for (const auto& pair : pairs) {
    double nearest = 1e9, ratio = 0.0;
    for (const auto& pole : A.eigenvalues().eval())
      if (const double off = std::abs(std::abs(pole) / (2.0 * M_PI) - pair.model_frequency); off < nearest)
        nearest = off, ratio = -pole.real() / std::abs(pole);
    EXPECT_GT(ratio, 0.01);
    EXPECT_NEAR(*pair.model_damping, ratio, 1e-2 * ratio);
  }
}

TEST(MeasuredModes, RefuseWhatCannotBeCompared) {
  const auto model = tower(three_masses());
  const VectorXd at = start(0, 0, 0, 0);
  const auto refused = [&](auto change, const LumpedSubstructure& given = three_masses()) -> std::string {
    auto measured = measurement(modes_at(*model, at));
    change(measured);
    try {
      ModalResidual(tower(given), measured, at_masses, at);
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(refused([](auto&) {}), "");
  EXPECT_THAT(refused([](auto& all) { all[0].damping = 0.01, all[0].damping_deviation = 0.001; }),
              HasSubstr("the model has no damping"));
  EXPECT_THAT(refused([](auto& all) { all[1].damping = 1.5; }, three_masses(4.0)),
              HasSubstr("is 1.5: it lies between"));
  EXPECT_THAT(refused([](auto& all) { all[0].shape_deviations = Eigen::Vector3d(0.1, 0.0, 0.1); }),
              HasSubstr("is not positive"));
  EXPECT_THAT(refused([](auto& all) { all[0].shape.setConstant(none); }), HasSubstr("without an entry"));
  EXPECT_THAT(refused([](auto& all) { all[0].shape_covariance = MatrixXd::Identity(2, 2); }),
              HasSubstr("is not 3 x 3"));
}

ModeSet one_mode(const Eigen::VectorXcd& shape) {
  ModeSet set{.points = {"1:+Z", "a2", "a3"}};
  set.modes.push_back({.frequency = 5.0, .frequency_std = 0.02, .damping = 0.01, .damping_std = 0.002, .shape = shape});
  return set;
}

/// r + 0.1 i s with s at right angles to r and as long, in any phase: turned back to r, complexity .1 / sqrt(1.01).
TEST(ModesOfSet, TurnComplexShapesToBeReal) {
  const Eigen::Vector3d real(1.0, 2.0, -2.0), across(2.0, 1.0, 2.0);
  const std::complex<double> phase = std::polar(3.0, 1.2);
  const Eigen::VectorXcd shape = phase * (real + std::complex<double>(0.0, 0.1) * across);
  const auto found = modes_of_set(one_mode(shape)).at(0);
  const VectorXd scaled = found.shape / found.shape[0];
  EXPECT_LT((scaled - real).norm(), 1e-14);
  EXPECT_NEAR(found.complexity, 0.1 / std::sqrt(1.01), 1e-14);
  EXPECT_EQ(found.deviation, 0.02);
  EXPECT_FALSE(found.damping);
  const auto with_damping = modes_of_set(one_mode(shape), {.deviation = 0.01, .dampings = true}).at(0);
  EXPECT_EQ(with_damping.deviation, 0.05);
  EXPECT_EQ(*with_damping.damping, 0.01);
  EXPECT_EQ(with_damping.damping_deviation, 0.002);
  try {
    modes_of_set(one_mode(shape), {.max_complexity = 0.09});
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), HasSubstr("measured mode 1 (5 Hz) is complex: 10 % of it are out of phase"));
  }
}

/// The covariance turns with the shape: real parts alone have errors here, and the shape is turned by 90 degrees twice.
TEST(ModesOfSet, CovariancesTurnWithTheShape) {
  auto set =
      one_mode(Eigen::Vector3cd(std::complex<double>(0, 1), std::complex<double>(0, 2), std::complex<double>(0, -2)));
  MatrixXd& covariance = set.modes[0].shape_covariance = MatrixXd::Zero(6, 6);
  covariance.bottomRightCorner(3, 3) = Eigen::Vector3d(1e-4, 4e-4, 9e-4).asDiagonal();
  covariance(3, 4) = covariance(4, 3) = 1e-4;
  covariance.topLeftCorner(3, 3).setIdentity();
  const auto found = modes_of_set(set).at(0);
  EXPECT_LT((found.shape_covariance - covariance.bottomRightCorner(3, 3)).norm(), 1e-15);
  set.modes[0].degrees_of_freedom = 8.0;  // four of them for three points and one more
  EXPECT_NEAR(modes_of_set(set).at(0).shape_covariance(0, 1), 0.5e-4, 1e-15);
  const auto chosen = at_points(set, {"-a3", "a2", "1:-Z"});
  EXPECT_EQ(chosen.modes[0].shape[0], std::complex<double>(0, 2));
  EXPECT_EQ(chosen.modes[0].shape[2], std::complex<double>(0, -1));
  EXPECT_EQ(chosen.modes[0].shape_covariance(4, 5), -1e-4);
  EXPECT_THROW(at_points(set, {"a4"}), InvalidInput);
}

}  // namespace
}  // namespace kalfem
