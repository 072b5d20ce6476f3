// SPDX-License-Identifier: Apache-2.0
#include "kalfem/dynamics/collocation_step.hpp"

#include <string>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

CollocationStep::Node node_of(const MatrixXd& transition, const std::vector<MatrixXd>& weights, Index forces) {
  CollocationStep::Node node{transition, {}, {}};
  for (const auto& weight : weights) {
    node.force.emplace_back(weight.leftCols(forces));
    node.input.emplace_back(weight.rightCols(weight.cols() - forces));
  }
  return node;
}

/// Motion of the connectors at the nodes per force there: through the state, and d'' at once.
MatrixXd compliance_of(const std::vector<CollocationStep::Node>& nodes, const LinearOutput& motion) {
  const auto s = static_cast<Index>(nodes.size());
  const Index m = motion.force.cols();
  MatrixXd compliance(3 * m * s, m * s);
  for (Index j = 0; j < s; ++j)
    for (Index l = 0; l < s; ++l) {
      MatrixXd block = motion.state * nodes[static_cast<std::size_t>(j)].force[static_cast<std::size_t>(l + 1)];
      if (j == l) block += motion.force;
      for (Index derivative = 0; derivative < 3; ++derivative)
        compliance.block((derivative * s + j) * m, l * m, m, m) = block.middleRows(derivative * m, m);
    }
  return compliance;
}

}  // namespace

CollocationStep::CollocationStep(const FirstOrderForm& form, double step_, int order)
    : step(step_), instant_compliance(form.motion().force) {
  const Index m = form.force_gain().cols();
  MatrixXd gain(form.size(), m + form.input_gain().cols());
  gain << form.force_gain(), form.input_gain();
  if (order == 2) {
    const auto hold = first_order_hold(form.dynamics(), gain, step);
    nodes = {node_of(hold.transition, {hold.begin_weight, hold.end_weight}, m)};
  } else if (order == 4) {
    const auto hold = quadratic_hold(form.dynamics(), gain, step);
    for (const auto& at : {hold.middle, hold.end})
      nodes.push_back(node_of(at.transition, {at.begin_weight, at.middle_weight, at.end_weight}, m));
    curvature_force = hold.curvature_weight.leftCols(m);
    curvature_input = hold.curvature_weight.rightCols(gain.cols() - m);
  } else {
    throw InvalidInput("a step of order " + std::to_string(order), "there are steps of order 2 and 4", "");
  }
  compliance = compliance_of(nodes, form.motion());
}

}  // namespace kalfem
