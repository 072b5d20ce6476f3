// SPDX-License-Identifier: Apache-2.0
#include "kalfem/watch/stream_clock.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/live/three_digits.hpp"

namespace kalfem {
namespace {

constexpr double jitter = 0.1;            ///< of a sample: times that are further off have moved
constexpr double gain = 0.2;              ///< by which a phase follows the times
constexpr double patience_ahead = 10.0;   ///< of strays that follow each other, until the clock has jumped [s]
constexpr double patience_behind = 60.0;  ///< longer, as blocks that are sent twice come behind
constexpr double furthest = 1e12;         ///< from the origin [s]

}  // namespace

PlacedBlock StreamClock::place(std::size_t channel, double time, std::ptrdiff_t count, std::optional<double> newest) {
  if (!(std::abs(time) < furthest))
    throw InvalidInput("the time " + shortest(time) + " s cannot be that of a sample", "", "");
  const double phase = phases_[channel].value_or(latest_phase_);
  const double place = time - phase / rate_;  // by the filter's clock
  const double ahead = newest ? place - *newest : 0.0;
  const double duration = static_cast<double>(count) / rate_;
  const bool is_ahead = ahead > longest_gap_, is_behind = ahead + duration < -horizon_;
  PlacedBlock placed;
  if (!is_ahead && !is_behind) {
    strays_from_.reset();
    placed.time = on_the_grid(channel, time, phase, placed.words);
    return placed;
  }
  const bool follows = follows_other_strays(place, duration);
  if (is_ahead && !follows)
    throw InvalidInput("samples that begin " + three_digits(ahead) + " s after the latest ones",
                       "the time must be wrong, or the clock has jumped",
                       "where all samples go on from there, they are used after " + shortest(patience_ahead) + " s");
  const double since = place - *strays_from_;
  if (since < (is_ahead ? patience_ahead : patience_behind)) {
    if (is_behind) placed.time = std::round(place * rate_) / rate_;  // it counts as late
    return placed;
  }
  placed.jump = ahead - since;  // the time for which it has been waited has passed for the structure, too
  placed.words = "the clock has jumped by " + three_digits(placed.jump) + " s; the stream goes on from there";
  strays_from_.reset();
  placed.time = on_the_grid(channel, time - placed.jump, phase, placed.words);
  return placed;
}

/// Whether all blocks since the first stray are strays of one clock: each begins about where the ones before end.
bool StreamClock::follows_other_strays(double time, double duration) {
  const bool follows = strays_from_ && time >= *strays_from_ && std::abs(time - strays_to_) <= horizon_ + duration;
  if (!follows) strays_from_ = time;
  strays_to_ = follows ? std::max(strays_to_, time + duration) : time + duration;
  return follows;
}

/// The sample that is nearest by the phase so far, which is moved towards the time.
double StreamClock::on_the_grid(std::size_t channel, double time, double phase, std::string& words) {
  const double place = time * rate_ - phase, sample = std::round(place), off = place - sample;
  const bool has_moved = std::abs(off) > jitter;
  const auto before = std::exchange(moved_, has_moved ? std::optional(off) : std::nullopt);
  const bool again = has_moved && before && std::abs(off - *before) <= jitter;
  if (has_moved && (!again || !phases_[channel]))
    throw InvalidInput("the time " + shortest(time) + " s lies between two samples",
                       "sample k is taken at start + k / " + shortest(rate_) + " Hz", "resample the channel");
  if (has_moved)
    words += (words.empty() ? "" : "; ") + ("its clock has moved by " + three_digits(off) + " of a sample");
  phases_[channel] = latest_phase_ = phase + (has_moved ? off : gain * off);
  return sample / rate_;
}

}  // namespace kalfem
