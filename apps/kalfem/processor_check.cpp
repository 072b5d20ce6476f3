// SPDX-License-Identifier: Apache-2.0
// Compiled for any processor, and free of headers with inline functions: a linker may take these from a file that was
// compiled for another one.
#include <string.h>
#include <unistd.h>

#include "processor_features.hpp"

#if defined(__x86_64__)
namespace kalfem::command {
namespace {

void say(const char* text) {
  if (write(STDERR_FILENO, text, strlen(text)) < 0) _exit(1);
}

[[noreturn]] void stop_without(const char* feature) {
  say("kalfem: this program was compiled for a processor with ");
  say(feature);
  say(", which this processor does not have: compile it here, or with KALFEM_NATIVE=OFF for any processor.\n");
  _exit(1);
}

/// Runs before every other initialisation of the program, as those may already use what the processor does not have.
[[gnu::constructor(101)]] void check_processor() {
  __builtin_cpu_init();
  const bool* needed = compiled_for;
#define KALFEM_CHECK(macro, name) \
  if (*needed++ && !__builtin_cpu_supports(name)) stop_without(name);
  KALFEM_PROCESSOR_FEATURES(KALFEM_CHECK)
#undef KALFEM_CHECK
}

}  // namespace
}  // namespace kalfem::command
#endif
