// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/api/update.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

/// The case's `update`, whose comparisons are of natural frequencies, as options of update().
UpdateOptions update_options_of(const Study& study);

}  // namespace kalfem
