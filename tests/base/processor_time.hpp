// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <ctime>

namespace kalfem {

/// Processor time of this process so far [s]. Tests that catch an algorithm of the wrong order use it with wide limits:
/// waiting for other processes does not count, so that a loaded machine fails none.
inline double processor_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

}  // namespace kalfem
