// SPDX-License-Identifier: Apache-2.0
#include "kalfem/report/finished/finished_run.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "kalfem/base/regular_file.hpp"
#include "kalfem/base/version.hpp"

namespace kalfem {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

std::optional<double> number_in(const Json& object, const char* key) {
  const auto found = object.find(key);
  return found == object.end() || found->is_null() ? std::nullopt : std::optional(found->get<double>());
}

std::string text_in(const Json& object, const char* key) { return object.value(key, std::string()); }

std::vector<std::string> texts_in(const Json& object, const char* key) {
  return object.value(key, std::vector<std::string>());
}

/// The object behind the key, an empty one if the step did not run.
Json object_in(const Json& object, const char* key) {
  const auto found = object.find(key);
  return found == object.end() || found->is_null() ? Json::object() : *found;
}

FoundParameter parameter_of(const std::string& name, const Json& json) {
  FoundParameter parameter{name,
                           text_in(json, "unit"),
                           number_in(json, "true"),
                           number_in(json, "initial"),
                           number_in(json, json.contains("mean") ? "mean" : "estimate"),
                           number_in(json, "std"),
                           number_in(json, "std_robust"),
                           {},
                           json.value("interval_95_from", std::string("std"))};
  const auto interval = json.find("interval_95");
  if (interval == json.end() || !interval->is_array()) return parameter;
  const Json &lower = interval->at(0), &upper = interval->at(1);
  if (lower.is_number() && upper.is_number()) parameter.interval = {lower.get<double>(), upper.get<double>()};
  return parameter;
}

/// The 95 % interval of a posterior stands among its quantiles.
FoundParameter inferred_parameter_of(const std::string& name, const Json& json) {
  FoundParameter parameter = parameter_of(name, json);
  const Json prior = object_in(json, "prior"), quantiles = object_in(json, "quantiles");
  parameter.initial = number_in(prior, "mean");
  const auto lower = number_in(quantiles, "2.5%"), upper = number_in(quantiles, "97.5%");
  if (lower && upper) parameter.interval = {*lower, *upper};
  parameter.interval_from = "posterior";
  return parameter;
}

template <class Read>
void add_parameters(std::string by, const Json& json, const Read& read, FinishedRun& run) {
  FoundParameters found{std::move(by), {}};
  for (const auto& [name, parameter] : json.items()) found.parameters.push_back(read(name, parameter));
  if (!found.parameters.empty()) run.found.push_back(std::move(found));
}

FoundFilter filter_of(const Json& estimation, const Json& timing) {
  const Json& nis = estimation.at("nis");
  return {estimation.at("filter"),
          text_in(estimation, "filter_reason"),
          estimation.at("steps"),
          estimation.at("state_dimension"),
          estimation.value("substeps", 1),
          {number_in(nis, "mean"), number_in(nis, "expected"), number_in(nis, "fraction_in_95")},
          number_in(timing, "estimate_us_per_step"),
          number_in(timing, "real_time_factor")};
}

/// "displacement_nrmse" of each point, without the ending that all keys share.
Named<NamedErrors> errors_by_point(const Json& points) {
  constexpr std::string_view ending = "_nrmse";
  Named<NamedErrors> errors;
  for (const auto& [point, quantities] : points.items()) {
    NamedErrors& own = errors.emplace_back(point, NamedErrors{}).second;
    for (const auto& [key, value] : quantities.items()) {
      std::string name = key;
      if (const auto at = name.find(ending); at != std::string::npos) name.erase(at, ending.size());
      std::ranges::replace(name, '_', ' ');
      own.emplace_back(name, value.is_null() ? std::nullopt : std::optional(value.get<double>()));
    }
  }
  return errors;
}

/// Errors of the driven substructures; modifications, which have natural frequencies only, are left out.
Named<NamedErrors> prediction_of(const Json& prediction) {
  Named<NamedErrors> errors;
  for (const auto& [substructure, points] : prediction.items()) {
    if (points.contains("frequencies_hz")) continue;
    for (auto& [point, own] : errors_by_point(points)) errors.emplace_back(substructure + "." + point, std::move(own));
  }
  return errors;
}

Named<NamedErrors> validation_of(const Json& validation) {
  Named<NamedErrors> errors;
  for (const auto& [sensor, own] : validation.items())
    errors.emplace_back(sensor, NamedErrors{{"open loop", number_in(own, "nrmse")},
                                            {"on the estimated part", number_in(own, "nrmse_estimated_part")},
                                            {"one step ahead", number_in(own, "one_step_nrmse")},
                                            {"noise / rms", number_in(own, "noise")}});
  return errors;
}

Named<FoundSensor> sensors_of(const Json& innovations) {
  Named<FoundSensor> sensors;
  for (const auto& [name, own] : innovations.items())
    sensors.emplace_back(name, FoundSensor{number_in(own, "rms_over_expected"), number_in(own, "correlation")});
  return sensors;
}

Named<std::vector<FoundPair>> correlation_of(const Json& comparisons) {
  Named<std::vector<FoundPair>> all;
  for (const auto& [name, own] : comparisons.items()) {
    auto& pairs = all.emplace_back(name, std::vector<FoundPair>{}).second;
    for (const auto& each : own.at("modes")) {
      const Json& mode = each.at("model_mode");
      pairs.push_back({.measured_hz = each.at("measured_hz"),
                       .model_mode = mode.is_null() ? std::nullopt : std::optional<int>(mode),
                       .model_hz = number_in(each, "model_hz"),
                       .error = number_in(each, "error"),
                       .mac = number_in(each, "mac")});
    }
  }
  return all;
}

NamedErrors timing_of(const Json& timing) {
  NamedErrors seconds{{"total", number_in(timing, "total_s")}};
  for (const std::string step : {"load", "reduce", "modes", "correlate", "static", "frequency_response", "simulate",
                                 "update", "estimate", "diagnose", "validate", "predict", "infer", "place", "verdict"})
    if (const auto taken = number_in(timing, (step + "_s").c_str())) seconds.emplace_back(step, taken);
  return seconds;
}

VerdictState state_named(const std::string& name) {
  for (const auto state : {VerdictState::consistent, VerdictState::suspicious, VerdictState::unusable})
    if (to_string(state) == name) return state;
  throw Json::other_error::create(501, "unknown verdict", static_cast<const Json*>(nullptr));
}

/// Throws Json::exception where the summary is not as kalfem writes it.
FinishedRun run_of(const Json& summary) {
  FinishedRun run;
  const Json timing = object_in(summary, "timing"), estimation = object_in(summary, "estimation");
  run.identity = summary.at("run");
  run.case_file = summary.at("case");
  run.title = text_in(summary, "title");
  run.usable = summary.at("status") == "ok";
  run.message = text_in(summary, "message");
  const Json& state = summary.at("verdict").at("state");
  run.compared = !state.is_null();
  if (run.compared) run.verdict = state_named(state);
  for (const auto& reason : summary.at("verdict").at("reasons"))
    run.reasons.push_back({.code = text_in(reason, "code"),
                           .subject = text_in(reason, "subject"),
                           .text = text_in(reason, "text"),
                           .remedy = text_in(reason, "remedy")});
  run.warnings = texts_in(summary, "warnings");
  run.files = texts_in(summary, "files");
  add_parameters("updating", object_in(object_in(summary, "updating"), "parameters"), parameter_of, run);
  add_parameters("filter", object_in(summary, "parameters"), parameter_of, run);
  add_parameters("posterior", object_in(object_in(summary, "inference"), "parameters"), inferred_parameter_of, run);
  if (!estimation.empty()) run.filter = filter_of(estimation, timing);
  run.sensors = sensors_of(object_in(estimation, "innovations"));
  run.states = errors_by_point(object_in(estimation, "states"));
  run.smoothed = errors_by_point(object_in(object_in(summary, "smoothed"), "states"));
  run.prediction = prediction_of(object_in(summary, "prediction"));
  run.validation = validation_of(object_in(summary, "validation"));
  run.correlation = correlation_of(object_in(object_in(summary, "correlation"), "comparisons"));
  run.timing = timing_of(timing);
  return run;
}

[[noreturn]] void fail(const fs::path& place, const std::string& what, const std::string& why, const std::string& fix) {
  throw InvalidInput(Issue{{place.string(), 0}, what, why, fix});
}

constexpr const char* how_to_name_a_folder = "give the folder of a run's results, such as case.kalfem-out";

}  // namespace

