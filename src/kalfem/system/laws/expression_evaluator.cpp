#include "kalfem/system/laws/expression_evaluator.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <set>

namespace kalfem {
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
      issues.add({}, what, "a name has letters, digits and _ and does not begin with a digit", "choose another name");
    else if (name == "x" || name == "v" || name == "a")
      issues.add({}, what, "x, v and a are the deformation, its rate and its acceleration", "choose another name");
    else if (parser.GetFunDef().count(name) > 0)
      issues.add({}, what, "it is the name of a function", "choose another name, such as " + name + "_1");
    else if (parser.GetConst().count(name) > 0)
      issues.add({}, what, "it is the name of a constant", "choose another name");
    else if (!seen.insert(name).second)
      issues.add({}, what, "it is given twice among parameters and states", "give each its own name");
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
  if (error.GetCode() != mu::ecUNASSIGNABLE_TOKEN) return "mend the expression there";
  std::vector<std::string> known = names;
  const mu::Parser parser;
  for (const auto& [name, function] : parser.GetFunDef()) known.push_back(name);
  return "declare it as a parameter or state, or use a known name" + did_you_mean(error.GetToken(), known);
}

/// Compiles one expression on trial and collects the names that it uses.
void check_expression(const std::string& role, const std::string& text, const std::vector<std::string>& names,
                      std::set<std::string>& used, IssueList& issues) {
  const std::string what = "expression for " + role + " \"" + text + "\"";
  if (const auto at = find_assignment(text); at != std::string::npos) {
    issues.add({}, what, "'=' at position " + std::to_string(at) + " would change a variable",
               "give only the right-hand side; compare with ==");
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
      issues.add({}, what, "a comma separates several results", "write one expression; the decimal sign is a point");
  } catch (const mu::ParserError& error) {
    const std::string position = error.GetPos() >= 0 ? " (position " + std::to_string(error.GetPos()) + ")" : "";
    issues.add({}, what, error.GetMsg() + position, fix_of(error, names));
  }
}

}  // namespace

std::vector<Issue> find_issues(const ExpressionLawOptions& options) {
  IssueList issues;
  std::vector<std::string> names = own_names(options);
  check_names(names, issues);
  if (options.states.size() > static_cast<std::size_t>(max_internal_states))
    issues.add({}, "expression: " + std::to_string(options.states.size()) + " internal states",
               "there may be at most " + std::to_string(max_internal_states), "use fewer states");
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
                 "use it or leave it out");
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
