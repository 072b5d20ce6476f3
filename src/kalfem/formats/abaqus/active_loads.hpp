// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <tuple>

#include "kalfem/formats/abaqus/placed_deck.hpp"
#include "kalfem/model/statics/load_case.hpp"

namespace kalfem::abaqus {

/// GRAV, CENTRIF or a force per volume on a set of elements.
struct BodyLoad {
  enum class Kind { gravity, centrifugal, force_per_volume };
  Kind kind = Kind::gravity;
  std::string set = {};                                 ///< as it stands, in capitals; empty: the whole model
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< of unit length: of the load, or of the axis
  Eigen::Vector3d about = Eigen::Vector3d::Zero();      ///< a point of the axis
  double value = 0.0;                                   ///< acceleration, square of the speed, or force per volume
  int step = 0;                                         ///< that gave the value
  Where where = {};
};

/// Loads that act at one time. Lines of one step add up; a line of a later step takes the place of what earlier steps
/// gave to the same node and direction, the same face of an element, or the same body load of a set. CalculiX takes
/// body loads of another direction as further ones, Abaqus as the same.
class ActiveLoads {
public:
  explicit ActiveLoads(bool of_abaqus) : of_abaqus_(of_abaqus) {}

  void begin_step() { ++step_; }
  void add_force(const NodalDof& dof, double value) { add(forces_, dof, value); }
  /// `face`: its label; `by_surface`: by *DSLOAD, which Abaqus keeps apart from *DLOAD.
  void add_pressure(Index element, const std::string& face, bool by_surface, const LoadedFace& loaded, double value);
  void add_body(BodyLoad load);

  void remove_forces() { forces_.clear(); }
  /// *DLOAD, OP=NEW or, `by_surface`, *DSLOAD, OP=NEW; in CalculiX each removes what both gave.
  void remove_distributed(bool by_surface);
  void remove_all() { *this = ActiveLoads(of_abaqus_); }

  /// In the axes of the nodes.
  [[nodiscard]] std::map<NodalDof, double> forces() const;
  /// Faces of the same pressure together.
  [[nodiscard]] std::vector<SurfacePressure> pressures() const;
  [[nodiscard]] const std::vector<BodyLoad>& bodies() const { return bodies_; }

private:
  struct Entry {
    double value = 0.0;
    int step = 0;
  };
  struct Pressed {
    LoadedFace face;
    Entry entry;
  };
  using Face = std::tuple<Index, std::string, bool>;

  template <typename Key>
  void add(std::map<Key, Entry>& entries, const Key& key, double value) {
    add(entries[key], value);
  }
  void add(Entry& entry, double value) const { entry = {entry.step == step_ ? entry.value + value : value, step_}; }

  bool of_abaqus_;
  int step_ = 0;
  std::map<NodalDof, Entry> forces_;
  std::map<Face, Pressed> faces_;
  std::vector<BodyLoad> bodies_;
};

}  // namespace kalfem::abaqus
