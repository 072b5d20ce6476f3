#pragma once

#include <optional>
#include <vector>

#include "kalfem/estimation/augmented_model.hpp"
#include "kalfem/system/sensors/output_map.hpp"

namespace kalfem {

struct FilterInput;

/// Gains of a filter over a record in physical coordinates, K [state / output], n x l: at each of the first samples,
/// where they change fast, and then now and again. A channel that is missing where a gain is kept has the gain before,
/// and 0 until it is first measured.
struct GainSchedule {
  Eigen::Index dense = 0;   ///< so many at the beginning are there one by one
  Eigen::Index stride = 1;  ///< samples from one to the next after these
  std::vector<Eigen::MatrixXd> gains;

  /// Whether the gain of sample k is kept.
  [[nodiscard]] bool keeps(Eigen::Index k) const { return k < dense || (k - dense) % stride == 0; }
  /// The gain that holds at sample k.
  [[nodiscard]] const Eigen::MatrixXd& at(Eigen::Index k) const {
    const Eigen::Index place = k < dense ? k : dense + (k - dense) / stride;
    return gains[static_cast<std::size_t>(place)];
  }
};

/// Means that a fixed-gain augmented model gives.
struct FixedGainMeans {
  Eigen::MatrixXd monitored;  ///< rows x samples
  Eigen::VectorXd state;      ///< of the augmented state at the sample that was asked for
};

/// Runs the mean of an augmented model over a record with gains that are given,
///     x- = f(x+),   x+ = x- + K_k (y_k - h(x-)),
/// with the maps at the mean in the place of their means over sigma points: no covariance, so a step costs a tenth of a
/// filter's. It tells how estimates move with the model when the gains are held: the difference of two such runs with
/// the same gains. `augmented model` is in physical coordinates. Nothing where a connector force cannot be evaluated.
std::optional<FixedGainMeans> run_with_gains(const AugmentedModel& augmented_model, const FilterInput& input,
                                             const GainSchedule& gains, const OutputMap& monitored,
                                             Eigen::Index state_at);

}  // namespace kalfem
