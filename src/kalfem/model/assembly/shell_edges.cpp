// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/assembly/shell_edges.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <set>

#include "kalfem/model/assembly/held_motions.hpp"
#include "kalfem/model/elements/shell.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

/// Shells that meet at a smaller angle than 45 degrees are one surface.
constexpr double least_cosine = 0.70710678118654752;
/// A surface is flat if the normals of its shells are within one degree of that of its first one.
constexpr double flat_cosine = 0.99984769515639127;
/// Rest of n that g may leave where the edge runs straight on. The sides of a curved surface's edge are in no one
/// plane.
constexpr double flat_rest = 0.01, curved_rest = 0.5;

/// A shell with the normal of its corners' order.
struct Facet {
  Index cell = 0;
  std::span<const Index> nodes;
  Vector3d normal;
  std::array<int, 4> partners = {};    ///< shells of the same surface at each side
  std::array<bool, 4> straight = {};   ///< sides that do not bulge
  std::array<bool, 4> following = {};  ///< corners

  [[nodiscard]] std::size_t count() const { return nodes.size(); }
  [[nodiscard]] bool is_triangle() const { return nodes.size() == 3; }
  [[nodiscard]] Index end(std::size_t side) const { return nodes[(side + 1) % nodes.size()]; }
};

/// The side of a facet, outwards.
struct Side {
  std::array<Index, 2> ends;  ///< ascending
  std::size_t facet, side;
};

std::vector<Facet> facets_of(const FiniteElementModel& model) {
  std::vector<Facet> facets;
  const auto& mesh = model.mesh;
  for (const auto& [region, property] : model.properties) {
    if (!std::holds_alternative<ShellProperty>(property) && !std::holds_alternative<LaminateProperty>(property))
      continue;
    for (const auto index : mesh.regions.at(region)) {
      const auto nodes = mesh.nodes_of(mesh.cells[static_cast<std::size_t>(index)]);
      const Vector3d last = mesh.nodes.col(nodes.back()), first = mesh.nodes.col(nodes[0]),
                     second = mesh.nodes.col(nodes[1]), third = mesh.nodes.col(nodes[2]);
      const Vector3d normal =
          nodes.size() == 3 ? (second - first).cross(third - first) : (third - first).cross(last - second);
      if (normal.norm() > 0.0) facets.push_back({.cell = index, .nodes = nodes, .normal = normal.normalized()});
    }
  }
  return facets;
}

/// Length times the normal of a side in the plane of its facet, outwards.
Vector3d outward(const Mesh& mesh, const Facet& facet, std::size_t side) {
  const Vector3d along = mesh.nodes.col(facet.end(side)) - mesh.nodes.col(facet.nodes[side]);
  return along.cross(facet.normal);
}

/// Whether the axes of held rotations span the normal.
bool holds_turn(const HeldMotions& held, Index node, const Vector3d& normal) {
  return (held.rotations(node) * normal - normal).norm() < 1e-6;
}

/// Whether the one axis of rotations that is left free, if any, leans less than 30 degrees out of the surface.
bool nearly_holds_turn(const HeldMotions& held, Index node, const Vector3d& normal) {
  return (held.rotations(node) * normal - normal).norm() < 0.5;
}

/// Whether a held translation has a part along the surface.
bool holds_in_plane(const HeldMotions& held, Index node, const Vector3d& normal) {
  const Eigen::Matrix3d translations = held.translations(node);
  return (translations - normal * (normal.transpose() * translations)).norm() > 1e-6;
}

void find_following(const HeldMotions& held, std::vector<Facet>& facets) {
  if (held.empty()) return;
  std::set<Index> follow;
  for (const auto& facet : facets) {
    const bool turns =
        std::ranges::all_of(facet.nodes, [&](Index node) { return holds_turn(held, node, facet.normal); });
    const bool moves =
        std::ranges::any_of(facet.nodes, [&](Index node) { return !holds_in_plane(held, node, facet.normal); });
    if (turns && moves) follow.insert(facet.nodes.begin(), facet.nodes.end());
  }
  for (auto& facet : facets)
    for (std::size_t i = 0; !follow.empty() && i < facet.count(); ++i)
      facet.following[i] = follow.contains(facet.nodes[i]) && holds_turn(held, facet.nodes[i], facet.normal);
}

/// Joined facets are one surface: a forest of facets, of which each root stands for a surface.
class Surfaces {
public:
  explicit Surfaces(std::size_t count) : parents_(count) {
    std::iota(parents_.begin(), parents_.end(), std::size_t{0});
  }
  std::size_t root(std::size_t facet) {
    while (parents_[facet] != facet) facet = parents_[facet] = parents_[parents_[facet]];
    return facet;
  }
  void join(std::size_t one, std::size_t other) { parents_[root(one)] = root(other); }

private:
  std::vector<std::size_t> parents_;
};

