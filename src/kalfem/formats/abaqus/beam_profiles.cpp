// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/abaqus/elements.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "kalfem/formats/abaqus/raw_deck.hpp"

namespace kalfem::abaqus {

namespace {

/// A rectangle of a section that is put together, with sides along the axes.
struct Plate {
  Eigen::Vector2d centre;
  double along_1, along_2;
  double sign = 1.0;  ///< -1: a hole
};

/// Area, centroid and second moments of rectangles.
BeamProfile put_together(const std::vector<Plate>& plates) {
  BeamProfile profile;
  Eigen::Vector2d moment = Eigen::Vector2d::Zero();
  for (const auto& plate : plates) {
    const double area = plate.sign * plate.along_1 * plate.along_2;
    profile.area += area;
    moment += area * plate.centre;
  }
  profile.centroid = moment / profile.area;
  for (const auto& plate : plates) {
    const double area = plate.sign * plate.along_1 * plate.along_2;
    const Eigen::Vector2d arm = plate.centre - profile.centroid;
    profile.i11 += area * (plate.along_2 * plate.along_2 / 12.0 + arm.y() * arm.y());
    profile.i22 += area * (plate.along_1 * plate.along_1 / 12.0 + arm.x() * arm.x());
    profile.i12 += area * arm.x() * arm.y();
    if (plate.sign > 0.0)
      for (const double x : {-0.5, 0.5})
        for (const double y : {-0.5, 0.5})
          profile.outline.corners.emplace_back(arm + Eigen::Vector2d(x * plate.along_1, y * plate.along_2));
  }
  profile.shear_centre = profile.centroid;
  return profile;
}

BeamProfile symmetric(const BeamSection& section) {
  BeamProfile profile{section.area,           section.inertia_z,     0.0, section.inertia_y, section.torsion,
                      section.shear_factor_z, section.shear_factor_y};
  for (const auto& corner : section.outline.corners) profile.outline.corners.emplace_back(corner.y(), -corner.x());
  profile.outline.radius = section.outline.radius;
  return profile;
}

/// Axes d1 and d2 of an ellipse; J of [TG70].
BeamProfile ellipse(double d1, double d2, double poissons_ratio) {
  constexpr double pi = std::numbers::pi;
  BeamProfile profile = symmetric(circular_section(std::sqrt(d1 * d2), poissons_ratio));
  if (d1 != d2) profile.outline = {};
  profile.area = pi * d1 * d2 / 4.0;
  profile.i11 = pi * d1 * std::pow(d2, 3) / 64.0;
  profile.i22 = pi * d2 * std::pow(d1, 3) / 64.0;
  profile.torsion = pi * std::pow(d1 * d2, 3) / (16.0 * (d1 * d1 + d2 * d2));
  return profile;
}

/// Outer sides a, b; walls at the right, top, left and bottom.
std::optional<BeamProfile> box(double a, double b, double right, double top, double left, double bottom, double nu) {
  if (!(right > 0.0 && top > 0.0 && left > 0.0 && bottom > 0.0 && left + right < a && top + bottom < b)) return {};
  BeamProfile profile = put_together(
      {{{0.0, 0.0}, a, b}, {{(left - right) / 2.0, (bottom - top) / 2.0}, a - left - right, b - top - bottom, -1.0}});
  profile.torsion = box_torsion(a - (left + right) / 2.0, b - (top + bottom) / 2.0, {bottom, top}, {left, right});
  const double mean = std::min((left + right + top + bottom) / 4.0, 0.49 * std::min(a, b));
  const auto even = symmetric(rectangular_tube_section(b, a, mean, nu));
  profile.shear_1 = even.shear_1;
  profile.shear_2 = even.shear_2;
  return profile;
}

/// Height of the origin above the underside, height, widths of the flanges below and above, their thicknesses, web.
std::optional<BeamProfile> i_profile(double l, double h, double b1, double b2, double t1, double t2, double t3) {
  if (!(h > t1 + t2 && t3 > 0.0 && t1 >= 0.0 && t2 >= 0.0 && b1 >= 0.0 && b2 >= 0.0)) return {};
  std::vector<Plate> plates = {{{0.0, t1 + (h - t1 - t2) / 2.0 - l}, t3, h - t1 - t2}};
  if (b1 * t1 > 0.0) plates.push_back({{0.0, t1 / 2.0 - l}, b1, t1});
  if (b2 * t2 > 0.0) plates.push_back({{0.0, h - t2 / 2.0 - l}, b2, t2});
  BeamProfile profile = put_together(plates);
  profile.torsion = ((h - t1 - t2) * std::pow(t3, 3) + b1 * std::pow(t1, 3) + b2 * std::pow(t2, 3)) / 3.0;
  const double below = t1 * std::pow(b1, 3), above = t2 * std::pow(b2, 3);
  if (below + above > 0.0) profile.shear_centre.y() = t1 / 2.0 - l + (h - (t1 + t2) / 2.0) * above / (below + above);
  profile.shear_2 = std::min(1.0, h * t3 / profile.area);
  const double flanges = b1 * t1 + b2 * t2;
  profile.shear_1 = 5.0 / 6.0 * (flanges > 0.0 ? std::min(1.0, flanges / profile.area) : 1.0);
  return profile;
}

/// Legs of length a along 1 and b along 2 with their thicknesses; origin and shear centre where their middles meet.
std::optional<BeamProfile> l_profile(double a, double b, double t1, double t2) {
  if (!(t1 > 0.0 && t2 > 0.0 && a > t2 && b > t1)) return {};
  const Eigen::Vector2d corner(t2 / 2.0, t1 / 2.0);
  BeamProfile profile = put_together({{Eigen::Vector2d(a / 2.0, t1 / 2.0) - corner, a, t1},
                                      {Eigen::Vector2d(t2 / 2.0, t1 + (b - t1) / 2.0) - corner, t2, b - t1}});
  profile.shear_centre.setZero();
  profile.torsion = (a * std::pow(t1, 3) + (b - t1) * std::pow(t2, 3)) / 3.0;
  profile.shear_1 = 5.0 / 6.0 * std::min(1.0, a * t1 / profile.area);
  profile.shear_2 = 5.0 / 6.0 * std::min(1.0, b * t2 / profile.area);
  return profile;
}

/// A, I11, I12, I22, J; shear areas are the whole one unless they are given apart.
std::optional<BeamProfile> general(const std::vector<double>& c) {
  if (!(c[0] > 0.0 && c[1] > 0.0 && c[3] > 0.0 && c[4] >= 0.0 && c[1] * c[3] > c[2] * c[2])) return {};
  return BeamProfile{c[0], c[1], c[2], c[3], c[4], 1.0, 1.0};
}

std::optional<BeamProfile> build(const std::string& shape, const std::vector<double>& d, double nu) {
  if (shape == "RECT") return symmetric(rectangular_section(d[1], d[0], nu));
  if (shape == "CIRC") return d.size() > 1 && d[1] > 0.0 ? ellipse(d[0], d[1], nu) : ellipse(2 * d[0], 2 * d[0], nu);
  if (shape == "PIPE") return symmetric(circular_tube_section(2.0 * d[0], d[1], nu));
  if (shape == "BOX") return box(d[0], d[1], d[2], d[3], d[4], d[5], nu);
  if (shape == "I") return i_profile(d[0], d[1], d[2], d[3], d[4], d[5], d[6]);
  if (shape == "L") return l_profile(d[0], d[1], d[2], d[3]);
  return general(d);
}

}  // namespace

std::size_t profile_numbers(const std::string& shape) {
  static const std::map<std::string, std::size_t> numbers = {{"RECT", 2}, {"CIRC", 1}, {"PIPE", 2},   {"BOX", 6},
                                                             {"I", 7},    {"L", 4},    {"GENERAL", 5}};
  const auto known = numbers.find(shape);
  return known == numbers.end() ? 0 : known->second;
}

std::optional<BeamProfile> beam_profile(const std::string& shape, const std::vector<double>& data, double nu,
                                        const Where& where, Problems& problems) {
  const std::size_t needed = profile_numbers(shape);
  if (needed == 0) {
    problems.add(where, "SECTION=" + to_string(shape) + " is not read",
                 "supported: RECT, CIRC, PIPE, BOX, I, L and GENERAL",
                 "give its A, I11, I12, I22 and J by *BEAM GENERAL SECTION, SECTION=GENERAL");
    return {};
  }
  std::vector<double> d = data;
  // One wall of a box stands for all.
  if (shape == "BOX" && d.size() == 3) d.resize(6, d[2]);
  if (shape == "GENERAL" && d.size() == 4) d.push_back(0.0);
  std::optional<BeamProfile> profile;
  if (d.size() >= needed) {
    try {
      profile = build(shape, d, std::clamp(nu, -0.99, 0.5));
    } catch (const InvalidInput&) {
      // Lengths that make no section: told below.
    }
  }
  if (!profile || !(profile->area > 0.0) || !std::isfinite(profile->area + profile->i11 + profile->i22))
    problems.add(where, "the dimensions of the section do not form a section " + shape + " profile",
                 "it needs " + std::to_string(needed) + " numbers: lengths above 0, and walls that leave a hole",
                 "correct the data line");
  return profile && profile->area > 0.0 ? profile : std::nullopt;
}

BeamSection section_of(const BeamProfile& profile) {
  const Eigen::Vector2d centroid = profile.centroid - profile.shear_centre;
  SectionOutline outline{.corners = {}, .radius = profile.outline.radius};
  for (const auto& corner : profile.outline.corners) outline.corners.emplace_back(-corner.y(), corner.x());
  return {.area = profile.area,
          .inertia_y = profile.i22,
          .inertia_z = profile.i11,
          .torsion = profile.torsion,
          .shear_factor_y = profile.shear_2,
          .shear_factor_z = profile.shear_1,
          .product_yz = -profile.i12,
          .centroid = {-centroid.y(), centroid.x()},
          .outline = std::move(outline)};
}

}  // namespace kalfem::abaqus
