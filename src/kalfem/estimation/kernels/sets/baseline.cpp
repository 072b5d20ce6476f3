// SPDX-License-Identifier: Apache-2.0
#define KALFEM_KERNELS baseline
#include "kalfem/estimation/kernels/sets/set.hpp"
