#include "kalfem/system/laws/expression_evaluator.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <set>

namespace kalfem {
namespace {

constexpr double weight = 0.29289321881345248;  ///< 1 - 1/sqrt(2), the L-stable choice

ConnectorMotion between(const ConnectorMotion& begin, const ConnectorMotion& end, double fraction) {
  return {begin.d + fraction * (end.d - begin.d), begin.v + fraction * (end.v - begin.v)};
}

StateMatrix rates_by_states(const StateRates& rates, const ConnectorMotion& at, StateVector s) {
  StateMatrix jacobian(s.size(), s.size());
  for (Eigen::Index j = 0; j < s.size(); ++j) {
    const double centre = s[j], step = difference_step(centre);
    s[j] = centre + step;
    jacobian.col(j) = rates(at, s);
    s[j] = centre - step;
    jacobian.col(j) = (jacobian.col(j) - rates(at, s)) / (2.0 * step);
    s[j] = centre;
  }
  return jacobian;
}

StateVector rates_by_deformation(const StateRates& rates, const ConnectorMotion& at, const StateVector& s) {
  const double step = difference_step(at.d);
  return (rates({at.d + step, at.v}, s) - rates({at.d - step, at.v}, s)) / (2.0 * step);
}

StateVector rates_by_rate(const StateRates& rates, const ConnectorMotion& at, const StateVector& s) {
  const double step = difference_step(at.v);
  return (rates({at.d, at.v + step}, s) - rates({at.d, at.v - step}, s)) / (2.0 * step);
}

/// One implicit stage s = base + w h g(motion, s).
struct Step {
  const StateRates& rates;
  ConnectorMotion motion;
  double step;  ///< w h [s]
  StateVector base;

