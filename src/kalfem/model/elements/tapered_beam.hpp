// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "kalfem/model/elements/line_mass.hpp"

namespace kalfem {

/// Section at a share of the line from its first end, linear between the stations of a tapered beam; the one section of
/// any other. Its outline is known where those of the stations beside it have the same corners.
BeamSection section_at(const BeamProperty& property, double place);
/// The same for all that a station holds.
BeamStation station_at(const std::vector<BeamStation>& stations, double place);
/// Mean of the stations over the length, as a section with its nonstructural mass.
BeamStation mean_station(const std::vector<BeamStation>& stations);

/// A straight beam of length L whose section is linear between its stations, in local axes and in the motions
/// [u v w theta_x theta_y theta_z] of the ends of its line, the line of shear centres.
///
/// Exact for end loads by integrated flexibility: with the section's forces s(x) = H(L - x) p of the loads p at the
/// second end and its compliance c(x) (axial force and bending about the centroid, shear areas k A, St Venant torsion),
///     F = int H^T c H dx,   K = T^T F^-1 T,   T = [-H(L)^T, I],
/// where H(d) carries a force over the distance d, M_y - d V_z and M_z + d V_y. Motions without load between the ends
/// are q(x) = H(x)^T q_A + G(x) F^-1 T [q_A; q_B] with G(x) = int_0^x H(x - xi)^T c H(L - xi) dxi. The integrals are
/// Gauss's over parts in which no property more than doubles. With equal stations it is beam(). The lumped mass of
/// either kind stands at the ends by the shares 1 - x / L and x / L, rotations as in beam().
class TaperedLine {
public:
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  using Matrix12 = Eigen::Matrix<double, 12, 12>;
  using Vector12 = Eigen::Matrix<double, 12, 1>;
  using Slopes = Eigen::Matrix<double, 2, 12>;

  TaperedLine(const std::vector<BeamStation>& stations, double length, double poissons_ratio,
              LumpedInertia lumped_inertia = LumpedInertia::all);

  [[nodiscard]] const Matrix12& stiffness() const { return stiffness_; }  ///< per unit E
  [[nodiscard]] Matrix12 section_mass(MassKind kind) const;               ///< per unit density
  [[nodiscard]] Matrix12 nonstructural_mass(MassKind kind) const;
  /// int N^T m a ds of a field in the axes of the line, per unit density and of the nonstructural mass.
  [[nodiscard]] Vector12 section_forces(MassKind kind, const LineField& field) const;
  [[nodiscard]] Vector12 nonstructural_forces(MassKind kind, const LineField& field) const;
  /// Of a unit of axial force: int (v'^2 + w'^2) dx / 2.
  [[nodiscard]] Matrix12 geometric_stiffness() const;

private:
  struct Point {
    BeamStation station;
    double weight;           ///< of the integral over the length [m]
    SectionMotions motions;  ///< of the section, from those of the ends
    Slopes slopes;           ///< v' and w'
  };
  /// A part of the line in which no property more than doubles, from and to shares of the length.
  struct Part {
    double from, to;
  };
  using MassAt = LineMass (*)(const BeamStation&);

  [[nodiscard]] Matrix6 compliance(const BeamSection& section) const;
  [[nodiscard]] Matrix6 flexibility(double from, double to, double up_to) const;
  void add_points(const Part& part, const Matrix6& before, const SectionMotions& loads);
  [[nodiscard]] Matrix12 mass(MassAt mass_at, MassKind kind) const;
  [[nodiscard]] Vector12 forces(MassAt mass_at, MassKind kind, const LineField& field) const;
  /// What an end carries of a lumped mass, at its centre.
  [[nodiscard]] LineMass mass_of_end(MassAt mass_at, int end) const;

  const std::vector<BeamStation>& stations_;
  double length_, poissons_ratio_;
  LumpedInertia lumped_inertia_;
  Matrix12 stiffness_;
  std::vector<Point> points_;
};

}  // namespace kalfem
