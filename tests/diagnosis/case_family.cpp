// SPDX-License-Identifier: Apache-2.0
#include "diagnosis/case_family.hpp"
#include "base/places.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include <fmt/format.h>

#include "kalfem/formats/tables/csv.hpp"
#include "kalfem/steps/run_study.hpp"
#include "kalfem/steps/simulation/outcome.hpp"

namespace kalfem::test {

using Eigen::Index;

namespace {

constexpr Index excitation_rate = 4;  ///< times the sensors' rate

std::string with(std::string text, const Changes& changes) {
  for (const auto& [from, to] : changes) {
    const auto at = text.find(from);
    if (at == std::string::npos) ADD_FAILURE() << "no '" << from << "' in\n" << text;
    text.replace(at, from.size(), to);
  }
  return text;
}

std::string sensors_of(const CaseFamily& family, const Record* measured) {
  std::string text = "sensors:\n";
  for (const auto& sensor : family.sensors) {
    const std::string noise =
        measured
            ? fmt::format("{:.6g} {}", measured->channels[static_cast<std::size_t>(measured->find(sensor.name))].noise,
                          sensor.unit)
            : fmt::format("{} %", 100.0 * family.noise);
    text += fmt::format("  {}: {{{}, noise: {}{}}}\n", sensor.name, sensor.quantity, noise, sensor.more);
  }
  return text;
}

std::filesystem::path write(const std::filesystem::path& file, const std::string& text) {
  std::ofstream(file) << text;
  return file;
}

}  // namespace

Measurement measure(const CaseFamily& family, const Changes& changes, int seed, const std::filesystem::path& folder) {
  std::string text = "kalfem: 1\ntitle: " + family.name + "\n" + with(family.structure, changes) + "excitation:\n";
  for (const auto& each : family.excitations)
    text += fmt::format("  {}: {{{}, {}}}\n", each.name, each.drives, each.signal);
  text += sensors_of(family, nullptr);
  text += fmt::format("simulate: {{duration: {} s, sample_rate: {} Hz, seed: {}, {}}}\n", family.duration,
                      family.sample_rate, seed, family.simulate);
  const Study study = load_study(write(folder / "truth.yaml", text).string());
  StudyResults results = run_study(study, "simulate");
  if (!results.complete()) ADD_FAILURE() << results.failure;
  Measurement measurement{results.get<SimulationOutcome>().measurements, {}};
  const double rate = excitation_rate * family.sample_rate;
  const Index count = excitation_rate * (measurement.sensors.samples() - 1) + 1;
  std::vector<std::pair<std::string, Eigen::VectorXd>> signals;
  for (std::size_t i = 0; i < study.structure->signals.size(); ++i)
    signals.emplace_back(study.structure->parts.inputs[i].name,
                         study.structure->signals[i]->sample(0.0, 1.0 / rate, count).col(0));
  measurement.excitations = make_record(rate, signals);
  return measurement;
}

std::filesystem::path write_case(const CaseFamily& family, const Measurement& measurement, const Changes& changes,
                                 const std::filesystem::path& folder) {
  write_csv(folder / "record.csv", measurement.sensors);
  write_csv(folder / "excitation.csv", measurement.excitations);
  std::string text = "kalfem: 1\ntitle: " + family.name + "\n" + with(family.structure, changes) + "excitation:\n";
  for (const auto& each : family.excitations)
    text += fmt::format("  {}: {{{}, file: excitation.csv, channel: {}}}\n", each.name, each.drives, each.name);
  text +=
      sensors_of(family, &measurement.sensors) + "record: {file: record.csv, skip_missing: true}\n" + family.estimate;
  const char* thoughts = std::getenv("KALFEM_SECOND_THOUGHTS");  // what the figures of a default run rest on: 2
  text += fmt::format("  second_thoughts: {}\n", thoughts ? thoughts : "full");
  return write(folder / "case.yaml", text);
}

CaseFamily chain_family() {
  return {
      .name = "chain",
      .structure = R"(substructures:
  wheel:
    masses: {w: 1.5 kg}
    springs: [{name: k_w, from: ground, to: w, stiffness: 20 kN/m}]
  body:
    chain: {masses: 10, mass: 1.0 kg, stiffness: 30 kN/m}
    damping: {modal: 1 %}
connectors:
  suspension:
    from: wheel.w
    to: body.1
    law: saturating
    parameters: {k: 5 kN/m, mu_k1: 20 N, mu_k2: 2 mm, c: 10 N s/m, mu_c1: 10 N, mu_c2: 0.05 m/s}
)",
      .excitations = {{"road", "base_displacement: wheel.ground", "random: {rms: 3 mm, band: [0.5, 30 Hz], seed: 7}"}},
      .sensors = {{"a3", "acceleration: body.2", "m/s^2"},
                  {"a5", "acceleration: body.4", "m/s^2"},
                  {"a7", "acceleration: body.6", "m/s^2"},
                  {"a11", "acceleration: body.10", "m/s^2"}},
      .noise = 0.15,
      .simulate = "integrator: newmark, tolerance: 1e-4",
      .duration = 8.0,
      .sample_rate = 1000.0,
      .estimate = R"(estimate:
  unknown:
    suspension.mu_k1: {initial: 15 N, std: 50 %}
    suspension.mu_c1: {initial: 13 N, std: 50 %}
  settle: 1 s
)"};
}

