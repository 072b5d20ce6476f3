// SPDX-License-Identifier: Apache-2.0
#include "true_system.hpp"

#include <cmath>
#include <numbers>
#include <stdexcept>

namespace kalfem::calibration {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr int stages = 3;

struct Tableau {
  Eigen::Matrix3d a;
  Eigen::Vector3d c;
};

Tableau radau() {
  const double s = std::sqrt(6.0);
  Tableau t;
  t.a << (88 - 7 * s) / 360, (296 - 169 * s) / 1800, (-2 + 3 * s) / 225, (296 + 169 * s) / 1800, (88 + 7 * s) / 360,
      (-2 - 3 * s) / 225, (16 - s) / 36, (16 + s) / 36, 1.0 / 9.0;
  t.c << (4 - s) / 10, (4 + s) / 10, 1.0;
  return t;
}

/// y = [x; x'; z] of the system, y' = F(t, y).
class FirstOrderForm {
public:
  explicit FirstOrderForm(const TrueSystem& system) : system_(system), inverse_mass_(system.mass.inverse()) {
    Index states = 0;
    for (const auto& each : system.local) places_.push_back(each.flow ? states++ : -1);
    size_ = 2 * system.dofs() + states;
    linear_ = MatrixXd::Zero(size_, size_);
    const Index n = system.dofs();
    linear_.block(0, n, n, n).setIdentity();
    linear_.block(n, 0, n, n) = -inverse_mass_ * system.stiffness;
    linear_.block(n, n, n, n) = -inverse_mass_ * system.damping;
    for (const auto& each : system.local) directions_.push_back(inverse_mass_ * each.shape);
  }

  [[nodiscard]] Index size() const { return size_; }

  [[nodiscard]] VectorXd loaded(double t) const { return inverse_mass_ * system_.load(t); }

  /// With M^-1 p at that time.
  [[nodiscard]] VectorXd flow(const VectorXd& load, const VectorXd& y) const {
    const Index n = system_.dofs();
    VectorXd f = linear_ * y;
    f.segment(n, n) += load;
    for (std::size_t j = 0; j < places_.size(); ++j) {
      const auto [d, v, z] = arguments(j, y);
      f.segment(n, n) -= directions_[j] * system_.local[j].force(d, v, z);
      if (places_[j] >= 0) f[2 * n + places_[j]] = system_.local[j].flow(d, v, z);
    }
    return f;
  }

  [[nodiscard]] VectorXd forces(const VectorXd& y) const {
    VectorXd forces(static_cast<Index>(places_.size()));
    for (std::size_t j = 0; j < places_.size(); ++j) {
      const auto [d, v, z] = arguments(j, y);
      forces[static_cast<Index>(j)] = system_.local[j].force(d, v, z);
    }
    return forces;
  }

  /// The largest displacement, velocity and state, each in the place of all of its kind.
  [[nodiscard]] VectorXd sizes(const VectorXd& y) const {
    const Index n = system_.dofs();
    VectorXd sizes = VectorXd::Constant(size_, 1e-9);
    sizes.head(n).array() += y.head(n).lpNorm<Eigen::Infinity>();
    sizes.segment(n, n).array() += y.segment(n, n).lpNorm<Eigen::Infinity>();
    if (size_ > 2 * n) sizes.tail(size_ - 2 * n).array() += y.tail(size_ - 2 * n).lpNorm<Eigen::Infinity>();
    return sizes;
  }

  [[nodiscard]] MatrixXd jacobian(const VectorXd& y) const {
    const Index n = system_.dofs();
    MatrixXd jacobian = linear_;
    for (std::size_t j = 0; j < places_.size(); ++j) {
      const auto [d, v, z] = arguments(j, y);
      const auto& local = system_.local[j];
      const auto slopes = [&](const auto& g) {
        const double hd = 1e-7 + 1e-6 * std::abs(d), hv = 1e-6 + 1e-6 * std::abs(v), hz = 1e-7 + 1e-6 * std::abs(z);
        return Eigen::Vector3d((g(d + hd, v, z) - g(d - hd, v, z)) / (2 * hd),
                               (g(d, v + hv, z) - g(d, v - hv, z)) / (2 * hv),
                               (g(d, v, z + hz) - g(d, v, z - hz)) / (2 * hz));
      };
      const Eigen::Vector3d f = slopes(local.force);
      jacobian.block(n, 0, n, n) -= f[0] * directions_[j] * local.shape.transpose();
      jacobian.block(n, n, n, n) -= f[1] * directions_[j] * local.shape.transpose();
      if (places_[j] < 0) continue;
      const Index state = 2 * n + places_[j];
      jacobian.block(n, state, n, 1) -= f[2] * directions_[j];
      const Eigen::Vector3d g = slopes(local.flow);
      jacobian.block(state, 0, 1, n) = g[0] * local.shape.transpose();
      jacobian.block(state, n, 1, n) = g[1] * local.shape.transpose();
      jacobian(state, state) = g[2];
    }
    return jacobian;
  }

private:
  struct Arguments {
    double d, v, z;
  };
  [[nodiscard]] Arguments arguments(std::size_t j, const VectorXd& y) const {
    const Index n = system_.dofs();
    const auto& b = system_.local[j].shape;
    return {b.dot(y.head(n)), b.dot(y.segment(n, n)), places_[j] >= 0 ? y[2 * n + places_[j]] : 0.0};
  }

