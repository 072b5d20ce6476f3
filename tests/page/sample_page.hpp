// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <numbers>

#include "kalfem/page/page.hpp"

namespace kalfem {

/// A page with every kind of chart and table, on signals that look like the real ones: a 20 s estimate at 1 kHz.
inline Page sample_page() {
  const std::size_t samples = 20001;
  std::vector<double> t(samples);
  std::vector<double> truth(samples), estimate(samples), low(samples), high(samples), measured(samples);
  std::vector<double> parameter(samples), parameter_low(samples), parameter_high(samples), force(samples);
  for (std::size_t k = 0; k < samples; ++k) {
    t[k] = static_cast<double>(k) * 1e-3;
    const double hiss = std::sin(12345.678 * static_cast<double>(k * k % 9973));
    const double unsure = std::exp(-t[k] / 1.5);
    truth[k] = 3e-3 * std::sin(8.0 * t[k]) + 1.2e-3 * std::sin(31.0 * t[k] + 0.4) * std::cos(0.7 * t[k]);
    estimate[k] = truth[k] + 1.5e-3 * unsure * std::sin(11.0 * t[k]);
    low[k] = estimate[k] - 2e-4 - 2e-3 * unsure;
    high[k] = estimate[k] + 2e-4 + 2e-3 * unsure;
    measured[k] = truth[k] + 5e-4 * hiss;
    parameter[k] = 30.0 - 15.0 * unsure * std::cos(2.0 * t[k]);
    parameter_low[k] = parameter[k] - 0.2 - 15.0 * unsure;
    parameter_high[k] = parameter[k] + 0.2 + 15.0 * unsure;
    force[k] = 2e4 * truth[k] + 30.0 * truth[k] / (1e-3 + std::abs(truth[k])) + 40.0 * std::cos(8.0 * t[k]);
  }
  const std::vector<double> thirty(samples, 30.0);
  const std::vector<double> fifteen(samples, 15.0);

  Chart convergence{.id = "mu_k1",
                    .title = "suspension_2.mu_k1",
                    .caption = "The band is twice the standard deviation on either side.",
                    .x_label = "time [s]",
                    .y_label = "friction force [N]",
                    .x = t,
                    .series = {{"true", thirty, {}, {}, Role::truth},
                               {"estimate", parameter, parameter_low, parameter_high, Role::estimate},
                               {"initial guess", fifteen, {}, {}, Role::initial}},
                    .half_width = true};
  Chart second = convergence;
  second.id = "mu_c1";
  second.title = "suspension_2.mu_c1";
  second.y_window = AxisRange{25.0, 35.0};
  Chart displacement{.id = "p5",
                     .title = "frame.p5.z, displacement",
                     .caption = "",
                     .x_label = "time [s]",
                     .y_label = "displacement [m]",
                     .x = t,
                     .series = {{"measured", measured, {}, {}, Role::measured},
                                {"estimate", estimate, low, high, Role::estimate},
                                {"reference", truth, {}, {}, Role::truth}}};
  Chart zoomed = displacement;
  zoomed.id = "p5-late";
  zoomed.title = "The same after two seconds";
  zoomed.caption = "Drag to look closer, double click to see the whole record.";
  zoomed.x_window = AxisRange{2.0, 3.5};
  zoomed.series[0].y[2500] = std::nan("");
  Chart loop{.id = "loop",
             .title = "Connector suspension_2",
             .caption = "Force over deformation.",
             .x_label = "deformation [m]",
             .y_label = "force [N]",
             .series = {{"reference", force, {}, {}, Role::truth, truth},
                        {"estimate", force, {}, {}, Role::estimate, estimate}},
             .scatter = true};
  Chart innovation{.id = "nis",
                   .title = "Normalised innovation squared",
                   .caption = "",
                   .x_label = "time [s]",
                   .y_label = "NIS",
                   .x = t,
                   .series = {{"NIS", measured, {}, {}, Role::other},
                              {"95 % limit", std::vector<double>(samples, 3e-3), {}, {}, Role::limit},
                              {"driven frame", truth, {}, {}, Role::predicted}},
                   .half_width = true};
  const Table parameters{"Parameters",
                         {"parameter", "true", "initial", "estimate", "standard deviation", "unit"},
                         {{"suspension_2.mu_k1", "30", "15", "29.97", "0.09", "N"},
                          {"suspension_2.mu_c1", "30", "48", "30.02", "0.11", "N"}}};
  return {
      .title = "Vehicle frame on four nonlinear suspensions",
      .subtitle = "examples/vehicle.yaml \u00b7 45,564 degrees of freedom reduced to 40",
      .status = VerdictState::consistent,
      .summary =
          "Two parameters found within 0.1 % of the reference; the innovations are white (mean NIS 7.05 where 7 is "
          "expected).",
      .sections = {{"Parameters",
                    "Estimated together with all states from seven accelerations.\n\nThe dashed line is the value that "
                    "the reference was made with.",
                    {parameters, convergence, second}},
                   {"Motion", "", {displacement, zoomed}},
                   {"Suspensions and diagnostics", "", {loop, innovation}}}};
}

}  // namespace kalfem
