#pragma once

#include <optional>

#include "kalfem/formats/abaqus/placed_deck.hpp"

namespace kalfem::abaqus {

/// A beam's cross-section in the deck's axes 1 and 2, measured from the section's origin.
struct BeamProfile {
  double area = 0.0;
  double i11 = 0.0, i12 = 0.0, i22 = 0.0;  ///< about the centroid: int x2^2 dA, int x1 x2 dA, int x1^2 dA
  double torsion = 0.0;
  double shear_1 = 0.0, shear_2 = 0.0;  ///< shear area / A for forces along 1 and 2; 0: shear rigid
  Eigen::Vector2d centroid = Eigen::Vector2d::Zero();
  Eigen::Vector2d shear_centre = Eigen::Vector2d::Zero();
};

/// The profile of SECTION=shape from the numbers of its data line: RECT, CIRC, PIPE, BOX, I, L, GENERAL. Shear factors
/// of massive and closed sections are Cowper's [Cow66], of open ones the area of the walls along the force (5/6 of it
/// in flanges) over the whole; torsion of open sections is sum b t^3 / 3. Nothing and a problem where the shape is
/// another one or the numbers make none.
std::optional<BeamProfile> beam_profile(const std::string& shape, const std::vector<double>& data,
                                        double poissons_ratio, const Where& where, Problems& problems);

/// As a section with local y against axis 2 and local z along axis 1, so that `up` of a placement is axis 1.
BeamSection section_of(const BeamProfile& profile);

}  // namespace kalfem::abaqus
