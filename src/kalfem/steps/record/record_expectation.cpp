// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/record/record_expectation.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/identification/open_loop.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;

constexpr double most_work = 2e10;      ///< samples x states^2
constexpr Index fewest_samples = 1000;  ///< are simulated whatever their work
constexpr double moves_nothing = 1e-9;  ///< rms of the model per rms of the record

/// The first samples of a record, as many as their simulation may cost.
Record first_part(const Record& record, Index states) {
  const double samples = most_work / (static_cast<double>(states) * static_cast<double>(states));
  const Index count = std::min(record.samples(), std::max(fewest_samples, static_cast<Index>(samples)));
  Record part = record;
  part.values.conservativeResize(Eigen::NoChange, count);
  part.used.reset();
  return part;
}

ChannelExpectation compare(const ArrayXd& measured, const ArrayXd& simulated) {
  const auto present = measured.isFinite();
  const double count = std::max(1.0, static_cast<double>(present.count()));
  const auto about_mean = [&](const ArrayXd& values) {
    const double mean = present.select(values, 0.0).sum() / count;
    return ArrayXd(present.select(values - mean, 0.0));
  };
  const ArrayXd of_record = about_mean(measured), of_model = about_mean(simulated);
  const double size = std::sqrt(of_record.square().sum() / count),
               expected = std::sqrt(of_model.square().sum() / count);
  if (!(expected > moves_nothing * size)) return {};
  const double product = size * expected * count;
  return {expected, size / expected, product > 0.0 ? (of_record * of_model).sum() / product : 0.0};
}

}  // namespace

RecordExpectation expectation_of_record(const Study& study) try {
  if (study.structure->signals.empty()) return {.reason = "the case has no excitation"};
  if (study.problem && study.problem->settings.local) return {.reason = "the model is a local one"};
  const auto& system = study.model->system();
  const Record part = first_part(study.record->record, 2 * system.size() + system.connector_states());
  const auto simulated = simulate_open_loop({system, *study.model, study.sensors, study.structure->signals},
                                            at_rest(system.size(), system.connector_states()), part);
  const std::string failure = open_loop_failure(simulated, part, "the simulation of the case");
  if (!failure.empty()) return {.reason = failure};
  RecordExpectation expectation{.duration = part.end() - part.start};
  for (Index j = 0; j < part.values.rows(); ++j)
    expectation.channels.push_back(compare(part.values.row(j).transpose(), simulated.sensors.row(j).transpose()));
  return expectation;
} catch (const InvalidInput& error) {
  return {.reason = error.issues().front().what};
}

}  // namespace kalfem
