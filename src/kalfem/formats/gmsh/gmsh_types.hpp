#pragma once

#include <array>
#include <optional>
#include <string>

#include "kalfem/model/mesh/mesh.hpp"

namespace kalfem {

/// A type of element of the MSH format.
struct GmshType {
  int number = 0;
  int dimension = 0;
  int nodes = 0;
  std::string name;
  std::optional<CellShape> shape = {};  ///< nothing where the program has no such cell
  std::array<int, 20> order = {};  ///< where each of the shape's nodes stands in the file; all 0: in the same order
};

/// The type of this number, nullptr where the format has none.
const GmshType* find_gmsh_type(std::int64_t number);

}  // namespace kalfem
