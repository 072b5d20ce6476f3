// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "casefile/case_run.hpp"
#include "kalfem/identification/record_estimate.hpp"
#include "kalfem/steps/run_study.hpp"

namespace kalfem::test {

/// The eleven-degree-of-freedom chain with four accelerometers of 5 % noise and two unknowns of its suspension.
/// `stiffness`: the factor of k in the suspension's law, `signals` what it reads.
inline std::string chain_case(const std::string& stiffness, const std::string& signals, int seed, double duration) {
  return R"(kalfem: 1
substructures:
  wheel: {masses: {w: 1.5 kg}, springs: [{name: k_w, from: ground, to: w, stiffness: 20 kN/m}]}
  body: {chain: {masses: 10, mass: 1 kg, stiffness: 30 kN/m}, damping: {modal: 1 %}}
connectors:
  suspension:
    from: wheel.w
    to: body.1
    law: expression
    force: k*)" +
         stiffness + R"(*x + mu*x/(2e-3 + abs(x)) + c*v
    parameters: {k: 5 kN/m, mu: 20 N, c: 60 N s/m}
)" + signals +
         R"(excitation:
  road: {base_displacement: wheel.ground, random: {rms: 3 mm, band: [0.5, 30 Hz], seed: )" +
         std::to_string(seed) + R"(}}
sensors:
  a3: {acceleration: body.2, noise: 5 %}
  a5: {acceleration: body.4, noise: 5 %}
  a7: {acceleration: body.6, noise: 5 %}
  a11: {acceleration: body.10, noise: 5 %}
simulate: {duration: )" +
         std::to_string(duration) + R"( s, sample_rate: 1 kHz, integrator: newmark, tolerance: 1e-4, seed: )" +
         std::to_string(seed) + R"(}
estimate:
  settle: 1 s
  substeps: 4
  unknown: {suspension.k: {initial: 6000, std: 30 %}, suspension.mu: {initial: 24, std: 30 %}}
)";
}

inline std::string steady_chain(int seed, double duration) { return chain_case("1", "", seed, duration); }

/// The suspension's k falls by a fifth at `time`, within a millisecond.
inline std::string dropping_chain(int seed, double duration, double time) {
  return chain_case("(1 - 0.2*min(1, max(0, 1000*(t - " + std::to_string(time) + "))))", "    signals: {t: time}\n",
                    seed, duration);
}

/// The model of one case over the record of another.
inline RecordEstimate estimate_of(const std::string& model, const std::string& recorded) {
  const Study simulated = study_of(recorded), study = study_of(model);
  const StudyResults results = run_study(simulated, "simulate");
  return estimate_record(study.problem, *study.augmented_model, record_of(simulated, results));
}

}  // namespace kalfem::test
