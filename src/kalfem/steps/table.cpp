// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/table.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>

namespace kalfem {

// Each in the folder of its step.
RunStep modes_step(), statics_step(), frequency_response_step(), record_step(), simulation_step(), updating_step(),
    correlation_step(), estimation_step(), validation_step(), prediction_step(), inference_step(), placement_step();

const std::vector<RunStep>& run_steps() {
  static const std::vector<RunStep> steps{modes_step(),       statics_step(),    frequency_response_step(),
                                          record_step(),      simulation_step(), updating_step(),
                                          correlation_step(), estimation_step(), validation_step(),
                                          prediction_step(),  inference_step(),  placement_step()};
  return steps;
}

const RunStep* find_step(std::string_view name) {
  const auto found = std::ranges::find(run_steps(), name, &RunStep::name);
  return found == run_steps().end() ? nullptr : &*found;
}

namespace {

bool contains(const std::vector<const RunStep*>& steps, const RunStep& step) {
  return std::ranges::find(steps, &step) != steps.end();
}

/// The step and, recursively, those with it.
void add_with(std::string_view name, std::vector<const RunStep*>& steps) {
  const RunStep* step = find_step(name);
  if (!step) throw std::invalid_argument("there is no step '" + std::string(name) + "'");
  if (contains(steps, *step)) return;
  steps.push_back(step);
  for (const auto other : step->with) add_with(other, steps);
}

}  // namespace

std::vector<const RunStep*> steps_of(std::string_view verb, const Study& study) {
  std::vector<const RunStep*> wanted, steps;
  if (verb == every_step)
    for (const auto& step : run_steps()) wanted.push_back(&step);
  else
    add_with(verb, wanted);
  const auto is_taken = [&](std::string_view name) {
    return std::ranges::find(steps, name, &RunStep::name) != steps.end();
  };
  for (const auto& step : run_steps()) {
    const bool takes = step.after.empty() ? contains(wanted, step) : std::ranges::any_of(step.after, is_taken);
    if (takes && step.run && step.asked_for(study)) steps.push_back(&step);
  }
  return steps;
}

std::vector<const RunStep*> verbs() {
  constexpr std::array<std::string_view, 10> listed{"modes",     "simulate", "estimate", "predict", "update",
                                                    "correlate", "infer",    "place",    "static",  "frf"};
  std::vector<const RunStep*> steps = steps_in_order(listed);
  std::erase_if(steps, [](const RunStep* step) { return !step->has_verb(); });
  return steps;
}

std::vector<const RunStep*> steps_in_order(std::span<const std::string_view> first) {
  std::vector<const RunStep*> steps;
  for (const auto name : first) steps.push_back(find_step(name));
  for (const auto& step : run_steps())
    if (!contains(steps, step)) steps.push_back(&step);
  return steps;
}

std::vector<const RunStep*> steps_that_ran(const StudyResults& results, std::span<const std::string_view> first) {
  std::vector<const RunStep*> steps = steps_in_order(first);
  std::erase_if(steps, [&](const RunStep* step) { return !step->ran(results); });
  return steps;
}

}  // namespace kalfem
