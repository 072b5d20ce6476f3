#include "kalfem/linalg/large_pages.hpp"

#ifdef __linux__
#include <linux/mman.h>
#include <sys/mman.h>

#include <cstdint>
#endif

namespace kalfem {

void move_to_large_pages([[maybe_unused]] const void* data, [[maybe_unused]] std::size_t bytes) {
#ifdef MADV_COLLAPSE
  constexpr std::uintptr_t large_page = 2 << 20;
  const auto begin = reinterpret_cast<std::uintptr_t>(data);
  const auto first = (begin + large_page - 1) / large_page * large_page,
             last = (begin + bytes) / large_page * large_page;
  // A wish: an error means that the memory stays as it is.
  if (first < last) madvise(reinterpret_cast<void*>(first), last - first, MADV_COLLAPSE);
#endif
}

}  // namespace kalfem
