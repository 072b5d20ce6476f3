// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/gauges/strain_gauge.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/model/assembly/shell_edges.hpp"
#include "kalfem/model/elements/solid_strains.hpp"
#include "kalfem/model/elements/tapered_beam.hpp"
#include "kalfem/model/gauges/nearest_place.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// A region with a property that a cell belongs to, and the cell's place in it.
struct Membership {
  const RegionProperty& property;
  std::size_t place;
};

Membership property_of(const FiniteElementModel& model, Index cell) {
  for (const auto& [region, property] : model.properties) {
    const auto& cells = model.mesh.regions.at(region);
    if (const auto found = std::ranges::find(cells, cell); found != cells.end())
      return {property, static_cast<std::size_t>(found - cells.begin())};
  }
  throw InvalidInput("a strain gauge stands on a cell without a property", "only elements have strains", "");
}

/// d^T epsilon d of [xx yy zz xy yz xz] with engineering shear.
double along(const Eigen::Vector3d& d, const Strain& strain) {
  return Strain(d[0] * d[0], d[1] * d[1], d[2] * d[2], d[0] * d[1], d[1] * d[2], d[0] * d[2]).dot(strain);
}

/// The strain of a gauge under motions of its cell's nodes, by the kind of the property.
class GaugeStrain {
public:
  GaugeStrain(const FiniteElementModel& model, const DrillingOptions& drilling, const StrainGauge& gauge,
              std::size_t place_in_region)
      : model_(model),
        drilling_(drilling),
        gauge_(gauge),
        place_in_region_(place_in_region),
        cell_(model.mesh.cells[static_cast<std::size_t>(gauge.cell)]),
        nodes_(model.mesh.nodes(Eigen::all, model.mesh.nodes_of(cell_))),
        shares_(corner_shares(cell_.shape, gauge.natural)) {}

  /// Strain per motion of each node in turn, motions_per_node() of each.
  VectorXd operator()(const SolidProperty& property) const {
    const double nu = model_.materials.at(property.material).poissons_ratio;
    const Eigen::Vector3d direction = gauge_.direction.normalized();
    return by_unit_motions(3, [&](const VectorXd& motions) {
      const SolidStrains strains = solid_strains(cell_.shape, nodes_, property, nu, motions);
      return along(direction, strains.leftCols(shares_.size()) * shares_);
    });
  }

  VectorXd operator()(const ShellProperty& property) const {
    const double nu = model_.materials.at(property.material).poissons_ratio;
    return of_shell(isotropic_section(nu, property.thickness), property.offset, Eigen::Vector3d::Zero(),
                    height_above_middle(property.thickness));
  }

  VectorXd operator()(const LaminateProperty& property) const {
    if (gauge_.surface != Layer::middle)
      throw InvalidInput("strain gauge '" + gauge_.name + "' stands on the " + to_string(gauge_.surface) +
                             " of a shell that is given by its stiffness",
                         "its thickness is not known", "write surface: middle");
    return of_shell(property.stiffness, property.offset, property.direction(place_in_region_), 0.0);
  }

  VectorXd operator()(const BeamProperty& property) const {
    const auto& material = model_.materials.at(property.material);
    return by_unit_motions(6, [&](const VectorXd& motions) {
      const auto ends =
          beam_forces(nodes_, property, property.placement(place_in_region_), material, model_.mass_kind, motions);
      const SectionForces forces = shares_[0] * ends[0] + shares_[1] * ends[1];
      return axial_stress(forces, section_at(property, shares_[1]), gauge_.fibre) / material.youngs_modulus;
    });
  }

private:
  template <class StrainOf>
  [[nodiscard]] VectorXd by_unit_motions(Index per_node, const StrainOf& strain_of) const {
    VectorXd row(per_node * nodes_.cols());
    for (Index i = 0; i < row.size(); ++i) row[i] = strain_of(VectorXd::Unit(row.size(), i));
    return row;
  }

  [[nodiscard]] double height_above_middle(double thickness) const {
    if (gauge_.surface == Layer::middle) return 0.0;
    return gauge_.surface == Layer::top ? 0.5 * thickness : -0.5 * thickness;
  }

