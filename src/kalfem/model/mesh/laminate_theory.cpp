// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/mesh/laminate_theory.hpp"

#include <array>
#include <cmath>
#include <string>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/units.hpp"

namespace kalfem {
namespace {

bool is_modulus_or_default(double value) { return value >= 0.0 && std::isfinite(value); }

void check(const OrthotropicSheet& sheet, const std::string& title, IssueList& issues) {
  const auto require = [&](bool holds, const std::string& what, const std::string& why) {
    if (!holds) issues.add({}, title + " has " + what, why, "correct its material");
  };
  const bool moduli = is_positive(sheet.youngs_modulus_1) && is_positive(sheet.youngs_modulus_2);
  require(moduli, "the Young's moduli " + shortest(sheet.youngs_modulus_1) + " and " + shortest(sheet.youngs_modulus_2),
          "both must be positive and finite");
  require(is_positive(sheet.shear_modulus_12), "the shear modulus " + shortest(sheet.shear_modulus_12),
          "it must be positive and finite");
  require(
      is_modulus_or_default(sheet.shear_modulus_13) && is_modulus_or_default(sheet.shear_modulus_23),
      "the transverse shear moduli " + shortest(sheet.shear_modulus_13) + " and " + shortest(sheet.shear_modulus_23),
      "both must be positive, or 0 to use the in-plane modulus");
  require(is_modulus_or_default(sheet.density), "the density " + shortest(sheet.density), "it must not be negative");
  const double squared = sheet.poissons_ratio_12 * sheet.poissons_ratio_12;
  require(!moduli || squared < sheet.youngs_modulus_1 / sheet.youngs_modulus_2,
          "Poisson's ratio " + shortest(sheet.poissons_ratio_12),
          "its square must be less than E1 / E2 for strain energy to be positive");
}

/// Plane stress in the sheet's axes.
Eigen::Matrix3d in_plane(const OrthotropicSheet& sheet) {
  const double e1 = sheet.youngs_modulus_1, e2 = sheet.youngs_modulus_2, nu = sheet.poissons_ratio_12;
  const double free = 1.0 - nu * nu * e2 / e1;
  return Eigen::Matrix3d{
      {e1 / free, nu * e2 / free, 0.0}, {nu * e2 / free, e2 / free, 0.0}, {0.0, 0.0, sheet.shear_modulus_12}};
}

/// The same in axes from which the sheet's are turned by `angle`: T^T Q T with T the strains [11 22 12] from [xx yy
/// xy].
Eigen::Matrix3d in_plane(const OrthotropicSheet& sheet, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  const Eigen::Matrix3d strains{
      {c * c, s * s, c * s}, {s * s, c * c, -c * s}, {-2.0 * c * s, 2.0 * c * s, c * c - s * s}};
  return strains.transpose() * in_plane(sheet) * strains;
}

/// Transverse shear moduli of [xz yz].
Eigen::Matrix2d transverse(const OrthotropicSheet& sheet, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  const Eigen::Matrix2d turn{{c, s}, {-s, c}};
  const auto given = [&](double modulus) { return modulus == 0.0 ? sheet.shear_modulus_12 : modulus; };
  const Eigen::Vector2d moduli(given(sheet.shear_modulus_13), given(sheet.shear_modulus_23));
  return turn.transpose() * moduli.asDiagonal() * turn;
}

/// A ply in the axes of the laminate between two heights from the centre of mass.
struct Layer {
  Eigen::Matrix3d in_plane;
  Eigen::Matrix2d transverse;
  double density, bottom, top;

