// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/statics/stresses.hpp"

#include <array>
#include <cmath>

#include "kalfem/model/assembly/shell_edges.hpp"
#include "kalfem/model/elements/solid_strains.hpp"
#include "kalfem/model/elements/tapered_beam.hpp"
#include "kalfem/model/part_factors.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// Isotropic elasticity [Pa], or the property's.
Matrix6 elasticity_of(const SolidProperty& property, const IsotropicMaterial& material) {
  if (property.elasticity) return *property.elasticity;
  return material.youngs_modulus * isotropic_elasticity(material.poissons_ratio);
}

/// A symmetric tensor of [xx yy xy] in a plane with the given axes (rows), as [xx yy zz xy yz xz] in global ones.
Stress from_plane(const Eigen::Vector3d& plane, const Eigen::Matrix3d& axes) {
  Eigen::Matrix3d tensor = Eigen::Matrix3d::Zero();
  tensor.topLeftCorner<2, 2>() << plane[0], plane[2], plane[2], plane[1];
  const Eigen::Matrix3d global = axes.transpose() * tensor * axes;
  return (Stress() << global.diagonal(), global(0, 1), global(1, 2), global(0, 2)).finished();
}

/// Strains of one layer of a shell in global axes; the strain across it follows from the plane stress.
Strain layer_strain(const Eigen::Vector3d& plane, const Eigen::Matrix3d& axes, double poissons_ratio) {
  Strain strain = from_plane({plane[0], plane[1], 0.5 * plane[2]}, axes);
  const double across = -poissons_ratio / (1.0 - poissons_ratio) * (plane[0] + plane[1]);
  const Eigen::Vector3d n = axes.row(2);
  strain += across * (Strain() << n.cwiseAbs2(), n[0] * n[1], n[1] * n[2], n[0] * n[2]).finished();
  strain.tail<3>() *= 2.0;
  return strain;
}

/// Factors of an element's stiffness and mass, 1 where it has none.
class CellFactors {
public:
  explicit CellFactors(const FiniteElementModel& model)
      : stiffness_(factors_of_cells(model, FactorOf::stiffness)), mass_(factors_of_cells(model, FactorOf::mass)) {}

  [[nodiscard]] double stiffness(Index cell) const { return of(stiffness_, cell); }
  [[nodiscard]] double mass(Index cell) const { return of(mass_, cell); }

private:
  static double of(const std::vector<double>& all, Index cell) {
    return all.empty() ? 1.0 : all[static_cast<std::size_t>(cell)];
  }
  std::vector<double> stiffness_, mass_;
};

/// Recovers the cells of a region by the kind of its property.
class Recovery {
public:
  Recovery(const FiniteElementModel& model, const ShellEdges& edges, const CellFactors& factors,
           const VectorXd& displacements, const AccelerationField& field, const std::vector<BeamLoad>& beam_loads,
           RegionStress& region)
      : model_(model),
        edges_(edges),
        factors_(factors),
        displacements_(displacements),
        field_(field),
        beam_loads_(beam_loads),
        region_(region) {}

  void operator()(const SolidProperty& property) {
    const auto& material = model_.materials.at(property.material);
    const Matrix6 nominal = elasticity_of(property, material);
    for_each_cell([&](Index index, const Cell& cell, std::size_t) {
      const Matrix6 elasticity = factors_.stiffness(index) * nominal;
      const SolidStrains strains =
          solid_strains(cell.shape, places(cell), property, material.poissons_ratio, motions(cell, 3));
      const Index nodes = strains.cols() - 1;
      region_.cells.push_back({.cell = index,
                               .layers = {{.centre = elasticity * strains.col(nodes),
                                           .strain = strains.col(nodes),
                                           .at_nodes = elasticity * strains.leftCols(nodes)}}});
    });
  }

  void operator()(const ShellProperty& property) {
    const auto& material = model_.materials.at(property.material);
    const double nu = material.poissons_ratio, t = property.thickness;
    const ShellStiffness unit = isotropic_section(nu, t);
    for_each_cell([&](Index index, const Cell& cell, std::size_t) {
      const double modulus = factors_.stiffness(index) * material.youngs_modulus;
      const Eigen::Matrix3d elasticity = modulus * plane_stress(nu);
      const ShellStrains strains = shell_strains(places(cell), unit, property.offset, Eigen::Vector3d::Zero(),
                                                 corner_motions(index), edges_.drilling(index));
      CellStress stress{.cell = index, .normal = strains.axes.row(2)};
      for (const auto& [layer, height] :
           {std::pair{Layer::top, 0.5 * t}, {Layer::middle, 0.0}, {Layer::bottom, -0.5 * t}}) {
        const auto plane_strain = [&](const SectionStrain& all) -> Eigen::Vector3d {
          return all.head<3>() + height * all.segment<3>(3);
        };
        const Eigen::Vector3d centre = plane_strain(strains.centre());
        LayerStress part{.layer = layer,
                         .centre = from_plane(elasticity * centre, strains.axes),
                         .strain = layer_strain(centre, strains.axes, nu)};
        part.at_nodes.resize(6, strains.corners.cols());
        for (Index i = 0; i < strains.corners.cols(); ++i)
          part.at_nodes.col(i) = from_plane(elasticity * plane_strain(strains.corners.col(i)), strains.axes);
        stress.layers.push_back(std::move(part));
      }
      region_.cells.push_back(std::move(stress));
      add_resultants(index, strains, modulus, unit);
    });
  }

