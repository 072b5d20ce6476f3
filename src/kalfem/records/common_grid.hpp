// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <vector>

namespace kalfem {

/// When the samples of a channel were taken.
struct SampleTimes {
  double start = 0.0;          ///< of the first sample [s]
  double interval = 0.0;       ///< between samples [s]; 0: `times` holds each
  Eigen::VectorXd times = {};  ///< of each sample [s], strictly ascending; empty: even
  Eigen::Index count = 0;

  [[nodiscard]] double at(Eigen::Index k) const {
    return times.size() > 0 ? times[k] : start + static_cast<double>(k) * interval;
  }
  [[nodiscard]] double end() const { return at(count - 1); }
  /// Usual interval between two samples [s].
  [[nodiscard]] double usual_interval() const;
};

/// Even times at which the samples of several channels can stand side by side.
struct CommonGrid {
  double start = 0.0;          ///< [s]
  double sample_rate = 1.0;    ///< [Hz]
  double last = 0.0;           ///< largest number of a grid time; it may be too large for a record
  double largest_shift = 0.0;  ///< of a sample to its grid time [s]
};

/// The coarsest grid on which every sample has a time of its own, moved by at most a tenth of the shortest usual
/// interval. It has that channel's rate or up to ten times as many; five are always enough for a tenth. A sample that
/// is moved by dt is wrong by its rate of change times dt: at a twentieth of the sampling rate, a tenth is 3 % at most,
/// and hardly more than 1 % rms. Throws InvalidInput where two samples of one channel lie too close for any of them.
CommonGrid common_grid(const std::vector<SampleTimes>& channels);

/// Number of the grid time of each sample of a channel.
std::vector<Eigen::Index> places_on(const CommonGrid& grid, const SampleTimes& channel);

/// Values of a channel at even times of its usual interval, on the natural cubic spline through its samples.
Eigen::VectorXd evenly_interpolated(const SampleTimes& channel, const Eigen::Ref<const Eigen::VectorXd>& values,
                                    double sample_rate);

}  // namespace kalfem
