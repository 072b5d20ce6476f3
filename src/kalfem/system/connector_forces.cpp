// SPDX-License-Identifier: Apache-2.0
#include "kalfem/system/connector_forces.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "kalfem/base/vector_loops.hpp"
#include "kalfem/system/force_correction.hpp"

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

/// Whether any of the first rows' entries is not zero.
bool has_entries(const MatrixXd& matrix, Index rows) {
  for (Index column = 0; column < matrix.cols(); ++column)
    for (Index row = 0; row < rows; ++row)
      if (matrix(row, column) != 0.0) return true;
  return false;
}

}  // namespace

void add_scaled(double factor, const ArrayXXd& from, Index from_column, ArrayXXd& to, Index to_column) {
  if (factor == 0.0) return;
  const double* in = &from(0, from_column);
  double* out = &to(0, to_column);
  KALFEM_INDEPENDENT
  for (Index i = 0; i < to.rows(); ++i) out[i] += factor * in[i];
}

/// The iteration on arrays in blocks of points.
class ConnectorForces::Solver {
public:
  Solver(const std::vector<Connector>& connectors, const ForceSolveOptions& options, const PointBlocks& blocks,
         Index instants)
      : options_(options),
        blocks_(blocks),
        laws_(connectors, blocks, instants),
        newton_(static_cast<Index>(connectors.size()), blocks),
        uses_acceleration_(std::ranges::any_of(
            connectors, [](const Connector& connector) { return connector.law->uses_acceleration(); })),
        free_motion_(laws_.motion) {
    for (auto* forces : {&force_, &next_force_, &correction_, &next_correction_, &residual_, &next_residual_})
      *forces = laws_.force;
  }

  ForceSolveOutcome solve(ConnectorForces& outer, const MatrixXd& compliance, double duration);

private:
  void read_interval(ConnectorForces& outer);
  void read_guess(const ConnectorForces& outer);
  void write(ConnectorForces& outer) const;
  void take_law_force(const MatrixXd& compliance, const ArrayXXd& free_motion);
  [[nodiscard]] bool has_inertance() const;
  ForceSolveOutcome iterate(const MatrixXd& compliance, double duration);
  void forget_residual() { residual_.setConstant(std::numeric_limits<double>::infinity()); }
  ForceIterate iterate_at(const MatrixXd& compliance);
  void take_correction();
  void evaluate(const MatrixXd& compliance, double duration);
  void back_off(const MatrixXd& compliance, double duration);
  void halve_where_worse();
  /// Residuals above this grew by a correction, and not by rounding alone.
  auto growth_limit() const { return 2.0 * residual_ + options_.tolerance * (force_.abs() + options_.force_floor); }
  [[nodiscard]] bool residual_grew() const { return exceeds(next_residual_, growth_limit()); }
  [[nodiscard]] bool bisect(const MatrixXd& compliance, double duration);
  void bisect(Index connector, const MatrixXd& compliance, double duration);
  [[nodiscard]] bool crosses(Index connector, const MatrixXd& compliance, double duration);

  ForceSolveOptions options_;
  PointBlocks blocks_;
  ConnectorResponse laws_;
  ForceCorrection newton_;
  bool uses_acceleration_;
  ArrayXXd free_motion_;
  ArrayXXd force_, next_force_;            ///< f, and f + c
  ArrayXXd correction_, next_correction_;  ///< what led to f, and c
  ArrayXXd residual_, next_residual_;      ///< |law - f| before and after the correction that led to f
};

ConnectorForces::ConnectorForces(const LocallyNonlinearSystem& system, ForceSolveOptions options, Index instants)
    : options_(options), instants_(instants) {
  for (Index instant = 0; instant < instants; ++instant)
    for (const auto& connector : system.connectors)
      connectors_.push_back({connector.name, connector.law, connector.parameters, {}, {}});
  resize(1);
}

ConnectorForces::ConnectorForces(ConnectorForces&&) noexcept = default;
ConnectorForces& ConnectorForces::operator=(ConnectorForces&&) noexcept = default;
ConnectorForces::~ConnectorForces() = default;

