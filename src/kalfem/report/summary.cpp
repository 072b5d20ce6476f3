// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <array>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "kalfem/base/hash.hpp"
#include "kalfem/base/version.hpp"
#include "kalfem/page/json_number.hpp"
#include "kalfem/report/console_report.hpp"
#include "kalfem/report/data_files.hpp"
#include "kalfem/report/result_set.hpp"
#include "kalfem/steps/compared.hpp"
#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/steps/inference/outcome.hpp"
#include "kalfem/steps/table.hpp"

namespace kalfem {
using Json = nlohmann::ordered_json;

void drop_times(Json& json) {
  if (json.is_object()) {
    json.erase("seconds");
    json.erase("timing");
  }
  for (auto& item : json)
    if (item.is_structured()) drop_times(item);
}

namespace {

/// What all files of one run carry, so that files of two runs are told apart: 16 hexadecimal digits, a hash of the case
/// with all its defaults and of the numbers in its summary. Times that were taken are left out, and with them what an
/// earlier run left to a resumed one: the same run again has the same identity.
std::string run_identity(const Study& study, const Json& summary) {
  Json numbers = summary;
  drop_times(numbers);
  Hash hash;
  hash.add(study.resolved_case);
  hash.add(numbers.dump(-1, ' ', false, Json::error_handler_t::replace));
  return fmt::format("{:016x}", hash.value());
}

Json timing_summary(const Study& study, const StudyResults& results) {
  Json timing = {{"total_s", number(results.total_seconds)}};
  const PhaseTimes times = step_times(study, results);
  for (const auto& [step, seconds] : times.list()) timing[step + "_s"] = number(seconds);
  for (const auto& [part, seconds] : study.reduce_phases.list()) timing["reduce_split_s"][part] = number(seconds);
  if (const auto* estimation = results.find<EstimationOutcome>()) {
    const auto& outcome = *estimation;
    const auto steps = static_cast<double>(outcome.measurements.samples());
    timing["estimate_us_per_step"] = number(1e6 * outcome.result.time.filter() / steps);
    timing["real_time_factor"] = number(steps / outcome.measurements.sample_rate / outcome.result.time.filter());
    timing["estimate_split_s"] = {{"predict", number(outcome.result.time.predict)},
                                  {"update", number(outcome.result.time.update)},
                                  {"output", number(outcome.result.time.output)}};
    timing["first_answer"] = {{"after_s", number(outcome.first_answer_seconds)}};
  }
  if (const auto* inference = results.find<InferenceOutcome>())
    timing["infer_evaluations_from_earlier_run"] = inference->evaluations_before;
  return timing;
}

/// Without a state where nothing was compared.
Json verdict_summary(const StudyResults& results) {
  Json reasons = Json::array();
  for (const auto& reason : results.verdict.reasons())
    reasons.push_back(
        {{"code", reason.code}, {"subject", reason.subject}, {"text", reason.text}, {"remedy", reason.remedy}});
  return {{"state", has_verdict(results) ? Json(to_string(results.verdict.state())) : Json()}, {"reasons", reasons}};
}

/// Null where nothing was estimated.
Json second_thoughts_summary(const StudyResults& results) {
  const auto* estimation = results.find<EstimationOutcome>();
  return estimation ? Json(to_string(estimation->second_thoughts)) : Json();
}

/// What the steps add, in the order of the file; what other steps add comes after it.
constexpr std::array key_order{
    "model",      "warnings", "simulation",  "record",    "parameters", "inputs",     "hardly_known",
    "estimation", "events",   "frequencies", "smoothed",  "diagnosis",  "validation", "validation_record",
    "prediction", "updating", "correlation", "inference", "placement",  "statics",    "frequency_response"};

void add_steps(const Study& study, const StudyResults& results, Json& summary) {
  Json found = Json::object();
  std::vector<std::string> warnings = study.warnings;
  warnings.insert(warnings.end(), results.warnings.begin(), results.warnings.end());
  if (!warnings.empty()) found["warnings"] = warnings;
  for (const auto* step : steps_that_ran(results))
    if (step->summarise) step->summarise(study, results, found);
  for (const char* key : key_order)
    if (found.contains(key)) {
      summary[key] = std::move(found[key]);
      found.erase(key);
    }
  summary.update(found);
}

}  // namespace

Json summarise(const Study& study, const StudyResults& results) {
  Json summary = {{"kalfem", version},
                  {"run", ""},
                  {"case", std::filesystem::path(study.file).filename().string()},
                  {"title", study.title},
                  {"status", results.usable() ? "ok" : "unusable"},
                  {"message", results.why_unusable()},
                  {"second_thoughts", second_thoughts_summary(results)},
                  {"verdict", verdict_summary(results)}};
  add_steps(study, results, summary);
  if (results.identified)
    summary["identified"] = {{"file", "case.identified.yaml"}, {"notes", results.identified->notes}};
  if (results.proposed) summary["proposed"] = {{"file", "case.proposed.yaml"}, {"edits", results.proposed->edits}};
  for (const auto& [path, bytes, sha256] : data_files(study))
    summary["data"].push_back({{"file", path.string()}, {"bytes", bytes}, {"sha256", sha256}});
  summary["run"] = run_identity(study, summary);
  summary["timing"] = timing_summary(study, results);
  return summary;
}

}  // namespace kalfem
