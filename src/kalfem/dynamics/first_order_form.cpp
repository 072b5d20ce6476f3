// SPDX-License-Identifier: Apache-2.0
#include "kalfem/dynamics/first_order_form.hpp"

#include <cmath>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

LinearOutput zero_output(Index rows, Index states, Index inputs, Index forces) {
  return {MatrixXd::Zero(rows, states), MatrixXd::Zero(rows, inputs), MatrixXd::Zero(rows, forces)};
}

void add_scaled(LinearOutput& sum, const MatrixXd& rows, const LinearOutput& term) {
  sum.state += rows * term.state;
  sum.input += rows * term.input;
  sum.force += rows * term.force;
}

void check(const std::vector<InputTreatment>& treatments, Index inputs, std::size_t chains, Index outputs) {
  IssueList issues;
  if (!treatments.empty() && static_cast<Index>(treatments.size()) != inputs)
    issues.add({}, std::to_string(treatments.size()) + " input models for " + std::to_string(inputs) + " inputs",
               "every input needs one");
  if (chains != 0 && static_cast<Index>(chains) != outputs)
    issues.add({}, std::to_string(chains) + " measurement chains for " + std::to_string(outputs) + " sensors",
               "every sensor needs one");
  for (const auto& treatment : treatments) {
    if (!treatment.is_latent()) continue;
    const auto& [order, time] = treatment.process;
    if (order < 1 || order > 3)
      issues.add({}, "the process of an unknown input has " + std::to_string(order) + " states", "it has 1, 2 or 3");
    else if (!(time > 0.0) || (order > 1 && !std::isfinite(time)))
      issues.add({}, "the correlation time of an input is " + std::to_string(time) + " s",
                 "it must be positive; infinity stands for a random walk, which has one state");
  }
  issues.raise();
}

/// A degree of freedom without mass has no acceleration: the factor's solution would hold it without a word.
void require_mass(const LocallyNonlinearSystem& system, const Eigen::LDLT<MatrixXd>& factor) {
  if (factor.info() == Eigen::Success && (factor.vectorD().array() > 0.0).all()) return;
  const Eigen::VectorXd mass = system.mass.diagonal();
  Index least = 0;
  if (mass.size() > 0) mass.minCoeff(&least);
  const auto place = static_cast<std::size_t>(least);
  const std::string name = place < system.dofs.size() ? ": '" + system.dofs[place] + "' has the least" : "";
  const Index without = (mass.array() <= 0.0).count();
  throw InvalidInput(without > 0 ? std::to_string(without) + " degrees of freedom have no mass" + name
                                 : "the mass matrix is not positive definite" + name,
                     "exact time steps need a mass at every degree of freedom",
                     "give them mass (where the lumped beams of a deck have none at their rotations, take consistent "
                     "mass matrices), or take a reduced model");
}

}  // namespace

Index InputTreatment::states() const {
  if (model == InputModel::integrated) return 2;
  return is_latent() ? first_derivative() + process.order : 0;
}

// The state is x = [z; z'; states of inputs; states of measurement chains], and x' = A x + G u + B f with the inputs
// u = [r; r'; r''] and the connector forces f. The rows are filled in the order in which they depend on each other:
//   1. add_input_models(): an integrated input has the states r and r', driven by r''; a latent one those of its
//      process, below r and r' where the process is r''. Wherever r stood as an input its columns move over to these
//      states (route_inputs()).
//   2. set_mechanics(): z'' from M z'' + C z' + K z + B f = P u, solved with M once.
//   3. set_motion(): motion of the connectors and its derivatives, d'' through the row of z''.
//   4. add_chains(): each sensor's raw output drives its analog chain, whose output takes its place.
FirstOrderForm::FirstOrderForm(const LocallyNonlinearSystem& system, const OutputMap& outputs,
                               const std::vector<MeasurementChain>& chains,
                               const std::vector<InputTreatment>& treatments)
    : n_(system.size()), n_u_(system.input_count()), m_(system.connector_count()), treatments_(treatments) {
  check(treatments, n_u_, chains.size(), outputs.size());
  treatments_.resize(static_cast<std::size_t>(n_u_));
  Index states = 2 * n_;
  for (const auto& treatment : treatments_) {
    const Index count = treatment.states();
    input_state_.push_back(count > 0 ? states : -1);
    states += count;
  }
  for (const auto& chain : chains) states += chain.states();
  dynamics_ = MatrixXd::Zero(states, states);
  force_gain_ = MatrixXd::Zero(states, m_);
  input_gain_ = MatrixXd::Zero(states, 3 * n_u_);
  add_input_models(treatments_);
  set_mechanics(system);
  set_motion(system);
  add_chains(outputs_of_state(outputs), chains);
}

