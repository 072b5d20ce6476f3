// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "kalfem/page/page.hpp"
#include "kalfem/report/finished/finished_run.hpp"

namespace kalfem {

/// A chart with the name that its file gets, without an ending.
struct Figure {
  std::string name;
  Chart chart;
};

/// The figures of a finished run, as papers show them, from its results.h5:
///   parameter-<name>              estimate over time with its 95 % band, and the truth; of an updating over
///   evaluations displacement-<point>{,-zoom}  estimated and simulated displacement, whole and a part about the largest
///   motion acceleration-<point>          predicted and simulated acceleration of the driven substructure
///   force-<connector>             estimated and simulated connector force over the deformation, about the largest one
///   validation-<sensor>           measured and simulated on the validation part
///   predictive-<sensor>           measured, and the posterior's prediction with its 95 % band
///   response-<comparison>-<i>     frequency response: measured, before and after the updating
/// What the run does not have is left out. `points`: whose motion is drawn; empty: the two first ones that move.
/// Throws InvalidInput for a point that the run does not have, and if results.h5 is missing or damaged.
std::vector<Figure> run_figures(const FinishedRun& run, const std::vector<std::string>& points = {});

}  // namespace kalfem
