#include "kalfem/system/laws/expression_tape.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {

using enum TapeOperation;

namespace {

template <int W, class Function>
TapeLanes<W> each(const TapeLanes<W>& a, const Function& function) {
  TapeLanes<W> out;
  for (int i = 0; i < W; ++i) out[i] = function(a[i]);
  return out;
}

template <int W, class Function>
TapeLanes<W> each(const TapeLanes<W>& a, const TapeLanes<W>& b, const Function& function) {
  TapeLanes<W> out;
  for (int i = 0; i < W; ++i) out[i] = function(a[i], b[i]);
  return out;
}

template <int W>
TapeLanes<W> truth(const Eigen::Array<bool, W, 1>& test) {
  return test.template cast<double>();
}

/// a^b; the exponents that laws have most often cost no call of pow.
template <int W>
TapeLanes<W> raised(const TapeLanes<W>& a, const TapeLanes<W>& b) {
  const double n = b[0];
  if ((b == n).all()) {
    if (n == 0.0) return TapeLanes<W>::Ones();
    if (n == 1.0) return a;
    if (n == 2.0) return a * a;
    if (n == 3.0) return a * a * a;
  }
  return each<W>(a, b, [](double base, double exponent) { return std::pow(base, exponent); });
}

template <int W>
TapeLanes<W> result(const TapeStep& step, const TapeLanes<W>* v) {
  const auto& a = v[step.a];
  const auto b = [&]() -> const TapeLanes<W>& { return v[step.b]; };
  switch (step.operation) {
    case add:
      return a + b();
    case subtract:
      return a - b();
    case multiply:
      return a * b();
    case divide:
      return a / b();
    case power:
      return raised<W>(a, b());
    case negate:
      return -a;
    case minimum:
      return a.min(b());
    case maximum:
      return a.max(b());
    case less:
      return truth<W>(a < b());
    case less_equal:
      return truth<W>(a <= b());
    case greater:
      return truth<W>(a > b());
    case greater_equal:
      return truth<W>(a >= b());
    case equal:
      return truth<W>(a == b());
    case not_equal:
      return truth<W>(a != b());
    case both:
      return truth<W>(a != 0.0 && b() != 0.0);
    case either:
      return truth<W>(a != 0.0 || b() != 0.0);
    case select:
      return (a != 0.0).select(b(), v[step.c]);
    case absolute:
      return a.abs();
    case sign:
      return truth<W>(a > 0.0) - truth<W>(a < 0.0);
    case round:
      return each<W>(a, [](double x) { return std::floor(x + 0.5); });
    case square:
      return a * a;
    case square_root:
      return a.sqrt();
    case exponential:
      return each<W>(a, [](double x) { return std::exp(x); });
    case logarithm:
      return each<W>(a, [](double x) { return std::log(x); });
    case logarithm_2:
      return each<W>(a, [](double x) { return std::log2(x); });
    case logarithm_10:
      return each<W>(a, [](double x) { return std::log10(x); });
    case sine:
      return each<W>(a, [](double x) { return std::sin(x); });
    case cosine:
      return each<W>(a, [](double x) { return std::cos(x); });
    case tangent:
      return each<W>(a, [](double x) { return std::tan(x); });
    case arcsine:
      return each<W>(a, [](double x) { return std::asin(x); });
    case arccosine:
      return each<W>(a, [](double x) { return std::acos(x); });
    case arctangent:
      return each<W>(a, [](double x) { return std::atan(x); });
    case arctangent_2:
      return each<W>(a, b(), [](double y, double x) { return std::atan2(y, x); });
    case hyperbolic_sine:
      return each<W>(a, [](double x) { return std::sinh(x); });
    case hyperbolic_cosine:
      return each<W>(a, [](double x) { return std::cosh(x); });
    case hyperbolic_tangent:
      return each<W>(a, [](double x) { return std::tanh(x); });
    case area_sine:
      return each<W>(a, [](double x) { return std::asinh(x); });
    case area_cosine:
      return each<W>(a, [](double x) { return std::acosh(x); });
    case area_tangent:
      return each<W>(a, [](double x) { return std::atanh(x); });
  }
  return a;
}

/// Derivative of the step's value y by its operand a, for operations on one value.
template <int W>
TapeLanes<W> slope(const TapeStep& step, const TapeLanes<W>& a, const TapeLanes<W>& y) {
  switch (step.operation) {
    case absolute:
      return truth<W>(a > 0.0) - truth<W>(a < 0.0);
    case square:
      return 2.0 * a;
    case square_root:
      return 0.5 / y;
    case exponential:
      return y;
    case logarithm:
      return a.inverse();
    case logarithm_2:
      return a.inverse() / std::numbers::ln2;
    case logarithm_10:
      return a.inverse() / std::numbers::ln10;
    case sine:
      return each<W>(a, [](double x) { return std::cos(x); });
    case cosine:
      return each<W>(a, [](double x) { return -std::sin(x); });
    case tangent:
      return 1.0 + y * y;
    case arcsine:
      return (1.0 - a * a).sqrt().inverse();
    case arccosine:
      return -(1.0 - a * a).sqrt().inverse();
    case arctangent:
      return (1.0 + a * a).inverse();
    case hyperbolic_sine:
      return each<W>(a, [](double x) { return std::cosh(x); });
    case hyperbolic_cosine:
      return each<W>(a, [](double x) { return std::sinh(x); });
    case hyperbolic_tangent:
      return 1.0 - y * y;
    case area_sine:
      return (a * a + 1.0).sqrt().inverse();
    case area_cosine:
      return (a * a - 1.0).sqrt().inverse();
    case area_tangent:
      return (1.0 - a * a).inverse();
    default:
      return TapeLanes<W>::Zero();  // comparisons, sign and rint are flat
  }
}

}  // namespace

