// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace kalfem {

/// Text as it is read on a page: powers of units raised, "m/s²" for "m/s^2"; numbers with a power of ten written out
/// between 1e-4 and 1e7, "8890" for "8.89e+03", and beyond with a raised power, "5.1×10⁻⁶"; "±" for "+-". What stands
/// between backticks stays, since it is to be typed.
std::string typeset(std::string_view text);

}  // namespace kalfem
