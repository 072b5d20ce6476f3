// SPDX-License-Identifier: Apache-2.0
#include "kalfem/correlation/point_match.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/correlation/node_grid.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;

constexpr Index most_placed = 1500;       ///< nodes on which the search lays points
constexpr std::size_t most_refined = 60;  ///< positions
constexpr int most_turns = 50;            ///< of nearest nodes and fit
constexpr double as_well = 25.0;          ///< squares more than the best fit's, in sigma^2, of one that counts too

/// The rigid motion, with a factor of length if asked for, that takes one set of places best to another [Ume91].
PlaceFit best_fit(const Matrix3Xd& from, const Matrix3Xd& to, bool with_scale) {
  const Vector3d mean_from = from.rowwise().mean(), mean_to = to.rowwise().mean();
  const Matrix3Xd centred = from.colwise() - mean_from, target = to.colwise() - mean_to;
  const Eigen::JacobiSVD<Matrix3d> svd(Matrix3d(target * centred.transpose()),
                                       Eigen::ComputeFullU | Eigen::ComputeFullV);
  Vector3d signs = Vector3d::Ones();
  if ((svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0) signs[2] = -1.0;
  PlaceFit fit;
  fit.rotation = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  if (with_scale) fit.scale = std::clamp(svd.singularValues().dot(signs) / centred.squaredNorm(), 0.9, 1.1);
  fit.shift = mean_to - fit.scale * fit.rotation * mean_from;
  return fit;
}

/// Nodes at which elements are joined, or all.
std::vector<Index> candidate_nodes(const Mesh& mesh) {
  std::set<Index> nodes;
  for (const auto& cell : mesh.cells)
    if (dimension(cell.shape) > 0)
      for (const auto node : mesh.nodes_of(cell)) nodes.insert(node);
  if (nodes.empty())
    for (Index i = 0; i < mesh.node_count(); ++i) nodes.insert(i);
  return {nodes.begin(), nodes.end()};
}

/// Nodes spread over the structure: each is the farthest from those before it. And how far any node is from them.
struct Spread {
  Matrix3Xd places;
  double gap = 0.0;  ///< [m]
};

Spread spread_of(const Matrix3Xd& places) {
  const Index count = std::min(most_placed, places.cols());
  Spread spread{Matrix3Xd(3, count), 0.0};
  Eigen::VectorXd distance = Eigen::VectorXd::Constant(places.cols(), std::numeric_limits<double>::infinity());
  Index next = 0;
  (places.colwise() - Vector3d(places.rowwise().mean())).colwise().norm().maxCoeff(&next);
  for (Index i = 0; i < count; ++i) {
    spread.places.col(i) = places.col(next);
    distance = distance.cwiseMin((places.colwise() - places.col(next)).colwise().norm().transpose());
    distance.maxCoeff(&next);
  }
  spread.gap = distance.maxCoeff();
  return spread;
}

/// Middle of the distances from nodes to their neighbours.
double spacing_of(const Matrix3Xd& places) {
  std::vector<double> gaps;
  const Index step = std::max<Index>(1, places.cols() / 200);
  for (Index i = 0; i < places.cols(); i += step) {
    double nearest = std::numeric_limits<double>::infinity();
    for (Index k = 0; k < places.cols(); ++k)
      if (const double gap = (places.col(k) - places.col(i)).norm(); gap > 0.0) nearest = std::min(nearest, gap);
    if (std::isfinite(nearest)) gaps.push_back(nearest);
  }
  if (gaps.empty()) return 1.0;
  std::ranges::nth_element(gaps, gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2));
  return gaps[gaps.size() / 2];
}

/// Search for the positions of a set of points on a set of nodes.
class Search {
public:
  Search(const Matrix3Xd& points, const Matrix3Xd& nodes, bool with_scale)
      : points_(points), nodes_(nodes), spacing_(spacing_of(nodes)), grid_(nodes, spacing_), with_scale_(with_scale) {}

  /// Distinct fits, the best first.
  std::vector<PlaceFit> fits() {
    choose_corners();
    lay_corners();
    std::vector<PlaceFit> found;
    for (const auto& [cost, fit] : placed_)
      if (auto refined = refined_from(fit); is_new(refined, found)) found.push_back(refined);
    std::ranges::sort(found, {}, &PlaceFit::rms);
    return found;
  }

  [[nodiscard]] const NodeGrid& grid() const { return grid_; }

private:
  void choose_corners();
  void lay_corners();
  void lay(const Matrix3Xd& corners);
  [[nodiscard]] PlaceFit refined_from(PlaceFit fit) const;
  [[nodiscard]] bool is_new(const PlaceFit& fit, const std::vector<PlaceFit>& others) const;
  /// Largest distance between the images of a point by two fits.
  [[nodiscard]] double apart(const PlaceFit& one, const PlaceFit& other) const {
    double largest = 0.0;
    for (const auto& point : points_.colwise()) largest = std::max(largest, (one(point) - other(point)).norm());
    return largest;
  }

