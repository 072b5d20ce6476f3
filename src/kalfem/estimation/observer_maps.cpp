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
    : observer_(&observer), begin_(observer.system(), observer.options().forces),
      end_(observer.system(), observer.options().forces) {
  const auto& layout = observer.layout();
  const auto& step = observer.step();
  const MatrixXd& motion = observer.form().motion().state;
  const Index n = layout.size(), x = layout.linear, s = layout.connector_states, m = step.begin_force.cols();

  linear = MatrixXd::Identity(n, n);
  linear.topLeftCorner(x, x) = step.transition;
  linear.block(x, x, s, s).setZero();
  gain = MatrixXd::Zero(n, 2 * m + s);
  gain.topRows(x).leftCols(2 * m) << step.begin_force, step.end_force;
  gain.block(x, 2 * m, s, s).setIdentity();

  selection = MatrixXd::Zero(6 * m + s + layout.unknowns, n);
  selection.topRows(3 * m).leftCols(x) = motion;
  selection.middleRows(3 * m, 3 * m).leftCols(x) = motion * step.transition;
  select_states_and_unknowns(layout, 6 * m, selection);
  begin_force_motion_ = motion * step.begin_force;
  offset = VectorXd::Zero(n);
  input_offset = VectorXd::Zero(selection.rows());
}

void TransitionMap::set_inputs(const Ref<const VectorXd>& begin, const Ref<const VectorXd>& end) {
  const auto& step = observer_->step();
  const auto& motion = observer_->form().motion();
  const Index m3 = motion.state.rows();
  drive_.noalias() = step.begin_input * begin;
  drive_.noalias() += step.end_input * end;
  offset.head(drive_.size()) = drive_;
  input_offset.head(m3).noalias() = motion.input * begin;
  input_offset.segment(m3, m3).noalias() = motion.state * drive_;
  input_offset.segment(m3, m3).noalias() += motion.input * end;
}

bool TransitionMap::evaluate(const ArrayXXd& in, ArrayXXd& out) {
  const auto& layout = observer_->layout();
  const Index m = begin_force_motion_.cols(), states = 6 * m;
  fit_points(begin_, in.rows());
  fit_points(end_, in.rows());
  set_unknowns(*observer_, in, states + layout.connector_states, begin_);
  set_unknowns(*observer_, in, states + layout.connector_states, end_);
  if (!solve_instant(*observer_, in, states, begin_)) return false;

  for (Index row = 0; row < 3 * m; ++row) {
    end_.free_motion().col(row) = in.col(3 * m + row);
    for (Index j = 0; j < m; ++j)
      end_.free_motion().col(row) += begin_force_motion_(row, j) * begin_.force().col(j);
  }
  end_.begin_motion() = begin_.motion();
  end_.begin_states() = begin_.begin_states();
  end_.force() = begin_.force();
  const auto outcome = end_.solve(observer_->step().compliance, observer_->step().step);
  if (!outcome.finite || !outcome.converged) return false;
  out.leftCols(m) = begin_.force();
  out.middleCols(m, m) = end_.force();
  out.rightCols(layout.connector_states) = end_.states();
  return true;
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
  offset.noalias() = input_ * inputs;
  const auto& motion = observer_->form().motion();
  input_offset.head(motion.state.rows()).noalias() = motion.input * inputs;
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
