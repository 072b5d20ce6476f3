// SPDX-License-Identifier: Apache-2.0
#include "kalfem/pictures/drawn_surface.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <unordered_map>

namespace kalfem {
namespace {

using Eigen::Index;
using Key = std::array<Index, 4>;

/// The same for faces with the same corners, whatever their order.
Key key_of(const DrawnFace& face) {
  Key key = {-1, -1, -1, -1};
  std::copy_n(face.nodes.begin(), face.count, key.begin());
  std::ranges::sort(key);
  return key;
}

void add_corner(DrawnFace& face, Index node) {
  const auto end = face.nodes.begin() + face.count;
  if (std::find(face.nodes.begin(), end, node) == end) face.nodes[static_cast<std::size_t>(face.count++)] = node;
}

DrawnFace face_of(const Mesh& mesh, const Cell& cell, std::span<const int> places, int region) {
  DrawnFace face{.region = region};
  for (const int place : places) add_corner(face, mesh.nodes_of(cell)[static_cast<std::size_t>(place)]);
  return face;
}

/// Sorts faces by their corners and keeps one of those that are alike, or none of them.
void keep_alike(std::vector<DrawnFace>& faces, bool one) {
  std::vector<std::pair<Key, std::size_t>> keys;
  keys.reserve(faces.size());
  for (std::size_t i = 0; i < faces.size(); ++i) keys.emplace_back(key_of(faces[i]), i);
  std::ranges::sort(keys);
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < keys.size();) {
    std::size_t next = i + 1;
    while (next < keys.size() && keys[next].first == keys[i].first) ++next;
    if (one || next == i + 1) kept.push_back(keys[i].second);
    i = next;
  }
  std::ranges::sort(kept);
  std::vector<DrawnFace> rest;
  rest.reserve(kept.size());
  for (const auto i : kept) rest.push_back(faces[i]);
  faces = std::move(rest);
}

struct KeyHash {
  std::size_t operator()(const std::array<std::int64_t, 3>& box) const {
    std::size_t hash = 0;
    for (const auto number : box)
      hash = (hash ^ static_cast<std::size_t>(number)) * 0x9e3779b97f4a7c15ULL + (hash >> 29U);
    return hash;
  }
};

DrawnSurface clustered(const Eigen::Matrix3Xd& places, const Eigen::VectorXd& weight,
                       const std::vector<DrawnFace>& faces, double width) {
  DrawnSurface surface{.places = Eigen::Matrix3Xd(3, places.cols()), .faces = {}, .coarsened = true};
  std::unordered_map<std::array<std::int64_t, 3>, Index, KeyHash> boxes;
  std::vector<Index> place_of(static_cast<std::size_t>(places.cols()), -1);
  std::vector<double> sums;
  const auto represented = [&](Index node) {
    Index& place = place_of[static_cast<std::size_t>(node)];
    if (place >= 0) return place;
    const Eigen::Vector3d scaled = places.col(node) / width;
    const auto [entry, is_new] = boxes.try_emplace(
        {static_cast<std::int64_t>(std::floor(scaled[0])), static_cast<std::int64_t>(std::floor(scaled[1])),
         static_cast<std::int64_t>(std::floor(scaled[2]))},
        static_cast<Index>(sums.size()));
    place = entry->second;
    if (is_new) {
      sums.push_back(0.0);
      surface.places.col(place).setZero();
    }
    sums[static_cast<std::size_t>(place)] += weight[node];
    surface.places.col(place) += weight[node] * places.col(node);
    return place;
  };
  for (const auto& face : faces) {
    DrawnFace coarse{.region = face.region};
    for (int i = 0; i < face.count; ++i) add_corner(coarse, represented(face.nodes[static_cast<std::size_t>(i)]));
    if (coarse.count >= std::min(face.count, 3)) surface.faces.push_back(coarse);
  }
  surface.places.conservativeResize(3, static_cast<Index>(sums.size()));
  for (std::size_t i = 0; i < sums.size(); ++i) surface.places.col(static_cast<Index>(i)) /= sums[i];
  keep_alike(surface.faces, true);
  surface.place_of = std::move(place_of);
  return surface;
}

}  // namespace

