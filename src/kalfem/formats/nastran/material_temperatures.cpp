// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/nastran/material_temperatures.hpp"

#include <algorithm>
#include <set>

#include "kalfem/base/units.hpp"

namespace kalfem::nastran {
namespace {

/// Linear between the points, and beyond them by the two at the end; the mean of points that share x.
double interpolated(const std::vector<std::pair<double, double>>& points, double x) {
  const auto at = &std::pair<double, double>::first;
  if (const auto same = std::ranges::equal_range(points, x, {}, at); !same.empty())
    return 0.5 * (same.front().second + same.back().second);
  auto above = std::ranges::upper_bound(points, x, {}, at);
  above = std::clamp(above, points.begin() + 1, points.end() - 1);
  const auto& [x1, y1] = *std::prev(above);
  const auto& [x2, y2] = *above;
  return x1 == x2 ? y2 : y1 + (x - x1) / (x2 - x1) * (y2 - y1);
}

/// TABLEM1: the table's value. TABLEM2, TABLEM3: nominal * table((T - X1) / X2). TABLEM4: nominal * sum_i A_i
/// ((T - X1) / X2)^i with T within X3 ... X4.
double value_at(const MaterialTable& table, double temperature, double nominal) {
  using enum MaterialTable::Form;
  if (table.form == value) return interpolated(table.points, temperature);
  if (table.form == factor) return nominal * interpolated(table.points, (temperature - table.shift) / table.scale);
  const double x = (std::clamp(temperature, table.range[0], table.range[1]) - table.shift) / table.scale;
  double sum = 0.0;
  for (auto coefficient = table.coefficients.rbegin(); coefficient != table.coefficients.rend(); ++coefficient)
    sum = sum * x + *coefficient;
  return nominal * sum;
}

/// The constant at a field of the material's card; it stands twice in a symmetric matrix.
std::vector<double*> constant_at(Material1& law, std::size_t field) {
  return {std::array{&law.youngs_modulus, &law.shear_modulus, &law.poissons_ratio, &law.density}.at(field - 2)};
}
std::vector<double*> constant_at(Material8& law, std::size_t field) {
  return {std::array{&law.e1, &law.e2, &law.nu12, &law.g12, &law.g13, &law.g23, &law.density}.at(field - 2)};
}
template <class SymmetricLaw>
std::vector<double*> constant_at(SymmetricLaw& law, std::size_t field) {
  std::size_t next = 2;
  for (Eigen::Index row = 0; row < law.stiffness.rows(); ++row)
    for (Eigen::Index column = row; column < law.stiffness.cols(); ++column)
      if (next++ == field) return {&law.stiffness(row, column), &law.stiffness(column, row)};
  return {&law.density};
}

const char* kind_of(const MaterialCard& card) {
  static constexpr std::array kinds = {"MAT1", "MAT2", "MAT8", "MAT9"};
  return kinds[card.law.index()];
}

/// The temperature of all grid points in a set; a problem where they differ or have none.
std::optional<double> temperature_of(Id set, const BulkData& bulk, const Place& where, DeckFiles& files) {
  std::map<Id, double> of_nodes;  // node 0: of all others
  for (const auto& card : bulk.temperatures)
    if (card.set == set) of_nodes[card.node] = card.value;
  std::optional<double> lowest, highest;
  for (const auto& grid : bulk.grids) {
    if (grid.motion_system == scalar_point) continue;
    const auto own = of_nodes.contains(grid.id) ? of_nodes.find(grid.id) : of_nodes.find(0);
    if (own == of_nodes.end()) {
      files.problem(where,
                    "grid point " + std::to_string(grid.id) + " has no temperature in set " + std::to_string(set),
                    "materials depend on it", "add a TEMPD card, or state `temperature` beside `deck`");
      return {};
    }
    lowest = std::min(lowest.value_or(own->second), own->second);
    highest = std::max(highest.value_or(own->second), own->second);
  }
  if (lowest == highest) return lowest;
  files.problem(
      where,
      "the temperatures of set " + std::to_string(set) + " go from " + shortest(*lowest) + " to " + shortest(*highest),
      "materials are taken at one temperature", "state this `temperature` beside `deck`");
  return {};
}

/// The set that the deck chooses.
std::optional<Id> chosen_set(const BulkData& bulk, const CaseControl& control) {
  if (control.material_temperature || control.is_present) return control.material_temperature;
  std::set<Id> present;
  for (const auto& card : bulk.temperatures) present.insert(card.set);
  return present.size() == 1 ? std::optional(*present.begin()) : std::nullopt;
}

void apply(const MaterialTemperatureCard& dependence, Id id, double temperature, BulkData& bulk, DeckFiles& files) {
  const std::string title = dependence.kind + "'s temperature dependence, material " + std::to_string(id);
  const auto material = bulk.materials.find(id);
  if (material == bulk.materials.end() || kind_of(material->second) != dependence.kind) {
    files.problem(dependence.where, title + ": there is no " + dependence.kind + " of this number",
                  "its values depend on temperature", "correct the number");
    return;
  }
  for (const auto& [field, number] : dependence.tables) {
    const auto table = bulk.material_tables.find(number);
    if (table == bulk.material_tables.end()) {
      files.problem(dependence.where, title + ": there is no TABLEMi " + std::to_string(number), "",
                    "correct the number");
      continue;
    }
    const auto constants = std::visit([&](auto& law) { return constant_at(law, field); }, material->second.law);
    const double value = value_at(table->second, temperature, *constants.front());
    for (double* constant : constants) *constant = value;
  }
}

}  // namespace

namespace {

/// Temperatures of a deck whose materials do not depend on them are thermal loads, or nothing.
void note_temperature_loads(const BulkData& bulk, const DeckFiles& files, DeckNotes& notes) {
  for (const auto& card : bulk.temperatures)
    notes.add(files.location(card.where), card.node == 0 ? "TEMPD" : "TEMP",
              bulk.expands ? "thermal loads are not read; load cases with them are refused"
                           : "no material depends on temperature or expands",
              DeckNoteKind::unused);
}

}  // namespace

void apply_temperature(BulkData& bulk, const CaseControl& control, DeckFiles& files, DeckNotes& notes) {
  if (bulk.material_temperatures.empty()) {
    note_temperature_loads(bulk, files, notes);
    if (bulk.temperature)
      notes.add(files.location({}), "a stated temperature", "no material of the deck depends on it",
                DeckNoteKind::doubtful);
    return;
  }
  const Place where = bulk.material_temperatures.begin()->second.where;
  std::optional<double> temperature = bulk.temperature;
  if (!temperature) {
    const auto set = chosen_set(bulk, control);
    if (!set) {
      notes.add(files.location(where), "materials by temperature",
                "no TEMPERATURE(MATERIAL) chooses one: the values of the MATi cards are used; state `temperature` for "
                "others",
                DeckNoteKind::doubtful);
      return;
    }
    temperature = temperature_of(*set, bulk, where, files);
  }
  if (!temperature) return;
  for (const auto& [id, dependence] : bulk.material_temperatures) apply(dependence, id, *temperature, bulk, files);
}

}  // namespace kalfem::nastran
