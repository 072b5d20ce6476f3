// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>

#include "kalfem/base/parallel.hpp"

namespace kalfem::command {

inline constexpr std::string_view no_memory =
    "kalfem: not enough memory: the input, or what is computed from it, is larger than the memory that is available "
    "(free memory, ulimit -v); use a smaller file or a coarser model\n";

/// Keeps the command from hanging or dying by a signal where `ulimit -v` limits its addresses. Each thread of OpenBLAS
/// asks for 128 MB, and asks again for ever where they are refused. Three things help:
/// 1. Before any library begins, the program starts itself again with one BLAS thread; it uses no more anyway.
/// 2. BLAS gets the buffer of that thread here, before data may take the room.
/// 3. With less than 1 GB for each processor, one thread computes while this object lives.
class LittleMemory {
public:
  /// Throws std::bad_alloc where not even the buffer has room.
  LittleMemory();

private:
  std::optional<OneCore> one_core_;
};

}  // namespace kalfem::command
