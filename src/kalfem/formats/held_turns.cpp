// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/held_turns.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Rotations that a node keeps held, as a projection, and under which name.
struct Kept {
  Matrix3d span;
  std::string name = {};
};
using KeptTurns = std::map<Index, Kept>;

/// Nodes whose turn about the normal is held, with what stays: V without its part p = P n along the normal.
KeptTurns kept_turns(const FiniteElementModel& model, const std::vector<NodalSurface>& surfaces,
                     const std::vector<bool>& turned) {
  constexpr double negligible = 1e-6;
  const HeldMotions held(model);
  KeptTurns kept;
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    if (turned[i] || !surfaces[i].is_surface()) continue;
    const auto node = static_cast<Index>(i);
    const Vector3d normal = surfaces[i].normal.normalized();
    const Matrix3d rotations = held.rotations(node);
    const Vector3d about = rotations * normal;
    if (about.norm() < negligible || is_held_in_plane(held, node, surfaces[i])) continue;
    const Vector3d unit = about.normalized();
    kept[node] = {rotations - unit * unit.transpose()};
  }
  return kept;
}

/// Takes rotations out of the supports, but for those along global axes that stay; these leave `kept`. Nodes of one
/// support that lose different directions become several supports of the same name.
void reduce_supports(FiniteElementModel& model, KeptTurns& kept) {
  std::vector<FixedNodes> supports;
  for (const auto& support : model.fixed) {
    std::map<std::array<bool, 6>, std::vector<Index>> nodes;  // by what stays held
    for (const auto node : support.nodes) {
      auto directions = support.directions;
      if (const auto own = kept.find(node); own != kept.end())
        for (int k = 0; k < 3; ++k) {
          bool& holds = directions[static_cast<std::size_t>(3 + k)];
          if (!holds) continue;
          own->second.name = support.name;
          const Vector3d axis = Vector3d::Unit(k);
          holds = (own->second.span * axis - axis).norm() < 1e-9;
          if (holds) own->second.span -= axis * axis.transpose();
        }
      nodes[directions].push_back(node);
    }
    for (auto& [directions, list] : nodes)
      if (std::ranges::count(directions, true) > 0) supports.push_back({support.name, std::move(list), directions});
  }
  model.fixed = std::move(supports);
}

/// Takes the constraints that hold rotations of these nodes away.
void remove_constraints(FiniteElementModel& model, KeptTurns& kept) {
  std::erase_if(model.constraints, [&](const MultiPointConstraint& constraint) {
    if (!holds_one_node(constraint) || constraint.terms.front().first.direction < 3) return false;
    const auto own = kept.find(constraint.terms.front().first.node);
    if (own != kept.end() && own->second.name.empty()) own->second.name = constraint.name;
    return own != kept.end();
  });
}

/// {rotation `from` of the node} = share {rotation `to`}.
MultiPointConstraint follow(const std::string& name, Index node, int from, int to, double share) {
  MultiPointConstraint constraint{name + "." + std::to_string(4 + from), {{{node, 3 + from}, 1.0}}};
  if (std::abs(share) > 1e-12) constraint.terms.push_back({{node, 3 + to}, -share});
  return constraint;
}

/// v^T theta = 0, in which the largest component follows.
MultiPointConstraint hold_along(const std::string& name, Index node, const Vector3d& v) {
  int largest = 0;
  v.cwiseAbs().maxCoeff(&largest);
  MultiPointConstraint constraint{name + "." + std::to_string(4 + largest), {{{node, 3 + largest}, v[largest]}}};
  for (int k = 0; k < 3; ++k)
    if (k != largest && std::abs(v[k]) > 1e-12) constraint.terms.push_back({{node, 3 + k}, v[k]});
  return constraint;
}

/// Holds what is left, along oblique axes: one direction, or all at right angles to the axis w, theta = (w^T theta) w.
void add_constraints(FiniteElementModel& model, const KeptTurns& kept) {
  for (const auto& [node, own] : kept) {
    const Eigen::SelfAdjointEigenSolver<Matrix3d> axes(own.span);  // eigenvalues 0 and 1, ascending
    const auto rank = (axes.eigenvalues().array() > 0.5).count();
    const std::string name =
        own.name + ".n" + std::to_string(model.mesh.node_ids[static_cast<std::size_t>(node)]) + ".turns";
    if (rank == 1) model.constraints.push_back(hold_along(name, node, axes.eigenvectors().col(2)));
    if (rank != 2) continue;
    const Vector3d w = axes.eigenvectors().col(0);
    int largest = 0;
    w.cwiseAbs().maxCoeff(&largest);
    for (int k = 0; k < 3; ++k)
      if (k != largest) model.constraints.push_back(follow(name, node, k, largest, w[k] / w[largest]));
  }
}

/// The shells' own node moves with the given one but for the turn about the normal n: u' = u, and
/// theta'_i - theta_i = (n_i / n_p) (theta'_p - theta_p) with the largest component p of n.
void tie(FiniteElementModel& model, Index node, Index own, const Vector3d& normal) {
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

std::size_t release_turns_about_normal(FiniteElementModel& model, const std::vector<NodalSurface>& surfaces,
                                       const std::vector<bool>& turned) {
  auto kept = kept_turns(model, surfaces, turned);
  if (kept.empty()) return 0;
  reduce_supports(model, kept);
  remove_constraints(model, kept);
  add_constraints(model, kept);
  return kept.size();
}

std::vector<Index> separate_shells(FiniteElementModel& model, const std::vector<NodalSurface>& surfaces,
                                   const std::vector<bool>& wanted) {
  auto& mesh = model.mesh;
  std::vector<Index> own(wanted.size(), -1);
  std::vector<Vector3d> places;
  const std::int64_t largest =
      mesh.node_ids.empty() ? 0 : *std::max_element(mesh.node_ids.begin(), mesh.node_ids.end());
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    if (!wanted[i] || !surfaces[i].is_surface()) continue;
    const auto node = static_cast<Index>(i);
    own[i] = mesh.node_count() + static_cast<Index>(places.size());
    places.emplace_back(mesh.nodes.col(node));
    mesh.node_ids.push_back(largest + static_cast<std::int64_t>(places.size()));
    tie(model, node, own[i], surfaces[i].normal.normalized());
  }
  if (places.empty()) return own;
  const auto count = static_cast<Index>(places.size());
  mesh.nodes.conservativeResize(3, mesh.nodes.cols() + count);
  mesh.nodes.rightCols(count) = Eigen::Map<const Eigen::Matrix3Xd>(places.front().data(), 3, count);
  for_each_shell(model, [&](const Cell& cell, const Vector3d&, double) {
    for (int i = 0; i < node_count(cell.shape); ++i) {
      auto& node = mesh.connectivity[static_cast<std::size_t>(cell.first + i)];
      if (node < static_cast<Index>(own.size()) && own[static_cast<std::size_t>(node)] >= 0)
        node = own[static_cast<std::size_t>(node)];
    }
  });
  return own;
}

DofSum turn_between(Index node, Index own, const NodalSurface& surface) {
  const Vector3d normal = surface.normal.normalized();
  DofSum turn;
  for (int k = 0; k < 3; ++k)
    if (std::abs(normal[k]) > 1e-9) {
      turn.push_back({{own, 3 + k}, normal[k]});
      turn.push_back({{node, 3 + k}, -normal[k]});
    }
  return turn;
}

}  // namespace kalfem
