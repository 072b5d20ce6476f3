// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/nastran/card_readers.hpp"

#include <algorithm>
#include <array>
#include <numbers>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/model/mesh/properties.hpp"

namespace kalfem::nastran {
namespace {

constexpr auto shapes = std::to_array<std::pair<std::string_view, std::size_t>>({{"ROD", 1},
                                                                                 {"TUBE", 2},
                                                                                 {"TUBE2", 2},
                                                                                 {"BAR", 2},
                                                                                 {"BOX", 4},
                                                                                 {"BOX1", 6},
                                                                                 {"I", 6},
                                                                                 {"I1", 4},
                                                                                 {"H", 4},
                                                                                 {"T", 4},
                                                                                 {"T1", 4},
                                                                                 {"T2", 4},
                                                                                 {"CHAN", 4},
                                                                                 {"CHAN1", 4},
                                                                                 {"CHAN2", 4},
                                                                                 {"CROSS", 4},
                                                                                 {"L", 4},
                                                                                 {"Z", 4},
                                                                                 {"HAT", 4}});

/// A point of a section: y upright, z to the left.
using Point = Eigen::Vector2d;

/// A straight wall between the ends of its middle line.
struct Wall {
  Point from, to;
  double thickness;
  [[nodiscard]] double length() const { return (to - from).norm(); }
  [[nodiscard]] double area() const { return length() * thickness; }
};

/// A rectangle by its middle and its extents along y and z.
struct Rectangle {
  Point middle;
  double height, width;
  [[nodiscard]] double area() const { return height * width; }
};

/// Rectangles that fill the section, and the middle lines of its walls, which hang together at their ends.
struct OpenSection {
  std::vector<Rectangle> rectangles;
  std::vector<Wall> walls;
};

/// Area, centroid and moments of inertia of rectangles.
struct Moments {
  double area = 0.0;
  Point centroid = Point::Zero();
  double yy = 0.0, zz = 0.0, yz = 0.0;  ///< integrals of y^2, z^2 and y z about the centroid
};

// Each rectangle has b h^3 / 12 about its own middle and A d^2 for the arm to the common centroid (Steiner).
Moments moments_of(const std::vector<Rectangle>& rectangles) {
  Moments sum;
  for (const auto& part : rectangles) {
    sum.area += part.area();
    sum.centroid += part.area() * part.middle;
  }
  sum.centroid /= sum.area;
  for (const auto& part : rectangles) {
    const Point arm = part.middle - sum.centroid;
    sum.yy += part.area() * (part.height * part.height / 12.0 + arm.x() * arm.x());
    sum.zz += part.area() * (part.width * part.width / 12.0 + arm.y() * arm.y());
    sum.yz += part.area() * arm.x() * arm.y();
  }
  return sum;
}

/// Integral of the product of two functions that are linear along a wall.
double product(const Wall& wall, double f0, double f1, double g0, double g1) {
  return wall.area() / 6.0 * (2.0 * f0 * g0 + f0 * g1 + f1 * g0 + 2.0 * f1 * g1);
}

/// Sectorial areas at the ends of the walls, with the pole at `pole`, from the start of the first wall on.
std::vector<std::array<double, 2>> sectorial_areas(const std::vector<Wall>& walls, const Point& pole) {
  std::vector<std::array<double, 2>> areas(walls.size());
  std::vector<bool> known(walls.size(), false);
  std::vector<std::pair<Point, double>> reached = {{walls.front().from, 0.0}};
  const auto sweep = [&](const Point& from, const Point& to) {
    return (from.x() - pole.x()) * (to.y() - from.y()) - (from.y() - pole.y()) * (to.x() - from.x());
  };
  for (std::size_t round = 0; round < walls.size(); ++round)
    for (std::size_t i = 0; i < walls.size(); ++i)
      for (std::size_t j = 0; j < reached.size() && !known[i]; ++j) {
        const auto [place, area] = reached[j];
        const auto& wall = walls[i];
        const double size = wall.length();
        if ((place - wall.from).norm() < 1e-9 * size)
          areas[i] = {area, area + sweep(wall.from, wall.to)};
        else if ((place - wall.to).norm() < 1e-9 * size)
          areas[i] = {area + sweep(wall.to, wall.from), area};
        else
          continue;
        known[i] = true;
        reached.emplace_back(wall.from, areas[i][0]);
        reached.emplace_back(wall.to, areas[i][1]);
      }
  return areas;
}

// Thin-walled open section: the shear centre P is the pole whose sectorial area has no product with y and z, int
// omega_P y dA = int omega_P z dA = 0. With omega_C about the centroid,
// omega_P = omega_C - p_y z + p_z y + const,   so that   p_y I_yz - p_z I_yy = int omega_C y dA
// and the same with z; these two equations give p = P - C. The origin of omega does not matter, as y and z are
// measured from the centroid.
Point shear_centre(const std::vector<Wall>& walls) {
  double area = 0.0;
  Point centroid = Point::Zero();
  for (const auto& wall : walls) {
    area += wall.area();
    centroid += wall.area() * 0.5 * (wall.from + wall.to);
  }
  centroid /= area;
  const auto omega = sectorial_areas(walls, centroid);
  double yy = 0.0, zz = 0.0, yz = 0.0, wy = 0.0, wz = 0.0;
  for (std::size_t i = 0; i < walls.size(); ++i) {
    const auto& wall = walls[i];
    const Point a = wall.from - centroid, b = wall.to - centroid;
    yy += product(wall, a.x(), b.x(), a.x(), b.x());
    zz += product(wall, a.y(), b.y(), a.y(), b.y());
    yz += product(wall, a.x(), b.x(), a.y(), b.y());
    wy += product(wall, omega[i][0], omega[i][1], a.x(), b.x());
    wz += product(wall, omega[i][0], omega[i][1], a.y(), b.y());
  }
  const Eigen::Matrix2d matrix{{yz, -yy}, {zz, -yz}};
  return centroid + matrix.partialPivLu().solve(Eigen::Vector2d(wy, wz));
}

// Area and second moments are those of the rectangles, corners counted once. Torsion is St Venant's sum of l t^3 / 3
// over the walls. Shear along an axis is carried by the rectangles along it.
SectionCard section_of(const OpenSection& open) {
  const Moments moments = moments_of(open.rectangles);
  SectionCard section;
  section.area = moments.area;
  section.i1 = moments.yy;
  section.i2 = moments.zz;
  section.i12 = moments.yz;
  double along_y = 0.0, along_z = 0.0;
  for (const auto& wall : open.walls) section.torsion += wall.length() * std::pow(wall.thickness, 3) / 3.0;
  for (const auto& part : open.rectangles) (part.height >= part.width ? along_y : along_z) += part.area();
  section.k1 = (along_z > 0.0 ? along_y : 5.0 / 6.0 * along_y) / moments.area;
  section.k2 = 5.0 / 6.0 * along_z / moments.area;
  section.neutral_axis = moments.centroid - shear_centre(open.walls);
  for (const auto& part : open.rectangles)
    for (const double y : {-0.5, 0.5})
      for (const double z : {-0.5, 0.5})
        section.outline.corners.push_back(part.middle + Point(y * part.height, z * part.width) - moments.centroid);
  return section;
}

/// From kalfem's shape functions, in which z is upright; both axes change places.
SectionCard section_of(const BeamSection& solid) {
  SectionCard section;
  section.area = solid.area;
  section.i1 = solid.inertia_y;
  section.i2 = solid.inertia_z;
  section.torsion = solid.torsion;
  section.k1 = solid.shear_factor_z;
  section.k2 = solid.shear_factor_y;
  for (const auto& corner : solid.outline.corners) section.outline.corners.push_back(corner.reverse());
  section.outline.radius = solid.outline.radius;
  return section;
}

Wall upright(double z, double bottom, double top, double thickness) { return {{bottom, z}, {top, z}, thickness}; }
Wall level(double y, double from, double to, double thickness) { return {{y, from}, {y, to}, thickness}; }
Rectangle box_between(double bottom, double top, double right, double left) {
  return {{(bottom + top) / 2.0, (right + left) / 2.0}, top - bottom, left - right};
}

/// Web between two flanges, each from `right` to `left` of the web's middle at z = 0 and of its own thickness.
struct Flange {
  double right, left, thickness;
};
OpenSection web_and_flanges(double height, double web, const Flange& bottom, const Flange& top) {
  OpenSection open;
  open.rectangles = {box_between(bottom.thickness, height - top.thickness, -web / 2.0, web / 2.0),
                     box_between(0.0, bottom.thickness, bottom.right, bottom.left),
                     box_between(height - top.thickness, height, top.right, top.left)};
  const double low = bottom.thickness / 2.0, high = height - top.thickness / 2.0;
  open.walls = {upright(0.0, low, high, web)};
  const auto add = [&](double y, const Flange& flange) {
    // Flanges that end at the web's face have no part beyond its middle line.
    if (flange.right < -web) open.walls.push_back(level(y, 0.0, flange.right, flange.thickness));
    if (flange.left > web) open.walls.push_back(level(y, 0.0, flange.left, flange.thickness));
  };
  add(low, bottom);
  add(high, top);
  return open;
}

/// A flange at the bottom (at y = 0) or the top of a web.
OpenSection tee(double width, double height, double flange, double web, bool on_top) {
  const double sign = on_top ? -1.0 : 1.0;
  OpenSection open;
  const auto part = [&](double from, double to, double half) {
    open.rectangles.push_back(
        box_between(std::min(sign * from, sign * to), std::max(sign * from, sign * to), -half, half));
  };
  part(0.0, flange, width / 2.0);
  part(flange, height, web / 2.0);
  const double line = sign * flange / 2.0;
  open.walls = {level(line, 0.0, -width / 2.0, flange), level(line, 0.0, width / 2.0, flange),
                upright(0.0, line, sign * height, web)};
  return open;
}

/// The same section lying: y and z change places.
OpenSection turned(OpenSection open) {
  for (auto& part : open.rectangles) {
    part.middle = part.middle.reverse().eval();
    std::swap(part.height, part.width);
  }
  for (auto& wall : open.walls) {
    wall.from = wall.from.reverse().eval();
    wall.to = wall.to.reverse().eval();
  }
  return open;
}

OpenSection hat(double height, double t, double top, double brim) {
  const double inner = top / 2.0 - t, outer = top / 2.0, line = top / 2.0 - t / 2.0;
  OpenSection open;
  open.rectangles = {box_between(height - t, height, -outer, outer), box_between(t, height - t, -outer, -inner),
                     box_between(t, height - t, inner, outer), box_between(0.0, t, -outer - brim, -inner),
                     box_between(0.0, t, inner, outer + brim)};
  const double low = t / 2.0, high = height - t / 2.0;
  open.walls = {level(high, -line, line, t), upright(-line, high, low, t), upright(line, high, low, t),
                level(low, -line, -outer - brim, t), level(low, line, outer + brim, t)};
  return open;
}

// Shear is carried by the two walls along it, with the factor 5/6.
/// A closed box with walls of their own thickness.
SectionCard box_section(double width, double height, double top, double bottom, double left, double right) {
  const std::vector<Rectangle> rectangles = {
      box_between(0.0, height, 0.0, right), box_between(0.0, height, width - left, width),
      box_between(0.0, bottom, right, width - left), box_between(height - top, height, right, width - left)};
  const Moments moments = moments_of(rectangles);
  SectionCard section;
  section.area = moments.area;
  section.i1 = moments.yy;
  section.i2 = moments.zz;
  section.i12 = moments.yz;
  section.torsion =
      box_torsion(width - (left + right) / 2.0, height - (top + bottom) / 2.0, {bottom, top}, {left, right});
  section.k1 = 5.0 / 6.0 * height * (left + right) / moments.area;
  section.k2 = 5.0 / 6.0 * width * (top + bottom) / moments.area;
  return section;
}

// DIM1, DIM2, ... of the card are at(1), at(2), ..., as the Quick Reference Guide numbers them for each TYPE.
OpenSection open_section(const std::string& shape, const std::vector<double>& d) {
  const auto at = [&](std::size_t i) { return d[i - 1]; };
  const auto symmetric = [](double width, double thickness) { return Flange{-width / 2.0, width / 2.0, thickness}; };
  if (shape == "I") return web_and_flanges(at(1), at(4), symmetric(at(2), at(5)), symmetric(at(3), at(6)));
  if (shape == "I1") {
    const auto flange = symmetric(at(1) + at(2), (at(4) - at(3)) / 2.0);
    return web_and_flanges(at(4), at(2), flange, flange);
  }
  // Legs upright, the cross bar between their faces: an I that lies.
  if (shape == "H") {
    OpenSection open;
    const double leg = at(2) / 2.0, half = at(1) / 2.0, line = half + leg / 2.0, mid = at(3) / 2.0;
    open.rectangles = {box_between(0.0, at(3), -half - leg, -half), box_between(0.0, at(3), half, half + leg),
                       box_between(mid - at(4) / 2.0, mid + at(4) / 2.0, -half, half)};
    open.walls = {level(mid, -line, line, at(4)), upright(-line, mid, 0.0, leg), upright(-line, mid, at(3), leg),
                  upright(line, mid, 0.0, leg), upright(line, mid, at(3), leg)};
    return open;
  }
  if (shape == "T") return tee(at(1), at(2), at(3), at(4), true);
  if (shape == "T2") return tee(at(1), at(2), at(3), at(4), false);
  if (shape == "T1") return turned(tee(at(1), at(2) + at(3), at(3), at(4), false));
  if (shape == "CHAN") {
    const Flange flange{at(3) / 2.0 - at(1), at(3) / 2.0, at(4)};
    return web_and_flanges(at(2), at(3), flange, flange);
  }
  if (shape == "CHAN1") {
    const Flange flange{-at(1) - at(2) / 2.0, at(2) / 2.0, (at(4) - at(3)) / 2.0};
    return web_and_flanges(at(4), at(2), flange, flange);
  }
  if (shape == "CHAN2") {
    const Flange leg{at(2) / 2.0 - at(3), at(2) / 2.0, at(1)};
    auto open = turned(web_and_flanges(at(4), at(2), leg, leg));
    for (auto& part : open.rectangles) part.middle.x() *= -1.0;
    for (auto& wall : open.walls) wall.from.x() *= -1.0, wall.to.x() *= -1.0;
    return open;
  }
  if (shape == "Z") {
    const double t = (at(4) - at(3)) / 2.0, web = at(2) / 2.0;
    return web_and_flanges(at(4), at(2), {-web - at(1), web, t}, {-web, web + at(1), t});
  }
  if (shape == "CROSS") {
    OpenSection open;
    const double web = at(2) / 2.0, mid = at(3) / 2.0, side = at(1) / 2.0;
    open.rectangles = {box_between(0.0, at(3), -web, web),
                       box_between(mid - at(4) / 2.0, mid + at(4) / 2.0, web, web + side),
                       box_between(mid - at(4) / 2.0, mid + at(4) / 2.0, -web - side, -web)};
    open.walls = {upright(0.0, mid, 0.0, at(2)), upright(0.0, mid, at(3), at(2)), level(mid, 0.0, web + side, at(4)),
                  level(mid, 0.0, -web - side, at(4))};
    return open;
  }
  if (shape == "L") {
    OpenSection open;
    const double leg = at(4) / 2.0;
    open.rectangles = {box_between(0.0, at(2), -leg, leg), box_between(0.0, at(3), leg - at(1), -leg)};
    open.walls = {upright(0.0, at(3) / 2.0, at(2), at(4)), level(at(3) / 2.0, 0.0, leg - at(1), at(3))};
    return open;
  }
  return hat(at(1), at(2), at(3), at(4));
}

}  // namespace

std::size_t dimension_count(const std::string& shape) {
  const auto place = std::ranges::find(shapes, shape, &std::pair<std::string_view, std::size_t>::first);
  return place == shapes.end() ? 0 : place->second;
}

SectionCard section_of_shape(const std::string& shape, const std::vector<double>& d, const std::string& title) {
  const auto refuse = [&]() -> SectionCard {
    throw CardError(title + ": the dimensions do not form the section " + shape,
                    "lengths must be > 0 and walls must not overlap", "correct the dimensions");
  };
  if (dimension_count(shape) != d.size()) return refuse();
  for (std::size_t i = 0; i < d.size(); ++i)
    if (!(d[i] > 0.0) && !(shape == "TUBE" && i == 1 && d[i] == 0.0)) return refuse();
  try {
    if (shape == "ROD" || (shape == "TUBE" && d[1] == 0.0)) return section_of(circular_section(2.0 * d[0]));
    if (shape == "TUBE") return section_of(circular_tube_section(2.0 * d[0], d[0] - d[1]));
    if (shape == "TUBE2") return section_of(circular_tube_section(2.0 * d[0], d[1]));
    if (shape == "BAR") return section_of(rectangular_section(d[0], d[1]));
  } catch (const InvalidInput&) {
    return refuse();
  }
  if (shape == "BOX" || shape == "BOX1") {
    const bool same = shape == "BOX";
    const double top = d[2], bottom = same ? d[2] : d[3], left = same ? d[3] : d[4], right = same ? d[3] : d[5];
    if (top + bottom >= d[1] || left + right >= d[0]) return refuse();
    return box_section(d[0], d[1], top, bottom, left, right);
  }
  const OpenSection open = open_section(shape, d);
  for (const auto& part : open.rectangles)
    if (!(part.height > 0.0 && part.width > 0.0)) return refuse();
  return section_of(open);
}

}  // namespace kalfem::nastran
