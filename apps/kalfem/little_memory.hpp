// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>

#include "kalfem/base/parallel.hpp"

namespace kalfem::command {

inline constexpr std::string_view no_memory =
    "kalfem: not enough memory: the input, or what is computed from it, is larger than the memory that is available "
    "(free memory, ulimit -v); use a smaller file or a coarser model\n";

/// What the command does where `ulimit -v` limits its addresses, so that it ends with a sentence and never with a
/// signal or a hang: OpenBLAS's threads each ask for 128 MB for ever. Before any library begins, the program starts
/// itself again with one BLAS thread (more it does not use anyway); here BLAS gets its one buffer before the data may
/// take the room, and with less than 1 GB for each processor one thread computes.
class LittleMemory {
public:
  /// Throws std::bad_alloc where not even the buffer has room.
  LittleMemory();

private:
  std::optional<OneCore> one_core_;
};

}  // namespace kalfem::command
