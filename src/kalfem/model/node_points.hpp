// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <string>

namespace kalfem {

/// Whether a point of a finite-element substructure is a motion of a node by its number, "n12.z". Such points serve as
/// places of sensors; reports show named nodes only.
inline bool is_numbered_node(const std::string& point) {
  const auto dot = point.find('.');
  if (dot == std::string::npos || dot < 2 || point.front() != 'n') return false;
  return std::all_of(point.begin() + 1, point.begin() + static_cast<std::ptrdiff_t>(dot),
                     [](char c) { return c >= '0' && c <= '9'; });
}

}  // namespace kalfem
