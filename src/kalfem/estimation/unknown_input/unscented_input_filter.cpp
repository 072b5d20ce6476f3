// SPDX-License-Identifier: Apache-2.0
#include "kalfem/estimation/unknown_input/unscented_input_filter.hpp"

#include <utility>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

MatrixXd symmetric(const MatrixXd& matrix) { return 0.5 * (matrix + matrix.transpose()); }

ArgumentTransform of_arguments(UnscentedOptions options) {
  options.points = SigmaPoints::of_arguments;
  return ArgumentTransform(options);
}

}  // namespace

UnscentedInputFilter::UnscentedInputFilter(UnknownInputMaps maps, const UnscentedOptions& options)
    : maps_(std::move(maps)), arguments_(of_arguments(options)) {
  const auto& [process, measurement, G, D, Q, R] = maps_;
  const Index n = process.linear().rows(), l = measurement.linear().rows(), p = G.cols();
  const bool fits = process.linear().cols() == n && measurement.linear().cols() == n && G.rows() == n &&
                    D.rows() == l && D.cols() == p && Q.rows() == n && Q.cols() == n && R.rows() == l && R.cols() == l;
  if (!fits)
    throw InvalidInput("the matrices of a model with an unknown input do not fit its maps",
                       "G is n x p, D l x p, Q n x n and R l x l, the process n -> n and the measurement n -> l", "");
}

// With F the slopes of phi, H = A + G F^T N and P_yy = H P H^T + G (P_phi - F^T P_ww F) G^T.
std::optional<UnscentedInputFilter::Image> UnscentedInputFilter::image(PartiallyLinearMap& map, const Gaussian& x) {
  const MatrixXd &N = map.selection(), &G = map.gain();
  const MatrixXd arguments = N * x.covariance * N.transpose();
  if (!arguments_.evaluate(map, N * x.mean + map.input_offset(), arguments)) return std::nullopt;
  const MatrixXd& slopes = arguments_.slopes();
  Image found{.y = {}, .linearised = map.linear() + G * slopes.transpose() * N};
  const MatrixXd rest = arguments_.covariance() - slopes.transpose() * arguments * slopes;
  found.y.mean = map.linear() * x.mean + G * arguments_.mean() + map.offset();
  found.y.covariance =
      symmetric(found.linearised * x.covariance * found.linearised.transpose() + G * rest * G.transpose());
  return found;
}

std::optional<InputMoments> UnscentedInputFilter::moments(const Gaussian& predicted, const VectorXd& y) {
  const auto output = image(maps_.measurement, predicted);
  if (!output) return std::nullopt;
  const bool direct = maps_.has_feedthrough();
  return InputMoments{.state = predicted,
                      .cross = predicted.covariance * output->linearised.transpose(),
                      .innovation = y - output->y.mean,
                      .innovation_covariance = output->y.covariance + maps_.R,
                      .state_input = direct ? MatrixXd::Zero(maps_.G.rows(), maps_.G.cols()) : maps_.G,
                      .output_input = direct ? maps_.D : MatrixXd(output->linearised * maps_.G)};
}

std::optional<InputEstimate> UnscentedInputFilter::update(const Gaussian& predicted, const VectorXd& y) {
  const auto of = moments(predicted, y);
  return of ? estimate_input(*of) : std::nullopt;
}

std::optional<InputEstimate> UnscentedInputFilter::first_update(const Gaussian& prior, const VectorXd& y) {
  const auto of = moments(prior, y);
  return of ? std::optional(estimate_without_input(*of)) : std::nullopt;
}

std::optional<Gaussian> UnscentedInputFilter::predict(const InputEstimate& estimate) {
  const auto moved = image(maps_.process, estimate.state);
  if (!moved) return std::nullopt;
  Gaussian predicted{moved->y.mean, moved->y.covariance + maps_.Q};
  if (!maps_.has_feedthrough()) return predicted;
  const MatrixXd &G = maps_.G, shared = moved->linearised * estimate.cross * G.transpose();
  predicted.mean += G * estimate.input.mean;
  predicted.covariance += shared + shared.transpose() + G * estimate.input.covariance * G.transpose();
  predicted.covariance = symmetric(predicted.covariance);
  return predicted;
}

}  // namespace kalfem
