// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace kalfem::benchmarks {

/// A free barrel of steel shells as a Nastran deck, 0.9 m long, radius 0.24 m at the ends and 0.3 m in the middle, 1.5
/// mm thick: `around` x `rings` nodes with six degrees of freedom each.
std::string barrel_deck(int around, int rings);

}  // namespace kalfem::benchmarks
