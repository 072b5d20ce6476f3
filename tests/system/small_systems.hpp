// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/model/lumped.hpp"
#include "kalfem/system/coupling.hpp"
#include "kalfem/system/laws/law_library.hpp"

namespace kalfem {

/// The law f = force(d, v) given as a function, tangents by what it returns: for laws that no user would write.
class FunctionLaw final : public ConnectorLaw {
public:
  struct Value {
    double force = 0.0, stiffness = 0.0, damping = 0.0;
  };
  explicit FunctionLaw(std::function<Value(double, double)> function) : function_(std::move(function)) {}

  std::string name() const override { return "function"; }
  const std::vector<LawQuantity>& parameters() const override { return none_; }
  const std::vector<LawQuantity>& states() const override { return none_; }
  void respond(const LawPoints& points, LawResponse response) const override {
    for (Eigen::Index i = 0; i < points.deformation.size(); ++i) {
      const auto value = function_(points.deformation[i], points.rate[i]);
      response.force[i] = value.force;
      response.stiffness[i] = value.stiffness;
      response.damping[i] = value.damping;
      response.inertance[i] = 0.0;
    }
  }

private:
  std::function<Value(double, double)> function_;
  std::vector<LawQuantity> none_;
};

inline ConnectorLawPtr function_law(std::function<FunctionLaw::Value(double, double)> function) {
  return std::make_shared<FunctionLaw>(std::move(function));
}

inline Eigen::VectorXd values(std::initializer_list<double> list) {
  Eigen::VectorXd vector(static_cast<Eigen::Index>(list.size()));
  std::ranges::copy(list, vector.begin());
  return vector;
}

/// A mass m on a spring k and dashpot c to the ground, with a force F and a ground displacement r as inputs.
inline CoupledModel oscillator(double m, double c, double k, const std::vector<ConnectorDescription>& connectors = {},
                               const std::vector<InputDescription>& inputs = {{"F", InputKind::force, "body.x"}}) {
  LumpedSubstructure body{.name = "body", .masses = {{"x", m}}, .springs = {{"s", "ground", "x", k, c}}};
  return CoupledModel({{"body", assemble(body)}}, connectors, inputs);
}

/// Saturating law of the size of a 10^4 N/m spring at a millimetre.
inline Eigen::VectorXd saturating_parameters() { return values({5e3, 20.0, 2e-3, 10.0, 10.0, 0.05}); }

/// wheel on a moving ground, body of `masses` on the wheel through `connectors` only.
inline CoupledModel quarter_chain(int masses, const std::vector<ConnectorDescription>& connectors,
                                  const std::vector<InputDescription>& inputs, double modal_damping = 0.01) {
  LumpedSubstructure wheel{.name = "wheel", .masses = {{"w", 1.5}}, .springs = {{"tyre", "ground", "w", 2e4, 4.0}}};
  LumpedSubstructure body;
  body.name = "body";
  body.modal_damping = {modal_damping};
  for (int i = 1; i <= masses; ++i) {
    body.masses.push_back({std::to_string(i), 1.0});
    if (i > 1) body.springs.push_back({"s" + std::to_string(i), std::to_string(i - 1), std::to_string(i), 3e4});
  }
  return CoupledModel({{"wheel", assemble(wheel)}, {"body", assemble(body)}}, connectors, inputs);
}

}  // namespace kalfem
