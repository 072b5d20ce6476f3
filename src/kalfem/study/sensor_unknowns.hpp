// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/identification/estimation_problem.hpp"
#include "kalfem/study/case_study.hpp"

namespace kalfem {

/// Whether an unknown of this name is one of the measurement or of the noise: sensors.NAME.gain, .delay, .offset or
/// .noise, or process_noise.
bool is_measurement_unknown(const std::string& name);

/// Its SI unit. The sensor is one of these.
std::string measurement_unit(const std::vector<Sensor>& sensors, const std::string& name);

/// Adds it to the problem. Throws InvalidInput where there is no such sensor, and for numbers that do not fit.
void add_measurement_unknown(const CaseStudy& study, const std::string& name, const description::Unknown& given,
                             EstimationProblem& problem);

}  // namespace kalfem
