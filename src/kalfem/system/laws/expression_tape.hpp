// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <tuple>
#include <vector>

namespace kalfem {

/// An operation of an expression on values a, b, c, d.
enum class TapeOperation : unsigned char {
  add,
  subtract,
  multiply,
  divide,
  power,
  negate,
  minimum,
  maximum,
  less,
  less_equal,
  greater,
  greater_equal,
  equal,
  not_equal,
  both,
  either,
  select,
  absolute,
  sign,
  round,
  square,
  square_root,
  exponential,
  logarithm,
  logarithm_2,
  logarithm_10,
  sine,
  cosine,
  tangent,
  arcsine,
  arccosine,
  arctangent,
  arctangent_2,
  hyperbolic_sine,
  hyperbolic_cosine,
  hyperbolic_tangent,
  area_sine,
  area_cosine,
  area_tangent,
  // of derivatives only
  guarded_multiply,  ///< a b, but 0 where a is 0, even if b is no number
  power_slope,       ///< b a^(b - 1), where c is a^b
  // of programs only
  copy,
  finish,                    ///< the end
  cube,                      ///< a^3
  cube_slope,                ///< 3 a^2
  multiply_subtract,         ///< a b - c
  guarded_multiply_add,      ///< a + b c, but a where b is 0
  guarded_subtract_product,  ///< a - b c, but a where b is 0
  difference_of_products,    ///< a b - c d
  sum_of_products,           ///< a b + c d
  multiply_add,              ///< a + b c
  subtract_product,          ///< a - b c
  multiply_three,            ///< a b c
  multiply_three_add,        ///< a + b c d
  subtract_three,            ///< a - b c d
  inverse_of_sum             ///< 1 / (a + b)
};

/// A value of a tape: a variable, a constant or the result of an operation on earlier values.
struct TapeValue {
  enum class Kind : unsigned char { variable, constant, result };

  Kind kind = Kind::variable;
  TapeOperation operation = TapeOperation::copy;
  int a = -1, b = -1, c = -1;  ///< numbers of the operands, -1: none
  double constant = 0.0;
  /// Whether it is a number wherever the variables are, overflow aside.
  bool always_finite = true;
};

/// Expressions and their derivatives as a list of values, each from values before it. What is equal stands there once,
/// constants are folded, and neutral operations (x + 0, 1 x) left out.
class ExpressionTape {
public:
  /// Number of the value of a new variable.
  int add_variable(const std::string& name);
  /// Lets a name stand for a value that is known already.
  void add_name(const std::string& name, int value) { names_[name] = value; }
  /// Number of the value of the expression, whose syntax is that of muParser. Throws InvalidInput where it is not.
  int compile(const std::string& text);

  int add_constant(double value);
  int add_step(TapeOperation operation, int a, int b = -1, int c = -1);

  [[nodiscard]] int size() const { return static_cast<int>(values_.size()); }
  [[nodiscard]] const TapeValue& operator[](int value) const { return values_[static_cast<std::size_t>(value)]; }
  [[nodiscard]] bool is_constant(int value, double number) const;
  /// The value of a name, a constant or a step, -1: none.
  [[nodiscard]] int find(const std::string& name) const;
  [[nodiscard]] int find_constant(double number) const;
  [[nodiscard]] int find_step(TapeOperation operation, int a, int b) const;
  /// Which values depend on some of the variables.
  [[nodiscard]] std::vector<char> that_depend_on(const std::vector<int>& variables) const;
  [[nodiscard]] bool depends(int value, int variable) const;

private:
  [[nodiscard]] int neutral(TapeOperation operation, int a, int b);
  [[nodiscard]] bool always_finite(TapeOperation operation, int a, int b, int c) const;
  [[nodiscard]] bool is_constant(int value) const {
    return value >= 0 && (*this)[value].kind == TapeValue::Kind::constant;
  }

  std::vector<TapeValue> values_;
  std::map<std::string, int> names_;
  std::map<double, int> constants_;
  std::map<std::tuple<TapeOperation, int, int, int>, int> steps_;
};

/// A function that expressions know.
struct ExpressionFunction {
  std::string name;
  std::string meaning;
};
const std::vector<ExpressionFunction>& expression_functions();

}  // namespace kalfem
