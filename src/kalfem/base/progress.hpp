#pragma once

#include <functional>
#include <string_view>

namespace kalfem {

/// Called by long steps with the name of the step and the fraction done in [0, 1]. May be empty.
using Progress = std::function<void(std::string_view step, double fraction)>;

}  // namespace kalfem