  [[nodiscard]] StateVector residual(const StateVector& s) const { return s - base - step * rates(motion, s); }
  [[nodiscard]] Eigen::PartialPivLU<StateMatrix> factored_jacobian(const StateVector& s) const {
    const StateMatrix identity = StateMatrix::Identity(s.size(), s.size());
    return Eigen::PartialPivLU<StateMatrix>(identity - step * rates_by_states(rates, motion, s));
  }
};

// Newton's method with a Jacobian by central differences. A step is halved while it makes the residual larger, as laws
// with powers and kinks can send the first steps far away. The end is judged by the correction, which stays meaningful
// where the residual is only rounding.
/// Damped Newton iteration on the stage, from s and into s.
bool solve(const Step& section, StateVector& s) {
  constexpr int max_iterations = 50, max_halvings = 20;
  StateVector residual = section.residual(s);
  for (int iteration = 0; iteration < max_iterations; ++iteration) {
    StateVector correction = section.factored_jacobian(s).solve(residual);
    if (!correction.allFinite()) return false;
    const double old_norm = residual.norm();
    // Beyond rounding a smaller residual cannot be asked for: the correction itself tells that this is the end.
    const bool last = (correction.array().abs() <= 1e-12 * s.array().abs() + 1e-300).all();
    for (int halving = 0; halving <= max_halvings; ++halving, correction *= 0.5) {
      const StateVector trial = s - correction;
      residual = section.residual(trial);
      if (last || halving == max_halvings || residual.norm() < old_norm) {
        s = trial;
        break;
      }
    }
    if (last) return residual.allFinite();
  }
  return residual.norm() <= 1e-9 * s.norm();
}

}  // namespace

// About the cube root of the rounding unit times x, where the errors of truncation and of rounding of a central
// difference are of one size; the floor serves x near zero.
double difference_step(double x) { return std::max(6e-6 * std::abs(x), 1e-9); }

// Two-stage, second-order, L-stable diagonally implicit Runge-Kutta method [Ale77] for s' = g(d, v, s), with the motion
// linear over the interval:
//     s_1 = s_0 + w h g(at w h, s_1),    s_2 = s_0 + (1 - w) h g(at w h, s_1) + w h g(at h, s_2),    w = 1 - 1/sqrt(2).
// The first stage's rate is taken from its increment, (s_1 - s_0) / w, so that no rate is evaluated twice. The
// derivatives by the motion at the end follow from both stages by the implicit function theorem:
//     (1 - w h dg/ds) ds_2 = reach ds_1 + w h (dg/dd, dg/dv).
AdvancedStates advance_states(const StateRates& rates, double duration, const ConnectorMotion& begin,
                              const ConnectorMotion& end, const StateVector& s) {
  const double reach = (1.0 - weight) / weight;  // the first stage's share of the second, by its own increment
  AdvancedStates out;

  Step section{rates, between(begin, end, weight), weight * duration, s};
  StateVector middle = s;
  out.converged = solve(section, middle);
  const auto middle_jacobian = section.factored_jacobian(middle);
  // The stage's motion moves by `weight` for each unit of the motion at the end.
  const StateVector middle_by_d =
      middle_jacobian.solve(weight * section.step * rates_by_deformation(rates, section.motion, middle));
  const StateVector middle_by_v =
      middle_jacobian.solve(weight * section.step * rates_by_rate(rates, section.motion, middle));

  section.motion = end;
  section.base = s + reach * (middle - s);
  out.s = middle;
  out.converged = solve(section, out.s) && out.converged;
  const auto jacobian = section.factored_jacobian(out.s);
  out.by_d = jacobian.solve(reach * middle_by_d + section.step * rates_by_deformation(rates, end, out.s));
  out.by_v = jacobian.solve(reach * middle_by_v + section.step * rates_by_rate(rates, end, out.s));
  return out;
}

namespace {

/// Names that an expression may use beside functions and constants.
std::vector<std::string> own_names(const ExpressionLawOptions& options) {
  std::vector<std::string> names;
  for (const auto& parameter : options.parameters) names.push_back(parameter.name);
  for (const auto& state : options.states) names.push_back(state.quantity.name);
  return names;
}

bool is_identifier(const std::string& name) {
  const auto letter = [](char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0 || c == '_'; };
  return !name.empty() && letter(name[0]) && std::all_of(name.begin(), name.end(), [&](char c) {
    return letter(c) || std::isdigit(static_cast<unsigned char>(c)) != 0;
  });
}

void check_names(const std::vector<std::string>& names, IssueList& issues) {
  const mu::Parser parser;
  std::set<std::string> seen;
  for (const auto& name : names) {
    const std::string what = "expression: the name '" + name + "'";
    if (!is_identifier(name))
      issues.add({}, what, "a name consists of letters, digits and _ and must not begin with a digit",
                 "choose another name");
    else if (name == "x" || name == "v" || name == "a")
      issues.add({}, what, "x, v and a are reserved for the deformation, its rate and its acceleration",
                 "choose another name");
    else if (parser.GetFunDef().count(name) > 0)
      issues.add({}, what, "it is the name of a function", "choose another name, such as " + name + "_1");
    else if (parser.GetConst().count(name) > 0)
      issues.add({}, what, "it is the name of a constant", "choose another name");
    else if (!seen.insert(name).second)
      issues.add({}, what, "it is used twice among parameters and states", "give each its own name");
  }
}

/// muParser would let "k = 3" change a variable. Position of such a lone '=', or npos.
std::size_t find_assignment(const std::string& text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '=') continue;
    if (i + 1 < text.size() && text[i + 1] == '=')
      ++i;
    else if (i == 0 || (text[i - 1] != '<' && text[i - 1] != '>' && text[i - 1] != '!'))
      return i;
  }
  return std::string::npos;
}

std::string fix_of(const mu::ParserError& error, const std::vector<std::string>& names) {
  if (error.GetCode() == mu::ecEMPTY_EXPRESSION) return "write an expression such as k*x + c*v";
  if (error.GetCode() != mu::ecUNASSIGNABLE_TOKEN) return "correct the expression there";
  std::vector<std::string> known = names;
  const mu::Parser parser;
  for (const auto& [name, function] : parser.GetFunDef()) known.push_back(name);
  return "declare it as a parameter or state, or use a known name" + did_you_mean(error.GetToken(), known);
}

// An expression is compiled and evaluated once with all names at 1: muParser reports syntax and unknown names only when
// it is asked for a value. What it would accept but nobody means is refused by hand: assignments and lists.
/// Compiles one expression on trial and collects the names that it uses.
void check_expression(const std::string& role, const std::string& text, const std::vector<std::string>& names,
                      std::set<std::string>& used, IssueList& issues) {
  const std::string what = "expression for " + role + " \"" + text + "\"";
  if (const auto at = find_assignment(text); at != std::string::npos) {
    issues.add({}, what, "'=' at position " + std::to_string(at) + " would assign to a variable",
               "give only the right-hand side; use == to compare");
    return;
  }
  try {
    mu::Parser parser;
    double value = 1.0;  // all names: only the syntax matters here
    for (const auto& name : names)
      if (is_identifier(name)) parser.DefineVar(name, &value);
    parser.SetExpr(text);
    (void)parser.Eval();
    for (const auto& [name, pointer] : parser.GetUsedVar()) used.insert(name);
    if (parser.GetNumResults() != 1)
      issues.add({}, what, "a comma would separate several results",
                 "write one expression and use a point for decimals");
  } catch (const mu::ParserError& error) {
    const std::string position = error.GetPos() >= 0 ? " (position " + std::to_string(error.GetPos()) + ")" : "";
    issues.add({}, what, error.GetMsg() + position, fix_of(error, names));
  }
}

}  // namespace