template <int W>
void run(const std::vector<TapeStep>& steps, TapeLanes<W>* values) {
  for (const auto& step : steps) values[step.out] = result<W>(step, values);
}

// A branch that is not taken may have no number: its adjoint is zero, and zero times its slope stays zero.
template <int W>
void run_back(const std::vector<TapeStep>& steps, const TapeLanes<W>* values, TapeLanes<W>* adjoints) {
  const auto times = [](const TapeLanes<W>& adjoint, const TapeLanes<W>& derivative) -> TapeLanes<W> {
    return (adjoint == 0.0).select(TapeLanes<W>::Zero(), adjoint * derivative);
  };
  for (auto step = steps.rbegin(); step != steps.rend(); ++step) {
    const TapeLanes<W>& of = adjoints[step->out];
    const TapeLanes<W>&y = values[step->out], &a = values[step->a];
    const auto b = [&]() -> const TapeLanes<W>& { return values[step->b]; };
    switch (step->operation) {
      case add:
        if (step->by_a) adjoints[step->a] += of;
        if (step->by_b) adjoints[step->b] += of;
        break;
      case subtract:
        if (step->by_a) adjoints[step->a] += of;
        if (step->by_b) adjoints[step->b] -= of;
        break;
      case negate:
        adjoints[step->a] -= of;
        break;
      case multiply:
        if (step->by_a) adjoints[step->a] += times(of, b());
        if (step->by_b) adjoints[step->b] += times(of, a);
        break;
      case divide:
        if (step->by_a) adjoints[step->a] += times(of, b().inverse());
        if (step->by_b) adjoints[step->b] -= times(of, y / b());
        break;
      case power:
        if (step->by_a)
          adjoints[step->a] += times(of, b() * (b() == 0.0).select(TapeLanes<W>::Zero(), raised<W>(a, b() - 1.0)));
        if (step->by_b)
          adjoints[step->b] +=
              times(of, (y == 0.0).select(TapeLanes<W>::Zero(), y * each<W>(a, [](double x) { return std::log(x); })));
        break;
      case minimum:
        if (step->by_a) adjoints[step->a] += (a <= b()).select(of, 0.0);
        if (step->by_b) adjoints[step->b] += (a <= b()).select(TapeLanes<W>::Zero(), of);
        break;
      case maximum:
        if (step->by_a) adjoints[step->a] += (a >= b()).select(of, 0.0);
        if (step->by_b) adjoints[step->b] += (a >= b()).select(TapeLanes<W>::Zero(), of);
        break;
      case select:
        if (step->by_b) adjoints[step->b] += (a != 0.0).select(of, 0.0);
        if (step->by_c) adjoints[step->c] += (a != 0.0).select(TapeLanes<W>::Zero(), of);
        break;
      case arctangent_2: {
        const TapeLanes<W> size = a * a + b() * b();
        if (step->by_a) adjoints[step->a] += times(of, b() / size);
        if (step->by_b) adjoints[step->b] -= times(of, a / size);
        break;
      }
      default:
        if (step->by_a) adjoints[step->a] += times(of, slope<W>(*step, a, y));
    }
  }
}

template void run<1>(const std::vector<TapeStep>&, TapeLanes<1>*);
template void run<4>(const std::vector<TapeStep>&, TapeLanes<4>*);
template void run<8>(const std::vector<TapeStep>&, TapeLanes<8>*);
template void run_back<1>(const std::vector<TapeStep>&, const TapeLanes<1>*, TapeLanes<1>*);
template void run_back<4>(const std::vector<TapeStep>&, const TapeLanes<4>*, TapeLanes<4>*);
template void run_back<8>(const std::vector<TapeStep>&, const TapeLanes<8>*, TapeLanes<8>*);

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
    const auto found = tape_.names_.find(word);
    if (found == tape_.names_.end()) fail();
    return found->second;
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

