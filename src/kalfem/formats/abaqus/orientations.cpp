// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/abaqus/orientations.hpp"

#include <cmath>
#include <numbers>

#include "kalfem/formats/abaqus/ledger_sweep.hpp"
#include "kalfem/formats/abaqus/placed_deck.hpp"
#include "kalfem/formats/abaqus/raw_deck.hpp"

namespace kalfem::abaqus {

std::optional<Eigen::Matrix3d> axes_from(const Eigen::Vector3d& x, const Eigen::Vector3d& in_plane) {
  const double scale = x.norm() * in_plane.norm();
  const Eigen::Vector3d normal = x.cross(in_plane);
  if (!(scale > 0.0) || !std::isfinite(scale) || normal.norm() < 1e-9 * scale) return {};
  Eigen::Matrix3d axes;
  axes.col(0) = x.normalized();
  axes.col(2) = normal.normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  return axes;
}

Eigen::Matrix3d rotation(const Eigen::Vector3d& axis, double angle) {
  return Eigen::AngleAxisd(angle, axis).toRotationMatrix();
}

// Of a curved system the axes follow from the place: the arm from the origin is split into its part along the polar
// axis and the radial one. On the polar axis itself every radial direction is as good, and the system's own x is taken.
// The additional rotation comes last, about the axis as it lies at that place.
Eigen::Matrix3d LocalAxes::at(const Eigen::Vector3d& place) const {
  Eigen::Matrix3d local = axes;
  if (kind != AxesKind::rectangular) {
    const Eigen::Vector3d polar = axes.col(2), arm = place - origin;
    const Eigen::Vector3d outward = arm - polar * polar.dot(arm);
    const bool on_axis = outward.norm() <= 1e-9 * (arm.norm() + 1e-300);
    const Eigen::Vector3d radial = on_axis ? Eigen::Vector3d(axes.col(0)) : Eigen::Vector3d(outward.normalized());
    const Eigen::Vector3d tangential = polar.cross(radial);
    if (kind == AxesKind::cylindrical) {
      local << radial, tangential, polar;
    } else {
      const Eigen::Vector3d outer = arm.norm() > 0.0 ? Eigen::Vector3d(arm.normalized()) : radial;
      local << outer, tangential, outer.cross(tangential);
    }
  }
  if (angle != 0.0) local = rotation(local.col(rotated_axis), angle) * local;
  return local;
}

namespace {

/// A frame whose z axis runs from a to b.
std::optional<Eigen::Matrix3d> polar_axes(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const Eigen::Vector3d polar = b - a;
  if (!(polar.norm() > 0.0) || !polar.allFinite()) return {};
  Eigen::Matrix3d axes;
  axes.col(2) = polar.normalized();
  axes.col(0) = axes.col(2).unitOrthogonal();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  return axes;
}

// Points are moved with their instance, as the nodes are. A missing point is the origin of the instance.
/// The points a, b, c that a definition gives, by coordinates or by nodes.
std::optional<std::array<Eigen::Vector3d, 3>> defining_points(PlacedDeck& deck, const PlacedBlock& at) {
  const auto& line = line_of(*at.block, 0);
  const auto& motion = deck.place(at.place).motion;
  const std::string definition = at.block->keyword.word("DEFINITION");
  if (!definition.empty() && definition != "COORDINATES" && definition != "NODES") {
    deck.problems.add(at.block->keyword.where, "DEFINITION=" + to_string(definition) + " is not read",
                      "local axes must be given by coordinates or nodes", "define the axes by coordinates");
    return {};
  }
  std::array<Eigen::Vector3d, 3> points = {motion.translation(), motion.translation(), motion.translation()};
  if (definition == "NODES") {
    for (std::size_t i = 0; i < 3 && !line.field(i).empty(); ++i) {
      const auto node = deck.node_list({line.field(i), line.where}, at.place);
      if (node.size() != 1) return {};
      points[i] = deck.mesh.nodes.col(node.front());
    }
    return points;
  }
  if (!line.fields.empty() && !to_number(line.field(0))) {
    deck.problems.add(line.where, "the axes refer to '" + to_string(line.field(0)) + "'",
                      "distributions over elements are not supported", "define the axes by coordinates");
    return {};
  }
  for (std::size_t i = 0; i < 9 && i < line.fields.size(); ++i)
    points[i / 3][static_cast<Index>(i % 3)] = number_or(line, i, 0.0, "a coordinate", deck.problems);
  if (line.fields.size() < 6) {
    deck.problems.add(at.block->keyword.where, at.block->keyword.title + " has fewer than six coordinates",
                      "two points define the axes", "correct the data line");
    return {};
  }
  for (std::size_t i = 0; i < 3; ++i) {
    Eigen::Vector3d given = Eigen::Vector3d::Zero();
    for (std::size_t a = 0; a < 3; ++a)
      given[static_cast<Index>(a)] = number_or(line, 3 * i + a, 0.0, "a coordinate", deck.problems);
    points[i] = motion * given;
  }
  return points;
}

void report_line(PlacedDeck& deck, const PlacedBlock& at) {
  deck.problems.add(at.block->keyword.where, "the points of " + at.block->keyword.title + " lie on one line",
                    "they must define the directions of the axes", "correct them");
}

}  // namespace

// The points a, b, c mean something else in each system: c is the origin of a rectangular one, with x (or z) through a
// and b in the plane; a and b lie on the polar axis of a curved one. Then the second line turns the axes about one of
// them.
LocalAxes orientation_axes(PlacedDeck& deck, const std::string& name, int place, const Where& where) {
  const PlacedBlock at = deck.find_block("ORIENTATION", name, place);
  if (!at.block) {
    deck.problems.add(where, "there is no orientation '" + to_string(name) + "'", "",
                      "define it by *ORIENTATION, NAME=...");
    return {};
  }
  const auto points = defining_points(deck, at);
  if (!points) return {};
  const auto& [a, b, c] = *points;
  const std::string system = at.block->keyword.word("SYSTEM");
  LocalAxes result;
  std::optional<Eigen::Matrix3d> axes;
  if (system.empty() || system == "RECTANGULAR" || system == "R") {
    axes = axes_from(a - c, b - c);
  } else if (system == "ZRECTANGULAR") {
    if (const auto turned = axes_from(a - c, b - c)) {  // z, x, y in the order of the columns
      axes.emplace();
      *axes << turned->col(1), -turned->col(2), turned->col(0);
      axes->col(1) = axes->col(2).cross(axes->col(0));
    }
  } else if (system == "CYLINDRICAL" || system == "C" || system == "SPHERICAL" || system == "S") {
    result.kind = system.front() == 'C' ? AxesKind::cylindrical : AxesKind::spherical;
    result.origin = a;
    axes = polar_axes(a, b);
    forget_from(line_of(*at.block, 0), 6);  // two points are all
  } else {
    deck.problems.add(at.block->keyword.where, "SYSTEM=" + to_string(system) + " is not read",
                      "axes can be rectangular, cylindrical or spherical", "correct it");
    return {};
  }
  if (!axes) {
    report_line(deck, at);
    return {};
  }
  result.axes = *axes;
  if (const auto& turn = line_of(*at.block, 1); !turn.fields.empty()) {
    const double axis = number_or(turn, 0, 1.0, "1, 2 or 3", deck.problems);
    if (axis != 1.0 && axis != 2.0 && axis != 3.0)
      deck.problems.add(turn.where, "the axes are rotated about axis " + to_string(turn.field(0)),
                        "the axes are 1, 2 and 3", "correct the line");
    else
      result.rotated_axis = static_cast<int>(axis) - 1;
    if (!turn.field(1).empty() && !to_number(turn.field(1)))
      deck.problems.add(turn.where, "the angle of the axes is '" + to_string(turn.field(1)) + "'",
                        "distributions over elements are not supported", "give a number in degrees");
    else
      result.angle = degree * number_or(turn, 1, 0.0, "an angle", deck.problems);
  }
  return result;
}

// *TRANSFORM gives two points: directions of x and of the x-y plane from the origin (R), or a and b on the polar axis
// (C, S).
LocalAxes transform_axes(PlacedDeck& deck, const PlacedBlock& at) {
  const auto& line = line_of(*at.block, 0);
  std::array<Eigen::Vector3d, 2> points;
  for (std::size_t i = 0; i < 6; ++i)
    points[i / 3][static_cast<Index>(i % 3)] = number_or(line, i, 0.0, "a coordinate", deck.problems);
  const auto& motion = deck.place(at.place).motion;
  const std::string type = at.block->keyword.word("TYPE");
  LocalAxes result;
  std::optional<Eigen::Matrix3d> axes;
  if (type.empty() || type == "R") {
    axes = axes_from(motion.linear() * points[0], motion.linear() * points[1]);
  } else if (type == "C" || type == "S") {
    result.kind = type == "C" ? AxesKind::cylindrical : AxesKind::spherical;
    result.origin = motion * points[0];
    axes = polar_axes(result.origin, motion * points[1]);
  } else {
    deck.problems.add(at.block->keyword.where, "*TRANSFORM has TYPE=" + to_string(type), "it must be R, C or S",
                      "correct it");
    return {};
  }
  if (!axes) {
    report_line(deck, at);
    return {};
  }
  result.axes = *axes;
  return result;
}

// An axis that is almost along the normal gives no direction in the surface; the next one does.
Eigen::Vector3d shell_direction(const LocalAxes& axes, const Eigen::Vector3d& place, const Eigen::Vector3d& normal) {
  const Eigen::Matrix3d local = axes.at(place);
  for (int step = 1; step <= 3; ++step) {
    const Eigen::Vector3d axis = local.col((axes.rotated_axis + step) % 3);
    const Eigen::Vector3d laid = axis - normal * normal.dot(axis);
    if (laid.norm() > 1e-3) return laid.normalized();
  }
  return shell_direction(normal);
}

// Abaqus's default: the projection of the global x axis, or of z where the normal is within 0.1 degrees of x.
Eigen::Vector3d shell_direction(const Eigen::Vector3d& normal) {
  const Eigen::Vector3d x = std::abs(normal.x()) > std::cos(0.1 * degree) ? Eigen::Vector3d(Eigen::Vector3d::UnitZ())
                                                                          : Eigen::Vector3d(Eigen::Vector3d::UnitX());
  return (x - normal * normal.dot(x)).normalized();
}

}  // namespace kalfem::abaqus
