// SPDX-License-Identifier: Apache-2.0
#include "kalfem/identification/record_start.hpp"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <limits>
#include <numbers>
#include <sstream>

#include "kalfem/records/isolated_values.hpp"
#include "kalfem/records/spectrum.hpp"
#include "kalfem/statistics/quantiles.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr Index first_samples = 10;           ///< of a record, that show whether it starts at rest
constexpr double certain = 1.0 - 1e-6;        ///< probability of a smaller NIS at rest
constexpr double large_nis = 4.0;             ///< per channel
constexpr Index samples_for_a_spike = 5;      ///< of so many first samples of a channel one may be a spike
constexpr double large_ratio = 4.0;           ///< innovation over its deviation: a spike, or a motion
constexpr double large_innovation = 0.3;      ///< of the channel's size: more than a model's error at the first steps
constexpr double margin = 2.0;                ///< of a mode's deviation over its size in the record
constexpr double band = std::numbers::sqrt2;  ///< a mode answers to what is below so many times its frequency
constexpr double least_share = 0.05;          ///< of an average mode's share in the sensors, for modes they hardly see
constexpr int linearisations = 4;
constexpr int stroke_steps = 20;

/// With two significant digits.
std::string rounded(double value) {
  std::ostringstream text;
  text << std::setprecision(2) << value;
  return text.str();
}

/// A connector displaced slowly from rest.
struct Stroke {
  double force = 0.0;
  VectorXd states;  ///< internal ones
};

/// Moves a connector to a deformation and holds it there: its force without the dashpots' part. The law sees steps, so
/// that its history goes along.
Stroke displaced(const Connector& connector, double deformation) {
  const auto& law = *connector.law;
  const Eigen::ArrayXXd parameters = connector.parameters.transpose().array();
  const auto states = static_cast<Index>(law.states().size());
  Eigen::ArrayXXd before = Eigen::ArrayXXd::Zero(1, states), after = before;
  Eigen::ArrayXd force(1), stiffness(1), damping(1), inertance(1);
  const Eigen::ArrayXd zero = Eigen::ArrayXd::Zero(1);
  const auto at = [&](int step) { return Eigen::ArrayXd::Constant(1, deformation * step / stroke_steps).eval(); };
  constexpr double duration = 1.0;  // slow: what depends on the rate fades
  const Eigen::ArrayXd rate = Eigen::ArrayXd::Constant(1, deformation / (duration * stroke_steps));
  for (int step = 1; step <= stroke_steps; ++step) {
    law.respond({duration, parameters, at(step - 1), rate, before, at(step), rate, zero},
                {force, stiffness, damping, inertance, after});
    before = after;
  }
  law.respond({0.0, parameters, at(stroke_steps), zero, before, at(stroke_steps), zero, zero},
              {force, stiffness, damping, inertance, after});
  return {force[0], before.row(0).matrix().transpose()};
}

/// Mean of the secants to both sides; 0 where the law gives none.
double secant_stiffness(const Connector& connector, double amplitude) {
  const double stiffness =
      (displaced(connector, amplitude).force - displaced(connector, -amplitude).force) / (2.0 * amplitude);
  return std::isfinite(stiffness) ? stiffness : 0.0;
}

/// Accelerations of the sensors below each frequency, from what they measure: mean square, sensor by sensor.
class SensorAccelerations {
public:
  SensorAccelerations(const AugmentedModelSetup& setup, const Record& record) {
    std::vector<OutputDescription> outputs;
    for (const auto& sensor : setup.sensors) outputs.push_back(sensor.output);
    const OutputMap map = make_outputs(*setup.model, outputs);
    rows_ = MatrixXd(map.displacement + map.velocity + map.acceleration);
    for (std::size_t j = 0; j < setup.sensors.size(); ++j) {
      const auto row = static_cast<Index>(j);
      const auto moves = [&](const SparseRows& rows) { return rows.row(row).norm() > 0.0; };
      const int derivatives = moves(map.displacement) ? 2 : moves(map.velocity) ? 1 : 0;
      const VectorXd channel = record.values.row(record.find(setup.sensors[j].name)).transpose();
      spectra_.emplace_back(channel, record.sample_rate, derivatives);
    }
  }

  [[nodiscard]] const MatrixXd& rows() const { return rows_; }
  /// Sum over the sensors that see a motion.
  [[nodiscard]] double mean_square_below(double frequency) const {
    double sum = 0.0;
    for (std::size_t j = 0; j < spectra_.size(); ++j)
      if (rows_.row(static_cast<Index>(j)).norm() > 0.0) sum += spectra_[j].mean_square_below(frequency);
    return sum;
  }

private:
  MatrixXd rows_;
  std::vector<CumulativeSpectrum> spectra_;
};

