#include "kalfem/estimation/observer_maps.hpp"

namespace kalfem {

using Eigen::ArrayXXd;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Ref;
using Eigen::VectorXd;

namespace {

/// Rows that pick internal states and unknowns from the augmented state.
void select_states_and_unknowns(const StateLayout& layout, Index row, MatrixXd& selection) {
  const Index count = layout.connector_states + layout.unknowns;
  selection.block(row, layout.connector_state(), count, count).setIdentity();
}

/// Parameters at the points from the unknowns in the columns from `column` on.
void set_unknowns(const Observer& observer, const ArrayXXd& in, Index column, ConnectorForces& forces) {
  for (const auto& unknown : observer.options().unknowns) {
    for (const auto& target : unknown.targets)
      unknown.transform.to_parameter(in.col(column), forces.parameter(target.connector, target.parameter));
    ++column;
  }
}

void fit_points(ConnectorForces& forces, Index points) {
  if (forces.points() != points) forces.resize(points);
}

/// Forces at an instant from motion, states and unknowns in the columns of `in` from 0 on.
bool solve_instant(const Observer& observer, const ArrayXXd& in, Index states_column, ConnectorForces& forces) {
  const auto& layout = observer.layout();
  const Index motion = forces.free_motion().cols();
  forces.free_motion() = in.leftCols(motion);
  forces.begin_motion() = forces.free_motion();
  forces.begin_states() = in.middleCols(states_column, layout.connector_states);
  const auto outcome = forces.solve(observer.step().instant_compliance, 0.0);
  return outcome.finite && outcome.converged;
}

}  // namespace

TransitionMap::TransitionMap(const Observer& observer)
    : observer_(&observer), parts_(observer.options().substeps), forces_(observer.system(), observer.options().forces) {
  const auto& layout = observer.layout();
  const auto& step = observer.step();
  const MatrixXd& motion = observer.form().motion().state;
  const Index n = layout.size(), x = layout.linear, s = layout.connector_states, m = step.begin_force.cols();

  selection = MatrixXd::Zero(3 * m * (parts_ + 1) + s + layout.unknowns, n);
  force_motion_ = MatrixXd::Zero(3 * m * parts_, m * parts_);
  MatrixXd transition = MatrixXd::Identity(x, x), forces = MatrixXd::Zero(x, m * (parts_ + 1));
  selection.topRows(3 * m).leftCols(x) = motion;
  for (Index part = 1; part <= parts_; ++part) {
    transition = step.transition * transition;
    forces = step.transition * forces;
    forces.middleCols((part - 1) * m, m) += step.begin_force;
    selection.middleRows(3 * m * part, 3 * m).leftCols(x) = motion * transition;
    force_motion_.middleRows(3 * m * (part - 1), 3 * m) = motion * forces.leftCols(m * parts_);
    forces.middleCols(part * m, m) += step.end_force;
  }
  select_states_and_unknowns(layout, 3 * m * (parts_ + 1), selection);

  linear = MatrixXd::Identity(n, n);
  linear.topLeftCorner(x, x) = transition;
  linear.block(x, x, s, s).setZero();
  gain = MatrixXd::Zero(n, m * (parts_ + 1) + s);
  gain.topRows(x).leftCols(forces.cols()) = forces;
  gain.block(x, forces.cols(), s, s).setIdentity();
  offset = VectorXd::Zero(n);
  input_offset = VectorXd::Zero(selection.rows());
}

void TransitionMap::set_inputs(const Ref<const MatrixXd>& inputs) {
  const auto& step = observer_->step();
  const auto& motion = observer_->form().motion();
  const Index m3 = motion.state.rows();
  input_offset.head(m3).noalias() = motion.input.lazyProduct(inputs.col(0));
  for (Index part = 1; part <= parts_; ++part) {
    moved_.noalias() = step.begin_input.lazyProduct(inputs.col(part - 1));
    if (part > 1) moved_.noalias() += step.transition * drive_;
    moved_.noalias() += step.end_input.lazyProduct(inputs.col(part));
    drive_.swap(moved_);
    input_offset.segment(part * m3, m3).noalias() = motion.state.lazyProduct(drive_);
    input_offset.segment(part * m3, m3).noalias() += motion.input.lazyProduct(inputs.col(part));
  }
  offset.head(drive_.size()) = drive_;
}

void TransitionMap::set_inputs(const Ref<const VectorXd>& begin, const Ref<const VectorXd>& end) {
  interpolated_.resize(begin.size(), parts_ + 1);
  for (Index part = 0; part <= parts_; ++part)
    interpolated_.col(part) = begin + (end - begin) * (static_cast<double>(part) / static_cast<double>(parts_));
  set_inputs(interpolated_);
}

bool TransitionMap::evaluate(const ArrayXXd& in, ArrayXXd& out) {
  const auto& layout = observer_->layout();
  const Index m = forces_.force().cols(), states = 3 * m * (parts_ + 1);
  fit_points(forces_, in.rows());
  set_unknowns(*observer_, in, states + layout.connector_states, forces_);
  if (!solve_instant(*observer_, in, states, forces_)) return false;
  out.leftCols(m) = forces_.force();
  for (Index part = 1; part <= parts_; ++part) {
    forces_.begin_motion() = forces_.motion();
    if (part > 1) forces_.begin_states() = forces_.states();
    if (!solve_part(part, in, out)) return false;
    out.middleCols(part * m, m) = forces_.force();
  }
  out.rightCols(layout.connector_states) = forces_.states();
  return true;
}

/// Forces at the end of one part from those at the ends of the earlier ones, in the columns of `out`.
bool TransitionMap::solve_part(Index part, const ArrayXXd& in, const ArrayXXd& out) {
  const Index m3 = forces_.free_motion().cols(), earlier = part * (m3 / 3);
  forces_.free_motion() = in.middleCols(part * m3, m3);
  for (Index row = 0; row < m3; ++row)
    for (Index j = 0; j < earlier; ++j)
      add_scaled(force_motion_((part - 1) * m3 + row, j), out, j, forces_.free_motion(), row);
  const auto outcome = forces_.solve(observer_->step().compliance, observer_->step().step);
  return outcome.finite && outcome.converged;
}

InstantMap::InstantMap(const Observer& observer, LinearOutput output)
    : observer_(&observer), all_(std::move(output)), forces_(observer.system(), observer.options().forces) {
  const auto& layout = observer.layout();
  const auto& motion = observer.form().motion();
  const Index m3 = motion.state.rows();
  selection = MatrixXd::Zero(m3 + layout.connector_states + layout.unknowns, layout.size());
  selection.topRows(m3).leftCols(layout.linear) = motion.state;
  select_states_and_unknowns(layout, m3, selection);
  input_offset = VectorXd::Zero(selection.rows());
  std::vector<Index> rows(static_cast<std::size_t>(all_.state.rows()));
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = static_cast<Index>(i);
  select_rows(rows);
}

void InstantMap::select_rows(const std::vector<Index>& rows) {
  linear = MatrixXd::Zero(static_cast<Index>(rows.size()), observer_->layout().size());
  linear.leftCols(all_.state.cols()) = all_.state(rows, Eigen::all);
  gain = all_.force(rows, Eigen::all);
  input_ = all_.input(rows, Eigen::all);
  offset = VectorXd::Zero(linear.rows());
}

void InstantMap::set_inputs(const Ref<const VectorXd>& inputs) {
  offset.noalias() = input_.lazyProduct(inputs);
  const auto& motion = observer_->form().motion();
  input_offset.head(motion.state.rows()).noalias() = motion.input.lazyProduct(inputs);
}

bool InstantMap::evaluate(const ArrayXXd& in, ArrayXXd& out) {
  const Index m3 = observer_->form().motion().state.rows();
  fit_points(forces_, in.rows());
  set_unknowns(*observer_, in, m3 + observer_->layout().connector_states, forces_);
  if (!solve_instant(*observer_, in, m3, forces_)) return false;
  out = forces_.force();
  return true;
}

}  // namespace kalfem
