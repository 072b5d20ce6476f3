// SPDX-License-Identifier: Apache-2.0
#include "casefile/probes.hpp"
#include "kalfem/system/laws/law_library.hpp"

/// Keys of lumped substructures, connectors and the whole structure's damping.
namespace kalfem::wiring {
namespace {

Study with_substructure(const std::string& text, const Sections& more = {}) {
  Sections sections{{"substructures", "{s: {" + text + "}}"}, {"connectors", ""}, {"excitation", ""}, {"sensors", ""}};
  for (const auto& [key, value] : more) sections[key] = value;
  return study_of(lumped_case(sections));
}

Study with_connector(const std::string& text) {
  return study_of(lumped_case({{"connectors", "{c: {from: s.a, to: s.b, " + text + "}}"}}));
}

/// Force of the first connector at a deformation and a rate, and its first internal state, 0 before, after `duration`.
std::pair<double, double> connector_response(const Study& study, double deformation, double rate, double duration) {
  const auto& connector = system_of(study).connectors.at(0);
  const auto states = static_cast<Eigen::Index>(connector.law->states().size());
  const Eigen::ArrayXXd parameters = connector.parameters.transpose().array(), begin = Eigen::ArrayXXd::Zero(1, states);
  const Eigen::ArrayXd d = Eigen::ArrayXd::Constant(1, deformation), v = Eigen::ArrayXd::Constant(1, rate),
                       a = Eigen::ArrayXd::Zero(1), d0 = d - rate * duration;
  Eigen::ArrayXd force(1), stiffness(1), damping(1), inertance(1);
  Eigen::ArrayXXd end(1, states);
  connector.law->respond({duration, parameters, d0, v, begin, d, v, a}, {force, stiffness, damping, inertance, end});
  return {force[0], states > 0 ? end(0, 0) : 0.0};
}

double connector_force(const Study& study, double deformation, double rate) {
  return connector_response(study, deformation, rate, 0.0).first;
}

void grounds_are_named_and_move() {
  const auto study = with_substructure(
      "masses: {a: 2}, grounds: [wall], springs: [{from: ground, to: a, stiffness: 700}, {from: a, to: wall, "
      "stiffness: "
      "300, damping: 5}]",
      {{"excitation", "{w: {base_displacement: s.wall, constant: 1 mm}}"}});
  near(stiffness(study, 0, 0), 1000.0);
  near(system_of(study).inputs[0].value[0], 300.0);
  near(system_of(study).inputs[0].rate[0], 5.0);
}

void points_are_weighted_sums() {
  const auto study = with_substructure(
      "masses: {a: 2, b: 3}, springs: [{from: ground, to: a, stiffness: 1e3}], "
      "points: {p: {a: 1, b: -0.75}}",
      {{"excitation", "{f: {force: s.p, constant: 1 N}}"}});
  near(system_of(study).inputs[0].value, vector({1.0, -0.75}));
  near(study.model->motion("s.p").dofs, vector({1.0, -0.75}));
}

const std::string two_modes =
    "masses: {a: 2, b: 3}, springs: [{from: ground, to: a, stiffness: 800}, {from: a, to: b, "
    "stiffness: 500}], damping: ";

void modal_ratios_are_one_a_mode() {
  near(modal_ratios(with_substructure(two_modes + "{modal: 2 %}")), vector({0.02, 0.02}), many_roundings);
  near(modal_ratios(with_substructure(two_modes + "{modal: [1 %, 3 %]}")), vector({0.01, 0.03}), many_roundings);
}

void rayleigh_factors_multiply_mass_and_stiffness() {
  const auto study = with_substructure(two_modes + "{mass_factor: 0.5 1/s}");
  near(damping(study, 0, 0), 1.0);
  near(damping(study, 1, 1), 1.5);
  const auto stiff = with_substructure(two_modes + "{stiffness_factor: 2 ms}");
  near(damping(stiff, 0, 0), 2.6);
  near(damping(stiff, 0, 1), -1.0);
}

void structure_modal_damping_is_of_the_whole() {
  const Sections undamped{
      {"substructures",
       "{s: {masses: {a: 2, b: 3}, springs: [{from: ground, to: a, stiffness: 800}, {from: a, to: b, "
       "stiffness: 500}]}}"},
      {"connectors", ""}};
  auto sections = undamped;
  sections["damping"] = "{modal: [2 %, 5 %]}";
  near(modal_ratios(study_of(lumped_case(sections))), vector({0.02, 0.05}), many_roundings);
  sections["damping"] = "{modal: 4 %}";
  near(modal_ratios(study_of(lumped_case(sections))), vector({0.04, 0.04}), many_roundings);
}

/// With finite elements modes above the limit have no ratio of their own.
void global_modal_damping_ends_at_its_frequency() {
  const auto kept = [](const std::string& text) {
    return system_of(study_of(beam_case({{"damping", text}}))).modal_damping.modes.frequencies;
  };
  const auto few = kept("{modal: 1 %, up_to: 60 Hz}"), more = kept("{modal: 1 %, up_to: 400 Hz}");
  ASSERT_GT(few.size(), 0);
  // what was asked for
  EXPECT_LE(few.maxCoeff(), 60.0);
  EXPECT_GT(more.maxCoeff(), 60.0);
  EXPECT_LE(more.maxCoeff(), 400.0);
  EXPECT_GT(kept("{modal: 1 %}").maxCoeff(), few.maxCoeff());  // 500 Hz
}

/// Two beams, the second at the end of the first or a little beside it, that share the motions of one node.
void joints_share_degrees_of_freedom() {
  const auto joined = [](const std::string& place, const std::string& more) {
    return study_of(
        beam_case({{"substructures", "{b: {finite_elements: {" + beam_elements() + "}}, c: {finite_elements: {" +
                                         beam_elements("translate: [" + place + ", 0, 0]") + "}}}"},
                   {"joints", "{weld: {between: [b.tip, c.mid]" + more + "}}"}}));
  };
  const auto study = joined("0.5 m", "");
  EXPECT_EQ(study.structure->parts.shared.size(), 6u);
  EXPECT_EQ(system_of(study).size(), 12 + 12 - 6);
  EXPECT_EQ(study.model->dof_index("b.n3.z"), study.model->dof_index("c.n2.z"));
  EXPECT_THROW(joined("0.501 m", ""), InvalidInput);
  EXPECT_EQ(joined("0.501 m", ", tolerance: 2 mm").structure->parts.shared.size(), 6u);
}

KeyChecks substructure_keys() {
  const std::string at = "substructures.*.";
  return {
      {at + "masses",
       [] {
         const auto study = with_substructure("masses: {a: 2 kg, b: {x: 30 g, rz: 0.1}}");
         EXPECT_EQ(system_of(study).dofs, (std::vector<std::string>{"s.a", "s.b.x", "s.b.rz"}));
         near(Eigen::VectorXd(Eigen::MatrixXd(system_of(study).mass).diagonal()), vector({2.0, 0.03, 0.1}));
       }},
      {at + "chain.masses",
       [] {
         const auto study = with_substructure("chain: {masses: 4, mass: 1, stiffness: 100}");
         EXPECT_EQ(system_of(study).dofs, (std::vector<std::string>{"s.1", "s.2", "s.3", "s.4"}));
       }},
      {at + "chain.mass",
       [] { near(mass(with_substructure("chain: {masses: 3, mass: 250 g, stiffness: 100}"), 2, 2), 0.25); }},
      {at + "chain.stiffness",
       [] {
         const auto study = with_substructure("chain: {masses: 3, mass: 1, stiffness: 2 kN/m}");
         near(stiffness(study, 0, 0), 2000.0);
         near(stiffness(study, 1, 1), 4000.0);
         near(stiffness(study, 1, 2), -2000.0);
         near(damping(study, 1, 1), 0.0);
       }},
      {at + "chain.damping",
       [] {
         const auto study = with_substructure("chain: {masses: 3, mass: 1, stiffness: 100, damping: 7 N s/m}");
         near(damping(study, 0, 0), 7.0);
         near(damping(study, 1, 1), 14.0);
         near(damping(study, 0, 1), -7.0);
       }},
      {at + "springs[].name",
       [] {
         const auto springs = [](const std::string& name) {
           return with_substructure("masses: {a: 1}, springs: [{" + name + "from: ground, to: a, stiffness: 5}]")
               .structure->parts.substructures[0]
               .springs[0]
               .name;
         };
         EXPECT_EQ(springs("name: k_w, "), "k_w");
         EXPECT_EQ(springs(""), "ground-a");
       }},
      {at + "springs[].from",
       [] {
         const auto study = with_substructure("masses: {a: 1, b: 1, c: 1}, springs: [{from: b, to: c, stiffness: 10}]");
         near(stiffness(study, 1, 1), 10.0);
         near(stiffness(study, 0, 0), 0.0);
       }},
      {at + "springs[].to",
       [] {
         const auto study = with_substructure("masses: {a: 1, b: 1, c: 1}, springs: [{from: a, to: c, stiffness: 10}]");
         near(stiffness(study, 0, 2), -10.0);
         near(stiffness(study, 0, 1), 0.0);
       }},
      {at + "springs[].stiffness",
       [] {
         near(stiffness(with_substructure("masses: {a: 1}, springs: [{from: ground, to: a, stiffness: 3 N/mm}]"), 0, 0),
              3000.0);
       }},
      {at + "springs[].damping",
       [] {
         const auto study = with_substructure("masses: {a: 1, b: 1}, springs: [{from: a, to: b, damping: 6 N s/m}]");
         near(damping(study, 0, 1), -6.0);
         near(stiffness(study, 0, 0), 0.0);
       }},
      {at + "grounds", grounds_are_named_and_move},
      {at + "points", points_are_weighted_sums},
      {at + "damping.modal", modal_ratios_are_one_a_mode},
      {at + "damping.mass_factor", rayleigh_factors_multiply_mass_and_stiffness},
      {at + "damping.stiffness_factor", rayleigh_factors_multiply_mass_and_stiffness},
  };
}

void expression_states_have_rates_and_units() {
  const auto study = with_connector(
      "law: expression, force: 'k*x + z', parameters: {k: 200}, states: {z: {rate: '3*v - 5*z', unit: N}}");
  const auto& law = *system_of(study).connectors[0].law;
  ASSERT_EQ(law.states().size(), 1u);
  EXPECT_EQ(law.states()[0].name, "z");
  EXPECT_EQ(law.states()[0].unit, "N");
  EXPECT_EQ(with_connector("law: expression, force: z, states: {z: {rate: v}}")
                .model->system()
                .connectors[0]
                .law->states()[0]
                .unit,
            "-");
  near(connector_force(study, 0.5, 0.0), 100.0);
  // At the constant rate 2 from z = 0: z' = 6 - 5 z, so z(h) = 1.2 (1 - exp(-5 h)), to the trapezoidal rule.
  near(connector_response(study, 0.5, 2.0, 0.01).second, 1.2 * (1.0 - std::exp(-0.05)), 2e-4);
}

KeyChecks connector_keys() {
  const std::string linear = "law: linear, parameters: {k: 500, c: 3}";
  const auto ends = [linear] {
    const auto study = study_of(lumped_case({{"connectors", "{c: {from: s.a, to: s.b, " + linear + "}}"}}));
    near(system_of(study).connectors[0].deformation, vector({-1.0, 1.0}));
    const auto turned = study_of(lumped_case({{"connectors", "{c: {from: s.b, to: s.ground, " + linear + "}}"}}));
    near(system_of(turned).connectors[0].deformation, vector({0.0, -1.0}));
  };
  return {{"connectors.*.from", ends},
          {"connectors.*.to", ends},
          {"connectors.*.law",
           [] {
             for (const auto& law : law_library()) {
               if (law.name == "linear_change" || law.name == "expression" || law.name == "polynomial") continue;
               std::string parameters;
               for (const auto& each : law.parameters)
                 if (std::isnan(each.default_value)) parameters += (parameters.empty() ? "" : ", ") + each.name + ": 1";
               const auto study = with_connector("law: " + law.name + ", parameters: {" + parameters + "}");
               EXPECT_EQ(system_of(study).connectors[0].law->name(), law.name);
             }
           }},
          {"connectors.*.parameters",
           [] {
             const auto study = with_connector("law: linear, parameters: {c: 3 N s/m, k: 2 kN/m}");
             near(system_of(study).connectors[0].parameters, vector({2000.0, 3.0}));
             near(connector_force(study, 0.01, 2.0), 26.0);
             const auto cubic = with_connector("law: polynomial, parameters: {k1: 10, k3: 7, c2: 4}");
             near(connector_force(cubic, 2.0, 3.0), 10.0 * 2 + 7.0 * 8 + 4.0 * 9);
           }},
          {"connectors.*.force",
           [] {
             near(connector_force(with_connector("law: expression, force: 'k*x^2 + v', parameters: {k: 3}"), 2.0, 0.5),
                  12.5);
           }},
          {"connectors.*.states.*.rate", expression_states_have_rates_and_units},
          {"connectors.*.states.*.unit", expression_states_have_rates_and_units}};
}

}  // namespace

KeyChecks structure_keys() {
  KeyChecks keys = substructure_keys();
  keys.merge(connector_keys());
  keys.merge(KeyChecks{
      {"kalfem",
       [] {
         EXPECT_TRUE(study_of(lumped_case()).resolved_case.starts_with("kalfem: 1\n"));
         EXPECT_THROW(study_of(lumped_case({{"kalfem", "2"}})), InvalidInput);
       }},
      {"joints.*.between", joints_share_degrees_of_freedom},
      {"joints.*.tolerance", joints_share_degrees_of_freedom},
      {"damping.modal", structure_modal_damping_is_of_the_whole},
      {"damping.up_to", global_modal_damping_ends_at_its_frequency},
  });
  return keys;
}

}  // namespace kalfem::wiring
