// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "kalfem/casefile/update_description.hpp"
#include "kalfem/formats/mode_file.hpp"
#include "kalfem/formats/tables/csv.hpp"
#include "kalfem/study/updating_setup.hpp"
#include "kalfem/updating/modes_of_set.hpp"
#include "kalfem/yaml/bounds.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

namespace d = description;

constexpr double default_deviation = 0.01, default_damping_deviation = 0.1;

/// Factor that turns a column of frequencies into Hz: rad/s and rpm are angular.
double factor_to_hertz(const std::string& unit) {
  if (unit.empty()) return 1.0;
  const Unit parsed = parse_unit(unit);
  if (parsed.dimension == parse_unit("Hz").dimension) return parsed.factor;
  if (parsed.dimension == parse_unit("rad/s").dimension) return parsed.factor / (2.0 * std::numbers::pi);
  throw InvalidInput("the frequencies are in '" + unit + "'", "that is not a unit of frequency", "give them in Hz");
}

/// A ratio, or per cent of it.
double factor_to_ratio(const std::string& unit) {
  if (unit.empty()) return 1.0;
  const Unit parsed = parse_unit(unit);
  if (parsed.dimension == Dimension{}) return parsed.factor;
  throw InvalidInput("the damping ratios are in '" + unit + "'", "a ratio has no unit", "give them without, or in %");
}

using Factor = double (*)(const std::string& unit);

std::vector<double> column_of(const d::TableColumn& given, Factor factor) {
  const auto table = read_csv_table(given.file, {.columns = {given.column}, .rows = given.first});
  try {
    const VectorXd values = factor(table.columns.front().unit) * table.values.col(0);
    return {values.begin(), values.end()};
  } catch (const InvalidInput& error) {
    IssueList issues;
    issues.add(error, {given.file.string(), table.title_line});
    throw InvalidInput(issues.issues());
  }
}

std::vector<double> numbers_of(const d::ListedNumbers& given, Factor factor) {
  if (const auto* listed = std::get_if<std::vector<double>>(&given)) return *listed;
  return column_of(std::get<d::TableColumn>(given), factor);
}

bool is_given(const d::Deviation& deviation) {
  const auto* value = std::get_if<d::Value>(&deviation);
  return !value || !value->path.empty();
}

/// The standard deviations of these values: part of each, one for all in `unit`, or a column.
std::vector<double> deviations_of(const d::Deviation& given, const std::vector<double>& values, double otherwise,
                                  const std::string& unit, Factor factor) {
  if (const auto* column = std::get_if<d::TableColumn>(&given)) {
    auto deviations = column_of(*column, factor);
    if (deviations.size() != values.size())
      throw InvalidInput(column->file.string() + " holds " + std::to_string(deviations.size()) + " standard deviations",
                         "there are " + std::to_string(values.size()) + " modes", "give one a mode, or `first`");
    return deviations;
  }
  const auto& one = std::get<d::Value>(given);
  const bool relative = one.path.empty() || (!one.value.bare && one.value.dimension == Dimension{});
  std::vector<double> deviations;
  for (const double value : values)
    deviations.push_back(relative ? (one.path.empty() ? otherwise : one.value.value) * value
                                  : checked_number(one, unit, Bounds::positive()));
  return deviations;
}

std::vector<double> frequencies_of(const std::vector<MeasuredMode>& modes) {
  std::vector<double> values;
  for (const auto& mode : modes) values.push_back(mode.frequency);
  return values;
}

void set_deviations(const d::Deviation& given, std::vector<MeasuredMode>& modes) {
  const auto deviations = deviations_of(given, frequencies_of(modes), default_deviation, "Hz", factor_to_hertz);
  for (std::size_t i = 0; i < modes.size(); ++i) modes[i].deviation = deviations[i];
}

void set_damping_deviations(const d::Deviation& given, std::vector<MeasuredMode>& modes) {
  std::vector<double> dampings;
  for (const auto& mode : modes) dampings.push_back(*mode.damping);
  const auto deviations = deviations_of(given, dampings, default_damping_deviation, "-", factor_to_ratio);
  for (std::size_t i = 0; i < modes.size(); ++i) modes[i].damping_deviation = deviations[i];
}

