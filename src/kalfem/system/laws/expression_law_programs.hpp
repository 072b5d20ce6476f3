// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/system/laws/expression_checks.hpp"
#include "kalfem/system/laws/expression_program.hpp"
#include "kalfem/system/laws/expression_states.hpp"

namespace kalfem {

/// Columns of a law's answers, in their order behind the variables of the table.
enum LawAnswer : int { force_answer, stiffness_answer, damping_answer, inertance_answer, answer_count };

/// The programs of a law written as expressions, by when they run, and where their results stand.
struct LawPrograms {
  /// Compiles; the options have been found free of issues.
  explicit LawPrograms(const ExpressionLawOptions& options);

  CompiledExpressions at;
  int variable_count;
  bool uses_acceleration;
  ExpressionProgram of_parameters;    ///< what depends on parameters alone; runs before the others
  RatePrograms rates;                 ///< of the states
  ExpressionProgram of_force;         ///< the answers, states held
  std::vector<Place> force_by_state;  ///< df/ds
  AlignedColumns constants;
  int result_count;  ///< columns of results
};

}  // namespace kalfem
