// SPDX-License-Identifier: Apache-2.0
#include "kalfem/records/windowed_transform.hpp"

#include <algorithm>
#include <numbers>

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// The least 2^a 3^b 5^c that is a multiple of `multiple` and not below n: transforms of other lengths take a time that
/// grows with n times its largest prime factor.
Index fast_length(Index n, Index multiple) {
  for (Index length = multiple * ((std::max<Index>(n, 1) + multiple - 1) / multiple);; length += multiple) {
    Index rest = length;
    for (const Index factor : {2, 3, 5})
      while (rest % factor == 0) rest /= factor;
    if (rest == 1) return length;
  }
}

}  // namespace

VectorXd hann_window(Index n) {
  const double last = 2.0 * std::numbers::pi * static_cast<double>(n - 1) / static_cast<double>(n);
  return 0.5 - 0.5 * VectorXd::LinSpaced(n, 0.0, last).array().cos();
}

WindowedTransform::WindowedTransform(Index length, Index multiple)
    : window_(hann_window(length)), windowed_(VectorXd::Zero(fast_length(length, multiple))) {}

const Eigen::VectorXcd& WindowedTransform::operator()(const VectorXd& signal) {
  windowed_.head(window_.size()) = signal.cwiseProduct(window_);
  transform_.fwd(spectrum_, windowed_);
  return spectrum_;
}

}  // namespace kalfem
