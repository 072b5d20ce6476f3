// SPDX-License-Identifier: Apache-2.0
// Compiled with the flags of the command, it holds data and no instruction: it can be read on any processor.
#include "processor_features.hpp"

// The name of a macro that is not defined stays as it is; one that is becomes 1.
#define KALFEM_TEXT(expanded) #expanded
#define KALFEM_IS_ONE(macro, name) KALFEM_TEXT(macro)[0] == '1',

namespace kalfem::command {

constinit const bool compiled_for[] = {KALFEM_PROCESSOR_FEATURES(KALFEM_IS_ONE)};

}  // namespace kalfem::command