// In this order, as each check needs the one before: names, number of states, each expression by itself, and last names
// that nothing uses, which are mostly a slip of the pen in an expression.
std::vector<Issue> find_issues(const ExpressionLawOptions& options) {
  IssueList issues;
  std::vector<std::string> names = own_names(options);
  check_names(names, issues);
  if (options.states.size() > static_cast<std::size_t>(max_internal_states))
    issues.add({}, "expression: " + std::to_string(options.states.size()) + " internal states",
               "at most " + std::to_string(max_internal_states), "use fewer states");
  if (!issues.empty()) return issues.issues();

  const std::vector<std::string> declared = names;
  names.insert(names.end(), {"x", "v"});
  std::set<std::string> used;
  for (const auto& state : options.states)
    check_expression("the rate of '" + state.quantity.name + "'", state.rate, names, used, issues);
  names.emplace_back("a");  // the acceleration is known at the end of an interval only, so the rates cannot have it
  check_expression("the force", options.force, names, used, issues);
  if (!issues.empty()) return issues.issues();

  for (const auto& name : declared)
    if (used.count(name) == 0)
      issues.add({}, "expression: '" + name + "' appears in no expression", "it would have no effect",
                 "use it or remove it");
  return issues.issues();
}

bool force_mentions_acceleration(const ExpressionLawOptions& options) {
  mu::Parser parser;
  double value = 1.0;
  std::vector<std::string> names = own_names(options);
  names.insert(names.end(), {"x", "v", "a"});
  for (const auto& name : names) parser.DefineVar(name, &value);
  parser.SetExpr(options.force);
  return parser.GetUsedVar().count("a") > 0;
}

ExpressionEvaluator::ExpressionEvaluator(const ExpressionLawOptions& options)
    : states_(StateVector::Zero(static_cast<Eigen::Index>(options.states.size()))),
      parameters_(options.parameters.size(), 0.0) {
  const auto define = [&](mu::Parser& parser, const std::string& text) {
    parser.DefineVar("x", &x_);
    parser.DefineVar("v", &v_);
    parser.DefineVar("a", &a_);
    for (std::size_t i = 0; i < options.parameters.size(); ++i)
      parser.DefineVar(options.parameters[i].name, &parameters_[i]);
    for (std::size_t i = 0; i < options.states.size(); ++i)
      parser.DefineVar(options.states[i].quantity.name, states_.data() + i);
    parser.SetExpr(text);
    (void)parser.Eval();  // compiles now, so that later evaluations neither allocate nor fail
  };
  define(force_, options.force);
  for (const auto& state : options.states) define(rates_.emplace_back(), state.rate);
}

void ExpressionEvaluator::set(const ConnectorMotion& motion, const StateVector& s) const {
  x_ = motion.d;
  v_ = motion.v;
  states_ = s;  // keeps its place: the size does not change
}

double ExpressionEvaluator::force(const ConnectorMotion& motion, double acceleration, const StateVector& s) const {
  set(motion, s);
  a_ = acceleration;
  return force_.Eval();
}

StateVector ExpressionEvaluator::operator()(const ConnectorMotion& motion, const StateVector& s) const {
  set(motion, s);
  StateVector rates(s.size());
  for (Eigen::Index i = 0; i < s.size(); ++i) rates[i] = rates_[static_cast<std::size_t>(i)].Eval();
  return rates;
}

std::unique_ptr<ExpressionEvaluator> EvaluatorPool::borrow() {
  const std::lock_guard lock(mutex_);
  if (idle_.empty()) return make();  // compiling under the lock: muParser's set-up shares a locale
  auto evaluator = std::move(idle_.back());
  idle_.pop_back();
  return evaluator;
}

void EvaluatorPool::give_back(std::unique_ptr<ExpressionEvaluator> evaluator) {
  const std::lock_guard lock(mutex_);
  idle_.push_back(std::move(evaluator));
}

}  // namespace kalfem
