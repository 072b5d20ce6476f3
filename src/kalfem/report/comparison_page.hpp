// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/report/page.hpp"
#include "kalfem/report/run_comparison.hpp"

namespace kalfem {

/// The tables of a comparison, and the course of each parameter in all runs, read from their results.h5. Throws
/// InvalidInput if one of these files cannot be read.
Page comparison_page(const RunComparison& comparison);

}  // namespace kalfem