  /// int z^n dz.
  [[nodiscard]] double moment(int n) const { return (std::pow(top, n + 1) - std::pow(bottom, n + 1)) / (n + 1); }
};

/// Height of the centre of mass above the underside; the middle of plies without density.
double centre_of_mass(const std::vector<Ply>& plies) {
  double height = 0.0, mass = 0.0, moment = 0.0;
  for (const auto& ply : plies) {
    mass += ply.material.density * ply.thickness;
    moment += ply.material.density * ply.thickness * (height + 0.5 * ply.thickness);
    height += ply.thickness;
  }
  return mass > 0.0 ? moment / mass : 0.5 * height;
}

std::vector<Layer> layers_of(const std::vector<Ply>& plies) {
  std::vector<Layer> layers;
  double bottom = -centre_of_mass(plies);
  for (const auto& ply : plies) {
    layers.push_back({in_plane(ply.material, ply.angle), transverse(ply.material, ply.angle), ply.material.density,
                      bottom, bottom + ply.thickness});
    bottom += ply.thickness;
  }
  return layers;
}

Eigen::Matrix2d summed_shear(const std::vector<Layer>& layers) {
  Eigen::Matrix2d shear = Eigen::Matrix2d::Zero();
  for (const auto& layer : layers) shear += 5.0 / 6.0 * layer.moment(0) * layer.transverse;
  return shear;
}

/// S^-1 = int g^T G^-1 g dz, with the stresses [xz yz] = -g q under shear forces q = [m_xx,x m_yy,y] that bend along
/// x and along y without membrane forces: with F(z) = int_bottom^z Q (b + z d) dz of the strains b m and curvatures d m
/// under moments m, g = [F_11, F_32; F_31, F_22] [Roh88].
Eigen::Matrix2d equilibrium_shear(const std::vector<Layer>& layers, const ShellStiffness& stiffness) {
  const Eigen::Matrix3d from_moments =
      (stiffness.bending - stiffness.coupling * stiffness.membrane.ldlt().solve(stiffness.coupling)).inverse();
  const Eigen::Matrix3d strains = -stiffness.membrane.ldlt().solve(stiffness.coupling * from_moments);
  // Exact to the fifth degree: the integrand is of the fourth in a layer.
  constexpr std::array<double, 3> places = {-0.7745966692414834, 0.0, 0.7745966692414834};
  constexpr std::array<double, 3> weights = {5.0 / 9.0, 8.0 / 9.0, 5.0 / 9.0};
  Eigen::Matrix3d below = Eigen::Matrix3d::Zero();  // F at the bottom of the layer
  Eigen::Matrix2d flexibility = Eigen::Matrix2d::Zero();
  for (const auto& layer : layers) {
    const auto force = [&](double z) -> Eigen::Matrix3d {
      return below + layer.in_plane *
                         ((z - layer.bottom) * strains + 0.5 * (z * z - layer.bottom * layer.bottom) * from_moments);
    };
    for (std::size_t i = 0; i < places.size(); ++i) {
      const double half = 0.5 * (layer.top - layer.bottom);
      const Eigen::Matrix3d f = force(layer.bottom + half * (1.0 + places[i]));
      const Eigen::Matrix2d stresses{{f(0, 0), f(2, 1)}, {f(2, 0), f(1, 1)}};
      flexibility += weights[i] * half * stresses.transpose() * layer.transverse.inverse() * stresses;
    }
    below = force(layer.top);
  }
  return flexibility.inverse();
}

void symmetrise(ShellStiffness& stiffness) {
  for (auto* matrix : {&stiffness.membrane, &stiffness.coupling, &stiffness.bending})
    *matrix = 0.5 * (*matrix + Eigen::Matrix3d(matrix->transpose()));
  stiffness.shear = 0.5 * (stiffness.shear + Eigen::Matrix2d(stiffness.shear.transpose()));
}

}  // namespace

OrthotropicSheet sheet_of(const IsotropicMaterial& material) {
  const double shear = material.shear_modulus();
  return {.youngs_modulus_1 = material.youngs_modulus,
          .youngs_modulus_2 = material.youngs_modulus,
          .poissons_ratio_12 = material.poissons_ratio,
          .shear_modulus_12 = shear,
          .shear_modulus_13 = shear,
          .shear_modulus_23 = shear,
          .density = material.density};
}

LaminateProperty laminated(const std::vector<Ply>& plies, double bottom, TransverseShear transverse_shear) {
  IssueList issues;
  if (plies.empty())
    issues.add({}, "the laminate has no plies", "its stiffness comes from its plies", "give it at least one");
  if (!std::isfinite(bottom)) issues.add({}, "the underside of the laminate is not at a finite height");
  for (std::size_t i = 0; i < plies.size(); ++i) {
    const std::string title = "ply " + std::to_string(i + 1) + " of a laminate";
    check(plies[i].material, title, issues);
    if (!is_positive(plies[i].thickness))
      issues.add({}, title + " has the thickness " + shortest(plies[i].thickness), "it must be positive and finite",
                 "remove or correct the ply");
    if (!std::isfinite(plies[i].angle)) issues.add({}, title + " has an angle that is not finite");
  }
  issues.raise();

  LaminateProperty property;
  property.offset = bottom + centre_of_mass(plies);
  const auto layers = layers_of(plies);
  auto& stiffness = property.stiffness;
  for (const auto& layer : layers) {
    stiffness.membrane += layer.moment(0) * layer.in_plane;
    stiffness.coupling += layer.moment(1) * layer.in_plane;
    stiffness.bending += layer.moment(2) * layer.in_plane;
    property.mass += layer.moment(0) * layer.density;
    property.rotary_inertia += layer.moment(2) * layer.density;
  }
  stiffness.shear =
      transverse_shear == TransverseShear::equilibrium ? equilibrium_shear(layers, stiffness) : summed_shear(layers);
  symmetrise(stiffness);
  return property;
}

LaminateProperty plate_section(const SeparatePlate& plate) {
  constexpr double small = 1e-6, large = 1e3;
  IssueList issues;
  if (!plate.membrane && !plate.bending)
    issues.add({}, "the plate has neither a membrane nor a bending material", "it needs one of them",
               "name a material for one of them");
  if (plate.membrane) check(*plate.membrane, "the membrane of a plate", issues);
  if (plate.bending) check(*plate.bending, "the bending of a plate", issues);
  if (plate.shear) check(*plate.shear, "the transverse shear of a plate", issues);
  for (const double positive : {plate.thickness, plate.bending_ratio, plate.shear_ratio})
    if (!is_positive(positive))
      issues.add({}, "the thickness or a ratio of a plate is " + shortest(positive), "it must be positive and finite");
  if (!is_modulus_or_default(plate.nonstructural_mass) || !std::isfinite(plate.offset) || !std::isfinite(plate.angle))
    issues.add({}, "the nonstructural mass of a plate is negative, or it, the offset or the angle is not finite");
  issues.raise();

  const double t = plate.thickness, inertia = plate.bending_ratio * t * t * t / 12.0;
  const OrthotropicSheet& membrane = plate.membrane ? *plate.membrane : *plate.bending;
  const OrthotropicSheet& bending = plate.bending ? *plate.bending : membrane;
  LaminateProperty property;
  property.stiffness.membrane = (plate.membrane ? 1.0 : small) * t * in_plane(membrane, plate.angle);
  property.stiffness.bending = (plate.bending ? 1.0 : small) * inertia * in_plane(bending, plate.angle);
  property.stiffness.shear = (plate.shear ? 1.0 : large) * plate.shear_ratio * t *
                             transverse(plate.shear ? *plate.shear : bending, plate.angle);
  symmetrise(property.stiffness);
  property.mass = membrane.density * t + plate.nonstructural_mass;
  property.rotary_inertia = property.mass * t * t / 12.0;
  property.offset = plate.offset;
  return property;
}

}  // namespace kalfem
