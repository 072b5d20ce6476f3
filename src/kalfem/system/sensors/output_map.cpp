// SPDX-License-Identifier: Apache-2.0
#include "kalfem/system/sensors/output_map.hpp"

namespace kalfem {
namespace {

// A sensor is one row of y = S_d z + S_v z' + S_a z'' + S_f f + D_0 r + D_1 r' + D_2 r''. The motion of a point is a
// combination of degrees of freedom and of moved grounds; a connector's deformation is b^T z - base^T r. Under a base
// acceleration coordinates are relative to the base, so that an accelerometer adds the base's share unless it is said
// to measure relative to the base. A strain is a combination of degrees of freedom.
Eigen::Index connector_index(const LocallyNonlinearSystem& system, const std::string& name) {
  std::vector<std::string> names;
  for (const auto& connector : system.connectors) {
    if (connector.name == name) return static_cast<Eigen::Index>(names.size());
    names.push_back(connector.name);
  }
  throw InvalidInput("there is no connector '" + name + "'" + did_you_mean(name, names), "", "");
}

/// The sparse rows while they are being filled.
struct RowEntries {
  std::vector<Eigen::Triplet<double>> displacement, velocity, acceleration;
};

void set_row(std::vector<Eigen::Triplet<double>>& entries, Eigen::Index row, const Eigen::VectorXd& values) {
  for (Eigen::Index i = 0; i < values.size(); ++i)
    if (values[i] != 0.0) entries.emplace_back(row, i, values[i]);
}

/// Adds one connector's share; entries of the same place add up.
void add_connector(OutputMap& map, RowEntries& entries, Eigen::Index row, const LocallyNonlinearSystem& system,
                   ObservedQuantity quantity, Eigen::Index index, double weight) {
  const auto& connector = system.connectors[static_cast<std::size_t>(index)];
  if (quantity == ObservedQuantity::connector_force) {
    map.force(row, index) += weight;
  } else if (quantity == ObservedQuantity::connector_deformation) {
    set_row(entries.displacement, row, weight * connector.deformation);
    map.input_value.row(row) -= weight * connector.base.transpose();
  } else {
    set_row(entries.velocity, row, weight * connector.deformation);
    map.input_rate.row(row) -= weight * connector.base.transpose();
  }
}

/// The motion of a sum of points, each with its weight.
PointMotion combined_motion(const CoupledModel& model, const DofCombination& points) {
  PointMotion sum{Eigen::VectorXd::Zero(model.system().size()), Eigen::VectorXd::Zero(model.system().input_count())};
  for (const auto& [point, coefficient] : points) {
    const PointMotion motion = model.motion(point);
    sum.dofs += coefficient * motion.dofs;
    sum.base += coefficient * motion.base;
  }
  return sum;
}

/// Adds the absolute acceleration of a sum of points, or without the base's share.
void add_acceleration(OutputMap& map, RowEntries& entries, Eigen::Index row, const CoupledModel& model,
                      const PointMotion& motion, bool relative_to_base) {
  set_row(entries.acceleration, row, motion.dofs);
  map.input_acceleration.row(row) += motion.base.transpose();
  if (!relative_to_base) map.input_value.row(row) += motion.dofs.transpose() * model.base_accelerations();
}

void set_connector_row(OutputMap& map, RowEntries& entries, Eigen::Index row, const CoupledModel& model,
                       const OutputDescription& output) {
  for (const auto& [connector, weight] : output.points)
    add_connector(map, entries, row, model.system(), output.quantity, connector_index(model.system(), connector),
                  weight);
  if (output.carried_masses.empty()) return;
  add_acceleration(map, entries, row, model, combined_motion(model, output.carried_masses), false);
}

void set_point_row(OutputMap& map, RowEntries& entries, Eigen::Index row, const CoupledModel& model,
                   const OutputDescription& output) {
  const PointMotion motion = combined_motion(model, output.points);
  switch (output.quantity) {
    case ObservedQuantity::displacement:
      set_row(entries.displacement, row, motion.dofs);
      map.input_value.row(row) = motion.base.transpose();
      break;
    case ObservedQuantity::velocity:
      set_row(entries.velocity, row, motion.dofs);
      map.input_rate.row(row) = motion.base.transpose();
      break;
    default:
      add_acceleration(map, entries, row, model, motion, output.relative_to_base);
  }
}

/// Grounds have no share: nothing of the base's motion strains an element by itself.
void set_gauge_row(RowEntries& entries, Eigen::Index row, const CoupledModel& model, const OutputDescription& output) {
  for (const auto& [gauge, weight] : output.points) set_row(entries.displacement, row, weight * model.strain(gauge));
}

}  // namespace

bool is_motion(ObservedQuantity quantity) { return quantity <= ObservedQuantity::acceleration; }

bool is_of_connector(ObservedQuantity quantity) {
  return quantity == ObservedQuantity::connector_force || quantity == ObservedQuantity::connector_deformation ||
         quantity == ObservedQuantity::connector_rate;
}

std::string unit_of(ObservedQuantity quantity) {
  switch (quantity) {
    case ObservedQuantity::displacement:
    case ObservedQuantity::connector_deformation:
      return "m";
    case ObservedQuantity::velocity:
    case ObservedQuantity::connector_rate:
      return "m/s";
    case ObservedQuantity::acceleration:
      return "m/s^2";
    case ObservedQuantity::connector_force:
      return "N";
    case ObservedQuantity::strain:
      return "m/m";
  }
  return "";
}

// Rows are collected as triplets, as few degrees of freedom move a sensor; the shares of inputs and connector forces
// are dense, as they are few columns. Every sensor that fails is reported, under its name.
OutputMap make_outputs(const CoupledModel& model, const std::vector<OutputDescription>& descriptions) {
  const auto& system = model.system();
  const auto l = static_cast<Eigen::Index>(descriptions.size());
  const SparseRows dofs(l, system.size());
  const auto inputs = Eigen::MatrixXd::Zero(l, system.input_count());
  OutputMap map{{}, {}, dofs, dofs, dofs, inputs, inputs, inputs, Eigen::MatrixXd::Zero(l, system.connector_count())};
  RowEntries entries;
  IssueList issues;
  for (Eigen::Index row = 0; row < l; ++row) {
    const auto& output = descriptions[static_cast<std::size_t>(row)];
    map.names.push_back(output.name);
    map.units.push_back(unit_of(output.quantity));
    try {
      if (output.points.empty())
        throw InvalidInput("it does not measure anything", "", "name a point, a connector or a gauge");
      if (is_of_connector(output.quantity))
        set_connector_row(map, entries, row, model, output);
      else if (output.quantity == ObservedQuantity::strain)
        set_gauge_row(entries, row, model, output);
      else
        set_point_row(map, entries, row, model, output);
    } catch (const InvalidInput& error) {
      for (const auto& issue : error.issues())
        issues.add(issue.location, "sensor '" + output.name + "': " + issue.what, issue.why, issue.fix);
    }
  }
  issues.raise();
  map.displacement.setFromTriplets(entries.displacement.begin(), entries.displacement.end());
  map.velocity.setFromTriplets(entries.velocity.begin(), entries.velocity.end());
  map.acceleration.setFromTriplets(entries.acceleration.begin(), entries.acceleration.end());
  return map;
}

}  // namespace kalfem
