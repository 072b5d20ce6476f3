// SPDX-License-Identifier: Apache-2.0
#include "kalfem/system/laws/compiled_law.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {

using Eigen::Index;

namespace {

/// Of a central difference about x, as its error is least: truncation against rounding.
double step_about(double x) { return std::max(6e-6 * std::abs(x), 1e-9); }

class CompiledLaw final : public ConnectorLaw {
public:
  CompiledLaw(std::string name, std::vector<LawQuantity> parameters, CompiledForce force,
              std::shared_ptr<const void> owner)
      : name_(std::move(name)), parameters_(std::move(parameters)), force_(force), owner_(std::move(owner)) {}

  [[nodiscard]] std::string name() const override { return name_; }
  [[nodiscard]] const std::vector<LawQuantity>& parameters() const override { return parameters_; }
  [[nodiscard]] const std::vector<LawQuantity>& states() const override { return states_; }
  [[nodiscard]] bool uses_acceleration() const override { return false; }

  void respond(const LawPoints& points, LawResponse response) const override {
    std::array<double, most_compiled_parameters> p{};
    for (Index i = 0; i < points.deformation.size(); ++i) {
      for (Index j = 0; j < points.parameters.cols(); ++j) p[static_cast<std::size_t>(j)] = points.parameters(i, j);
      const double x = points.deformation[i], v = points.rate[i], dx = step_about(x), dv = step_about(v);
      const auto force = [&](double at_x, double at_v) { return force_(at_x, at_v, p.data()); };
      response.force[i] = force(x, v);
      response.stiffness[i] = (force(x + dx, v) - force(x - dx, v)) / (2.0 * dx);
      response.damping[i] = (force(x, v + dv) - force(x, v - dv)) / (2.0 * dv);
      response.inertance[i] = 0.0;
    }
  }

private:
  std::string name_;
  std::vector<LawQuantity> parameters_, states_;
  CompiledForce force_;
  std::shared_ptr<const void> owner_;
};

}  // namespace

ConnectorLawPtr compiled_law(std::string name, std::vector<LawQuantity> parameters, CompiledForce force,
                             std::shared_ptr<const void> owner) {
  if (force == nullptr)
    throw InvalidInput("law: the compiled function '" + name + "' has no address", "it is null",
                       "give one that is loaded");
  if (parameters.size() > most_compiled_parameters)
    throw InvalidInput(
        "law: the compiled function '" + name + "' has " + std::to_string(parameters.size()) + " parameters",
        "a compiled law may have " + std::to_string(most_compiled_parameters), "write a ConnectorLaw");
  return std::make_shared<const CompiledLaw>(std::move(name), std::move(parameters), force, std::move(owner));
}

}  // namespace kalfem
