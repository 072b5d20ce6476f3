// SPDX-License-Identifier: Apache-2.0
// Cost of updating, as ratios within one run (medians of alternating repetitions):
//   the chain: one evaluation of the residual of its record against the simulation / one simulation of the same case;
//   the vehicle: one iteration of the loop / (one reduction + one filter pass + one prediction, timed alone).
// Usage: updating_benchmark CHAIN.yaml VEHICLE.yaml, both with `update`
#include <algorithm>
#include <cstdio>
#include <vector>

#include "kalfem/dynamics/simulate.hpp"
#include "kalfem/identification/driven_substructure.hpp"
#include "kalfem/identification/initial_state.hpp"
#include "kalfem/identification/record_residual.hpp"
#include "kalfem/identification/simulation_residual.hpp"
#include "kalfem/steps/field_series.hpp"
#include "kalfem/steps/run_study.hpp"
#include "timing.hpp"

namespace {

using namespace kalfem;
using namespace kalfem::benchmarks;
using Eigen::Index;
using Eigen::VectorXd;

std::vector<std::string> names_of(const std::vector<Sensor>& sensors) {
  std::vector<std::string> names;
  for (const auto& sensor : sensors) names.push_back(sensor.name);
  return names;
}

/// A simulation of the structure as it is, with the sensors, at the residual's own step.
void simulate_once(const Study& study, const CoupledModel& model, Index substeps) {
  std::vector<OutputDescription> outputs;
  for (const auto& sensor : study.sensors) outputs.push_back(sensor.output);
  SimulationOptions options;
  options.integrator = Integrator::exact;
  options.step = 1.0 / (study.sample_rate() * static_cast<double>(substeps));
  options.duration = study.simulation->duration;
  options.keep_motion = false;
  options.every_step = make_outputs(model, outputs);
  simulate(model.system(), study.structure->signals, initial_state(study.simulation->initial, model), options);
}

void time_simulation_residual(const Study& study, const Record& record) {
  const auto& structure = study.updating_plan->structure;
  const SimulationResidual::Options options{.name = "record"};
  const SimulationResidual residual(study.structure, study.sensors, record, structure, study.updating->parameters,
                                    options);
  const VectorXd start = initial_values(study.updating->parameters);
  const CoupledModel model = couple(structure->at(start).parts);
  std::vector<double> evaluations, simulations;
  for (int repetition = 0; repetition < 9; ++repetition) {
    evaluations.push_back(seconds([&] { return residual.evaluate(start, false); }));
    simulations.push_back(seconds([&] { simulate_once(study, model, options.substeps); }));
  }
  line("one simulation", 1e3 * median(simulations), "ms");
  line("one evaluation of the residual", 1e3 * median(evaluations), "ms");
  line("  ratio (at most 1.3)", median(evaluations) / median(simulations), "");
}

/// Parts of an iteration, each timed alone: seconds of the reduction, the filter pass and the prediction.
struct SectionParts {
  double reduction = 0.0, filter = 0.0, prediction = 0.0;
  [[nodiscard]] double sum() const { return reduction + filter + prediction; }
};

SectionParts time_parts(const RecordResidual& residual, const ParameterisedStructure& structure,
                        const VectorXd& start) {
  SectionParts parts;
  StructureAtParameters here;
  parts.reduction = seconds([&] { here = structure.at(start); });
  RecordResidual::Estimate estimate;
  parts.filter = seconds([&] { estimate = *residual.estimate_at(here.parts, start, false); });
  parts.prediction = seconds([&] { return residual.predict_from(estimate); });
  return parts;
}

void time_iterations(const Study& study, const Record& record, int repetitions) {
  const auto& structure = study.updating_plan->structure;
  auto options = std::get<RecordResidual::Options>(study.updating_plan->record_comparisons.front().what);
  options.sensors = names_of(study.sensors);
  const RecordResidual residual(study.problem, record, structure, *study.updating, options);
  const VectorXd start = initial_values(study.updating->parameters);
  std::vector<double> first, later, reductions, filters, predictions, sums;
  for (int repetition = 0; repetition < repetitions; ++repetition) {
    const SectionParts parts = time_parts(residual, *structure, start);
    reductions.push_back(parts.reduction);
    filters.push_back(parts.filter);
    predictions.push_back(parts.prediction);
    sums.push_back(parts.sum());
    first.push_back(seconds([&] { return residual.evaluate(start, true); }));
    later.push_back(seconds([&] { return residual.evaluate(start, false); }));
  }
  line("one reduction", median(reductions), "s");
  line("one filter pass", median(filters), "s");
  line("one prediction", median(predictions), "s");
  line("one iteration with its derivatives", median(first), "s");
  line("  ratio to the three (at most 1.2)", median(first) / median(sums), "");
  line("one iteration without derivatives", median(later), "s");
  line("  ratio to the three", median(later) / median(sums), "");
}

Record simulated_record(const Study& study) { return record_of(study, run_study(study, "simulate")); }

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: updating_benchmark CHAIN.yaml VEHICLE.yaml\n");
    return 2;
  }
  try {
    const Study chain = load_study(argv[1]);
    std::printf("Chain: %zu parameters, %g s\n", chain.updating->parameters.size(), chain.simulation->duration);
    const Record chain_record = simulated_record(chain);
    time_simulation_residual(chain, chain_record);
    time_iterations(chain, chain_record, 5);
    const Study vehicle = load_study(argv[2]);
    std::printf("\nVehicle: %zu parameters, %g s\n", vehicle.updating->parameters.size(), vehicle.simulation->duration);
    time_iterations(vehicle, simulated_record(vehicle), 3);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
  return 0;
}
