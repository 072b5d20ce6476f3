// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/shell_surfaces.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "kalfem/model/assembly/held_motions.hpp"

namespace kalfem {
namespace {

/// Shells at a node are one surface where their normals lie within PARAM SNORM of their mean.
const double least_cosine = std::cos(20.0 * std::numbers::pi / 180.0);

double membrane_shear(const FiniteElementModel& model, const RegionProperty& property) {
  if (const auto* shell = std::get_if<ShellProperty>(&property))
    return model.materials.at(shell->material).shear_modulus() * shell->thickness;
  return std::get<LaminateProperty>(property).stiffness.membrane(2, 2);
}

bool is_shell(const RegionProperty& property) {
  return std::holds_alternative<ShellProperty>(property) || std::holds_alternative<LaminateProperty>(property);
}

/// Directions in which supports hold each node, a bit each.
std::vector<unsigned char> held_directions(const FiniteElementModel& model) {
  std::vector<unsigned char> held(static_cast<std::size_t>(model.mesh.node_count()), 0);
  for (const auto& support : model.fixed)
    for (const auto node : support.nodes)
      for (std::size_t i = 0; i < 6; ++i)
        if (support.directions[i]) held[static_cast<std::size_t>(node)] |= static_cast<unsigned char>(1u << i);
  return held;
}

}  // namespace

void for_each_shell(const FiniteElementModel& model, const ShellVisitor& visit) {
  const auto& mesh = model.mesh;
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

// Two passes: normals are summed by area, each turned to the side of the sum so far, as neighbours may be numbered
// either way round; then every cell's normal is compared with the mean, as one sharp fold makes the node no smooth
// surface.
std::vector<NodalSurface> nodal_surfaces(const FiniteElementModel& model) {
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
  for (const auto& constraint : model.constraints)
    if (!holds_one_node(constraint)) mark_terms(constraint.terms);
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

bool is_held_in_plane(const HeldMotions& held, Eigen::Index node, const NodalSurface& surface) {
  const Eigen::Vector3d normal = surface.normal.normalized();
  const Eigen::Matrix3d translations = held.translations(node);
  return (translations - normal * (normal.transpose() * translations)).norm() > 1e-6;
}

std::vector<NodalDof> held_drilling(const FiniteElementModel& model, const std::vector<NodalSurface>& surfaces) {
  constexpr double negligible = 1e-6;
  const auto held = held_directions(model);
  const HeldMotions motions(model);
  std::vector<NodalDof> dofs;
  for (std::size_t i = 0; i < held.size(); ++i) {
    if (!surfaces[i].is_surface() || is_held_in_plane(motions, static_cast<Eigen::Index>(i), surfaces[i])) continue;
    for (int k = 0; k < 3; ++k)
      if (((held[i] >> (3 + k)) & 1u) != 0 && std::abs(surfaces[i].normal[k]) > negligible * surfaces[i].normal.norm())
        dofs.push_back({static_cast<Eigen::Index>(i), 3 + k});
  }
  return dofs;
}

bool is_along_normal(const std::vector<NodalSurface>& surfaces, const NodalDof& dof) {
  const Eigen::Vector3d normal = surfaces[static_cast<std::size_t>(dof.node)].normal.normalized();
  return std::abs(normal[dof.direction - 3]) > 1.0 - 1e-9;
}

// Nodes of one support that lose different directions become several supports of the same name.
void release(FiniteElementModel& model, const std::vector<NodalDof>& dofs) {
  std::vector<FixedNodes> kept;
  for (const auto& support : model.fixed) {
    std::map<std::array<bool, 6>, std::vector<Eigen::Index>> nodes;  // by what stays held
    for (const auto node : support.nodes) {
      auto directions = support.directions;
      for (int i = 0; i < 6; ++i)
        if (std::ranges::binary_search(dofs, NodalDof{node, i})) directions[static_cast<std::size_t>(i)] = false;
      nodes[directions].push_back(node);
    }
    for (auto& [directions, list] : nodes)
      if (std::ranges::count(directions, true) > 0) kept.push_back({support.name, std::move(list), directions});
  }
  model.fixed = std::move(kept);
}

}  // namespace kalfem
