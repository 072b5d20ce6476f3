// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>

namespace kalfem::test {

/// Address space that each rank but the first may have [byte].
inline constexpr Eigen::Index most_memory_of_a_worker = Eigen::Index{3} << 30;

int number_of_ranks();

}  // namespace kalfem::test
