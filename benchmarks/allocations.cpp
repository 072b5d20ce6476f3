// SPDX-License-Identifier: Apache-2.0
#include "allocations.hpp"

#include <cstddef>

// The C library lets a program put its own allocation functions in place of the library's; these count and pass on.
// operator new and Eigen's aligned storage end here too.
namespace {
long count = 0;  // the program has one thread
}

extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t number, std::size_t size);
void* __libc_realloc(void* memory, std::size_t size);

void* malloc(std::size_t size) { return ++count, __libc_malloc(size); }
void* calloc(std::size_t number, std::size_t size) { return ++count, __libc_calloc(number, size); }
void* realloc(void* memory, std::size_t size) { return ++count, __libc_realloc(memory, size); }
}

namespace kalfem::benchmarks {

long allocations() { return count; }

}  // namespace kalfem::benchmarks
