// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/process_model.hpp"

#include <algorithm>

#include "kalfem/base/independent.hpp"

namespace kalfem {

using Eigen::ArrayXXd;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Ref;
using Eigen::VectorXd;

namespace {

/// Arguments that are internal states and unknowns. They come first, those of motion behind them: these may depend on
/// each other almost exactly, and a triangular factor of their covariance then ends in small entries only.
Index picked_arguments(const StateLayout& layout) { return layout.connector_states + layout.unknowns; }

/// Rows that pick internal states and unknowns from the augmented state.
void select_states_and_unknowns(const StateLayout& layout, MatrixXd& selection) {
  const Index count = picked_arguments(layout);
  selection.block(0, layout.connector_state(), count, count).setIdentity();
}

/// Parameters at the points from the unknowns.
void set_unknowns(const AugmentedModel& augmented_model, const ArrayXXd& in, ConnectorForces& forces) {
  Index column = augmented_model.layout().connector_states;
  for (const auto& unknown : augmented_model.options().unknowns) {
    for (const auto& target : unknown.targets)
      unknown.transform.to_parameter(in.col(column), forces.parameter(target.connector, target.parameter));
    ++column;
  }
}

void fit_points(ConnectorForces& forces, Index points) {
  if (forces.points() != points) forces.resize(points);
}

/// Arguments of connector motion at one instant: d, d', and d'' where some law depends on it.
Index motion_arguments(const LocallyNonlinearSystem& system) {
  const bool accelerations = std::ranges::any_of(
      system.connectors, [](const Connector& connector) { return connector.law->uses_acceleration(); });
  return (accelerations ? 3 : 2) * system.connector_count();
}

/// Forces at the first instant from states, unknowns and the motion there.
bool solve_instant(const AugmentedModel& augmented_model, const ArrayXXd& in, Index motion, ConnectorForces& forces) {
  const Index first = picked_arguments(augmented_model.layout());
  forces.free_motion().leftCols(motion) = in.middleCols(first, motion);
  forces.begin_motion().leftCols(motion) = in.middleCols(first, motion);
  forces.begin_states() = in.leftCols(augmented_model.layout().connector_states);
  const auto outcome = forces.solve(augmented_model.step().instant_compliance, 0.0);
  return outcome.finite && outcome.converged;
}

/// A column += sum_j factors_j column j of `from`: so many columns in one go.
template <int columns>
void add_columns(const double* factors, Index factor_stride, const double* from, Index points, double* to) {
  KALFEM_INDEPENDENT
  for (Index i = 0; i < points; ++i) {
    double sum = to[i];
#pragma GCC unroll 4
    for (int j = 0; j < columns; ++j) sum += factors[j * factor_stride] * from[j * points + i];
    to[i] = sum;
  }
}

/// Columns of `to`, one a row of the factors, += these factors times the first columns of `from`.
void add_combinations(const Ref<const MatrixXd>& factors, const ArrayXXd& from, ArrayXXd& to) {
  const Index points = from.rows(), stride = factors.outerStride(), count = factors.cols();
  for (Index row = 0; row < factors.rows(); ++row) {
    const auto factor = [&](Index j) { return factors.data() + row + j * stride; };
    Index j = 0;
    for (; j + 4 <= count; j += 4) add_columns<4>(factor(j), stride, &from(0, j), points, &to(0, row));
    for (; j + 2 <= count; j += 2) add_columns<2>(factor(j), stride, &from(0, j), points, &to(0, row));
    if (j < count) add_scaled(factors(row, j), from, j, to, row);
  }
}

/// After a solve that failed: the connector with a force that is not finite, otherwise the one with the largest force.
Index worst_connector(ConnectorForces& forces) {
  Index worst = 0;
  const ArrayXXd& force = forces.force();
  for (Index j = 0; j < force.cols(); ++j)
    if (!force.col(j).isFinite().all()) return j;
  force.abs().colwise().maxCoeff().maxCoeff(&worst);
  return worst;
}

/// Weights of a column of instants for values that are linear from the first to the last.
MatrixXd between_ends(const MatrixXd& weights, Index instants) {
  const Index width = weights.cols() / instants;
  MatrixXd ends = MatrixXd::Zero(weights.rows(), 2 * width);
  for (Index i = 0; i < instants; ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(instants - 1);
    ends.leftCols(width) += (1.0 - share) * weights.middleCols(i * width, width);
    ends.rightCols(width) += share * weights.middleCols(i * width, width);
  }
  return ends;
}

}  // namespace

// The interval's N parts, each x_i = A_h x_(i-1) + G_0 f_(i-1) + G_1 f_i + drive_i, are composed once, so that the
// state moves by one matrix and the sigma points see only the connectors' motion. After part i
//     x_i = A_h^i x_0 + sum_j F_ij f_j + inputs,     forces <- A_h forces, with G_0 and G_1 added to two columns.
// The connectors' motion at the end of part i is C x_i; its share of x_0 and the inputs is the nonlinear argument w,
// its share of earlier forces is `force_motion_`, and its share of f_i itself the compliance with which f_i is solved
// for. evaluate() then goes from part to part with all points at once.
ProcessModel::ProcessModel(const AugmentedModel& augmented_model)
    : augmented_model_(&augmented_model),
      parts_(augmented_model.options().substeps),
      motion_(motion_arguments(augmented_model.system())),
      forces_(augmented_model.system(), augmented_model.options().forces),
      tangent_(augmented_model) {
  const auto& layout = augmented_model.layout();
  const auto& step = augmented_model.step();
  const auto& seen = augmented_model.form().motion();
  const MatrixXd motion = seen.state.topRows(motion_), motion_of_input = seen.input.topRows(motion_);
  const Index n = layout.size(), x = layout.linear, s = layout.connector_states, m = step.begin_force.cols(),
              u = step.begin_input.cols(), instants = parts_ + 1;

  const Index first = picked_arguments(layout);
  selection_ = MatrixXd::Zero(first + motion_ * instants, n);
  force_motion_ = MatrixXd::Zero(motion_ * parts_, m * parts_);
  input_motion_ = MatrixXd::Zero(motion_ * instants, u * instants);
  MatrixXd transition = MatrixXd::Identity(x, x), forces = MatrixXd::Zero(x, m * instants);
  input_state_ = MatrixXd::Zero(x, u * instants);
  selection_.middleRows(first, motion_).leftCols(x) = motion;
  input_motion_.topLeftCorner(motion_, u) = motion_of_input;
  for (Index part = 1; part <= parts_; ++part) {
    transition = step.transition * transition;
    forces = step.transition * forces;
    input_state_ = step.transition * input_state_;
    forces.middleCols((part - 1) * m, m) += step.begin_force;
    input_state_.middleCols((part - 1) * u, u) += step.begin_input;
    input_state_.middleCols(part * u, u) += step.end_input;
    selection_.middleRows(first + motion_ * part, motion_).leftCols(x) = motion * transition;
    force_motion_.middleRows(motion_ * (part - 1), motion_) = motion * forces.leftCols(m * parts_);
    input_motion_.middleRows(motion_ * part, motion_) = motion * input_state_;
    input_motion_.block(motion_ * part, u * part, motion_, u) += motion_of_input;
    forces.middleCols(part * m, m) += step.end_force;
  }
  straight_state_ = between_ends(input_state_, instants);
  straight_motion_ = between_ends(input_motion_, instants);
  select_states_and_unknowns(layout, selection_);

  linear_ = MatrixXd::Identity(n, n);
  linear_.topLeftCorner(x, x) = transition;
  linear_.block(x, x, s, s).setZero();
  moving_gain_ = tangent_.size();
  gain_ = MatrixXd::Zero(n, m * instants + s + moving_gain_);
  gain_.topRows(x).leftCols(forces.cols()) = forces;
  gain_.block(x, forces.cols(), s, s).setIdentity();
  offset_ = VectorXd::Zero(n);
  input_offset_ = VectorXd::Zero(selection_.rows());
}

void ProcessModel::set_inputs(const Ref<const MatrixXd>& inputs) {
  tangent_.each([&](ProcessModel& beside) { beside.set_inputs(inputs); });
  ends_ = inputs.reshaped();
  offset_.head(input_state_.rows()).noalias() = input_state_ * ends_;
  input_offset_.tail(input_motion_.rows()).noalias() = input_motion_ * ends_;
}

void ProcessModel::set_inputs(const Ref<const VectorXd>& begin, const Ref<const VectorXd>& end) {
  tangent_.each([&](ProcessModel& beside) { beside.set_inputs(begin, end); });
  ends_.resize(2 * begin.size());
  ends_ << begin, end;
  offset_.head(straight_state_.rows()).noalias() = straight_state_ * ends_;
  input_offset_.tail(straight_motion_.rows()).noalias() = straight_motion_ * ends_;
}

void ProcessModel::set_mean(const VectorXd& mean) {
  if (moving_gain_ == 0) return;
  derivatives_usable_ = tangent_.derivatives(mean, derivatives_);
  if (derivatives_usable_) gain_.rightCols(moving_gain_) = augmented_model_->own(derivatives_);
}

bool ProcessModel::evaluate(const ArrayXXd& in, ArrayXXd& out) {
  failed_connector_.reset();
  if (!derivatives_usable_) return false;
  if (solve_interval(in, out)) return true;
  failed_connector_ = worst_connector(forces_);
  return false;
}

/// Forces at the first instant from the motion there, then of each part's end from those before, with the connectors'
/// internal states going along.
bool ProcessModel::solve_interval(const ArrayXXd& in, ArrayXXd& out) {
  const auto& layout = augmented_model_->layout();
  const Index m = forces_.force().cols();
  fit_points(forces_, in.rows());
  set_unknowns(*augmented_model_, in, forces_);
  if (!solve_instant(*augmented_model_, in, motion_, forces_)) return false;
  out.leftCols(m) = forces_.force();
  for (Index part = 1; part <= parts_; ++part) {
    if (layout.connector_states > 0) {  // otherwise no force depends on the part's begin
      forces_.begin_motion() = forces_.motion();
      if (part > 1) forces_.begin_states() = forces_.states();
    }
    if (!solve_part(part, in, out)) return false;
    out.middleCols(part * m, m) = forces_.force();
  }
  out.middleCols((parts_ + 1) * m, layout.connector_states) = forces_.states();
  tangent_.set_outputs(in, layout.connector_states, out);
  return true;
}

/// Forces at the end of one part from those at the ends of the earlier ones, in the columns of `out`.
bool ProcessModel::solve_part(Index part, const ArrayXXd& in, const ArrayXXd& out) {
  const Index earlier = part * forces_.force().cols();
  forces_.free_motion().leftCols(motion_) =
      in.middleCols(picked_arguments(augmented_model_->layout()) + part * motion_, motion_);
  add_combinations(force_motion_.block((part - 1) * motion_, 0, motion_, earlier), out, forces_.free_motion());
  const auto outcome = forces_.solve(augmented_model_->step().compliance, augmented_model_->step().step);
  return outcome.finite && outcome.converged;
}

AugmentedModelOutput sensor_outputs(const AugmentedModel& augmented_model) {
  AugmentedModelOutput output(augmented_model.form().outputs());
  const auto& unknowns = augmented_model.options().unknowns;
  for (std::size_t i = 0; i < unknowns.size(); ++i)
    for (const Index sensor : unknowns[i].sensors) {
      if (output.unknowns.size() == 0)
        output.unknowns = MatrixXd::Zero(output.of_system.state.rows(), augmented_model.layout().unknowns);
      output.unknowns(sensor, static_cast<Index>(i)) = 1.0;
    }
  return output;
}

MeasurementModel::MeasurementModel(const AugmentedModel& augmented_model, const OutputsOf& outputs)
    : augmented_model_(&augmented_model),
      motion_(motion_arguments(augmented_model.system())),
      forces_(augmented_model.system(), augmented_model.options().forces),
      tangent_(augmented_model, outputs) {
  const auto& layout = augmented_model.layout();
  selection_ = MatrixXd::Zero(picked_arguments(layout) + motion_, layout.size());
  selection_.bottomRows(motion_).leftCols(layout.linear) = augmented_model.form().motion().state.topRows(motion_);
  select_states_and_unknowns(layout, selection_);
  input_offset_ = VectorXd::Zero(selection_.rows());

  const auto all = outputs(augmented_model);
  const auto& [state, input, force] = all.of_system;
  linear_ = MatrixXd::Zero(state.rows(), layout.size());
  linear_.leftCols(state.cols()) = state;
  if (all.unknowns.size() > 0) linear_.middleCols(layout.unknown(), layout.unknowns) = all.unknowns;
  moving_gain_ = tangent_.size();
  gain_ = MatrixXd::Zero(linear_.rows(), force.cols() + moving_gain_);
  gain_.leftCols(force.cols()) = force;
  input_ = input;
  offset_ = VectorXd::Zero(linear_.rows());
}

void MeasurementModel::set_mean(const VectorXd& mean) {
  if (moving_gain_ == 0) return;
  derivatives_usable_ = tangent_.derivatives(mean, derivatives_);
  if (derivatives_usable_) gain_.rightCols(moving_gain_) = derivatives_;
}

void MeasurementModel::set_inputs(const Ref<const VectorXd>& inputs) {
  tangent_.each([&](MeasurementModel& beside) { beside.set_inputs(inputs); });
  offset_.noalias() = input_.lazyProduct(inputs);
  input_offset_.tail(motion_).noalias() = augmented_model_->form().motion().input.topRows(motion_).lazyProduct(inputs);
}

bool MeasurementModel::evaluate(const ArrayXXd& in, ArrayXXd& out) {
  failed_connector_.reset();
  if (!derivatives_usable_) return false;
  fit_points(forces_, in.rows());
  set_unknowns(*augmented_model_, in, forces_);
  if (!solve_instant(*augmented_model_, in, motion_, forces_)) {
    failed_connector_ = worst_connector(forces_);
    return false;
  }
  out.leftCols(forces_.force().cols()) = forces_.force();
  tangent_.set_outputs(in, augmented_model_->layout().connector_states, out);
  return true;
}

bool image(PartiallyLinearMap& map, const Eigen::VectorXd& x, Eigen::VectorXd& y) {
  const Eigen::ArrayXXd in = (map.selection() * x + map.input_offset()).transpose().array();
  Eigen::ArrayXXd out = Eigen::ArrayXXd::Zero(1, map.gain().cols());
  if (!map.evaluate(in, out)) return false;
  y = map.offset();
  y.noalias() += map.linear() * x;
  y.noalias() += map.gain() * out.matrix().transpose();
  return y.allFinite();
}

}  // namespace kalfem
