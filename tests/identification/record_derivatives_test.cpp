// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "identification/chain_structure.hpp"
#include "kalfem/identification/record_residual.hpp"

// Columns of a record residual's Jacobian with held gains against columns by filter passes.

namespace kalfem::test {
namespace {

using Derivatives = RecordResidual::Derivatives;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// theta = [two springs of the body, its modal damping], off the truth by the factors.
UpdatingSetup springs_and_damping(const StructureData& structure, const Eigen::Vector3d& factors) {
  UpdatingSetup setup;
  setup.parameters = {{.name = "lower", .unit = "N/m", .initial = factors[0] * body_stiffness},
                      {.name = "upper", .unit = "N/m", .initial = factors[1] * body_stiffness},
                      {.name = "damping", .unit = "-", .initial = factors[2] * 0.01}};
  setup.true_parameters = {body_stiffness, body_stiffness, 0.01};
  setup.bindings = {{0, parameter(structure, "body.3-4.stiffness")},
                    {1, parameter(structure, "body.7-8.stiffness")},
                    {2, parameter(structure, "body.damping.modal")}};
  return setup;
}

/// The chain's record and how the body is compared with it.
struct Comparison {
  EstimationProblem problem = chain_problem();
  double duration = 2.0;
  Eigen::Vector3d factors{1.03, 0.97, 1.1};

  Comparison() { problem.settings.settle = 0.5; }