std::vector<MeasuredMode> modes_of(const d::ListedModes& listed, const d::ModalData& given) {
  std::vector<MeasuredMode> modes;
  for (const double frequency : numbers_of(listed.frequencies.value, factor_to_hertz))
    modes.push_back({.frequency = frequency});
  set_deviations(given.deviation, modes);
  if (!listed.dampings) return modes;
  const auto dampings = numbers_of(listed.dampings->value, factor_to_ratio);
  if (dampings.size() != modes.size())
    throw InvalidInput(listed.dampings->issue(
        std::to_string(modes.size()) + " frequencies and " + std::to_string(dampings.size()) + " dampings", "",
        "give the same number of each"));
  for (std::size_t i = 0; i < modes.size(); ++i) modes[i].damping = dampings[i];
  set_damping_deviations(given.damping_deviation, modes);
  return modes;
}

Eigen::MatrixXd shape_table(const std::filesystem::path& file, Index rows, Index columns) {
  const auto table = read_csv_table(file, {.missing = true});
  if (table.values.rows() != rows || table.values.cols() != columns)
    throw InvalidInput(file.string() + " holds " + std::to_string(table.values.rows()) + " rows and " +
                           std::to_string(table.values.cols()) + " columns of numbers",
                       "there are " + std::to_string(rows) + " points and " + std::to_string(columns) + " frequencies",
                       "give one row per point and one column per mode");
  return table.values;
}

/// Throws with every point that the model does not have.
std::vector<DofCombination> points_of(const LinearModel& model, const std::vector<Name>& names) {
  std::vector<DofCombination> points;
  IssueList issues;
  for (const auto& name : names) try {
      points.push_back(point_of(model, name));
    } catch (const InvalidInput& error) {
      issues.add(error, name.location);
    }
  issues.raise();
  return points;
}

void add_shapes(const d::ShapeTable& given, const LinearModel& model, ModalMeasurement& measured) {
  for (const auto& point : given.points) measured.places.push_back(point.value);
  measured.points = points_of(model, given.points);
  measured.sensors = measured.places;
  const auto rows = std::ssize(measured.points), columns = std::ssize(measured.modes);
  const Eigen::MatrixXd shapes = shape_table(given.file, rows, columns);
  Eigen::MatrixXd deviations;
  if (given.deviations) deviations = shape_table(*given.deviations, rows, columns);
  for (Index i = 0; i < columns; ++i) {
    auto& mode = measured.modes[static_cast<std::size_t>(i)];
    if (shapes.col(i).array().isNaN().all()) continue;  // its frequency alone was measured
    mode.shape = shapes.col(i);
    mode.shape_deviation = given.deviation;
    if (given.deviations) mode.shape_deviations = deviations.col(i);
  }
}

// --- a file of modes -------------------------------------------------------------------------------------------------

ModeSet chosen_modes(const d::ModeFile& given) {
  ModeSet set = read_modes(given.file.value);
  if (given.only.empty()) return set;
  std::vector<ModeSet::Mode> chosen;
  for (const int number : given.only) {
    if (number > std::ssize(set.modes))
      throw InvalidInput(given.file.issue("there is no mode " + std::to_string(number) + " in it",
                                          "it holds " + std::to_string(set.modes.size()) + " modes",
                                          "correct the numbers under `only`"));
    chosen.push_back(set.modes[static_cast<std::size_t>(number) - 1]);
  }
  set.modes = std::move(chosen);
  return set;
}

bool has_point(const LinearModel& model, const std::string& name) {
  return model.points.contains(name) || std::ranges::find(model.dofs, name) != model.dofs.end();
}

/// The point of the model that has the name of the i-th point of the set, or is the same motion of its node.
std::optional<std::string> same_point(const LinearModel& model, const ModeSet& set, std::size_t i) {
  constexpr std::array<const char*, 6> directions = {".x", ".y", ".z", ".rx", ".ry", ".rz"};
  std::vector<std::string> names = {set.points[i]};
  if (!set.places.empty() && set.places[i].node && set.places[i].direction > 0) {
    const std::string motion =
        std::to_string(*set.places[i].node) + directions.at(static_cast<std::size_t>(set.places[i].direction) - 1);
    names.insert(names.end(), {motion, "n" + motion});
  }
  for (const auto& name : names)
    if (has_point(model, name)) return name;
  return std::nullopt;
}

