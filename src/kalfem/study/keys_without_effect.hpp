#pragma once

#include <string>
#include <vector>

#include "kalfem/casefile/description.hpp"

namespace kalfem {

/// Keys that the case gives and that nothing reads, one sentence each: options of another integrator, filter or search,
/// of finite elements where there are none, of connectors that a local augmented model leaves out.
std::vector<std::string> keys_without_effect(const description::Case& given);

}  // namespace kalfem
