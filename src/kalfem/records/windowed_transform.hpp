// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <unsupported/Eigen/FFT>

namespace kalfem {

/// (1 - cos(2 pi k / n)) / 2, k = 0 ... n - 1.
Eigen::VectorXd hann_window(Eigen::Index n);

/// Spectra of Hann-windowed signals of one length, each followed by zeros up to a length of factors 2, 3 and 5: all
/// lines of the discrete Fourier transform. Keeps the window and the factors of the length, which cost as much
/// as a transform. One thread.
class WindowedTransform {
public:
  /// `length`: samples of a signal. `multiple`: a divisor of the length with zeros, of factors 2, 3 and 5; with 4 a
  /// transform takes half the time.
  explicit WindowedTransform(Eigen::Index length, Eigen::Index multiple = 1);

  /// Stays until the next call.
  const Eigen::VectorXcd& operator()(const Eigen::VectorXd& signal);

private:
  Eigen::VectorXd window_, windowed_;  ///< `windowed_`: with the zeros
  Eigen::VectorXcd spectrum_;
  Eigen::FFT<double> transform_;
};

}  // namespace kalfem
