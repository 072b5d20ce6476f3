// SPDX-License-Identifier: Apache-2.0
#include "kalfem/api/finite_elements.hpp"

#include <algorithm>
#include <numbers>

#include "kalfem/api/finite_element_substructure.hpp"
#include "kalfem/model/gauges/gauge_placement.hpp"
#include "kalfem/model/linear_model.hpp"
#include "kalfem/model/part_factors.hpp"

namespace kalfem {

using Eigen::Index;

/// The contents of the description, for its builders.
struct FiniteElementsAccess {
  const FiniteElements& of;

  [[nodiscard]] const auto& nodes() const { return of.nodes_; }
  [[nodiscard]] const auto& gauges() const { return of.gauges_; }
  [[nodiscard]] const auto& fixed() const { return of.fixed_; }
  [[nodiscard]] const auto& boundary() const { return of.boundary_; }
  [[nodiscard]] const auto& damping() const { return of.damping_; }
  [[nodiscard]] const auto& reduction() const { return of.reduction_; }
  [[nodiscard]] const auto& numbers() const { return of.numbers_; }
  static void set(FiniteElements& of, const std::string& number, double value) {
    of.numbers_.push_back({number, value});
  }
};

namespace {

/// Sets a number that the model's description holds; false where it holds none of that name.
bool set_in_model(FiniteElementModel& model, const std::string& number, double value) {
  const auto dot = number.rfind('.');
  const std::string owner = number.substr(0, dot), quantity = dot == std::string::npos ? "" : number.substr(dot + 1);
  if (const auto material = model.materials.find(owner); material != model.materials.end()) {
    if (quantity == "youngs_modulus") return material->second.youngs_modulus = value, true;
    if (quantity == "density") return material->second.density = value, true;
  }
  if (const auto property = model.properties.find(owner); property != model.properties.end())
    if (auto* shell = std::get_if<ShellProperty>(&property->second); shell && quantity == "thickness")
      return shell->thickness = value, true;
  bool any = false;
  if (quantity == "factor")
    for (auto& factor : model.factors)
      if (factor.name == owner) factor.value = value, any = true;
  if (quantity == "mass")
    for (auto& mass : model.masses)
      if (mass.name == owner) mass.mass = value, any = true;
  if (quantity == "stiffness") {
    for (auto& spring : model.springs)
      if (spring.name == owner) spring.stiffness = value, any = true;
    for (auto& joint : model.joints)
      if (joint.name == owner) joint.stiffness = value, any = true;
  }
  return any;
}

void set_damping(FiniteElementDamping& damping, const FiniteElementParameter& parameter, double value) {
  using Kind = FiniteElementParameter::Kind;
  if (parameter.kind == Kind::mass_factor) damping.rayleigh.mass_factor = value;
  if (parameter.kind == Kind::stiffness_factor) damping.rayleigh.stiffness_factor = value;
  if (parameter.kind == Kind::modal_ratio) damping.modal_ratios.values[parameter.ratio] = value;
  if (parameter.kind == Kind::all_modal_ratios) std::ranges::fill(damping.modal_ratios.values, value);
}

/// Looks the names of one description up and builds the part.
class PartBuilder {
public:
  PartBuilder(const FiniteElements& given, const ElementsInUse& use) : given_{given}, use_(use) {
    part_.name = given.name();
    part_.elements = given.model();
    part_.elements.name = given.name();
  }

  FiniteElementPart build() {
    for (const auto& [number, value] : given_.numbers()) set_in_model(part_.elements, number, value);
    find_nodes();
    place_gauges();
    hold_fixed();
    const auto kept = kept_dofs();
    issues_.raise();
    const auto& damping = given_.damping();
    part_.damping = {{damping.alpha, damping.beta}, {damping.ratios, damping.up_to}};
    assemble_part(part_, {.parameters = varied_names(), .independent = kept});
    set_other_numbers();
    const auto& [ratios, up_to] = part_.damping.modal_ratios;
    if (!ratios.empty()) add_modal_damping(part_.full, ratios, {.up_to = up_to}, part_.factor.get());
    for (const auto& dof : kept) keep(dof);
    return std::move(part_);
  }

private:
  [[nodiscard]] std::vector<std::string> varied_names() const {
    std::vector<std::string> names = use_.parameters;
    for (const auto& [number, value] : given_.numbers()) names.push_back(number);
    return names;
  }

  /// Damping, and factors of beams: numbers that the assembled part has and its description does not.
  void set_other_numbers() {
    if (given_.numbers().empty()) return;
    for (const auto& [number, value] : given_.numbers())
      for (const auto& [name, parameter] : parameters_of(part_.assembled, part_.damping)) {
        if (name != number) continue;
        if (parameter.kind == FiniteElementParameter::Kind::matrix)
          part_.assembled.parameters[name] = value;
        else
          set_damping(part_.damping, parameter, value);
      }
    auto gauges = std::move(part_.full.gauges);
    part_.full = linear_model(part_.elements, part_.assembled, part_.nodes, part_.damping.rayleigh);
    part_.full.gauges = std::move(gauges);
    part_.full.points_only = true;
    part_.factor = nullptr;  // of K before the change
  }

  void refuse(const std::string& what, const std::string& why, const std::string& fix) {
    issues_.add({}, "finite elements '" + part_.name + "': " + what, why, fix);
  }

  void find_nodes() {
    const NodeFinder finder(part_.elements.mesh);
    for (const auto& [name, where] : given_.nodes()) {
      if (const auto* place = std::get_if<Eigen::Vector3d>(&where)) {
        const Index node = nearest_node(part_.elements.mesh, *place);
        part_.nodes.push_back({name, node, (part_.elements.mesh.nodes.col(node) - *place).norm()});
        continue;
      }
      const auto number = std::get<std::int64_t>(where);
      const Index node = finder.find(number);
      if (node < 0)
        refuse("node '" + name + "': the mesh has no node " + std::to_string(number), "", "give one of its numbers");
      else
        part_.nodes.push_back({name, node});
    }
  }

