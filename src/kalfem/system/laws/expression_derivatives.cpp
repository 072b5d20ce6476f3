// SPDX-License-Identifier: Apache-2.0
#include "kalfem/system/laws/expression_derivatives.hpp"

#include <numbers>

namespace kalfem {
namespace {

using enum TapeOperation;

// Reverse accumulation: from the value back, each step hands its adjoint (the derivative of the value by the step's
// result) on to its operands, times the step's own derivative. An adjoint is a value of the tape like any other.
class ReverseAccumulation {
public:
  ReverseAccumulation(ExpressionTape& tape, int value, const std::vector<int>& variables)
      : tape_(tape), active_(tape.that_depend_on(variables)), adjoints_(active_.size(), -1) {
    adjoint(value) = tape_.add_constant(1.0);
    for (int i = value; i >= 0; --i)
      if (adjoint(i) >= 0 && tape_[i].kind == TapeValue::Kind::result && !tape_.is_constant(adjoint(i), 0.0))
        hand_on(i, adjoint(i));
  }

  [[nodiscard]] int derivative(int variable) { return adjoint(variable) >= 0 ? adjoint(variable) : number(0.0); }

private:
  int& adjoint(int value) { return adjoints_[static_cast<std::size_t>(value)]; }
  [[nodiscard]] bool wanted(int value) const { return active_[static_cast<std::size_t>(value)] != 0; }

  int number(double value) { return tape_.add_constant(value); }
  int step(TapeOperation operation, int a, int b = -1, int c = -1) { return tape_.add_step(operation, a, b, c); }
  int inverse(int value) { return step(divide, number(1.0), value); }

  void plus(int operand, int term) {
    if (!wanted(operand)) return;
    int& sum = adjoint(operand);
    const TapeValue so_far = sum < 0 ? TapeValue{} : tape_[sum];
    if (sum < 0)
      sum = term;
    else if (so_far.operation == subtract)  // what is subtracted last goes with its product in one pass
      sum = step(subtract, step(add, so_far.a, term), so_far.b);
    else
      sum = step(add, sum, term);
  }
  void minus(int operand, int term) {
    if (wanted(operand))
      adjoint(operand) = adjoint(operand) < 0 ? step(negate, term) : step(subtract, adjoint(operand), term);
  }

  // `of` is the adjoint of y = a (operation) b.
  void hand_on(int y, int of) {
    const TapeValue at = tape_[y];
    const int a = at.a, b = at.b, c = at.c;
    switch (at.operation) {
      case add:
        plus(a, of);
        plus(b, of);
        break;
      case subtract:
        plus(a, of);
        minus(b, of);
        break;
      case negate:
        minus(a, of);
        break;
      case multiply:
        if (wanted(a)) plus(a, step(guarded_multiply, of, b));
        if (wanted(b)) plus(b, step(guarded_multiply, of, a));
        break;
      case divide:
        if (wanted(a)) plus(a, step(guarded_multiply, of, inverse(b)));
        if (wanted(b)) minus(b, step(guarded_multiply, of, step(multiply, y, inverse(b))));
        break;
      case power:
        if (wanted(a)) plus(a, step(guarded_multiply, of, step(power_slope, a, b, y)));
        if (wanted(b))
          plus(b, step(guarded_multiply, of,
                       step(select, step(equal, y, number(0.0)), number(0.0), step(multiply, y, step(logarithm, a)))));
        break;
      case minimum:
      case maximum:
        choose(step(at.operation == minimum ? less_equal : greater_equal, a, b), of, a, b);
        break;
      case select:
        choose(a, of, b, c);
        break;
      case arctangent_2: {
        const int size = inverse(step(add, step(square, a), step(square, b)));
        if (wanted(a)) plus(a, step(guarded_multiply, of, step(multiply, b, size)));
        if (wanted(b)) minus(b, step(guarded_multiply, of, step(multiply, a, size)));
        break;
      }
      default:
        if (const int by_a = slope(at.operation, a, y); by_a >= 0) plus(a, step(guarded_multiply, of, by_a));
    }
  }

  void choose(int condition, int of, int yes, int no) {
    if (wanted(yes)) plus(yes, step(select, condition, of, number(0.0)));
    if (wanted(no)) plus(no, step(select, condition, number(0.0), of));
  }

  /// Derivative of y = operation(a); -1: flat.
  int slope(TapeOperation operation, int a, int y) {
    const auto one_and = [&](TapeOperation sign_of_square, int value) {
      return step(sign_of_square, number(1.0), step(square, value));
    };
    switch (operation) {
      case absolute:
        return step(sign, a);
      case square:
        return step(multiply, number(2.0), a);
      case square_root:
        return step(divide, number(0.5), y);
      case exponential:
        return y;
      case logarithm:
        return inverse(a);
      case logarithm_2:
        return step(multiply, inverse(a), number(1.0 / std::numbers::ln2));
      case logarithm_10:
        return step(multiply, inverse(a), number(1.0 / std::numbers::ln10));
      case sine:
        return step(cosine, a);
      case cosine:
        return step(negate, step(sine, a));
      case tangent:
        return one_and(add, y);
      case arcsine:
        return inverse(step(square_root, one_and(subtract, a)));
      case arccosine:
        return step(negate, inverse(step(square_root, one_and(subtract, a))));
      case arctangent:
        return inverse(one_and(add, a));
      case hyperbolic_sine:
        return step(hyperbolic_cosine, a);
      case hyperbolic_cosine:
        return step(hyperbolic_sine, a);
      case hyperbolic_tangent:
        return one_and(subtract, y);
      case area_sine:
        return inverse(step(square_root, one_and(add, a)));
      case area_cosine:
        return inverse(step(square_root, step(subtract, step(square, a), number(1.0))));
      case area_tangent:
        return inverse(one_and(subtract, a));
      default:
        return -1;
    }
  }

  ExpressionTape& tape_;
  std::vector<char> active_;
  std::vector<int> adjoints_;
};

}  // namespace

std::vector<int> differentiate(ExpressionTape& tape, int value, const std::vector<int>& variables) {
  ReverseAccumulation reverse(tape, value, variables);
  std::vector<int> derivatives;
  for (const int variable : variables) derivatives.push_back(reverse.derivative(variable));
  return derivatives;
}

}  // namespace kalfem
