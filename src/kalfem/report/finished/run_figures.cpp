// SPDX-License-Identifier: Apache-2.0
#include "kalfem/report/finished/run_figures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "kalfem/page/chart_series.hpp"
#include "kalfem/report/finished/run_series.hpp"

namespace kalfem {
namespace {

using Eigen::VectorXd;

constexpr std::size_t points_unasked = 2;  ///< whose motion is drawn if no point is named
constexpr double zoomed_part = 0.05;       ///< of the record

/// "body.3" of "/estimate/body.3/displacement"; empty for another quantity or a deeper group.
std::string owner_of(const std::string& path, const std::string& group, const std::string& quantity) {
  const std::string end = "/" + quantity;
  if (!path.ends_with(end) || path.size() <= group.size() + 1 + end.size()) return "";
  const std::string name = path.substr(group.size() + 1, path.size() - group.size() - 1 - end.size());
  return name.find('/') == std::string::npos ? name : "";
}

/// Makes the figures of one run.
class Figures {
public:
  explicit Figures(const FinishedRun& run) : run_(run), series_(run) {}

  std::vector<Figure> make(const std::vector<std::string>& points) {
    add_parameters();
    const bool unasked = points.empty();
    for (const auto& point : unasked ? first_moving("/estimate", "displacement", run_.states) : checked(points))
      add_displacement(point);
    for (const auto& point : unasked ? first_moving("/prediction", "acceleration", run_.prediction) : points)
      add_acceleration(point);
    for (const auto& connector : owners("/estimate", "force")) add_force(connector);
    for (const auto& sensor : owners("/validation", "measured")) add_validation(sensor);
    for (const auto& sensor : owners("/predictive", "measured")) add_predictive(sensor);
    add_responses();
    add_computed_responses();
    return std::move(figures_);
  }

private:
  void add(std::string name, Chart chart) { figures_.push_back({std::move(name), std::move(chart)}); }

  /// Names of the points, connectors or sensors of a group that have the quantity.
  [[nodiscard]] std::vector<std::string> owners(const std::string& group, const std::string& quantity) const {
    std::vector<std::string> names;
    for (const auto& path : series_.below(group))
      if (auto name = owner_of(path, group, quantity); !name.empty()) names.push_back(std::move(name));
    return names;
  }

  /// The first points that move, in the order of the summary, where an error of null tells of rest. Without a reference
  /// there are no errors: then the first ones of the file.
  [[nodiscard]] std::vector<std::string> first_moving(const std::string& group, const std::string& quantity,
                                                      const Named<NamedErrors>& errors) const {
    std::vector<std::string> names;
    for (const auto& [point, own] : errors)
      for (const auto& [name, error] : own)
        if (name == quantity && error) names.push_back(point);
    if (errors.empty()) names = owners(group, quantity);
    names.resize(std::min(names.size(), points_unasked));
    return names;
  }

  [[nodiscard]] std::vector<std::string> checked(const std::vector<std::string>& points) const {
    auto known = owners("/estimate", "displacement");
    const auto predicted = owners("/prediction", "acceleration");
    known.insert(known.end(), predicted.begin(), predicted.end());
    IssueList issues;
    for (const auto& point : points)
      if (std::ranges::find(known, point) == known.end())
        issues.add({run_.folder.string(), 0}, "the run reports no point '" + point + "'" + did_you_mean(point, known));
    issues.raise();
    return points;
  }

  /// The times of the first samples.
  [[nodiscard]] std::vector<double> times_of(const VectorXd& values) const {
    const VectorXd time = series_.read("/time").value_or(VectorXd());
    return series_values(time.head(std::min(time.size(), values.size())));
  }

  /// A series of the run, cut to so many samples.
  [[nodiscard]] std::optional<Series> curve(const std::string& label, const std::string& path, Role role,
                                            std::size_t samples) const {
    const auto values = series_.read(path);
    if (!values || values->size() < static_cast<Eigen::Index>(samples)) return std::nullopt;
    return Series{.label = label, .y = series_values(values->head(static_cast<Eigen::Index>(samples))), .role = role};
  }

  void add_parameters() {
    for (const auto& step : run_.found)
      for (const auto& parameter : step.parameters) {
        const bool of_filter = step.by == "filter";
        const auto course = of_filter               ? series_.filter_course(parameter.name)
                            : step.by == "updating" ? series_.updating_course(parameter.name)
                                                    : std::nullopt;
        if (course && course->x.size() > 1) add_parameter(parameter, *course, of_filter ? "time [s]" : "evaluation");
      }
  }

