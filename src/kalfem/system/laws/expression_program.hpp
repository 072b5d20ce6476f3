// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "kalfem/system/laws/expression_kernels.hpp"
#include "kalfem/system/laws/expression_tape.hpp"

namespace kalfem {

/// Most points that a program works on at once: a column of each value stays in the first-level cache.
inline constexpr Eigen::Index points_together = 64;

/// Entries of the table of columns, the same for every program of a tape. Behind them stand the tape's variables in
/// their order, and then the columns of the answers.
enum ColumnBase : int { results_base, constants_base, first_variable_base };

/// The begins of columns. Only those of results and answers are written.
using ColumnTable = std::vector<double*>;

inline double* column(const ColumnTable& table, Place place) {
  return table[static_cast<std::size_t>(place.base)] + place.offset;
}

/// Instructions up to `finish`.
using ExpressionProgram = std::vector<Instruction>;

inline void run(const ExpressionProgram& program, const ColumnTable& table, Eigen::Index count) {
  program.front().kernel(program.data(), table.data(), count);
}

/// Columns of constants, `points_together` rows each.
using AlignedColumns = std::vector<double, Eigen::aligned_allocator<double>>;

/// Makes programs of a tape. A value has one place, whichever program computes it; what only one sum or product
/// reads is computed with it where there is a kernel for both, and a quotient a/b is a (1/b) where 1/b is on the tape
/// too.
class ProgramMaker {
public:
  /// The tape's first values are its `variables` variables.
  ProgramMaker(const ExpressionTape& tape, int variables);

  /// Lets the value be computed into the column of an answer, the `answer`-th behind the variables. Where that cannot
  /// be, as for a variable, `copies` gets the instruction that copies it.
  void answer(int value, int answer, ExpressionProgram& copies);
  /// Instructions for the targets from what is `known`; their results become known.
  [[nodiscard]] ExpressionProgram make(const std::vector<int>& targets, std::vector<char>& known);
  /// The results not marked in `later` that the targets need: what can be computed before the marked values are known.
  [[nodiscard]] std::vector<int> needed_before(const std::vector<int>& targets, const std::vector<char>& later) const;

  [[nodiscard]] Place place(int value);
  /// Places of `points_together` rows for the values, which the program copies there if they stand elsewhere.
  [[nodiscard]] std::vector<Place> full_places(const std::vector<int>& values, ExpressionProgram& program);
  [[nodiscard]] int result_count() const { return result_count_; }
  [[nodiscard]] const AlignedColumns& constants() const { return constants_; }

private:
  /// Factors of a product, the last of which is read in a form.
  struct Factors {
    std::vector<int> values;
    OperandForm form = OperandForm::plain;
  };

  [[nodiscard]] TapeValue step(int value) const;
  [[nodiscard]] bool is_result(int value) const { return tape_[value].kind == TapeValue::Kind::result; }
  void count_uses(int value);
  void emit(int value);
  [[nodiscard]] bool is_inner(int value) const;
  [[nodiscard]] bool is_inner(int value, TapeOperation operation) const;
  [[nodiscard]] Factors factors_of(const TapeValue& product) const;
  [[nodiscard]] Factors factors_of(int product) const { return factors_of(step(product)); }
  [[nodiscard]] OperandForm form_of(int value) const;
  void read_last_in_form(Factors& factors) const;
  Instruction sum(const TapeValue& of);
  Instruction product(const TapeValue& of);
  Instruction instruction(TapeOperation operation, OperandForm form, const std::vector<int>& operands);

  const ExpressionTape& tape_;
  int variables_, result_count_ = 0;
  std::vector<Place> places_;
  AlignedColumns constants_;
  std::vector<char>* known_ = nullptr;  ///< of the program that is being made, as are the following
  std::vector<int> uses_;
  ExpressionProgram program_;
};

}  // namespace kalfem
