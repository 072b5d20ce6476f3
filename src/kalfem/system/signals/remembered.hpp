// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/system/signal.hpp"

namespace kalfem {

/// The signal itself, with the samples of its last long calls kept: a filter that runs again over a record, or over
/// records that differ by their noise alone, asks for the same ones. At most 100 MB of samples stay.
SignalPtr remembered(SignalPtr signal);

}  // namespace kalfem
