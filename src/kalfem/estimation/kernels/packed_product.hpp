// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/estimation/kernels/register_tile.hpp"

namespace kalfem::tiles {

/// C = A B, C += A B or C -= A B for factors beyond the nearest cache: blocks of both are first copied in the order in
/// which the tiles read them [Goto and van de Geijn 2008, ACM Trans. Math. Softw. 34(3), 12]. A is rows x depth, B is
/// depth x columns. With Shape::lower_result entries above the diagonal are left without meaning. The copies lie in
/// storage of the calling thread that stays, so that only a growing size allocates.
template <class Right>
void packed_product(Keep keep, Shape shape, Eigen::Index rows, Eigen::Index columns, Eigen::Index depth,
                    const double* a, Eigen::Index a_stride, Right b, double* c, Eigen::Index c_stride);

extern template void packed_product(Keep, Shape, Eigen::Index, Eigen::Index, Eigen::Index, const double*, Eigen::Index,
                                    Plain, double*, Eigen::Index);
extern template void packed_product(Keep, Shape, Eigen::Index, Eigen::Index, Eigen::Index, const double*, Eigen::Index,
                                    Transposed, double*, Eigen::Index);

}  // namespace kalfem::tiles