std::optional<double> FoundParameter::deviation() const {
  if (!std || !std_robust) return std ? std : std_robust;
  return std::max(*std, *std_robust);
}

std::string FinishedRun::label() const {
  constexpr std::string_view ending = ".kalfem-out";
  const fs::path whole = fs::absolute(folder).lexically_normal();
  std::string name = (whole.has_filename() ? whole : whole.parent_path()).filename().string();
  if (name.size() > ending.size() && name.ends_with(ending)) name.resize(name.size() - ending.size());
  return name;
}

std::vector<FoundParameter> FinishedRun::parameters() const {
  std::vector<FoundParameter> all;
  for (const auto& step : found)
    for (const auto& parameter : step.parameters) {
      const auto before = std::ranges::find(all, parameter.name, &FoundParameter::name);
      if (before == all.end())
        all.push_back(parameter);
      else if (parameter.estimate)
        *before = parameter;
    }
  return all;
}

FinishedRun finished_run_of(const std::string& text, const fs::path& place) {
  const std::string again = "run the case again";
  const Json summary = Json::parse(text, nullptr, false);
  if (!summary.is_object() || !summary.contains("kalfem"))
    fail(place, "it is damaged", "it is no summary of kalfem", again);
  if (summary["kalfem"] != version)
    fail(place, "it was written by kalfem " + summary["kalfem"].dump(),
         "this is kalfem " + std::string(version) + ", whose summaries may differ", again + " with this version");
  try {
    FinishedRun run = run_of(summary);
    run.summary = text;
    return run;
  } catch (const Json::exception&) {
    fail(place, "it is damaged", "some of its values are missing or of another kind", again);
  }
}

FinishedRun read_finished_run(const fs::path& folder) {
  const fs::path file = folder / "summary.json";
  std::error_code error;
  if (!fs::is_directory(folder, error)) fail(folder, "it is no folder", "", how_to_name_a_folder);
  if (!fs::is_regular_file(file, error))
    fail(folder, "it holds no results of a run", "summary.json is missing", how_to_name_a_folder);
  FinishedRun run = finished_run_of(read_bytes(file), file);
  run.folder = folder;
  return run;
}

}  // namespace kalfem
