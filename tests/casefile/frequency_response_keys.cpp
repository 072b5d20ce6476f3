// SPDX-License-Identifier: Apache-2.0
#include <numbers>

#include "casefile/probes.hpp"

#include "kalfem/steps/frequency_response/outcome.hpp"
#include "kalfem/study/study.hpp"

/// Keys of frequency responses.
namespace kalfem::wiring {
namespace {

/// The two masses of lumped_case, or the cantilever of beam_case, with these keys in the place of the usual ones.
std::string section(std::map<std::string, std::string> keys, const std::string& input, const std::string& output) {
  keys.insert({{"frequencies", "[1 Hz, 2 Hz]"}, {"inputs", "[" + input + "]"}, {"outputs", "[" + output + "]"}});
  std::string text;
  for (const auto& [key, value] : keys) text += (text.empty() ? "" : ", ") + key + ": " + value;
  return "{" + text + "}";
}

Study lumped(const std::map<std::string, std::string>& keys) {
  return study_of(lumped_case({{"frequency_response", section(keys, "s.b", "{displacement: s.a}")}}));
}

Study beam(const std::map<std::string, std::string>& keys) {
  return study_of(beam_case({{"frequency_response", section(keys, "b.mid.z", "{displacement: b.tip.z}")}}));
}

/// The cantilever under a force at its tip, with a gauge at its upper fibre amid the first element.
Study with_gauge(const std::map<std::string, std::string>& keys) {
  const std::string part = beam_elements("gauges: {g: {element: 1, fibre: [0, 10 mm]}}");
  return study_of(beam_case({{"substructures", "{b: {finite_elements: {" + part + "}}}"},
                             {"frequency_response", section(keys, "b.tip.z", "{strain: b.g}")}}));
}

FrequencyResponseOutcome outcome_of(const Study& study) { return run(study, "frf").get<FrequencyResponseOutcome>(); }

void lines() {
  near(lumped({{"frequencies", "[3, 2 kHz]"}}).frequency_response->frequencies, vector({3.0, 2000.0}));
  const auto band = [](const std::string& more) {
    return lumped({{"frequencies", "{from: 1 Hz, to: 100 Hz" + more + "}"}}).frequency_response->frequencies;
  };
  EXPECT_EQ(band("").size(), 400);
  near(band(", lines: 4"), vector({1.0, 34.0, 67.0, 100.0}));
  near(band(", lines: 3, spacing: logarithmic"), vector({1.0, 10.0, 100.0}));
}

/// Static responses: a force at b moves a by 1 / k, the ground carries both masses along.
void inputs_and_outputs() {
  const auto outcome = outcome_of(lumped({{"frequencies", "[0 Hz]"},
                                          {"inputs", "[s.b, s.ground]"},
                                          {"outputs", "[{displacement: s.a}, {velocity: s.b}, {displacement: s.b}]"}}));
  ASSERT_EQ(outcome.responses.size(), 6u);
  const auto value = [&](std::size_t i) { return outcome.responses[i].full[0].real(); };
  EXPECT_EQ(outcome.responses[0].name, "s.a per force at s.b");
  EXPECT_EQ(outcome.responses[0].unit, "m/N");
  near(value(0), 1.0 / 800.0);
  EXPECT_EQ(outcome.responses[1].output, "s.b");
  near(value(1), 1.0 / 800.0 + 1.0 / 500.0);
  EXPECT_EQ(outcome.responses[2].quantity, "velocity");
  EXPECT_EQ(value(2), 0.0);
  EXPECT_EQ(outcome.responses[3].name, "s.a per motion of s.ground");
  EXPECT_EQ(outcome.responses[3].unit, "m/m");
  near(value(3), 1.0);
}

void accelerations() {
  const auto outcome =
      outcome_of(lumped({{"outputs", "[{displacement: s.a}, {acceleration: s.a}]"}, {"frequencies", "[2 Hz]"}}));
  const double omega = 4.0 * std::numbers::pi;
  const auto expected = -omega * omega * outcome.responses[0].full[0];
  EXPECT_LT(std::abs(outcome.responses[1].full[0] - expected), many_roundings * std::abs(expected));
}

/// Bending of the cantilever by a slow force at its tip: epsilon = F (L - x) e / E I at the middle of the first
/// element, 0.5 m long.
void strains() {
  const auto outcome = outcome_of(with_gauge({{"frequencies", "[0 Hz]"}}));
  const double diameter = 0.02, inertia = std::numbers::pi * std::pow(diameter, 4) / 64.0;
  EXPECT_EQ(outcome.responses[0].quantity, "strain");
  EXPECT_EQ(outcome.responses[0].unit, "(m/m)/N");
  near(outcome.responses[0].full[0].real(), -0.01 * 0.75 / (210e9 * inertia), 1e-6);
}

void models() {
  const auto full = outcome_of(beam({})), reduced = outcome_of(beam({{"model", "reduced"}})),
             both = outcome_of(beam({{"model", "both"}}));
  EXPECT_TRUE(full.full && !full.reduced && !reduced.full && reduced.reduced && both.full && both.reduced);
  EXPECT_EQ(full.full->dofs, 12);
  EXPECT_EQ(full.responses[0].reduced.size(), 0);
  EXPECT_EQ(reduced.responses[0].full.size(), 0);
  EXPECT_FALSE(full.responses[0].difference);
  ASSERT_TRUE(both.responses[0].difference);
  // far below the first mode, at 14 Hz: the middle, at which the force acts, keeps its constraint mode
  EXPECT_LT(both.responses[0].difference->between.value(), 1e-6);
}

void methods() {
  const auto modal = lumped({{"method", "modal"}}), direct = lumped({{"method", "direct"}});
  EXPECT_EQ(modal.frequency_response->method, ResponseMethod::modal);
  EXPECT_EQ(direct.frequency_response->method, ResponseMethod::direct);
  const auto a = outcome_of(modal).responses[0].full, b = outcome_of(direct).responses[0].full;
  EXPECT_LT((a - b).norm(), many_roundings * b.norm());
}

/// Alone, the mass b has no connector to the rest and moves freely.
void substructure() {
  const auto outcome =
      outcome_of(lumped({{"substructure", "s"}, {"inputs", "[s.b]"}, {"outputs", "[{acceleration: s.b}]"}}));
  near(outcome.responses[0].full[0].real(), 1.0 / 3.0, many_roundings);
}

}  // namespace

KeyChecks frequency_response_keys() {
  const std::string section = "frequency_response.";
  return {{section + "frequencies.from", lines},
          {section + "frequencies.to", lines},
          {section + "frequencies.lines", lines},
          {section + "frequencies.spacing", lines},
          {section + "inputs", inputs_and_outputs},
          {section + "outputs[].displacement", inputs_and_outputs},
          {section + "outputs[].velocity", inputs_and_outputs},
          {section + "outputs[].acceleration", accelerations},
          {section + "outputs[].strain", strains},
          {section + "model", models},
          {section + "method", methods},
          {section + "substructure", substructure}};
}

}  // namespace kalfem::wiring