// A face that two solids share is inside and not drawn: faces are sorted by their corners, and those met once are kept.
std::vector<DrawnFace> outer_faces(const Mesh& mesh, const std::vector<std::string>& regions) {
  std::vector<DrawnFace> faces, of_solids;
  std::vector<bool> taken(mesh.cells.size(), false);
  for (std::size_t r = 0; r < regions.size(); ++r) {
    const auto cells = mesh.regions.find(regions[r]);
    if (cells == mesh.regions.end()) continue;
    for (const auto index : cells->second) {
      const Cell& cell = mesh.cells[static_cast<std::size_t>(index)];
      if (taken[static_cast<std::size_t>(index)]) continue;
      taken[static_cast<std::size_t>(index)] = true;
      if (dimension(cell.shape) == 1) faces.push_back(face_of(mesh, cell, std::array{0, 1}, static_cast<int>(r)));
      for (const auto& ring : corner_rings(cell.shape)) {
        const DrawnFace face = face_of(mesh, cell, ring.places(), static_cast<int>(r));
        if (face.count >= 3) (dimension(cell.shape) == 3 ? of_solids : faces).push_back(face);
      }
    }
  }
  keep_alike(of_solids, false);
  faces.insert(faces.end(), of_solids.begin(), of_solids.end());
  return faces;
}

// At an edge the unit normals of the faces around a node cancel in part: the shorter their mean, the sharper the edge.
Eigen::VectorXd shape_weights(const Eigen::Matrix3Xd& places, const std::vector<DrawnFace>& faces) {
  Eigen::Matrix3Xd normals = Eigen::Matrix3Xd::Zero(3, places.cols());
  Eigen::VectorXd count = Eigen::VectorXd::Zero(places.cols());
  std::vector<int> region(static_cast<std::size_t>(places.cols()), -1);
  std::vector<bool> meets(region.size(), false);
  for (const auto& face : faces) {
    const auto corner = [&](int i) { return places.col(face.nodes[static_cast<std::size_t>(i)]); };
    const Eigen::Vector3d normal =
        face.count < 3 ? Eigen::Vector3d::Zero()
                       : Eigen::Vector3d((corner(1) - corner(0)).cross(corner(2) - corner(0)).stableNormalized());
    for (int i = 0; i < face.count; ++i) {
      const auto node = face.nodes[static_cast<std::size_t>(i)];
      const auto place = static_cast<std::size_t>(node);
      normals.col(node) += normal;
      count[node] += 1.0;
      if (region[place] >= 0 && region[place] != face.region) meets[place] = true;
      region[place] = face.region;
    }
  }
  Eigen::VectorXd weight = Eigen::VectorXd::Ones(places.cols());
  for (Index node = 0; node < places.cols(); ++node)
    if (count[node] > 0.0)
      weight[node] = std::exp(
          30.0 * (1.0 - normals.col(node).norm() / count[node] + (meets[static_cast<std::size_t>(node)] ? 0.2 : 0.0)));
  return weight;
}

// Vertex clustering: space is divided into boxes, the nodes of a box become one at their weighted mean, faces that
// collapse are dropped and those that become alike drawn once. The boxes grow until few enough faces are left. Weights
// pull the mean towards edges and seams, so that the outline stays sharp.
DrawnSurface coarsened(const Eigen::Matrix3Xd& places, std::vector<DrawnFace> faces, const Eigen::VectorXd& weights,
                       std::size_t most) {
  if (faces.size() <= most || faces.empty()) return {places, std::move(faces), false};
  Eigen::Vector3d low = places.col(faces[0].nodes[0]), high = low;
  for (const auto& face : faces)
    for (int i = 0; i < face.count; ++i) {
      low = low.cwiseMin(places.col(face.nodes[static_cast<std::size_t>(i)]));
      high = high.cwiseMax(places.col(face.nodes[static_cast<std::size_t>(i)]));
    }
  const double size = (high - low).norm();
  DrawnSurface surface;
  for (double width = size / 600.0; width < size; width *= 1.3) {
    surface = clustered(places.colwise() - low, weights, faces, width);
    if (surface.faces.size() <= most) break;
  }
  surface.places.colwise() += low;
  return surface;
}

}  // namespace kalfem