CaseFamily half_car_family() {
  return {
      .name = "half car",
      .structure = R"(substructures:
  car:
    masses: {heave: 430, pitch: 82, uL: 56, uR: 56}
    grounds: [groundL, groundR]
    points:
      LH: {heave: 1, pitch: -0.75}
      RH: {heave: 1, pitch: 0.75}
    springs:
      - {name: strut_L, from: uL, to: LH, stiffness: 20 kN/m}
      - {name: strut_R, from: uR, to: RH, stiffness: 20 kN/m}
      - {name: tyre_L, from: groundL, to: uL, stiffness: 150 kN/m, damping: 100 N s/m}
      - {name: tyre_R, from: groundR, to: uR, stiffness: 150 kN/m, damping: 100 N s/m}
connectors:
  damper_L: {from: car.uL, to: car.LH, law: coulomb, parameters: {f_c: 60, v_ref: 0.05, k: 0, c: 1200}}
  damper_R: {from: car.uR, to: car.RH, law: cubic, parameters: {k: 0, k3: 2e6, c: 1000, c3: 0}}
)",
      .excitations = {{"road_L", "base_displacement: car.groundL", "random: {rms: 6 mm, band: [0.5, 20 Hz], seed: 3}"},
                      {"road_R", "base_displacement: car.groundR", "random: {rms: 6 mm, band: [0.5, 20 Hz], seed: 4}"}},
      .sensors = {{"body_L", "acceleration: car.LH", "m/s^2"},
                  {"body_R", "acceleration: car.RH", "m/s^2"},
                  {"wheel_L", "acceleration: car.uL", "m/s^2"},
                  {"stroke_R", "displacement: car.uR", "m"}},
      .noise = 0.05,
      .simulate = "tolerance: 1e-4",
      .duration = 15.0,
      .sample_rate = 250.0,
      .estimate = R"(estimate:
  unknown:
    damper_L.c: {initial: 900, std: 40 %}
    damper_R.k3: {initial: 1.4e6, std: 50 %}
    car.strut_R.stiffness: {initial: 17 kN/m, std: 30 %}
  settle: 1 s
)"};
}

CaseFamily frame_family() {
  return {.name = "frame",
          .structure = R"(substructures:
  frame:
    masses: {f1: 1200, f2: 1200, f3: 900}
    springs:
      - {name: storey_2, from: f1, to: f2, stiffness: 1.6 MN/m}
      - {name: storey_3, from: f2, to: f3, stiffness: 1.2 MN/m}
    damping: {modal: 2 %}
connectors:
  storey_1: {from: frame.ground, to: frame.f1, law: bouc_wen, parameters: {k: 2e6, alpha: 0.3, beta: 80, gamma: 40, c: 3000}}
)",
          .excitations = {{"quake", "base_acceleration: all", "random: {rms: 2 m/s^2, band: [0.5, 15 Hz], seed: 9}"}},
          .sensors = {{"floor_1", "acceleration: frame.f1", "m/s^2"},
                      {"floor_2", "acceleration: frame.f2", "m/s^2"},
                      {"floor_3", "acceleration: frame.f3", "m/s^2"}},
          .noise = 0.03,
          .simulate = "tolerance: 1e-4",
          .duration = 20.0,
          .sample_rate = 200.0,
          .estimate = R"(estimate:
  unknown:
    storey_1.k: {initial: 1.7e6, std: 30 %}
    frame.storey_2.stiffness: {initial: 1.9 MN/m, std: 30 %}
  settle: 1 s
)"};
}

CaseFamily vehicle_family() {
  std::ifstream file(source_folder() + "/examples/vehicle/vehicle.yaml");
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  const auto begin = text.find("substructures:"), end = text.find("excitation:");
  CaseFamily family{
      .name = "vehicle",
      .structure =
          with(text.substr(begin, end - begin),
               {{"${MESH:-frame.msh}", source_folder() + "/examples/vehicle/small.msh"}, {"${CUT_OFF:-300}", "150"}}),
      .noise = 0.15,
      .simulate = "reference: superelement, modes_up_to: 600 Hz, integrator: generalized_alpha, tolerance: 1e-3",
      .duration = 3.0,
      .sample_rate = 1000.0,
      .estimate = R"(estimate:
  unknown:
    suspension_2.mu_k1: {initial: 22 N, std: 50 %}
    suspension_2.mu_c1: {initial: 40 N, std: 50 %}
  process_noise: {acceleration: 0.0005 m/s^2/sqrt(Hz)}
  substeps: 2
  settle: 0.5 s
)"};
  for (int i = 1; i <= 4; ++i) {
    family.excitations.push_back({fmt::format("road_{}", i), fmt::format("base_displacement: wheel_{}.ground", i),
                                  fmt::format("random: {{rms: 2 mm, band: [0.5 Hz, 40 Hz], seed: {}}}", 10 + i)});
    family.sensors.push_back({fmt::format("a{}", i), fmt::format("acceleration: frame.p{}.z", i), "m/s^2",
                              ", chain: [{butterworth: {order: 4, low_pass: 80 Hz}}]"});
  }
  return family;
}

}  // namespace kalfem::test