  void add_parameter(const FoundParameter& parameter, const ParameterCourse& course, const std::string& x_label) {
    Chart chart{.title = parameter.name,
                .x_label = x_label,
                .x = series_values(course.x),
                .series = {{.label = course.lower.size() > 0 ? "estimate, 95 % band" : "estimate",
                            .y = series_values(course.mean),
                            .lower = series_values(course.lower),
                            .upper = series_values(course.upper),
                            .role = Role::estimate}}};
    if (parameter.truth)
      chart.series.push_back(
          {.label = "truth", .y = std::vector<double>(chart.x.size(), *parameter.truth), .role = Role::truth});
    add("parameter-" + parameter.name, with_readable_ordinates(std::move(chart), parameter.name, parameter.unit));
  }

  void add_displacement(const std::string& point) {
    const std::string path = point + "/displacement";
    const auto estimate = series_.read("/estimate/" + path);
    if (!estimate) return;
    Chart chart{.title = "Displacement of " + point,
                .x_label = "time [s]",
                .x = times_of(*estimate),
                .series = {{.label = "estimate", .y = series_values(*estimate), .role = Role::estimate}}};
    if (chart.x.size() != chart.series.front().y.size()) return;
    if (auto truth = curve("simulated", "/truth/" + path, Role::truth, chart.x.size()))
      chart.series.push_back(std::move(*truth));
    chart = with_readable_ordinates(std::move(chart), "displacement", "m");
    add("displacement-" + point, chart);
    chart.x_window = about_the_largest(chart.x, chart.series.back().y);
    chart.title += ", zoomed";
    if (chart.x_window) add("displacement-" + point + "-zoom", std::move(chart));
  }

  /// A part of the record about its largest value.
  static std::optional<AxisRange> about_the_largest(const std::vector<double>& x, const std::vector<double>& values) {
    const auto size = [](double value) { return std::isfinite(value) ? std::abs(value) : 0.0; };
    const auto largest = std::ranges::max_element(values, {}, size) - values.begin();
    const double length = zoomed_part * (x.back() - x.front());
    if (!(length > 0.0)) return std::nullopt;
    const double from = std::clamp(x[static_cast<std::size_t>(largest)] - 0.5 * length, x.front(), x.back() - length);
    return AxisRange{from, from + length};
  }

  void add_acceleration(const std::string& point) {
    const std::string path = point + "/acceleration";
    const auto predicted = series_.read("/prediction/" + path);
    if (!predicted) return;
    Chart chart{.title = "Predicted acceleration of " + point,
                .x_label = "time [s]",
                .y_label = "acceleration [m/s²]",
                .x = times_of(*predicted),
                .series = {{.label = "predicted", .y = series_values(*predicted), .role = Role::predicted}}};
    if (chart.x.size() != chart.series.front().y.size()) return;
    if (auto truth = curve("simulated", "/truth/" + path, Role::truth, chart.x.size()))
      chart.series.push_back(std::move(*truth));
    chart.x_window = about_the_largest(chart.x, chart.series.back().y);
    add("acceleration-" + point, std::move(chart));
  }

  /// The path about the largest deformation: that of a whole record would be a blot.
  void add_force(const std::string& connector) {
    Chart chart{.title = "Force of " + connector, .scatter = true};
    std::optional<AxisRange> window;
    for (const auto& [group, label, role] :
         {std::tuple{"/estimate/", "estimate", Role::estimate}, {"/truth/", "simulated", Role::truth}}) {
      const auto deformation = series_.read(group + connector + "/deformation");
      const auto force = series_.read(group + connector + "/force");
      if (!deformation || !force || deformation->size() != force->size()) continue;
      const auto time = times_of(*deformation);
      if (!window && time.size() > 1) window = about_the_largest(time, series_values(*deformation));
      if (!window) return;
      const auto first = std::ranges::lower_bound(time, window->front()) - time.begin();
      const auto count = std::ranges::upper_bound(time, window->back()) - time.begin() - first;
      chart.series.push_back({.label = label,
                              .y = series_values(force->segment(first, count)),
                              .role = role,
                              .x = series_values(deformation->segment(first, count))});
    }
    if (chart.series.empty()) return;
    chart = with_readable_abscissae(std::move(chart), "deformation", "m");
    add("force-" + connector, with_readable_ordinates(std::move(chart), "force", "N"));
  }

