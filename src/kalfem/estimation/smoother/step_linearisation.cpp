// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/smoother/step_linearisation.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

ArgumentTransform argument_transform_of(const EstimationOptions& options) {
  if (options.filter == FilterKind::extended) return ArgumentTransform::linearised();
  UnscentedOptions of_arguments = options.unscented;
  of_arguments.points = SigmaPoints::of_arguments;
  return ArgumentTransform(of_arguments);
}

bool StepLinearisation::evaluate(PartiallyLinearMap& map, const Gaussian& about) {
  const MatrixXd& N = map.selection();
  const MatrixXd selected = N * about.covariance;
  return moments_.evaluate(map, N * about.mean + map.input_offset(), selected * N.transpose());
}

bool StepLinearisation::linearise_prediction(FilterSetup& setup, const Gaussian& before, LinearisedStep& step) {
  if (!evaluate(setup.transition, before)) return false;
  step.gain_of_arguments = moments_.slopes() * setup.transition.gain().transpose();
  return true;
}

// An iterated update conditioned on the measurement linearised about the posterior.
bool StepLinearisation::linearise_update(FilterSetup& setup, const Gaussian& predicted, const Innovation& innovation,
                                         LinearisedMeasurement& measurement) {
  const auto& channels = innovation.channels;
  const Index n = predicted.mean.size();
  measurement = {MatrixXd(0, n), MatrixXd(n, 0), MatrixXd(0, n), VectorXd()};
  if (channels.empty()) return true;
  auto& map = setup.measurement;
  const auto& filter = *setup.filter;
  if (!evaluate(map, innovation.relinearised ? Gaussian{filter.mean(), filter.covariance()} : predicted)) return false;
  measurement.output = map.linear()(channels, Eigen::all);
  measurement.output += map.gain()(channels, Eigen::all) * (moments_.slopes().transpose() * map.selection());
  measurement.gain = filter.gain();
  const Eigen::LLT<MatrixXd> factor(innovation.conditioned_covariance());
  measurement.weighted = factor.solve(measurement.output);
  measurement.innovation = factor.solve(innovation.conditioned_value());
  return true;
}

}  // namespace kalfem
