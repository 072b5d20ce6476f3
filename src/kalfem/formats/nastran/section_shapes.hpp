#pragma once

#include <string>
#include <vector>

#include "kalfem/formats/nastran/bulk_data.hpp"

namespace kalfem::nastran {

/// Number of dimensions of a section shape of PBARL and PBEAML, 0 of an unknown one.
std::size_t dimension_count(const std::string& shape);

/// Cross-section of the shapes ROD, TUBE, TUBE2, BAR, BOX, BOX1, I, I1, H, T, T1, T2, CHAN, CHAN1, CHAN2, CROSS, L, Z
/// and HAT, with the plane 1 (y) upright in the manual's figures and z to the left in them.
///
/// Area and moments of inertia are those of the rectangles that make up the section. Torsion: exact for circles and
/// rectangles [TG70], Bredt's formula for boxes, sum of l t^3 / 3 for open walls. Shear centre of open walls by
/// sectorial areas [Vla61]: with omega from the centroid, I_wy - a_y I_yz + a_z I_yy = 0 and
/// I_wz - a_y I_zz + a_z I_yz = 0. Shear factors: [Cow66] for circles, tubes and boxes, 5/6 for rectangles; of open
/// walls the share of the walls along the force, of those along z times 5/6.
/// Throws CardError for an unknown shape and for lengths that do not fit together.
SectionCard section_of_shape(const std::string& shape, const std::vector<double>& dimensions, const std::string& title);

}  // namespace kalfem::nastran
