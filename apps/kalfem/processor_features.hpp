// SPDX-License-Identifier: Apache-2.0
#pragma once

/// X(macro, name): the macro that a compiler defines when it may use a feature of x86 processors, and the feature's
/// name for __builtin_cpu_supports. Features that only come together with one of these are left out.
#define KALFEM_PROCESSOR_FEATURES(X)        \
  X(__SSE3__, "sse3")                       \
  X(__SSSE3__, "ssse3")                     \
  X(__SSE4_1__, "sse4.1")                   \
  X(__SSE4_2__, "sse4.2")                   \
  X(__SSE4A__, "sse4a")                     \
  X(__POPCNT__, "popcnt")                   \
  X(__AVX__, "avx")                         \
  X(__XOP__, "xop")                         \
  X(__FMA4__, "fma4")                       \
  X(__FMA__, "fma")                         \
  X(__AVX2__, "avx2")                       \
  X(__BMI__, "bmi")                         \
  X(__BMI2__, "bmi2")                       \
  X(__GFNI__, "gfni")                       \
  X(__AVX512F__, "avx512f")                 \
  X(__AVX512CD__, "avx512cd")               \
  X(__AVX512BW__, "avx512bw")               \
  X(__AVX512DQ__, "avx512dq")               \
  X(__AVX512VL__, "avx512vl")               \
  X(__AVX512IFMA__, "avx512ifma")           \
  X(__AVX512VBMI__, "avx512vbmi")           \
  X(__AVX512VBMI2__, "avx512vbmi2")         \
  X(__AVX512VNNI__, "avx512vnni")           \
  X(__AVX512BITALG__, "avx512bitalg")       \
  X(__AVX512VPOPCNTDQ__, "avx512vpopcntdq") \
  X(__AVX512BF16__, "avx512bf16")

namespace kalfem::command {

/// For each of these features whether the command was compiled to use it.
extern const bool compiled_for[];

}  // namespace kalfem::command
