// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "kalfem/records/mode_set.hpp"

namespace kalfem {

/// Modes of a MATLAB file of any version, of variables or of the fields of its only structure:
///     frequencies [Hz], shapes (points x modes, real or complex), and, where they are known,
///     points (a cell of names; otherwise "1", "2", ...), frequency_std [Hz], dampings (ratios), damping_std,
///     shape_std (of real and of imaginary part, as large as shapes).
/// NaN stands for what was not measured. Throws InvalidInput with all that is absent or does not fit.
ModeSet read_matlab_modes(const std::filesystem::path& path);

}  // namespace kalfem
