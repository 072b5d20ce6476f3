// SPDX-License-Identifier: Apache-2.0
#include "kalfem/base/freed_memory.hpp"

#include <cstdlib>  // and with it __GLIBC__

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace kalfem {

void keep_freed_memory() {
#ifdef __GLIBC__
  constexpr int most = 384 << 20;
  if (mallopt(M_MMAP_THRESHOLD, most) != 0) mallopt(M_TRIM_THRESHOLD, most);  // glibc before 2.35 refuses the first
#endif
}

}  // namespace kalfem
