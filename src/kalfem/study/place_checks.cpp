// SPDX-License-Identifier: Apache-2.0
#include "kalfem/study/case_checks.hpp"

#include <algorithm>
#include <map>
#include <unordered_set>

namespace kalfem {
namespace {

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::ranges::find(names, name) != names.end();
}

/// Checks the points and grounds that connectors and excitations name: first that both ends of each connector exist,
/// then the target of each excitation, at last that no connector joins two grounds at rest. The last check needs the
/// grounds that the excitations move.
class PlaceChecks {
public:
  PlaceChecks(const description::Case& given, const StructureParts& parts, IssueList& issues)
      : given_(given),
        issues_(issues),
        parts_(parts),
        grounds_(ground_names(parts)),
        model_(couple({parts.substructures, parts.finite_elements, {}, {}})),
        points_(model_.point_names()),
        known_(points_.begin(), points_.end()) {}

  void run() {
    for (const auto& [name, connector] : given_.connectors)
      for (const auto& end : {connector.from, connector.to})
        if (end.value != fixed_ground) find(end);
    for (const auto& [name, excitation] : given_.excitation)
      std::visit([&](const auto& target) { check(target); }, excitation.target);
    for (const auto& [name, connector] : given_.connectors) check_ends(name, connector);
  }

private:
  bool find(const Name& name) {
    const bool found = known_.contains(name.value);
    if (!found)
      issues_.add(name.location,
                  name.path + ": there is no point '" + name.value + "'" + did_you_mean(name.value, points_),
                  "write points as substructure.name", "name a mass, point or ground of a substructure");
    return found;
  }

  void check(const description::Force& target) { find(target.point); }

  void check(const description::SignalTarget& /*of_a_law*/) {}  // the law feels it

  void check(const description::BaseDisplacement& target) { check_ground(target.ground); }

  void check(const description::BaseVelocity& target) { check_ground(target.ground); }

  void check_ground(const Name& name) {
    if (!find(name)) return;
    if (contains(grounds_, name.value))
      drive(name);
    else
      issues_.add(name.location,
                  name.path + ": '" + name.value + "' is not a ground" + did_you_mean(name.value, grounds_),
                  "only a ground can be moved", "write it as substructure.ground");
  }

  void check(const description::BaseAcceleration& target) {
    const auto& points = target.direction;
    if (points.value.empty())
      issues_.add(points.location, points.path + " lists no ground", "it would accelerate nothing",
                  "list grounds or write all");
    for (const auto& [point, weight] : points.value)
      if (weight == 0.0 || (point == "all" && weight != 1.0))
        issues_.add(points.location, points.path + ": the weight of '" + point + "' is " + shortest(weight),
                    weight == 0.0 ? "a ground with weight 0 would not move" : "with `all`, every ground has weight 1",
                    "set the size of the signal by `scale`");
    if (points.value.size() == 1 && points.value.front().first == "all") return check_translation(points);
    std::size_t grounds = 0;
    for (const auto& [point, weight] : points.value) {
      const Name name{point, points.location, points.path};
      if (!find(name) || !contains(grounds_, point)) continue;
      ++grounds;
      drive(name);
    }
    if (grounds > 0 && grounds < points.value.size())
      issues_.add(points.location, points.path + " lists both grounds and degrees of freedom",
                  "an excitation accelerates either single grounds or the whole base", "make it two excitations");
  }

  /// The structure must follow a base that moves every degree of freedom alike.
  void check_translation(const description::Points& all) {
    try {
      couple({parts_.substructures, parts_.finite_elements, {}, {{all.path, InputKind::base_acceleration, "", {}}}});
    } catch (const InvalidInput& error) {
      issues_.add(error, all.location);
    }
  }

  /// Each ground has one motion, and something must feel it.
  void drive(const Name& ground) {
    const auto [first, added] = driven_.emplace(ground.value, ground);
    if (!added)
      issues_.add(ground.location, ground.path + ": the ground '" + ground.value + "' is driven twice",
                  "the excitation on line " + std::to_string(first->second.location.line) + " drives it already",
                  "keep one of the two");
    else if (!is_felt(ground.value))
      issues_.add(ground.location, ground.path + ": nothing is attached to the ground '" + ground.value + "'",
                  "its motion would have no effect", "name a ground with a spring or a connector");
  }

  [[nodiscard]] bool is_felt(const std::string& ground) const {
    for (const auto& [name, connector] : given_.connectors)
      if (connector.from.value == ground || connector.to.value == ground) return true;
    for (const auto& part : model_.substructures())
      for (const auto& coupling : part.model->grounds)
        if (part.name + "." + coupling.ground == ground)
          return !coupling.stiffness.isZero(0.0) || !coupling.damping.isZero(0.0);
    return false;
  }

  /// A connector between two grounds needs one that moves.
  void check_ends(const std::string& name, const description::Connector& connector) {
    const auto is_ground = [&](const std::string& end) { return end == fixed_ground || contains(grounds_, end); };
    const std::string &from = connector.from.value, &to = connector.to.value;
    if (is_ground(from) && is_ground(to) && (from == to || (!driven_.contains(from) && !driven_.contains(to))))
      issues_.add(connector.from.location,
                  "connector '" + name + "' connects the grounds '" + from + "' and '" + to + "', which do not move",
                  "it has no effect", "connect a point to a ground, or move one of the grounds by an excitation");
  }

  const description::Case& given_;
  IssueList& issues_;
  const StructureParts& parts_;
  std::vector<std::string> grounds_;
  CoupledModel model_;
  std::vector<std::string> points_;
  std::unordered_set<std::string> known_;
  std::map<std::string, Name> driven_;  ///< grounds, with the first excitation that moves them
};

}  // namespace

void check_places(const description::Case& given, const StructureParts& parts, IssueList& issues) {
  PlaceChecks(given, parts, issues).run();
}

}  // namespace kalfem
