// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/elements/line_mass.hpp"

namespace kalfem {
namespace {

using Matrix12 = Eigen::Matrix<double, 12, 12>;
using Vector12 = Eigen::Matrix<double, 12, 1>;
using Motions = Eigen::Matrix<double, 3, 12>;

Motions motions_of(const SectionMotions& section, const Eigen::Vector2d& place) {
  Motions moved = section.topRows<3>();
  moved.row(0) -= place.transpose() * turns_of(section);
  moved.row(1) -= place.y() * section.row(3);
  moved.row(2) += place.x() * section.row(3);
  return moved;
}

SectionMotions end_section(int end) {
  SectionMotions section = SectionMotions::Zero();
  section.middleCols<6>(6 * end).setIdentity();
  return section;
}

}  // namespace

LineMass mass_of(const BeamSection& section) {
  const bool y = section.shear_factor_y != 0.0, z = section.shear_factor_z != 0.0;
  const double product = y && z ? section.product_yz : 0.0;
  return {section.area, section.centroid, section.inertia_y + section.inertia_z,
          Eigen::Matrix2d{{y ? section.inertia_z : 0.0, product}, {product, z ? section.inertia_y : 0.0}}};
}

Eigen::Matrix<double, 2, 12> turns_of(const SectionMotions& section) {
  Eigen::Matrix<double, 2, 12> turns;
  turns << section.row(5), -section.row(4);
  return turns;
}

Matrix12 mass_at_section(const LineMass& mass, const SectionMotions& section) {
  const Motions moved = motions_of(section, mass.place);
  const auto turns = turns_of(section);
  const auto twist = section.row(3);
  return mass.amount * moved.transpose() * moved + mass.polar * twist.transpose() * twist +
         turns.transpose() * mass.rotary * turns;
}

Vector12 forces_at_section(const LineMass& mass, const SectionMotions& section, double share, const LineField& field) {
  return mass.amount * motions_of(section, mass.place).transpose() * field.at(share, mass.place);
}

Matrix12 mass_at_end(const LineMass& mass, int end, double length, LumpedInertia lumped_inertia) {
  LineMass own = mass;
  if (lumped_inertia == LumpedInertia::none) own.polar = 0.0;
  if (lumped_inertia == LumpedInertia::all)
    own.rotary += 2.0 * mass.amount * length * length / 78.0 * Eigen::Matrix2d::Identity();
  else
    own.rotary.setZero();
  return mass_at_section(own, end_section(end));
}

Vector12 forces_at_end(const LineMass& mass, int end, const LineField& field) {
  return forces_at_section(mass, end_section(end), end, field);
}

}  // namespace kalfem
