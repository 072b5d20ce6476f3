// SPDX-License-Identifier: Apache-2.0
// Of the program alone: what it does before any library begins, see LittleMemory.
#include <cstring>
#include <exception>

#include <unistd.h>

#include "little_memory.hpp"

#ifdef __linux__
namespace kalfem::command {
namespace {

constexpr int most_variables = 4096;

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

__attribute__((no_sanitize("address", "undefined"))) void before_every_library(int, char** arguments,
                                                                               char** variables) {
  std::set_terminate(end_without_memory);
  if (addresses_are_limited()) start_with_one_blas_thread(arguments, variables);
}

[[gnu::section(".preinit_array"), gnu::used]] void (*const first)(int, char**, char**) = before_every_library;

}  // namespace
}  // namespace kalfem::command
#endif
