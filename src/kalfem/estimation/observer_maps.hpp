#pragma once

#include <memory>

#include "kalfem/estimation/observer.hpp"
#include "kalfem/estimation/partially_linear_map.hpp"
#include "kalfem/system/connector_forces.hpp"

namespace kalfem {

/// Transition of the augmented state over one sample interval. Channels in: connector motion at the begin (3m) and, as far
/// as the linear part gives it, at the end (3m), internal states, unknowns. Channels out: forces at begin and end, internal
/// states at the end.
class TransitionMap final : public PartiallyLinearMap {
 public:
  explicit TransitionMap(const Observer& observer);

  /// Inputs [r; r'; r''] at the begin and the end of the interval.
  void set_inputs(const Eigen::Ref<const Eigen::VectorXd>& begin, const Eigen::Ref<const Eigen::VectorXd>& end);
  bool evaluate(const Eigen::ArrayXXd& in, Eigen::ArrayXXd& out) override;

 private:
  const Observer* observer_;
  ConnectorForces begin_, end_;
  Eigen::MatrixXd begin_force_motion_;  ///< connector motion at the end per force at the begin, 3m x m
  Eigen::VectorXd drive_;
};

/// Outputs at an instant as a function of the augmented state, through the connector forces of that instant. Channels in:
/// connector motion without the forces (3m), internal states, unknowns. Channels out: forces.
class InstantMap final : public PartiallyLinearMap {
 public:
  InstantMap(const Observer& observer, LinearOutput output);

  void set_inputs(const Eigen::Ref<const Eigen::VectorXd>& inputs);
  /// Only these rows of the output from now on (samples that are missing are left out).
  void select_rows(const std::vector<Eigen::Index>& rows);
  bool evaluate(const Eigen::ArrayXXd& in, Eigen::ArrayXXd& out) override;

 private:
  const Observer* observer_;
  LinearOutput all_;
  Eigen::MatrixXd input_;
  ConnectorForces forces_;
};

}  // namespace kalfem
