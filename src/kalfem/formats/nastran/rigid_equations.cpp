// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/nastran/model_building.hpp"

#include <algorithm>

#include "kalfem/model/assembly/rigid_motion.hpp"

namespace kalfem::nastran {
namespace {

/// A component of a node, in its own axes, by the rigid motion about `centre`.
RigidRow row_of(const Building& building, const NodalDof& component, const Eigen::Vector3d& centre) {
  return rigid_row(component.direction, building.place(component.node) - centre, building.motion_axes(component.node));
}

std::vector<NodalDof> listed(const NodeComponents& nodes) {
  std::vector<NodalDof> components;
  for (const auto& [node, set] : nodes)
    for (int i = 0; i < 6; ++i)
      if (((set >> i) & 1u) != 0) components.push_back({node, i});
  return components;
}

Eigen::Matrix<double, Eigen::Dynamic, 6> rigid_rows_of(const Building& building,
                                                       const std::vector<NodalDof>& components,
                                                       const Eigen::Vector3d& centre) {
  Eigen::Matrix<double, Eigen::Dynamic, 6> rows(static_cast<Eigen::Index>(components.size()), 6);
  for (std::size_t i = 0; i < components.size(); ++i)
    rows.row(static_cast<Eigen::Index>(i)) = row_of(building, components[i], centre);
  return rows;
}

/// Mean distance of nodes from a centre; 1 where all lie there.
double typical_length(const Building& building, const std::vector<NodalDof>& components,
                      const Eigen::Vector3d& centre) {
  double sum = 0.0;
  for (const auto& component : components) sum += (building.place(component.node) - centre).norm();
  return sum > 0.0 ? sum / static_cast<double>(components.size()) : 1.0;
}

}  // namespace

// Six independent components u_i = R_i q determine the rigid motion q, so a dependent one is u_d = R_d R_i^-1 u_i.
// Rotations are divided by the typical length first: whether R_i is singular must not depend on the unit of length.
std::vector<DependentRow> rigid_rows(const Building& building, const NodeComponents& independent,
                                     const NodeComponents& dependent) {
  const auto lead = listed(independent), follow = listed(dependent);
  if (lead.size() != 6) return {};
  const Eigen::Vector3d centre = building.place(lead.front().node);
  const double length = typical_length(building, lead, centre);
  RigidRow scale;
  scale << 1.0, 1.0, 1.0, 1.0 / length, 1.0 / length, 1.0 / length;
  const Eigen::Matrix<double, 6, 6> leading = rigid_rows_of(building, lead, centre) * scale.asDiagonal();
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> solver(leading);
  solver.setThreshold(1e-10);
  if (!solver.isInvertible()) return {};
  const Eigen::MatrixXd inverse = solver.solve(Eigen::MatrixXd(Eigen::MatrixXd::Identity(6, 6)));
  const Eigen::MatrixXd shares = rigid_rows_of(building, follow, centre) * scale.asDiagonal() * inverse;
  std::vector<DependentRow> rows;
  for (std::size_t i = 0; i < follow.size(); ++i) {
    if (std::ranges::find(lead, follow[i]) != lead.end()) continue;
    DependentRow row{follow[i], {}};
    building.append(row.terms, follow[i].node, follow[i].direction, 1.0);
    for (std::size_t j = 0; j < 6; ++j) {
      const double share = shares(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
      if (std::abs(share) > 1e-12) building.append(row.terms, lead[j].node, lead[j].direction, -share);
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

std::optional<DependentRow> rod_row(const Building& building, const NodeComponents& nodes) {
  const auto dependent = listed(nodes);
  const Eigen::Vector3d along = building.place(nodes[1].first) - building.place(nodes[0].first);
  if (dependent.size() != 1 || dependent.front().direction > 2 || !(along.norm() > 0.0)) return std::nullopt;
  DependentRow row{dependent.front(), {}};
  const Eigen::Vector3d axis = along.normalized();
  for (int k = 0; k < 3; ++k)
    if (axis[k] != 0.0) {
      row.terms.push_back({{nodes[1].first, k}, axis[k]});
      row.terms.push_back({{nodes[0].first, k}, -axis[k]});
    }
  return row;
}

// RBE3 in displacement axes of its nodes. The equations say that each tied component of the reference node is the
// weighted mean of the others. With a UM set other components are to depend: the equations are multiplied by the
// inverse of these components' columns, which is singular where the choice cannot be.
std::vector<DependentRow> weighted_rows(const Building& building, const WeightedLink& link,
                                        const NodeComponents& moved) {
  const MeanMotion mean(building.model.mesh, link, [&](Eigen::Index node) { return building.motion_axes(node); });
  unsigned reference = 0;
  for (std::size_t i = 0; i < 6; ++i) reference |= link.tied[i] ? 1u << i : 0u;
  const auto followers = listed({{link.follower, reference}});
  const auto& sources = mean.components();
  const auto count = static_cast<Eigen::Index>(followers.size());
  Eigen::MatrixXd shares(count, static_cast<Eigen::Index>(sources.size()));
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto row = row_of(building, followers[static_cast<std::size_t>(i)], building.place(link.follower));
    if (!mean.determines(row)) return {};
    shares.row(i) = mean.shares(row);
  }
  // Equations over [followers, sources], then solved for the components that depend.
  std::vector<NodalDof> all = followers;
  all.insert(all.end(), sources.begin(), sources.end());
  Eigen::MatrixXd equations(count, static_cast<Eigen::Index>(all.size()));
  equations << Eigen::MatrixXd::Identity(count, count), -shares;
  auto dependent = followers;
  if (!moved.empty()) {
    dependent = listed(moved);
    if (dependent.size() != followers.size()) return {};
    Eigen::MatrixXd pivots(count, count);
    for (Eigen::Index i = 0; i < count; ++i) {
      const auto place = std::ranges::find(all, dependent[static_cast<std::size_t>(i)]);
      if (place == all.end()) return {};
      pivots.col(i) = equations.col(place - all.begin());
    }
    Eigen::ColPivHouseholderQR<Eigen::MatrixXd> chosen(pivots);
    chosen.setThreshold(1e-10);
    if (!chosen.isInvertible()) return {};
    equations = chosen.solve(equations).eval();
  }
  std::vector<DependentRow> rows;
  for (Eigen::Index i = 0; i < count; ++i) {
    DependentRow row{dependent[static_cast<std::size_t>(i)], {}};
    for (std::size_t j = 0; j < all.size(); ++j)
      if (const double share = equations(i, static_cast<Eigen::Index>(j)); std::abs(share) > 1e-13)
        building.append(row.terms, all[j].node, all[j].direction, share);
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace kalfem::nastran
