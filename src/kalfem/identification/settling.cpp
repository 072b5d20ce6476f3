// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/settling.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kalfem/system/linearised.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double largest_share = 0.1;  ///< of the record
constexpr double remainder = 0.01;     ///< of an amplitude that has decayed
constexpr Index most_dofs = 300;       ///< whose modes cost nothing beside a filter
constexpr double rigid = 1e-3;         ///< times the highest frequency: modes below have no decay of their own

/// Decay rate of the slowest elastic mode about rest [1/s]: half of phi^T C phi, as of light damping. 0: not known.
double slowest_decay(const CoupledModel& coupled) try {
  if (coupled.system().size() > most_dofs) return 0.0;
  const LinearModel model = linearised_at_rest(coupled);
  const NormalModes modes = normal_modes(model.mass, model.stiffness);
  MatrixXd damped = model.damping * modes.shapes;
  if (model.modal_damping.rates.size() > 0) damped += damping_force(model.modal_damping, model.mass, modes.shapes);
  double slowest = std::numeric_limits<double>::infinity();
  for (Index i = 0; i < modes.frequencies.size(); ++i)
    if (modes.frequencies[i] > rigid * modes.frequencies.maxCoeff())
      slowest = std::min(slowest, 0.5 * modes.shapes.col(i).dot(damped.col(i)));
  return std::isfinite(slowest) ? std::max(0.0, slowest) : 0.0;
} catch (const InvalidInput&) {
  return 0.0;  // a law without a tangent at rest
}

}  // namespace

double settling_time(const EstimationSettings& settings, const AugmentedModelSetup& setup, const RecordStart& start,
                     const Record& record) {
  if (settings.settle) return *settings.settle;
  if (!start.moving) return 0.0;
  const double most = largest_share * static_cast<double>(record.samples()) / record.sample_rate;
  const double decay = slowest_decay(*setup.model);
  return decay > 0.0 ? std::min(most, -std::log(remainder) / decay) : most;
}

Index first_settled_sample(const EstimationSettings& settings, const AugmentedModelSetup& setup,
                           const RecordStart& start, const Record& record) {
  const auto first =
      static_cast<Index>(std::llround(settling_time(settings, setup, start, record) * record.sample_rate));
  return std::clamp<Index>(first, 0, record.samples() - 1);
}

}  // namespace kalfem
