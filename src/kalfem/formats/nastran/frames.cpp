#include "kalfem/formats/nastran/frames.hpp"

#include <numbers>

namespace kalfem::nastran {
namespace {

/// Systems that hang on one another deeper than this are taken for a ring.
constexpr int deepest = 500;
constexpr double radian = std::numbers::pi / 180.0;

Eigen::Matrix3d columns(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  Eigen::Matrix3d matrix;
  matrix << a, b, c;
  return matrix;
}

}  // namespace

Eigen::Vector3d Frame::place(const Eigen::Vector3d& c) const {
  const double first = c[1] * radian, second = c[2] * radian;
  switch (kind) {
    case SystemKind::cylindrical:
      return origin + axes * Eigen::Vector3d(c[0] * std::cos(first), c[0] * std::sin(first), c[2]);
    case SystemKind::spherical:
      return origin + axes * (c[0] * Eigen::Vector3d(std::sin(first) * std::cos(second),
                                                     std::sin(first) * std::sin(second), std::cos(first)));
    default:
      return origin + axes * c;
  }
}

Eigen::Matrix3d Frame::directions(const Eigen::Vector3d& at) const {
  if (kind == SystemKind::rectangular) return axes;
  const Eigen::Vector3d local = axes.transpose() * (at - origin);
  const double radius = std::hypot(local.x(), local.y());
  const bool on_axis = radius <= 1e-9 * local.norm();
  const double cosine = on_axis ? 1.0 : local.x() / radius, sine = on_axis ? 0.0 : local.y() / radius;
  const Eigen::Vector3d around(-sine, cosine, 0.0);
  if (kind == SystemKind::cylindrical)
    return axes * columns(Eigen::Vector3d(cosine, sine, 0.0), around, Eigen::Vector3d::UnitZ());
  const double distance = local.norm();
  const double up = distance > 0.0 ? local.z() / distance : 1.0, out = distance > 0.0 ? radius / distance : 0.0;
  return axes *
         columns(Eigen::Vector3d(out * cosine, out * sine, up), Eigen::Vector3d(up * cosine, up * sine, -out), around);
}

Frames::Frames(BulkData& bulk, const NumberLookup& nodes, DeckFiles& files)
    : bulk_(bulk), nodes_(nodes), files_(files), placed_(bulk.grids.size(), false) {
  frames_[0] = {};
  for (const auto& [id, card] : bulk.systems) resolve(id, card.where, 0);
  for (std::size_t i = 0; i < bulk.grids.size(); ++i) resolve_grid(i, 0);
}

const Frame* Frames::find(Id system, const Place& where) const {
  const auto frame = frames_.find(system);
  if (frame != frames_.end()) return &frame->second;
  if (!failed_.contains(system))
    files_.problem(where, "coordinate system " + std::to_string(system) + " is missing", "the card names it",
                   "add its CORD card, or mend the number");
  return nullptr;
}

const Frame* Frames::resolve(Id id, const Place& where, int depth) {
  if (const auto known = frames_.find(id); known != frames_.end()) return &known->second;
  if (failed_.contains(id)) return nullptr;
  const auto card = bulk_.systems.find(id);
  if (card == bulk_.systems.end()) return find(id, where);
  if (depth > deepest) {
    if (failed_.try_emplace(id, true).second)
      files_.problem(card->second.where, "coordinate system " + std::to_string(id) + " depends on itself",
                     "its place cannot be found", "break the ring of references");
    return nullptr;
  }
  Eigen::Matrix3d points;
  if (card->second.nodes) {
    for (int i = 0; i < 3; ++i) {
      Eigen::Vector3d place;
      if (!resolve_node((*card->second.nodes)[static_cast<std::size_t>(i)], card->second.where, depth + 1, place)) {
        failed_[id] = true;
        return nullptr;
      }
      points.col(i) = place;
    }
  } else {
    const Frame* reference = resolve(card->second.reference, card->second.where, depth + 1);
    if (reference == nullptr) {
      failed_[id] = true;
      return nullptr;
    }
    for (int i = 0; i < 3; ++i) points.col(i) = reference->place(card->second.points.col(i));
  }
  return &(frames_[id] = from_points(card->second, points));
}

Frame Frames::from_points(const SystemCard& card, const Eigen::Matrix3d& points) {
  Frame frame;
  frame.kind = card.kind;
  frame.origin = points.col(0);
  const Eigen::Vector3d up = points.col(1) - points.col(0), side = points.col(2) - points.col(0);
  const Eigen::Vector3d across = up.cross(side);
  if (!(across.norm() > 1e-10 * up.norm() * side.norm())) {
    files_.problem(card.where, "the three points of a coordinate system coincide or lie on a line",
                   "they must span its x-z plane", "mend the points");
    return frame;
  }
  const Eigen::Vector3d z = up.normalized(), y = across.normalized();
  frame.axes = columns(y.cross(z), y, z);
  return frame;
}

bool Frames::resolve_node(Id node, const Place& where, int depth, Eigen::Vector3d& place) {
  const auto index = nodes_.find(node);
  if (index < 0) {
    files_.problem(where, "grid point " + std::to_string(node) + " is missing",
                   "the coordinate system is defined by it", "add the GRID card, or mend the number");
    return false;
  }
  if (!resolve_grid(static_cast<std::size_t>(index), depth)) return false;
  place = bulk_.grids[static_cast<std::size_t>(index)].place;
  return true;
}

bool Frames::resolve_grid(std::size_t index, int depth) {
  if (placed_[index]) return true;
  Grid& grid = bulk_.grids[index];
  const Frame* frame = resolve(grid.position_system, grid.where, depth + 1);
  if (frame == nullptr) return false;
  grid.place = frame->place(grid.place);
  placed_[index] = true;
  return true;
}

}  // namespace kalfem::nastran
