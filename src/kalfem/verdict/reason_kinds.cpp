// SPDX-License-Identifier: Apache-2.0
#include "kalfem/verdict/reason_kinds.hpp"

#include <algorithm>

namespace kalfem {

namespace {

bool has(const ReasonKind& kind, std::string_view code) {
  return std::ranges::find(kind.codes, code) != kind.codes.end();
}

}  // namespace

std::span<const ReasonKind> reason_kinds() {
  static const std::vector<ReasonKind> kinds{
      {{"innovation_large"},
       "a sensor's innovations are larger than the filter expects (rms of innovation / expected "
       "deviation)",
       Gravity::either},
      {{"innovation_large_in_part"},
       "the same in the loudest twentieth of the record, with its times: quiet parts do not average a "
       "wrong loud part away"},
      {{"innovation_large_often"}, "more than 5 % of the time beyond half the gate"},
      {{"nis_large"}, "NIS of all sensors together, where no sensor stands out by itself", Gravity::either},
      {{"nis_large_in_part"}, "the same in the loudest twentieth of the record"},
      {{"innovation_correlated"},
       "successive innovations of a sensor are correlated; for a right model they are white [BLK01, "
       "section 5.4]",
       Gravity::either},
      {{"outliers"},
       "up to 5 % of the samples lie far away, with the time of the worst; they hardly count "
       "(`estimate.outliers`). Up to one in a thousand that were given little weight are an event, no "
       "reason"},
      {{"record_too_short"}, "fewer than 50 measured values are left to judge by", Gravity::suspicious, false},
      {{"sensor_dead", "sensor_stuck"},
       "a sensor holds one value or shows noise only while its prediction moves; these samples are not used",
       Gravity::suspicious,
       false},
      {{"sensor_saturated"},
       "a sensor stands at its limit while its prediction moves beyond; these samples are not used",
       Gravity::either,
       false},
      {{"sensor_off"},
       "a live filter leaves a sensor out whose values its model does not expect ([live](live.md))",
       Gravity::suspicious,
       false},
      {{"parameter_jump", "parameter_drift"},
       "an unknown that the model holds constant changes within the record, at once or slowly, with "
       "times and size (see Events); it stands before what it explains. For a drift the remedy gives a "
       "number for `random_walk`",
       Gravity::either},
      {{"fixed_parameter"},
       "a number that the case holds fixed (a mass, a gain, a number of a law) at a value against which "
       "the record speaks: the change that it asks for is significant at .5 % over all numbers together "
       "and moves an unknown by more than its standard deviation ([How well do you know your "
       "model?](fixed-numbers.md)). Where a larger contradiction was looked into, it is the hypothesis "
       "of that name that explains most",
       Gravity::either},
      {{"band_too_narrow"},
       "a sensor, predicted from all others as if it were a virtual one, contradicts its band: bands of "
       "quantities that no sensor measures do not hold ([How well do you know your "
       "model?](fixed-numbers.md#virtual-sensors))",
       Gravity::suspicious,
       false},
      {{"noise_too_large"},
       "innovations are smaller than expected: the noise is stated too large, and the deviations are "
       "too wide",
       Gravity::suspicious,
       false},
      {{"far_from_prior"}, "an estimate lies more than four prior deviations from its initial value", Gravity::either},
      {{"sign_changed"}, "an estimate has the other sign than its initial value"},
      {{"out_of_range"},
       "a negative stiffness, mass or damping by more than its deviation explains",
       Gravity::unusable},
      {{"at_bound"}, "an estimate at one of its bounds", Gravity::suspicious, false},
      {{"not_identified", "correlated", "combination"},
       "the record says nothing about an unknown, or cannot tell two or more apart, unless it knows each to a small "
       "part of its prior",
       Gravity::suspicious,
       false},
      {{"process_noise_decides"},
       "with three times as much or as little process noise an estimate leaves its 95 % interval, by "
       "more than the other run's deviation",
       Gravity::suspicious,
       false},
      {{"noise_adapted_far"},
       "`adaptive_noise` had to move the noise of a sensor, or the process noise, by a factor of three "
       "or more: it may have swallowed what the model misses"},
      {{"step_too_coarse"},
       "the most substeps that are tried, or that `second_thoughts` allow, still bias an estimate by "
       "half its deviation or more",
       Gravity::either,
       false},
      {{"deviation_too_small"},
       "the robust standard deviation of an unknown is 1.5 times the stated one or more; in an "
       "updating, only where a residual is large too, as intervals come from the wider one",
       Gravity::either},
      {{"too_sure"},
       "the filter's standard deviation of an unknown, which rests on linearisations about the estimates of each "
       "moment, "
       "is 1.5 times too small or more beside that about one point, or the most likely value is more than twice it "
       "away ([tangents](theory/tangents.md#whether-the-filter-is-too-sure))",
       Gravity::suspicious,
       false},
      {{"open_loop_error", "open_loop_failed"}, "the estimates alone do not reproduce the record"},
      {{"validation_error"},
       "the estimates do not predict data that they were not found from ([measured records](records.md))",
       Gravity::either},
      {{"validation_worse"}, "they predict them far worse than their own"},
      {{"residual_large"},
       "after an updating, the residual of a comparison is larger than its stated deviations",
       Gravity::either},
      {{"residual_small"}, "the same, smaller"},
      {{"not_converged", "poor_pairs"},
       "an updating did not end at a minimum; no mode of the model agrees with a measured one"},
      {{"setup_mistake"},
       "sensors of a modal test measure something else than the case says: turned, exchanged, rotated, along another "
       "axis or at another point ([modes of a record](modal.md#beside-the-model))",
       Gravity::suspicious,
       false},
      {{"unphysical_sign"}, "an updated stiffness, mass or modulus is negative", Gravity::unusable},
      {{"validation_failed"}, "the estimates cannot be simulated over the data that were held back"},
      {{"input_not_identified", "input_drifts"},
       "the sensors hardly show an unknown excitation; the band of one that walks grows without end"},
      {{"likelihood_not_converged"}, "the search for gains, delays and noise did not end at a maximum"},
      {{"failed"}, "a step stopped", Gravity::unusable},
  };
  return kinds;
}

std::span<const ReasonKind> mistake_kinds() {
  static const std::vector<ReasonKind> kinds{
      {{"sensor_sign", "sensor_unit", "sensor_gain"},
       "sign, unit (g, mm, inches, ...) or sensitivity of one sensor",
       Gravity::either},
      {{"record_unit"}, "the unit of all sensors", Gravity::either},
      {{"sensor_delay"},
       "a sensor's clock, up to 150 ms early or late; parts of a sample interval where whole ones leave something",
       Gravity::either},
      {{"sensor_drift"}, "a clock that runs fast or slow: of one sensor, or of a rack of them", Gravity::either},
      {{"sensors_swapped"}, "two sensors are exchanged", Gravity::either},
      {{"sensor_offset", "sensor_saturated", "sensor_noise"},
       "an offset; a range that is too small; noise other than stated",
       Gravity::either},
      {{"excitation_sign", "excitation_unit", "excitation_gain", "excitation_delay", "excitation_rate"},
       "the same of each excitation, and the time base of all",
       Gravity::either},
      {{"fixed_parameter"},
       "a parameter that the case holds fixed, alone or with all of its kind that have the same value",
       Gravity::either},
      {{"first_guess"},
       "the initial value of an unknown, with its relative prior: a filter that starts far off may end "
       "far off",
       Gravity::either},
      {{"wrong_law"},
       "a connector that needs further forces: a stop, another damping in rebound than in compression, a force "
       "quadratic or cubic in the deformation or the rate, friction, hysteresis, a lag",
       Gravity::either},
      {{"missing_modes"}, "modes that the reduction left out", Gravity::either},
  };
  return kinds;
}

std::string_view to_string(Gravity gravity) {
  switch (gravity) {
    case Gravity::suspicious:
      return "suspicious";
    case Gravity::either:
      return "either";
    case Gravity::unusable:
      return "unusable";
  }
  return "";
}

const ReasonKind* kind_of_reason(std::string_view code) {
  for (const auto kinds : {reason_kinds(), mistake_kinds()})
    if (const auto found = std::ranges::find_if(kinds, [&](const auto& kind) { return has(kind, code); });
        found != kinds.end())
      return &*found;
  return nullptr;
}

VerdictState allowed_state(std::string_view code, VerdictState state) {
  const auto* kind = kind_of_reason(code);
  if (!kind || state == VerdictState::consistent || kind->gravity == Gravity::either) return state;
  return kind->gravity == Gravity::unusable ? VerdictState::unusable : VerdictState::suspicious;
}

}  // namespace kalfem
