// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>

#include "kalfem/base/parallel.hpp"

namespace kalfem::command {

inline constexpr std::string_view no_memory =
    "kalfem: not enough memory: the input, or what is computed from it, is larger than the memory that is available "
    "(free memory, ulimit -v); use a smaller file or a coarser model\n";

bool addresses_are_limited();  ///< by ulimit -v

/// What std::terminate does: memory may also end where nothing can be thrown on, in a destructor, in a thread or before
/// main() in a library. Prints no_memory and exits where that is why, and aborts otherwise.
[[noreturn]] void end_without_memory();

/// Keeps the command from hanging or dying by a signal where `ulimit -v` limits its addresses. Each thread of OpenBLAS
/// asks for 128 MB, and asks again for ever where they are refused. Three things help:
/// 1. Before any library begins, the program starts itself again with one BLAS thread (one_blas_thread.cpp); it uses no
///    more anyway. In the Python package, kalfem/command.py asks for one before it loads the libraries.
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
