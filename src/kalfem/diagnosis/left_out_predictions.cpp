// SPDX-License-Identifier: Apache-2.0
#include "kalfem/diagnosis/left_out_predictions.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double not_listened_to = 1e3;  ///< times the stated noise, or the recorded signal where this is larger
constexpr Index fewest_samples = 30;
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

/// Rows about their means, scaled to a mean square of one, zero where nothing is there.
MatrixXd centred(const Eigen::Ref<const MatrixXd>& values, VectorXd& scale) {
  MatrixXd result = values;
  scale.resize(values.rows());
  for (Index i = 0; i < values.rows(); ++i) {
    auto row = result.row(i).array();
    const auto there = row.isFinite();
    const double count = std::max(1.0, static_cast<double>(there.count()));
    const double mean = there.select(row, 0.0).sum() / count;
    row = there.select(row - mean, 0.0).eval();
    scale[i] = std::sqrt(row.square().sum() / count);
  }
  return result;
}

double mean_square(const Eigen::Ref<const Eigen::RowVectorXd>& values) {
  const auto there = values.array().isFinite();
  const double count = std::max(1.0, static_cast<double>(there.count()));
  return there.select(values.array(), 0.0).square().sum() / count;
}

/// sum over rows and samples of one(k) other(k - lag).
double product(const MatrixXd& one, const MatrixXd& other, Index lag) {
  const Index count = one.cols() - std::abs(lag);
  return one.middleCols(std::max<Index>(lag, 0), count)
      .cwiseProduct(other.middleCols(std::max<Index>(-lag, 0), count))
      .sum();
}

}  // namespace

MatrixXd predicted_without(const DiagnosisInput& input, const FilterRun& run, const EstimationOptions& options,
                           const std::vector<Index>& left_out) {
  const auto& measured = run.input.measured;
  FilterInput heard = run.input;
  DiagnosisInput others = input;
  for (const Index i : left_out) {
    heard.noise(i, i) =
        not_listened_to * not_listened_to * std::max(heard.noise(i, i), mean_square(measured.values.row(i)));
    Record& record = others.record;
    record.values.row(record.find(measured.channels[static_cast<std::size_t>(i)].name)).setConstant(not_a_number);
  }
  // A start that is read from displacement sensors needs all of them.
  const bool given_start = input.problem->settings.initial_state_from_record;
  const auto choice = given_start ? run.choice : others.run().choice;
  const auto result = estimate(*choice.augmented_model, heard, options);
  if (result.failure) return {};
  return measured.values - result.innovation;
}

Likeness likeness(const Eigen::Ref<const MatrixXd>& recorded, const Eigen::Ref<const MatrixXd>& predicted, Index most) {
  Likeness found;
  if (predicted.size() == 0 || predicted.cols() < fewest_samples) return found;
  VectorXd recorded_scale, predicted_scale;
  MatrixXd y = centred(recorded, recorded_scale), x = centred(predicted, predicted_scale);
  for (Index i = 0; i < y.rows(); ++i) {
    const double weight = recorded_scale[i] > 0.0 ? 1.0 / recorded_scale[i] : 0.0;
    y.row(i) *= weight;
    x.row(i) *= weight;
  }
  const double of_x = x.squaredNorm(), of_y = y.squaredNorm();
  if (!(of_x > 0.0) || !(of_y > 0.0)) return found;
  found.known = true;
  found.gain = product(y, x, 0) / of_x;
  if (y.rows() == 1) {
    const auto difference = (recorded - predicted).array();
    const auto there = difference.isFinite();
    found.offset = there.select(difference, 0.0).sum() / std::max(1.0, static_cast<double>(there.count()));
  }
  double largest = 0.0;
  const Index reach = std::min(most, x.cols() - fewest_samples);
  for (Index lag = -reach; lag <= reach; ++lag) {
    const double value = product(y, x, lag);
    if (std::abs(value) <= largest) continue;
    largest = std::abs(value);
    found.lag = lag;
    found.correlation = value / std::sqrt(of_x * of_y);
  }
  found.clock = fit_clock(recorded, predicted, reach);
  return found;
}

}  // namespace kalfem
