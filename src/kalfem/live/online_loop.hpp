// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/base/binary_archive.hpp"
#include "kalfem/estimation/failure.hpp"
#include "kalfem/estimation/filter_setup.hpp"
#include "kalfem/live/filter_problem.hpp"
#include "kalfem/live/fixed_lag.hpp"
#include "kalfem/live/health_spans.hpp"
#include "kalfem/live/innovation_window.hpp"
#include "kalfem/live/last_consistent.hpp"
#include "kalfem/live/live_state.hpp"
#include "kalfem/live/online_options.hpp"
#include "kalfem/live/sensor_gate.hpp"

namespace kalfem {

/// A filter with its model and present state, moved from sample to sample. move() sets the inputs of an interval and
/// predicts over it. update() conditions on the sensors and, once the unknowns of the linear part have moved far
/// enough, relinearises the model. After a stop both return false and change nothing.
///
/// With gates, SensorGate decides before each update which sensors it learns from. Where it blames the filter, or where
/// innovations that were consistent are no longer, the filter's deviations are widened; where that does not help, and
/// where the filter stops, it begins anew from LastConsistent.
class OnlineLoop {
public:
  /// Throws InvalidInput as make_filter_run() does.
  OnlineLoop(FilterProblem problem, const OnlineOptions& options);

  /// The inputs at the present sample, [r; r'; r''] one after the other, 3 n_u.
  void set_inputs(Eigen::VectorXd inputs) { inputs_ = std::move(inputs); }
  [[nodiscard]] const Eigen::VectorXd& inputs() const { return inputs_; }

  /// To the next sample, with inputs that are linear up to it, 3 n_u.
  bool move_to(const Eigen::VectorXd& inputs);
  /// To the next sample, with the inputs at its instants, 3 n_u x (instants + 1).
  bool move_along(const Eigen::MatrixXd& inputs);
  bool update(const Eigen::VectorXd& measured);

  /// Mean and standard deviation of a motion or an output; throws InvalidInput where there is none of that name.
  [[nodiscard]] PresentEstimate observe(const std::string& name);
  /// Names that observe() knows, in its order, and all of them at once.
  [[nodiscard]] std::vector<std::string> observed() const;
  [[nodiscard]] std::vector<PresentEstimate> observe_all();
  [[nodiscard]] PresentParameter parameter(std::size_t i) const;
  /// Of the sample OnlineOptions::lag before the present one, or the first one that the present estimate follows from;
  /// nothing without a lag.
  [[nodiscard]] std::optional<SmoothedEstimate> smoothed();
  /// The unknowns' part of the estimate, in the coordinates of the state, one row for each of unknown_options().
  [[nodiscard]] Gaussian unknown_states() const;
  [[nodiscard]] const std::vector<UnknownParameter>& unknown_options() const { return model_->options().unknowns; }
  [[nodiscard]] std::size_t unknowns() const { return model_->options().unknowns.size(); }
  [[nodiscard]] const std::vector<Sensor>& sensors() const { return made_.setup.sensors; }
  [[nodiscard]] bool in_physical_coordinates() const;

  [[nodiscard]] Eigen::Index instants() const { return model_->options().instants(); }
  [[nodiscard]] double step() const { return step_; }  ///< from sample to sample [s]
  [[nodiscard]] long sample() const { return sample_; }
  [[nodiscard]] double time() const { return static_cast<double>(sample_) * step_; }
  [[nodiscard]] const std::optional<FilterStop>& failure() const { return failure_; }
  [[nodiscard]] const Eigen::VectorXd& innovation() const { return innovation_; }
  [[nodiscard]] double nis() const { return nis_; }
  [[nodiscard]] ConsistencySummary consistency() const { return window_.consistency(); }
  /// Reasons of the window, and of the sensors that are left out.
  [[nodiscard]] const Verdict& verdict() const { return verdict_; }
  [[nodiscard]] FilterCondition condition() const;
  [[nodiscard]] SpanHealth health(HealthSpan span) const { return health_.of(span); }
  /// Sample at which its deviations were last widened, or at which it last began anew; -1: never.
  [[nodiscard]] long changed() const { return changed_; }
  /// The latest events; none without gates.
  [[nodiscard]] const EventLog& log() const { return gate_.log(); }

  /// All that later steps depend on, to an archive or from it. take_up() makes the model anew where it has been
  /// relinearised; after DamagedArchive the loop is not to be used.
  void keep(ArchiveWriter& archive) const;
  void take_up(ArchiveReader& archive);

private:
  template <class SetInputs>
  bool move(const SetInputs& set_inputs, const Eigen::VectorXd& next);
  /// Makes a step of the filter; where the covariance has lost its sign in modal coordinates, once more in physical
  /// ones. A step that fails leaves the estimate as it was.
  template <class Step>
  bool went_on(const Step& step);
  bool stop_unless_usable(FilterOutcome outcome);
  void gate_channels(const Eigen::VectorXd& measured);
  [[nodiscard]] bool has_become_wrong();
  void hold_at_prior();
  void doubt_itself(const std::string& why);
  void was_changed(FilterEventKind how, const std::string& text);
  bool begin_anew(const std::string& why);
  void form_verdict();
  void renew_verdict();
  /// Carries the estimate over to a model in physical coordinates; false where it stands in these already or is not
  /// finite.
  bool use_physical_coordinates();
  [[nodiscard]] std::shared_ptr<const AugmentedModel> run_start_model(bool physical) const;
  [[nodiscard]] std::shared_ptr<const AugmentedModel> about_the_estimate() const;
  [[nodiscard]] ModelPlace place() const;
  [[nodiscard]] std::shared_ptr<const AugmentedModel> model_at(const ModelPlace& place) const;
  [[nodiscard]] Gaussian estimate() const { return {setup_->filter->mean(), setup_->filter->covariance()}; }
  /// Values and deviations of the unknowns of the linear part, now or by their prior.
  [[nodiscard]] LinearEstimate linear_estimate(bool prior) const;
  [[nodiscard]] PresentParameter parameter_of(std::size_t i, double state, double deviation) const;
  bool linearise_where_it_moved();
  static void transfer(auto& self, auto& archive);

  FilterProblem made_;
  double step_;  ///< [s]
  EstimationOptions options_;
  std::shared_ptr<const AugmentedModel> model_;  ///< at the start of the run
  std::unique_ptr<FilterSetup> setup_;
  std::vector<Eigen::Index> linear_unknowns_;
  LinearEstimate linearised_about_;
  bool relinearised_ = false;        ///< whether the model of `setup_` is not `model_` itself
  Eigen::VectorXd prior_deviation_;  ///< of the unknowns, as states
  Eigen::MatrixXd noise_;
  Eigen::VectorXd inputs_;  ///< at the present sample
  Eigen::VectorXd innovation_;
  double nis_;
  long sample_ = 0;
  std::optional<FilterStop> failure_;
  InnovationWindow window_;
  Verdict verdict_;
  HealthSpans health_;

  FixedLag lag_{0, 0, {}};
  GateOptions gates_;
  bool gated_;
  SensorGate gate_;
  Eigen::VectorXd taken_;  ///< the measured values less those that the gate refuses
  Innovation expected_;
  LastConsistent last_consistent_;
  long changed_ = -1;            ///< sample at which the filter was last widened or begun anew
  bool was_consistent_ = false;  ///< since it last was changed
  int unusable_ = 0;             ///< samples for which the window has been
  long seen_changes_ = 0;        ///< of the gate
};

}  // namespace kalfem
