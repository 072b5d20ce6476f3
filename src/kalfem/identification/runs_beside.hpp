// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kalfem/estimation/fixed_gain_tangents.hpp"
#include "kalfem/identification/numbers_at.hpp"
#include "kalfem/identification/record_estimate.hpp"

namespace kalfem {

/// d(.)/d c_i of everything that a run of the mean gives.
struct NumberDerivative {
  std::optional<FixedGainMeans> means;  ///< nothing where there is no model beside the number
  bool by_run = false;                  ///< from a run beside the number, which has no tangent
};

/// Runs of one filter over its record, with a number changed that the problem holds fixed, of the mean
/// with the gains of the filter as it is.
class RunsBeside {
public:
  /// What is given stays alive. `problem`: with its substeps, and with numbers as they are `changed` in it. Throws
  /// InvalidInput where it makes no model.
  RunsBeside(EstimationProblemPtr problem, const AugmentedModelSetup& setup, const Record& record,
             const RecordEstimate& estimate, const RecordEstimateOptions& options, const ChangedNumbers& changed);

  [[nodiscard]] const FilterRun& filter() const { return filter_; }
  [[nodiscard]] const std::vector<FixedNumber>& numbers() const { return numbers_; }
  [[nodiscard]] const Eigen::VectorXd& stand_at() const { return stand_at_; }
  /// Whether the filter's model has tangents; otherwise each number takes a run.
  [[nodiscard]] bool carries_tangents() const { return has_tangents(*filter_.choice.augmented_model); }
  /// Filter steps that the filter's run, that of the mean and the derivatives by all numbers cost together, about.
  [[nodiscard]] double steps() const;
  /// Of the gains, and of the derivatives of the innovations by every number [byte].
  [[nodiscard]] double memory() const;

  /// The run with the numbers as they are. False where it fails.
  bool run_base(Gains gains);
  /// The numbers in groups, whose derivatives are independent of each other.
  [[nodiscard]] std::vector<std::vector<std::size_t>> groups() const;
  /// By one run with the tangents of all numbers of a group; by a run beside each number that has none, or all where
  /// the filter's linear part has unknowns. Monitored quantities of stated numbers only, which are in groups of their
  /// own.
  [[nodiscard]] std::vector<NumberDerivative> derivatives(const std::vector<std::size_t>& group) const;
  /// The same by two runs beside number i, `by` in its scale away on either side.
  [[nodiscard]] std::optional<FixedGainMeans> difference(std::size_t i, double by) const;

private:
  /// The model of a run, and what is added to what it is given.
  struct Change {
    EstimationProblemPtr problem;
    AugmentedModelSetup setup;
    Eigen::MatrixXd to_measured = {}, to_inputs = {};
  };

  void reduce_once();
  [[nodiscard]] bool follows_unknowns() const;
  [[nodiscard]] double value_with(std::size_t i, double change) const;
  [[nodiscard]] Change change_of(std::size_t i, double change) const;
  [[nodiscard]] Change change_of_parameter(const Parameter& parameter, double value) const;
  [[nodiscard]] Change change_of_signal(const FixedNumber& number, double change) const;
  [[nodiscard]] Eigen::MatrixXd added_to_sensor(Eigen::Index row, const FixedNumber& number) const;
  [[nodiscard]] Eigen::MatrixXd added_to_input(Eigen::Index input, bool delay) const;
  [[nodiscard]] std::optional<RunDerivative> tangent_of(std::size_t i) const;
  [[nodiscard]] OpenModel open(const Change& change, bool monitors) const;
  [[nodiscard]] std::optional<FixedGainMeans> quotient(std::size_t i, std::optional<FixedGainMeans> above,
                                                       const FixedGainMeans& below, double distance) const;
  [[nodiscard]] std::optional<FixedGainMeans> beside(std::size_t i, double change) const;
  [[nodiscard]] OutputMap monitored_by(const Change& change, bool monitors) const;
  [[nodiscard]] FilterRun run_of(const Change& change, std::optional<StateCoordinates> coordinates = {}) const;
  [[nodiscard]] std::optional<FixedGainMeans> run(const FilterRun& beside, const OutputMap& monitored) const;

  EstimationProblemPtr problem_;
  const Record& record_;
  const std::vector<OutputDescription>& monitored_;
  const AugmentedModelSetup& given_;
  std::vector<FixedNumber> numbers_;
  Eigen::VectorXd stand_at_;  ///< changes of the numbers in the problem
  StructureParts parts_;
  HeldElements held_;  ///< the numbers of finite elements
  std::optional<ParameterisedStructure> elements_;
  StructureAtParameters reduced_;
  AugmentedModelSetup base_setup_;
  FilterRun filter_;
  FilterRun base_run_;  ///< in physical coordinates
  OpenModel base_open_, base_open_monitored_;
  Gains gains_;
  FixedGainMeans base_;
};

/// ln L of the samples from `first` on, given those before.
double log_likelihood_from(const EstimationResult& result, Eigen::Index first);

}  // namespace kalfem
