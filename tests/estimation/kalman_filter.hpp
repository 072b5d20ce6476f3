// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <numbers>

#include "estimation/chain_model.hpp"

namespace kalfem {

/// A discrete linear model x+ = Phi x + drive(u, u+) + w, y = H x + D u + v.
struct LinearProblem {
  Eigen::MatrixXd Phi, begin, end, H, D, Q, R;

  [[nodiscard]] Eigen::VectorXd drive(const Eigen::VectorXd& u0, const Eigen::VectorXd& u1) const {
    return begin * u0 + end * u1;
  }
};

/// The filter as textbooks print it (Bar-Shalom, Li and Kirubarajan 2001, section 5.2), rows that are not a number left
/// out.
struct KalmanFilter {
  Eigen::VectorXd x;
  Eigen::MatrixXd P;
  double log_likelihood = 0.0;
  double nis = 0.0;

  void predict(const LinearProblem& problem, const Eigen::VectorXd& drive) {
    x = problem.Phi * x + drive;
    P = problem.Phi * P * problem.Phi.transpose() + problem.Q;
  }

  void update(const LinearProblem& problem, const Eigen::VectorXd& u, const Eigen::VectorXd& y) {
    std::vector<Eigen::Index> rows;
    for (Eigen::Index i = 0; i < y.size(); ++i)
      if (std::isfinite(y[i])) rows.push_back(i);
    if (rows.empty()) return;
    const Eigen::MatrixXd H = problem.H(rows, Eigen::all);
    const Eigen::VectorXd innovation = y(rows) - H * x - problem.D(rows, Eigen::all) * u;
    const Eigen::MatrixXd S = H * P * H.transpose() + problem.R(rows, rows), K = P * H.transpose() * S.inverse();
    nis = innovation.dot(S.inverse() * innovation);
    log_likelihood -= 0.5 * (nis + std::log(S.determinant()) + double(rows.size()) * std::log(2 * std::numbers::pi));
    x += K * innovation;
    P = ((Eigen::MatrixXd::Identity(x.size(), x.size()) - K * H) * P).eval();
    P = (0.5 * (P + P.transpose())).eval();
  }
};

/// The augmented model's discrete model where every connector is a spring k and dashpot c: f = F x + F_u u closes the
/// loop of
///     x1 = A x0 + G_0 f0 + G_1 f1 + B_0 u0 + B_1 u1.
inline LinearProblem closed_loop(const AugmentedModel& augmented_model, const Eigen::MatrixXd& R) {
  const ExactStep step(augmented_model.form(), augmented_model.step().step);
  const auto& motion = augmented_model.form().motion();
  const auto& outputs = augmented_model.form().outputs();
  const auto& connectors = augmented_model.system().connectors;
  const auto m = static_cast<Eigen::Index>(connectors.size()), n = augmented_model.form().size();
  Eigen::MatrixXd F(m, n), F_u(m, motion.input.cols());
  for (Eigen::Index j = 0; j < m; ++j) {
    const auto& p = connectors[std::size_t(j)].parameters;
    F.row(j) = p[0] * motion.state.row(j) + p[1] * motion.state.row(m + j);
    F_u.row(j) = p[0] * motion.input.row(j) + p[1] * motion.input.row(m + j);
  }
  const Eigen::MatrixXd loop = (Eigen::MatrixXd::Identity(n, n) - step.end_force * F).inverse();
  return {loop * (step.transition + step.begin_force * F),
          loop * (step.begin_input + step.begin_force * F_u),
          loop * (step.end_input + step.end_force * F_u),
          outputs.state + outputs.force * F,
          outputs.input + outputs.force * F_u,
          augmented_model.process_noise().topLeftCorner(n, n),
          R};
}

/// A draw from N(0, P).
inline Eigen::VectorXd draw(RandomStream& random, const Eigen::MatrixXd& P) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(P);
  const Eigen::VectorXd normal = Eigen::VectorXd::NullaryExpr(P.rows(), [&] { return random.normal(); });
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().cwiseProduct(normal);
}

/// A record of the linear problem itself: start from the prior, process and measurement noise as stated.
inline FilterInput draw_record(const LinearProblem& problem, const Gaussian& prior, const Eigen::MatrixXd& inputs,
                               std::uint64_t seed) {
  RandomStream random(seed, "linear record");
  FilterInput record{{.values = Eigen::MatrixXd(problem.H.rows(), inputs.cols())}, inputs, problem.R};
  Eigen::VectorXd x = prior.mean + draw(random, prior.covariance);
  for (Eigen::Index k = 0; k < inputs.cols(); ++k) {
    if (k > 0) x = problem.Phi * x + problem.drive(inputs.col(k - 1), inputs.col(k)) + draw(random, problem.Q);
    record.measured.values.col(k) = problem.H * x + problem.D * inputs.col(k) + draw(random, problem.R);
  }
  return record;
}

}  // namespace kalfem