void ConnectorForces::resize(Index points) {
  const auto m = static_cast<Index>(connectors_.size());
  Index parameter_count = 0, state_count = 0;
  first_parameter_.clear();
  for (const auto& connector : connectors_) {
    first_parameter_.push_back(parameter_count);
    parameter_count += connector.parameters.size();
    state_count += static_cast<Index>(connector.law->states().size());
  }
  parameters_.resize(points, parameter_count);
  for (std::size_t j = 0; j < connectors_.size(); ++j) {
    const auto& values = connectors_[j].parameters;
    parameters_.middleCols(first_parameter_[j], values.size()) = values.transpose().array().replicate(points, 1);
  }
  parameter_changed_.assign(static_cast<std::size_t>(parameter_count), 1);
  for (auto* motion : {&free_motion_, &begin_motion_, &motion_}) *motion = ArrayXXd::Zero(points, 3 * m);
  for (auto* states : {&begin_states_, &states_}) *states = ArrayXXd::Zero(points, state_count);
  force_ = ArrayXXd::Zero(points, m);
  solver_ = std::make_unique<Solver>(connectors_, options_, PointBlocks(points), instants_);
}

ForceSolveOutcome ConnectorForces::solve(const MatrixXd& compliance, double duration) {
  if (connectors_.empty()) return {};
  return solver_->solve(*this, compliance, duration);
}

// Which way a solution goes depends on what feels the forces. Where displacements or rates at the end do, or a law
// depends on the acceleration: Newton's method. Otherwise one call of the laws is the solution.
ForceSolveOutcome ConnectorForces::Solver::solve(ConnectorForces& outer, const MatrixXd& compliance, double duration) {
  read_interval(outer);
  ForceSolveOutcome outcome;
  const bool forces_move = has_entries(compliance, 2 * force_.cols());  // not at an instant, where only d'' feels them
  if (forces_move || uses_acceleration_) {
    read_guess(outer);
    evaluate(compliance, duration);
    if (forces_move || has_inertance())
      outcome = iterate(compliance, duration);
    else
      take_law_force(compliance, free_motion_);
  } else {
    blocks_.spread(outer.free_motion_.data(), laws_.motion.data(), laws_.motion.cols());
    laws_.respond(duration);
    take_law_force(compliance, laws_.motion);
  }
  outcome.finite = all_finite(force_) && all_finite(laws_.states);
  write(outer);
  return outcome;
}

/// Parameters that changed and, where a law has states, the interval's begin: no force depends on it but through them.
void ConnectorForces::Solver::read_interval(ConnectorForces& outer) {
  for (std::size_t i = 0; i < outer.parameter_changed_.size(); ++i)
    if (std::exchange(outer.parameter_changed_[i], 0) != 0) {
      const auto column = static_cast<Index>(i);
      blocks_.spread(&outer.parameters_(0, column), &laws_.parameters(0, column), 1);
    }
  if (laws_.states.cols() == 0) return;
  blocks_.spread(outer.begin_motion_.data(), laws_.begin_motion.data(), laws_.begin_motion.cols());
  blocks_.spread(outer.begin_states_.data(), laws_.begin_states.data(), laws_.begin_states.cols());
}

void ConnectorForces::Solver::read_guess(const ConnectorForces& outer) {
  blocks_.spread(outer.free_motion_.data(), free_motion_.data(), free_motion_.cols());
  blocks_.spread(outer.force_.data(), force_.data(), force_.cols());
}

void ConnectorForces::Solver::write(ConnectorForces& outer) const {
  blocks_.collect(force_.data(), outer.force_.data(), force_.cols());
  blocks_.collect(laws_.motion.data(), outer.motion_.data(), laws_.motion.cols());
  blocks_.collect(laws_.states.data(), outer.states_.data(), laws_.states.cols());
}

/// The solution where d and d' do not feel the forces and the laws do not feel d''.
void ConnectorForces::Solver::take_law_force(const MatrixXd& compliance, const ArrayXXd& free_motion) {
  force_ = laws_.force;
  auto at = iterate_at(compliance);
  at.free_motion = free_motion.data();
  newton_.move_acceleration(at);
}

/// Whether some law's force depends on d''.
bool ConnectorForces::Solver::has_inertance() const {
  return uses_acceleration_ && !(laws_.tangents.rightCols(force_.cols()).abs().sum() == 0.0);
}

/// The laws at the present forces.
void ConnectorForces::Solver::evaluate(const MatrixXd& compliance, double duration) {
  newton_.move(iterate_at(compliance));
  laws_.respond(duration);
}

