// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <numbers>

#include "evidence_cases.hpp"

namespace kalfem {

/// y = A theta + e, e ~ N(0, sigma^2 I), theta ~ N(m, D^2): posterior and evidence in closed form. The columns of A are
/// far from orthogonal.
inline EvidenceCase linear_gaussian_case(int p) {
  const int rows = p + 3;
  constexpr double sigma = 0.4;
  Eigen::MatrixXd a(rows, p);
  Eigen::VectorXd y(rows), m(p), d(p);
  for (int i = 0; i < rows; ++i) {
    y[i] = 1.0 + 0.5 * std::sin(2.0 * i);
    for (int j = 0; j < p; ++j) a(i, j) = 0.4 + std::cos(1.0 + i * (j + 1.0));
  }
  Named<MarginalPrior> marginals;
  for (int j = 0; j < p; ++j) {
    m[j] = 0.3 * j - 0.5;
    d[j] = 1.0 + 0.2 * j;
    marginals.emplace_back("x" + std::to_string(j + 1), NormalPrior{m[j], d[j]});
  }
  const Eigen::VectorXd prior_information = d.array().square().inverse();
  Eigen::MatrixXd information = a.transpose() * a / (sigma * sigma);
  information.diagonal() += prior_information;
  const Eigen::MatrixXd covariance = information.inverse();
  const Eigen::VectorXd mean = covariance * (a.transpose() * y / (sigma * sigma) + prior_information.cwiseProduct(m));
  Eigen::MatrixXd of_data = a * d.array().square().matrix().asDiagonal() * a.transpose();
  of_data.diagonal().array() += sigma * sigma;
  const Eigen::LLT<Eigen::MatrixXd> factor(of_data);
  const Eigen::VectorXd off = y - a * m;
  const double log_evidence = -0.5 * off.dot(factor.solve(off)) - factor.matrixLLT().diagonal().array().log().sum() -
                              0.5 * rows * std::log(2.0 * std::numbers::pi);
  const auto likelihood = [=](const Eigen::VectorXd& x) {
    const Eigen::VectorXd e = y - a * x;
    return -0.5 * e.squaredNorm() / (sigma * sigma) - rows * (std::log(sigma) + 0.5 * std::log(2.0 * std::numbers::pi));
  };
  return {"linear-Gaussian, p = " + std::to_string(p),
          {JointPrior(std::move(marginals)), likelihood},
          log_evidence,
          mean,
          covariance.diagonal().cwiseSqrt()};
}

}  // namespace kalfem