/// The motion of a model that is as large as a record, in the modes of its linearisation.
class MotionOfRecord {
public:
  MotionOfRecord(const AugmentedModelSetup& setup, const Record& record, const MatrixXd& inputs)
      : setup_(setup), system_(setup.model->system()), sensors_(setup, record) {
    const auto n_u = system_.input_count();
    for (Index i = 0; i < 2 * n_u; ++i)
      inputs_.emplace_back(VectorXd(inputs.row(i).transpose()), record.sample_rate, 0, CumulativeSpectrum::Mean::kept);
    slowest_ = 2.0 * std::numbers::pi * record.sample_rate / static_cast<double>(record.samples());
    amplitudes_ = VectorXd::Zero(system_.connector_count());
    for (int i = 0; i < linearisations; ++i) linearise();
  }

  [[nodiscard]] bool seen() const { return sensors_.rows().norm() > 0.0; }
  [[nodiscard]] const MatrixXd& displacement() const { return displacement_; }
  [[nodiscard]] const MatrixXd& velocity() const { return velocity_; }
  [[nodiscard]] const VectorXd& deformations() const { return amplitudes_; }

private:
  void linearise() {
    MatrixXd stiffness(system_.stiffness);
    for (Index j = 0; j < amplitudes_.size(); ++j) {
      const auto& connector = system_.connectors[static_cast<std::size_t>(j)];
      const double amplitude = amplitudes_[j] > 0.0 ? amplitudes_[j] : smallest_amplitude;
      const double k = secant_stiffness(connector, amplitude);
      stiffness += k * connector.deformation * connector.deformation.transpose();
      pull_.conservativeResize(system_.size(), amplitudes_.size());
      pull_.col(j) = k * connector.deformation;
    }
    const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> eigen(stiffness, MatrixXd(system_.mass));
    shapes_ = eigen.eigenvectors();
    frequencies_ = eigen.eigenvalues().cwiseMax(slowest_ * slowest_).cwiseSqrt();
    set_covariances();
    for (Index j = 0; j < amplitudes_.size(); ++j) {
      const VectorXd& b = system_.connectors[static_cast<std::size_t>(j)].deformation;
      amplitudes_[j] = std::sqrt(std::max(0.0, b.dot(displacement_ * b)));
    }
  }

  void set_covariances() {
    const VectorXd accelerations = modal_accelerations();
    const VectorXd speeds = accelerations.cwiseQuotient(frequencies_), strokes = speeds.cwiseQuotient(frequencies_);
    displacement_ = shapes_ * strokes.cwiseAbs2().asDiagonal() * shapes_.transpose();
    velocity_ = shapes_ * speeds.cwiseAbs2().asDiagonal() * shapes_.transpose();
    for (Index i = 0; i < system_.input_count(); ++i) {
      const VectorXd of_value = static_response(i, 0), of_rate = static_response(i, 1);
      displacement_ += of_value * of_value.transpose();
      velocity_ += of_rate * of_rate.transpose();
    }
  }

  [[nodiscard]] double limit(Index mode) const { return band * frequencies_[mode] / (2.0 * std::numbers::pi); }

  /// The modes below a frequency share the sensors' mean square there equally.
  [[nodiscard]] VectorXd modal_accelerations() const {
    const VectorXd shares = (sensors_.rows() * shapes_).colwise().squaredNorm().transpose();
    VectorXd accelerations(frequencies_.size());
    for (Index r = 0; r < accelerations.size(); ++r) {
      double share = 0.0;
      for (Index i = 0; i < shares.size(); ++i)
        if (frequencies_[i] <= band * frequencies_[r]) share += std::max(shares[i], least_share * shares.mean());
      accelerations[r] = share > 0.0 ? margin * std::sqrt(sensors_.mean_square_below(limit(r)) / share) : 0.0;
    }
    return accelerations;
  }

  /// Static response of all modes to the part of a known input, or of its rate, that is slower than each.
  [[nodiscard]] VectorXd static_response(Index input, Index derivative) const {
    const auto& treatments = setup_.options.inputs;
    const bool known = treatments.empty() || treatments[static_cast<std::size_t>(input)].model == InputModel::known;
    if (!known) return VectorXd::Zero(system_.size());
    VectorXd force = system_.inputs[static_cast<std::size_t>(input)].value;
    for (Index j = 0; j < amplitudes_.size(); ++j)
      force += pull_.col(j) * system_.connectors[static_cast<std::size_t>(j)].base[input];
    const auto& spectrum = inputs_[static_cast<std::size_t>(derivative * system_.input_count() + input)];
    VectorXd response = shapes_.transpose() * force;
    for (Index r = 0; r < response.size(); ++r)
      response[r] *= std::sqrt(spectrum.mean_square_below(limit(r))) / (frequencies_[r] * frequencies_[r]);
    return shapes_ * response;
  }

  static constexpr double smallest_amplitude = 1e-9;  ///< [m], of the first linearisation

