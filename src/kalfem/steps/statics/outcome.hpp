// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "kalfem/model/statics/solved_load_cases.hpp"

namespace kalfem {

/// Static analysis of a substructure.
struct StaticsOutcome : SolvedLoadCases {
  std::string substructure;
  double seconds = 0.0;
};

}  // namespace kalfem
