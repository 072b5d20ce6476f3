// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/estimation/kernels/sets/cholesky.hpp"
#include "kalfem/estimation/kernels/sets/thin_product.hpp"
#include "kalfem/estimation/kernels/sets/tile_pass.hpp"

// The set of kernels of the width that this file's source is compiled for. A source defines KALFEM_KERNELS, the set's
// name and namespace, and includes nothing else.

namespace kalfem::KALFEM_KERNELS {

inline void matrix_product(Keep keep, Shape shape, Index rows, Index columns, Index depth, KernelMatrix a,
                           KernelMatrix b, double* c, Index c_stride) {
  if (b.transposed)
    product(keep, shape, rows, columns, depth, a.data, a.stride, Transposed{b.data, b.stride}, c, c_stride);
  else
    product(keep, shape, rows, columns, depth, a.data, a.stride, Plain{b.data, b.stride}, c, c_stride);
}

#define KALFEM_NAME_OF(set) #set
#define KALFEM_NAME(set) KALFEM_NAME_OF(set)
extern const KernelSet set;
constinit const KernelSet set = {
    .name = KALFEM_NAME(KALFEM_KERNELS),
    .product = matrix_product,
    .cholesky = cholesky,
    .thin_add = thin_add,
    .thin_inner = thin_inner,
    .propagate = propagate,
    .pass_over = pass_over,
};
#undef KALFEM_NAME
#undef KALFEM_NAME_OF

}  // namespace kalfem::KALFEM_KERNELS
