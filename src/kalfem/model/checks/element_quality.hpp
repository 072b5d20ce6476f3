#pragma once

#include <array>
#include <map>
#include <string>
#include <vector>

#include "kalfem/model/mesh/mesh.hpp"

namespace kalfem {

/// Measures of the shape of a cell, by its corners; of quadratic cells too.
enum class QualityMeasure {
  aspect_ratio,    ///< longest side / shortest side; 1e9 where two nodes stand at one place
  smallest_angle,  ///< between two sides of a face [deg]
  largest_angle,   ///< the same [deg]
  warp,   ///< quadrilaterals and such faces: between the two triangles beside a diagonal, the larger of two [deg]
  taper,  ///< the same: smallest of the corners' triangles / mean of the four; 1 for a parallelogram
  scaled_jacobian,  ///< least over the corners of the edges' determinant / product of their lengths, so scaled that
                    ///< equilateral triangles and tetrahedra, and rectangles, have 1 [Knu03]; <= 0: not convex or
                    ///< turned inside out
};
inline constexpr int quality_measures = 6;
std::string to_string(QualityMeasure measure);

/// Values of all measures, in their order.
using CellQuality = std::array<double, quality_measures>;

/// Shape of a triangle, quadrilateral, tetrahedron, wedge or hexahedron. Sides and corners that collapse because the
/// cell names a node twice are left out. Finite for finite coordinates.
CellQuality cell_quality(const Mesh& mesh, const Cell& cell);

/// Limits beyond which a cell counts as badly shaped, in the order of the measures; usual ones of meshing practice.
struct QualityLimits {
  CellQuality limits = {20.0, 15.0, 165.0, 15.0, 0.3, 0.2};
};

/// Whether larger values of a measure are worse.
bool is_worse_when_larger(QualityMeasure measure);

/// One measure over the cells of a region.
struct QualityOfRegion {
  QualityMeasure measure = QualityMeasure::aspect_ratio;
  double worst = 0.0;
  double mean = 0.0;
  Eigen::Index beyond = 0;                ///< cells beyond the limit
  std::vector<Eigen::Index> worst_cells;  ///< indices of up to 5 cells beyond the limit, the worst first
};

/// Shapes of a region's surfaces and solids.
struct RegionQuality {
  std::string region;
  std::map<CellShape, Eigen::Index> cells;  ///< how many of each shape, lines and points too
  Eigen::Index measured = 0;                ///< surfaces and solids
  std::array<QualityOfRegion, quality_measures> measures;
};

RegionQuality region_quality(const Mesh& mesh, const std::string& region, const QualityLimits& limits = {});

}  // namespace kalfem
