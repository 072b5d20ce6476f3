// SPDX-License-Identifier: Apache-2.0
#include "kalfem/records/spectrum_pair.hpp"

#include <algorithm>
#include <numbers>
#include <unsupported/Eigen/FFT>

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::VectorXcd;
using Eigen::VectorXd;

VectorXd hann(Index n) {
  const double last = 2.0 * std::numbers::pi * static_cast<double>(n - 1) / static_cast<double>(n);
  return 0.5 - 0.5 * VectorXd::LinSpaced(n, 0.0, last).array().cos();
}

/// Lines 1 to below half the sampling rate of the windowed segment, its mean taken off.
VectorXcd spectrum_of(const VectorXd& signal, Index begin, const VectorXd& window) {
  const Index n = window.size();
  const VectorXd samples = signal.segment(begin, n);
  const VectorXd windowed = (samples.array() - samples.mean()) * window.array();
  Eigen::FFT<double> transform;
  VectorXcd spectrum;
  transform.fwd(spectrum, windowed);
  return spectrum.segment(1, (n - 1) / 2);
}

}  // namespace

SpectrumPair spectrum_pair(const VectorXd& first, const VectorXd& second, double sample_rate, Index segment) {
  SpectrumPair pair;
  const Index lines = (segment - 1) / 2;
  const VectorXd window = hann(segment);
  pair.first = pair.second = pair.difference = VectorXd::Zero(lines);
  VectorXcd cross = VectorXcd::Zero(lines);
  for (Index begin = 0; begin + segment <= first.size(); begin += std::max<Index>(1, segment / 2)) {
    if (!first.segment(begin, segment).allFinite() || !second.segment(begin, segment).allFinite()) continue;
    const VectorXcd x = spectrum_of(first, begin, window), y = spectrum_of(second, begin, window);
    pair.first += x.cwiseAbs2();
    pair.second += y.cwiseAbs2();
    pair.difference += (x - y).cwiseAbs2();
    cross += x.conjugate().cwiseProduct(y);
    ++pair.segments;
  }
  if (pair.segments == 0) return {};
  const VectorXd power = pair.first.cwiseProduct(pair.second);
  pair.coherence = (power.array() > 0.0).select(cross.cwiseAbs2().array() / power.array(), 0.0).min(1.0);
  const double to_density = 2.0 / (sample_rate * window.squaredNorm() * static_cast<double>(pair.segments));
  for (auto* density : {&pair.first, &pair.second, &pair.difference}) *density *= to_density;
  pair.lines = VectorXd::LinSpaced(lines, 1.0, static_cast<double>(lines)) * sample_rate / static_cast<double>(segment);
  return pair;
}

}  // namespace kalfem
