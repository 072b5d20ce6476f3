#include "kalfem/linalg/blas_threads.hpp"

#include <mutex>

// Declared weak, so that a BLAS library without them links as well.
extern "C" {
[[gnu::weak]] void openblas_set_num_threads(int count);
[[gnu::weak]] int openblas_get_num_threads();
}

namespace kalfem {

void keep_blas_to_one_thread() {
  static std::once_flag done;
  std::call_once(done, [] {
    if (openblas_set_num_threads != nullptr) openblas_set_num_threads(1);
  });
}

int blas_threads() { return openblas_get_num_threads != nullptr ? openblas_get_num_threads() : 0; }

}  // namespace kalfem
