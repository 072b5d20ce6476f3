// SPDX-License-Identifier: Apache-2.0
#include "little_memory.hpp"

#include <algorithm>
#include <cstdlib>
#include <exception>
#include <new>
#include <thread>

#include <sys/resource.h>
#include <unistd.h>

#include "kalfem/linalg/blas.hpp"
#include "verbs.hpp"

namespace kalfem::command {
namespace {

constexpr rlim_t room_of_a_processor = 1 << 30;  // [bytes]: the buffer of its BLAS, twice, and what it works on

rlim_t limit_of_addresses() {
  rlimit limit{};
  return getrlimit(RLIMIT_AS, &limit) == 0 ? limit.rlim_cur : RLIM_INFINITY;
}

}  // namespace

bool addresses_are_limited() { return limit_of_addresses() != RLIM_INFINITY; }

void end_without_memory() {
  try {
    if (const auto thrown = std::current_exception()) std::rethrow_exception(thrown);
  } catch (const std::bad_alloc&) {
    if (write(STDERR_FILENO, no_memory.data(), no_memory.size()) >= 0) _exit(mend_the_input);
  } catch (...) {
    std::abort();
  }
  std::abort();
}

LittleMemory::LittleMemory() {
  std::set_terminate(end_without_memory);
  if (!addresses_are_limited()) return;
  take_blas_buffer();
  if (limit_of_addresses() / room_of_a_processor < std::max(1U, std::thread::hardware_concurrency()))
    one_core_.emplace();
}

}  // namespace kalfem::command
