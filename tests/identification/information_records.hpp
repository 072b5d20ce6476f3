// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "identification/chain_structure.hpp"
#include "kalfem/base/parallel.hpp"
#include "kalfem/identification/fisher_information.hpp"

// Fisher information against the curvature of log-likelihoods over many records.

namespace kalfem::test {

/// -d^2 ln p / dtheta_i dtheta_j by central differences with the steps h.
inline Eigen::MatrixXd negative_hessian(const FilterLikelihood& likelihood, const Eigen::VectorXd& theta,
                                        const Eigen::VectorXd& h) {
  using Eigen::Index;
  const auto at = [&](Index i, double a, Index j, double b) {
    Eigen::VectorXd there = theta;
    there[i] += a * h[i];
    there[j] += b * h[j];
    return likelihood.log_likelihood(there);
  };
  const double here = likelihood.log_likelihood(theta);
  Eigen::MatrixXd hessian(theta.size(), theta.size());
  for (Index i = 0; i < theta.size(); ++i) {
    hessian(i, i) = (2.0 * here - at(i, 1, i, 0) - at(i, -1, i, 0)) / (h[i] * h[i]);
    for (Index j = 0; j < i; ++j)
      hessian(i, j) = hessian(j, i) =
          (at(i, 1, j, -1) + at(i, -1, j, 1) - at(i, 1, j, 1) - at(i, -1, j, -1)) / (4.0 * h[i] * h[j]);
  }
  return hessian;
}

/// Mean of a matrix over seeds, with the standard deviation of each entry of the mean.
struct MeanOverSeeds {
  Eigen::MatrixXd mean, deviation;

  template <class Draw>
  MeanOverSeeds(int seeds, const Draw& draw) {
    std::vector<Eigen::MatrixXd> all(static_cast<std::size_t>(seeds));
    for_each_index(all.size(), processors(), [&](std::size_t i) { all[i] = draw(static_cast<std::uint64_t>(i + 1)); });
    mean = Eigen::MatrixXd::Zero(all[0].rows(), all[0].cols());
    Eigen::MatrixXd squares = mean;
    for (const auto& each : all) mean += each / seeds;
    for (const auto& each : all) squares += (each - mean).cwiseAbs2();
    deviation = (squares / (seeds * (seeds - 1.0))).cwiseSqrt();
  }
};

/// Largest |value - reference| over sqrt(reference_ii reference_jj).
inline double largest_error(const Eigen::MatrixXd& value, const Eigen::MatrixXd& reference) {
  const Eigen::VectorXd scale = reference.diagonal().cwiseSqrt().cwiseInverse();
  return (scale.asDiagonal() * (value - reference) * scale.asDiagonal()).cwiseAbs().maxCoeff();
}

/// The chain with three unknowns, all of them named, under known noise.
struct InformedChain {
  static constexpr double noise = 3.0;  ///< [m/s^2], as large as the signals
  InformedChain() {
    problem.settings.substeps = 4;
    problem.settings.unknowns.push_back(unknown(*problem.structure, "body.3-4.stiffness", body_stiffness, 3e3));
    for (std::size_t i = 0; i < 4; ++i) {
      problem.sensors[i].relative_noise = false;
      problem.sensors[i].noise = noise;
    }
    clean = chain_record(problem, 2.0, false);
  }

  [[nodiscard]] Record record(std::uint64_t seed) const {
    Record noisy = clean;
    RandomStream random(seed, "noise");
    for (double& sample : noisy.values.reshaped()) sample += noise * random.normal();
    return noisy;
  }
  [[nodiscard]] FilterLikelihood likelihood(const Record& of) const { return {shared(problem), of, names}; }

  EstimationProblem problem = chain_problem();
  Record clean;
  std::vector<std::string> names{"suspension.mu_k1", "suspension.mu_c1", "body.3-4.stiffness"};
  Eigen::VectorXd truth{{true_mu_k1, true_mu_c1, body_stiffness}};
  Eigen::VectorXd steps = Eigen::Vector3d(0.02, 0.02, 0.002).cwiseProduct(truth);
};

}  // namespace kalfem::test
