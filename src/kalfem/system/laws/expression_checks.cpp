// SPDX-License-Identifier: Apache-2.0
#include "kalfem/system/laws/expression_checks.hpp"

#include <algorithm>
#include <cctype>
#include <set>

#include <muParser.h>

#include "kalfem/system/laws/expression_tape.hpp"

namespace kalfem {
namespace {

/// Names that an expression may use beside functions and constants.
std::vector<std::string> own_names(const ExpressionLawOptions& options) {
  std::vector<std::string> names;
  for (const auto& parameter : options.parameters) names.push_back(parameter.name);
  for (const auto& state : options.states) names.push_back(state.quantity.name);
  for (const auto& signal : options.signals) names.push_back(signal.name);
  for (const auto& let : options.lets) names.push_back(let.name);
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
                 name == "v" ? "choose another name, such as volt for a voltage" : "choose another name");
    else if (parser.GetFunDef().count(name) > 0)
      issues.add({}, what, "it is the name of a function", "choose another name, such as " + name + "_1");
    else if (parser.GetConst().count(name) > 0)
      issues.add({}, what, "it is the name of a constant", "choose another name");
    else if (!seen.insert(name).second)
      issues.add({}, what, "it is used twice among parameters, states, signals and sub-expressions",
                 "give each its own name");
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
  return "declare it as a parameter, state or signal, or use a known name" + did_you_mean(error.GetToken(), known);
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

namespace {

/// A rate must not depend on the acceleration, by whatever way: it is known at the end of an interval only.
void check_rates_without_acceleration(const ExpressionLawOptions& options, IssueList& issues) {
  const CompiledExpressions compiled(options);
  for (std::size_t i = 0; i < options.states.size(); ++i)
    if (compiled.tape.depends(compiled.rates[i], compiled.a))
      issues.add({}, "expression for the rate of '" + options.states[i].quantity.name + "' depends on a",
                 "the acceleration is known at the end of an interval only, so that no state can follow it",
                 "leave a out of the rate, and out of f and the sub-expressions that it uses");
}

void check_unused(const std::vector<std::string>& declared, const std::set<std::string>& used, IssueList& issues) {
  for (const auto& name : declared)
    if (used.count(name) == 0)
      issues.add({}, "expression: '" + name + "' appears in no expression", "it would have no effect",
                 "use it or remove it");
}

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::ranges::find(names, name) != names.end();
}

}  // namespace

// In this order, as each check needs the one before: names, number of states, each expression by itself, and last names
// that nothing uses, which are mostly a slip of the pen in an expression.
std::vector<Issue> find_issues(const ExpressionLawOptions& options) {
  IssueList issues;
  const std::vector<std::string> declared = own_names(options);
  check_names(declared, issues);
  if (options.states.size() > static_cast<std::size_t>(max_internal_states))
    issues.add({}, "expression: " + std::to_string(options.states.size()) + " internal states",
               "at most " + std::to_string(max_internal_states), "use fewer states");
  if (!issues.empty()) return issues.issues();

  std::vector<std::string> names(declared.begin(), declared.end() - std::ssize(options.lets));
  names.insert(names.end(), {"x", "v", "a"});
  std::set<std::string> used;
  for (const auto& let : options.lets) {
    check_expression("'" + let.name + "'", let.value, names, used, issues);
    names.push_back(let.name);
  }
  check_expression("the force", options.force, names, used, issues);
  std::erase(names, "a");
  if (!contains(names, "f")) names.emplace_back("f");
  for (const auto& state : options.states)
    check_expression("the rate of '" + state.quantity.name + "'", state.rate, names, used, issues);
  if (issues.empty()) check_rates_without_acceleration(options, issues);
  if (issues.empty()) check_unused(declared, used, issues);
  return issues.issues();
}

CompiledExpressions::CompiledExpressions(const ExpressionLawOptions& options) {
  x = tape.add_variable("x");
  v = tape.add_variable("v");
  a = tape.add_variable("a");
  for (const auto& each : options.parameters) parameters.push_back(tape.add_variable(each.name));
  for (const auto& each : options.states) states.push_back(tape.add_variable(each.quantity.name));
  for (const auto& each : options.signals) signals.push_back(tape.add_variable(each.name));
  for (const auto& let : options.lets) tape.add_name(let.name, tape.compile(let.value));
  force = tape.compile(options.force);
  if (!contains(own_names(options), "f")) tape.add_name("f", force);
  for (const auto& state : options.states) rates.push_back(tape.compile(state.rate));
}

}  // namespace kalfem
