// SPDX-License-Identifier: Apache-2.0
#include "kalfem/study/identified_case.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "kalfem/casefile/case_schema.hpp"
#include "kalfem/study/assembly.hpp"
#include "kalfem/study/sensor_unknowns.hpp"

namespace kalfem {
namespace {

namespace d = description;

template <class T>
T* find(Named<T>& entries, const std::string& name) {
  const auto found = std::ranges::find(entries, name, &std::pair<std::string, T>::first);
  return found == entries.end() ? nullptr : &found->second;
}

std::optional<Dimension> dimension_of(const std::string& unit) try {
  const Dimension dimension = parse_unit(unit).dimension;
  return dimension == Dimension{} ? std::nullopt : std::optional(dimension);  // "1.5 -" would read as per cent
} catch (const InvalidInput&) {
  return std::nullopt;  // "1/m^n" of a law, or none at all
}

/// The law of an expression takes its parameters in whatever unit the user gave them.
d::Value replaced(const d::Value& present, double number, const std::string& unit) {
  if (present.value.bare || present.value.dimension == Dimension{}) return value_in(number, unit);
  return {{number, present.value.dimension, false}};
}

/// "steel.youngs_modulus" of the part "frame" is ("steel", "youngs_modulus").
std::pair<std::string, std::string> split_at_last_dot(const std::string& name) {
  const auto dot = name.rfind('.');
  return {name.substr(0, dot), name.substr(dot + 1)};
}

/// Writes values of parameters into a description of the case. Each `set` returns whether the case has a place for it.
class ParameterPlaces {
public:
  ParameterPlaces(d::Case& given, const StructureModel& structure) : given_(given), structure_(structure) {}

  bool set(const Parameter& parameter, double value) {
    if (parameter.of_connector()) return set_connector(parameter, value);
    d::Substructure& part = *find(given_.substructures, parameter.owner);
    if (const auto* lumped = std::get_if<LumpedParameter>(&parameter.where)) return set_lumped(part, *lumped, value);
    return set_elements(part, parameter.owner, std::get<FiniteElementParameter>(parameter.where), value);
  }

private:
  bool set_connector(const Parameter& parameter, double value) {
    d::Connector* in_structure = find(given_.connectors, parameter.owner);
    d::Connector& connector = in_structure ? *in_structure : given_.component->value.connector;
    const std::string name = parameter.name.substr(parameter.owner.size() + 1);
    if (auto* present = find(connector.parameters, name))
      *present = replaced(*present, value, parameter.unit);
    else
      connector.parameters.emplace_back(name, value_in(value, parameter.unit));
    return true;
  }

  /// The numbers of a chain are common to all its springs and masses: the chain is written out.
  static void write_out_chain(d::Substructure& part) {
    if (!part.chain) return;
    const d::Chain chain = *std::exchange(part.chain, std::nullopt);
    std::vector<d::Spring> springs;
    for (int i = 1; i <= chain.masses; ++i) {
      const std::string name = std::to_string(i), before = std::to_string(i - 1);
      part.masses.push_back({name, {{"", chain.mass}}});
      if (i > 1) springs.push_back({before + "-" + name, {before}, {name}, chain.stiffness, chain.damping});
    }
    part.springs.insert(part.springs.begin(), springs.begin(), springs.end());
  }

  static double& mass_of(d::Substructure& part, std::size_t element) {
    for (auto& [node, masses] : part.masses) {
      if (element < masses.size()) return masses[element].second;
      element -= masses.size();
    }
    return part.masses.back().second.back().second;
  }

  static bool set_lumped(d::Substructure& part, const LumpedParameter& target, double value) {
    using enum LumpedParameter::Kind;
    if (target.kind == stiffness || target.kind == damping || target.kind == mass) write_out_chain(part);
    if (target.kind == stiffness) part.springs[target.element].stiffness = value;
    if (target.kind == damping) part.springs[target.element].damping = value;
    if (target.kind == mass) mass_of(part, target.element) = value;
    if (target.kind == modal_ratio) part.damping.modal[target.element] = value;
    if (target.kind == all_modal_ratios) part.damping.modal.assign(1, value);
    if (target.kind == mass_factor) part.damping.mass_factor = value;
    if (target.kind == stiffness_factor) part.damping.stiffness_factor = value;
    return true;
  }

