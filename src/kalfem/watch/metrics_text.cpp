// SPDX-License-Identifier: Apache-2.0
#include "kalfem/watch/metrics_text.hpp"

#include <algorithm>
#include <functional>
#include <nlohmann/json.hpp>

#include "kalfem/base/units.hpp"

namespace kalfem {
namespace {

using Json = nlohmann::ordered_json;

std::string escaped(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    if (c == '\n') {
      safe += "\\n";
      continue;
    }
    if (c == '"' || c == '\\') safe += '\\';
    safe += c;
  }
  return safe;
}

Json estimates_of(const WatchedHealth& each) {
  return each.estimates.empty() ? Json::object() : Json::parse(each.estimates);
}

std::string condition_of(const WatchedHealth& each) {
  return each.running ? estimates_of(each).value("condition", "warming up") : "stopped";
}

/// Lines of one metric: values by labels.
class Metric {
public:
  Metric(const std::string& name, const std::string& type, const std::string& help)
      : name_(name), text_("# HELP " + name + " " + help + "\n# TYPE " + name + " " + type + "\n") {}
  void add(const std::vector<std::pair<std::string, std::string>>& labels, double value) {
    text_ += name_;
    char mark = '{';
    for (const auto& [key, label] : labels) {
      text_ += mark + key + "=\"" + escaped(label) + "\"";
      mark = ',';
    }
    text_ += "} " + shortest(value) + "\n";
  }
  [[nodiscard]] const std::string& text() const { return text_; }

private:
  std::string name_, text_;
};

std::string of_each(const std::vector<WatchedHealth>& cases, const std::string& name, const std::string& type,
                    const std::string& help, const std::function<double(const WatchedHealth&)>& value) {
  Metric metric(name, type, help);
  for (const auto& each : cases) metric.add({{"case", each.name}}, value(each));
  return metric.text();
}

/// A number of the latest line of estimates.
std::string of_estimates(const std::vector<WatchedHealth>& cases, const std::string& name, const std::string& type,
                         const std::string& help, const std::string& key) {
  Metric metric(name, type, help);
  for (const auto& each : cases)
    if (const Json told = estimates_of(each); told.contains(key) && told[key].is_number())
      metric.add({{"case", each.name}}, told[key].get<double>());
  return metric.text();
}

std::string conditions(const std::vector<WatchedHealth>& cases) {
  Metric metric("kalfem_condition", "gauge", "1 for the condition in which the filter is");
  for (const auto& each : cases)
    for (const char* condition : {"warming up", "consistent", "suspicious", "unusable", "silent", "stopped"})
      metric.add({{"case", each.name}, {"condition", condition}}, condition_of(each) == condition ? 1.0 : 0.0);
  return metric.text();
}

std::string parameters(const std::vector<WatchedHealth>& cases, const std::string& name, const std::string& help,
                       const std::string& key) {
  Metric metric(name, "gauge", help);
  for (const auto& each : cases) {
    const Json told = estimates_of(each).value("parameters", Json::object());
    for (const auto& [parameter, value] : told.items())
      if (value[key].is_number())
        metric.add({{"case", each.name}, {"parameter", parameter}, {"unit", value["unit"]}}, value[key].get<double>());
  }
  return metric.text();
}

}  // namespace

std::string metrics_text(const std::vector<WatchedHealth>& cases) {
  return of_each(cases, "kalfem_up", "gauge", "1 while the case is watched",
                 [](const auto& each) { return each.running ? 1.0 : 0.0; }) +
         conditions(cases) + of_estimates(cases, "kalfem_samples_total", "counter", "samples taken", "samples") +
         of_estimates(cases, "kalfem_late_total", "counter", "values that came too late or twice", "late") +
         of_estimates(cases, "kalfem_bad_lines_total", "counter", "lines that could not be used", "bad_lines") +
         of_estimates(cases, "kalfem_stream_seconds", "gauge", "time of the stream where the filter stands", "t") +
         of_each(cases, "kalfem_silent_seconds", "gauge", "since the last sample came",
                 [](const auto& each) { return each.silent_for; }) +
         of_each(cases, "kalfem_alarms_total", "counter", "alarms given",
                 [](const auto& each) { return static_cast<double>(each.alarms); }) +
         of_each(cases, "kalfem_changes", "gauge", "parameters whose alarm stands",
                 [](const auto& each) {
                   return static_cast<double>(estimates_of(each).value("changes", Json::array()).size());
                 }) +
         parameters(cases, "kalfem_parameter", "estimate", "estimate") +
         parameters(cases, "kalfem_parameter_std", "standard deviation of the estimate", "std");
}

bool is_healthy(const std::vector<WatchedHealth>& cases) {
  return std::ranges::all_of(cases, [](const auto& each) {
    const auto condition = condition_of(each);
    return condition == "warming up" || condition == "consistent" || condition == "suspicious";
  });
}

std::string health_text(const std::vector<WatchedHealth>& cases) {
  Json told{{"healthy", is_healthy(cases)}, {"cases", Json::object()}};
  for (const auto& each : cases) {
    auto& entry = told["cases"][each.name];
    entry = {{"running", each.running}, {"condition", condition_of(each)}, {"silent_for", each.silent_for}};
    if (!each.why_not.empty()) entry["why"] = each.why_not;
  }
  return told.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace kalfem
