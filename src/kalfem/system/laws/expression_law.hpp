// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "kalfem/system/connector_law.hpp"

namespace kalfem {

/// An internal state of a user-written law: its rate as an expression of x, v, f, the states, the signals and the
/// parameters.
struct ExpressionState {
  LawQuantity quantity;
  std::string rate;  ///< such as "A*v - beta*abs(v)*z - gamma*v*abs(z)"
};

/// A named sub-expression.
struct ExpressionLet {
  std::string name;
  std::string value;  ///< of all that the force may use, and of the sub-expressions above it
};

/// A connector law in the user's own words, in the syntax of muParser.
struct ExpressionLawOptions {
  std::string force;  ///< of x (deformation), v (rate), a (relative acceleration), states, signals and parameters
  std::vector<LawQuantity> parameters;
  std::vector<ExpressionState> states = {};  ///< at most 8
  std::vector<LawQuantity> signals = {};     ///< known functions of time, such as a voltage
  std::vector<ExpressionLet> lets = {};
};

/// Most internal states that a user-written law may have; fixed, so that their integration needs no allocation.
inline constexpr int max_internal_states = 8;

/// The law f = force(x, v, a, s, w; theta), s' = rate(x, v, s, w, f; theta), for example
///     force "k*x + mu*x/(m2 + abs(x)) + c*v", parameters k, mu, m2, c.
/// States are integrated over an interval, motion and signals w linear in between, by the two-stage, second-order,
/// L-stable diagonally implicit Runge-Kutta method [Ale77], each stage by a damped Newton iteration. All derivatives
/// are exact (reverse differentiation), through the states too. Each operation is done at up to 64 points at once.
/// Every mistake is reported at once as InvalidInput: syntax (with its position), unknown and unused names, names that
/// clash with x, v, a, a function or a constant. Evaluation never throws: what is not finite, or a state whose implicit
/// step does not converge, gives a NaN force. Each thread has arrays of its own, which grow once.
ConnectorLawPtr expression_law(const ExpressionLawOptions& options);

/// The words that a law of expression_law() was made from; null for any other law.
const ExpressionLawOptions* expression_of(const ConnectorLaw& law);

}  // namespace kalfem
