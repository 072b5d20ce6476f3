// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace kalfem {

/// sin(2 pi c t) / (2 pi c t) under a Kaiser window that ends at |t| = `half_length` and leaves 100 dB [Kai74]: a
/// low-pass filter with the cut-off c per unit of t.
double windowed_sinc(double t, double cut_off, double half_length);

}  // namespace kalfem
