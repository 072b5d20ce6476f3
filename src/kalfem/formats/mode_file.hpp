// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "kalfem/records/mode_set.hpp"

namespace kalfem {

/// Modes of a file: `modes.json` of `kalfem modal`, with all that it knows of their errors, a MATLAB file (see
/// read_matlab_modes()), or a universal file (datasets 55 and 2414, with nodes of 15 or 2411; static shapes are left
/// out).
///
/// A point of a universal file is a node with a direction, "12:+Z". As such files write zeros for what was not
/// measured, a direction of a node that is exactly zero in every mode is no point; one without a value in one mode (the
/// node is absent there, or the value is no number) is not measured there. Throws InvalidInput as read_universal()
/// does, for text that is no such JSON, and where there is no mode.
ModeSet read_modes(const std::filesystem::path& file);

}  // namespace kalfem
