// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/kernels/kernel_set.hpp"

#include <Eigen/Core>
#include <array>

#include "kalfem/base/vector_loops.hpp"

namespace kalfem {

namespace baseline {
extern const KernelSet set;
}
#if defined(KALFEM_WIDE_KERNELS)
namespace avx2 {
extern const KernelSet set;
}
namespace avx512 {
extern const KernelSet set;
}
#endif

const KernelSet& kernels() {
#if defined(KALFEM_WIDE_KERNELS)
  static constexpr std::array sets = {&baseline::set, &avx2::set, &avx512::set};  // in the order of VectorWidth
  static const KernelSet& set = *sets[static_cast<std::size_t>(vector_width())];
#else
  static const KernelSet& set = baseline::set;
#endif
  return set;
}

double* kernel_storage(int which, std::ptrdiff_t size) {
  thread_local std::array<Eigen::VectorXd, 2> kept;
  auto& storage = kept[static_cast<std::size_t>(which)];
  if (storage.size() < size) storage.resize(size);
  return storage.data();
}

}  // namespace kalfem