  bool set_elements(d::Substructure& part, const std::string& owner, const FiniteElementParameter& target,
                    double value) {
    using enum FiniteElementParameter::Kind;
    if (target.kind == matrix) return set_matrix(part, owner, target.name, value);
    if (target.kind == modal_ratio) part.damping.modal[target.ratio] = value;
    if (target.kind == all_modal_ratios) part.damping.modal.assign(1, value);
    if (target.kind == mass_factor) part.damping.mass_factor = value;
    if (target.kind == stiffness_factor) part.damping.stiffness_factor = value;
    return true;
  }

  bool set_matrix(d::Substructure& part, const std::string& owner, const std::string& parameter, double value) {
    const auto [name, quantity] = split_at_last_dot(parameter);
    if (quantity == "youngs_modulus" || quantity == "density") return set_material(part, owner, name, quantity, value);
    if (quantity == "thickness") return set_thickness(part, owner, name, value);
    if (auto* mass = find(part.finite_elements->masses, name); mass && quantity == "mass") {
      mass->mass = value;
      return true;
    }
    const auto spring = std::ranges::find(part.springs, name, &spring_name);
    if (quantity != "stiffness" || spring == part.springs.end()) return false;
    spring->stiffness = value;
    return true;
  }

  [[nodiscard]] const FiniteElementModel& elements_of(const std::string& owner) const {
    return std::ranges::find(structure_.finite_elements, owner, [](const auto& each) { return each.part->name; })
        ->part->elements;
  }

  /// A material of a deck is replaced as a whole.
  bool set_material(d::Substructure& part, const std::string& owner, const std::string& name,
                    const std::string& quantity, double value) {
    auto& materials = part.finite_elements->materials;
    if (!find(materials, name)) {
      const auto& [modulus, ratio, density] = elements_of(owner).materials.at(name);
      materials.push_back({name, {modulus, ratio, density}});
    }
    (quantity == "density" ? find(materials, name)->density : find(materials, name)->youngs_modulus) = value;
    return true;
  }

  /// A plain shell of a deck is replaced as a whole; one with nonstructural mass cannot be.
  bool set_thickness(d::Substructure& part, const std::string& owner, const std::string& name, double value) {
    auto& regions = part.finite_elements->regions;
    if (!find(regions, name)) {
      const auto& properties = elements_of(owner).properties;
      const auto found = properties.find(name);
      const auto* shell = found == properties.end() ? nullptr : std::get_if<ShellProperty>(&found->second);
      if (!shell || shell->nonstructural_mass != 0.0) return false;
      regions.push_back({name, {{shell->material}, d::ShellRegion{shell->thickness, shell->offset}}});
    }
    auto* shell = std::get_if<d::ShellRegion>(&find(regions, name)->property);
    if (shell) shell->thickness = value;
    return shell != nullptr;
  }

