// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/system/laws/expression_law.hpp"
#include "kalfem/system/laws/expression_tape.hpp"

namespace kalfem {

/// Every problem of the options' names and expressions.
std::vector<Issue> find_issues(const ExpressionLawOptions& options);

/// All expressions of a law on one tape, and the numbers of its values there.
struct CompiledExpressions {
  /// Compiles; the options' syntax has been found free of issues.
  explicit CompiledExpressions(const ExpressionLawOptions& options);

  ExpressionTape tape;
  int x, v, a, force;
  std::vector<int> parameters, states, signals, rates;
};

}  // namespace kalfem
