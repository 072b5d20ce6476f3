// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "kalfem/system/connector_law.hpp"

namespace kalfem {

/// Values by name, in SI units.
using NamedValues = std::vector<std::pair<std::string, double>>;

/// A connector's law with the values of its parameters.
struct Law {
  ConnectorLawPtr law;
  Eigen::VectorXd values;  ///< in the order of law->parameters()
};

/// A law of the library, such as "linear", "saturating", "bouc_wen", "gap" (`kalfem schema --laws` lists them):
///     law("saturating", {{"k", 5e3}, {"mu_k1", 20.0}, {"mu_k2", 2e-3}, {"mu_c2", 0.05}})
/// A missing parameter takes the law's default (`kalfem schema --laws`), or zero if zero is allowed, so that a term
/// without its force is absent. The scales of the saturating law default to those below. Throws InvalidInput with every
/// name that the law does not have, every value out of range, and every parameter that must be given.
Law law(const std::string& name, const NamedValues& values = {});
constexpr double saturating_deformation = 2e-3;  ///< mu_k2 of law("saturating") [m], as in the example of the chain
constexpr double saturating_rate = 0.05;         ///< mu_c2 [m/s]

/// A law as a formula of the deformation x, its rate v and its acceleration a: expression("k*x + k3*x^3", {{"k", 5e3},
/// {"k3", 1e9}}). Throws InvalidInput if the formula cannot be parsed.
Law expression(const std::string& force, const NamedValues& values);

/// Force [N] that resists the deformation [m] at its rate [m/s]. Called from several threads at once; it must not
/// throw.
using ForceFunction = std::function<double(double deformation, double rate, std::span<const double> parameters)>;

/// A law of your own without internal states, from a function of deformation, rate and the parameters in the given
/// order. Tangents are central differences of relative step 6e-6. Throws InvalidInput where the function is empty, a
/// parameter is named twice, or a value is not finite.
Law law(const std::string& name, const NamedValues& values, ForceFunction force);

/// A law of your own with internal states or exact tangents: a class that is derived from ConnectorLaw. Values as for
/// a law of the library.
Law law(ConnectorLawPtr own, const NamedValues& values);

}  // namespace kalfem
