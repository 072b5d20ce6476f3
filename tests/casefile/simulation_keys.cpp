// SPDX-License-Identifier: Apache-2.0
#include "casefile/probes.hpp"
#include "kalfem/base/random.hpp"
#include "kalfem/steps/run_study.hpp"
#include "kalfem/steps/simulation/outcome.hpp"

/// Keys of the simulation: the record is the one that the library makes with the same options.
namespace kalfem::wiring {
namespace {

const Sections cubic{{"connectors", "{c: {from: s.a, to: s.b, law: cubic, parameters: {k: 500, k3: 1e6, c: 3}}}"}};

Study with_simulation(const std::string& text) {
  auto sections = cubic;
  sections["simulate"] = "{duration: 0.5 s, sample_rate: 100 Hz, " + text + "}";
  return study_of(lumped_case(sections));
}

/// A few coarse steps, so that no two schemes agree: the case's record against the library's.
void integrators() {
  struct Scheme {
    std::string text;
    SimulationOptions options;
  };
  const std::vector<Scheme> schemes{
      {"integrator: newmark", {.integrator = Integrator::newmark}},
      {"integrator: hht_alpha", {.integrator = Integrator::hht_alpha}},
      {"integrator: hht_alpha, hht_alpha: -0.3", {.integrator = Integrator::hht_alpha, .hht_alpha = -0.3}},
      {"integrator: generalized_alpha", {.integrator = Integrator::generalized_alpha}},
      {"integrator: generalized_alpha, spectral_radius: 0.2",
       {.integrator = Integrator::generalized_alpha, .spectral_radius = 0.2}},
      {"integrator: exact", {.integrator = Integrator::exact}}};
  std::vector<Eigen::MatrixXd> records;
  for (const auto& scheme : schemes) {
    const auto study = with_simulation(scheme.text + ", tolerance: 5, first_substeps: 1, max_substeps: 2");
    auto options = scheme.options;
    options.duration = 0.5;
    const auto reference =
        simulate_converged(system_of(study), study.structure->signals, at_rest(2, 0),
                           make_outputs(*study.model, {study.sensors[0].output}), {}, options,
                           {.sample_rate = 100, .first_substeps = 1, .max_substeps = 2, .tolerance = 5});
    records.push_back(clean_record(study));
    // the same simulation
    EXPECT_LT(relative_difference(records.back(), reference.sensors), 1e-14) << scheme.text;
    for (std::size_t i = 0; i + 1 < records.size(); ++i)
      EXPECT_GT(relative_difference(records[i], records.back()), 1e-7) << scheme.text << " and " << schemes[i].text;
  }
  EXPECT_LT(relative_difference(clean_record(with_simulation("tolerance: 5, first_substeps: 1, max_substeps: 2")),
                                records.front()),
            1e-14);  // newmark where the case does not say
}

void steps_are_refined_to_the_tolerance() {
  const auto substeps = [](const std::string& text) {
    return run(with_simulation(text), "simulate").get<SimulationOutcome>().reference.substeps;
  };
  EXPECT_EQ(substeps("tolerance: 5, first_substeps: 1"), 2);
  EXPECT_EQ(substeps("tolerance: 5, first_substeps: 8"), 16);
  EXPECT_EQ(substeps("tolerance: 5"), 8);  // from 4 on
  EXPECT_GT(substeps("tolerance: 1e-6, first_substeps: 1"), substeps("tolerance: 1e-2, first_substeps: 1"));
  const auto stopped = run_study(with_simulation("tolerance: 1e-12, first_substeps: 1, max_substeps: 4"), "simulate");
  EXPECT_FALSE(stopped.complete());
  EXPECT_EQ(stopped.get<SimulationOutcome>().reference.substeps, 3);  // 6 would be the next
}

/// A fixed step is neither refined nor compared: the plain solution with it, also above the usual max_substeps of 256.
void fixed_steps() {
  for (const int substeps : {3, 300}) {
    const auto study = with_simulation("substeps: " + std::to_string(substeps));
    const auto reference = run(study, "simulate").get<SimulationOutcome>().reference;
    EXPECT_EQ(reference.substeps, substeps);
    EXPECT_TRUE(reference.changes.empty());
    const auto once =
        simulate(system_of(study), study.structure->signals, at_rest(2, 0),
                 {.integrator = Integrator::newmark, .step = 0.01 / substeps, .duration = 0.5, .keep_every = substeps});
    near(Eigen::VectorXd(reference.sensors.row(0).transpose()),
         Eigen::VectorXd(once.trajectory.displacement.row(1).transpose()));
  }
}

void lengths() {
  const auto study = study_of(lumped_case({{"simulate", "{duration: 0.3 s, sample_rate: 200 Hz}"}}));
  const auto results = run(study, "simulate");
  EXPECT_EQ(results.get<SimulationOutcome>().measurements.samples(), 61);
  near(results.get<SimulationOutcome>().measurements.sample_rate, 200.0);
  near(study.sample_rate(), 200.0);
}

void seeds() {
  const auto noise = [](const std::string& text) {
    const auto results =
        run(study_of(lumped_case({{"simulate", "{duration: 0.5 s, sample_rate: 100 Hz" + text + "}"}})), "simulate");
    return Eigen::VectorXd(
        (results.get<SimulationOutcome>().measurements.values - results.get<SimulationOutcome>().reference.sensors)
            .row(0)
            .transpose() /
        1e-4);
  };
  for (const std::uint64_t seed : {1, 7}) {
    RandomStream random(seed, "y");
    const Eigen::VectorXd expected = Eigen::VectorXd::NullaryExpr(51, [&] { return random.normal(); });
    near(noise(", seed: " + std::to_string(seed)), expected, many_roundings);
  }
  near(noise(""), noise(", seed: 1"));
}

void starts() {
  const auto first = [](const std::string& text, ObservedQuantity quantity, const std::string& point) {
    const auto study =
        study_of(lumped_case({{"simulate", "{duration: 0.5 s, sample_rate: 100 Hz, initial: {" + text + "}}"}}));
    const auto results = run(study, "simulate");
    for (const auto& each : results.get<SimulationOutcome>().points)
      if (each.point == point && each.quantity == quantity) return each.mean[0];
    return 0.0;
  };
  using enum ObservedQuantity;
  near(first("s.b: {displacement: 3 mm}", displacement, "s.b"), 3e-3);
  EXPECT_EQ(first("s.b: {displacement: 3 mm}", displacement, "s.a"), 0.0);
  EXPECT_EQ(first("s.b: {displacement: 3 mm}", velocity, "s.b"), 0.0);
  near(first("s.a: {velocity: -2 m/s}", velocity, "s.a"), -2.0);
}

/// Of finite elements the record is made from every degree of freedom, or from a superelement of many modes.
void reference_models() {
  const auto dofs = [](const std::string& text) {
    return system_of(study_of(beam_case({{"simulate", "{duration: 0.02, sample_rate: 1000, " + text + "}"}}))).size();
  };
  EXPECT_EQ(dofs("tolerance: 1e-2"), 12);
  EXPECT_EQ(dofs("reference: full"), 12);
  // Three translations of the tip, a mode of bending in each of two planes at 69 Hz, and one modal truncation
  // augmentation vector each.
  const auto few = dofs("reference: superelement, modes_up_to: 100 Hz"),
             more = dofs("reference: superelement, modes_up_to: 3 kHz"), usual = dofs("reference: superelement");
  EXPECT_LT(few, more);
  EXPECT_LT(more, 13);
  EXPECT_EQ(usual, dofs("reference: superelement, modes_up_to: 1200 Hz"));
}

}  // namespace

KeyChecks simulation_keys() {
  return {{"simulate.duration", lengths},
          {"simulate.sample_rate", lengths},
          {"simulate.integrator", integrators},
          {"simulate.hht_alpha", integrators},
          {"simulate.spectral_radius", integrators},
          {"simulate.tolerance", steps_are_refined_to_the_tolerance},
          {"simulate.first_substeps", steps_are_refined_to_the_tolerance},
          {"simulate.max_substeps", steps_are_refined_to_the_tolerance},
          {"simulate.substeps", fixed_steps},
          {"simulate.reference", reference_models},
          {"simulate.modes_up_to", reference_models},
          {"simulate.seed", seeds},
          {"simulate.initial.*.displacement", starts},
          {"simulate.initial.*.velocity", starts}};
}

}  // namespace kalfem::wiring
