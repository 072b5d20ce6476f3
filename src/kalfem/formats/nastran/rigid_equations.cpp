#include "kalfem/formats/nastran/rigid_equations.hpp"

#include <algorithm>

namespace kalfem::nastran {
namespace {

using Row6 = Eigen::Matrix<double, 1, 6>;

/// A component of a node by the rigid motion about `centre`: a . (t + r x arm), or a . r.
Row6 rigid_row(const Building& building, const NodalDof& component, const Eigen::Vector3d& centre) {
  const Eigen::Vector3d axis = building.motion_axes(component.node).col(component.direction % 3);
  Row6 row = Row6::Zero();
  if (component.direction < 3) {
    row.head<3>() = axis.transpose();
    row.tail<3>() = (building.place(component.node) - centre).cross(axis).transpose();
  } else {
    row.tail<3>() = axis.transpose();
  }
  return row;
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
    rows.row(static_cast<Eigen::Index>(i)) = rigid_row(building, components[i], centre);
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

std::vector<DependentRow> rigid_rows(const Building& building, const NodeComponents& independent,
                                     const NodeComponents& dependent) {
  const auto lead = listed(independent), follow = listed(dependent);
  if (lead.size() != 6) return {};
  const Eigen::Vector3d centre = building.place(lead.front().node);
  const double length = typical_length(building, lead, centre);
  Row6 scale;
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

std::vector<DependentRow> weighted_rows(const Building& building, const WeightedLink& link,
                                        const NodeComponents& moved) {
  const Eigen::Vector3d centre = building.place(link.follower);
  std::vector<NodalDof> sources;
  std::vector<double> weights;
  double distance = 0.0;
  for (const auto& share : link.shares) distance += (building.place(share.node) - centre).norm();
  distance /= std::max<double>(1.0, static_cast<double>(link.shares.size()));
  for (const auto& share : link.shares)
    for (int i = 0; i < 6; ++i)
      if (share.directions[static_cast<std::size_t>(i)]) {
        sources.push_back({share.node, i});
        weights.push_back(share.weight * (i < 3 ? 1.0 : distance * distance));
      }
  if (sources.empty()) return {};
  const double length = distance > 0.0 ? distance : 1.0;
  Row6 scale;
  scale << 1.0, 1.0, 1.0, 1.0 / length, 1.0 / length, 1.0 / length;
  const Eigen::MatrixXd motions = rigid_rows_of(building, sources, centre) * scale.asDiagonal();
  const Eigen::VectorXd weight =
      Eigen::Map<const Eigen::VectorXd>(weights.data(), static_cast<Eigen::Index>(weights.size()));
  const Eigen::Matrix<double, 6, 6> normal = motions.transpose() * weight.asDiagonal() * motions;
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> solver(6, 6);
  solver.setThreshold(1e-12);
  solver.compute(normal);
  const Eigen::MatrixXd fit =
      scale.asDiagonal() * solver.solve(Eigen::MatrixXd(motions.transpose() * weight.asDiagonal()));

  unsigned reference = 0;
  for (std::size_t i = 0; i < 6; ++i) reference |= link.tied[i] ? 1u << i : 0u;
  const auto followers = listed({{link.follower, reference}});
  const Eigen::MatrixXd shares = rigid_rows_of(building, followers, centre) * fit;
  // A motion of the follower that the shares do not show is not determined by them.
  const Eigen::MatrixXd seen = shares * motions,
                        wanted = rigid_rows_of(building, followers, centre) * scale.asDiagonal();
  if (!((seen - wanted).cwiseAbs().maxCoeff() < 1e-9)) return {};
  // Equations over [followers, sources], then solved for the components that depend.
  std::vector<NodalDof> all = followers;
  all.insert(all.end(), sources.begin(), sources.end());
  const auto count = static_cast<Eigen::Index>(followers.size());
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
