// SPDX-License-Identifier: Apache-2.0
#include "kalfem/statistics/motion_errors.hpp"

#include <algorithm>
#include <complex>
#include <numeric>
#include <vector>

#include <unsupported/Eigen/FFT>

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXcd;
using Eigen::VectorXd;

namespace {

constexpr Index bands = 10;
constexpr double energy_in_band = 0.99;

/// The largest length up to n of factors 2, 3 and 5: a prime would take n^2 operations.
Index fast_length(Index n) {
  for (;; --n) {
    Index rest = n;
    for (const Index factor : {2, 3, 5})
      while (rest % factor == 0) rest /= factor;
    if (rest == 1) return n;
  }
}

/// At the frequencies between zero and half the sampling rate, both left out.
VectorXcd spectrum(const VectorXd& values) {
  VectorXcd all;
  Eigen::FFT<double>().fwd(all, (values.array() - values.mean()).matrix().eval());
  return all.segment(1, (values.size() - 1) / 2);
}

/// The fewest frequencies that hold so much of the energy.
std::vector<Index> loudest(const VectorXd& energy, double part) {
  std::vector<Index> order(static_cast<std::size_t>(energy.size()));
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, std::ranges::greater{}, [&](Index f) { return energy[f]; });
  double held = 0.0;
  auto end = order.begin();
  while (end != order.end() && held < part * energy.sum()) held += energy[*end++];
  order.erase(end, order.end());
  return order;
}

}  // namespace

MotionErrors motion_errors(const VectorXd& errors, const VectorXd& prediction) {
  MotionErrors found;
  if (errors.size() < 3) return found;
  const Index n = fast_length(errors.size());
  const VectorXcd e = spectrum(errors.tail(n)), x = spectrum(prediction.tail(n));
  const VectorXd energy = x.cwiseAbs2();
  const double total = energy.sum(), scale = 2.0 / static_cast<double>(n);
  if (!(total > 0.0)) return found;

  std::complex<double> product = 0.0;
  double of_band = 0.0;
  for (Index f = 0; f < energy.size(); ++f) {
    product += e[f] * std::conj(x[f]);
    of_band += energy[f];
    const bool ends = f + 1 == energy.size() || of_band >= total / bands;
    if (!ends || !(of_band > 0.0)) continue;
    found.followed += scale * std::norm(product) / of_band;
    found.followed_freedom += 2.0;
    of_band = 0.0;
    product = 0.0;
  }
  for (const Index f : loudest(energy, energy_in_band)) {
    found.in_band += scale * std::norm(e[f]);
    found.in_band_freedom += 2.0;
  }
  return found;
}

}  // namespace kalfem
