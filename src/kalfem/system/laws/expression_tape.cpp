// SPDX-License-Identifier: Apache-2.0
#include "kalfem/system/laws/expression_tape.hpp"

#include <cmath>
#include <utility>

#include "kalfem/system/laws/expression_kernels.hpp"

namespace kalfem {

using enum TapeOperation;

int ExpressionTape::add_variable(const std::string& name) {
  values_.push_back({});
  return names_[name] = size() - 1;
}

int ExpressionTape::add_constant(double value) {
  const auto [known, is_new] = constants_.try_emplace(value, size());
  if (is_new)
    values_.push_back({.kind = TapeValue::Kind::constant, .constant = value, .always_finite = std::isfinite(value)});
  return known->second;
}

int ExpressionTape::add_step(TapeOperation operation, int a, int b, int c) {
  if ((operation == add || operation == multiply) && a > b) std::swap(a, b);
  if (operation == power && is_constant(b, 2.0)) return add_step(square, a);
  if (const int same = neutral(operation, a, b); same >= 0) return same;
  const auto key = std::make_tuple(operation, a, b, c);
  if (const auto found = steps_.find(key); found != steps_.end()) return found->second;
  if (is_constant(a) && (b < 0 || is_constant(b)) && (c < 0 || is_constant(c))) {
    const auto of = [&](int operand) { return operand < 0 ? 0.0 : (*this)[operand].constant; };
    const double folded = compute(operation, of(a), of(b), of(c));
    if (std::isfinite(folded)) return steps_[key] = add_constant(folded);
  }
  values_.push_back({.kind = TapeValue::Kind::result,
                     .operation = operation,
                     .a = a,
                     .b = b,
                     .c = c,
                     .always_finite = always_finite(operation, a, b, c)});
  return steps_[key] = size() - 1;
}

/// The value that a step would only repeat, or -1.
int ExpressionTape::neutral(TapeOperation operation, int a, int b) {
  const auto negated = [&](int value) { return (*this)[value].operation == negate; };
  switch (operation) {
    case add:
      if (is_constant(a, 0.0)) return b;
      if (is_constant(b, 0.0)) return a;
      if (negated(b)) return add_step(subtract, a, (*this)[b].a);
      return negated(a) ? add_step(subtract, b, (*this)[a].a) : -1;
    case subtract:
      if (is_constant(b, 0.0)) return a;
      return negated(b) ? add_step(add, a, (*this)[b].a) : -1;
    case multiply:
      if (is_constant(a, 1.0)) return b;
      if (is_constant(b, 1.0)) return a;
      if (negated(b)) return add_step(negate, add_step(multiply, a, (*this)[b].a));
      return negated(a) ? add_step(negate, add_step(multiply, (*this)[a].a, b)) : -1;
    case divide:
    case power:
      return is_constant(b, 1.0) ? a : -1;
    case guarded_multiply:
      if (is_constant(a, 0.0)) return a;
      if (is_constant(a) || (*this)[b].always_finite) return add_step(multiply, a, b);
      return negated(a) ? add_step(negate, add_step(guarded_multiply, (*this)[a].a, b)) : -1;
    case negate:
      return negated(a) ? (*this)[a].a : -1;
    default:
      return -1;
  }
}

bool ExpressionTape::always_finite(TapeOperation operation, int a, int b, int c) const {
  const auto finite = [&](int value) { return value < 0 || (*this)[value].always_finite; };
  const auto whole = [&](double least) {
    return is_constant(b) && (*this)[b].constant >= least && (*this)[b].constant == std::floor((*this)[b].constant);
  };
  switch (operation) {
    case less:
    case less_equal:
    case greater:
    case greater_equal:
    case equal:
    case not_equal:
    case both:
    case either:
    case sign:
      return true;
    case power:
      return whole(0.0) && finite(a);
    case power_slope:
      return whole(1.0) && finite(a);
    case add:
    case subtract:
    case multiply:
    case negate:
    case minimum:
    case maximum:
    case select:
    case absolute:
    case round:
    case square:
    case sine:
    case cosine:
    case arctangent:
    case hyperbolic_tangent:
    case area_sine:
      return finite(a) && finite(b) && finite(c);
    default:
      return false;
  }
}

bool ExpressionTape::is_constant(int value, double number) const {
  return is_constant(value) && (*this)[value].constant == number;
}

int ExpressionTape::find(const std::string& name) const {
  const auto found = names_.find(name);
  return found == names_.end() ? -1 : found->second;
}

int ExpressionTape::find_constant(double number) const {
  const auto found = constants_.find(number);
  return found == constants_.end() ? -1 : found->second;
}

int ExpressionTape::find_step(TapeOperation operation, int a, int b) const {
  const auto found = steps_.find({operation, a, b, -1});
  return found == steps_.end() ? -1 : found->second;
}

std::vector<char> ExpressionTape::that_depend_on(const std::vector<int>& variables) const {
  std::vector<char> active(values_.size(), 0);
  for (const int variable : variables) active[static_cast<std::size_t>(variable)] = 1;
  for (std::size_t i = 0; i < values_.size(); ++i)
    for (const int operand : {values_[i].a, values_[i].b, values_[i].c})
      if (operand >= 0 && active[static_cast<std::size_t>(operand)] != 0) active[i] = 1;
  return active;
}

bool ExpressionTape::depends(int value, int variable) const {
  return that_depend_on({variable})[static_cast<std::size_t>(value)] != 0;
}

}  // namespace kalfem
