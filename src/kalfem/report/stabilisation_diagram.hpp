// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "kalfem/modal/modal_result.hpp"

namespace kalfem {

/// Poles of all orders over frequency as one self-contained SVG element: those of modes blue, with a bar of two
/// standard deviations to each side, others as small grey dots; a line and its number at each mode.
std::string stabilisation_svg(const ModalResult& result);

}  // namespace kalfem
