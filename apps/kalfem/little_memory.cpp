// SPDX-License-Identifier: Apache-2.0
#include "little_memory.hpp"

#include <algorithm>
#include <cstdlib>
#include <cstring>
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
constexpr int most_variables = 4096;

rlim_t limit_of_addresses() {
  rlimit limit{};
  return getrlimit(RLIMIT_AS, &limit) == 0 ? limit.rlim_cur : RLIM_INFINITY;
}

/// Memory may also end where nothing can be thrown on: in a destructor, in a thread or before main() in a library.
[[noreturn]] void end_without_memory() {
  try {
    if (const auto thrown = std::current_exception()) std::rethrow_exception(thrown);
  } catch (const std::bad_alloc&) {
    if (write(STDERR_FILENO, no_memory.data(), no_memory.size()) >= 0) _exit(mend_the_input);
  } catch (...) {
    std::abort();
  }
  std::abort();
}

/// The same program in this process, with one BLAS thread; returns where it already runs so.
__attribute__((no_sanitize("address", "undefined"))) void start_with_one_blas_thread(char** arguments,
                                                                                     char** variables) {
  static char one_thread[] = "OPENBLAS_NUM_THREADS=1";
  static char* changed[most_variables];
  constexpr std::size_t name = sizeof one_thread - 2;  // with '='
  int count = 0;
  changed[count++] = one_thread;
  for (char** variable = variables; *variable != nullptr; ++variable) {
    if (std::strcmp(*variable, one_thread) == 0 || count + 1 == most_variables) return;
    if (std::strncmp(*variable, one_thread, name) != 0) changed[count++] = *variable;
  }
  static char program[4096];  // by its path, so that ps shows its name
  const ssize_t length = readlink("/proc/self/exe", program, sizeof program - 1);
  if (length > 0) execve(program, arguments, changed);
}

#ifdef __linux__
__attribute__((no_sanitize("address", "undefined"))) void before_every_library(int, char** arguments,
                                                                               char** variables) {
  std::set_terminate(end_without_memory);
  if (limit_of_addresses() != RLIM_INFINITY) start_with_one_blas_thread(arguments, variables);
}

[[gnu::section(".preinit_array"), gnu::used]] void (*const first)(int, char**, char**) = before_every_library;
#endif

}  // namespace

LittleMemory::LittleMemory() {
  std::set_terminate(end_without_memory);
  const rlim_t limit = limit_of_addresses();
  if (limit == RLIM_INFINITY) return;
  take_blas_buffer();
  if (limit / room_of_a_processor < std::max(1U, std::thread::hardware_concurrency())) one_core_.emplace();
}

}  // namespace kalfem::command
