// SPDX-License-Identifier: Apache-2.0
#include "kalfem/watch/change_lines.hpp"

#include <cmath>

#include "kalfem/base/text.hpp"
#include "kalfem/base/units.hpp"

namespace kalfem {

namespace {

using Json = nlohmann::ordered_json;

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

std::string text_of(const Json& line) { return line.dump(-1, ' ', false, Json::error_handler_t::replace); }

void add_change(const ParameterChange& what, double origin, Json& to) {
  to["parameter"] = what.parameter;
  to["change"] = number(what.change);
  to["std"] = number(what.std);
  to["lower"] = number(what.lower);
  to["upper"] = number(what.upper);
  to["since"] = number(origin + what.since);
  to["since_within"] = {number(origin + what.earliest), number(origin + what.latest)};
}

Json json_of(const DailyMean& day) {
  return {
      {"mean", number(day.mean)}, {"std", number(day.std)}, {"lower", number(day.lower)}, {"upper", number(day.upper)}};
}

std::string places_of(const DailyMean& day) {
  return shortest(day.mean) + "," + shortest(day.std) + "," + shortest(day.lower) + "," + shortest(day.upper);
}

}  // namespace

std::string alarm_line(const Alarm& alarm, const ChangeMonitor& monitor, double origin) {
  Json told{{"number", alarm.number}, {"t", number(origin + alarm.time)}, {"kind", to_string(alarm.kind)}};
  add_change(alarm.what, origin, told);
  told["level"] = monitor.options().level;
  told["statistic"] = number(alarm.what.statistic);
  told["threshold"] = number(monitor.threshold());
  told["text"] = alarm.text;
  return text_of({{"alarm", told}});
}

Json changes_now(const ChangeMonitor& monitor, double origin) {
  Json all = Json::array();
  for (const auto& each : monitor.present_changes()) add_change(each, origin, all.emplace_back(Json::object()));
  return all;
}

std::string trend_line(const TrendDay& day, const ChangeMonitor& monitor) {
  Json parameters = Json::object();
  for (const auto& each : monitor.parameters_of(day)) {
    auto& told = parameters[each.parameter] = json_of(each.measured);
    told["corrected"] = json_of(each.corrected);
    told["unit"] = each.unit;
  }
  return text_of({{"trend", {{"day", number(day.start)}, {"windows", day.windows}, {"parameters", parameters}}}});
}

std::string alarm_file(const ChangeMonitor& monitor, double origin) {
  std::string text;
  for (const auto& alarm : monitor.alarms()) text += alarm_line(alarm, monitor, origin) + "\n";
  return text;
}

std::string trend_table(const ChangeMonitor& monitor) {
  std::string text =
      "day "
      "[s],parameter,unit,mean,std,lower,upper,corrected_mean,corrected_std,corrected_lower,corrected_upper,windows\n";
  for (const auto& each : monitor.trend())
    text += shortest(each.day) + "," + each.parameter + "," + each.unit + "," + places_of(each.measured) + "," +
            places_of(each.corrected) + "," + std::to_string(each.windows) + "\n";
  return text;
}

}  // namespace kalfem
