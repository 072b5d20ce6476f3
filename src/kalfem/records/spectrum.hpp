// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <string>
#include <vector>

#include "kalfem/records/record.hpp"

namespace kalfem {

enum class SpectralWindow { hann, rectangular };

/// How frequency responses are estimated from spectra of a record, with S_yf those of outputs and forces.
enum class FrfEstimator {
  h1,  ///< S_yf S_ff^-1: noise on the outputs does not bias it
  h2,  ///< S_yy / S_fy of one force: noise on the force does not
  hv   ///< total least squares: noise on both, in proportion to their spectra
};

/// Frequency response functions (FRFs) between several inputs and outputs on common lines: output per input, motions
/// taken as exp(+i 2 pi f t).
struct FrfMatrix {
  Eigen::VectorXd lines;         ///< [Hz], ascending
  std::vector<Channel> outputs;  ///< one a column
  std::vector<std::string> inputs;
  std::vector<Eigen::MatrixXcd> values;  ///< one an input, lines x outputs
  /// Standard deviation of the real and of the imaginary part, each, as `values`; empty: not known.
  std::vector<Eigen::MatrixXd> deviations = {};
};

/// A range of frequencies [Hz].
struct FrequencyBand {
  double from = 0.0;
  double to = 0.0;
};

/// rms(estimate - reference) / rms(reference), both of the part of the signals in the band: by the discrete Fourier
/// transform of the Hann-windowed signals, zeros added up to a multiple of four of factors 2, 3 and 5 (Parseval). NaN
/// where the reference has nothing there.
double nrmse_in_band(const Eigen::VectorXd& estimate, const Eigen::VectorXd& reference, double sample_rate,
                     const FrequencyBand& band);

/// Mean square of a signal below any frequency, by the discrete Fourier transform of the Hann-windowed signal. A sample
/// that is not a number counts as the mean.
class CumulativeSpectrum {
public:
  enum class Mean { removed, kept };  ///< kept: the square of the mean counts at frequency zero

  /// `derivatives`: times that the signal is differentiated first, a factor of (2 pi f)^2 each in the mean square.
  CumulativeSpectrum(Eigen::VectorXd signal, double sample_rate, int derivatives = 0, Mean mean = Mean::removed);

  /// [unit^2 of the derivative]; `frequency` in Hz.
  [[nodiscard]] double mean_square_below(double frequency) const;

private:
  double spacing_;  ///< of the lines [Hz]
  double of_mean_ = 0.0;
  Eigen::VectorXd up_to_;  ///< mean square up to and with each line
};

/// Peak of a spectrum.
struct SpectralPeak {
  double frequency = 0.0;  ///< power-weighted over its lines [Hz]
  double share = 0.0;      ///< of the signal's variance
};

/// The strongest peaks of the signal's spectrum, each four times as high as its surroundings and of at least 2 % of the
/// variance; the strongest first. Welch's spectrum of eighths of the signal tells the peaks, that of the whole signal
/// (in pieces of 2^19 samples at most) their frequencies. A sample that is not a number counts as the mean.
std::vector<SpectralPeak> spectral_peaks(Eigen::VectorXd signal, double sample_rate, std::size_t most);

}  // namespace kalfem