  [[nodiscard]] RecordResidual residual(Derivatives derivatives, double relative_step = 1e-4,
                                        double most_memory = 5e8) const {
    const auto given = shared(problem);
    const auto setup = springs_and_damping(*given->structure, factors);
    return {given,
            chain_record(*given, duration),
            std::make_shared<const ParameterisedStructure>(given->structure, setup.bindings, 3),
            setup,
            {.name = "record",
             .substructure = "body",
             .sensors = {"a2", "a4", "a6", "a10"},
             .derivatives = derivatives,
             .relative_step = relative_step,
             .most_gain_memory = most_memory}};
  }
  [[nodiscard]] VectorXd start() const {
    return initial_values(springs_and_damping(*problem.structure, factors).parameters);
  }
  [[nodiscard]] MatrixXd jacobian(Derivatives derivatives, double relative_step = 1e-4) const {
    const auto value = residual(derivatives, relative_step).evaluate(start(), true);
    return value ? value->jacobian : MatrixXd();
  }
  /// Central differences of filter passes.
  [[nodiscard]] MatrixXd central(double relative_step) const {
    const auto passes = residual(Derivatives::filter_passes);
    const VectorXd theta = start();
    MatrixXd columns(passes.size(), theta.size());
    for (Index i = 0; i < theta.size(); ++i) {
      const VectorXd step = relative_step * theta[i] * VectorXd::Unit(theta.size(), i);
      const VectorXd above = passes.evaluate(theta + step, false)->values,
                     below = passes.evaluate(theta - step, false)->values;
      columns.col(i) = (above - below) / (2.0 * step[i]);
    }
    return columns;
  }
};

/// The largest relative error of a column.
double column_error(const MatrixXd& columns, const MatrixXd& exact) {
  if (columns.size() != exact.size()) return std::numeric_limits<double>::infinity();
  return ((columns - exact).colwise().norm().array() / exact.colwise().norm().array()).maxCoeff();
}

Comparison with_noise_in_the_process() {
  Comparison comparison;
  comparison.problem.settings.process_noise.acceleration = 0.1;
  return comparison;
}

TEST(RecordDerivatives, ByFilterPassesAreThoseOfCentralDifferences) {
  const Comparison comparison;
  const MatrixXd exact = comparison.central(1e-4);
  EXPECT_LT(column_error(comparison.central(1e-3), exact), 2e-4);  // found 4e-5: the step does not matter
  EXPECT_LT(column_error(comparison.jacobian(Derivatives::filter_passes), exact), 1e-3);  // found 4e-4: one-sided
}

/// An unknown's gain follows the motion from sample to sample. Held over 20 samples, gains gave columns that were 15
/// to 1e4 times too long, with a correlation of -0.07 to 0.15 to the exact ones; over 5, errors of 3 to 11 %.
TEST(RecordDerivatives, WithHeldGainsAreNearlyExactBesideUnknownsOfConnectors) {
  const Comparison comparison;
  EXPECT_LT(column_error(comparison.jacobian(Derivatives::held_gains), comparison.central(1e-4)), 0.02);  // found 0.010
  const Comparison noisy = with_noise_in_the_process();
  EXPECT_LT(column_error(noisy.jacobian(Derivatives::held_gains), noisy.central(1e-4)), 0.1);  // found 0.063
}

TEST(RecordDerivatives, WithHeldGainsAreNearlyExactBesideAnUnknownOfTheLinearPart) {
  Comparison comparison;
  comparison.problem.settings.unknowns = {
      unknown(*comparison.problem.structure, "body.9-10.stiffness", 0.9 * body_stiffness, 0.1 * body_stiffness)};
  EXPECT_LT(column_error(comparison.jacobian(Derivatives::held_gains), comparison.central(1e-4)), 0.03);  // found 0.014
}

TEST(RecordDerivatives, WithHeldGainsAreNearlyExactFarFromTheTruth) {
  Comparison comparison;
  comparison.factors = {1.2, 0.8, 1.5};
  comparison.duration = 4.0;
  EXPECT_LT(column_error(comparison.jacobian(Derivatives::held_gains), comparison.central(1e-4)), 0.06);  // found 0.030
}

TEST(RecordDerivatives, AutomaticOnesHoldTheGainsWhereThatIsAccurate) {
  const auto residual = Comparison().residual(Derivatives::held_gains_where_accurate);
  EXPECT_TRUE(residual.holds_gains());
  EXPECT_NE(residual.derivatives().find("held gains: derivatives differ from those by filter passes by at most 2.6 %"),
            std::string::npos)
      << residual.derivatives();
}

void expect_filter_passes(const Comparison& comparison, double found) {
  const MatrixXd passes = comparison.jacobian(Derivatives::filter_passes);
  EXPECT_GT(column_error(comparison.jacobian(Derivatives::held_gains), passes), 0.8 * found);
  const auto residual = comparison.residual(Derivatives::held_gains_where_accurate);
  EXPECT_FALSE(residual.holds_gains());
  EXPECT_NE(residual.derivatives().find("filter passes: derivatives with held gains would differ by up to"),
            std::string::npos)
      << residual.derivatives();
  EXPECT_EQ(residual.evaluate(comparison.start(), true)->jacobian, passes);
}

/// A record that ends half a second after an uncertain start.
TEST(RecordDerivatives, AutomaticOnesAreFilterPassesWhereTheFilterStillLearns) {
  Comparison comparison;
  comparison.problem.settings.settle = 0.1;
  comparison.duration = 0.5;
  for (auto& unknown : comparison.problem.settings.unknowns) unknown.deviation = 2.0 * unknown.initial;
  expect_filter_passes(comparison, 0.1);
}

/// A second pass starts from where the first one ended, which moves with theta: runs with held gains do not follow it.
TEST(RecordDerivatives, AutomaticOnesAreFilterPassesOverSeveralPasses) {
  Comparison comparison;
  comparison.problem.settings.settle = 0.1;
  comparison.duration = 1.0;
  comparison.factors = {1.5, 0.5, 1.5};
  comparison.problem.settings.estimate_initial_state = true;
  comparison.problem.settings.passes = 2;
  expect_filter_passes(comparison, 0.1);
}

TEST(RecordDerivatives, GainsThatWouldTakeTooMuchMemoryAreNotHeld) {
  const Comparison comparison;
  // 24 states x 4 sensors x 2001 samples x 8 bytes
  const auto residual = comparison.residual(Derivatives::held_gains, 1e-4, 1.5e6);
  EXPECT_FALSE(residual.holds_gains());
  EXPECT_EQ(residual.derivatives(), "filter passes: held gains would take 0.0015 GB (at most 0.0015 GB)");
  EXPECT_TRUE(comparison.residual(Derivatives::held_gains, 1e-4, 1.6e6).holds_gains());
}

TEST(RecordDerivatives, WhereTheFilterFailsThereIsNoResidual) {
  Comparison comparison;
  comparison.factors[0] = -1.0;
  std::optional<RecordResidual> residual;
  try {
    residual.emplace(comparison.residual(Derivatives::held_gains_where_accurate));
  } catch (const InvalidInput&) {
    return;
  }
  EXPECT_FALSE(residual->evaluate(comparison.start(), true));
}

}  // namespace
}  // namespace kalfem::test
