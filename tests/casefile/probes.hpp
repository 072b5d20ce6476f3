// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cmath>

#include "casefile/case_sections.hpp"
#include "kalfem/steps/run_study.hpp"
#include "kalfem/steps/simulation/outcome.hpp"

/// Numbers of what is built from a case.
namespace kalfem::wiring {

constexpr double rounding = 1e-14;        ///< of a few operations: found 4e-16
constexpr double many_roundings = 1e-12;  ///< of filters, searches and eigenvalue problems: found up to 2e-14

/// Equal to rounding, or to the relative tolerance that is given.
inline void near(double found, double expected, double tolerance = rounding) {
  EXPECT_NEAR(found, expected, tolerance * std::max(std::abs(expected), 1e-300));
}

inline void near(const Eigen::VectorXd& found, const Eigen::VectorXd& expected, double tolerance = rounding) {
  ASSERT_EQ(found.size(), expected.size());
  EXPECT_LE((found - expected).norm(), tolerance * expected.norm())
      << "found " << found.transpose() << "\nexpected " << expected.transpose();
}

inline Eigen::VectorXd vector(std::initializer_list<double> values) {
  Eigen::VectorXd result(static_cast<Eigen::Index>(values.size()));
  std::ranges::copy(values, result.begin());
  return result;
}

inline const LocallyNonlinearSystem& system_of(const Study& study) { return study.model->system(); }
inline double mass(const Study& study, int i, int j) { return system_of(study).mass.coeff(i, j); }
inline double stiffness(const Study& study, int i, int j) { return system_of(study).stiffness.coeff(i, j); }
inline double damping(const Study& study, int i, int j) { return system_of(study).damping.coeff(i, j); }

/// Ratio to critical of each mode of the study's linear part, from Phi^T C Phi = 2 zeta omega.
inline Eigen::VectorXd modal_ratios(const Study& study) {
  const auto& system = system_of(study);
  const auto modes = normal_modes(system.mass, system.stiffness);
  const Eigen::VectorXd rates = (modes.shapes.transpose() * system.full_damping() * modes.shapes).diagonal();
  return rates.cwiseQuotient(4.0 * 3.14159265358979323846 * modes.frequencies);
}

/// Value, rate and acceleration of the first input at a time.
inline Eigen::Vector3d signal_at(const Study& study, double time, std::size_t input = 0) {
  return study.structure->signals.at(input)->sample(time, 1.0, 1).matrix().row(0).transpose();
}

/// Values of two signals at `count` times from 0 on are the same, and not all zero.
inline void same_signal(const Signal& found, const Signal& expected, double step = 0.01, Eigen::Index count = 60) {
  const Eigen::MatrixXd a = found.sample(0.0, step, count).matrix(), b = expected.sample(0.0, step, count).matrix();
  EXPECT_GT(b.col(0).norm(), 0.0);
  EXPECT_LE((a - b).norm(), rounding * b.norm());
}

inline StudyResults run(const Study& study, std::string_view verb) {
  StudyResults results = run_study(study, verb);
  EXPECT_TRUE(results.complete()) << results.failure;
  return results;
}

/// Simulated, free of noise: the record of the sensors, sensors x samples.
inline Eigen::MatrixXd clean_record(const Study& study) {
  return run(study, "simulate").get<SimulationOutcome>().reference.sensors;
}

inline double relative_difference(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return (a - b).norm() / std::max(a.norm(), b.norm());
}

}  // namespace kalfem::wiring
