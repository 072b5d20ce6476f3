#include <algorithm>
#include <cmath>
#include <numbers>

#include "kalfem/formats/nastran/model_building.hpp"

namespace kalfem::nastran {
namespace {

/// Shells at a node are one surface where their normals lie within PARAM SNORM of their mean.
const double least_cosine = std::cos(20.0 * std::numbers::pi / 180.0);

/// The surface at a node.
struct NodalSurface {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< sum over the cells, by area
  double shear_stiffness = 0.0;                      ///< sum of G t |J|
  bool is_smooth = true;
};

double membrane_shear(const FiniteElementModel& model, const RegionProperty& property) {
  if (const auto* shell = std::get_if<ShellProperty>(&property))
    return model.materials.at(shell->material).shear_modulus() * shell->thickness;
  return std::get<LaminateProperty>(property).stiffness.membrane(2, 2);
}

bool is_shell(const RegionProperty& property) {
  return std::holds_alternative<ShellProperty>(property) || std::holds_alternative<LaminateProperty>(property);
}

/// Calls visit(nodes, normal times area, G t) for each shell.
template <typename Visit>
void for_each_shell(FiniteElementModel& model, const Visit& visit) {
  auto& mesh = model.mesh;
  for (const auto& [region, property] : model.properties) {
    if (!is_shell(property)) continue;
    const double shear = membrane_shear(model, property);
    for (const auto index : mesh.regions.at(region)) {
      const auto& cell = mesh.cells[static_cast<std::size_t>(index)];
      const auto nodes = mesh.nodes_of(cell);
      const auto place = [&](std::size_t i) -> Eigen::Vector3d { return mesh.nodes.col(nodes[i]); };
      const Eigen::Vector3d normal = nodes.size() == 3
                                         ? Eigen::Vector3d((place(1) - place(0)).cross(place(2) - place(0)))
                                         : Eigen::Vector3d((place(2) - place(0)).cross(place(3) - place(1)));
      visit(cell, Eigen::Vector3d(0.5 * normal), shear);
    }
  }
}

/// Nodes whose rotations something else than shells acts on.
std::vector<bool> turned_by_others(const FiniteElementModel& model) {
  std::vector<bool> turned(static_cast<std::size_t>(model.mesh.node_count()), false);
  const auto mark = [&](Eigen::Index node) { turned[static_cast<std::size_t>(node)] = true; };
  const auto mark_terms = [&](const auto& terms) {
    for (const auto& [dof, coefficient] : terms)
      if (dof.direction >= 3) mark(dof.node);
  };
  for (const auto& [region, property] : model.properties)
    if (std::holds_alternative<BeamProperty>(property))
      for (const auto cell : model.mesh.regions.at(region))
        for (const auto node : model.mesh.nodes_of(model.mesh.cells[static_cast<std::size_t>(cell)])) mark(node);
  for (const auto& joint : model.joints) mark_terms(joint.deformation);
  for (const auto& constraint : model.constraints) mark_terms(constraint.terms);
  for (const auto& item : model.matrices)
    for (const auto& dof : item.dofs)
      if (dof.direction >= 3 && item.stiffness.size() > 0) mark(dof.node);
  for (const auto& link : model.links) {
    mark(link.master);
    if (link.tied[3] || link.tied[4] || link.tied[5])
      for (const auto slave : link.slaves) mark(slave);
  }
  for (const auto& link : model.weighted_links) {
    if (link.tied[3] || link.tied[4] || link.tied[5]) mark(link.follower);
    for (const auto& share : link.shares)
      if (share.directions[3] || share.directions[4] || share.directions[5]) mark(share.node);
  }
  return turned;
}

std::vector<NodalSurface> nodal_surfaces(FiniteElementModel& model) {
  std::vector<NodalSurface> surfaces(static_cast<std::size_t>(model.mesh.node_count()));
  for_each_shell(model, [&](const Cell& cell, const Eigen::Vector3d& normal, double shear) {
    const auto nodes = model.mesh.nodes_of(cell);
    for (const auto node : nodes) {
      auto& surface = surfaces[static_cast<std::size_t>(node)];
      surface.normal += surface.normal.dot(normal) < 0.0 ? Eigen::Vector3d(-normal) : normal;
      surface.shear_stiffness += shear * normal.norm() * (nodes.size() == 3 ? 2.0 : 0.25);
    }
  });
  for_each_shell(model, [&](const Cell& cell, const Eigen::Vector3d& normal, double) {
    for (const auto node : model.mesh.nodes_of(cell)) {
      auto& surface = surfaces[static_cast<std::size_t>(node)];
      if (!(std::abs(surface.normal.dot(normal)) >= least_cosine * surface.normal.norm() * normal.norm()))
        surface.is_smooth = false;
    }
  });
  return surfaces;
}

/// The shells' own node moves with the given one but for the turn about the normal n: u' = u, and
/// theta'_i - theta_i = (n_i / n_p) (theta'_p - theta_p) with the largest component p of n.
void tie(FiniteElementModel& model, Eigen::Index node, Eigen::Index own, const Eigen::Vector3d& normal) {
  int largest = 0;
  normal.cwiseAbs().maxCoeff(&largest);
  const auto name = "drilling.n" + std::to_string(model.mesh.node_ids[static_cast<std::size_t>(node)]);
  for (int i = 0; i < 6; ++i) {
    if (i == 3 + largest) continue;
    MultiPointConstraint constraint{name + "." + std::to_string(i + 1), {{{own, i}, 1.0}, {{node, i}, -1.0}}};
    const double share = i < 3 ? 0.0 : normal[i - 3] / normal[largest];
    if (std::abs(share) > 1e-9) {
      constraint.terms.push_back({{own, 3 + largest}, -share});
      constraint.terms.push_back({{node, 3 + largest}, share});
    }
    model.constraints.push_back(std::move(constraint));
  }
}

}  // namespace

/// Shells of Nastran have no stiffness against turns about their normal but PARAM K6ROT: what else stands on such a
/// node turns there almost freely. Shells here carry these turns. Where shells of one surface meet beams, springs or
/// links, they get a node of their own at the same place, which follows in all but the turn about the normal, and the
/// spring
///     k = 1e-6 K6ROT sum G t |J|
/// between both turns [Cab], J being the Jacobian of the shape functions: |J| = A / 4 of a quadrilateral and 2 A of a
/// triangle. Of a triangle no manual says it; with 2 A the modes of ribs that end in triangles are those that Nastran
/// prints (the Pazy wing).
void release_drilling(Building& building) {
  auto& model = building.model;
  const auto turned = turned_by_others(model);
  const auto surfaces = nodal_surfaces(model);
  std::vector<Eigen::Index> own(turned.size(), -1);
  std::vector<Eigen::Vector3d> places;
  auto& mesh = model.mesh;
  const std::int64_t largest =
      mesh.node_ids.empty() ? 0 : *std::max_element(mesh.node_ids.begin(), mesh.node_ids.end());
  MatrixGather springs;
  for (std::size_t i = 0; i < turned.size(); ++i) {
    const auto& surface = surfaces[i];
    if (!turned[i] || !surface.is_smooth || !(surface.normal.norm() > 0.0)) continue;
    const auto node = static_cast<Eigen::Index>(i);
    own[i] = static_cast<Eigen::Index>(turned.size() + places.size());
    places.emplace_back(mesh.nodes.col(node));
    mesh.node_ids.push_back(largest + static_cast<std::int64_t>(places.size()));
    const Eigen::Vector3d normal = surface.normal.normalized();
    tie(model, node, own[i], normal);
    DofSum turn;
    for (int k = 0; k < 3; ++k)
      if (std::abs(normal[k]) > 1e-9) {
        turn.push_back({{own[i], 3 + k}, normal[k]});
        turn.push_back({{node, 3 + k}, -normal[k]});
      }
    springs.add(MatrixGather::stiffness, turn, turn, 1e-6 * building.bulk.drilling * surface.shear_stiffness);
  }
  if (places.empty()) return;
  building.note({}, "rotations of shells about their normal (K6ROT)",
                "where shells meet beams, springs or links, " + std::to_string(places.size()) +
                    " nodes of their own leave these rotations nearly free, as Nastran does");
  mesh.nodes.conservativeResize(3, mesh.nodes.cols() + static_cast<Eigen::Index>(places.size()));
  mesh.nodes.rightCols(static_cast<Eigen::Index>(places.size())) =
      Eigen::Map<const Eigen::Matrix3Xd>(places.front().data(), 3, static_cast<Eigen::Index>(places.size()));
  for_each_shell(model, [&](const Cell& cell, const Eigen::Vector3d&, double) {
    for (int i = 0; i < node_count(cell.shape); ++i) {
      auto& node = mesh.connectivity[static_cast<std::size_t>(cell.first + i)];
      if (node < static_cast<Eigen::Index>(own.size()) && own[static_cast<std::size_t>(node)] >= 0)
        node = own[static_cast<std::size_t>(node)];
    }
  });
  if (building.bulk.drilling > 0.0) model.matrices.push_back(springs.finish("drilling"));
}

}  // namespace kalfem::nastran
