// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/point_errors.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "kalfem/page/json_number.hpp"
#include "kalfem/page/words.hpp"
#include "kalfem/records/record.hpp"

namespace kalfem {
namespace {

using Json = nlohmann::ordered_json;

constexpr double smallest_part = 1e-6;

const char* quantity_key(ObservedQuantity quantity) {
  switch (quantity) {
    case ObservedQuantity::displacement:
      return "displacement_nrmse";
    case ObservedQuantity::velocity:
      return "velocity_nrmse";
    case ObservedQuantity::acceleration:
      return "acceleration_nrmse";
    case ObservedQuantity::connector_deformation:
      return "deformation_nrmse";
    case ObservedQuantity::connector_rate:
      return "rate_nrmse";
    case ObservedQuantity::connector_force:
      return "force_nrmse";
    case ObservedQuantity::strain:
      return "strain_nrmse";
  }
  return "";
}

const char* short_name(ObservedQuantity quantity) {
  switch (quantity) {
    case ObservedQuantity::displacement:
    case ObservedQuantity::connector_deformation:
      return "displacement";
    case ObservedQuantity::velocity:
    case ObservedQuantity::connector_rate:
      return "velocity";
    case ObservedQuantity::acceleration:
      return "acceleration";
    case ObservedQuantity::connector_force:
      return "force";
    case ObservedQuantity::strain:
      return "strain";
  }
  return "";
}

}  // namespace

bool shown(const Study& study, const PointQuantity& quantity) {
  const auto& point = quantity.point;
  const auto& wanted =
      quantity.quantity == ObservedQuantity::strain ? study.report.strains : study.report.displacements;
  const bool of_elements = std::ranges::any_of(
      study.structure->finite_elements, [&](const auto& each) { return point.starts_with(each.part->name + "."); });
  return !of_elements || wanted.empty() || std::ranges::any_of(wanted, [&](const auto& name) { return name == point; });
}

std::string band_words(const std::optional<FrequencyBand>& band) {
  return band ? fmt::format(" (band of the excitation: {} to {} Hz)", four_digits(band->from), four_digits(band->to))
              : std::string();
}

Table error_table(const std::string& title, const Study& study, const std::vector<PointQuantity>& points,
                  Eigen::Index settled) {
  const RestingPoints resting(points, settled);
  std::vector<std::string> order;
  std::map<std::string, std::map<std::string, std::string>> cells;
  for (const auto& point : points) {
    if (point.truth.size() == 0 || !shown(study, point)) continue;
    if (!cells.contains(point.point)) order.push_back(point.point);
    const std::string quantity = short_name(point.quantity);
    const bool rests = resting.rests(point);
    cells[point.point][quantity] = rests ? "at rest" : point.nrmse ? per_cent(*point.nrmse) : "-";
    if (point.nrmse_in_band && !rests) cells[point.point][quantity + " in band"] = per_cent(*point.nrmse_in_band);
    if (point.coverage && !rests) cells[point.point]["within ± 1.96 std"] = per_cent(*point.coverage);
  }
  Table table{title,
              {"point", "displacement", "velocity", "acceleration", "acceleration in band", "force", "strain",
               "strain in band", "within ± 1.96 std"},
              {},
              {}};
  const auto used = [&](const std::string& column) {
    return std::ranges::any_of(cells, [&](const auto& row) { return row.second.contains(column); });
  };
  std::erase_if(table.columns, [&](const auto& column) { return column != "point" && !used(column); });
  const auto rests = [&](const auto& own) {
    return std::ranges::all_of(own, [](const auto& cell) { return cell.second == "at rest"; });
  };
  for (const auto& name : order) {
    if (rests(cells[name])) continue;
    std::vector<std::string> row{name};
    for (std::size_t c = 1; c < table.columns.size(); ++c) {
      const auto cell = cells[name].find(table.columns[c]);
      row.push_back(cell == cells[name].end() ? "" : cell->second);
    }
    table.rows.push_back(row);
  }
  return table;
}

RestingPoints::RestingPoints(const std::vector<PointQuantity>& points, Eigen::Index settled) : settled_(settled) {
  for (const auto& point : points) {
    double& largest = largest_[point.quantity];
    largest = std::max(largest, moved(point));
  }
}

bool RestingPoints::rests(const PointQuantity& point) const {
  const auto largest = largest_.find(point.quantity);
  return point.truth.size() > 0 && largest != largest_.end() && moved(point) <= smallest_part * largest->second;
}

double RestingPoints::moved(const PointQuantity& point) const {
  return rms(point.truth.tail(std::max<Eigen::Index>(0, point.truth.size() - settled_)));
}

// Null for points that do not move.
void add_errors(Json& errors, const PointQuantity& point, const RestingPoints& resting) {
  const std::string key = quantity_key(point.quantity);
  const bool rests = resting.rests(point);
  errors[key] = rests ? Json(nullptr) : number(point.nrmse);
  if (point.nrmse_in_band) errors[key + "_in_band"] = rests ? Json(nullptr) : number(*point.nrmse_in_band);
  if (point.coverage) errors["strain_coverage_95"] = number(*point.coverage);
}

}  // namespace kalfem
