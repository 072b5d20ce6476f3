// SPDX-License-Identifier: Apache-2.0
#include "kalfem/updating/direct_response.hpp"

#include <gtest/gtest.h>

#include <complex>
#include <memory>
#include <numbers>

#include "kalfem/base/interruption.hpp"
#include "kalfem/base/invalid_input.hpp"
#include "kalfem/model/fixed_model.hpp"
#include "kalfem/updating/frf_model.hpp"

namespace kalfem {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double rounding = 1e-12;

Complex laplace(double frequency) { return {0.0, 2.0 * std::numbers::pi * frequency}; }

/// A mass on a spring and a dashpot, which stand on a ground.
LinearModel oscillator(double mass, double stiffness, double damping) {
  return assemble({.name = "o", .masses = {{"m", mass}}, .springs = {{"", "ground", "m", stiffness, damping}}});
}

/// A bar that is fixed at one end, of equal masses on equal springs: half a mass at the free end.
LinearModel bar(int count, double mass, double stiffness, const RayleighDamping& rayleigh = {}) {
  LumpedSubstructure bar{.name = "bar", .masses = {}, .rayleigh = rayleigh};
  for (int i = 1; i <= count; ++i) {
    const std::string dof = std::to_string(i);
    bar.masses.push_back({dof, i == count ? 0.5 * mass : mass});
    bar.springs.push_back({"", i == 1 ? "ground" : std::to_string(i - 1), dof, stiffness, 0.0});
  }
  return assemble(bar);
}

/// Largest |found - expected| over the largest |expected|.
double error_of(const MatrixXcd& found, const MatrixXcd& expected) {
  return (found - expected).cwiseAbs().maxCoeff() / expected.cwiseAbs().maxCoeff();
}

/// By modes and residual vectors, as the updating computes them.
MatrixXcd modal(const LinearModel& model, const FrfSet& set, const VectorXd& lines) {
  const VectorXd none;
  const auto evaluation =
      FrfModel(std::make_shared<const FixedModel>(model), {set}, lines.maxCoeff(), none).evaluate(none, false);
  MatrixXcd values(lines.size(), std::ssize(set.outputs));
  for (Index i = 0; i < lines.size(); ++i) values.row(i) = evaluation.at(0, laplace(lines[i])).values.transpose();
  return values;
}

TEST(DirectResponse, OfOneMassIsItsClosedForm) {
  const double m = 2.0, k = 800.0, c = 3.0;
  const auto model = oscillator(m, k, c);
  const VectorXd lines = VectorXd::LinSpaced(31, 0.0, 10.0);
  const auto found =
      direct_responses(model,
                       {{FrfInput::force, "m", {"m"}, ResponseQuantity::displacement},
                        {FrfInput::force, "m", {"m"}, ResponseQuantity::velocity},
                        {FrfInput::force, "m", {"m"}, ResponseQuantity::acceleration},
                        {FrfInput::ground_displacement, "ground", {"m"}, ResponseQuantity::displacement},
                        {FrfInput::ground_acceleration, "ground", {"m"}, ResponseQuantity::acceleration}},
                       lines);
  for (Index i = 0; i < lines.size(); ++i) {
    const Complex s = laplace(lines[i]), receptance = 1.0 / (k + s * c + s * s * m);
    EXPECT_LT(std::abs(found[0](i, 0) - receptance), rounding * std::abs(receptance));
    EXPECT_LT(std::abs(found[1](i, 0) - s * receptance), rounding * std::abs(s * receptance) + 1e-300);
    EXPECT_LT(std::abs(found[2](i, 0) - s * s * receptance), rounding * std::abs(s * s * receptance) + 1e-300);
    const Complex transmissibility = (k + s * c) * receptance;
    EXPECT_LT(std::abs(found[3](i, 0) - transmissibility), rounding * std::abs(transmissibility));
    EXPECT_LT(std::abs(found[4](i, 0) - transmissibility), rounding * std::abs(transmissibility));
  }
}

// Waves in a chain: u_j = sin(j theta) with 2 sin(theta / 2) = omega sqrt(m / k); the force at the half mass of the
// free end, N, gives H_jN = sin(j theta) / (k sin(theta) cos(N theta)). Rayleigh damping makes k and m complex.
TEST(DirectResponse, OfABarIsThatOfItsWaves) {
  const int count = 60;
  const double m = 0.1, k = 1e6;
  const RayleighDamping rayleigh{.mass_factor = 4.0, .stiffness_factor = 1e-5};
  const VectorXd lines = VectorXd::LinSpaced(80, 1.0, 400.0);
  const auto found = direct_responses(bar(count, m, k, rayleigh),
                                      {{FrfInput::force, "60", {"60", "20"}, ResponseQuantity::displacement}}, lines);
  MatrixXcd expected(lines.size(), 2);
  for (Index i = 0; i < lines.size(); ++i) {
    const Complex s = laplace(lines[i]);
    const Complex stiffness = k * (1.0 + s * rayleigh.stiffness_factor), mass = m * (1.0 + rayleigh.mass_factor / s);
    const Complex theta = 2.0 * std::asin(0.5 * std::sqrt(-s * s * mass / stiffness));
    for (Index j = 0; j < 2; ++j)
      expected(i, j) =
          std::sin((j == 0 ? 60.0 : 20.0) * theta) / (stiffness * std::sin(theta) * std::cos(60.0 * theta));
  }
  EXPECT_LT(error_of(found[0], expected), 1e-9);
}

// The border stands for C_m; all modes and the dense matrix do without.
TEST(DirectResponse, WithModalDampingIsThatOfAllModes) {
  LinearModel model = bar(40, 0.1, 1e6);
  add_modal_damping(model, {0.01, 0.03}, {.count = 12});
  ASSERT_EQ(model.modal_damping.rates.size(), 12);
  const FrfSet set{FrfInput::force, "17", {"17", "40"}, ResponseQuantity::acceleration};
  const VectorXd lines = VectorXd::LinSpaced(100, 0.0, 700.0);
  const auto found = direct_responses(model, {set}, lines);
  EXPECT_LT(error_of(found[0], modal(model, set, lines)), 1e-9);

  const MatrixXd damping =
      MatrixXd(model.damping) + damping_force(model.modal_damping, model.mass, MatrixXd::Identity(40, 40));
  const Complex s = laplace(lines[60]);
  const MatrixXcd dense = (MatrixXd(model.stiffness) + s * damping + s * s * MatrixXd(model.mass)).inverse();
  EXPECT_LT(std::abs(found[0](60, 1) - s * s * dense(39, 16)), 1e-9 * std::abs(found[0](60, 1)));
  LinearModel without = model;
  without.modal_damping = {};
  EXPECT_GT(error_of(direct_responses(without, {set}, lines)[0], found[0]), 0.01);
}

TEST(DirectResponse, RefusesUnknownPlacesAtOnce) {
  try {
    direct_responses(oscillator(1.0, 1.0, 1.0),
                     {{FrfInput::force, "n", {"m"}, ResponseQuantity::velocity},
                      {FrfInput::ground_displacement, "base", {"q"}, ResponseQuantity::velocity}},
                     VectorXd::Ones(1));
    FAIL() << "unknown places are accepted";
  } catch (const InvalidInput& error) {
    EXPECT_EQ(error.issues().size(), 3u) << error.what();
  }
}

TEST(DirectResponse, RefusesUndampedResonancesAndFreeStructuresAtRest) {
  const auto message = [](const LinearModel& model, double frequency) {
    try {
      direct_responses(model, {{FrfInput::force, "m", {"m"}, ResponseQuantity::displacement}},
                       VectorXd::Constant(1, frequency));
    } catch (const InvalidInput& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const double natural = std::sqrt(800.0 / 2.0) / (2.0 * std::numbers::pi);
  EXPECT_NE(message(oscillator(2.0, 800.0, 0.0), natural).find("an undamped mode resonates there"), std::string::npos);
  EXPECT_EQ(message(oscillator(2.0, 800.0, 1e-3), natural), "");
  EXPECT_EQ(message(oscillator(2.0, 800.0, 0.0), 1.001 * natural), "");
  EXPECT_NE(message(oscillator(2.0, 0.0, 0.0), 0.0).find("can move as a rigid body"), std::string::npos);
  EXPECT_EQ(message(oscillator(2.0, 0.0, 0.0), 1.0), "");
}

TEST(DirectResponse, ShowsItsLinesAndStopsWhenAsked) {
  const auto model = oscillator(1.0, 1.0, 1.0);
  const std::vector<FrfSet> sets{{FrfInput::force, "m", {"m"}, ResponseQuantity::displacement}};
  std::vector<std::string> shown;
  direct_responses(model, sets, VectorXd::LinSpaced(3, 1.0, 3.0),
                   [&](std::string_view words, double) { shown.emplace_back(words); });
  EXPECT_EQ(shown, (std::vector<std::string>{"line 1 of 3", "line 2 of 3", "line 3 of 3"}));
  const StopQuestion stop = [] { return true; };
  const StopScope scope(&stop);
  EXPECT_THROW(direct_responses(model, sets, VectorXd::Ones(1)), Interrupted);
}

}  // namespace
}  // namespace kalfem