  [[nodiscard]] VectorXd of_shell(const ShellStiffness& section, double offset, const Eigen::Vector3d& x_axis,
                                  double height) const {
    return by_unit_motions(6, [&](const VectorXd& motions) {
      const ShellStrains strains = shell_strains(nodes_, section, offset, x_axis, motions, drilling_);
      const SectionStrain here = strains.corners * shares_;
      const Eigen::Vector3d plane = here.head<3>() + height * here.segment<3>(3);
      const Eigen::Vector2d a = direction_in_surface(strains.axes);
      return a[0] * a[0] * plane[0] + a[1] * a[1] * plane[1] + a[0] * a[1] * plane[2];
    });
  }

  /// Along the x and y axes of the section. `axes`: see ShellStrains.
  [[nodiscard]] Eigen::Vector2d direction_in_surface(const Eigen::Matrix3d& axes) const {
    constexpr double least_part = 0.2;  // sine of the angle between direction and normal, 12 degrees
    const Eigen::Vector2d part = axes.topRows<2>() * gauge_.direction.normalized();
    if (part.norm() < least_part)
      throw InvalidInput("the direction of strain gauge '" + gauge_.name + "' is normal to its shell",
                         "a gauge measures along the surface it is bonded to",
                         "give a direction in the plane of element " + std::to_string(cell_.id));
    return part.normalized();
  }

  const FiniteElementModel& model_;
  const DrillingOptions& drilling_;
  const StrainGauge& gauge_;
  std::size_t place_in_region_;
  const Cell& cell_;
  Eigen::Matrix3Xd nodes_;
  VectorXd shares_;  ///< of the corners in the strain at the gauge
};

/// c^T T over the independent degrees of freedom, c of the row, with those left out that are rounding.
VectorXd over_independent(const DofSum& row, const AssembledModel& assembled) {
  Eigen::SparseVector<double> all(assembled.expansion.rows());
  double size = 0.0;
  for (const auto& [dof, coefficient] : row) {
    all.coeffRef(6 * dof.node + dof.direction) += coefficient;
    size = std::max(size, std::abs(coefficient));
  }
  const VectorXd independent = assembled.expansion.transpose() * all;
  return (independent.array().abs() > 1e-12 * size).select(independent, 0.0);
}

}  // namespace

DofSum strain_row(const FiniteElementModel& model, const StrainGauge& gauge) {
  const auto [property, place] = property_of(model, gauge.cell);
  const ShellEdges edges(model);
  const VectorXd coefficients = std::visit(GaugeStrain(model, edges.drilling(gauge.cell), gauge, place), property);
  const int per_node = motions_per_node(property);
  const auto nodes = model.mesh.nodes_of(model.mesh.cells[static_cast<std::size_t>(gauge.cell)]);
  DofSum row;
  for (Index i = 0; i < coefficients.size(); ++i)
    row.push_back({{nodes[static_cast<std::size_t>(i / per_node)], static_cast<int>(i % per_node)}, coefficients[i]});
  for (const auto& [motion, dof, share] : edges.shares(gauge.cell))
    row.push_back({{dof / 6, static_cast<int>(dof % 6)}, share * coefficients[motion]});
  return row;
}

std::map<std::string, DofCombination> gauge_combinations(const FiniteElementModel& model,
                                                         const AssembledModel& assembled,
                                                         const std::vector<StrainGauge>& gauges) {
  std::map<std::string, DofCombination> combinations;
  IssueList issues;
  for (const auto& gauge : gauges) {
    const VectorXd independent = over_independent(strain_row(model, gauge), assembled);
    if (independent.isZero(0.0)) {
      const auto id = model.mesh.cells[static_cast<std::size_t>(gauge.cell)].id;
      issues.add({},
                 "strain gauge '" + gauge.name + "' stands on element " + std::to_string(id) + ", which cannot deform",
                 "its nodes are fixed or follow one rigid body", "place it on an element beside the rigid part");
    }
    DofCombination& combination = combinations[gauge.name];
    for (Index i = 0; i < independent.size(); ++i)
      if (independent[i] != 0.0)
        combination[dof_name(model.mesh, assembled.dofs[static_cast<std::size_t>(i)])] = independent[i];
  }
  issues.raise();
  return combinations;
}

}  // namespace kalfem
