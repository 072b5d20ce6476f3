// SPDX-License-Identifier: Apache-2.0
#include "kalfem/records/fractional_shift.hpp"

#include <array>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <vector>

#include <unsupported/Eigen/FFT>

#include "kalfem/records/signal_continuation.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// A signal and its continuation as one period.
class PeriodicSignal {
public:
  explicit PeriodicSignal(const VectorXd& signal) {
    const std::vector<double> period = periodic(without_gaps(signal));
    fft_.fwd(lines_, period);
  }

  [[nodiscard]] Index length() const { return std::ssize(lines_); }

  /// The whole period earlier by `lead` samples.
  std::vector<double> earlier(double lead) {
    auto lines = lines_;
    const std::size_t half = lines.size() / 2;
    for (std::size_t i = 1; i < half; ++i) {
      const double phase = 2.0 * std::numbers::pi * static_cast<double>(i) * lead / static_cast<double>(length());
      lines[i] *= std::polar(1.0, phase);
      lines[lines.size() - i] = std::conj(lines[i]);
    }
    lines[half] *= std::cos(std::numbers::pi * lead);
    std::vector<double> moved;
    fft_.inv(moved, lines);
    return moved;
  }

private:
  Eigen::FFT<double> fft_;
  std::vector<std::complex<double>> lines_;
};

/// The polynomial through values at Chebyshev points of [-1/2, 1/2] (Berrut and Trefethen, SIAM Rev. 46 (2004) 501-517,
/// eqs. 4.2 and 5.3).
class FractionInterpolation {
public:
  static constexpr int points = 12;

  FractionInterpolation() {
    for (int j = 0; j < points; ++j) {
      const double angle = (2.0 * j + 1.0) * std::numbers::pi / (2.0 * points);
      at_[j] = 0.5 * std::cos(angle);
      weight_[j] = (j % 2 == 0 ? 1.0 : -1.0) * std::sin(angle);
    }
  }

  [[nodiscard]] double point(int j) const { return at_[j]; }

  template <class Value>
  [[nodiscard]] double at(double fraction, const Value& value) const {
    double sum = 0.0, weights = 0.0;
    for (int j = 0; j < points; ++j) {
      const double distance = fraction - at_[j];
      if (distance == 0.0) return value(j);
      sum += weight_[j] / distance * value(j);
      weights += weight_[j] / distance;
    }
    return sum / weights;
  }

private:
  std::array<double, points> at_{}, weight_{};
};

/// y(k), from k and the nearest sample to k + lead(k), where that one is there; otherwise missing.
template <class Lead, class Value>
VectorXd where_present(const Eigen::Ref<const VectorXd>& signal, const Lead& lead, const Value& value) {
  VectorXd result = VectorXd::Constant(signal.size(), std::numeric_limits<double>::quiet_NaN());
  for (Index k = 0; k < signal.size(); ++k) {
    const double nearest = std::round(static_cast<double>(k) + lead(k));
    if (!(nearest >= 0.0) || !(nearest < static_cast<double>(signal.size()))) continue;
    if (std::isfinite(signal[static_cast<Index>(nearest)])) result[k] = value(k, static_cast<Index>(nearest));
  }
  return result;
}

}  // namespace

VectorXd shifted(const Eigen::Ref<const VectorXd>& signal, double lead) {
  if (signal.size() == 0) return signal;
  const std::vector<double> moved = PeriodicSignal(signal).earlier(lead);
  return where_present(
      signal, [&](Index) { return lead; }, [&](Index k, Index) { return moved[static_cast<std::size_t>(k)]; });
}

VectorXd shifted(const Eigen::Ref<const VectorXd>& signal, const VectorXd& lead) {
  if (signal.size() == 0) return signal;
  PeriodicSignal periodic(signal);
  const FractionInterpolation fractions;
  std::vector<std::vector<double>> moved;
  for (int j = 0; j < FractionInterpolation::points; ++j) moved.push_back(periodic.earlier(fractions.point(j)));
  return where_present(
      signal, [&](Index k) { return lead[k]; },
      [&](Index k, Index nearest) {
        const double fraction = lead[k] - static_cast<double>(nearest - k);
        return fractions.at(
            fraction, [&](int j) { return moved[static_cast<std::size_t>(j)][static_cast<std::size_t>(nearest)]; });
      });
}

}  // namespace kalfem
