#include "kalfem/system/laws/implicit_states.hpp"

#include <algorithm>
#include <cmath>

namespace kalfem {
namespace {

constexpr double weight = 0.29289321881345248;  ///< 1 - 1/sqrt(2), the L-stable choice

ConnectorMotion between(const ConnectorMotion& begin, const ConnectorMotion& end, double fraction) {
  return {begin.d + fraction * (end.d - begin.d), begin.v + fraction * (end.v - begin.v)};
}

StateMatrix rates_by_states(const StateRates& rates, const ConnectorMotion& at, StateVector s) {
  StateMatrix jacobian(s.size(), s.size());
  for (Eigen::Index j = 0; j < s.size(); ++j) {
    const double centre = s[j], step = difference_step(centre);
    s[j] = centre + step;
    jacobian.col(j) = rates(at, s);
    s[j] = centre - step;
    jacobian.col(j) = (jacobian.col(j) - rates(at, s)) / (2.0 * step);
    s[j] = centre;
  }
  return jacobian;
}

StateVector rates_by_deformation(const StateRates& rates, const ConnectorMotion& at, const StateVector& s) {
  const double step = difference_step(at.d);
  return (rates({at.d + step, at.v}, s) - rates({at.d - step, at.v}, s)) / (2.0 * step);
}

StateVector rates_by_rate(const StateRates& rates, const ConnectorMotion& at, const StateVector& s) {
  const double step = difference_step(at.v);
  return (rates({at.d, at.v + step}, s) - rates({at.d, at.v - step}, s)) / (2.0 * step);
}

/// One implicit stage s = base + w h g(motion, s).
struct Step {
  const StateRates& rates;
  ConnectorMotion motion;
  double step;  ///< w h [s]
  StateVector base;

  [[nodiscard]] StateVector residual(const StateVector& s) const { return s - base - step * rates(motion, s); }
  [[nodiscard]] Eigen::PartialPivLU<StateMatrix> factored_jacobian(const StateVector& s) const {
    const StateMatrix identity = StateMatrix::Identity(s.size(), s.size());
    return Eigen::PartialPivLU<StateMatrix>(identity - step * rates_by_states(rates, motion, s));
  }
};

/// Damped Newton iteration on the stage, from s and into s.
bool solve(const Step& section, StateVector& s) {
  constexpr int max_iterations = 50, max_halvings = 20;
  StateVector residual = section.residual(s);
  for (int iteration = 0; iteration < max_iterations; ++iteration) {
    StateVector correction = section.factored_jacobian(s).solve(residual);
    if (!correction.allFinite()) return false;
    const double old_norm = residual.norm();
    // Beyond rounding a smaller residual cannot be asked for: the correction itself tells that this is the end.
    const bool last = (correction.array().abs() <= 1e-12 * s.array().abs() + 1e-300).all();
    for (int halving = 0; halving <= max_halvings; ++halving, correction *= 0.5) {
      const StateVector trial = s - correction;
      residual = section.residual(trial);
      if (last || halving == max_halvings || residual.norm() < old_norm) {
        s = trial;
        break;
      }
    }
    if (last) return residual.allFinite();
  }
  return residual.norm() <= 1e-9 * s.norm();
}

}  // namespace

double difference_step(double x) { return std::max(6e-6 * std::abs(x), 1e-9); }

AdvancedStates advance_states(const StateRates& rates, double duration, const ConnectorMotion& begin,
                              const ConnectorMotion& end, const StateVector& s) {
  const double reach = (1.0 - weight) / weight;  // the first stage's share of the second, by its own increment
  AdvancedStates out;

  Step section{rates, between(begin, end, weight), weight * duration, s};
  StateVector middle = s;
  out.converged = solve(section, middle);
  const auto middle_jacobian = section.factored_jacobian(middle);
  // The stage's motion moves by `weight` for each unit of the motion at the end.
  const StateVector middle_by_d =
      middle_jacobian.solve(weight * section.step * rates_by_deformation(rates, section.motion, middle));
  const StateVector middle_by_v =
      middle_jacobian.solve(weight * section.step * rates_by_rate(rates, section.motion, middle));

  section.motion = end;
  section.base = s + reach * (middle - s);
  out.s = middle;
  out.converged = solve(section, out.s) && out.converged;
  const auto jacobian = section.factored_jacobian(out.s);
  out.by_d = jacobian.solve(reach * middle_by_d + section.step * rates_by_deformation(rates, end, out.s));
  out.by_v = jacobian.solve(reach * middle_by_v + section.step * rates_by_rate(rates, end, out.s));
  return out;
}

}  // namespace kalfem
