// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "kalfem/diagnosis/hypothesis.hpp"
#include "kalfem/diagnosis/left_out_predictions.hpp"

namespace kalfem {

/// What single sensors may have against them: sign, unit, gain, delay, offset, saturation, noise; two that are
/// exchanged; a unit or gain of all.
/// `likeness`: of every sensor to its prediction by the others; `of_all`: of all to what the excitation alone gives.
std::vector<Hypothesis> sensor_hypotheses(const DiagnosisInput& input, const FilterRun& base,
                                          const std::vector<Likeness>& likeness, const Likeness& of_all);

/// What the excitations may have against them: sign, unit, gain, delay of each, another rate of all.
/// `sample_rate`: of the record [Hz]. `likeness`: of the sensors to what each excitation gives, less what the others
/// give.
std::vector<Hypothesis> excitation_hypotheses(double sample_rate, const std::vector<std::string>& sources,
                                              const std::vector<Likeness>& likeness);

/// Size of the motion of a connector in a run.
struct ConnectorMotion {
  double deformation = 0.0, rate = 0.0, force = 0.0;          ///< rms [m], [m/s], [N]
  double least_deformation = 0.0, largest_deformation = 0.0;  ///< [m]

  [[nodiscard]] bool moves() const { return deformation > 0.0 && rate > 0.0 && force > 0.0; }
};

/// What the model may have against it: each parameter that is held fixed, the first guess of each unknown, a law that a
/// connector does not follow, modes that the reduction left out. `motion`: of each connector of the parts.
std::vector<Hypothesis> model_hypotheses(const DiagnosisInput& input, const std::vector<ConnectorMotion>& motion);

}  // namespace kalfem
