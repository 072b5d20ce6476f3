// SPDX-License-Identifier: Apache-2.0
#include "kalfem/linalg/large_pages.hpp"

#ifdef __linux__
#include <linux/mman.h>
#include <sys/mman.h>

#include <memory>
#endif

namespace kalfem {

void move_to_large_pages([[maybe_unused]] const void* data, [[maybe_unused]] std::size_t bytes) {
#ifdef MADV_COLLAPSE
  constexpr std::size_t large_page = 2 << 20;
  void* first = const_cast<void*>(data);
  if (std::align(large_page, large_page, first, bytes) == nullptr) return;
  madvise(first, bytes / large_page * large_page, MADV_COLLAPSE);  // where it cannot, the memory stays as it is
#endif
}

}  // namespace kalfem
