// SPDX-License-Identifier: Apache-2.0
#define KALFEM_KERNELS avx512
#include "kalfem/estimation/kernels/sets/set.hpp"