  void place_gauges() {
    for (const auto& gauge : given_.gauges()) try {
        part_.gauges.push_back(place_gauge(part_.elements, gauge));
      } catch (const InvalidInput& error) {
        issues_.add(error, {});
      }
  }

  /// Index of a named node; -1, with an issue, if there is none.
  Index node_of(const std::string& name, const std::string& what_for) {
    const auto found = std::ranges::find(part_.nodes, name, &NamedNode::name);
    if (found != part_.nodes.end()) return found->node;
    std::vector<std::string> known;
    for (const auto& node : part_.nodes) known.push_back(node.name);
    refuse(what_for + ": there is no node '" + name + "'" + did_you_mean(name, known), "", "name it by node()");
    return -1;
  }

  void hold_fixed() {
    for (const auto& name : given_.fixed())
      if (const Index node = node_of(name, "fix"); node >= 0) part_.elements.fixed.push_back({name, {node}});
  }

  /// "tip": its translations; "tip.rx": that motion and, if a connector or force acts there, the node's translations
  /// too.
  void add_dofs(const std::string& place, bool touched, std::vector<NodalDof>& dofs) {
    const auto dot = place.find('.');
    const Index node = node_of(place.substr(0, dot), touched ? "a point that is used" : "boundary");
    if (node < 0) return;
    const auto add = [&](int direction) {
      if (const NodalDof dof{node, direction}; std::ranges::find(dofs, dof) == dofs.end()) dofs.push_back(dof);
    };
    const int direction = dot == std::string::npos ? -1 : direction_index(place.substr(dot + 1));
    if (dot != std::string::npos && direction < 0) {
      refuse("'" + place + "' has no direction", "", "write node, or node.x, y, z, rx, ry or rz");
      return;
    }
    if (direction < 0 || touched)
      for (int each = 0; each < 3; ++each) add(each);
    if (direction >= 0) add(direction);
  }

  std::vector<NodalDof> kept_dofs() {
    std::vector<NodalDof> dofs;
    for (const auto& place : given_.boundary()) add_dofs(place, false, dofs);
    for (const auto& place : use_.attached)
      if (place != "ground") add_dofs(place, true, dofs);
    return dofs;
  }

  void keep(const NodalDof& dof) {
    if (part_.assembled.find(dof) >= 0) part_.boundary.push_back(dof_name(part_.elements.mesh, dof));
  }

  FiniteElementsAccess given_;
  const ElementsInUse& use_;
  FiniteElementPart part_;
  IssueList issues_;
};

}  // namespace

FiniteElements::FiniteElements(std::string name, FiniteElementModel model)
    : name_(std::move(name)), model_(std::move(model)) {}

FiniteElements& FiniteElements::node(const std::string& name, std::int64_t number) {
  nodes_.push_back({name, number});
  return *this;
}

FiniteElements& FiniteElements::node(const std::string& name, const Eigen::Vector3d& place) {
  nodes_.push_back({name, place});
  return *this;
}

FiniteElements& FiniteElements::gauge(GaugeDescription gauge) {
  gauges_.push_back(std::move(gauge));
  return *this;
}

FiniteElements& FiniteElements::fix(const std::string& node) {
  fixed_.push_back(node);
  return *this;
}

FiniteElements& FiniteElements::factor(const std::string& name, const std::vector<std::string>& elements, FactorOf of,
                                       double value) {
  add_element_factor(model_, name, elements, of, value);
  return *this;
}

FiniteElements& FiniteElements::modal_damping(std::vector<double> ratios, double up_to) {
  damping_.ratios = std::move(ratios);
  damping_.up_to = up_to;
  return *this;
}

FiniteElements& FiniteElements::rayleigh_damping(double alpha, double beta) {
  damping_.alpha = alpha;
  damping_.beta = beta;
  return *this;
}

FiniteElements& FiniteElements::reduce(ReductionRequest request, std::vector<std::string> boundary) {
  reduction_ = request;
  boundary_ = std::move(boundary);
  return *this;
}

void set_number(FiniteElements& substructure, const std::string& number, double value) {
  FiniteElementsAccess::set(substructure, number, value);
}

FiniteElementSubstructure make_substructure(const FiniteElements& given, const ElementsInUse& use) {
  FiniteElementSubstructure substructure;
  substructure.part = std::make_shared<const FiniteElementPart>(PartBuilder(given, use).build());
  const auto& request = FiniteElementsAccess{given}.reduction();
  if (!request) return substructure;
  substructure.reduction = *request;
  if (substructure.part->boundary.empty())
    throw InvalidInput("finite elements '" + given.name() + "': the reduction has no boundary",
                       "no connector or force touches the substructure", "name the nodes to keep in reduce()");
  substructure.reduced =
      std::make_shared<const Superelement>(reduce(*substructure.part, *request, use.sensor_bandwidth));
  return substructure;
}

Superelement reduce(const FiniteElements& elements) {
  const auto substructure = make_substructure(elements, {});
  if (!substructure.reduced)
    throw InvalidInput("finite elements '" + elements.name() + "' are not to be reduced", "",
                       "call reduce() of the substructure with the nodes to keep");
  return *substructure.reduced;
}

FiniteElementPart make_full_part(const FiniteElements& given) { return PartBuilder(given, {}).build(); }

Eigen::VectorXd natural_frequencies(const FiniteElements& elements, Index count) {
  const FiniteElementPart part = make_full_part(elements);
  return lowest_normal_modes(part.full, {count}, part.factor.get()).frequencies;
}

}  // namespace kalfem
