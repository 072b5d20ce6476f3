// SPDX-License-Identifier: Apache-2.0
#include "kalfem/validation/estimated_structure.hpp"

#include <algorithm>
#include <utility>

#include "kalfem/identification/record_estimate.hpp"
#include "kalfem/identification/released_elements.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

std::vector<SensorOffset> found_offsets(const EstimationProblem& problem, const RecordEstimate& estimate) {
  std::vector<SensorOffset> offsets;
  const auto& unknowns = estimate.augmented_model->options().unknowns;
  const Index last = estimate.result.unknowns.mean.cols() - 1;
  for (SensorOffset offset : problem.offsets) {
    const auto found = std::ranges::find(unknowns, offset.name, &UnknownParameter::name);
    if (found == unknowns.end() || is_rest_position(offset)) continue;
    offset.initial = estimate.result.unknowns.mean(found - unknowns.begin(), last);
    offset.deviation = estimate.result.unknowns.deviation(found - unknowns.begin(), last);
    offsets.push_back(std::move(offset));
  }
  return offsets;
}

}  // namespace

MotionRange range_of(const MatrixXd& motion, Index dofs) {
  const VectorXd mean = motion.rowwise().mean();
  return {mean, (motion.colwise() - mean).cwiseAbs().rowwise().maxCoeff(), dofs};
}

MotionRange range_of(const RecordEstimate& estimate) {
  const auto& layout = estimate.augmented_model->layout();
  const auto& mean = estimate.result.state.mean;
  MatrixXd motion(2 * layout.dofs + layout.connector_states, mean.cols());
  motion << mean.topRows(2 * layout.dofs), mean.middleRows(layout.connector_state(), layout.connector_states);
  return range_of(motion, layout.dofs);
}

EstimatedStructure at_estimates(const EstimationProblem& problem, StructureParts parts,
                                const RecordEstimate& estimate) {
  EstimatedStructure found{problem.structure, std::move(parts), problem.sensors, problem.settings,
                           found_offsets(problem, estimate)};
  found.settings.substeps = estimate.substeps.substeps;
  const auto unknowns = std::exchange(found.settings.unknowns, {});
  const VectorXd estimates = estimate.result.unknowns.mean.rightCols(1);
  for (std::size_t i = 0; i < unknowns.size(); ++i)
    for (const auto& target : unknowns[i].targets)
      if (can_be_released(problem.structure->parts, target))  // others are in the parts already
        set_parameter(found.parts, target, estimates[static_cast<Index>(i)]);
  return found;
}

PreparedRecord without_sensor_errors(PreparedRecord prepared, const RecordEstimate& estimate) {
  if (const auto& found = estimate.likelihood)
    prepared.record = corrected_record(found->unknowns, found->values, std::move(prepared.record));
  return prepared;
}

}  // namespace kalfem
