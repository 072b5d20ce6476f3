// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "kalfem/sampling/posterior.hpp"

// Posteriors whose evidence is known from quadrature or in closed form.

namespace kalfem {

struct EvidenceCase {
  std::string name;
  Posterior posterior;
  double log_evidence = 0.0;
  Eigen::VectorXd mean = {};       ///< of the parameters, where it is known
  Eigen::VectorXd deviation = {};  ///< the same
};

inline double log_normal(double x, double mean, double deviation) {
  const double score = (x - mean) / deviation;
  return -0.5 * score * score - std::log(deviation) - 0.5 * std::log(2.0 * std::numbers::pi);
}

inline JointPrior uniform_box(int dimension, double lower, double upper) {
  Named<MarginalPrior> marginals;
  for (int i = 0; i < dimension; ++i) marginals.emplace_back("x" + std::to_string(i + 1), UniformPrior{lower, upper});
  return JointPrior(std::move(marginals));
}

/// First eigenvalue and ratio phi_2 / phi_1 of the first mode of K = [[k1 + k2, -k2], [-k2, k2]], M = diag(m1, m2).
struct FirstMode {
  double eigenvalue = 0.0, ratio = 0.0;
};

inline FirstMode first_mode(const Eigen::VectorXd& k, double m1, double m2) {
  const double a = (k[0] + k[1]) / m1, b = k[1] / m2, coupling = k[1] * k[1] / (m1 * m2);
  const double eigenvalue = 0.5 * (a + b) - std::sqrt(0.25 * (a - b) * (a - b) + coupling);
  return {eigenvalue, (k[0] + k[1] - m1 * eigenvalue) / k[1]};
}

struct ModalData {
  double m1, m2;
  std::array<double, 5> eigenvalues, ratios;
  double eigenvalue_deviation, ratio_deviation;

  double operator()(const Eigen::VectorXd& k) const {
    const FirstMode mode = first_mode(k, m1, m2);
    double sum = 0.0;
    for (const double value : eigenvalues) sum += log_normal(value, mode.eigenvalue, eigenvalue_deviation);
    for (const double value : ratios) sum += log_normal(value, mode.ratio, ratio_deviation);
    return sum;
  }
};

/// Yuen (2010), Bayesian Methods for Structural Dynamics and Civil Engineering, section 2.4: two degrees of freedom.
inline EvidenceCase yuen_case() {
  return {"Yuen, 2 DOF",
          {JointPrior({{"k1", UniformPrior{0.8, 2.2}}, {"k2", UniformPrior{0.4, 1.2}}}),
           ModalData{1.0,
                     1.0,
                     {.3860, .3922, .4157, .3592, .3615},
                     {1.68245252, 1.71103903, 1.57876073, 1.58722342, 1.61878479},
                     .0191,
                     .0809}},
          14.01714,
          Eigen::Vector2d(1.00860, .99067),
          Eigen::Vector2d(.02644, .04156)};
}

inline EvidenceCase frame_case() {
  return {"two-storey frame",
          {JointPrior({{"k1", UniformPrior{500.0, 1500.0}}, {"k2", UniformPrior{500.0, 1500.0}}}),
           ModalData{
               .52, .26, {1025.21, 1138.11, 1099.39, 1002.41, 1052.69}, {1.53, 1.24, 1.38, 1.50, 1.35}, 54.203, .0705}},
          -28.28331,
          Eigen::Vector2d(939.472, 980.548),
          Eigen::Vector2d(23.128, 61.801)};
}

/// Two shells of radius 2 and width 0.1 about -3.5 and 3.5 on the first axis (Feroz and Hobson 2008, MNRAS 384, 449).
inline EvidenceCase shells_case(int dimension, double log_evidence) {
  const auto likelihood = [](const Eigen::VectorXd& x) {
    const auto shell = [&](double centre) {
      const double first = x[0] - centre;
      return log_normal(std::sqrt(x.squaredNorm() - x[0] * x[0] + first * first), 2.0, 0.1);
    };
    const double left = shell(-3.5), right = shell(3.5);
    return std::max(left, right) + std::log1p(std::exp(-std::abs(left - right)));
  };
  return {"Gaussian shells, n = " + std::to_string(dimension),
          {uniform_box(dimension, -6.0, 6.0), likelihood},
          log_evidence};
}

inline EvidenceCase eggbox_case() {
  const auto likelihood = [](const Eigen::VectorXd& x) {
    return std::pow(2.0 + std::cos(0.5 * x[0]) * std::cos(0.5 * x[1]), 5.0);
  };
  return {"eggbox", {uniform_box(2, 0.0, 10.0 * std::numbers::pi), likelihood}, 235.8559};
}

inline EvidenceCase blobs_case() {
  const auto likelihood = [](const Eigen::VectorXd& x) {
    const auto blob = [&](double centre) { return -50.0 * (x.array() - centre).square().sum(); };
    const double one = blob(1.0), other = blob(-1.0);
    return std::max(one, other) + std::log1p(std::exp(-std::abs(one - other)));
  };
  return {"two blobs", {uniform_box(2, -5.0, 5.0), likelihood}, -6.679};
}

/// Two parameters along a parabola, b = c (a^2 - 1) +- 0.1; ln Z by quadrature over a.
inline EvidenceCase banana_case(double curvature) {
  const auto likelihood = [=](const Eigen::VectorXd& x) {
    return log_normal(x[1] - curvature * (x[0] * x[0] - 1.0), 0.0, 0.1);
  };
  constexpr int points = 20001;
  double sum = 0.0;
  for (int k = 0; k < points; ++k) {
    const double a = -10.0 + 20.0 * k / (points - 1);
    sum += std::exp(log_normal(a, 0.0, 1.0) + log_normal(curvature * (a * a - 1.0), 0.0, std::sqrt(100.01)));
  }
  return {"parabola, curvature " + std::to_string(curvature).substr(0, 4),
          {JointPrior({{"a", NormalPrior{0.0, 1.0}}, {"b", NormalPrior{0.0, 10.0}}}), likelihood},
          std::log(sum * 20.0 / (points - 1))};
}

/// Data that determine only the sum of two parameters: Z = E[1 - |s|] of the sum's error s.
inline EvidenceCase ridge_case() {
  return {"ridge",
          {uniform_box(2, 0.0, 1.0), [](const Eigen::VectorXd& x) { return log_normal(x[0] + x[1], 1.0, 0.01); }},
          std::log(1.0 - 0.01 * std::sqrt(2.0 / std::numbers::pi))};
}

}  // namespace kalfem
