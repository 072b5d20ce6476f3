// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "kalfem/modal/modal_options.hpp"
#include "kalfem/modal/state_space_poles.hpp"

namespace kalfem {

/// Poles of several orders that are the same mode.
struct PoleTrack {
  std::vector<const StatePole*> poles;  ///< at most one an order, ascending
  const StatePole* chosen = nullptr;    ///< by a person; null: none

  /// The pole that stands for all: the chosen one; otherwise, of the orders from `least_order` on (of all where it has
  /// none there): near the median frequency and damping, with a typical standard deviation.
  [[nodiscard]] const StatePole& representative(Eigen::Index least_order = 0) const;
};

/// The lowest order whose model may hold all modes: models of lower orders are biased, as their modes stand for
/// several.
Eigen::Index sufficient_order(const std::vector<PoleTrack>& tracks);

/// Follows poles from order to order: poles of an order continue tracks whose last pole had about the same frequency,
/// damping and shape, the nearest pairs first; others start a track. Poles with a damping or with deviations far beyond
/// the limits are left out. A track is a mode where it holds in enough of the orders from its first one on, in at least
/// four, and where the pole that stands for it and one more are within the limits; of two with the same frequency and
/// shape the longer one stays. `by_order`: ascending orders. Tracks by frequency.
std::vector<PoleTrack> stable_tracks(const std::vector<std::vector<StatePole>>& by_order,
                                     const StabilisationOptions& limits);

/// The tracks of the poles that a person chose: each is the nearest one in frequency within 2 %, of its order, with the
/// poles of other orders that are the same. Throws InvalidInput with every choice without such a pole.
std::vector<PoleTrack> chosen_tracks(const std::vector<std::vector<StatePole>>& by_order,
                                     const std::vector<ChosenPole>& poles, const StabilisationOptions& limits);

/// Frequencies [Hz] of poles that hold over the orders with no damping that their deviations tell from none: steady
/// harmonics of machines. Those beside a mode, within half a per cent, are taken for that mode.
std::vector<double> steady_harmonics(const std::vector<std::vector<StatePole>>& by_order,
                                     const std::vector<PoleTrack>& modes, const StabilisationOptions& limits);

}  // namespace kalfem
