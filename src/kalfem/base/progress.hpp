#pragma once

#include <functional>
#include <string_view>

namespace kalfem {

/// Called by long stages with the name of the stage and the fraction done in [0, 1]. May be empty.
using Progress = std::function<void(std::string_view stage, double fraction)>;

}  // namespace kalfem
