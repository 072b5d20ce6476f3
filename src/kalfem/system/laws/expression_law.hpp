#pragma once

#include <string>
#include <vector>

#include "kalfem/system/connector_law.hpp"

namespace kalfem {

/// An internal state of a user-written law: its rate as an expression of x, v, the states and the parameters.
struct ExpressionState {
  LawQuantity quantity;
  std::string rate;  ///< such as "A*v - beta*abs(v)*z - gamma*v*abs(z)"
};

/// A connector law in the user's own words, in the syntax of muParser.
struct ExpressionLawOptions {
  std::string force;  ///< of x (deformation), v (rate), a (relative acceleration), states and parameters
  std::vector<LawQuantity> parameters;
  std::vector<ExpressionState> states = {};  ///< at most 8
};

/// The law f = force(x, v, a, s; theta), s' = rate(x, v, s; theta), for example
///     force "k*x + mu*x/(m2 + abs(x)) + c*v", parameters k, mu, m2, c.
/// States are integrated as advance_states says; tangents are central differences of relative step 6e-6, through the
/// states too. Every mistake is reported at once as InvalidInput: syntax (with its position), unknown and unused names,
/// names that clash with x, v, a, a function or a constant. Evaluation never throws: what is not finite, or a state
/// whose implicit step does not converge, gives a NaN force. Threads share a pool of parsers; once it has grown to
/// their number, nothing is allocated.
ConnectorLawPtr expression_law(const ExpressionLawOptions& options);

}  // namespace kalfem
