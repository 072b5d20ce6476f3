// SPDX-License-Identifier: Apache-2.0
#include "kalfem/modal/stabilisation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <optional>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/modal/shape_measures.hpp"

namespace kalfem {
namespace {

constexpr std::size_t least_poles = 4;
constexpr double looser = 4.0;  ///< limits of deviations, for a pole that continues a track

/// Certainty of a pole: the inverse of the sum of its relative variances.
double weight(const StatePole& pole) {
  const double of_frequency = pole.frequency_std / (pole.frequency * pole.damping),
               of_damping = pole.damping_std / pole.damping;
  return 1.0 / (of_frequency * of_frequency + of_damping * of_damping);
}

/// The pole up to which, ascending by `value`, a share of the weight lies.
template <class Value>
const StatePole* weighted_quantile(std::vector<const StatePole*> poles, double share, const Value& value) {
  std::ranges::sort(poles, {}, [&](const StatePole* pole) { return std::invoke(value, *pole); });
  double left = 0.0;
  for (const auto* pole : poles) left += share * weight(*pole);
  for (const auto* pole : poles) {
    left -= weight(*pole);
    if (left <= 0.0) return pole;
  }
  return poles.back();
}

/// Whether a pole may be a mode: its damping and its standard deviations are within the limits, times `factor`.
bool is_admissible(const StatePole& pole, const StabilisationOptions& limits, double factor) {
  return pole.damping > 0.0 && pole.damping <= limits.largest_damping &&
         pole.frequency_std <= factor * limits.frequency_std * pole.frequency &&
         pole.damping_std <= factor * limits.damping_std * pole.damping;
}

/// 0 for the same pole, larger the less they agree; nothing where they are different modes.
std::optional<double> distance(const StatePole& one, const StatePole& other, const StabilisationOptions& limits) {
  const double frequency =
      std::abs(one.frequency - other.frequency) / std::max(one.frequency, other.frequency) / limits.frequency;
  const double damping = std::abs(one.damping - other.damping) / std::max(one.damping, other.damping) / limits.damping;
  const double shape = (1.0 - mac(one.shape, other.shape)) / (1.0 - limits.mac);
  if (frequency > 1.0 || damping > 1.0 || shape > 1.0) return std::nullopt;
  return frequency + damping + shape;
}

/// A track that is being followed.
struct OpenTrack {
  PoleTrack track;
  std::size_t first = 0;  ///< position of its first order
};

struct Link {
  double distance;
  std::size_t track, pole;
};

void follow(std::vector<OpenTrack>& tracks, std::size_t position, const std::vector<StatePole>& poles,
            const StabilisationOptions& limits) {
  std::vector<Link> links;
  for (std::size_t t = 0; t < tracks.size(); ++t) {
    for (std::size_t p = 0; p < poles.size(); ++p)
      if (is_admissible(poles[p], limits, looser))
        if (const auto apart = distance(*tracks[t].track.poles.back(), poles[p], limits))
          links.push_back({*apart, t, p});
  }
  std::ranges::sort(links, {}, &Link::distance);
  std::vector<bool> continued(tracks.size(), false), taken(poles.size(), false);
  for (const auto& link : links) {
    if (continued[link.track] || taken[link.pole]) continue;
    continued[link.track] = taken[link.pole] = true;
    tracks[link.track].track.poles.push_back(&poles[link.pole]);
  }
  for (std::size_t p = 0; p < poles.size(); ++p)
    if (!taken[p] && is_admissible(poles[p], limits, looser)) tracks.push_back({{{&poles[p]}}, position});
}

/// Of the poles within a standard deviation of the medians of frequency and damping one whose deviations are a little
/// smaller than the median, all by weight: the smallest deviations are so by chance, the largest where an order cuts
/// between singular values that hardly differ. With the share of 0.6 intervals hold the truth as often as they say, see
/// docs/modal.md.
const StatePole& typical_pole(const std::vector<const StatePole*>& poles) {
  const double frequency = weighted_quantile(poles, 0.5, &StatePole::frequency)->frequency,
               damping = weighted_quantile(poles, 0.5, &StatePole::damping)->damping;
  std::vector<const StatePole*> near;
  std::ranges::copy_if(poles, std::back_inserter(near), [&](const StatePole* pole) {
    return std::abs(pole->frequency - frequency) <= pole->frequency_std &&
           std::abs(pole->damping - damping) <= pole->damping_std;
  });
  return *weighted_quantile(near.empty() ? poles : near, 0.6, weight);
}

/// Whether a pole may be of a sine, whose damping is none but for rounding and the record's length.
bool is_undamped(const StatePole& pole) {
  constexpr double none = 1e-3, deviations = 3.0;
  return std::abs(pole.damping) < none && std::abs(pole.damping) < deviations * pole.damping_std;
}

/// The vibrating pole nearest to a chosen frequency, of those within 2 % of it; null: there is none.
const StatePole* pole_at(const ChosenPole& wanted, const std::vector<std::vector<StatePole>>& by_order) {
  constexpr double near = 0.02;
  for (std::size_t i = by_order.size(); i-- > 0;) {
    const StatePole* found = nullptr;
    for (const auto& pole : by_order[i]) {
      if (wanted.order > 0 && pole.order != wanted.order) continue;
      const double apart = std::abs(pole.frequency - wanted.frequency);
      if (pole.damping > 0.0 && apart < near * wanted.frequency &&
          (!found || apart < std::abs(found->frequency - wanted.frequency)))
        found = &pole;
    }
    if (found) return found;
  }
  return nullptr;
}

/// The undamped pole nearest to a frequency, of those within 2e-4 of it.
const StatePole* undamped_at(double frequency, const std::vector<StatePole>& poles) {
  constexpr double same = 2e-4;
  const StatePole* found = nullptr;
  for (const auto& pole : poles) {
    const double apart = std::abs(pole.frequency - frequency);
    if (is_undamped(pole) && apart < same * frequency && (!found || apart < std::abs(found->frequency - frequency)))
      found = &pole;
  }
  return found;
}

}  // namespace

const StatePole& PoleTrack::representative(Eigen::Index least_order) const {
  if (chosen) return *chosen;
  std::vector<const StatePole*> counted;
  std::ranges::copy_if(poles, std::back_inserter(counted),
                       [&](const StatePole* pole) { return pole->order >= least_order; });
  return counted.empty() ? typical_pole(poles) : typical_pole(counted);
}

Eigen::Index sufficient_order(const std::vector<PoleTrack>& tracks) {
  Eigen::Index order = 0;
  for (const auto& track : tracks) order = std::max(order, track.poles.front()->order);
  return order;
}

std::vector<PoleTrack> stable_tracks(const std::vector<std::vector<StatePole>>& by_order,
                                     const StabilisationOptions& limits) {
  std::vector<OpenTrack> tracks;
  for (std::size_t position = 0; position < by_order.size(); ++position)
    follow(tracks, position, by_order[position], limits);
  std::erase_if(tracks, [&](const OpenTrack& each) {
    const auto possible = static_cast<double>(by_order.size() - each.first);
    const auto certain = std::ranges::count_if(
        each.track.poles, [&](const StatePole* pole) { return is_admissible(*pole, limits, 1.0); });
    return each.track.poles.size() < least_poles || certain < 2 ||
           !is_admissible(each.track.representative(), limits, 1.0) ||
           each.track.representative().participation < limits.least_participation ||
           static_cast<double>(each.track.poles.size()) < limits.least_share * possible;
  });
  std::ranges::stable_sort(tracks, std::greater{}, [](const OpenTrack& each) { return each.track.poles.size(); });
  std::vector<PoleTrack> stable;
  for (auto& each : tracks)
    if (std::ranges::none_of(stable, [&](const PoleTrack& longer) {
          return distance(longer.representative(), each.track.representative(), limits).has_value();
        }))
      stable.push_back(std::move(each.track));
  std::ranges::sort(stable, {}, [](const PoleTrack& each) { return each.representative().frequency; });
  return stable;
}

std::vector<PoleTrack> chosen_tracks(const std::vector<std::vector<StatePole>>& by_order,
                                     const std::vector<ChosenPole>& poles, const StabilisationOptions& limits) {
  std::vector<PoleTrack> tracks;
  IssueList issues;
  for (const auto& wanted : poles) {
    const StatePole* chosen = pole_at(wanted, by_order);
    if (!chosen) {
      issues.add({},
                 fmt::format("there is no pole at {:.5g} Hz{}", wanted.frequency,
                             wanted.order > 0 ? fmt::format(" of order {}", wanted.order) : ""),
                 "a chosen pole lies within 2 % of one in the stabilisation diagram",
                 "read its frequency and order from the diagram (--page, --json)");
      continue;
    }
    PoleTrack track{.poles = {}, .chosen = chosen};
    for (const auto& of_order : by_order) {
      const StatePole* same = nullptr;
      std::optional<double> nearest;
      for (const auto& pole : of_order)
        if (const auto apart = distance(*chosen, pole, limits); apart && (!nearest || *apart < *nearest)) {
          nearest = apart;
          same = &pole;
        }
      if (same) track.poles.push_back(same);
    }
    tracks.push_back(std::move(track));
  }
  issues.raise();
  std::ranges::sort(tracks, {}, [](const PoleTrack& each) { return each.chosen->frequency; });
  return tracks;
}

// From the largest order down: a pole of noise that happens to be undamped in one model is not so in the next.
std::vector<double> steady_harmonics(const std::vector<std::vector<StatePole>>& by_order,
                                     const std::vector<PoleTrack>& modes, const StabilisationOptions& limits) {
  constexpr double beside = 5e-3, least_participation = 1e-4;
  constexpr std::size_t least_orders = 6;
  std::vector<double> found;
  if (by_order.empty()) return found;
  for (const auto& pole : by_order.back()) {
    const auto near = [&](double frequency) { return std::abs(frequency - pole.frequency) < beside * pole.frequency; };
    if (!is_undamped(pole) || pole.participation < least_participation) continue;
    if (std::ranges::any_of(modes, [&](const PoleTrack& mode) { return near(mode.representative().frequency); }) ||
        std::ranges::any_of(found, near))
      continue;
    std::size_t first = by_order.size(), held = 0;
    for (std::size_t i = by_order.size(); i-- > 0;)
      if (undamped_at(pole.frequency, by_order[i])) {
        first = i;
        ++held;
      }
    const auto possible = static_cast<double>(by_order.size() - first);
    if (held >= least_orders && static_cast<double>(held) >= limits.least_share * possible)
      found.push_back(pole.frequency);
  }
  std::ranges::sort(found);
  return found;
}

}  // namespace kalfem
