// SPDX-License-Identifier: Apache-2.0
#pragma once

/// KALFEM_INDEPENDENT before a loop: no iteration writes what another one reads or writes, so the compiler may run them
/// side by side.
#if defined(__clang__)
#define KALFEM_INDEPENDENT _Pragma("clang loop vectorize(assume_safety)")
#elif defined(__GNUC__)
#define KALFEM_INDEPENDENT _Pragma("GCC ivdep")
#else
#define KALFEM_INDEPENDENT
#endif