/// x = T xi. Outputs and motion keep their physical rows of inputs and forces; only their columns of x change.
FirstOrderForm FirstOrderForm::in_coordinates(const BlockDiagonalForm& coordinates,
                                              const FirstOrderForm& physical) const {
  FirstOrderForm form = *this;
  form.motion_ = physical.motion_;
  form.outputs_ = physical.outputs_;
  form.dynamics_ = coordinates.blocks;
  form.force_gain_ = coordinates.inverse * force_gain_;
  form.input_gain_ = coordinates.inverse * input_gain_;
  form.motion_.state = motion_.state * coordinates.basis;
  form.outputs_.state = outputs_.state * coordinates.basis;
  form.basis_ = coordinates.basis;
  return form;
}

/// z'' = M^-1 (P u - C z' - K z - B f) and the rows of z and z' in A, G, B.
void FirstOrderForm::set_mechanics(const LocallyNonlinearSystem& system) {
  const Eigen::LDLT<MatrixXd> mass{MatrixXd(system.mass)};
  require_mass(system, mass);
  acceleration_ = zero_output(n_, dynamics_.cols(), 3 * n_u_, m_);
  acceleration_.state.leftCols(n_) = -mass.solve(MatrixXd(system.stiffness));
  acceleration_.state.middleCols(n_, n_) = -mass.solve(system.full_damping());
  acceleration_.force = -mass.solve(system.connector_directions());
  for (Index i = 0; i < n_u_; ++i) {
    const auto& input = system.inputs[static_cast<std::size_t>(i)];
    acceleration_.input.col(i) = mass.solve(input.value);
    acceleration_.input.col(n_u_ + i) = mass.solve(input.rate);
    acceleration_.input.col(2 * n_u_ + i) = mass.solve(input.acceleration);
  }
  acceleration_ = route_inputs(std::move(acceleration_));
  dynamics_.block(0, n_, n_, n_).setIdentity();
  dynamics_.middleRows(n_, n_) = acceleration_.state;
  force_gain_.middleRows(n_, n_) = acceleration_.force;
  input_gain_.middleRows(n_, n_) = acceleration_.input;
}

void FirstOrderForm::add_input_models(const std::vector<InputTreatment>& treatments) {
  for (Index i = 0; i < n_u_; ++i) {
    const auto& treatment = treatments[static_cast<std::size_t>(i)];
    const Index state = input_state(i);
    if (treatment.model == InputModel::integrated) {
      dynamics_(state, state + 1) = 1.0;
      input_gain_(state + 1, 2 * n_u_ + i) = 1.0;
    } else if (treatment.is_latent()) {
      const Index last = state + treatment.states() - 1, order = treatment.process.order;
      for (Index each = state; each < last; ++each) dynamics_(each, each + 1) = 1.0;
      dynamics_.row(last).segment(last - order + 1, order) = treatment.process.feedback();
    }
  }
}

/// Moves the columns of inputs that are states from `input` to `state`. The derivative that white noise drives acts by
/// its mean, a further one not at all.
LinearOutput FirstOrderForm::route_inputs(LinearOutput output) const {
  for (Index i = 0; i < n_u_; ++i) {
    const auto& treatment = treatments_[static_cast<std::size_t>(i)];
    const Index state = input_state(i), count = treatment.states();
    if (count == 0) continue;
    for (Index derivative = 0; derivative < (treatment.is_latent() ? 3 : 2); ++derivative) {
      auto column = output.input.col(derivative * n_u_ + i);
      if (derivative < count)
        output.state.col(state + derivative) += column;
      else if (derivative == count)
        output.state.middleCols(state, count) += column * dynamics_.row(state + count - 1).segment(state, count);
      column.setZero();
    }
  }
  return output;
}

