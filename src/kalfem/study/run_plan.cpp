// SPDX-License-Identifier: Apache-2.0
#include "kalfem/study/run_plan.hpp"

#include "kalfem/casefile/description.hpp"

namespace kalfem {

SimulationPlan make_simulation_plan(const description::Simulation& given) {
  SimulationPlan plan{.duration = given.duration, .sample_rate = given.sample_rate};
  plan.integration.integrator = given.integrator;
  plan.integration.duration = given.duration;
  plan.integration.hht_alpha = given.hht_alpha;
  plan.integration.spectral_radius = given.spectral_radius;
  plan.convergence = {.sample_rate = given.sample_rate,
                      .first_substeps = given.substeps ? given.substeps->value : given.first_substeps,
                      .max_substeps = given.substeps ? given.substeps->value : given.max_substeps,
                      .tolerance = given.tolerance,
                      .refine = !given.substeps};
  plan.initial = given.initial;
  plan.seed = given.seed;
  return plan;
}

PredictionPlan make_prediction_plan(const description::Prediction& given) {
  return {given.substructure, given.substeps};
}

ReportPlan make_report_plan(const description::Report& given) {
  ReportPlan plan{.modes = given.modes,
                  .frequencies = given.frequencies,
                  .zoom = given.zoom,
                  .superelements = given.superelements.value};
  if (given.fields) plan.pictures = PicturePlan{given.fields->substructure.value, given.fields->every};
  for (const auto& point : given.displacements) plan.displacements.push_back(point.value);
  for (const auto& gauge : given.strains) plan.strains.push_back(gauge.value);
  return plan;
}

}  // namespace kalfem
