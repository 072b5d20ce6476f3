// SPDX-License-Identifier: Apache-2.0
#include "kalfem/system/laws/law_library.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <sstream>

namespace kalfem {
namespace {

/// The degree that a coefficient's name such as "k3" states, or 0 where it is no such name.
int degree_of(const std::string& name) {
  if (name.size() < 2 || name.size() > 3 || (name[0] != 'k' && name[0] != 'c') || name[1] == '0') return 0;
  const bool digits = std::all_of(name.begin() + 1, name.end(), [](char c) { return c >= '0' && c <= '9'; });
  return digits ? std::stoi(name.substr(1)) : 0;
}

// The highest index of k and of c sets the degrees of the law; it then has every lower coefficient too.
ConnectorLawPtr polynomial_of(const LawArguments& arguments) {
  int stiffness_degree = 0, damping_degree = 0;
  IssueList issues;
  for (const auto& parameter : arguments.parameters) {
    const std::string& name = parameter.name;
    const int degree = degree_of(name);
    if (degree == 0)
      issues.add({}, "polynomial: the parameter '" + name + "'", "coefficients are named k1, k2, ... and c1, c2, ...",
                 "write k3 for the coefficient of d^3");
    int& highest = name.starts_with("k") ? stiffness_degree : damping_degree;
    highest = std::max(highest, degree);
  }
  issues.raise();
  return polynomial_law(stiffness_degree, damping_degree);
}

/// The branch that a parameter's name such as "k2" or "tau2" states, 0 where it is no such name.
int branch_of(const std::string& name) {
  if (name.starts_with("c")) return 0;
  return degree_of(name.starts_with("tau") ? "k" + name.substr(3) : name);
}

// The highest index sets the number of branches; the law then asks for every parameter up to it.
ConnectorLawPtr prony_of(const LawArguments& arguments) {
  int branches = 0;
  for (const auto& parameter : arguments.parameters) branches = std::max(branches, branch_of(parameter.name));
  return prony_law(branches);
}

ConnectorLawPtr expression_of(const LawArguments& arguments) {
  ExpressionLawOptions options{.force = arguments.force,
                               .parameters = {},
                               .states = arguments.states,
                               .signals = arguments.signals,
                               .lets = arguments.lets};
  for (const auto& parameter : arguments.parameters)
    options.parameters.push_back({parameter.name, parameter.unit, "defined by the expression"});
  return expression_law(options);
}

// A law is found by its name in a table of name, equation, meaning and maker. The same table gives `kalfem laws` and
// the schema their text: a law that is added here needs no other place.
struct Entry {
  std::string name, equation, meaning;
  std::function<ConnectorLawPtr(const LawArguments&)> make;
  LawArguments example = {};
};

const std::vector<Entry>& entries() {
  static const std::vector<Entry> all{
      {"linear", "f = k d + c v", "spring and dashpot", [](const auto&) { return linear_law(); }},
      {"saturating", "f = k d + mu_k1 d/(mu_k2 + |d|) + c v + mu_c1 v/(mu_c2 + |v|)",
       "suspension with saturating spring and damper", [](const auto&) { return saturating_law(); }},
      {"cubic", "f = k d + k3 d^3 + c v + c3 v^3", "hardening or softening spring and damper",
       [](const auto&) { return cubic_law(); }},
      {"polynomial",
       "f = sum_i k_i d^i + sum_i c_i v^i",
       "polynomial spring and damper of any degree, including even terms",
       polynomial_of,
       {.parameters = {{"k1"}, {"k2"}, {"k3"}, {"c1"}}}},
      {"gap", "f = k d + c v + stops: k_stop overlap + c_stop v while in contact and pushing",
       "bump stop on one or both sides", [](const auto&) { return gap_law(); }},
      {"hunt_crossley", "f = k d + c v + stops: k_stop overlap max(0, 1 + 1.5 a_stop v) while in contact",
       "bump stop on one or both sides whose damping grows with the overlap",
       [](const auto&) { return hunt_crossley_law(); }},
      {"damper", "f = k d + c_rebound v/(1 + v/v_rebound) for v > 0, k d + c_compression v/(1 - v/v_compression) else",
       "shock absorber: asymmetric and digressive", [](const auto&) { return damper_law(); }},
      {"coulomb", "f = k d + c v + f_c tanh(v/v_ref)", "dry (Coulomb) friction, regularised",
       [](const auto&) { return coulomb_law(); }},
      {"stribeck", "f = k d + c v + (f_c + (f_s - f_c) exp(-(v/v_s)^2)) tanh(v/v_ref)",
       "dry friction that decreases from static to sliding (Stribeck)", [](const auto&) { return stribeck_law(); }},
      {"jenkins", "f = k d + c v + k_stick (d - slip), the last term bounded by f_slip",
       "dry friction with true sticking: a spring in series with a slider (Jenkins element)",
       [](const auto&) { return jenkins_law(); }},
      {"bilinear", "f = alpha k d + (1 - alpha) k (d - slip) + c v, the middle term bounded by (1 - alpha) f_y",
       "elastoplastic spring with kinematic hardening", [](const auto&) { return bilinear_law(); }},
      {"bouc_wen", "f = alpha k d + (1 - alpha) k z + c v, z' = A v - beta |v| |z|^(n-1) z - gamma v |z|^n",
       "smooth hysteresis", [](const auto&) { return bouc_wen_law(); }},
      {"bouc_wen_degrading", "f as bouc_wen, z' = h (A v - nu (beta |v| |z|^(n-1) z + gamma v |z|^n))/eta, e' = z v",
       "smooth hysteresis whose strength and stiffness degrade and whose loops are pinched (Baber, Noori, Foliente)",
       [](const auto&) { return degrading_bouc_wen_law(); }},
      {"ramberg_osgood", "d = f/k (1 + alpha |f/f_y|^(r-1)), after a reversal scaled by two from there (Masing)",
       "steel, soil and wire rope that yield gradually, with closed loops (Ramberg, Osgood, Masing)",
       [](const auto&) { return ramberg_osgood_law(); }},
      {"iwan", "f = k d + c v + sliders in parallel with the density R phi^chi and one more at phi_max",
       "bolted joint: microslip with power-law dissipation, then macroslip (Iwan, four parameters)",
       [](const auto&) { return iwan_law(); }},
      {"lugre", "f = k d + sigma_0 z + sigma_1 z' + sigma_2 v, z' = v - sigma_0 |v| z/g(v)",
       "dry friction by the deflection of bristles (LuGre)", [](const auto&) { return lugre_law(); }},
      {"maxwell", "f = k d + c v + k_branch (d - z), z' = (d - z)/tau", "spring and dashpot in series beside both",
       [](const auto&) { return maxwell_law(); }},
      {"prony",
       "f = k_inf d + c v + sum_i k_i (d - z_i), z_i' = (d - z_i)/tau_i",
       "rubber mount: Prony series of 1 to 8 Maxwell branches",
       prony_of,
       {.parameters = {{"k_inf"}, {"c"}, {"k1"}, {"tau1"}, {"k2"}, {"tau2"}}}},
      {"inerter", "f = b a", "inerter: force proportional to relative acceleration",
       [](const auto&) { return inerter_law(); }},
      {"preload", "f = f0", "constant force", [](const auto&) { return preload_law(); }},
      {"linear_change", "f = (k - k_nominal) d + (c - c_nominal) v + (b - b_nominal) a",
       "deviation of a linear spring, dashpot or mass from its nominal value",
       [](const LawArguments& arguments) { return linear_change_law(arguments.nominal); }},
      {"expression",
       "f = an expression of x, v, a, the parameters, the states and the signals",
       "a law written as an expression",
       expression_of,
       {.parameters = {{"k"}, {"c"}}, .force = "k*x + c*v"}},
  };
  return all;
}

/// What a range asks for, and whether a value has it.
struct Requirement {
  std::string words;
  bool met;
};

// Comparisons are written so that NaN fails each of them.
Requirement require(Range range, double value) {
  switch (range) {
    case Range::nonnegative:
      return {"it must not be negative", value >= 0.0};
    case Range::positive:
      return {"it must be positive", value > 0.0};
    case Range::fraction:
      return {"it must lie between 0 and 1", value >= 0.0 && value <= 1.0};
    case Range::at_least_one:
      return {"it must be at least 1", value >= 1.0};
    case Range::any:
      break;
  }
  return {"any number is allowed", true};
}

std::string to_string(const LawQuantity& parameter, double value) {
  std::ostringstream text;
  text << "parameter '" << parameter.name << "' is " << value;
  if (!parameter.unit.empty() && parameter.unit != "-") text << " " << parameter.unit;
  return text.str();
}

}  // namespace

ConnectorLawPtr make_law(const std::string& name, const LawArguments& arguments) {
  std::vector<std::string> known;
  std::string list;
  for (const auto& entry : entries()) {
    if (entry.name == name) return entry.make(arguments);
    known.push_back(entry.name);
    list += (list.empty() ? "" : ", ") + entry.name;
  }
  throw InvalidInput("unknown connector law '" + name + "'" + did_you_mean(name, known), "", "the laws are " + list);
}

// Quantities of a law are those of an example, as polynomials and expressions have parameters by their arguments
// only.
std::vector<LawDescription> law_library() {
  std::vector<LawDescription> library;
  for (const auto& entry : entries()) {
    const auto law = entry.make(entry.example);
    library.push_back({entry.name, entry.equation, entry.meaning, law->parameters(), law->states()});
  }
  return library;
}

// Tests each value against the range that its law declares. An infinite value is allowed only where it is the
// default, as that of a quantity that is absent. Each value has at most one issue.
std::vector<Issue> validate_parameters(const ConnectorLaw& law, const Eigen::Ref<const Eigen::VectorXd>& values) {
  const auto& parameters = law.parameters();
  IssueList issues;
  if (values.size() != static_cast<Eigen::Index>(parameters.size())) {
    issues.add({}, "law '" + law.name() + "' was given " + std::to_string(values.size()) + " parameter values",
               "it has " + std::to_string(parameters.size()) + " parameters", "give one value for each");
    return issues.issues();
  }
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    const auto& parameter = parameters[static_cast<std::size_t>(i)];
    const bool may_be_infinite = std::isinf(parameter.default_value) && values[i] == parameter.default_value;
    const auto requirement = require(parameter.range, values[i]);
    if (!std::isfinite(values[i]) && !may_be_infinite)
      issues.add({}, to_string(parameter, values[i]), "it must be a finite number", "give the " + parameter.meaning);
    else if (!requirement.met)
      issues.add({}, to_string(parameter, values[i]), requirement.words, "give the " + parameter.meaning);
  }
  return issues.issues();
}

}  // namespace kalfem
