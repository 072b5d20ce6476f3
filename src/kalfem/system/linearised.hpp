// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/system/coupling.hpp"

namespace kalfem {

/// The whole structure as one linear model about rest,
///     K + sum_j k_j b_j b_j^T,   C + sum_j c_j b_j b_j^T,   M + sum_j m_j b_j b_j^T,
/// with the tangents k_j = df/dd, c_j = df/dd', m_j = df/dd'' of connector j where nothing moves. Its degrees of
/// freedom, points and strain gauges have qualified names; its grounds are the moved grounds, by the names of their
/// inputs. Throws InvalidInput with every connector whose tangents at rest are not finite.
LinearModel linearised_at_rest(const CoupledModel& coupled);

}  // namespace kalfem