  const Matrix3Xd& points_;
  const Matrix3Xd& nodes_;
  double spacing_;
  NodeGrid grid_;
  bool with_scale_;
  std::vector<Index> order_;                         ///< of the points: the three corners first
  double reach_ = 0.0;                               ///< how far a point may be from a node of the search [m]
  std::vector<std::pair<double, PlaceFit>> placed_;  ///< with their costs, ascending
};

/// The farthest two points, then each time the one that is farthest from those before it: the third is off their line.
void Search::choose_corners() {
  const Index count = points_.cols();
  Index first = 0, second = 0;
  double longest = -1.0;
  for (Index i = 0; i < count; ++i)
    for (Index k = 0; k < i; ++k)
      if (const double length = (points_.col(i) - points_.col(k)).norm(); length > longest) {
        longest = length;
        first = i;
        second = k;
      }
  const Vector3d along = (points_.col(second) - points_.col(first)).normalized();
  Index third = 0;
  (points_.colwise() - points_.col(first)).colwise().cross(along).colwise().norm().maxCoeff(&third);
  order_ = {first, second, third};
  for (Index i = 0; i < count; ++i)
    if (std::ranges::find(order_, i) == order_.end()) order_.push_back(i);
}

// All pairs of nodes at the distance of the first two corners, and all third nodes at the distances of the third corner
// from both. The farther apart the corners, the fewer positions there are.
void Search::lay_corners() {
  const Spread spread = spread_of(nodes_);
  reach_ = std::max(spread.gap, 0.75 * spacing_);
  const Vector3d a = points_.col(order_[0]), b = points_.col(order_[1]), c = points_.col(order_[2]);
  const double ab = (b - a).norm(), ac = (c - a).norm(), bc = (c - b).norm();
  const double slack = reach_ + (with_scale_ ? 0.1 * ab : 0.0);
  const Matrix3Xd& nodes = spread.places;
  Matrix3Xd corners(3, 3);
  for (Index i = 0; i < nodes.cols(); ++i) {
    const Eigen::VectorXd from_i = (nodes.colwise() - nodes.col(i)).colwise().norm();
    std::vector<Index> thirds;
    for (Index k = 0; k < nodes.cols(); ++k)
      if (std::abs(from_i[k] - ac) <= slack) thirds.push_back(k);
    for (Index j = 0; j < nodes.cols(); ++j) {
      if (std::abs(from_i[j] - ab) > slack) continue;
      for (const auto k : thirds) {
        if (std::abs((nodes.col(k) - nodes.col(j)).norm() - bc) > slack) continue;
        corners << nodes.col(i), nodes.col(j), nodes.col(k);
        lay(corners);
      }
    }
  }
}

// A position whose points are farther from nodes than those kept already is dropped as soon as this shows. Alike
// positions keep the best of them.
void Search::lay(const Matrix3Xd& corners) {
  Matrix3Xd from(3, 3);
  from << points_.col(order_[0]), points_.col(order_[1]), points_.col(order_[2]);
  const PlaceFit fit = best_fit(from, corners, with_scale_);
  const double limit = placed_.size() < most_refined ? std::numeric_limits<double>::infinity() : placed_.back().first;
  const double most = 4.0 * reach_ * reach_;
  double cost = 0.0;
  for (const auto point : order_) {
    const double distance = grid_.near(fit(points_.col(point)), spacing_).distance[0];
    cost += std::min(distance * distance, most);
    if (cost >= limit) return;
  }
  for (auto& [other_cost, other] : placed_) {
    if (apart(fit, other) > 2.0 * reach_) continue;
    if (cost < other_cost) {
      other_cost = cost;
      other = fit;
      std::ranges::sort(placed_, {}, [](const auto& each) { return each.first; });
    }
    return;
  }
  placed_.emplace_back(cost, fit);
  std::ranges::sort(placed_, {}, [](const auto& each) { return each.first; });
  if (placed_.size() > most_refined) placed_.pop_back();
}

/// Nearest nodes and the fit to them in turns, until the nodes stay.
PlaceFit Search::refined_from(PlaceFit fit) const {
  std::vector<Index> nearest;
  Matrix3Xd targets(3, points_.cols());
  for (int turn = 0; turn < most_turns; ++turn) {
    std::vector<Index> found;
    for (const auto& point : points_.colwise()) found.push_back(grid_.nearest(fit(point)).index[0]);
    if (found == nearest) break;
    nearest = std::move(found);
    for (Index i = 0; i < points_.cols(); ++i) targets.col(i) = nodes_.col(nearest[static_cast<std::size_t>(i)]);
    fit = best_fit(points_, targets, with_scale_);
  }
  double squares = 0.0;
  for (Index i = 0; i < points_.cols(); ++i) squares += (fit(points_.col(i)) - targets.col(i)).squaredNorm();
  fit.rms = std::sqrt(squares / static_cast<double>(points_.cols()));
  return fit;
}

bool Search::is_new(const PlaceFit& fit, const std::vector<PlaceFit>& others) const {
  return std::ranges::none_of(others, [&](const auto& other) { return apart(fit, other) < 1e-9 * spacing_; });
}

