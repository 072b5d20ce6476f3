// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/statics/rotation.hpp"

#include <Eigen/Geometry>
#include <cmath>

#include "kalfem/model/assembly/assembly.hpp"
#include "kalfem/model/elements/beam_forces.hpp"
#include "kalfem/model/elements/shell.hpp"

namespace kalfem {
namespace {

using Eigen::Index;

/// 1 - n n^T.
Eigen::Matrix3d across(const Eigen::Vector3d& axis) {
  const Eigen::Vector3d n = axis.normalized();
  return Eigen::Matrix3d::Identity() - n * n.transpose();
}

/// Mass of all nodes before supports and links, 6 to a node.
SparseMatrix mass_of_nodes(FiniteElementModel model) {
  model.fixed.clear();
  model.links.clear();
  model.weighted_links.clear();
  model.constraints.clear();
  const AssembledModel assembled = assemble(model);
  const SparseMatrix spread = assembled.expansion * evaluate(assembled.mass, assembled.parameters);
  return spread * SparseMatrix(assembled.expansion.transpose());
}

/// The model without beams and point masses.
FiniteElementModel without_beams_and_masses(FiniteElementModel model) {
  std::erase_if(model.properties, [](const auto& of) { return std::holds_alternative<BeamProperty>(of.second); });
  model.masses.clear();
  return model;
}

/// Of the corners of a shell in turn.
Eigen::Matrix3Xd corner_normals(const Eigen::Matrix3Xd& corners) {
  Eigen::Matrix3Xd normals(3, corners.cols());
  for (Index i = 0; i < corners.cols(); ++i) {
    const Eigen::Vector3d next = corners.col((i + 1) % corners.cols()) - corners.col(i);
    const Eigen::Vector3d last = corners.col((i + corners.cols() - 1) % corners.cols()) - corners.col(i);
    normals.col(i) = next.cross(last).normalized();
  }
  return normals;
}

/// Sums up what a field exerts on the parts of a model, see field_forces().
class FieldForces {
public:
  FieldForces(const FiniteElementModel& model, const AccelerationField& field)
      : model_(model), field_(field), forces_(Eigen::VectorXd::Zero(6 * model.mesh.node_count())) {
    add_spread_masses();
    for (const auto& [region, property] : model.properties) {
      const auto& cells = model.mesh.regions.at(region);
      for (std::size_t i = 0; i < cells.size(); ++i) {
        const auto nodes = model.mesh.nodes_of(model.mesh.cells[static_cast<std::size_t>(cells[i])]);
        std::visit([&, nodes = nodes](const auto& of) { add(nodes, of, i); }, property);
      }
    }
    for (const auto& mass : model.masses) add(mass);
  }
  [[nodiscard]] const Eigen::VectorXd& sum() const { return forces_; }

private:
  using Nodes = std::span<const Index>;

  /// M a of the field at the nodes.
  void add_spread_masses() {
    const FiniteElementModel rest = without_beams_and_masses(model_);
    if (rest.properties.empty() && rest.matrices.empty()) return;
    Eigen::VectorXd acceleration = Eigen::VectorXd::Zero(forces_.size());
    for (Index node = 0; node < model_.mesh.node_count(); ++node)
      acceleration.segment<3>(6 * node) =
          model_.mesh.axes_of(node).transpose() * field_.at(model_.mesh.nodes.col(node));
    forces_ += mass_of_nodes(rest) * acceleration;
  }

  void add(Nodes nodes, const BeamProperty& property, std::size_t place) {
    const Eigen::Matrix<double, 3, 2> ends = model_.mesh.nodes(Eigen::all, nodes);
    const BeamField field{(field_.gradient * ends).colwise() + field_.constant, field_.gradient};
    scatter(nodes, beam_field_forces(ends, property, property.placement(place), material_of(property), model_.mass_kind,
                                     field));
  }
  void add(Nodes /*nodes*/, const SolidProperty& /*property*/, std::size_t /*place*/) {}

