// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {

/// How well numbers are known that an analysis holds fixed: their standard deviation, of one or of a group each.
struct KnownTo {
  /// A number ("frame.3.mass", "a1.gain"), all of an owner or of its part ("frame.3"), or a group: "masses",
  /// "stiffnesses", "damping", "positions", "laws", "gains", "excitations", "delays", "drifts". The longest name that
  /// fits a number counts, a group last.
  std::string name;
  double deviation = 0.0;        ///< relative, or in the number's unit
  bool relative = true;          ///< of the number's own size; delays and drifts are never relative
  SourceLocation location = {};  ///< where it is stated, for messages
};

/// What an estimation does about fixed numbers that its record asks to change: nothing, propose them as unknowns, or
/// take those as unknowns that predict better with.
enum class FreeNumbers { none, ask, automatic };

/// "none", "ask", "auto".
inline const char* to_string(FreeNumbers free) {
  return free == FreeNumbers::none ? "none" : free == FreeNumbers::ask ? "ask" : "auto";
}

}  // namespace kalfem
