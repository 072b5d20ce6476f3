// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "verbs.hpp"

namespace kalfem::command {

/// kalfem --help: the verbs in groups, in the order in which they are used, each with an example.
std::string overview(const std::vector<VerbUsage>& verbs);
/// kalfem VERB --help.
std::string help_of(const VerbUsage& verb);

}  // namespace kalfem::command
