// SPDX-License-Identifier: Apache-2.0
#include "kalfem/analysis/expressible.hpp"

#include <algorithm>

#include "kalfem/casefile/case_schema.hpp"

namespace kalfem {
namespace {

namespace d = description;

/// Keys of `estimate` that EstimateOptions has a member for.
const std::vector<std::string> expressed{
    "filter",        "unknown",       "initial_state",   "initial_state_from_record",
    "settle",        "process_noise", "known_to",        "initial_connector_states",
    "passes",        "substeps",      "step_order",      "estimate_initial_state",
    "threads",       "diagnose",      "second_thoughts", "free",
    "adaptive_noise"};

void refuse(const d::Case& given, const std::vector<std::string>& key, IssueList& issues) {
  std::string path;
  for (const auto& part : key) path += (path.empty() ? "" : ".") + part;
  issues.add(given.source.at(key), path + " has no word in the options of the library",
             "what a program gets would not be what the case says", "leave it out, or run the case file");
}

/// Keys whose values are not the defaults.
std::vector<std::string> changed_keys(const d::Estimation& given) {
  static const auto schema = d::estimation();
  const auto written = schema.write(given), before = schema.write(d::Estimation{});
  std::vector<std::string> keys;
  for (const auto& entry : written->entries) {
    const auto* was = before->find(entry.key);
    if (!was || to_yaml(*was->value) != to_yaml(*entry.value)) keys.push_back(entry.key);
  }
  return keys;
}

/// UpdateOptions compare natural frequencies, and search from one start by least squares.
void require_expressible_update(const d::Case& given, IssueList& issues) {
  const auto& update = *given.update;
  if (update.method != UpdatingMethod::least_squares) refuse(given, {"update", "method"}, issues);
  if (update.starts != 1) refuse(given, {"update", "starts"}, issues);
  if (!update.alternatives.empty()) refuse(given, {"update", "alternatives"}, issues);
  for (const auto& [name, parameter] : update.parameters)
    if (!parameter.value.applies_to.empty()) refuse(given, {"update", "parameters", name, "applies_to"}, issues);
  for (const auto& [name, comparison] : update.comparisons) {
    const auto* modes = std::get_if<d::ModalData>(&comparison.value.data);
    if (!modes)
      refuse(given, {"update", "compare", name}, issues);
    else if (std::holds_alternative<d::ModeFile>(modes->measured))
      refuse(given, {"update", "compare", name, "file"}, issues);
    else if (std::get<d::ListedModes>(modes->measured).shapes)
      refuse(given, {"update", "compare", name, "shapes"}, issues);
    else if (std::get<d::ListedModes>(modes->measured).dampings)
      refuse(given, {"update", "compare", name, "dampings"}, issues);
  }
}

}  // namespace

void require_expressible(const Study& study) {
  const d::Case& given = *study.description;
  IssueList issues;
  if (study.record && study.record->free_response && study.record->free_response->rest_is_unknown())
    refuse(given, {"record", "free_response", "rest_std"}, issues);
  for (const auto& [name, excitation] : given.excitation)
    if (excitation.unknown) refuse(given, {"excitation", name, "unknown"}, issues);
  if (given.estimate) {
    for (const auto& key : changed_keys(*given.estimate))
      if (std::ranges::find(expressed, key) == expressed.end()) refuse(given, {"estimate", key}, issues);
    if (!given.estimate->process_noise.accelerations.empty())
      refuse(given, {"estimate", "process_noise", "accelerations"}, issues);
  }
  if (given.update) require_expressible_update(given, issues);
  issues.raise();
}

std::vector<std::string> sections_left_out(const d::Case& given) {
  static const std::vector<std::string> held{"kalfem",    "title",    "substructures", "connectors", "joints",
                                             "component", "damping",  "excitation",    "sensors",    "simulate",
                                             "record",    "estimate", "update"};
  std::vector<std::string> sections;
  if (given.source.root())
    for (const auto& entry : given.source.root()->entries)
      if (std::ranges::find(held, entry.key) == held.end()) sections.push_back(entry.key);
  return sections;
}

}  // namespace kalfem