bool are_one_surface(const Mesh& mesh, const Facet& one, std::size_t side, const Facet& other, std::size_t other_side) {
  return std::abs(one.normal.dot(other.normal)) >= least_cosine &&
         outward(mesh, one, side).dot(outward(mesh, other, other_side)) < 0.0;
}

/// Counts the partners of each side; those of triangles beside quadrilaterals are straight.
void find_partners(const Mesh& mesh, std::vector<Facet>& facets, Surfaces& surfaces) {
  std::vector<Side> sides;
  for (std::size_t f = 0; f < facets.size(); ++f)
    for (std::size_t i = 0; i < facets[f].count(); ++i) {
      const Index a = facets[f].nodes[i], b = facets[f].end(i);
      sides.push_back({{std::min(a, b), std::max(a, b)}, f, i});
    }
  std::ranges::sort(sides, {}, &Side::ends);
  for (auto first = sides.begin(); first != sides.end();) {
    const auto last = std::find_if(first, sides.end(), [&](const Side& side) { return side.ends != first->ends; });
    for (auto one = first; one != last; ++one)
      for (auto other = first; other != last; ++other) {
        if (one == other || !are_one_surface(mesh, facets[one->facet], one->side, facets[other->facet], other->side))
          continue;
        ++facets[one->facet].partners[one->side];
        if (!facets[other->facet].is_triangle()) facets[one->facet].straight[one->side] = true;
        surfaces.join(one->facet, other->facet);
      }
    first = last;
  }
}

/// No corners of curved surfaces follow: where a shell bends, a held rotation is not one in a plane.
std::vector<bool> facets_of_flat_surfaces(std::vector<Facet>& facets, Surfaces& surfaces) {
  std::vector<bool> flat(facets.size(), true);
  for (std::size_t f = 0; f < facets.size(); ++f) {
    const std::size_t root = surfaces.root(f);
    if (std::abs(facets[f].normal.dot(facets[root].normal)) < flat_cosine) flat[root] = false;
  }
  for (std::size_t f = 0; f < facets.size(); ++f) {
    flat[f] = flat[surfaces.root(f)];
    if (!flat[f]) facets[f].following = {};
  }
  return flat;
}

/// g_1 and g_2 with n = g_1 m_1 + g_2 m_2, of moderate size; nothing where there are none.
std::optional<std::array<double, 2>> force_shares(const Vector3d& n, const Vector3d& m1, const Vector3d& m2,
                                                  double length, double largest_rest) {
  const double largest = 4.0 / length;
  Eigen::Matrix<double, 3, 2> m;
  m << m1, m2;
  // The edge turns at an end: both are needed. Otherwise n, m_1 and m_2 are along one line, and the smallest serve.
  for (const auto& [threshold, rest] : {std::pair{1e-9, 1e-3}, {0.1, largest_rest}}) {
    const Eigen::JacobiSVD<Eigen::MatrixXd> solver = [&, threshold = threshold] {
      Eigen::JacobiSVD<Eigen::MatrixXd> svd(m, Eigen::ComputeThinU | Eigen::ComputeThinV);
      svd.setThreshold(threshold);
      return svd;
    }();
    const Eigen::Vector2d g = solver.solve(n);
    if (g.cwiseAbs().maxCoeff() <= largest && (m * g - n).norm() <= rest) return std::array{g[0], g[1]};
  }
  return std::nullopt;
}

/// A part of the displacement of a node at an edge: along `direction`, per difference of two drilling rotations.
struct BulgePart {
  Vector3d direction, normal;
  Index from = 0, to = 0;
};
using NodeOfSurface = std::pair<std::size_t, Index>;

/// The sides of edges, each with its facet, and m_i of the edges' nodes.
class Edges {
public:
  Edges(const Mesh& mesh, const HeldMotions& held, std::vector<Facet>& facets, Surfaces& surfaces,
        const std::vector<bool>& flat)
      : mesh_(mesh), held_(held), facets_(facets), surfaces_(surfaces), flat_(flat) {
    for (std::size_t f = 0; f < facets.size(); ++f)
      for (std::size_t i = 0; i < facets[f].count(); ++i) {
        if (facets[f].partners[i] > 0) continue;
        const Vector3d half = 0.5 * outward(mesh, facets[f], i);
        for (const auto node : {facets[f].nodes[i], facets[f].end(i)})
          normals_.try_emplace({surfaces.root(f), node}, Vector3d::Zero()).first->second += half;
        if (facets[f].is_triangle() && !facets[f].straight[i]) bulging_.emplace_back(f, i);
      }
    for (const auto& [facet, side] : bulging_) add(facet, side);
  }

