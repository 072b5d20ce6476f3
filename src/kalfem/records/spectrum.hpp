#pragma once

#include <Eigen/Dense>

namespace kalfem {

/// A range of frequencies [Hz].
struct FrequencyBand {
  double from = 0.0;
  double to = 0.0;
};

/// rms(estimate - reference) / rms(reference), both of the part of the signals in the band: by the discrete Fourier
/// transform of the Hann-windowed signals, zeros added up to a length of factors 2, 3 and 5 (Parseval). NaN where the
/// reference has nothing there.
double nrmse_in_band(const Eigen::VectorXd& estimate, const Eigen::VectorXd& reference, double sample_rate,
                     const FrequencyBand& band);

}  // namespace kalfem
