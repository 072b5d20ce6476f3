// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/process_model.hpp"

#include <algorithm>
#include <utility>

#include "kalfem/base/vector_loops.hpp"

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

/// Parameters at the points from the unknowns, for the connectors at so many instants.
void set_unknowns(const AugmentedModel& augmented_model, const ArrayXXd& in, Index instants, ConnectorForces& forces) {
  const Index m = augmented_model.system().connector_count();
  Index column = augmented_model.layout().connector_states;
  for (const auto& unknown : augmented_model.options().unknowns) {
    for (const auto& [connector, parameter] : unknown.targets) {
      unknown.transform.to_parameter(in.col(column), forces.parameter(connector, parameter));
      for (Index instant = 1; instant < instants; ++instant)
        forces.parameter(instant * m + connector, parameter) = forces.parameter(connector, parameter);
    }
    ++column;
  }
}

/// Parameters that vary, from the points' last columns.
void set_varied(const std::vector<ParameterTarget>& varied, const ArrayXXd& in, Index instants, Index connectors,
                ConnectorForces& forces) {
  const Index first = in.cols() - std::ssize(varied);
  for (std::size_t i = 0; i < varied.size(); ++i)
    for (Index instant = 0; instant < instants; ++instant)
      forces.parameter(instant * connectors + varied[i].connector, varied[i].parameter) =
          in.col(first + static_cast<Index>(i));
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

// A point whose forces have not settled goes on with those of the last, damped iteration: one of many points is no
// reason to end a run, and what it adds to the moments shows in the innovations.

/// Forces at the first instant from states, unknowns and the motion there. False where one is not finite.
bool solve_instant(const AugmentedModel& augmented_model, const ArrayXXd& in, Index motion, ConnectorForces& forces) {
  const Index first = picked_arguments(augmented_model.layout());
  forces.free_motion().leftCols(motion) = in.middleCols(first, motion);
  forces.begin_motion().leftCols(motion) = in.middleCols(first, motion);
  forces.begin_states() = in.leftCols(augmented_model.layout().connector_states);
  return forces.solve(augmented_model.step().instant_compliance, 0.0).finite;
}

/// The motion and the states with which a part begins: those with which `before` ends, the last of its instants.
void begin_part(const ConnectorForces& before, Index instants, ConnectorForces& part, Index nodes) {
  const Index m = before.motion().cols() / (3 * instants), s = before.states().cols() / instants;
  for (Index derivative = 0; derivative < 2; ++derivative)
    part.begin_motion().middleCols(derivative * nodes * m, m) =
        before.motion().middleCols(((derivative + 1) * instants - 1) * m, m);
  part.begin_states().leftCols(s) = before.states().rightCols(s);
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

/// The weights at all instants move over a part, which adds its own of the second difference of its three.
void add_second_difference(const MatrixXd& transition, const MatrixXd& weight, Index begin, MatrixXd& weights) {
  weights = transition * weights;
  const Index width = weight.cols();
  weights.middleCols(begin * width, width) += weight;
  weights.middleCols((begin + 1) * width, width) -= 2.0 * weight;
  weights.middleCols((begin + 2) * width, width) += weight;
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

// The interval's parts are composed once, so that the state moves by one matrix and the sigma points see only the
// connectors' motion. At node j of a part that begins with instant b
//     x_(b+j) = T_j x_b + sum_l G_jl f_(b+l) + inputs,     x_b = transition x_0 + sum_i F_i f_i + inputs.
// The connectors' motion there is C x_(b+j); its share of x_0 and the inputs is the nonlinear argument w, its share of
// earlier forces is `force_motion_`, and its share of the part's own forces the compliance with which these are solved
// for. evaluate() then goes from part to part with all points at once.
// The motion at the nodes of a part stands as ConnectorForces has it: d at all nodes, then d', then d''.
ProcessModel::ProcessModel(const AugmentedModel& augmented_model)
    : augmented_model_(&augmented_model),
      parts_(augmented_model.options().substeps),
      nodes_(augmented_model.step().instants()),
      motion_(motion_arguments(augmented_model.system())),
      first_forces_(augmented_model.system(), augmented_model.options().forces),
      forces_(augmented_model.system(), augmented_model.options().forces, nodes_),
      tangent_(augmented_model) {
  const auto& layout = augmented_model.layout();
  const auto& seen = augmented_model.form().motion();
  const Index n = layout.size(), x = layout.linear, s = layout.connector_states, m = seen.force.cols(),
              u = seen.input.cols(), first = picked_arguments(layout), instants = parts_ * nodes_ + 1;
  selection_ = MatrixXd::Zero(first + motion_ * instants, n);
  force_motion_ = MatrixXd::Zero(motion_ * (instants - 1), m * instants);
  input_motion_ = MatrixXd::Zero(motion_ * instants, u * instants);
  force_difference_ = MatrixXd::Zero(x, m * instants);
  input_difference_ = MatrixXd::Zero(x, u * instants);
  select_states_and_unknowns(layout, selection_);
  selection_.middleRows(first, motion_).leftCols(x) = seen.state.topRows(motion_);
  input_motion_.topLeftCorner(motion_, u) = seen.input.topRows(motion_);
  Composed all{MatrixXd::Identity(x, x), MatrixXd::Zero(x, m * instants), MatrixXd::Zero(x, u * instants)};
  for (Index part = 0; part < parts_; ++part) add_part(part, all);
  input_state_ = std::move(all.inputs);
  straight_state_ = between_ends(input_state_, instants);
  straight_motion_ = between_ends(input_motion_, instants);
  straight_difference_ = between_ends(input_difference_, instants);

  linear_ = MatrixXd::Identity(n, n);
  linear_.topLeftCorner(x, x) = all.transition;
  linear_.block(x, x, s, s).setZero();
  moving_gain_ = tangent_.size();
  gain_ = MatrixXd::Zero(n, m * instants + s + moving_gain_);
  gain_.topRows(x).leftCols(m * instants) = all.forces;
  gain_.block(x, m * instants, s, s).setIdentity();
  offset_ = VectorXd::Zero(n);
  input_offset_ = VectorXd::Zero(selection_.rows());
}

void ProcessModel::add_part(Index part, Composed& all) {
  const auto& step = augmented_model_->step();
  const auto& seen = augmented_model_->form().motion();
  const MatrixXd motion = seen.state.topRows(motion_), motion_of_input = seen.input.topRows(motion_);
  const Index x = motion.cols(), m = seen.force.cols(), u = seen.input.cols(), begin = part * nodes_,
              first = picked_arguments(augmented_model_->layout());
  Composed at;
  for (Index node = 0; node < nodes_; ++node) {
    const auto& [transition, force, input] = step.nodes[static_cast<std::size_t>(node)];
    at = {transition * all.transition, transition * all.forces, transition * all.inputs};
    at.forces.middleCols(begin * m, m) += force[0];
    for (Index l = 0; l <= nodes_; ++l) at.inputs.middleCols((begin + l) * u, u) += input[static_cast<std::size_t>(l)];
    for (Index derivative = 0; derivative * m < motion_; ++derivative) {
      const Index from = derivative * m, row = begin * motion_ + (derivative * nodes_ + node) * m;
      selection_.block(first + motion_ + row, 0, m, x) = motion.middleRows(from, m) * at.transition;
      force_motion_.middleRows(row, m) = motion.middleRows(from, m) * at.forces;
      input_motion_.middleRows(motion_ + row, m) = motion.middleRows(from, m) * at.inputs;
      input_motion_.block(motion_ + row, (begin + node + 1) * u, m, u) += motion_of_input.middleRows(from, m);
    }
    for (Index l = 1; l <= nodes_; ++l) at.forces.middleCols((begin + l) * m, m) += force[static_cast<std::size_t>(l)];
  }
  if (nodes_ == 2) {
    const MatrixXd& transition = step.nodes.back().transition;
    add_second_difference(transition, step.curvature_force, begin, force_difference_);
    add_second_difference(transition, step.curvature_input, begin, input_difference_);
  }
  all = std::move(at);
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
  return solve_interval(in, out);
}

/// Forces at the first instant from the motion there, then at each part's nodes from those before, with the connectors'
/// internal states going along.
bool ProcessModel::solve_interval(const ArrayXXd& in, ArrayXXd& out) {
  const auto& layout = augmented_model_->layout();
  const Index m = first_forces_.force().cols(), of_part = forces_.force().cols(), s = layout.connector_states;
  fit_points(first_forces_, in.rows());
  fit_points(forces_, in.rows());
  set_unknowns(*augmented_model_, in, 1, first_forces_);
  set_unknowns(*augmented_model_, in, nodes_, forces_);
  set_varied(varied_, in, 1, m, first_forces_);
  set_varied(varied_, in, nodes_, m, forces_);
  const auto fails = [&](ConnectorForces& forces) {
    failed_connector_ = worst_connector(forces) % m;
    return false;
  };
  if (!solve_instant(*augmented_model_, in, motion_, first_forces_)) return fails(first_forces_);
  out.leftCols(m) = first_forces_.force();
  for (Index node = 0; node < nodes_; ++node) forces_.force().middleCols(node * m, m) = first_forces_.force();
  if (s > 0) begin_part(first_forces_, 1, forces_, nodes_);  // otherwise no force depends on the part's begin
  for (Index part = 0; part < parts_; ++part) {
    if (part > 0 && s > 0) begin_part(forces_, nodes_, forces_, nodes_);
    if (!solve_part(part, in, out)) return fails(forces_);
    out.middleCols(m + part * of_part, of_part) = forces_.force();
  }
  out.middleCols(m + parts_ * of_part, s) = forces_.states().rightCols(s);
  tangent_.set_outputs(in, s, out);
  return true;
}

/// Forces at the nodes of one part from those at the earlier instants, in the columns of `out`.
bool ProcessModel::solve_part(Index part, const ArrayXXd& in, const ArrayXXd& out) {
  const auto& step = augmented_model_->step();
  const Index m = first_forces_.force().cols(), earlier = m + part * forces_.force().cols(), rows = nodes_ * motion_;
  forces_.free_motion().leftCols(rows) =
      in.middleCols(picked_arguments(augmented_model_->layout()) + motion_ + part * rows, rows);
  add_combinations(force_motion_.block(part * rows, 0, rows, earlier), out, forces_.free_motion());
  return forces_.solve(step.compliance, step.step / static_cast<double>(nodes_)).finite;
}

OpenMap ProcessModel::open(bool straight) const {
  const auto& step = augmented_model_->step();
  const Index x = input_state_.rows(), motions = input_motion_.rows(), forces = force_difference_.cols(),
              m = forces / (parts_ * nodes_ + 1), of_part = nodes_ * m, rows = nodes_ * motion_;
  const MatrixXd &of_state = straight ? straight_state_ : input_state_,
                 &of_motion = straight ? straight_motion_ : input_motion_;
  OpenMap map{MatrixXd::Zero(x + motions, x + forces + of_state.cols()), x, x, forces};
  map.all.topRows(x) << linear_.topLeftCorner(x, x), gain_.topLeftCorner(x, forces), of_state;
  map.all.bottomRows(motions).leftCols(x) = selection_.bottomRows(motions).leftCols(x);
  map.all.bottomRows(motions).rightCols(of_state.cols()) = of_motion;
  auto by_force = map.all.bottomRows(motions).middleCols(x, forces);
  by_force.topLeftCorner(motion_, m) = step.instant_compliance.topRows(motion_);
  by_force.bottomRows(motions - motion_) = force_motion_;
  for (Index part = 0; part < parts_; ++part)
    by_force.block(motion_ + part * rows, m + part * of_part, rows, of_part) += step.compliance.topRows(rows);
  return map;
}

VectorXd ProcessModel::embedded_difference(const Ref<const VectorXd>& outputs) const {
  const auto& of_inputs = ends_.size() == input_difference_.cols() ? input_difference_ : straight_difference_;
  VectorXd difference = VectorXd::Zero(linear_.rows());
  difference.head(force_difference_.rows()) -=
      force_difference_ * outputs.head(force_difference_.cols()) + of_inputs * ends_;
  return difference;
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

OpenMap MeasurementModel::open() const {
  const auto& form = augmented_model_->form();
  const Index rows = linear_.rows(), x = form.size(), forces = form.motion().force.cols(), inputs = input_.cols();
  OpenMap map{MatrixXd(rows + motion_, x + forces + inputs), rows, x, forces};
  map.all.topRows(rows) << linear_.leftCols(x), gain_.leftCols(forces), input_;
  map.all.bottomRows(motion_) << form.motion().state.topRows(motion_),
      augmented_model_->step().instant_compliance.topRows(motion_), form.motion().input.topRows(motion_);
  return map;
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
  set_unknowns(*augmented_model_, in, 1, forces_);
  set_varied(varied_, in, 1, forces_.force().cols(), forces_);
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
