#include "kalfem/report/mesh_picture.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <queue>
#include <unordered_map>

#include "kalfem/model/mesh/mesh.hpp"

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

namespace {

// Row by row: where a line through the pixels' centres enters and leaves the triangle, and the depth at each centre by
// its barycentric coordinates.
/// Calls visit(pixel, depth) for the pixels whose centre lies in a triangle.
template <typename Visit>
void scan_triangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c, int width, int height,
                   const Visit& visit) {
  const double area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
  if (std::abs(area) < 1e-9) return;
  const int top = std::max(0, static_cast<int>(std::ceil(std::min({a[1], b[1], c[1]}) - 0.5)));
  const int bottom = std::min(height - 1, static_cast<int>(std::floor(std::max({a[1], b[1], c[1]}) - 0.5)));
  for (int row = top; row <= bottom; ++row) {
    const double y = row + 0.5;
    double from = std::numeric_limits<double>::infinity(), to = -from;
    for (const auto& [p, q] : {std::pair{&a, &b}, std::pair{&b, &c}, std::pair{&c, &a}}) {
      if ((y - (*p)[1]) * (y - (*q)[1]) > 0.0 || (*p)[1] == (*q)[1]) continue;
      const double x = (*p)[0] + ((*q)[0] - (*p)[0]) * (y - (*p)[1]) / ((*q)[1] - (*p)[1]);
      from = std::min(from, x);
      to = std::max(to, x);
    }
    const int first = std::max(0, static_cast<int>(std::ceil(from - 0.5)));
    const int last = std::min(width - 1, static_cast<int>(std::ceil(to - 0.5)) - 1);
    for (int column = first; column <= last; ++column) {
      const double x = column + 0.5;
      const double u = ((x - a[0]) * (c[1] - a[1]) - (y - a[1]) * (c[0] - a[0])) / area,
                   v = ((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])) / area;
      visit(static_cast<std::size_t>(row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(column),
            a[2] + u * (b[2] - a[2]) + v * (c[2] - a[2]));
    }
  }
}

template <typename Visit>
void scan(const ScreenPolygon& polygon, int width, int height, const Visit& visit) {
  for (Eigen::Index i = 2; i < polygon.corners.cols(); ++i)
    scan_triangle(polygon.corners.col(0), polygon.corners.col(i - 1), polygon.corners.col(i), width, height, visit);
}

using Pair = std::pair<std::uint32_t, std::uint32_t>;

/// (farther, nearer) of visible polygons that follow one another over a pixel, each pair once.
std::vector<Pair> covering(const std::vector<ScreenPolygon>& polygons, const std::vector<bool>& visible, int width,
                           int height) {
  struct Layer {
    std::uint32_t pixel;
    float depth;
    std::uint32_t polygon;
  };
  std::vector<Layer> layers;
  for (std::size_t i = 0; i < polygons.size(); ++i)
    if (visible[i])
      scan(polygons[i], width, height, [&](std::size_t pixel, double depth) {
        layers.push_back({static_cast<std::uint32_t>(pixel), static_cast<float>(depth), static_cast<std::uint32_t>(i)});
      });
  std::ranges::sort(layers, [](const Layer& a, const Layer& b) {
    return a.pixel != b.pixel ? a.pixel < b.pixel : a.depth > b.depth;
  });
  std::vector<Pair> pairs;
  for (std::size_t i = 1; i < layers.size(); ++i)
    if (layers[i].pixel == layers[i - 1].pixel && layers[i].polygon != layers[i - 1].polygon)
      pairs.emplace_back(layers[i - 1].polygon, layers[i].polygon);
  std::ranges::sort(pairs);
  pairs.erase(std::ranges::unique(pairs).begin(), pairs.end());
  return pairs;
}

}  // namespace

double ScreenDepth::at(double x, double y) const {
  if (!(x >= 0.0 && y >= 0.0 && x < width && y < height)) return std::numeric_limits<double>::infinity();
  return nearest[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
}

// A depth buffer: per pixel the nearest polygon. Polygons that are nearest nowhere are hidden and need not be drawn.
ScreenDepth screen_depth(const std::vector<ScreenPolygon>& polygons, int width, int height) {
  const auto pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  ScreenDepth screen{.visible = std::vector<bool>(polygons.size(), false),
                     .nearest = std::vector<double>(pixels, std::numeric_limits<double>::infinity()),
                     .width = width,
                     .height = height};
  std::vector<std::int64_t> owner(pixels, -1);
  for (std::size_t i = 0; i < polygons.size(); ++i)
    scan(polygons[i], width, height, [&](std::size_t pixel, double depth) {
      if (depth >= screen.nearest[pixel]) return;
      screen.nearest[pixel] = depth;
      owner[pixel] = static_cast<std::int64_t>(i);
    });
  for (const auto i : owner)
    if (i >= 0) screen.visible[static_cast<std::size_t>(i)] = true;
  return screen;
}

// An order from back to front in which nothing is painted over what lies before it. Over each pixel the polygons are
// sorted by depth, which gives pairs (farther, nearer); a topological sort of these takes the farthest polygon that
// waits for none. Polygons that overlap in a ring have no such order: the farthest of those left breaks it.
std::vector<std::size_t> painters_order(const std::vector<ScreenPolygon>& polygons, const ScreenDepth& depth) {
  const auto& visible = depth.visible;
  const auto pairs = covering(polygons, visible, depth.width, depth.height);  // sorted by the farther one
  std::vector<int> waiting(polygons.size(), 0);
  for (const auto& [far, near] : pairs) ++waiting[near];
  using Entry = std::pair<double, std::size_t>;  // farthest first
  std::priority_queue<Entry> ready;
  std::vector<Entry> by_depth;
  for (std::size_t i = 0; i < polygons.size(); ++i) {
    if (!visible[i]) continue;
    by_depth.emplace_back(polygons[i].corners.row(2).mean(), i);
    if (waiting[i] == 0) ready.push(by_depth.back());
  }
  std::ranges::sort(by_depth, std::greater{});
  std::vector<bool> painted(polygons.size(), false);
  std::vector<std::size_t> order;
  std::size_t next = 0;  // in by_depth, to break rings
  while (order.size() < by_depth.size()) {
    if (ready.empty()) {
      while (painted[by_depth[next].second]) ++next;
      ready.push(by_depth[next]);
    }
    const std::size_t i = ready.top().second;
    ready.pop();
    if (painted[i]) continue;
    painted[i] = true;
    order.push_back(i);
    auto pair = std::ranges::lower_bound(pairs, Pair{static_cast<std::uint32_t>(i), 0});
    for (; pair != pairs.end() && pair->first == i; ++pair)
      if (--waiting[pair->second] == 0) ready.push({polygons[pair->second].corners.row(2).mean(), pair->second});
  }
  return order;
}

}  // namespace kalfem