void check(const std::vector<TestPoint>& points, const Matrix3Xd& places, const Matrix3Xd& nodes) {
  if (points.size() < 4)
    throw InvalidInput(fmt::format("the test has {} points with places", points.size()),
                       "a position in space needs four that are not on one line", "give their coordinates");
  if (!places.allFinite()) throw InvalidInput("a coordinate of the test is not finite", "", "correct it");
  const auto extent = [](const Matrix3Xd& of) {
    return Eigen::JacobiSVD<Eigen::MatrixXd>((of.colwise() - Vector3d(of.rowwise().mean()))).singularValues().eval();
  };
  const Eigen::VectorXd spread = extent(places);
  if (!(spread[1] > 1e-3 * spread[0]))
    throw InvalidInput("the points of the test are on one line", "the turn about it cannot be found",
                       "give points beside the line");
  const double test = (places.rowwise().maxCoeff() - places.rowwise().minCoeff()).norm(),
               model = (nodes.rowwise().maxCoeff() - nodes.rowwise().minCoeff()).norm();
  if (test > 1.2 * model * std::numbers::sqrt3 || test < 1e-2 * model)
    throw InvalidInput(fmt::format("the test is {:.3g} m large and the model {:.3g} m", test, model),
                       "their units of length differ", "state the unit of the test's coordinates");
}

/// Standard deviation of a coordinate by a fit: of its 3 n numbers it has fitted six or seven.
double noise_of(const PlaceFit& fit, std::size_t count, bool with_scale) {
  const auto n = static_cast<double>(count);
  return fit.rms * std::sqrt(n / (3.0 * n - (with_scale ? 7.0 : 6.0)));
}

}  // namespace

bool PointMatch::sure() const { return std::ranges::all_of(points, &MatchedPoint::sure); }

PointMatch match_points(const std::vector<TestPoint>& points, const Mesh& mesh, const PointMatchOptions& options) {
  Matrix3Xd places(3, std::ssize(points));
  for (Index i = 0; i < places.cols(); ++i) places.col(i) = points[static_cast<std::size_t>(i)].place;
  const auto candidates = candidate_nodes(mesh);
  const Matrix3Xd nodes = mesh.nodes(Eigen::all, candidates);
  if (nodes.cols() < 4) throw InvalidInput("the model has fewer than four nodes", "", "give one with elements");
  check(points, places, nodes);
  Search search(places, nodes, options.scale);
  auto fits = search.fits();
  if (fits.empty())
    throw InvalidInput("the points of the test lie nowhere on the model", "no nodes have their distances",
                       "check the unit of length and that the model is of the same structure");
  PointMatch match{.fit = fits.front(), .points = {}};
  const double floor = 1e-6 * (nodes.rowwise().maxCoeff() - nodes.rowwise().minCoeff()).norm();
  match.noise =
      std::max(options.noise > 0.0 ? options.noise : noise_of(match.fit, points.size(), options.scale), floor);
  const double variance = match.noise * match.noise;
  std::vector<double> weights{1.0};  // of the fits, against the best
  for (std::size_t i = 1; i < fits.size(); ++i) {
    const double more =
        (fits[i].rms * fits[i].rms - match.fit.rms * match.fit.rms) * static_cast<double>(points.size());
    if (more > as_well * variance) break;
    match.others.push_back(fits[i]);
    weights.push_back(std::exp(-0.5 * more / variance));
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto near = search.grid().nearest(match.fit(points[i].place));
    const auto node_of = [&](std::size_t k) {
      return near.index[k] < 0 ? -1 : candidates[static_cast<std::size_t>(near.index[k])];
    };
    MatchedPoint point{.name = points[i].name,
                       .node = node_of(0),
                       .distance = near.distance[0],
                       .next = node_of(1),
                       .next_distance = near.distance[1]};
    const double gap = (near.distance[1] * near.distance[1] - near.distance[0] * near.distance[0]) / (2.0 * variance);
    double same = 1.0, all = 1.0;
    for (std::size_t k = 0; k < match.others.size(); ++k) {
      const auto other = search.grid().nearest(match.others[k](points[i].place)).index[0];
      all += weights[k + 1];
      if (other == near.index[0]) same += weights[k + 1];
    }
    point.probability = same / all / (1.0 + std::exp(-gap));
    point.sure = point.probability >= options.sureness;
    point.axes = match.fit.rotation * points[i].axes;
    match.points.push_back(std::move(point));
  }
  return match;
}

std::string direction_words(const Vector3d& direction) {
  const Vector3d unit = direction.normalized();
  Index axis = 0;
  const double cosine = unit.cwiseAbs().maxCoeff(&axis);
  if (cosine >= std::cos(5.0 * std::numbers::pi / 180.0))
    return std::string(unit[axis] < 0.0 ? "-" : "+") + "xyz"[axis];
  return fmt::format("({:.2g}, {:.2g}, {:.2g})", unit[0], unit[1], unit[2]);
}

}  // namespace kalfem