  const TrueSystem& system_;
  MatrixXd inverse_mass_, linear_;
  std::vector<VectorXd> directions_;
  std::vector<Index> places_;  ///< of each local force's state; -1: it has none
  Index size_ = 0;
};

/// One step after the other, the Newton matrix kept as long as it converges.
class Radau {
public:
  Radau(const FirstOrderForm& form, double step)
      : form_(form), step_(step), tableau_(radau()), increments_(MatrixXd::Zero(form.size(), stages)) {}

  void advance(VectorXd& y, double t) {
    if (!has_matrix_) refresh(y);
    if (!solve(y, t)) {
      refresh(y);
      increments_.setZero();
      solve(y, t);  // at a kink of a law: what forty iterations gave
    }
    y += increments_.col(stages - 1);
  }

private:
  void refresh(const VectorXd& y) {
    const Index n = form_.size();
    const MatrixXd jacobian = form_.jacobian(y);
    MatrixXd matrix = MatrixXd::Identity(stages * n, stages * n);
    for (int i = 0; i < stages; ++i)
      for (int j = 0; j < stages; ++j) matrix.block(i * n, j * n, n, n) -= step_ * tableau_.a(i, j) * jacobian;
    factor_.compute(matrix);
    has_matrix_ = true;
  }

  /// Z_i = h sum_j a_ij F(t + c_j h, y + Z_j).
  bool solve(const VectorXd& y, double t) {
    const Index n = form_.size();
    std::array<VectorXd, stages> loads;
    for (int j = 0; j < stages; ++j) loads[static_cast<std::size_t>(j)] = form_.loaded(t + tableau_.c[j] * step_);
    MatrixXd flows(n, stages);
    const VectorXd tolerance = form_.sizes(y) * 1e-11;
    for (int iteration = 0; iteration < 40; ++iteration) {
      for (int j = 0; j < stages; ++j)
        flows.col(j) = form_.flow(loads[static_cast<std::size_t>(j)], y + increments_.col(j));
      const MatrixXd residual = step_ * flows * tableau_.a.transpose() - increments_;
      const VectorXd change = factor_.solve(Eigen::Map<const VectorXd>(residual.data(), residual.size()));
      increments_ += Eigen::Map<const MatrixXd>(change.data(), n, stages);
      const Eigen::Map<const MatrixXd> last(change.data(), n, stages);
      if ((last.rowwise().norm().array() <= tolerance.array()).all()) return true;
    }
    return false;
  }

  const FirstOrderForm& form_;
  double step_;
  Tableau tableau_;
  MatrixXd increments_;
  Eigen::PartialPivLU<MatrixXd> factor_;
  bool has_matrix_ = false;
};

}  // namespace

TrueMotion integrate(const TrueSystem& system, double rate, Index samples, int steps) {
  const FirstOrderForm form(system);
  const double step = 1.0 / (rate * steps);
  Radau radau(form, step);
  const Index n = system.dofs();
  TrueMotion motion{MatrixXd(n, samples), MatrixXd(n, samples), MatrixXd(n, samples),
                    MatrixXd(static_cast<Index>(system.local.size()), samples)};
  VectorXd y = VectorXd::Zero(form.size());
  for (Index k = 0; k < samples; ++k) {
    const double t = static_cast<double>(k) / rate;
    motion.displacement.col(k) = y.head(n);
    motion.velocity.col(k) = y.segment(n, n);
    motion.acceleration.col(k) = form.flow(form.loaded(t), y).segment(n, n);
    motion.force.col(k) = form.forces(y);
    for (int i = 0; i < steps; ++i) radau.advance(y, t + i * step);
  }
  if (!motion.acceleration.allFinite()) throw std::runtime_error("the true motion is not finite");
  return motion;
}

VectorXd frequencies(const TrueSystem& system) {
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> eigen(system.stiffness, system.mass, Eigen::EigenvaluesOnly);
  return eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt() / (2.0 * std::numbers::pi);
}

}  // namespace kalfem::calibration