LinearOutput FirstOrderForm::raw_outputs(const OutputMap& outputs) const {
  LinearOutput raw = outputs_of_state(outputs);
  if (basis_.size() > 0) raw.state = raw.state * basis_;
  return raw;
}

LinearOutput FirstOrderForm::outputs_of_state(const OutputMap& outputs) const {
  LinearOutput raw = zero_output(outputs.size(), dynamics_.cols(), 3 * n_u_, m_);
  raw.state.leftCols(n_) = MatrixXd(outputs.displacement);
  raw.state.middleCols(n_, n_) = MatrixXd(outputs.velocity);
  raw.input << outputs.input_value, outputs.input_rate, outputs.input_acceleration;
  raw.force = outputs.force;
  raw = route_inputs(std::move(raw));
  add_scaled(raw, MatrixXd(outputs.acceleration), acceleration_);
  return raw;
}

/// d = b^T z - base^T r, d' and d''; d'' holds z'' and therefore inputs and forces of the same instant.
void FirstOrderForm::set_motion(const LocallyNonlinearSystem& system) {
  const MatrixXd directions = system.connector_directions().transpose(), bases = system.connector_bases();
  motion_ = zero_output(3 * m_, dynamics_.cols(), 3 * n_u_, m_);
  for (Index derivative = 0; derivative < 3; ++derivative) {
    if (derivative < 2) motion_.state.block(derivative * m_, derivative * n_, m_, n_) = directions;
    motion_.input.block(derivative * m_, derivative * n_u_, m_, n_u_) = -bases;
  }
  motion_ = route_inputs(std::move(motion_));
  MatrixXd rows = MatrixXd::Zero(3 * m_, n_);
  rows.bottomRows(m_) = directions;
  add_scaled(motion_, rows, acceleration_);
}

/// s' = A_c s + B_c y_raw per sensor, y = C_c s + D_c y_raw.
void FirstOrderForm::add_chains(const LinearOutput& raw, const std::vector<MeasurementChain>& chains) {
  outputs_ = raw;
  Index state = dynamics_.rows();
  for (const auto& chain : chains) state -= chain.states();
  for (std::size_t i = 0; i < chains.size(); ++i) {
    const ChainStateSpace chain = chains[i].realise();
    const auto row = static_cast<Index>(i), count = chain.A.rows();
    dynamics_.middleRows(state, count) = chain.B * raw.state.row(row);
    dynamics_.block(state, state, count, count) += chain.A;
    force_gain_.middleRows(state, count) = chain.B * raw.force.row(row);
    input_gain_.middleRows(state, count) = chain.B * raw.input.row(row);
    outputs_.state.row(row) *= chain.D;
    outputs_.state.row(row).segment(state, count) += chain.C;
    outputs_.force.row(row) *= chain.D;
    outputs_.input.row(row) *= chain.D;
    state += count;
  }
}

// One first-order hold over all columns of G and B: forces and inputs both are linear over the step. The compliance
// adds what the forces at the end do to the state by then, and to d'' at once.
ExactStep::ExactStep(const FirstOrderForm& form, double step_) : step(step_) {
  const auto m = form.force_gain().cols();
  Eigen::MatrixXd gain(form.size(), m + form.input_gain().cols());
  gain << form.force_gain(), form.input_gain();
  const auto hold = first_order_hold(form.dynamics(), gain, step);
  transition = hold.transition;
  begin_force = hold.begin_weight.leftCols(m);
  end_force = hold.end_weight.leftCols(m);
  begin_input = hold.begin_weight.rightCols(gain.cols() - m);
  end_input = hold.end_weight.rightCols(gain.cols() - m);
  instant_compliance = form.motion().force;
  compliance = form.motion().state * end_force + form.motion().force;
}

}  // namespace kalfem
