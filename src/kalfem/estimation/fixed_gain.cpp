// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/fixed_gain.hpp"

#include <cassert>

#include "kalfem/estimation/estimate.hpp"
#include "kalfem/estimation/filter_setup.hpp"
#include "kalfem/estimation/process_model.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

// A filter's loop with the mean alone: predict by the process model at the mean, correct by the kept gain, look at the
// monitored quantities. Missing channels add nothing. Maps are evaluated at one point in the place of sigma points.
/// A map of an augmented model at one point, y = A x + G phi(N x + e) + b.
template <class Map>
class PointMap {
public:
  explicit PointMap(Map& map) : map_(map), largest_(VectorXd::Zero(map.selection().rows())) {}

  [[nodiscard]] const VectorXd& largest() const { return largest_; }

  /// Nothing changes where phi cannot be evaluated.
  bool apply(const VectorXd& x, VectorXd& y) {
    map_.set_mean(x);
    arguments_.noalias() = map_.selection() * x;
    arguments_ += map_.input_offset();
    largest_ = largest_.cwiseMax(arguments_.cwiseAbs());
    in_ = arguments_.transpose().array();
    out_.resize(1, map_.gain().cols());
    if (!map_.evaluate(in_, out_)) return false;
    response_ = out_.row(0).matrix().transpose();
    y.noalias() = map_.linear() * x;
    y.noalias() += map_.gain() * response_;
    y += map_.offset();
    return true;
  }

private:
  Map& map_;
  VectorXd arguments_, response_, largest_;
  Eigen::ArrayXXd in_, out_;
};

}  // namespace

std::optional<FixedGainMeans> run_with_gains(const AugmentedModel& augmented_model, const FilterInput& input,
                                             const Gains& gains, const OutputMap& monitored, Index state_at) {
  assert(augmented_model.options().coordinates == StateCoordinates::physical);
  const auto& layout = augmented_model.layout();
  const Index samples = input.measured.samples(), stride = input.input_stride(augmented_model.options().instants());
  ProcessModel transition(augmented_model);
  MeasurementModel measurement(augmented_model, sensor_outputs);
  MeasurementModel monitored_map(
      augmented_model, [&](const AugmentedModel& each) { return each.augmented_model_form().outputs(monitored); });
  PointMap predict(transition);
  PointMap<MeasurementModel> measure(measurement), look(monitored_map);
  FixedGainMeans means{Eigen::MatrixXd(monitored.size(), samples),
                       Eigen::MatrixXd(input.measured.values.rows(), samples),
                       Eigen::MatrixXd(layout.unknowns, samples)};
  means.predicted.resize(input.measured.values.rows(), samples);
  VectorXd state = augmented_model.prior().mean, predicted = state, output, innovation, values;
  for (Index k = 0; k < samples; ++k) {
    if (k > 0) {
      set_inputs_to(k, input, augmented_model.options().instants(), transition);
      if (!predict.apply(state, predicted)) return std::nullopt;
      state.swap(predicted);
    }
    measurement.set_inputs(input.inputs.col(k * stride));
    if (!measure.apply(state, output)) return std::nullopt;
    means.predicted.col(k) = output;
    input.sample(k, innovation);
    innovation -= output;
    innovation = innovation.array().isNaN().select(0.0, innovation);
    means.innovation.col(k) = innovation;
    state.noalias() += gains[static_cast<std::size_t>(k)] * innovation;
    means.unknowns.col(k) = state.segment(layout.unknown(), layout.unknowns);
    if (k == state_at) means.state = state;
    if (monitored.size() == 0) continue;
    monitored_map.set_inputs(input.inputs.col(k * stride));
    if (!look.apply(state, values)) return std::nullopt;
    means.monitored.col(k) = values;
  }
  means.largest = predict.largest();
  return means;
}

}  // namespace kalfem
