// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <string>
#include <string_view>

namespace kalfem {

/// Whether the tests run as continuous integration does: CI=true in the environment. There nothing may be absent.
inline bool in_continuous_integration() {
  const char* variable = std::getenv("CI");
  return variable && std::string_view(variable) == "true";
}

}  // namespace kalfem

/// Ends a test (or its SetUp) that needs a program or data that are not here: skipped with these words, but failed in
/// continuous integration, where a skipped test would pass for one that held.
#define KALFEM_ABSENT(words)                                                                             \
  do {                                                                                                   \
    if (kalfem::in_continuous_integration())                                                             \
      GTEST_FAIL() << (words) << "; with CI=true nothing may be absent: scripts/setup --tests installs " \
                   << "programs, and data are in KALFEM_DATA or ../shared/data";                         \
    else                                                                                                 \
      GTEST_SKIP() << (words);                                                                           \
  } while (false)
