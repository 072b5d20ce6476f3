// SPDX-License-Identifier: Apache-2.0
#include "casefile/probes.hpp"

#include "kalfem/steps/placement/outcome.hpp"
#include "kalfem/study/study.hpp"

/// Keys of the placement of sensors: its plan, and what they do to the choice.
namespace kalfem::wiring {
namespace {

const std::string floors = "floors: {acceleration: [s.a, s.b], noise: 5 %}", one = "count: 1";

Study with_place(const std::string& text, const Sections& more = {}) {
  Sections sections{
      {"place", "{" + text + "}"},
      {"estimate", "{unknown: {c.k: {initial: 400 N/m, std: 100 N/m}, c.c: {initial: 2, std: 0.5}}, settle: 0.1 s}"}};
  for (const auto& [key, value] : more) sections[key] = value;
  return study_of(estimated_case(sections));
}

PlacementPlan plan_of(const std::string& text, const Sections& more = {}) {
  return with_place(text, more).placement.value();
}

PlacementPlan plan_of_group(const std::string& group) { return plan_of("candidates: {g: {" + group + "}}, " + one); }

PlacementOutcome placed(const std::string& text, const Sections& more = {}) {
  return run(with_place(text, more), "place").get<PlacementOutcome>();
}

std::vector<std::string> names_of(const PlacementPlan& plan) {
  std::vector<std::string> names;
  for (const auto& candidate : plan.candidates) names.push_back(candidate.name);
  return names;
}

using Names = std::vector<std::string>;

void points_and_quantities() {
  for (const auto& [key, quantity] : {std::pair{"acceleration", ObservedQuantity::acceleration},
                                      {"velocity", ObservedQuantity::velocity},
                                      {"displacement", ObservedQuantity::displacement}}) {
    const auto plan = plan_of_group(key + std::string(": [s.b, s.a], noise: 5 %"));
    EXPECT_EQ(names_of(plan), (Names{"s.b", "s.a"}));
    const auto& output = plan.candidates.at(0).channels.at(0).output;
    EXPECT_EQ(output.quantity, quantity);
    EXPECT_EQ(output.points, (DofCombination{{"s.b", 1.0}}));
  }
  EXPECT_EQ(names_of(plan_of_group("velocity: all, noise: 5 %")), (Names{"s.a", "s.b"}));
  const auto both = plan_of("candidates: {" + floors + ", gauges: {displacement: s.b, noise: 1 mm}}, " + one);
  EXPECT_EQ(names_of(both), (Names{"s.a", "s.b acceleration", "s.b displacement"}));
}

void noise() {
  const auto relative = plan_of_group("acceleration: s.a, noise: 5 %").candidates[0].channels[0];
  EXPECT_TRUE(relative.relative_noise);
  near(relative.noise, 0.05);
  const auto absolute = plan_of_group("displacement: s.a, noise: 2 mm").candidates[0].channels[0];
  EXPECT_FALSE(absolute.relative_noise);
  near(absolute.noise, 0.002);
}

const Sections beam_places{{"estimate", "{unknown: {b.steel.youngs_modulus: {initial: 200 GPa, std: 10 %}}}"}};

PlacementPlan beam_plan(const std::string& group) {
  Sections sections = beam_case(beam_places);
  sections["place"] = "{candidates: {g: {" + group + ", noise: 5 %}}, count: 1}";
  return study_of(sections).placement.value();
}

void directions_of_a_node() {
  EXPECT_EQ(names_of(beam_plan("acceleration: b.tip")), (Names{"b.tip.x", "b.tip.y", "b.tip.z"}));
  EXPECT_EQ(names_of(beam_plan("acceleration: b.tip.z")), (Names{"b.tip.z"}));
  const auto together = beam_plan("acceleration: [b.tip, b.mid], triaxial: true");
  EXPECT_EQ(names_of(together), (Names{"b.tip", "b.mid"}));
  ASSERT_EQ(together.candidates[0].channels.size(), 3u);
  EXPECT_EQ(together.candidates[0].channels[2].name, "b.tip.z");
  EXPECT_EQ(together.places[0].substructure, "b");
  EXPECT_EQ(together.places[0].node, 2);
  EXPECT_EQ(names_of(beam_plan("acceleration: all, triaxial: true")), (Names{"b.mid", "b.tip"}));
}

/// Nodes lie at 0 (held), 0.5 and 1 m.
void spacing_of_a_region() {
  EXPECT_EQ(names_of(beam_plan("acceleration: b.bar.z")), (Names{"b.mid.z", "b.tip.z"}));
  EXPECT_EQ(names_of(beam_plan("acceleration: b.bar.z, spacing: 400 mm")), (Names{"b.mid.z", "b.tip.z"}));
  EXPECT_EQ(names_of(beam_plan("acceleration: b.bar.z, spacing: 600 mm")), (Names{"b.tip.z"}));
}

void number_of_sensors() {
  EXPECT_EQ(plan_of("candidates: {" + floors + "}, count: 2").options.sensors, 2u);
  EXPECT_EQ(placed("candidates: {" + floors + "}, count: 2").placement.best().candidates.size(), 2u);
}

void parameters_that_count() {
  const auto all = plan_of("candidates: {" + floors + "}, " + one);
  EXPECT_EQ(all.unknowns, (Names{"c.k", "c.c"}));
  EXPECT_EQ(all.counted, 2u);
  near(all.options.scale, vector({100.0, 0.5}));
  const auto chosen = plan_of("candidates: {" + floors + "}, parameters: c.c, " + one);
  EXPECT_EQ(chosen.unknowns, (Names{"c.c", "c.k"}));
  EXPECT_EQ(chosen.counted, 1u);
  near(chosen.options.prior_deviation, vector({0.5}));
  // The other unknown stays unknown: the deviation is that of both.
  const std::string both = "candidates: {" + floors + "}, count: 2";
  near(placed(both + ", parameters: c.c").best[0].bound[0], placed(both).best[0].bound[1], many_roundings);
  const auto drifting = plan_of("candidates: {" + floors + "}, " + one,
                                {{"estimate",
                                  "{unknown: {c.k: {initial: 400, std: 100, random_walk: 1}, c.c: "
                                  "{initial: 2, std: 0.5}}}"}});
  EXPECT_EQ(drifting.unknowns, (Names{"c.c"}));
}

void sensors_that_stay() {
  const std::string kept = "candidates: {g: {displacement: all, noise: 0.1 mm}}, keep: y, " + one;
  const auto plan = plan_of(kept);
  EXPECT_EQ(plan.options.fixed, (Names{"y"}));
  EXPECT_EQ(plan.options.sensors, 2u);
  EXPECT_EQ(names_of(plan), (Names{"y", "s.a"}));  // y measures s.b already
  near(plan.candidates[0].channels[0].noise, 1e-4);
  const auto outcome = placed(kept);
  EXPECT_EQ(outcome.placement.sets.size(), 1u);
  EXPECT_TRUE(outcome.candidates[0].kept);
  EXPECT_FALSE(outcome.candidates[0].rank);
}

void criteria() {
  using enum PlacementCriterion;
  for (const auto& [word, criterion] : {std::pair{"determinant", d_optimality},
                                        {"trace", a_optimality},
                                        {"smallest_eigenvalue", e_optimality},
                                        {"deviation", expected_deviation},
                                        {"information", mutual_information}})
    EXPECT_EQ(plan_of("candidates: {" + floors + "}, criterion: " + word + ", " + one).options.criterion, criterion);
  EXPECT_EQ(plan_of("candidates: {" + floors + "}, " + one).options.criterion, d_optimality);
}

void draws_and_their_seed() {
  const auto criterion = [](const std::string& more) {
    return placed("candidates: {" + floors + "}, criterion: deviation, " + one + more).best[0].criterion;
  };
  EXPECT_EQ(plan_of("candidates: {" + floors + "}, " + one).draws, 1);
  EXPECT_EQ(plan_of("candidates: {" + floors + "}, draws: 3, seed: 8, " + one).seed, 8u);
  EXPECT_EQ(criterion(", draws: 3"), criterion(", draws: 3, seed: 1"));
  EXPECT_NE(criterion(", draws: 3"), criterion(", draws: 3, seed: 2"));
  EXPECT_NE(criterion(", draws: 3"), criterion(""));
  EXPECT_EQ(criterion(", seed: 2"), criterion(""));
}

void enumeration() {
  EXPECT_TRUE(placed("candidates: {" + floors + "}, " + one).placement.exact);
  EXPECT_FALSE(placed("candidates: {" + floors + "}, largest_enumeration: 1, " + one).placement.exact);
}

}  // namespace

KeyChecks placement_keys() {
  return {{"place.candidates.*.acceleration", points_and_quantities},
          {"place.candidates.*.velocity", points_and_quantities},
          {"place.candidates.*.displacement", points_and_quantities},
          {"place.candidates.*.noise", noise},
          {"place.candidates.*.triaxial", directions_of_a_node},
          {"place.candidates.*.spacing", spacing_of_a_region},
          {"place.count", number_of_sensors},
          {"place.parameters", parameters_that_count},
          {"place.keep", sensors_that_stay},
          {"place.criterion", criteria},
          {"place.draws", draws_and_their_seed},
          {"place.seed", draws_and_their_seed},
          {"place.largest_enumeration", enumeration}};
}

}  // namespace kalfem::wiring
