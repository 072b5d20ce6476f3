// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <optional>

#include "kalfem/base/binary_archive.hpp"
#include "kalfem/base/invalid_input.hpp"
#include "kalfem/estimation/smoother/step_linearisation.hpp"

namespace kalfem {

/// Which model of a structure a filter works with, so that it can be made anew.
struct ModelPlace {
  bool physical = false;      ///< in physical coordinates
  bool relinearised = false;  ///< about `about`, otherwise that of the run's start
  LinearEstimate about = {};  ///< the unknowns of the linear part
};

/// A sample as all samples so far tell it.
struct SmoothedSample {
  long sample = 0;
  Eigen::VectorXd unknowns, unknowns_deviation;  ///< in the coordinates of the state
  Eigen::VectorXd outputs, outputs_deviation;    ///< monitored; not a number where they cannot be evaluated
};

/// An issue at `place` where the covariances of a lag's samples, of n states each, need more than 4 GB.
void check_lag(Eigen::Index lag, Eigen::Index states, const SourceLocation& place, IssueList& issues);

/// Fixed-lag smoother of a filter that is moved from sample to sample: the estimate of sample k - N given all samples
/// up to k. It keeps the linearisations and estimates of the latest N + 1 samples; each call of smoothed() passes the
/// adjoint of the fixed-interval smoother (Bryson and Frazier) back over them. So it is the estimate that smooth()
/// gives of sample k - N over the record that ends with sample k. With N = 0 every call does nothing.
///
/// After begin() there is nothing from before: until N samples have passed, the estimate is that of the first one.
class FixedLag {
public:
  /// `states`: n. Throws InvalidInput as check_lag() says.
  FixedLag(Eigen::Index lag, Eigen::Index states, EstimationOptions options);

  /// The model from now on. The estimate of the filter before stood in that of `before`.
  void use(const ModelPlace& place, const FilterSetup& setup);
  /// The filter's estimate does not follow from the samples before: it was given or widened.
  void begin(const FilterSetup& setup, long sample, const Eigen::VectorXd& inputs);

  void before_prediction(const FilterSetup& setup);
  /// `inputs`: [r; r'; r''] at the sample, for the monitored quantities.
  void after_prediction(FilterSetup& setup, long sample, const Eigen::VectorXd& inputs);
  void before_update(const FilterSetup& setup) { before_prediction(setup); }
  void after_update(FilterSetup& setup, const Innovation& innovation, long sample, const Eigen::VectorXd& inputs);

  /// Null with N = 0, and before the first sample.
  [[nodiscard]] const SmoothedSample* smoothed();

  /// All that later samples depend on. `model_at` makes a model anew.
  void keep(ArchiveWriter& archive) const;
  using ModelAt = std::function<std::shared_ptr<const AugmentedModel>(const ModelPlace&)>;
  void take_up(ArchiveReader& archive, const ModelAt& model_at);

private:
  struct Model {
    ModelPlace place;
    std::shared_ptr<const AugmentedModel> augmented_model;
    std::shared_ptr<const TransposedMap> transition;
  };
  /// A prediction, an update, or one after the other.
  struct Step {
    long sample = 0;
    std::shared_ptr<const Model> model;
    LinearisedStep transition;  ///< without a map where none leads here
    LinearisedMeasurement measurement;
    Gaussian estimate;            ///< behind both
    Eigen::MatrixXd coordinates;  ///< x of the next model = T x; empty where it stayed
    Eigen::VectorXd inputs;
  };

  Step& add(const FilterSetup& setup, long sample, const Eigen::VectorXd& inputs);
  [[nodiscard]] SmoothedSample sample_of(const Step& step, const Adjoint& adjoint);
  [[nodiscard]] bool smooth_monitored(const Step& step, const Adjoint& adjoint, SmoothedSample& sample);
  static void transfer(auto& step, auto& archive);

  Eigen::Index lag_;
  EstimationOptions options_;
  StepLinearisation linearisation_;
  ArgumentMoments moments_;
  std::shared_ptr<const Model> model_;
  std::deque<Step> steps_;
  Gaussian before_;
  std::optional<SmoothedSample> smoothed_;  ///< until the next step
};

}  // namespace kalfem
