// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <string>
#include <vector>

#include "kalfem/model/mesh/mesh.hpp"
#include "kalfem/records/test_point.hpp"

namespace kalfem {

struct PointMatchOptions {
  bool scale = false;      ///< fit a factor of the test's lengths too, within 10 %
  double noise = 0.0;      ///< standard deviation of a measured coordinate [m]; 0: from the fit
  double sureness = 0.99;  ///< probability of the nearest node from which a match is sure
};

/// Places of the test in the model's axes: s R x + t.
struct PlaceFit {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  ///< R
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();         ///< t [m]
  double scale = 1.0;                                      ///< s
  double rms = 0.0;                                        ///< distance of the points from their nodes [m]

  [[nodiscard]] Eigen::Vector3d operator()(const Eigen::Vector3d& place) const {
    return scale * (rotation * place) + shift;
  }
};

/// The node of one point.
struct MatchedPoint {
  std::string name;
  Eigen::Index node = 0;       ///< of the mesh, by index
  double distance = 0.0;       ///< of the fitted place from it [m]
  Eigen::Index next = -1;      ///< the second nearest node; -1: there is none
  double next_distance = 0.0;  ///< [m]
  double probability = 0.0;    ///< of the node, against the next one and against other fits
  bool sure = false;
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< columns: the sensor's x, y, z in the model's axes
};

/// Points of a test at the nodes of a mesh.
struct PointMatch {
  PlaceFit fit;
  std::vector<MatchedPoint> points;   ///< in the order of the test's
  std::vector<PlaceFit> others = {};  ///< fits that explain the places as well: of a symmetric structure, for instance
  double noise = 0.0;                 ///< standard deviation of a coordinate that probabilities rest on [m]

  [[nodiscard]] bool sure() const;
};

/// Finds how a test's geometry lies on a mesh whatever its origin and its axes are, and which node each point is.
///
/// The farthest two points and a third one far from their line are laid on all nodes at the same distances; the best of
/// these positions are refined by turns of nearest nodes and the rigid motion that fits them best [BM92] [Ume91]. The
/// probability of a node follows from the normal density of the noise at it and at the next one, exp(-d^2 / 2 sigma^2).
/// Other fits count as well where their sum of squares is less than 25 sigma^2 larger; a point that they lay on another
/// node is not sure.
///
/// `mesh`: nodes that elements join are candidates; all, where there are no elements. Throws InvalidInput for fewer
/// than four points, points on one line, numbers that are not finite, and points larger or smaller than anything in the
/// mesh.
PointMatch match_points(const std::vector<TestPoint>& points, const Mesh& mesh, const PointMatchOptions& options = {});

/// How a sensor's axis looks in the model: "+x", "-z", or "(0.71, 0, 0.71)" where it is more than 5 degrees off an
/// axis.
std::string direction_words(const Eigen::Vector3d& direction);

}  // namespace kalfem
