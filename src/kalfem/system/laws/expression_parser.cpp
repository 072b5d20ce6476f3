// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <numbers>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/system/laws/expression_tape.hpp"

namespace kalfem {

using enum TapeOperation;

namespace {

struct Function {
  ExpressionFunction text;
  TapeOperation operation;
};

const std::vector<Function>& functions() {
  static const std::vector<Function> all{
      {{"abs", "magnitude"}, absolute},
      {{"sign", "-1, 0 or 1"}, sign},
      {{"rint", "nearest whole number"}, round},
      {{"sqrt", "square root"}, square_root},
      {{"exp", "exponential"}, exponential},
      {{"ln", "natural logarithm"}, logarithm},
      {{"log", "natural logarithm, the same as ln"}, logarithm},
      {{"log2", "logarithm to base 2"}, logarithm_2},
      {{"log10", "logarithm to base 10"}, logarithm_10},
      {{"sin", "sine [rad]"}, sine},
      {{"cos", "cosine [rad]"}, cosine},
      {{"tan", "tangent [rad]"}, tangent},
      {{"asin", "arc sine [rad]"}, arcsine},
      {{"acos", "arc cosine [rad]"}, arccosine},
      {{"atan", "arc tangent [rad]"}, arctangent},
      {{"atan2", "angle of the point (b, a) for atan2(a, b) [rad]"}, arctangent_2},
      {{"sinh", "hyperbolic sine"}, hyperbolic_sine},
      {{"cosh", "hyperbolic cosine"}, hyperbolic_cosine},
      {{"tanh", "hyperbolic tangent"}, hyperbolic_tangent},
      {{"asinh", "inverse of sinh"}, area_sine},
      {{"acosh", "inverse of cosh"}, area_cosine},
      {{"atanh", "inverse of tanh"}, area_tangent},
      {{"min", "smallest of its arguments"}, minimum},
      {{"max", "largest of its arguments"}, maximum},
      {{"sum", "sum of its arguments"}, add},
      {{"avg", "mean of its arguments"}, add},
  };
  return all;
}

}  // namespace

const std::vector<ExpressionFunction>& expression_functions() {
  static const std::vector<ExpressionFunction> all = [] {
    std::vector<ExpressionFunction> texts;
    for (const auto& function : functions()) texts.push_back(function.text);
    return texts;
  }();
  return all;
}

namespace {

// Recursive descent with precedence climbing. From loose to tight: ?:, ||, &&, comparisons, + -, * / and signs, ^
// (which groups from the right).
class ExpressionParser {
public:
  ExpressionParser(ExpressionTape& tape, const std::string& text) : tape_(tape), text_(text) {}

  int parse() {
    const int value = choice();
    if (skip_blanks(); at_ != text_.size()) fail();
    return value;
  }

private:
  int choice() {
    const int condition = operation(0);
    if (!accept("?")) return condition;
    const int yes = choice();
    if (!accept(":")) fail();
    const int no = choice();
    return tape_.add_step(select, condition, yes, no);
  }

  /// A chain of operators of this level, grouped from the left.
  int operation(std::size_t level) {
    struct Sign {
      const char* text;
      TapeOperation operation;
    };
    static const std::vector<std::vector<Sign>> levels{
        {{"||", either}},
        {{"&&", both}},
        {{"<=", less_equal}, {">=", greater_equal}, {"==", equal}, {"!=", not_equal}, {"<", less}, {">", greater}},
        {{"+", add}, {"-", subtract}},
        {{"*", multiply}, {"/", divide}}};
    if (level == levels.size()) return signed_power();
    int left = operation(level + 1);
    for (;;) {
      const auto found = std::ranges::find_if(levels[level], [&](const Sign& sign) { return accept(sign.text); });
      if (found == levels[level].end()) return left;
      const int right = operation(level + 1);
      left = tape_.add_step(found->operation, left, right);
    }
  }

  int signed_power() {
    if (accept("-")) return tape_.add_step(negate, signed_power());
    if (accept("+")) return signed_power();
    const int base = atom();
    return accept("^") ? tape_.add_step(power, base, signed_power()) : base;
  }

  int atom() {
    skip_blanks();
    if (accept("(")) {
      const int value = choice();
      if (!accept(")")) fail();
      return value;
    }
    if (at_ == text_.size()) fail();
    const char first = text_[at_];
    if ((first >= '0' && first <= '9') || first == '.') return number();
    return name();
  }

  int number() {
    const char* begin = text_.c_str() + at_;
    char* end = nullptr;
    const double value = std::strtod(begin, &end);
    if (end == begin) fail();
    at_ += static_cast<std::size_t>(end - begin);
    return tape_.add_constant(value);
  }

  int name() {
    const auto begin = at_;
    while (at_ < text_.size() && (std::isalnum(static_cast<unsigned char>(text_[at_])) != 0 || text_[at_] == '_'))
      ++at_;
    const std::string word = text_.substr(begin, at_ - begin);
    if (accept("(")) return call(word);
    if (word == "_pi") return tape_.add_constant(std::numbers::pi);
    if (word == "_e") return tape_.add_constant(std::numbers::e);
    const int found = tape_.find(word);
    if (found < 0) fail();
    return found;
  }

  int call(const std::string& word) {
    const auto found =
        std::ranges::find(functions(), word, [](const Function& function) { return function.text.name; });
    if (found == functions().end()) fail();
    std::vector<int> arguments{choice()};
    while (accept(",")) arguments.push_back(choice());
    if (!accept(")")) fail();
    if (word == "atan2") return tape_.add_step(arctangent_2, arguments.at(0), arguments.at(1));
    if (word != "min" && word != "max" && word != "sum" && word != "avg")
      return tape_.add_step(found->operation, arguments.front());
    int value = arguments.front();
    for (std::size_t i = 1; i < arguments.size(); ++i) value = tape_.add_step(found->operation, value, arguments[i]);
    if (word != "avg") return value;
    return tape_.add_step(divide, value, tape_.add_constant(static_cast<double>(arguments.size())));
  }

  void skip_blanks() {
    while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_])) != 0) ++at_;
  }
  bool accept(const char* sign) {
    skip_blanks();
    const std::string wanted(sign);
    if (text_.compare(at_, wanted.size(), wanted) != 0) return false;
    at_ += wanted.size();
    return true;
  }
  [[noreturn]] void fail() const {
    throw InvalidInput(
        "expression \"" + text_ + "\": the part from position " + std::to_string(at_) + " has no meaning",
        "an expression has names, numbers, + - * / ^, comparisons, && ||, a ? b : c and functions",
        "correct the expression there; `kalfem schema --laws` lists the functions");
  }

  ExpressionTape& tape_;
  const std::string& text_;
  std::size_t at_ = 0;
};

}  // namespace

int ExpressionTape::compile(const std::string& text) { return ExpressionParser(*this, text).parse(); }

}  // namespace kalfem
