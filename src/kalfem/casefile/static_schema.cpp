// SPDX-License-Identifier: Apache-2.0
#include "kalfem/casefile/case_schema.hpp"
#include "kalfem/yaml/map_schema.hpp"

namespace kalfem::description {

using namespace schema;

namespace {

/// A load case without any load is probably an unfinished one.
std::vector<Issue> check_loaded(const StaticCase& given) {
  const bool weightless = given.gravity == std::array<double, 3>{} && !given.rotation;
  if (!given.forces.empty() || !given.pressures.empty() || !given.displacements.empty() || !weightless) return {};
  return {{{},
           "the load case has no load",
           "nothing would happen",
           "give `forces`, `pressures`, `gravity`, `rotation` or `displacements`"}};
}

Schema<StaticCase> static_case() {
  const auto force =
      Fields<StaticForce>()
          .required(
              "at", &StaticForce::at, name(),
              "one of `nodes`, a node number, or a group: the load is spread evenly over its lines or surfaces, or "
              "shared equally by its nodes")
          .optional("force", &StaticForce::force, tuple<3>(number("N")), "force along x, y, z, of the whole group")
          .optional("moment", &StaticForce::moment, tuple<3>(number("N m")), "moment about x, y, z, of the whole group")
          .check([](const StaticForce& given) -> std::vector<Issue> {
            if (given.force != std::array<double, 3>{} || given.moment != std::array<double, 3>{}) return {};
            return {{{}, "the load is zero", "it has no effect", "give `force` or `moment`"}};
          });
  const auto pressure =
      Fields<StaticPressure>()
          .required("on", &StaticPressure::on, name(),
                    "region of shells, group of surfaces on solids, or group of nodes that holds whole faces")
          .required("pressure", &StaticPressure::pressure, number("Pa"),
                    "pushes into solids, and against the normal of shells (their nodes by the right-hand rule)")
          .check([](const StaticPressure& given) -> std::vector<Issue> {
            if (given.pressure != 0.0) return {};
            return {{{}, "the pressure is zero", "it has no effect", "give `pressure`, or leave it out"}};
          });
  const auto rotation =
      Fields<StaticRotation>()
          .required("axis", &StaticRotation::axis, tuple<3>(number("-")), "direction of the axis")
          .optional("about", &StaticRotation::about, tuple<3>(number("m")), "a point of the axis; default: the origin")
          .required("speed", &StaticRotation::speed, number("rad/s"), "angular velocity: 100 rad/s, 3000 rpm")
          .check([](const StaticRotation& given) -> std::vector<Issue> {
            if (given.axis != std::array<double, 3>{} && given.speed != 0.0) return {};
            return {{{}, "the rotation has no axis or no speed", "it has no effect", "give both, or leave it out"}};
          });
  return mapping(Fields<StaticCase>()
                     .optional("forces", &StaticCase::forces, list(mapping(force)), "forces and moments")
                     .optional("pressures", &StaticCase::pressures, list(mapping(pressure)), "pressures on surfaces")
                     .optional("gravity", &StaticCase::gravity, tuple<3>(number("m/s^2")),
                               "acceleration of the field: [0, 0, -9.81]; each mass m weighs m g")
                     .optional("rotation", &StaticCase::rotation, mapping(rotation),
                               "steady rotation, seen from axes that turn: centrifugal forces; as a preload also their "
                               "growth with the displacement")
                     .optional("displacements", &StaticCase::displacements, named(value(), NameRule::dotted),
                               "imposed displacements and rotations: {tip.z: 1 mm}")
                     .check(check_loaded));
}

}  // namespace

Schema<Statics> statics() {
  return mapping(
      Fields<Statics>()
          .required("substructure", &Statics::substructure, name(), "finite-element substructure that is loaded")
          .optional("cases", &Statics::cases, named(located(static_case())), "load cases by names of your own")
          .optional("deck_cases", &Statics::deck_cases, located(boolean()),
                    "the load cases of the deck too, by its names: step1, subcase2")
          .optional("points", &Statics::points, one_or_list(name()),
                    "named nodes whose displacement and stress are reported; default: all `nodes`")
          .check([](const Statics& given) -> std::vector<Issue> {
            if (!given.cases.empty() || given.deck_cases.value) return {};
            return {{{}, "there is no load case", "nothing would be solved", "give `cases`, or `deck_cases: true`"}};
          }));
}

}  // namespace kalfem::description
