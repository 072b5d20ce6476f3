// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <string>
#include <vector>

namespace kalfem {

/// A matrix as coloured squares with their numbers.
struct HeatMap {
  std::string name;        ///< in words, for those who do not see it
  Eigen::MatrixXd values;  ///< in [0, 1], or [-1, 1] with `diverging`; not a number: an empty square
  std::vector<std::string> rows, columns;
  std::string row_title = {}, column_title = {};
  bool diverging = false;  ///< colours on both sides of 0
};

/// One self-contained SVG element. Numbers are left out where the squares are too small for them.
std::string heat_map_svg(const HeatMap& map);

}  // namespace kalfem
