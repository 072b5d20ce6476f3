// SPDX-License-Identifier: Apache-2.0
#include "kalfem/api/laws.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "kalfem/system/laws/law_library.hpp"

namespace kalfem {
namespace {

// About the cube root of the rounding unit times x, where the errors of truncation and of rounding of a central
// difference are of one size; the floor serves x near zero.
/// Half the span of a central difference about x.
double difference_step(double x) { return std::max(6e-6 * std::abs(x), 1e-9); }

using Eigen::Index;

std::vector<LawQuantity> named(const NamedValues& values) {
  std::vector<LawQuantity> quantities;
  for (const auto& [name, value] : values) quantities.push_back({.name = name});
  return quantities;
}

bool may_be_zero(Range range) { return range != Range::positive && range != Range::at_least_one; }

/// Default of a parameter; empty if the caller must give it. A program may leave more out than a case file, which
/// states every number that a run depends on.
std::optional<double> default_of(const ConnectorLaw& law, const LawQuantity& parameter) {
  if (!std::isnan(parameter.default_value)) return parameter.default_value;
  if (law.name() == "saturating" && parameter.name == "mu_k2") return saturating_deformation;
  if (law.name() == "saturating" && parameter.name == "mu_c2") return saturating_rate;
  return may_be_zero(parameter.range) ? std::optional(0.0) : std::nullopt;
}

/// Values in the law's order, with an issue for each that is missing, unknown or given twice.
Eigen::VectorXd ordered(const ConnectorLaw& law, const NamedValues& given, IssueList& issues) {
  const auto& parameters = law.parameters();
  Eigen::VectorXd values(static_cast<Index>(parameters.size()));
  std::vector<std::string> known;
  for (const auto& parameter : parameters) {
    const auto found = std::ranges::find(given, parameter.name, &NamedValues::value_type::first);
    const auto value = found != given.end() ? std::optional(found->second) : default_of(law, parameter);
    if (!value)
      issues.add({}, "law '" + law.name() + "': the parameter '" + parameter.name + "' is missing",
                 "it must be positive: " + parameter.meaning, "give it in " + parameter.unit);
    values[static_cast<Index>(known.size())] = value.value_or(1.0);
    known.push_back(parameter.name);
  }
  for (auto it = given.begin(); it != given.end(); ++it) {
    if (std::ranges::find(known, it->first) == known.end())
      issues.add(
          {}, "law '" + law.name() + "': there is no parameter '" + it->first + "'" + did_you_mean(it->first, known));
    if (std::find_if(given.begin(), it, [&](const auto& other) { return other.first == it->first; }) != it)
      issues.add({}, "law '" + law.name() + "': the parameter '" + it->first + "' is given twice");
  }
  return values;
}

Law with_values(ConnectorLawPtr law, const NamedValues& given) {
  IssueList issues;
  Eigen::VectorXd values = ordered(*law, given, issues);
  for (const auto& issue : validate_parameters(*law, values))
    issues.add({}, "law '" + law->name() + "': " + issue.what, issue.why, issue.fix);
  issues.raise();
  return {std::move(law), std::move(values)};
}

/// f(d, v; p) point by point, its tangents by central differences.
class FunctionLaw final : public ConnectorLaw {
public:
  FunctionLaw(std::string name, std::vector<LawQuantity> parameters, ForceFunction force)
      : name_(std::move(name)), parameters_(std::move(parameters)), force_(std::move(force)) {}

  [[nodiscard]] std::string name() const override { return name_; }
  [[nodiscard]] const std::vector<LawQuantity>& parameters() const override { return parameters_; }
  [[nodiscard]] const std::vector<LawQuantity>& states() const override { return states_; }
  [[nodiscard]] bool uses_acceleration() const override { return false; }

  void respond(const LawPoints& points, LawResponse response) const override {
    std::array<double, most_parameters> p{};
    const std::span<const double> parameters(p.data(), parameters_.size());
    for (Index i = 0; i < points.deformation.size(); ++i) {
      for (Index j = 0; j < points.parameters.cols(); ++j) p[static_cast<std::size_t>(j)] = points.parameters(i, j);
      const double d = points.deformation[i], v = points.rate[i];
      const double step_d = difference_step(d), step_v = difference_step(v);
      response.force[i] = force_(d, v, parameters);
      response.stiffness[i] = (force_(d + step_d, v, parameters) - force_(d - step_d, v, parameters)) / (2.0 * step_d);
      response.damping[i] = (force_(d, v + step_v, parameters) - force_(d, v - step_v, parameters)) / (2.0 * step_v);
      response.inertance[i] = 0.0;
    }
  }

  static constexpr std::size_t most_parameters = 32;

private:
  std::string name_;
  std::vector<LawQuantity> parameters_, states_;
  ForceFunction force_;
};

}  // namespace

Law law(const std::string& name, const NamedValues& values) {
  return with_values(make_law(name, {.parameters = named(values)}), values);
}

Law expression(const std::string& force, const NamedValues& values) {
  return with_values(make_law("expression", {.parameters = named(values), .force = force}), values);
}

Law law(const std::string& name, const NamedValues& values, ForceFunction force) {
  if (!force)
    throw InvalidInput("law '" + name + "': the force function is empty", "a law needs its force", "give one");
  if (values.size() > FunctionLaw::most_parameters)
    throw InvalidInput("law '" + name + "' has " + std::to_string(values.size()) + " parameters",
                       "a force function takes at most " + std::to_string(FunctionLaw::most_parameters),
                       "derive a class from ConnectorLaw");
  std::vector<LawQuantity> parameters;
  for (const auto& [parameter, value] : values) parameters.push_back({parameter});
  return with_values(std::make_shared<const FunctionLaw>(name, std::move(parameters), std::move(force)), values);
}

Law law(ConnectorLawPtr own, const NamedValues& values) {
  if (!own) throw InvalidInput("law: the pointer is empty", "a connector needs its law", "give one");
  return with_values(std::move(own), values);
}

}  // namespace kalfem
