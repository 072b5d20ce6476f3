#pragma once

#include <array>
#include <span>
#include <vector>

#include "kalfem/model/mesh/mesh.hpp"

namespace kalfem {

/// Corners of a face or a surface, by their places in the cell, in order around it.
struct CornerRing {
  std::array<int, 4> corners = {};
  int count = 0;
  [[nodiscard]] std::span<const int> places() const { return {corners.data(), static_cast<std::size_t>(count)}; }
};

/// Faces of a cell by its corners: of a solid all, counter-clockwise seen from outside; of a surface itself; none of
/// lines and points.
std::span<const CornerRing> corner_rings(CellShape shape);

/// Sides between corners, each once.
std::span<const std::array<int, 2>> corner_sides(CellShape shape);

/// The three corners that sides of a solid lead to from each corner, so ordered that their edges have a positive triple
/// product in a cell that is not turned inside out. None of other cells.
std::span<const std::array<int, 3>> corner_neighbours(CellShape shape);

/// Places of the corners, 3 x corners.
Eigen::Matrix3Xd corner_places(const Mesh& mesh, const Cell& cell);

/// Length, area or volume of a cell by its corners; 0 of a point. The volume of a cell that is turned inside out is
/// negative.
double cell_measure(const Mesh& mesh, const Cell& cell);

}  // namespace kalfem