  [[nodiscard]] const std::vector<BulgePart>* parts(std::size_t facet, Index node) {
    const auto own = parts_.find({surfaces_.root(facet), node});
    return own == parts_.end() ? nullptr : &own->second;
  }

private:
  void add(std::size_t f, std::size_t side) {
    Facet& facet = facets_[f];
    const std::size_t surface = surfaces_.root(f);
    const Index from = facet.nodes[side], to = facet.end(side);
    if (nearly_holds_turn(held_, from, facet.normal) && nearly_holds_turn(held_, to, facet.normal)) return;
    const Vector3d across = outward(mesh_, facet, side), n = across.normalized();
    const auto in_plane = [&](Index node) -> Vector3d {
      const Vector3d& m = normals_.at({surface, node});
      return m - facet.normal * facet.normal.dot(m);
    };
    const auto shares =
        force_shares(n, in_plane(from), in_plane(to), across.norm(), flat_[f] ? flat_rest : curved_rest);
    if (!shares) {
      facet.straight[side] = true;
      return;
    }
    for (std::size_t end = 0; end < 2; ++end)
      if ((*shares)[end] != 0.0)
        parts_[{surface, end == 0 ? from : to}].push_back(
            {-(*shares)[end] * bulge(across.norm()) * n, facet.normal, from, to});
  }

  const Mesh& mesh_;
  const HeldMotions& held_;
  std::vector<Facet>& facets_;
  Surfaces& surfaces_;
  const std::vector<bool>& flat_;
  std::map<NodeOfSurface, Vector3d> normals_;
  std::vector<std::pair<std::size_t, std::size_t>> bulging_;
  std::map<NodeOfSurface, std::vector<BulgePart>> parts_;
};

void append_shares(int corner, const BulgePart& part, std::vector<EdgeShare>& shares) {
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) {
      const double share = part.direction[i] * part.normal[k];
      if (share == 0.0) continue;
      shares.push_back({6 * corner + i, 6 * part.to + 3 + k, share});
      shares.push_back({6 * corner + i, 6 * part.from + 3 + k, -share});
    }
}

}  // namespace

// In this order: which corners follow, which sides meet others of their surface, then the edges that are left.
ShellEdges::ShellEdges(const FiniteElementModel& model) {
  auto facets = facets_of(model);
  const HeldMotions held(model);
  find_following(held, facets);
  const bool has_triangles = std::ranges::any_of(facets, &Facet::is_triangle);
  const bool any_follows = std::ranges::any_of(facets, [](const Facet& facet) {
    return std::ranges::any_of(facet.following, [](bool follows) { return follows; });
  });
  if (!has_triangles && !any_follows) return;
  Surfaces surfaces(facets.size());
  find_partners(model.mesh, facets, surfaces);
  const std::vector<bool> flat = facets_of_flat_surfaces(facets, surfaces);
  for (auto& facet : facets)
    for (std::size_t i = 0; i < facet.count(); ++i)
      if (facet.following[i]) facet.straight[i] = facet.straight[(i + facet.count() - 1) % facet.count()] = true;
  std::optional<Edges> edges;
  if (has_triangles) edges.emplace(model.mesh, held, facets, surfaces, flat);
  for (std::size_t f = 0; f < facets.size(); ++f) {
    CellEdges own{.drilling = {.following = facets[f].following}, .shares = {}};
    if (facets[f].is_triangle()) std::copy_n(facets[f].straight.begin(), 3, own.drilling.straight.begin());
    for (std::size_t i = 0; edges && i < facets[f].count(); ++i)
      if (const auto* parts = edges->parts(f, facets[f].nodes[i]))
        for (const auto& part : *parts) append_shares(static_cast<int>(i), part, own.shares);
    if (own.drilling != DrillingOptions{} || !own.shares.empty()) cells_[facets[f].cell] = std::move(own);
  }
}

Eigen::VectorXd ShellEdges::corner_motions(const Mesh& mesh, Index cell, const Eigen::VectorXd& all) const {
  const auto nodes = mesh.nodes_of(mesh.cells[static_cast<std::size_t>(cell)]);
  Eigen::VectorXd motions(6 * static_cast<Index>(nodes.size()));
  for (std::size_t i = 0; i < nodes.size(); ++i)
    motions.segment<6>(6 * static_cast<Index>(i)) = all.segment<6>(6 * nodes[i]);
  for (const auto& [row, dof, share] : shares(cell)) motions[row] += share * all[dof];
  return motions;
}

}  // namespace kalfem
