// SPDX-License-Identifier: Apache-2.0
#include "kalfem/records/oversampling.hpp"

#include <cmath>

#include "kalfem/base/units.hpp"
#include "kalfem/records/kaiser_kernel.hpp"
#include "kalfem/records/signal_continuation.hpp"
#include "kalfem/records/spectrum.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr Index fewest_samples = 32;  ///< of which a spectrum says something
constexpr Index reach = 32;           ///< samples at either side, which give the kernel a transition of 0.1 of the rate

/// Weights of the samples k - reach + 1 ... k + reach for the instant k + i / factor: row i. They sum up to one.
MatrixXd phases(Index factor) {
  MatrixXd weights(factor, 2 * reach);
  for (Index i = 0; i < factor; ++i) {
    const double part = static_cast<double>(i) / static_cast<double>(factor);
    for (Index j = 0; j < 2 * reach; ++j)
      weights(i, j) = windowed_sinc(static_cast<double>(j - reach + 1) - part, 0.5, static_cast<double>(reach));
    weights.row(i) /= weights.row(i).sum();
  }
  return weights;
}

}  // namespace

double share_above_quarter(const Eigen::Ref<const VectorXd>& signal) {
  constexpr double rate = 1.0;
  const CumulativeSpectrum spectrum(signal, rate);
  const double all = spectrum.mean_square_below(rate), below = spectrum.mean_square_below(0.25 * rate);
  return all > 0.0 ? std::max(0.0, 1.0 - below / all) : 0.0;
}

bool is_fast(const Eigen::Ref<const VectorXd>& signal) {
  constexpr double told = 1e-3;
  return signal.size() >= fewest_samples && share_above_quarter(signal) > told;
}

double spline_error(const Eigen::Ref<const VectorXd>& signal) {
  if (signal.size() < fewest_samples) return 0.0;
  constexpr int bands = 100;
  const CumulativeSpectrum spectrum(signal, 1.0);
  double below = 0.0, lost = 0.0;
  for (int i = 1; i <= bands; ++i) {
    const double to = 0.5 * i / bands, middle = to - 0.25 / bands, up_to = spectrum.mean_square_below(to);
    const double taken = std::pow(middle / (1.0 - middle), 4) + std::pow(middle / (1.0 + middle), 4);
    lost += (up_to - below) * taken * taken;
    below = up_to;
  }
  return below > 0.0 ? std::sqrt(lost / below) : 0.0;
}

std::string fast_content(double share, double sample_rate) {
  const double percent = 100.0 * share, tenths = percent < 10.0 ? 10.0 : 1.0;
  return shortest(std::round(percent * tenths) / tenths) + " % of its variance lies above " +
         shortest(0.25 * sample_rate) + " Hz, a quarter of its sampling rate";
}

VectorXd oversampled(const Eigen::Ref<const VectorXd>& signal, Index factor) {
  const Index samples = signal.size();
  const VectorXd longer = reflected(signal, reach);
  const MatrixXd weights = phases(factor);
  VectorXd finer(factor * (samples - 1) + 1);
  for (Index k = 0; k < samples; ++k) {
    finer[factor * k] = signal[k];
    if (k + 1 == samples) break;
    const auto near = longer.segment(k + 1, 2 * reach);  // from sample k - reach + 1 on
    for (Index i = 1; i < factor; ++i) finer[factor * k + i] = weights.row(i) * near;
  }
  return finer;
}

// What is missing d intervals before the last sample: the kernel's weights of the samples behind this one, times how
// far the signal lies from its last value.
Index undetermined_samples(const Eigen::Ref<const VectorXd>& signal) {
  constexpr double told = 1e-3;                           // of the rms about the mean
  const VectorXd weights = phases(2).row(1).transpose();  // midway between two samples
  const VectorXd last = signal.tail(std::min(reach, signal.size()));
  const double swing = (last.array() - last[last.size() - 1]).abs().maxCoeff();
  const double allowed = told * std::sqrt((signal.array() - signal.mean()).square().mean());
  Index count = 0;
  while (count < last.size() && swing * weights.tail(reach - 1 - std::min(count, reach - 1)).norm() > allowed) ++count;
  return count;
}

}  // namespace kalfem
