// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "kalfem/system/laws/expression_tape.hpp"

namespace kalfem {

/// A column of a value: `offset` doubles behind the begin that a table of columns has for `base`.
struct Place {
  int base = 0, offset = 0;
};

struct Instruction;

/// Computes an instruction at `count` points, and then those that follow it. Operands that its operation does not have
/// are not read; the result's column is none of the operands'.
using TapeKernel = void (*)(const Instruction* at, double* const* table, std::ptrdiff_t count);

/// One operation on columns.
struct Instruction {
  TapeKernel kernel = nullptr;
  Place out, a, b, c, d;
};

/// The kernel of an operation. `finish` ends a list of instructions.
TapeKernel kernel_of(TapeOperation operation);

/// How an operand is read.
enum class OperandForm : unsigned char { plain, square, cube, cube_slope, magnitude, sign };

/// The kernel of an operation whose last operand is read in a form, or null where there is none: of `add`,
/// `inverse_of_sum`, and the products and their sums.
TapeKernel kernel_of(TapeOperation operation, OperandForm form);

/// One operation on numbers.
double compute(TapeOperation operation, double a, double b, double c);

}  // namespace kalfem
