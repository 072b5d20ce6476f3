#include "kalfem/system/connector_forces.hpp"

namespace kalfem {

using Eigen::ArrayXXd;
using Eigen::Index;
using Eigen::MatrixXd;

namespace {

// Whole-array tests as arithmetic reductions: these run over vector registers, Eigen's all() and any() entry by entry.

bool all_finite(const ArrayXXd& values) { return (0.0 * values).sum() == 0.0; }

/// Whether a > b anywhere; false where it is undefined.
template <class A, class B>
bool exceeds(const A& a, const B& b) {
  return (a - b).max(0.0).sum() > 0.0;
}

}  // namespace

void add_scaled(double factor, const ArrayXXd& from, Index from_column, ArrayXXd& to, Index to_column) {
  if (factor == 0.0) return;
  const double* in = &from(0, from_column);
  double* out = &to(0, to_column);
#pragma GCC ivdep
  for (Index i = 0; i < to.rows(); ++i) out[i] += factor * in[i];
}

ConnectorForces::ConnectorForces(const LocallyNonlinearSystem& system, ForceSolveOptions options) : options_(options) {
  for (const auto& connector : system.connectors) {
    laws_.push_back(connector.law);
    nominal_.push_back(connector.parameters);
    state_offset_.push_back(state_count_);
    state_count_ += static_cast<Index>(connector.law->states().size());
  }
  resize(1);
}

void ConnectorForces::resize(Index points) {
  const auto m = static_cast<Index>(laws_.size());
  parameters_.clear();
  for (const auto& values : nominal_) parameters_.emplace_back(values.transpose().array().replicate(points, 1));
  for (auto* motion : {&free_motion_, &begin_motion_, &motion_, &tangents_}) *motion = ArrayXXd::Zero(points, 3 * m);
  for (auto* states : {&begin_states_, &states_}) *states = ArrayXXd::Zero(points, state_count_);
  for (auto* forces : {&force_, &law_force_, &correction_, &residual_, &previous_residual_})
    *forces = ArrayXXd::Zero(points, m);
  jacobian_ = MatrixXd::Identity(m, m);
  factor_ = Eigen::PartialPivLU<MatrixXd>(m);
  small_ = Eigen::VectorXd::Zero(m);
}

ForceSolveOutcome ConnectorForces::solve(const MatrixXd& compliance, double duration) {
  ForceSolveOutcome outcome;
  if (laws_.empty()) return outcome;
  set_motion(compliance);
  respond(duration);
  if (!feels_its_forces(compliance)) {
    force_ = law_force_;
    outcome.finite = all_finite(force_);
    return outcome;
  }
  residual_ = law_force_ - force_;
  for (;;) {
    const bool done = correct(compliance);
    set_motion(compliance);
    if (done) break;
    respond(duration);
    previous_residual_.swap(residual_);
    residual_ = law_force_ - force_;
    if (++outcome.iterations >= options_.max_iterations) {
      outcome.converged = bisect(compliance, duration);
      break;
    }
    for (int halvings = 0; halvings < 8 && exceeds(residual_.abs(), growth_limit()); ++halvings) {
      halve_where_worse();
      set_motion(compliance);
      respond(duration);
      residual_ = law_force_ - force_;
    }
  }
  outcome.finite = all_finite(force_) && all_finite(states_);
  return outcome;
}

/// Whether the laws see a motion that depends on the forces themselves: not at an instant, where only d'' does, unless
/// some law uses it.
bool ConnectorForces::feels_its_forces(const MatrixXd& compliance) const {
  const Index m = force_.cols();
  return !compliance.topRows(2 * m).isZero(0.0) || !(tangents_.rightCols(m).abs().sum() == 0.0);
}

void ConnectorForces::set_motion(const MatrixXd& compliance) {
  motion_ = free_motion_;
  for (Index row = 0; row < motion_.cols(); ++row)
    for (Index j = 0; j < force_.cols(); ++j) add_scaled(compliance(row, j), force_, j, motion_, row);
}

void ConnectorForces::respond(double duration) {
  const Index m = force_.cols();
  for (Index j = 0; j < m; ++j) {
    const auto& law = *laws_[static_cast<std::size_t>(j)];
    const Index offset = state_offset_[static_cast<std::size_t>(j)], count = static_cast<Index>(law.states().size());
    law.respond({duration, parameters_[static_cast<std::size_t>(j)], begin_motion_.col(j), begin_motion_.col(m + j),
                 begin_states_.middleCols(offset, count), motion_.col(j), motion_.col(m + j), motion_.col(2 * m + j)},
                {law_force_.col(j), tangents_.col(j), tangents_.col(m + j), tangents_.col(2 * m + j),
                 states_.middleCols(offset, count)});
  }
}

/// One Newton correction of f - law(k_free + H f) = 0; true when it was small enough to be the last, or not
/// finite.
bool ConnectorForces::correct(const MatrixXd& compliance) {
  if (force_.cols() == 1)
    correct_single(compliance);
  else
    correct_coupled(compliance);
  force_ += correction_;
  return !exceeds(correction_.abs(), options_.tolerance * (force_.abs() + options_.force_floor));
}

void ConnectorForces::correct_single(const MatrixXd& compliance) {
  correction_.col(0) = residual_.col(0) / (1.0 - compliance(0, 0) * tangents_.col(0) -
                                           compliance(1, 0) * tangents_.col(1) - compliance(2, 0) * tangents_.col(2));
}

void ConnectorForces::correct_coupled(const MatrixXd& compliance) {
  const Index m = force_.cols();
  for (Index point = 0; point < force_.rows(); ++point) {
    for (Index j = 0; j < m; ++j) {
      jacobian_.row(j) = -(tangents_(point, j) * compliance.row(j) + tangents_(point, m + j) * compliance.row(m + j) +
                           tangents_(point, 2 * m + j) * compliance.row(2 * m + j));
      jacobian_(j, j) += 1.0;
    }
    small_ = residual_.row(point).transpose().matrix();
    factor_.compute(jacobian_);
    correction_.row(point) = factor_.solve(small_).transpose().array();
  }
}

/// Takes back half of the last correction at the points where it made any residual worse.
void ConnectorForces::halve_where_worse() {
  for (Index point = 0; point < force_.rows(); ++point) {
    if (!(residual_.row(point).abs() > growth_limit().row(point)).any()) continue;
    correction_.row(point) *= 0.5;
    force_.row(point) -= correction_.row(point);
  }
}

/// Where Newton's method runs to and fro across a kink: each connector in turn by bisection, until none moves. Sure for
/// laws that rise with d, d' and d'' (their compliance is negative), which joints, stops and friction do.
bool ConnectorForces::bisect(const MatrixXd& compliance, double duration) {
  for (int sweep = 0; sweep < 200; ++sweep) {
    const ArrayXXd before = force_;
    for (Index j = 0; j < force_.cols(); ++j) bisect(j, compliance, duration);
    if (!exceeds((force_ - before).abs(), options_.tolerance * (force_.abs() + options_.force_floor))) break;
  }
  residual_ = law_force_ - force_;
  return !exceeds(residual_.abs(), 1e-6 * (force_.abs() + options_.force_floor));
}

/// f - law(k_free + H f) rises with f by 1 at least, so its root lies no farther from f than its value there.
void ConnectorForces::bisect(Index j, const MatrixXd& compliance, double duration) {
  set_motion(compliance);
  respond(duration);
  Eigen::ArrayXd lower = force_.col(j).min(law_force_.col(j)), upper = force_.col(j).max(law_force_.col(j));
  for (int halving = 0; halving < 100; ++halving) {
    force_.col(j) = 0.5 * (lower + upper);
    if ((force_.col(j) == lower || force_.col(j) == upper).all()) break;
    set_motion(compliance);
    respond(duration);
    lower = (law_force_.col(j) >= force_.col(j)).select(force_.col(j), lower);
    upper = (law_force_.col(j) >= force_.col(j)).select(upper, force_.col(j));
  }
  set_motion(compliance);
  respond(duration);
}

}  // namespace kalfem
