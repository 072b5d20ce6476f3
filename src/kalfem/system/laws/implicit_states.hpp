#pragma once

#include <Eigen/Dense>

namespace kalfem {

/// Most internal states that a user-written law may have; fixed, so that their integration needs no allocation.
inline constexpr int max_internal_states = 8;

using StateVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, max_internal_states, 1>;
using StateMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, max_internal_states, max_internal_states>;

/// Deformation and rate of a connector at an instant.
struct ConnectorMotion {
  double d = 0.0;  ///< [m]
  double v = 0.0;  ///< [m/s]
};

/// Internal states at an interval's end with their derivatives by the motion there.
struct AdvancedStates {
  StateVector s, by_d, by_v;
  bool converged = true;
};

/// Rates s' = g(d, v, s) of a law's internal states at one point.
class StateRates {
public:
  virtual ~StateRates() = default;
  [[nodiscard]] virtual StateVector operator()(const ConnectorMotion& motion, const StateVector& s) const = 0;
};

/// Half the span of a central difference about x: relative, with a floor that is small against any deformation, rate or
/// state of engineering interest.
double difference_step(double x);

/// Integrates s' = g(d(t), v(t), s) over [0, h], motion linear in between, by the two-stage, second-order, L-stable
/// diagonally implicit Runge-Kutta method [Ale77], each stage by a damped Newton iteration with difference quotients.
/// Failure is a value: `converged` is false and the states are what was reached.
AdvancedStates advance_states(const StateRates& rates, double duration, const ConnectorMotion& begin,
                              const ConnectorMotion& end, const StateVector& s);

}  // namespace kalfem