  /// What the field at the mid-surface differs from that at the nodes.
  void add(Nodes nodes, const ShellProperty& property, std::size_t /*place*/) {
    if (property.offset == 0.0) return;
    const auto& material = material_of(property);
    const Eigen::Matrix3Xd corners = model_.mesh.nodes(Eigen::all, nodes);
    const auto matrices = corners.cols() == 3 ? shell3(corners, material.poissons_ratio, property, model_.mass_kind)
                                              : shell4(corners, material.poissons_ratio, property, model_.mass_kind);
    for (const auto& term : matrices.mass)
      add_at_offset(nodes, corners, property.offset,
                    std::pow(material.density, term.powers.density) *
                        std::pow(property.thickness, term.powers.thickness) * term.matrix);
  }
  void add(Nodes nodes, const LaminateProperty& property, std::size_t place) {
    if (property.offset == 0.0) return;
    const Eigen::Matrix3Xd corners = model_.mesh.nodes(Eigen::all, nodes);
    for (const auto& term : laminate(corners, property, property.direction(place), model_.mass_kind).mass)
      add_at_offset(nodes, corners, property.offset, term.matrix);
  }
  void add_at_offset(Nodes nodes, const Eigen::Matrix3Xd& corners, double offset, const Eigen::MatrixXd& mass) {
    const Eigen::Matrix3Xd differences = offset * field_.gradient * corner_normals(corners);
    Eigen::VectorXd acceleration = Eigen::VectorXd::Zero(mass.cols());
    for (Index i = 0; i < corners.cols(); ++i) acceleration.segment<3>(6 * i) = differences.col(i);
    scatter(nodes, mass * acceleration);
  }

  /// With the second moments S = int r r^T dm about the centre, int r x (G r) dm is the axial vector of G S - (G S)^T.
  void add(const PointMass& mass) {
    const Eigen::Matrix3d axes = model_.mesh.axes_of(mass.node);
    const Eigen::Matrix3d gradient = axes.transpose() * field_.gradient * axes;
    const Eigen::Vector3d at_node = axes.transpose() * field_.at(model_.mesh.nodes.col(mass.node));
    const Eigen::Vector3d force = mass.mass * (at_node + gradient * mass.offset);
    const Eigen::Matrix3d moments = 0.5 * mass.inertia.trace() * Eigen::Matrix3d::Identity() - mass.inertia;
    const Eigen::Matrix3d turn = gradient * moments;
    forces_.segment<3>(6 * mass.node) += force;
    forces_.segment<3>(6 * mass.node + 3) +=
        mass.offset.cross(force) +
        Eigen::Vector3d(turn(2, 1) - turn(1, 2), turn(0, 2) - turn(2, 0), turn(1, 0) - turn(0, 1));
  }

  template <typename Property>
  [[nodiscard]] const IsotropicMaterial& material_of(const Property& property) const {
    return model_.materials.at(property.material);
  }

  void scatter(Nodes nodes, const Eigen::VectorXd& forces) {
    for (std::size_t i = 0; i < nodes.size(); ++i)
      forces_.segment<6>(6 * nodes[i]) += forces.segment<6>(6 * static_cast<Index>(i));
  }

  const FiniteElementModel& model_;
  const AccelerationField& field_;
  Eigen::VectorXd forces_;
};

}  // namespace

AccelerationField& AccelerationField::operator+=(const AccelerationField& other) {
  constant += other.constant;
  gradient += other.gradient;
  return *this;
}

AccelerationField centrifugal_field(const Rotation& rotation) {
  AccelerationField field;
  field.gradient = rotation.speed * rotation.speed * across(rotation.axis);
  field.constant = -field.gradient * rotation.about;
  return field;
}

Eigen::VectorXd field_forces(const FiniteElementModel& model, const AccelerationField& field) {
  return FieldForces(model, field).sum();
}

Eigen::VectorXd centrifugal_forces(const FiniteElementModel& model, const Rotation& rotation) {
  return field_forces(model, centrifugal_field(rotation));
}

SparseMatrix spin_softening(const FiniteElementModel& model, const Rotation& rotation) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int node = 0; node < static_cast<int>(model.mesh.node_count()); ++node) {
    const Eigen::Matrix3d block = across(model.mesh.axes_of(node).transpose() * rotation.axis);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) entries.emplace_back(6 * node + i, 6 * node + j, block(i, j));
  }
  SparseMatrix projection(6 * model.mesh.node_count(), 6 * model.mesh.node_count());
  projection.setFromTriplets(entries.begin(), entries.end());
  return -rotation.speed * rotation.speed * SparseMatrix(projection * mass_of_nodes(model) * projection);
}

}  // namespace kalfem
