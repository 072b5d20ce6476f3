// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/step_shift.hpp"

#include <limits>
#include <utility>

#include "kalfem/estimation/filter_setup.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
}  // namespace

StepShift::Maps::Maps(std::shared_ptr<const AugmentedModel> of)
    : model(std::move(of)), transition(*model), measurement(*model, sensor_outputs) {}

StepShift::StepShift(std::shared_ptr<const AugmentedModel> model)
    : maps_(std::make_unique<Maps>(std::move(model))), shift_(VectorXd::Zero(maps_->model->layout().size())) {}

/// Nonlinear outputs at the mean and at the mean shifted.
bool StepShift::outputs(PartiallyLinearMap& map, const VectorXd& mean) {
  in_.resize(2, map.selection().rows());
  out_.resize(2, map.gain().cols());
  in_.row(0) = (map.selection() * mean + map.input_offset()).transpose().array();
  in_.row(1) = in_.row(0) + (map.selection() * shift_).transpose().array();
  if (map.evaluate(in_, out_)) return true;
  shift_.setConstant(not_a_number);
  return false;
}

/// What the map makes of the shift.
VectorXd StepShift::response(const PartiallyLinearMap& map) const {
  const VectorXd difference = (out_.row(1) - out_.row(0)).matrix().transpose();
  return map.linear() * shift_ + map.gain() * difference;
}

void StepShift::predict_to(Index k, const FilterInput& input, const VectorXd& mean) {
  auto& map = maps_->transition;
  set_inputs_to(k, input, maps_->model->options().instants(), map);
  if (map.moving_gain() > 0) map.set_mean(mean);
  if (!outputs(map, mean)) return;
  shift_ = response(map) + map.embedded_difference(out_.row(0).matrix().transpose());
}

void StepShift::update_at(Index k, const FilterInput& input, const VectorXd& mean, const Filter& filter,
                          const Innovation& innovation) {
  if (innovation.channels.empty()) return;
  auto& map = maps_->measurement;
  map.set_inputs(input.inputs.col(k * input.input_stride(maps_->model->options().instants())));
  if (map.moving_gain() > 0) map.set_mean(mean);
  if (!outputs(map, mean)) return;
  const VectorXd seen = response(map);
  shift_ -= filter.gain() * seen(innovation.channels);
}

void StepShift::move_to(std::shared_ptr<const AugmentedModel> model) {
  const MatrixXd physical = maps_->model->physical(shift_);
  shift_ = model->own(physical);
  maps_ = std::make_unique<Maps>(std::move(model));
}

}  // namespace kalfem
