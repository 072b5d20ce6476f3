// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/unit_system.hpp"

#include <cmath>

namespace kalfem {
namespace {

// Every field is multiplied by its unit in SI, which follows from length, mass and time alone. Rotations have no unit,
// so moments per angle are force times length, and lever arms in a deformation are lengths.
/// Units of derived quantities in SI.
struct Derived {
  double length, mass, force, pressure, density, area, inertia;

  explicit Derived(const UnitSystem& units)
      : length(units.length),
        mass(units.mass),
        force(mass * length / (units.time * units.time)),
        pressure(force / (length * length)),
        density(mass / (length * length * length)),
        area(length * length),
        inertia(area * area) {}
};

struct PropertyConverter {
  const Derived& unit;

  void operator()(ShellProperty& shell) const {
    shell.thickness *= unit.length;
    shell.offset *= unit.length;
    shell.nonstructural_mass *= unit.mass / unit.area;
  }
  void operator()(LaminateProperty& laminate) const {
    laminate.stiffness.membrane *= unit.force / unit.length;
    laminate.stiffness.coupling *= unit.force;
    laminate.stiffness.bending *= unit.force * unit.length;
    laminate.stiffness.shear *= unit.force / unit.length;
    laminate.mass *= unit.mass / unit.area;
    laminate.rotary_inertia *= unit.mass;
    laminate.offset *= unit.length;
  }
  void operator()(BeamSection& section) const {
    section.area *= unit.area;
    for (double* inertia : {&section.inertia_y, &section.inertia_z, &section.torsion, &section.product_yz})
      *inertia *= unit.inertia;
    section.centroid *= unit.length;
    for (auto& corner : section.outline.corners) corner *= unit.length;
    section.outline.radius *= unit.length;
  }
  void operator()(BeamProperty& beam) const {
    (*this)(beam.section);
    for (auto& station : beam.stations) {
      (*this)(station.section);
      station.nonstructural_mass *= unit.mass / unit.length;
      station.nonstructural_inertia *= unit.mass * unit.length;
      station.nonstructural_centre *= unit.length;
    }
    for (auto& placement : beam.placements) placement.offsets *= unit.length;
    beam.nonstructural_mass *= unit.mass / unit.length;
    beam.nonstructural_centre *= unit.length;
  }
  void operator()(SolidProperty& solid) const {
    if (solid.elasticity) *solid.elasticity *= unit.pressure;
  }
};

/// Stiffness or damping of a spring: force per translation, moment per rotation.
double spring_unit(int direction, const Derived& unit) {
  return direction < 3 ? unit.force / unit.length : unit.force * unit.length;
}

/// A deformation that rotations enter by lever arms is a length, one of rotations alone an angle.
void convert(JointSpring& joint, const Derived& unit, double time) {
  bool is_length = false;
  for (const auto& [dof, coefficient] : joint.deformation) is_length = is_length || dof.direction < 3;
  if (is_length)
    for (auto& [dof, coefficient] : joint.deformation)
      if (dof.direction >= 3) coefficient *= unit.length;
  joint.stiffness *= spring_unit(is_length ? 0 : 3, unit);
  joint.damping *= spring_unit(is_length ? 0 : 3, unit) * time;
}

void convert(NodalMatrices& item, const UnitSystem& units) {
  std::vector<int> directions;
  for (const auto& dof : item.dofs) directions.push_back(dof.direction);
  const Eigen::VectorXd factors = unit_factors(directions, units);
  const auto scale = [&](Eigen::SparseMatrix<double>& matrix, double unit) {
    if (matrix.size() > 0) matrix = scaled(matrix, unit, factors);
  };
  scale(item.stiffness, units.mass / (units.time * units.time));
  scale(item.damping, units.mass / units.time);
  scale(item.mass, units.mass);
}

/// Rotations in a constraint that holds translations too have lever arms as coefficients.
void convert(MultiPointConstraint& constraint, const Derived& unit) {
  for (auto& [dof, coefficient] : constraint.terms)
    if (dof.direction >= 3) coefficient *= unit.length;
}

}  // namespace

void to_si(FiniteElementModel& model, const UnitSystem& units) {
  const Derived unit(units);
  model.mesh.nodes *= unit.length;
  for (auto& [name, material] : model.materials) {
    material.youngs_modulus *= unit.pressure;
    material.density *= unit.density;
  }
  for (auto& [region, property] : model.properties) std::visit(PropertyConverter{unit}, property);
  for (auto& mass : model.masses) {
    mass.mass *= unit.mass;
    mass.inertia *= unit.mass * unit.area;
    mass.offset *= unit.length;
  }
  for (auto& spring : model.springs) {
    spring.stiffness *= spring_unit(spring.from.direction, unit);
    spring.damping *= spring_unit(spring.from.direction, unit) * units.time;
  }
  for (auto& joint : model.joints) convert(joint, unit, units.time);
  for (auto& item : model.matrices) convert(item, units);
  for (auto& constraint : model.constraints) convert(constraint, unit);
}

void to_si(LoadCase& load_case, const UnitSystem& units) {
  const Derived unit(units);
  for (auto& load : load_case.loads) {
    load.force *= unit.force;
    load.moment *= unit.force * unit.length;
  }
  for (auto& beam : load_case.beam_loads)
    for (const Eigen::Index end : {0, 6}) {
      beam.forces.segment<3>(end) *= unit.force;
      beam.forces.segment<3>(end + 3) *= unit.force * unit.length;
    }
  for (auto& pressure : load_case.pressures) pressure.pressure *= unit.pressure;
  if (auto& rotation = load_case.rotation) {
    rotation->about *= unit.length;
    rotation->speed /= units.time;
  }
  load_case.gravity *= unit.length / (units.time * units.time);
  for (auto& motion : load_case.imposed)
    if (motion.dof.direction < 3) motion.value *= unit.length;
  for (auto& carried : load_case.preload) to_si(carried, units);
}

Eigen::VectorXd unit_factors(const std::vector<int>& directions, const UnitSystem& units) {
  Eigen::VectorXd factors(static_cast<Eigen::Index>(directions.size()));
  for (Eigen::Index i = 0; i < factors.size(); ++i) {
    const int direction = directions[static_cast<std::size_t>(i)];
    factors[i] = direction < 0 ? 1.0 / std::sqrt(units.mass) : direction < 3 ? 1.0 : units.length;
  }
  return factors;
}

Eigen::SparseMatrix<double> scaled(const Eigen::SparseMatrix<double>& matrix, double unit,
                                   const Eigen::VectorXd& factors) {
  const Eigen::SparseMatrix<double> left = (unit * factors).asDiagonal() * matrix;
  return left * factors.asDiagonal();
}

}  // namespace kalfem
