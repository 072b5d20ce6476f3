#pragma once

#include <Eigen/Dense>
#include <map>
#include <string>
#include <tuple>
#include <vector>

namespace kalfem {

/// An operation of an expression on one, two or three values.
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
  area_tangent
};

/// One step of a tape: value `out` from the values `a`, `b`, `c`.
struct TapeStep {
  TapeOperation operation = TapeOperation::add;
  int out = 0, a = -1, b = -1, c = -1;
  /// In a backward pass: whether a derivative by the operand is wanted.
  bool by_a = false, by_b = false, by_c = false;
};

/// One quantity at W points, a point per lane of the vector registers.
template <int W>
using TapeLanes = Eigen::Array<double, W, 1>;

/// Expressions compiled into a list of steps, with common sub-expressions computed once and constants folded. Values
/// are numbered: variables, constants, results of steps. The syntax is that of muParser, by which the text has been
/// checked.
class ExpressionTape {
public:
  /// Number of the value of a new variable.
  int add_variable(const std::string& name);
  /// Lets a name stand for a value that is known already.
  void add_name(const std::string& name, int value) { names_[name] = value; }
  /// Number of the value of the expression.
  int compile(const std::string& text);

  [[nodiscard]] int size() const { return size_; }  ///< number of values
  [[nodiscard]] const std::vector<std::pair<int, double>>& constants() const { return constants_; }

  /// Steps that lead to the values, in order, without those whose value is `known`; they become known.
  [[nodiscard]] std::vector<TapeStep> steps_to(const std::vector<int>& values, std::vector<char>& known) const;
  /// Steps that depend on none but these variables and constants, in order; they become known.
  [[nodiscard]] std::vector<TapeStep> steps_from(const std::vector<int>& variables, std::vector<char>& known) const;
  /// Steps from the value back to the variables that its derivatives are wanted by.
  [[nodiscard]] std::vector<TapeStep> steps_back(int value, const std::vector<int>& variables) const;
  /// Whether the value depends on the variable.
  [[nodiscard]] bool depends(int value, int variable) const;

private:
  friend class ExpressionParser;
  int add_constant(double value);
  int add_step(TapeOperation operation, int a, int b = -1, int c = -1);
  [[nodiscard]] const double* constant(int value) const;
  [[nodiscard]] std::vector<char> that_depend_on(const std::vector<int>& variables) const;

  int size_ = 0;
  std::map<std::string, int> names_;
  std::vector<std::pair<int, double>> constants_;
  std::vector<TapeStep> steps_;
  std::map<std::tuple<TapeOperation, int, int, int>, int> known_steps_;
};

/// Computes the steps' values.
template <int W>
void run(const std::vector<TapeStep>& steps, TapeLanes<W>* values);

/// Adds to `adjoints`, from that of the last step's value back, the derivatives by all values that the steps read.
/// `adjoints` of these values have been set to zero, and that of the result to one.
template <int W>
void run_back(const std::vector<TapeStep>& steps, const TapeLanes<W>* values, TapeLanes<W>* adjoints);

/// A function that expressions know.
struct ExpressionFunction {
  std::string name;
  std::string meaning;
};
const std::vector<ExpressionFunction>& expression_functions();

}  // namespace kalfem
