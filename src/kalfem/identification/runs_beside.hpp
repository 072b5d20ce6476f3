// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kalfem/estimation/fixed_gain.hpp"
#include "kalfem/identification/fixed_numbers.hpp"
#include "kalfem/identification/record_estimate.hpp"

namespace kalfem {

/// Runs of one filter over its record, with a number changed that the problem holds fixed: of the mean with the gains
/// of the filter as it is, and of the filter itself.
class RunsBeside {
public:
  /// What is given stays alive. `problem`: with its substeps. Throws InvalidInput where it makes no model.
  RunsBeside(EstimationProblemPtr problem, const AugmentedModelSetup& setup, const Record& record,
             const RecordEstimate& estimate, const RecordEstimateOptions& options);

  [[nodiscard]] const FilterRun& filter() const { return filter_; }
  [[nodiscard]] const std::vector<FixedNumber>& numbers() const { return numbers_; }
  [[nodiscard]] const std::vector<std::string>& left_out() const { return left_out_; }
  /// Of the gains, and of the derivatives of the innovations by every number [byte].
  [[nodiscard]] double memory() const;

  /// The run with the numbers as they are. False where it fails.
  bool run_base(Gains gains);
  /// d(.)/d c_i of everything that a run of the mean gives, by a run beside number i; monitored quantities of stated
  /// numbers only. Nothing where there is no model beside it.
  [[nodiscard]] std::optional<FixedGainMeans> derivative(std::size_t i) const;
  /// ln L of the filter with number i changed [its scale]; minus infinity where it stops.
  [[nodiscard]] double log_likelihood(std::size_t i, double change, const EstimationOptions& options) const;

private:
  /// The model of a run, and what is added to what it is given.
  struct Change {
    EstimationProblemPtr problem;
    AugmentedModelSetup setup;
    Eigen::MatrixXd to_measured = {}, to_inputs = {};
  };

  void leave_out_repeated_reductions();
  void reduce_once();
  [[nodiscard]] Change change_of(std::size_t i, double change) const;
  [[nodiscard]] Change change_of_parameter(const FixedNumber& number, double change) const;
  [[nodiscard]] Change change_of_signal(const FixedNumber& number, double change) const;
  [[nodiscard]] Eigen::MatrixXd added_to_sensor(Eigen::Index row, bool delay) const;
  [[nodiscard]] Eigen::MatrixXd added_to_input(Eigen::Index input, bool delay) const;
  [[nodiscard]] FilterRun run_of(const Change& change, std::optional<StateCoordinates> coordinates = {}) const;
  [[nodiscard]] std::optional<FixedGainMeans> run(const Change& change, bool monitors) const;

  EstimationProblemPtr problem_;
  const Record& record_;
  const std::vector<OutputDescription>& monitored_;
  const AugmentedModelSetup& given_;
  std::vector<FixedNumber> numbers_;
  std::vector<std::string> left_out_;
  StructureParts parts_;
  std::vector<StructureBinding> bindings_;  ///< of the numbers of finite elements
  Eigen::VectorXd of_elements_;             ///< their values
  std::optional<ParameterisedStructure> elements_;
  StructureAtParameters reduced_;
  AugmentedModelSetup base_setup_;
  FilterRun filter_;
  Gains gains_;
  FixedGainMeans base_;
};

}  // namespace kalfem