  const AugmentedModelSetup& setup_;
  const LocallyNonlinearSystem& system_;
  SensorAccelerations sensors_;
  std::vector<CumulativeSpectrum> inputs_;  ///< values, then rates
  double slowest_ = 0.0;                    ///< [rad/s]
  VectorXd amplitudes_;                     ///< of the connectors' deformations
  MatrixXd pull_;                           ///< force per displacement of a connector's base, n x m
  MatrixXd shapes_, displacement_, velocity_;
  VectorXd frequencies_;  ///< [rad/s]
};

/// Root mean square of each channel, without its spikes.
VectorXd sizes_of(const MatrixXd& values) {
  const MatrixXd kept = without_isolated_values(values);
  VectorXd sizes(values.rows());
  for (Index j = 0; j < sizes.size(); ++j) sizes[j] = rms_of_present(kept.row(j).transpose());
  return sizes;
}

/// Whether these are innovations of a filter that is right to be sure of rest.
bool looks_like_rest(const EstimationResult& result, const VectorXd& sizes) {
  if (result.failure) return false;
  double sum = 0.0, degrees = 0.0, largest = 0.0;
  for (Index k = 0; k < result.nis.size(); ++k) {
    if (!std::isfinite(result.nis[k])) continue;
    sum += result.nis[k];
    degrees += result.measured[k];
  }
  for (Index j = 0; j < sizes.size(); ++j) {
    const auto innovation = result.innovation.row(j).array().abs();
    if (sizes[j] > 0.0)
      largest = std::max(largest, innovation.isFinite().select(innovation, 0.0).maxCoeff() / sizes[j]);
  }
  return largest <= large_innovation || degrees == 0.0 || sum <= large_nis * degrees ||
         sum <= chi_squared_quantile(certain, degrees);
}

/// Takes the value that is furthest from its prediction out of each channel where that is beyond any noise.
void set_largest_aside(const EstimationResult& result, MatrixXd& values) {
  const Index computed = std::min(result.innovation.cols(), values.cols());
  for (Index j = 0; j < values.rows(); ++j) {
    const auto ratio =
        (result.innovation.row(j).head(computed).array() / result.innovation_deviation.row(j).head(computed).array())
            .abs()
            .eval();
    Index at = 0;
    const double furthest = ratio.isFinite().select(ratio, 0.0).maxCoeff(&at);
    if (furthest > large_ratio) values(j, at) = std::numeric_limits<double>::quiet_NaN();
  }
}

}  // namespace

std::string explain(const RecordStart& start) {
  if (!start.moving) return start.reason;
  return "the structure moves at the first sample (" + start.reason +
         "): its initial state is unknown, with deviations from the record of up to " + rounded(start.displacement) +
         " m and " + rounded(start.velocity) + " m/s";
}

bool states_initial_motion(const EstimationSettings& settings) {
  return !settings.initial_state.empty() || settings.initial_state_from_record ||
         !settings.initial_connector_states.empty();
}

RecordStart start_by_first_samples(const AugmentedModel& augmented_model, const FilterInput& input,
                                   EstimationOptions options) {
  const Index samples = std::min(first_samples, input.measured.samples());
  const Index stride = input.input_stride(augmented_model.options().instants());
  FilterInput head{input.measured, input.inputs.leftCols((samples - 1) * stride + 1), input.noise};
  head.measured.values = input.measured.values.leftCols(samples).eval();
  options.passes = 1;
  const VectorXd sizes = sizes_of(input.measured.values);
  for (Index aside = 0;; ++aside) {
    const auto result = estimate(augmented_model, head, options);
    if (looks_like_rest(result, sizes))
      return {.spiked = aside > 0, .reason = "the structure is at rest at the first sample"};
    if (aside == samples / samples_for_a_spike)
      return {.moving = true, .reason = "its first samples are not those of rest"};
    set_largest_aside(result, head.measured.values);
  }
}

bool set_moving_start(const AugmentedModelSetup& setup, const Record& record, const MatrixXd& inputs,
                      StatePrior& prior) {
  const MotionOfRecord motion(setup, record, inputs);
  if (!motion.seen()) return false;
  const Index n = setup.model->system().size();
  prior.motion_covariance = MatrixXd::Zero(2 * n, 2 * n);
  prior.motion_covariance.topLeftCorner(n, n) = motion.displacement();
  prior.motion_covariance.bottomRightCorner(n, n) = motion.velocity();
  Index state = 0;
  for (Index j = 0; j < setup.model->system().connector_count(); ++j) {
    const auto& connector = setup.model->system().connectors[static_cast<std::size_t>(j)];
    const VectorXd pulled = displaced(connector, motion.deformations()[j]).states;
    const VectorXd pushed = displaced(connector, -motion.deformations()[j]).states;
    for (Index i = 0; i < pulled.size(); ++i, ++state) {
      const double size = std::max(std::abs(pulled[i]), std::abs(pushed[i]));
      prior.connector_state_deviation[state] = std::isfinite(size) ? size : 0.0;
    }
  }
  return true;
}

}  // namespace kalfem
