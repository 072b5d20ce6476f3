// SPDX-License-Identifier: Apache-2.0
#include "kalfem/system/linearised.hpp"

#include <cmath>

namespace kalfem {
namespace {

using Eigen::ArrayXd;
using Eigen::ArrayXXd;
using Eigen::Index;
using Eigen::VectorXd;

/// Tangents of a law where nothing moves.
struct Tangents {
  double stiffness = 0.0, damping = 0.0, inertance = 0.0;
};

Tangents tangents_at_rest(const Connector& connector) {
  const auto states = static_cast<Index>(connector.law->states().size());
  const ArrayXd zero = ArrayXd::Zero(1);
  const ArrayXXd values = connector.parameters.transpose(), no_states = ArrayXXd::Zero(1, states);
  const ArrayXXd silence = ArrayXXd::Zero(1, std::ssize(connector.law->signals()));
  const LawSignals signals(silence.data(), 1, silence.cols(), Eigen::OuterStride<>(1));
  ArrayXd force(1), stiffness(1), damping(1), inertance(1);
  ArrayXXd end_states(1, states);
  connector.law->respond({0.0, values, zero, zero, no_states, zero, zero, zero, signals, signals},
                         {force, stiffness, damping, inertance, end_states});
  return {stiffness[0], damping[0], inertance[0]};
}

/// What the connectors add to M, C and K, and to the loads of the moved grounds.
class ConnectorsAtRest {
public:
  explicit ConnectorsAtRest(const LocallyNonlinearSystem& system) : system_(system) {
    IssueList issues;
    const Index count = system.connector_count();
    stiffness_.resize(count);
    damping_.resize(count);
    inertance_.resize(count);
    for (Index j = 0; j < count; ++j) {
      const auto& connector = system.connectors[static_cast<std::size_t>(j)];
      const auto [k, c, m] = tangents_at_rest(connector);
      if (!std::isfinite(k) || !std::isfinite(c) || !std::isfinite(m))
        issues.add({}, "connector '" + connector.name + "' has no tangent at rest",
                   "a linear model needs the slope of its force", "choose a law that is smooth at rest");
      stiffness_[j] = k;
      damping_[j] = c;
      inertance_[j] = m;
    }
    issues.raise();
    directions_ = system.connector_directions().sparseView();
  }

  void add_to(LinearModel& model) const {
    model.mass += joined(inertance_);
    model.damping += joined(damping_);
    model.stiffness += joined(stiffness_);
  }

  /// A ground that moves by r relieves connector j by g_j r.
  void add_to(GroundCoupling& ground, Index input) const {
    for (Index j = 0; j < stiffness_.size(); ++j) {
      const auto& connector = system_.connectors[static_cast<std::size_t>(j)];
      ground.stiffness += stiffness_[j] * connector.base[input] * connector.deformation;
      ground.damping += damping_[j] * connector.base[input] * connector.deformation;
    }
  }

private:
  [[nodiscard]] SparseMatrix joined(const VectorXd& tangents) const {
    const SparseMatrix forces = directions_ * tangents.asDiagonal();
    return forces * SparseMatrix(directions_.transpose());
  }

  const LocallyNonlinearSystem& system_;
  VectorXd stiffness_, damping_, inertance_;
  SparseMatrix directions_;
};

/// Points and gauges of a part under the names of the whole; a degree of freedom that parts share has one name.
void add_places(const Substructure& part, const CoupledModel& coupled, LinearModel& model) {
  const auto of_whole = [&](const DofCombination& combination) {
    DofCombination sum;
    for (const auto& [dof, coefficient] : combination) {
      const auto place = static_cast<std::size_t>(coupled.dof_index(part.name + "." + dof));
      sum[model.dofs[place]] += coefficient;
    }
    return sum;
  };
  for (const auto& [name, combination] : part.model->points)
    model.points[part.name + "." + name] = of_whole(combination);
  for (const auto& [name, combination] : part.model->gauges)
    model.gauges[part.name + "." + name] = of_whole(combination);
}

}  // namespace

LinearModel linearised_at_rest(const CoupledModel& coupled) {
  const auto& system = coupled.system();
  const ConnectorsAtRest connectors(system);
  LinearModel model;
  model.dofs = system.dofs;
  model.mass = system.mass;
  model.damping = system.damping;
  model.stiffness = system.stiffness;
  connectors.add_to(model);
  model.modal_damping = system.modal_damping;
  for (Index i = 0; i < system.input_count(); ++i) {
    const auto& input = system.inputs[static_cast<std::size_t>(i)];
    if (input.unit != unit_of(InputKind::base_displacement)) continue;
    GroundCoupling ground{input.name, input.value, input.rate};
    connectors.add_to(ground, i);
    model.grounds.push_back(std::move(ground));
  }
  for (const auto& part : coupled.substructures()) add_places(part, coupled, model);
  return model;
}

}  // namespace kalfem