  /// Curves of one sensor over the time of their group.
  Chart sensor_chart(const std::string& group, const std::string& sensor) {
    const std::string measured = group + "/" + sensor + "/measured";
    Chart chart{.title = sensor, .x_label = "time [s]", .y_label = sensor + " [" + series_.unit(measured) + "]"};
    chart.x = series_values(series_.read(group + "/time").value_or(VectorXd()));
    if (auto found = curve("measured", measured, Role::measured, chart.x.size()))
      chart.series.push_back(std::move(*found));
    return chart;
  }

  void add_validation(const std::string& sensor) {
    Chart chart = sensor_chart("/validation", sensor);
    if (auto found = curve("simulated with the estimates", "/validation/" + sensor + "/simulated", Role::estimate,
                           chart.x.size()))
      chart.series.push_back(std::move(*found));
    if (!chart.series.empty()) add("validation-" + sensor, std::move(chart));
  }

  void add_predictive(const std::string& sensor) {
    Chart chart = sensor_chart("/predictive", sensor);
    const std::string own = "/predictive/" + sensor;
    const auto lower = series_.read(own + "/lower"), upper = series_.read(own + "/upper");
    if (auto mean = curve("predicted, 95 % band", own + "/mean", Role::estimate, chart.x.size());
        mean && lower && upper) {
      mean->lower = series_values(*lower);
      mean->upper = series_values(*upper);
      chart.series.push_back(std::move(*mean));
    }
    if (!chart.series.empty()) add("predictive-" + sensor, std::move(chart));
  }

  /// Magnitudes in decibels of the SI unit.
  std::optional<Series> decibel_curve(const std::string& label, const std::string& path, Role role, std::size_t size) {
    auto found = curve(label, path, role, size);
    if (found)
      for (double& value : found->y) value = 20.0 * std::log10(value);
    return found;
  }

  void add_responses() {
    const std::string group = "/updating/responses";
    for (const auto& path : series_.below(group)) {
      if (!path.ends_with("/frequency")) continue;
      const std::string own = path.substr(0, path.rfind('/') + 1);
      Chart chart{.title = "Frequency response", .x_label = "frequency [Hz]", .y_label = "magnitude [dB]"};
      chart.x = series_values(series_.read(path).value_or(VectorXd()));
      for (const auto& [name, role] :
           {std::pair{"measured", Role::measured}, {"before", Role::initial}, {"after", Role::estimate}})
        if (auto found = decibel_curve(name, own + name, role, chart.x.size()))
          chart.series.push_back(std::move(*found));
      std::string name = own.substr(group.size() + 1, own.size() - group.size() - 2);
      std::ranges::replace(name, '/', '-');
      if (!chart.series.empty()) add("response-" + name, std::move(chart));
    }
  }

  /// The same of full and reduced models.
  void add_computed_responses() {
    const std::string group = "/frequency_response";
    const auto lines = series_values(series_.read(group + "/frequency").value_or(VectorXd()));
    std::set<std::string> responses;
    for (const auto& path : series_.below(group))
      if (path.ends_with("/full") || path.ends_with("/reduced")) responses.insert(path.substr(0, path.rfind('/') + 1));
    for (const auto& own : responses) {
      Chart chart{.title = "Frequency response", .x_label = "frequency [Hz]", .y_label = "magnitude [dB]", .x = lines};
      for (const auto& [name, role] : {std::pair{"full", Role::truth}, {"reduced", Role::estimate}})
        if (auto found = decibel_curve(name, own + name, role, chart.x.size()))
          chart.series.push_back(std::move(*found));
      std::string name = own.substr(group.size() + 1, own.size() - group.size() - 2);
      std::ranges::replace(name, '/', '-');
      if (!chart.series.empty()) add("frf-" + name, std::move(chart));
    }
  }

  const FinishedRun& run_;
  RunSeries series_;
  std::vector<Figure> figures_;
};

}  // namespace

std::vector<Figure> run_figures(const FinishedRun& run, const std::vector<std::string>& points) {
  return Figures(run).make(points);
}

}  // namespace kalfem
