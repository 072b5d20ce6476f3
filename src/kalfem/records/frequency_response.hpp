// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "kalfem/records/record.hpp"
#include "kalfem/records/spectrum.hpp"

namespace kalfem {

/// Frequency response functions (FRFs) of one input: H_j(f) = output j per input, with motions taken as exp(+i 2 pi f
/// t).
struct FrequencyResponse {
  Eigen::VectorXd lines;            ///< [Hz], ascending
  std::vector<Channel> outputs;     ///< one a column
  Eigen::MatrixXcd values;          ///< H, lines x outputs
  Eigen::MatrixXd deviations = {};  ///< standard deviation of the real and of the imaginary part, each (it is that of
                                    ///< |H| too, where it is small), lines x outputs; 0 x 0: not known
  bool magnitudes_only = false;     ///< the phases were not measured: the values are |H|
  Eigen::MatrixXd coherence = {};   ///< gamma^2 of output and input, lines x outputs; 0 x 0: not known
};

/// How spectra of a record are averaged [Wel67].
struct H1Options {
  Eigen::Index segment = 0;  ///< samples; the lines are sample_rate / segment apart
  double overlap = 0.5;      ///< part of a segment that the next one shares, in [0, 0.95]
  SpectralWindow window = SpectralWindow::hann;
};

struct H1Estimate {
  FrequencyResponse response;  ///< without line 0, because the mean of each segment is taken off
  Eigen::Index segments = 0;   ///< that were averaged
  double averages = 0.0;       ///< n_d, independent segments to which the overlapping ones are worth
};

/// H1 = S_xy / S_xx with gamma^2 = |S_xy|^2 / (S_xx S_yy), which noise on the output does not bias, from the segments
/// of one or more records (blows of a hammer in a file each) [BP10, 9.1].
///
/// Deviation of each part, from the part of the output's power that is not coherent (in [BP10] with n_d for n_d - 1):
///     sigma^2 = S_yy (1 - gamma^2) / (2 (n_d - 1) S_xx).
/// Effective averages of n overlapping segments, with rho_k the correlation of windows k steps apart [Wel67]:
///     n_d = n / (1 + 2 sum_k (1 - k / n) rho_k^2).
/// With one segment the coherence is 1 and the deviations are not known. Lines at which the input has no power are left
/// out. Throws InvalidInput where a channel is missing, sampling rates differ or no record is as long as a segment.
H1Estimate estimate_h1(std::span<const Record> records, const std::string& input,
                       const std::vector<std::string>& outputs, const H1Options& options);

/// What counts as a peak of an FRF.
struct PeakOptions {
  FrequencyBand band = {0.0, std::numeric_limits<double>::infinity()};
  double least = 0.1;       ///< height against the highest peak in the band
  double prominence = 2.0;  ///< height against the lowest place between it and any higher peak (or the band's end)
};

/// A resonance.
struct ResponsePeak {
  double frequency = 0.0;         ///< natural frequency [Hz]
  std::optional<double> damping;  ///< ratio to critical; nothing where the lines around it do not tell
};

/// Resonances of lightly damped FRFs, ascending: the peaks of the columns' root mean square, each fitted over the lines
/// around it by one pole that all columns share, in x = omega^2,
///     H_j = (a_j + b_j x) / (x - p),  p = omega_r^2 (1 + 2 i zeta),
/// a mode's displacement, velocity or acceleration on a constant background, linear in p, a_j and b_j after
/// multiplication by x - p. Where the fit finds no damped pole among those lines, a parabola through the highest three
/// gives the frequency.
std::vector<ResponsePeak> find_peaks(const FrequencyResponse& response, const PeakOptions& options = {});

}  // namespace kalfem
