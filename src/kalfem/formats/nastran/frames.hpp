#pragma once

#include <map>

#include "kalfem/formats/gmsh/gmsh_builder.hpp"
#include "kalfem/formats/nastran/bulk_data.hpp"
#include "kalfem/formats/nastran/card_stream.hpp"

namespace kalfem::nastran {

/// A coordinate system in basic axes.
struct Frame {
  SystemKind kind = SystemKind::rectangular;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< columns x, y, z

  /// Basic place of coordinates: x y z; r theta z; or rho theta phi with theta from the z axis and phi about it, angles
  /// in degrees.
  [[nodiscard]] Eigen::Vector3d place(const Eigen::Vector3d& coordinates) const;
  /// Unit vectors along the coordinates at a place, as columns; on the z axis those of angle 0.
  [[nodiscard]] Eigen::Matrix3d directions(const Eigen::Vector3d& at) const;
};

/// All coordinate systems of a deck, and the places of its nodes, which depend on each other in any order.
class Frames {
public:
  /// Writes the places of the nodes in basic axes into bulk.grids. Notes systems that are missing, that depend on
  /// themselves and whose points lie on a line.
  Frames(BulkData& bulk, const NumberLookup& nodes, DeckFiles& files);
  /// The system of this number, 0 is the basic one; null where there is none, which is noted once with the place.
  [[nodiscard]] const Frame* find(Id system, const Place& where) const;

private:
  const Frame* resolve(Id system, const Place& where, int depth);
  bool resolve_node(Id node, const Place& where, int depth, Eigen::Vector3d& place);
  bool resolve_grid(std::size_t index, int depth);
  Frame from_points(const SystemCard& card, const Eigen::Matrix3d& points);

  BulkData& bulk_;
  const NumberLookup& nodes_;
  DeckFiles& files_;
  std::map<Id, Frame> frames_;
  std::map<Id, bool> failed_;
  std::vector<bool> placed_;
};

}  // namespace kalfem::nastran