int ExpressionTape::add_variable(const std::string& name) {
  names_[name] = size_;
  return size_++;
}

int ExpressionTape::compile(const std::string& text) { return ExpressionParser(*this, text).parse(); }

int ExpressionTape::add_constant(double value) {
  for (const auto& [number, known] : constants_)
    if (known == value) return number;
  constants_.emplace_back(size_, value);
  return size_++;
}

const double* ExpressionTape::constant(int value) const {
  for (const auto& [number, known] : constants_)
    if (number == value) return &known;
  return nullptr;
}

int ExpressionTape::add_step(TapeOperation operation, int a, int b, int c) {
  if (operation == power && constant(b) != nullptr && *constant(b) == 2.0) return add_step(square, a);
  const auto key = std::make_tuple(operation, a, b, c);
  if (const auto found = known_steps_.find(key); found != known_steps_.end()) return found->second;
  const bool fixed = constant(a) != nullptr && (b < 0 || constant(b) != nullptr) && (c < 0 || constant(c) != nullptr);
  if (fixed) {
    TapeLanes<1> operands[3];
    for (int i = 0; const int each : {a, b, c}) operands[i++] = each < 0 ? 0.0 : *constant(each);
    const double folded = result<1>({operation, 0, 0, 1, 2}, operands)[0];
    if (std::isfinite(folded)) return known_steps_[key] = add_constant(folded);
  }
  steps_.push_back({operation, size_, a, b, c});
  known_steps_[key] = size_;
  return size_++;
}

std::vector<TapeStep> ExpressionTape::steps_to(const std::vector<int>& values, std::vector<char>& known) const {
  std::vector<char> needed(static_cast<std::size_t>(size_), 0);
  for (const int value : values) needed[static_cast<std::size_t>(value)] = 1;
  std::vector<TapeStep> found;
  for (auto step = steps_.rbegin(); step != steps_.rend(); ++step) {
    const auto out = static_cast<std::size_t>(step->out);
    if (needed[out] == 0 || known[out] != 0) continue;
    known[out] = 1;
    found.push_back(*step);
    for (const int operand : {step->a, step->b, step->c})
      if (operand >= 0) needed[static_cast<std::size_t>(operand)] = 1;
  }
  std::ranges::reverse(found);
  return found;
}

std::vector<TapeStep> ExpressionTape::steps_from(const std::vector<int>& variables, std::vector<char>& known) const {
  known.assign(static_cast<std::size_t>(size_), 0);
  for (const int variable : variables) known[static_cast<std::size_t>(variable)] = 1;
  for (const auto& [number, value] : constants_) known[static_cast<std::size_t>(number)] = 1;
  std::vector<TapeStep> found;
  const auto is_known = [&](int operand) { return operand < 0 || known[static_cast<std::size_t>(operand)] != 0; };
  for (const auto& step : steps_)
    if (is_known(step.a) && is_known(step.b) && is_known(step.c)) {
      known[static_cast<std::size_t>(step.out)] = 1;
      found.push_back(step);
    }
  return found;
}

std::vector<char> ExpressionTape::that_depend_on(const std::vector<int>& variables) const {
  std::vector<char> active(static_cast<std::size_t>(size_), 0);
  for (const int variable : variables) active[static_cast<std::size_t>(variable)] = 1;
  for (const auto& step : steps_)
    for (const int operand : {step.a, step.b, step.c})
      if (operand >= 0 && active[static_cast<std::size_t>(operand)] != 0)
        active[static_cast<std::size_t>(step.out)] = 1;
  return active;
}

std::vector<TapeStep> ExpressionTape::steps_back(int value, const std::vector<int>& variables) const {
  const auto active = that_depend_on(variables);
  const auto wanted = [&](int operand) { return operand >= 0 && active[static_cast<std::size_t>(operand)] != 0; };
  std::vector<char> none(static_cast<std::size_t>(size_), 0);
  std::vector<TapeStep> found;
  for (auto step : steps_to({value}, none)) {
    step.by_a = wanted(step.a), step.by_b = wanted(step.b), step.by_c = wanted(step.c);
    if (step.by_a || step.by_b || step.by_c) found.push_back(step);
  }
  return found;
}

bool ExpressionTape::depends(int value, int variable) const {
  return that_depend_on({variable})[static_cast<std::size_t>(value)] != 0;
}

}  // namespace kalfem