  void operator()(const LaminateProperty& property) {
    for_each_cell([&](Index index, const Cell& cell, std::size_t place) {
      const ShellStrains strains =
          shell_strains(places(cell), property.stiffness, property.offset, property.direction(place),
                        corner_motions(index), edges_.drilling(index));
      add_resultants(index, strains, factors_.stiffness(index), property.stiffness);
    });
  }

  void operator()(const BeamProperty& property) {
    const auto& material = model_.materials.at(property.material);
    for_each_cell([&](Index index, const Cell& cell, std::size_t place) {
      const auto forces = [&](const VectorXd& moved, const BeamField& field,
                              const Eigen::Matrix<double, 12, 1>& loads) {
        return beam_forces(places(cell), property, property.placement(place), material, model_.mass_kind, moved, field,
                           loads);
      };
      const double of_mass = factors_.mass(index);
      const BeamField field{of_mass * at_nodes(cell), of_mass * field_.gradient};
      BeamStress stress{.cell = index,
                        .ends = forces(factors_.stiffness(index) * motions(cell, 6), field, loads_of(index))};
      for (std::size_t end = 0; end < 2; ++end) {
        const BeamSection section = section_at(property, static_cast<double>(end));
        stress.axial[end] = stress.ends[end][0] / section.area;
        stress.fibres[end] = fibre_stress(stress.ends[end], section);
      }
      region_.beams.push_back(stress);
    });
  }

private:
  template <class Visit>
  void for_each_cell(const Visit& visit) {
    const auto& cells = model_.mesh.regions.at(region_.region);
    for (std::size_t i = 0; i < cells.size(); ++i)
      visit(cells[i], model_.mesh.cells[static_cast<std::size_t>(cells[i])], i);
  }

  [[nodiscard]] Eigen::Matrix3Xd places(const Cell& cell) const {
    return model_.mesh.nodes(Eigen::all, model_.mesh.nodes_of(cell));
  }

  /// The field at the ends of a beam.
  [[nodiscard]] Eigen::Matrix<double, 3, 2> at_nodes(const Cell& cell) const {
    return (field_.gradient * places(cell)).colwise() + field_.constant;
  }

  /// What loads on its line add up to at the nodes of a beam.
  [[nodiscard]] Eigen::Matrix<double, 12, 1> loads_of(Index cell) const {
    Eigen::Matrix<double, 12, 1> sum = Eigen::Matrix<double, 12, 1>::Zero();
    for (const auto& load : beam_loads_)
      if (load.cell == cell) sum += load.forces;
    return sum;
  }

  /// The first `count` motions of each node of the cell.
  [[nodiscard]] VectorXd motions(const Cell& cell, Index count) const {
    const auto nodes = model_.mesh.nodes_of(cell);
    VectorXd all(count * static_cast<Index>(nodes.size()));
    for (std::size_t i = 0; i < nodes.size(); ++i)
      all.segment(count * static_cast<Index>(i), count) = displacements_.segment(6 * nodes[i], count);
    return all;
  }

  /// Of a shell.
  [[nodiscard]] VectorXd corner_motions(Index cell) const {
    return edges_.corner_motions(model_.mesh, cell, displacements_);
  }

  void add_resultants(Index cell, const ShellStrains& strains, double modulus, const ShellStiffness& section) {
    const SectionStrain centre = strains.centre();
    const Eigen::Vector3d stretch = centre.head<3>(), bend = centre.segment<3>(3);
    ShellResultants resultants{.cell = cell, .axes = strains.axes, .values = {}};
    resultants.values << section.membrane * stretch + section.coupling * bend,
        section.coupling * stretch + section.bending * bend, section.shear * centre.tail<2>();
    resultants.values *= modulus;
    region_.resultants.push_back(resultants);
  }

  const FiniteElementModel& model_;
  const ShellEdges& edges_;
  const CellFactors& factors_;
  const VectorXd& displacements_;
  const AccelerationField& field_;
  const std::vector<BeamLoad>& beam_loads_;
  RegionStress& region_;
};

}  // namespace

double von_mises(const Stress& stress) {
  const double xy = stress[0] - stress[1], yz = stress[1] - stress[2], zx = stress[2] - stress[0];
  return std::sqrt(0.5 * (xy * xy + yz * yz + zx * zx) + 3.0 * stress.tail<3>().squaredNorm());
}

Eigen::Vector3d principal_stresses(const Stress& s) {
  const Eigen::Matrix3d tensor{{s[0], s[3], s[5]}, {s[3], s[1], s[4]}, {s[5], s[4], s[2]}};
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(tensor, Eigen::EigenvaluesOnly).eigenvalues().reverse();
}

const char* to_string(Layer layer) {
  constexpr std::array names = {"", "top", "middle", "bottom"};
  return names[static_cast<std::size_t>(layer)];
}

std::vector<RegionStress> recover_stresses(const FiniteElementModel& model, const VectorXd& displacements,
                                           const AccelerationField& field, const std::vector<BeamLoad>& beam_loads) {
  const ShellEdges edges(model);
  const CellFactors factors(model);
  std::vector<RegionStress> regions;
  for (const auto& [region, property] : model.properties) {
    regions.push_back({.region = region});
    std::visit(Recovery(model, edges, factors, displacements, field, beam_loads, regions.back()), property);
  }
  return regions;
}

}  // namespace kalfem