/// Newton's method until the last correction is small, or something not finite.
ForceSolveOutcome ConnectorForces::Solver::iterate(const MatrixXd& compliance, double duration) {
  ForceSolveOutcome outcome;
  forget_residual();
  for (;;) {
    auto judgement = newton_.correct(iterate_at(compliance));
    if (judgement.grew) [[unlikely]] {
      back_off(compliance, duration);
      judgement = newton_.correct(iterate_at(compliance));
    }
    take_correction();
    if (judgement.small) break;
    laws_.respond(duration);
    if (++outcome.iterations >= options_.max_iterations) {
      outcome.converged = bisect(compliance, duration);
      break;
    }
  }
  if (!uses_acceleration_) newton_.move_acceleration(iterate_at(compliance));
  return outcome;
}

ForceIterate ConnectorForces::Solver::iterate_at(const MatrixXd& compliance) {
  return {
      blocks_.rows,         force_.cols(),         uses_acceleration_,      compliance.data(),  free_motion_.data(),
      laws_.force.data(),   laws_.tangents.data(), force_.data(),           residual_.data(),   options_.tolerance,
      options_.force_floor, next_residual_.data(), next_correction_.data(), next_force_.data(), laws_.motion.data()};
}

void ConnectorForces::Solver::take_correction() {
  force_.swap(next_force_);
  correction_.swap(next_correction_);
  residual_.swap(next_residual_);
}

/// Shortens the correction that led to the present forces while residuals are worse than before it.
void ConnectorForces::Solver::back_off(const MatrixXd& compliance, double duration) {
  for (int halvings = 0; halvings < 8 && residual_grew(); ++halvings) {
    halve_where_worse();
    evaluate(compliance, duration);
    next_residual_ = (laws_.force - force_).abs();
  }
}

/// Takes back half of the last correction at the points where it made any residual worse.
void ConnectorForces::Solver::halve_where_worse() {
  for (Index point = 0; point < force_.rows(); ++point) {
    if (!(next_residual_.row(point) > growth_limit().row(point)).any()) continue;
    correction_.row(point) *= 0.5;
    force_.row(point) -= correction_.row(point);
  }
}

/// Where Newton's method runs to and fro across a kink or a jump: each connector in turn by bisection, until none
/// moves. Sure for laws that rise with d, d' and d'' (their compliance is negative), which joints, stops and friction
/// do. At a jump of a law the force is the one within the jump that holds the motion there (Filippov 1988, Differential
/// Equations with Discontinuous Righthand Sides).
bool ConnectorForces::Solver::bisect(const MatrixXd& compliance, double duration) {
  constexpr int sweeps = 200, undamped = 20;
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    const ArrayXXd before = force_;
    for (Index j = 0; j < force_.cols(); ++j) bisect(j, compliance, duration);
    if (!exceeds((force_ - before).abs(), options_.tolerance * (force_.abs() + options_.force_floor))) break;
    if (sweep >= undamped) force_ = 0.5 * (force_ + before);
  }
  bool solved = true;
  for (Index j = 0; solved && j < force_.cols(); ++j) solved = crosses(j, compliance, duration);
  evaluate(compliance, duration);
  return solved && all_finite(force_);
}

/// Whether law - f is positive just below the force of a connector and negative just above it, at every point.
bool ConnectorForces::Solver::crosses(Index j, const MatrixXd& compliance, double duration) {
  const Eigen::ArrayXd root = force_.col(j), margin = 1e-6 * (root.abs() + options_.force_floor);
  force_.col(j) = root - margin;
  evaluate(compliance, duration);
  const bool below = !exceeds(force_.col(j), laws_.force.col(j));
  force_.col(j) = root + margin;
  evaluate(compliance, duration);
  const bool above = !exceeds(laws_.force.col(j), force_.col(j));
  force_.col(j) = root;
  return below && above;
}

/// f - law(k_free + H f) rises with f by 1 at least, so its root lies no farther from f than its value there.
void ConnectorForces::Solver::bisect(Index j, const MatrixXd& compliance, double duration) {
  evaluate(compliance, duration);
  Eigen::ArrayXd lower = force_.col(j).min(laws_.force.col(j)), upper = force_.col(j).max(laws_.force.col(j));
  for (int halving = 0; halving < 100; ++halving) {
    force_.col(j) = 0.5 * (lower + upper);
    if ((force_.col(j) == lower || force_.col(j) == upper).all()) break;
    evaluate(compliance, duration);
    lower = (laws_.force.col(j) >= force_.col(j)).select(force_.col(j), lower);
    upper = (laws_.force.col(j) >= force_.col(j)).select(upper, force_.col(j));
  }
  evaluate(compliance, duration);
}

}  // namespace kalfem
