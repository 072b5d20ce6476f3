#pragma once

#include <string>

#include "kalfem/formats/matrices/entries.hpp"

namespace kalfem {

/// Whether an array of two columns under this name says what the rows of the matrices beside it are.
inline bool is_map_name(const std::string& name) {
  const std::string lower = lower_case(name.substr(name.find_last_of('/') + 1));
  return lower == "cbmap" || lower == "dof_map" || lower == "dofmap" || lower == "map" || lower == "dofs" ||
         lower == "dof";
}

}  // namespace kalfem
