// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <numbers>
#include <unsupported/Eigen/MatrixFunctions>

#include "identification/chain_structure.hpp"
#include "kalfem/system/signals/sampled.hpp"

// Two masses on linear springs under a force, with process noise and noisy sensors: the joint density of all samples is
// a normal one, found here from the matrices without a filter.

namespace kalfem::test {

constexpr double linear_rate = 50.0;  // [Hz]
constexpr Eigen::Index linear_samples = 80;

/// Numbers of the structure, its sensors and noise.
struct LinearNumbers {
  double lower_mass = 2.0, upper_stiffness = 300.0, lower_damping = 1.5;
  double gain = 1.0, noise = 2e-3, density = 0.2, offset = 0.0;
};

inline StructureParts linear_parts(const LinearNumbers& numbers) {
  LumpedSubstructure frame;
  frame.name = "frame";
  frame.masses = {{"1", numbers.lower_mass}, {"2", 1.0}};
  frame.springs = {{"a", "ground", "1", 400.0, numbers.lower_damping}, {"b", "1", "2", numbers.upper_stiffness, 0.5}};
  return {.substructures = {frame},
          .finite_elements = {},
          .connectors = {},
          .inputs = {{"f", InputKind::force, "frame.2"}}};
}

inline Eigen::VectorXd linear_force() {
  RandomStream random(3, "force");
  return Eigen::VectorXd::NullaryExpr(linear_samples, [&] { return 5.0 * random.normal(); });
}

/// A displacement "d" of the lower mass and an acceleration "a" of the upper one. All of LinearNumbers are unknowns.
inline EstimationProblem linear_problem(const LinearNumbers& numbers = {}) {
  auto structure = std::make_shared<StructureData>();
  structure->parts = linear_parts(numbers);
  structure->signals = {
      make_sampled(linear_force(), {.sample_rate = linear_rate, .interpolation = Interpolation::linear})};
  EstimationProblem problem{.structure = structure, .sample_rate = linear_rate};
  problem.sensors = {
      {.name = "d", .output = {"d", ObservedQuantity::displacement, {{"frame.1", 1.0}}}, .noise = 2e-3, .unit = "m"},
      {.name = "a",
       .output = {"a", ObservedQuantity::acceleration, {{"frame.2", 1.0}}},
       .noise = 0.1,
       .unit = "m/s^2"}};
  for (const auto& [name, deviation] :
       {std::pair{"frame.1.mass", 0.2}, {"frame.b.stiffness", 30.0}, {"frame.a.damping", 0.3}})
    problem.settings.unknowns.push_back(unknown(*structure, name, parameter(*structure, name).value, deviation));
  using enum LikelihoodUnknownKind;
  problem.settings.likelihood_unknowns = {{"gain", sensor_gain, {"d"}, "-", 1.0, 0.1},
                                          {"noise", sensor_noise, {"d"}, "m", numbers.noise, 1e-3},
                                          {"density", process_noise, {}, "m/s^2/sqrt(Hz)", numbers.density, 0.1}};
  problem.offsets = {{.name = "offset", .sensor = "d", .deviation = 1e-2}};
  problem.settings.initial_state = {{"all", {{0.0, 0.0, 1e-2, 5e-2}}}};
  problem.settings.process_noise.acceleration = numbers.density;
  problem.settings.threads = 1;
  return problem;
}

/// x+ = Phi x + begin u + end u+ + w,  y = H x + D u + v, exact for a force that is linear between samples.
struct LinearStateSpace {
  Eigen::MatrixXd Phi, Q, H;
  Eigen::VectorXd begin, end, D;

