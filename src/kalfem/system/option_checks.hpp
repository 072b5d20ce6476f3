// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {

/// A finite number as the user would write it: "0.25", "nan", "-inf".
std::string to_string(double value);

/// Each adds one issue naming the option and its value when the requirement is broken; NaN breaks every one of them.
void require_finite(IssueList& issues, const std::string& option, double value);
void require_positive(IssueList& issues, const std::string& option, double value);
void require_nonnegative(IssueList& issues, const std::string& option, double value);
/// 0 < low < high, both finite: a band.
void require_band(IssueList& issues, const std::string& option, double low, double high);

}  // namespace kalfem