  d::Case& given_;
  const StructureModel& structure_;
};

std::string without_place(const Parameter& target, double value, const std::string& owner) {
  const std::string unit = target.unit == "-" ? "" : " " + target.unit;
  return "'" + target.name + "', found to be " + shortest(value) + unit +
         ", has no key among the substructures; only the initial value of " + owner + " holds it";
}

bool is_percentage(const d::Value& value) { return !value.value.bare && value.value.dimension == Dimension{}; }

/// The new start of an unknown. A prior in per cent stays so, another one as wide as before in the filter's state. The
/// transform is the one that the run had: a default follows the sign of the initial value.
void set_start(const Unknown& unknown, double value, d::Unknown& given) {
  const auto& transform = unknown.transform;
  if (transform.kind == TransformKind::logit) {  // strictly between the bounds, whatever rounding does
    const double margin = 1e-9 * (transform.upper - transform.lower);
    value = std::clamp(value, transform.lower + margin, transform.upper - margin);
  }
  constexpr double too_small = 1e-3;  // per cent of next to nothing would hold the unknown there
  const bool can_scale = std::abs(value) > too_small * std::abs(unknown.initial);
  const auto as_wide = [&](std::optional<d::Value>& spread, double former) {
    if (can_scale && (!spread || is_percentage(*spread))) return;
    const double widening =
        transform.slope(transform.to_state(value)) / transform.slope(transform.to_state(unknown.initial));
    spread = replaced(given.initial, former * widening, unknown.unit());
  };
  as_wide(given.std, unknown.deviation);
  if (given.random_walk) as_wide(given.random_walk, unknown.random_walk);
  given.initial = replaced(given.initial, value, unknown.unit());
  if ((value > 0.0) != (unknown.initial > 0.0)) given.transform = transform.kind;
}

/// Puts values into a description of the case, and collects notes on those that have no place.
class Identification {
public:
  explicit Identification(const Study& study)
      : study_(study), given_(*study.description), places_(given_, *study.structure) {}

  void put_updated(const std::vector<double>& values) {
    const auto& [parameters, bindings, truth] = *study_.updating;
    for (const auto& [index, target] : bindings) {
      const auto i = static_cast<std::size_t>(index);
      if (!places_.set(target, values[i]))
        notes_.push_back(without_place(target, values[i], "update.parameters." + parameters[i].name));
    }
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      auto& given = find(given_.update->parameters, parameters[i].name)->value;
      given.initial = value_in(values[i], parameters[i].unit);
      if (given.std) given.std = value_in(parameters[i].deviation, parameters[i].unit);
    }
  }

  void put_estimated(const std::vector<double>& values) {
    const auto& unknowns = study_.problem->settings.unknowns;
    for (std::size_t i = 0; i < unknowns.size(); ++i) {
      for (const auto& target : unknowns[i].targets)
        if (!places_.set(target, values[i]))
          notes_.push_back(without_place(target, values[i], "estimate.unknown." + unknowns[i].name));
      set_start(unknowns[i], values[i], *find(given_.estimate->unknown, unknowns[i].name));
    }
  }

  void put_of_measurement(const std::vector<std::pair<std::string, double>>& values) {
    for (const auto& [name, value] : values) {
      auto& given = *find(given_.estimate->unknown, name);
      given.initial = value_in(value, measurement_unit(study_.sensors, name));
    }
  }

  void put_moved(const IdentifiedValues& values) {
    for (const auto& [parameter, value] : values.moved)
      if (!places_.set(parameter, value))
        notes_.push_back("'" + parameter.name + "' of " + shortest(value) + " " + parameter.unit +
                         " has no place in the case");
    for (const auto& words : values.moved_signals)
      notes_.push_back("the values belong to " + words + ", which is not written");
  }

  [[nodiscard]] IdentifiedCase finish() const {
    static const auto schema = d::case_schema();
    const auto written =
        as_given(schema.write(given_), schema.write(*study_.description), study_.description->source.root());
    std::string comments;
    for (const auto& note : notes_) comments += "# " + note + "\n";
    return {comments + to_yaml(*written), notes_};
  }

private:
  const Study& study_;
  d::Case given_;
  ParameterPlaces places_;
  std::vector<std::string> notes_;
};

}  // namespace

d::Value value_in(double number, const std::string& unit) {
  const auto dimension = dimension_of(unit);
  return {{number, dimension.value_or(Dimension{}), !dimension}};
}

bool put_value(d::Case& given, const StructureModel& structure, const Parameter& parameter, double value) {
  return ParameterPlaces(given, structure).set(parameter, value);
}

IdentifiedCase identified_case(const Study& study, const IdentifiedValues& values) {
  Identification identification(study);
  if (!values.updated.empty()) identification.put_updated(values.updated);
  if (!values.unknowns.empty()) identification.put_estimated(values.unknowns);
  identification.put_of_measurement(values.of_measurement);
  identification.put_moved(values);
  return identification.finish();
}

}  // namespace kalfem
