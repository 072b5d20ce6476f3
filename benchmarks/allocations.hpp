// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace kalfem::benchmarks {

/// Calls of malloc and its relatives by this program so far, those inside libraries included.
long allocations();

}  // namespace kalfem::benchmarks
