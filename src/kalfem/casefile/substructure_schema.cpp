// SPDX-License-Identifier: Apache-2.0
#include "kalfem/casefile/case_schema.hpp"
#include "kalfem/casefile/plausible.hpp"
#include "kalfem/yaml/map_schema.hpp"

namespace kalfem::description {

using namespace schema;

namespace {

/// Mass of a node: one number, or one per direction.
Schema<Named<double>> mass() {
  const auto single = number("kg", plausible::mass());
  const auto full = named(single);
  const auto read = [=](const CaseNode& node, Named<double>& masses) {
    if (node.yaml().kind != YamlNode::Kind::scalar) return full.read(node, masses);
    masses = {{"", 0.0}};
    return single.read(node, masses.front().second);
  };
  const auto write = [=](const Named<double>& masses) {
    const bool one = masses.size() == 1 && masses.front().first.empty();
    return one ? single.write(masses.front().second) : full.write(masses);
  };
  return make_schema<Named<double>>(read, write, either_schema(single.json_schema(), full.json_schema()));
}

Schema<Spring> spring() {
  const auto coefficient = [](const std::string& unit) { return number(unit, plausible::coefficient()); };
  return mapping(
      Fields<Spring>()
          .optional("name", &Spring::name, text(), "name, to refer to it as a parameter; default: from-to")
          .required("from", &Spring::from, name(), "mass, point or ground at one end")
          .required("to", &Spring::to, name(), "mass, point or ground at the other end")
          .optional("stiffness", &Spring::stiffness, coefficient("N/m"), "stiffness of the spring")
          .optional("damping", &Spring::damping, coefficient("N s/m"), "damping of the dashpot in parallel"));
}

Schema<Chain> chain() {
  const auto coefficient = [](const std::string& unit) { return number(unit, plausible::coefficient()); };
  return mapping(Fields<Chain>()
                     .required("masses", &Chain::masses, integer(1, 100000), "number of masses, named 1, 2, ...")
                     .required("mass", &Chain::mass, number("kg", plausible::mass()), "of each")
                     .required("stiffness", &Chain::stiffness, coefficient("N/m"), "between neighbours")
                     .optional("damping", &Chain::damping, coefficient("N s/m"), "between neighbours"));
}

}  // namespace

Schema<Substructure> substructure() {
  const auto damping =
      Fields<Damping>()
          .optional("modal", &Damping::modal, one_or_list(number("-", Bounds::between(0, 0.999))),
                    "damping ratio of every mode, or a list with one ratio per mode (the last one applies to the rest)")
          .optional("mass_factor", &Damping::mass_factor, number("1/s", plausible::coefficient()), "Rayleigh alpha")
          .optional("stiffness_factor", &Damping::stiffness_factor, number("s", plausible::time()), "Rayleigh beta")
          .optional("modal_up_to", &Damping::modal_up_to, number("Hz", plausible::frequency()),
                    "finite elements only: modes up to this frequency have their own ratio; higher modes share the "
                    "damping rate of the last one");
  return mapping(
      Fields<Substructure>()
          .optional("finite_elements", &Substructure::finite_elements, finite_elements(),
                    "a finite-element model, instead of masses and chain")
          .optional("masses", &Substructure::masses, named(mass()),
                    "masses by name: one value, or one per direction ({x: 2 kg, rz: 0.1}), then named node.direction")
          .optional("chain", &Substructure::chain, chain(), "equal masses in a row, joined by equal springs")
          .optional("springs", &Substructure::springs, list(spring()), "springs and dashpots")
          .optional("grounds", &Substructure::grounds, list(text()), "names of further grounds, besides `ground`")
          .optional("points", &Substructure::points, named(named(number("-"), NameRule::dotted)),
                    "named weighted sums of degrees of freedom: LH: {heave: 1, pitch: -0.75}")
          .optional("damping", &Substructure::damping, mapping(damping), "damping in addition to the dashpots")
          .optional("reduction", &Substructure::reduction, located(reduction()),
                    "reduction of the finite-element model inside the filter's model")
          .optional("preload", &Substructure::preload, name(),
                    "load case of `static` whose stresses the finite elements carry: tension makes them stiffer, "
                    "compression softer; default: that which the deck states (STATSUB of Nastran)"));
}

}  // namespace kalfem::description
