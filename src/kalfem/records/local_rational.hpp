// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>

#include "kalfem/records/frequency_response.hpp"
#include "kalfem/records/record_spectra.hpp"

namespace kalfem {

/// Window of lines that each local fit uses.
struct LocalRationalOptions {
  Eigen::Index half_width = 20;    ///< lines on each side; fewer where the record has not as many
  Eigen::Index order = 3;          ///< of the three polynomials: resonances that a window may hold
  int passes = 2;                  ///< the second one weighs the equation error by 1 / |A| of the first
  Eigen::Index most_lines = 2000;  ///< fits are spread evenly over the lines of the band if it has more
};

struct LocalRationalFit {
  /// H at the lines of the band that were fitted, with its deviation and 1 - noise / |Y|^2, the part of the outputs'
  /// power about the line that input and transient explain, as `coherence`.
  FrequencyResponse response;
  Eigen::MatrixXd noise;  ///< E |E|^2 of the spectra's output noise, at every line of `spectra` in the band x outputs
};

/// FRFs and noise of a record with any excitation, blows too, by the local rational method [MG12; PS12, chapter 7]:
/// about a line k, with r the distance in lines, input U, output Y,
///     Y(k + r) = (B(r) U(k + r) + C(r)) / A(r) + E(k + r),   A(0) = 1,
/// with polynomials A, B, C of `order`, by least squares of the equation times A. C / A is the leakage of motion that
/// the record begins and ends with, which has the poles of H = B / A; it is left out where the noise is no larger
/// without it. No window widens a resonance. Noise: the residual's power per degree of freedom over the mean of |A|^2,
/// in which A's coefficients count twice, because they also follow the noise; the mean over the windows that overlap,
/// and |H|^2 times input_error_power().
///
/// A window of 2 half_width + 1 lines may hold no more resonances than `order`: others make the noise too large.
LocalRationalFit fit_local_rational(const RecordSpectra& spectra, const FrequencyBand& band,
                                    const LocalRationalOptions& options = {});

}  // namespace kalfem