  explicit LinearStateSpace(const LinearNumbers& numbers) {
    using Eigen::MatrixXd;
    const double h = 1.0 / linear_rate, k = numbers.upper_stiffness;
    const MatrixXd inverse_mass = Eigen::Vector2d(1.0 / numbers.lower_mass, 1.0).asDiagonal();
    const MatrixXd K{{400.0 + k, -k}, {-k, k}}, C{{numbers.lower_damping + 0.5, -0.5}, {-0.5, 0.5}};
    MatrixXd A = MatrixXd::Zero(4, 4), B = MatrixXd::Zero(4, 1);
    A.topRightCorner(2, 2).setIdentity();
    A.bottomLeftCorner(2, 2) = -inverse_mass * K;
    A.bottomRightCorner(2, 2) = -inverse_mass * C;
    B(3, 0) = 1.0;
    MatrixXd hold = MatrixXd::Zero(6, 6);
    hold.topLeftCorner(4, 4) = h * A;
    hold.block(0, 4, 4, 1) = h * B;
    hold(4, 5) = 1.0;
    const MatrixXd held = hold.exp();
    Phi = held.topLeftCorner(4, 4);
    end = held.block(0, 5, 4, 1);
    begin = held.block(0, 4, 4, 1) - end;
    // [Van Loan 1978]: exp([-A W; 0 A^T] h) = [. G; 0 Phi^T], Q = Phi G.
    MatrixXd W = MatrixXd::Zero(4, 4);
    W(2, 2) = W(3, 3) = numbers.density * numbers.density;
    MatrixXd block = MatrixXd::Zero(8, 8);
    block << -A, W, MatrixXd::Zero(4, 4), A.transpose();
    Q = Phi * MatrixXd((h * block).exp()).topRightCorner(4, 4);
    H = MatrixXd::Zero(2, 4);
    H(0, 0) = 1.0;
    H.row(1) = A.row(3);
    D = Eigen::Vector2d(0.0, 1.0);
  }
};

/// Mean and covariance of all samples, sample by sample, recorded = gain signal + offset gain + noise.
inline Gaussian joint_density(const LinearNumbers& numbers) {
  using Eigen::Index;
  using Eigen::MatrixXd;
  using Eigen::VectorXd;
  const LinearStateSpace model(numbers);
  const VectorXd force = linear_force();
  const MatrixXd gain = Eigen::Vector2d(numbers.gain, 1.0).asDiagonal();
  const MatrixXd H = gain * model.H;
  Gaussian joint{VectorXd(2 * linear_samples), MatrixXd(2 * linear_samples, 2 * linear_samples)};
  VectorXd mean = VectorXd::Zero(4);
  MatrixXd P = Eigen::Vector4d(1e-4, 1e-4, 2.5e-3, 2.5e-3).asDiagonal();
  for (Index k = 0; k < linear_samples; ++k) {
    if (k > 0) {
      mean = model.Phi * mean + model.begin * force[k - 1] + model.end * force[k];
      P = model.Phi * P * model.Phi.transpose() + model.Q;
    }
    joint.mean.segment(2 * k, 2) = H * mean + gain * (model.D * force[k] + Eigen::Vector2d(numbers.offset, 0.0));
    MatrixXd cross = P;  // Cov(x_j, x_k)
    for (Index j = k; j < linear_samples; ++j, cross = model.Phi * cross) {
      joint.covariance.block(2 * j, 2 * k, 2, 2) = H * cross * H.transpose();
      joint.covariance.block(2 * k, 2 * j, 2, 2) = joint.covariance.block(2 * j, 2 * k, 2, 2).transpose();
    }
    joint.covariance(2 * k, 2 * k) += numbers.noise * numbers.noise;
    joint.covariance(2 * k + 1, 2 * k + 1) += 0.01;
  }
  return joint;
}

/// A draw of that density; missing samples where `with_gaps`.
inline Record linear_record(const LinearNumbers& numbers, std::uint64_t seed, bool with_gaps = false) {
  const Gaussian joint = joint_density(numbers);
  RandomStream random(seed, "joint");
  const Eigen::VectorXd normal = Eigen::VectorXd::NullaryExpr(joint.mean.size(), [&] { return random.normal(); });
  const Eigen::VectorXd drawn = joint.mean + joint.covariance.llt().matrixL() * normal;
  Record record{.sample_rate = linear_rate, .channels = {{"d", "m", 2e-3}, {"a", "m/s^2", 0.1}}};
  record.values = drawn.reshaped(2, linear_samples);
  if (!with_gaps) return record;
  record.values(0, 7) = record.values(1, 20) = std::numeric_limits<double>::quiet_NaN();
  record.values.middleCols(40, 3).setConstant(std::numeric_limits<double>::quiet_NaN());
  return record;
}

/// ln N of the samples that are there.
inline double dense_log_likelihood(const LinearNumbers& numbers, const Record& record) {
  const Gaussian joint = joint_density(numbers);
  const Eigen::VectorXd samples = record.values.reshaped();
  std::vector<Eigen::Index> there;
  for (Eigen::Index i = 0; i < samples.size(); ++i)
    if (std::isfinite(samples[i])) there.push_back(i);
  const Eigen::VectorXd departure = samples(there) - joint.mean(there);
  const Eigen::LLT<Eigen::MatrixXd> factor(joint.covariance(there, there));
  return -0.5 * departure.dot(factor.solve(departure)) - factor.matrixLLT().diagonal().array().log().sum() -
         0.5 * static_cast<double>(there.size()) * std::log(2.0 * std::numbers::pi);
}

}  // namespace kalfem::test
