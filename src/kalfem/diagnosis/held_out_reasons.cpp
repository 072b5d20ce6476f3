// SPDX-License-Identifier: Apache-2.0
#include "kalfem/diagnosis/held_out_reasons.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "kalfem/identification/held_out_sensors.hpp"

namespace kalfem {

std::vector<Reason> held_out_reasons(const RecordEstimate& estimate) {
  const auto* study = estimate.held_out_sensors.get();
  const auto* worst = study ? study->worst() : nullptr;
  if (!worst) return {};
  std::string remedy =
      "look for what the model leaves out; until then rely on no band of a quantity that no sensor measures";
  if (study->proposes())
    remedy = fmt::format(
        "look for what the model leaves out, or let process noise stand for it, with which the bands hold: "
        "process_noise: {{acceleration: {:.2g} m/s^2/sqrt(Hz)}}, adaptive_noise: {{process: true}} (log-likelihood "
        "{:+.3g})",
        study->adapted->density, study->adapted->gain);
  return {{.code = "band_too_narrow",
           .subject = worst->name,
           .text = fmt::format("predicted from the other sensors, '{}' contradicts its band, which holds {:.3g} % of "
                               "its samples and about {:.2g} % of its motion: 95 % bands of quantities that no sensor "
                               "measures are too narrow",
                               worst->name, 100.0 * worst->inside, 100.0 * worst->motion_inside),
           .remedy = std::move(remedy),
           .weight = std::max(worst->followed, worst->in_band)}};
}

}  // namespace kalfem
