// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/identification/estimation_problem.hpp"
#include "kalfem/identification/parameterised_structure.hpp"
#include "kalfem/records/record.hpp"

namespace kalfem {

/// Some unknowns of a problem, by name, whose values theta come from outside: no filter and no search estimates them.
/// Immutable; it shares the problem.
class NamedUnknowns {
public:
  /// `first`: values at which finite elements are reduced, in their own units; empty: the initial values. Throws
  /// InvalidInput with every name that is unknown or doubled or whose unknown drifts, where a first value is not
  /// admissible, and where another unknown of the linear part would have to be set together with a finite-element
  /// parameter among them.
  NamedUnknowns(EstimationProblemPtr problem, std::vector<std::string> names,
                const std::optional<Eigen::VectorXd>& first = {});

  [[nodiscard]] const std::vector<std::string>& names() const { return names_; }
  [[nodiscard]] const Eigen::VectorXd& first() const { return first_; }

  /// The problem with theta in its structure, without the unknowns that these are. Those without a state all stay.
  /// Throws InvalidInput where a number makes no finite element; couple() finds the rest.
  [[nodiscard]] EstimationProblemPtr problem_at(const Eigen::VectorXd& theta) const;
  /// Of all the problem's unknowns without a state: those named at theta, the others at their initial values.
  [[nodiscard]] Eigen::VectorXd likelihood_values(const Eigen::VectorXd& theta) const;
  /// Takes the named sensor offsets off a record of the corrected sensors.
  void subtract_offsets(const Eigen::VectorXd& theta, Record& record) const;
  /// A record of ideal sensors as the sensors with these offsets, gains and delays give it, and with the noise of those
  /// whose noise is unknown.
  [[nodiscard]] Record as_recorded(const Eigen::VectorXd& theta, Record ideal) const;
  /// Whether every value is finite, no gain zero, no noise negative and no sensor's zero.
  [[nodiscard]] bool admissible(const Eigen::VectorXd& theta) const;
  /// What the record's unit is of the corrected one, one a channel: the sensor's gain.
  [[nodiscard]] Eigen::VectorXd gains(const Eigen::VectorXd& theta, const std::vector<Sensor>& sensors) const;

private:
  struct Place {
    Eigen::Index of_theta = 0;
    std::size_t index = 0;  ///< among those of its kind in the problem
  };
  void find_places();
  void check_linear_part() const;
  void reduce_finite_elements();

  EstimationProblemPtr problem_;
  std::vector<std::string> names_;
  Eigen::VectorXd first_;
  EstimationProblem remaining_;  ///< without the unknowns
  std::vector<StructureBinding> bindings_;
  std::vector<Place> offsets_, likelihood_unknowns_;
  std::shared_ptr<const ParameterisedStructure> finite_elements_;  ///< where some are among the bindings
  StructureAtParameters reduced_;                                  ///< at the first values
};

}  // namespace kalfem
