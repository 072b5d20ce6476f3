// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/api/estimate.hpp"

namespace kalfem {

/// An input at one instant: its value with its first and second time derivative. A force needs its value alone, an
/// accelerated base too; a moving ground acts through velocity and acceleration.
struct InputSample {
  double value = 0.0, rate = 0.0, acceleration = 0.0;
};

/// Mean and standard deviation of a quantity now.
struct PresentEstimate {
  double mean = 0.0, std = 0.0;
};

/// A filter that is moved from sample to sample by its caller, as a live system needs it:
///
///     OnlineFilter filter(structure, 1000.0, {.sensors = {...}, .unknowns = {...}});
///     filter.update(first_sample);
///     while (filter.usable() && next(inputs, y)) {
///       filter.predict(inputs);
///       filter.update(y);
///     }
///
/// The covariance moves in the modal coordinates of the linear part, where a step costs least. Where rounding makes it
/// indefinite there (close poles), the filter goes on in physical coordinates from the estimate before the step, with
/// the negative directions of its covariance taken off. A step costs more from then on.
///
/// Moved by predict() without arguments it gives the estimates of estimate() over the same record. One thread uses it
/// at a time.
class OnlineFilter {
public:
  /// `sample_rate` [Hz]: of predict(). `first`: the inputs at the first sample, in the order of their addition to the
  /// structure; if empty, those of its signals, or zero. Throws InvalidInput as estimate() does.
  OnlineFilter(const Structure& structure, double sample_rate, const EstimateOptions& options,
               const std::vector<InputSample>& first = {});
  OnlineFilter(OnlineFilter&&) noexcept;
  OnlineFilter& operator=(OnlineFilter&&) noexcept;
  ~OnlineFilter();

  /// Predicts to the next sample; inputs are linear between the samples. Returns false if the filter has stopped, see
  /// failure(). Throws InvalidInput if the number of inputs is not that of the structure, or if one is not finite.
  bool predict(const std::vector<InputSample>& inputs);
  /// The same from values alone, one an input. The rate and acceleration of a moved ground are the differences between
  /// the samples.
  bool predict_values(const Eigen::VectorXd& values);
  /// The inputs at the first sample, before its update(), where the constructor was not told.
  void start(const Eigen::VectorXd& values);
  /// The same with the signals of the structure. Throws InvalidInput if one of its inputs has none.
  bool predict();
  /// Conditions the estimate on a sample with one value per sensor; NaN is a missing value. Returns false if the filter
  /// has stopped. Throws InvalidInput if there is not one value for each sensor.
  bool update(const Eigen::VectorXd& measured);

  /// Whether the covariance had to leave the modal coordinates.
  [[nodiscard]] bool in_physical_coordinates() const;
  [[nodiscard]] double time() const;  ///< of the present sample, the first one at 0 [s]
  [[nodiscard]] bool usable() const { return !failure(); }
  [[nodiscard]] const std::optional<FilterStop>& failure() const;

  /// The unknowns now, without histories.
  [[nodiscard]] std::vector<ParameterEstimate> parameters() const;
  /// Look-up by the name of an unknown; throws InvalidInput if there is none.
  [[nodiscard]] PresentEstimate parameter(const std::string& name) const;
  /// "body.2.displacement", "body.2.velocity", or an output that was asked for. Throws InvalidInput where there is
  /// none.
  [[nodiscard]] PresentEstimate state(const std::string& name);
  /// Of the last update: measured minus predicted, and its normalised square. Not a number before the first one.
  [[nodiscard]] const Eigen::VectorXd& innovation() const;
  [[nodiscard]] double nis() const;

private:
  class Loop;
  std::unique_ptr<Loop> loop_;
};

}  // namespace kalfem
