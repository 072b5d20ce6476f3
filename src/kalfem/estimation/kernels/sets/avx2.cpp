// SPDX-License-Identifier: Apache-2.0
#define KALFEM_KERNELS avx2
#include "kalfem/estimation/kernels/sets/set.hpp"