/// "point 'a1'", "points 'a1', 'a2', 'a3' and 5 more".
std::string counted_names(const std::vector<std::string>& points) {
  constexpr std::size_t most = 3;
  std::string words = points.size() == 1 ? "point " : "points ";
  for (std::size_t i = 0; i < std::min(points.size(), most); ++i) words += (i > 0 ? ", '" : "'") + points[i] + "'";
  return points.size() > most ? words + " and " + std::to_string(points.size() - most) + " more" : words;
}

/// The model's points and the file's names of them.
Named<Located<std::string>> points_of_file(const d::ModeFile& given, const LinearModel& model, const ModeSet& set) {
  if (!given.points.empty()) return given.points;
  Named<Located<std::string>> points;
  std::vector<std::string> unknown;
  for (std::size_t i = 0; i < set.points.size(); ++i)
    if (const auto name = same_point(model, set, i))
      points.emplace_back(*name, Located<std::string>{set.points[i], given.file.location, given.file.path});
    else
      unknown.push_back(set.points[i]);
  if (!unknown.empty())
    throw InvalidInput(
        given.file.issue("the substructure has no namesake of its " + counted_names(unknown),
                         "each entry of a shape is compared at a point",
                         "list under `points` those that are compared, each with the file's name of it"));
  return points;
}

ModalMeasurement measurement_of(const d::ModeFile& given, const d::ModalData& data, const LinearModel& model) {
  const ModeSet set = chosen_modes(given);
  ModalMeasurement measured;
  std::vector<Name> points;
  for (const auto& [point, name] : points_of_file(given, model, set)) {
    points.push_back({point, name.location, name.path});
    measured.places.push_back(point);
    measured.sensors.push_back(name.value);
  }
  measured.points = points_of(model, points);
  measured.modes = modes_of_set(
      at_points(set, measured.sensors),
      {.shape_deviation = given.shape_deviation, .dampings = given.dampings, .max_complexity = given.max_complexity});
  if (is_given(data.deviation)) set_deviations(data.deviation, measured.modes);
  if (given.dampings && is_given(data.damping_deviation))
    set_damping_deviations(data.damping_deviation, measured.modes);
  return measured;
}

void set_model_modes(const d::ModalData& given, const Name& place, std::vector<MeasuredMode>& modes) {
  if (given.model_modes.empty()) return;
  if (given.model_modes.size() != modes.size())
    throw InvalidInput(place.issue(
        std::to_string(modes.size()) + " frequencies and " + std::to_string(given.model_modes.size()) + " model_modes",
        "", "give the same number of each, or remove model_modes"));
  for (std::size_t i = 0; i < modes.size(); ++i) modes[i].model_mode = given.model_modes[i];
}

}  // namespace

DofCombination point_of(const LinearModel& model, const Name& name) {
  if (const auto point = model.points.find(name.value); point != model.points.end()) return point->second;
  if (std::ranges::find(model.dofs, name.value) != model.dofs.end()) return {{name.value, 1.0}};
  std::vector<std::string> known;
  for (const auto& [point, combination] : model.points) known.push_back(point);
  if (!model.points_only) known.insert(known.end(), model.dofs.begin(), model.dofs.end());
  throw InvalidInput(name.issue("there is no point '" + name.value + "'" + did_you_mean(name.value, known)));
}

std::vector<MeasuredMode> listed_modes(const d::ModalData& given) {
  const auto& listed = std::get<d::ListedModes>(given.measured);
  auto modes = modes_of(listed, given);
  set_model_modes(given, {"", listed.frequencies.location, listed.frequencies.path}, modes);
  return modes;
}

ModalMeasurement modal_measurement(const d::ModalData& given, const LinearModel& model) {
  ModalMeasurement measured;
  if (const auto* file = std::get_if<d::ModeFile>(&given.measured)) {
    measured = measurement_of(*file, given, model);
    set_model_modes(given, {"", file->file.location, file->file.path}, measured.modes);
    return measured;
  }
  measured.modes = listed_modes(given);
  const auto& listed = std::get<d::ListedModes>(given.measured);
  if (listed.shapes) add_shapes(*listed.shapes, model, measured);
  return measured;
}

bool has_shapes(const d::ModalData& given) {
  const auto* listed = std::get_if<d::ListedModes>(&given.measured);
  return !listed || listed->shapes;
}

bool has_dampings(const d::ModalData& given) {
  if (const auto* listed = std::get_if<d::ListedModes>(&given.measured)) return listed->dampings.has_value();
  return std::get<d::ModeFile>(given.measured).dampings;
}

}  // namespace kalfem
