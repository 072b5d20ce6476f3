// SPDX-License-Identifier: Apache-2.0
#include "casefile/sample_case.hpp"

#include "kalfem/yaml/map_schema.hpp"

namespace kalfem::sample {
namespace {

std::vector<Issue> validate(const RandomRoad& road) {
  if (road.band[0] < road.band[1]) return {};
  return {{{}, "the band is empty", "its first frequency must be below the second", "write [low, high]"}};
}

}  // namespace

Schema<Study> study_schema() {
  using namespace schema;
  const auto spring = Fields<Spring>()
                          .required("from", &Spring::from, text(), "one end")
                          .required("to", &Spring::to, text(), "other end")
                          .required("stiffness", &Spring::stiffness, number("N/m", Bounds::nonnegative()), "stiffness");
  const auto substructure =
      Fields<Substructure>()
          .required("masses", &Substructure::masses, named(number("kg", Bounds::positive())), "masses by name")
          .optional("springs", &Substructure::springs, list(mapping(spring)), "springs between the masses")
          .optional("modal", &Substructure::modal_damping, one_or_list(number("-", Bounds::between(0, 1))),
                    "damping ratio, for all modes or each");
  const auto connector =
      Fields<Connector>()
          .required("from", &Connector::from, located(text()), "first end")
          .required("law", &Connector::law, word({"linear", "saturating"}), "force of deformation and rate")
          .optional("parameters", &Connector::parameters, named(located(quantity())), "parameters of the law");
  const auto random =
      Fields<RandomRoad>()
          .required("rms", &RandomRoad::rms, number("m", Bounds::positive()), "root mean square")
          .required("band", &RandomRoad::band, tuple<2>(number("Hz", Bounds::nonnegative())), "from, to")
          .optional("seed", &RandomRoad::seed, seed(), "of the random numbers")
          .check([](const RandomRoad& road) { return validate(road); });
  const auto recorded = Fields<RecordedRoad>()
                            .required("file", &RecordedRoad::file, text(), "record")
                            .required("channel", &RecordedRoad::channel, text(), "column of the record");
  const auto excitation =
      Fields<Excitation>()
          .required("base_displacement", &Excitation::base_displacement, text(), "where the ground moves")
          .one_of(&Excitation::signal, when("random", mapping(random), "band-limited noise"), when(recorded));
  const auto simulation =
      Fields<Simulation>()
          .required("duration", &Simulation::duration, number("s", Bounds::positive()), "length of the record")
          .optional("sample_rate", &Simulation::sample_rate, number("Hz", Bounds::positive()), "of the record")
          .optional("method", &Simulation::method,
                    choice<Method>({{"newmark", Method::newmark, "average acceleration"},
                                    {"exact", Method::exact, "first-order hold"}}),
                    "time stepping")
          .optional("iterations", &Simulation::iterations, integer(1, 100), "at most")
          .optional("keep_states", &Simulation::keep_states, boolean(), "write every state")
          .optional("settling", &Simulation::settling, number("s", Bounds::nonnegative()), "left out of the errors");
  return mapping(Fields<Study>()
                     .optional("title", &Study::title, text(), "one line")
                     .required("substructures", &Study::substructures, named(mapping(substructure)), "linear parts")
                     .optional("connectors", &Study::connectors, named(mapping(connector)), "nonlinear parts")
                     .optional("excitation", &Study::excitation, named(mapping(excitation)), "what moves it")
                     .optional("simulate", &Study::simulation, mapping(simulation), "the reference"));
}

const std::string valid_text = R"(# a chain
title: "Chain: 2 DOF ${A:-with ${B:-a suspension}}"
substructures:
  wheel:
    masses: {w: 1500 g, 2: 1.5}
    springs: [{from: ground, to: w, stiffness: 20 kN/m}]
    modal: 1 %
  body: &body
    masses: {1: 1, 2: 2.0e0}
    modal: [0.01, 2 %]
  copy: {<<: *body, modal: []}
connectors:
  suspension: {from: wheel.w, law: saturating, parameters: {k: 5e3, mu: 20 N, c: 10 N s/m}}
excitation:
  road:
    base_displacement: wheel.ground
    random: {rms: 3 mm, band: [0.5, 30 Hz], seed: 18446744073709551615}
  other: {base_displacement: body.1, file: road.csv, channel: r1}
simulate:
  duration: 20
  method: exact
  settling: 0.1 s
)";

Study read(const std::string& text) {
  const Environment none = [](const std::string&) { return std::nullopt; };
  return read_case_text(text, "case.yaml", study_schema(), none);
}

std::string problems(const std::string& text) {
  try {
    read(text);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

}  // namespace kalfem::sample
