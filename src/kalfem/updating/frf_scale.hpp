// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace kalfem {

/// Which responses share a factor that the comparison leaves free, as that of a sensor that was not calibrated. The
/// best factor c follows from the residual itself, where d are the differences ln|H_model / H| and w = |H| / sigma:
///     ln c = -sum w^2 d / sum w^2,      r = w (d + ln c),
/// so that it is no parameter of the search. Only logarithms can be compared so.
enum class FrfScale {
  fixed,        ///< none: responses are calibrated
  per_input,    ///< one for all responses to an input
  per_response  ///< one for each response
};

}  // namespace kalfem
