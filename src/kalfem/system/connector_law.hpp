// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <limits>
#include <memory>
#include <string>
#include <vector>

namespace kalfem {

/// The values a physical parameter may take: any finite number, >= 0, > 0, in [0, 1], >= 1.
enum class Range { any, nonnegative, positive, fraction, at_least_one };

/// Name, unit and meaning of one parameter or internal state of a connector law.
struct LawQuantity {
  std::string name;
  std::string unit = {};
  std::string meaning = {};
  Range range = Range::any;
  /// NaN: the user must give it. An infinite default says that infinity is a sensible value (an absent stop).
  double default_value = std::numeric_limits<double>::quiet_NaN();
};

/// Signals of a law at many points, N x signals.
using LawSignals = Eigen::Map<const Eigen::ArrayXXd, 0, Eigen::OuterStride<>>;
inline LawSignals no_signals() { return {nullptr, 0, 0, Eigen::OuterStride<>(0)}; }

/// N independent points at which one connector is evaluated over an interval [0, h]; every array has N rows, so that a
/// law's inner loop runs over contiguous memory. Internal states are advanced from `begin_states` at the interval's
/// start to its end; h = 0 asks for the force at an instant (the states stay as they are, and so they are in the
/// tangents).
struct LawPoints {
  double duration = 0.0;                               ///< h [s]
  Eigen::Ref<const Eigen::ArrayXXd> parameters;        ///< N x parameters
  Eigen::Ref<const Eigen::ArrayXd> begin_deformation;  ///< d(0) [m]
  Eigen::Ref<const Eigen::ArrayXd> begin_rate;         ///< d'(0) [m/s]
  Eigen::Ref<const Eigen::ArrayXXd> begin_states;      ///< s(0), N x states
  Eigen::Ref<const Eigen::ArrayXd> deformation;        ///< d(h) [m]
  Eigen::Ref<const Eigen::ArrayXd> rate;               ///< d'(h) [m/s]
  Eigen::Ref<const Eigen::ArrayXd> acceleration;       ///< d''(h) [m/s^2]
  LawSignals begin_signals = no_signals();             ///< w(0), N x signals; none: they are zero
  LawSignals signals = no_signals();                   ///< w(h), linear in time in between
};

/// What a law answers at the interval's end; the caller owns and sizes the arrays, which must not overlap the points'.
struct LawResponse {
  Eigen::Ref<Eigen::ArrayXd> force;      ///< f [N]
  Eigen::Ref<Eigen::ArrayXd> stiffness;  ///< df/dd  [N/m], through the states too
  Eigen::Ref<Eigen::ArrayXd> damping;    ///< df/dd' [N s/m], through the states too
  Eigen::Ref<Eigen::ArrayXd> inertance;  ///< df/dd'' [kg]
  Eigen::Ref<Eigen::ArrayXXd> states;    ///< s(h), N x states
};

/// Force of a local nonlinear element as a function of its deformation and history,
///     f(h) = f(d(h), d'(h), d''(h), s(h), w(h); theta),     s(h) = s(0) + int_0^h s'(d, d', s, w; theta) dt
/// and of known signals w (a coil's voltage, a temperature, the time).
/// Positive force resists positive deformation. Laws are immutable and safe to share between threads.
class ConnectorLaw {
public:
  virtual ~ConnectorLaw() = default;

  [[nodiscard]] virtual std::string name() const = 0;
  [[nodiscard]] virtual const std::vector<LawQuantity>& parameters() const = 0;
  [[nodiscard]] virtual const std::vector<LawQuantity>& states() const = 0;
  /// Known functions of time that the law reads beside its motion.
  [[nodiscard]] virtual const std::vector<LawQuantity>& signals() const {
    static const std::vector<LawQuantity> none;
    return none;
  }
  /// Whether the force depends on d'': what no law reads need not be followed. A law that does not say counts as one
  /// that does.
  [[nodiscard]] virtual bool uses_acceleration() const { return true; }
  /// Whether respond() works on several points at once, so that a few more cost next to nothing.
  [[nodiscard]] virtual bool vectorised() const { return false; }
  /// Advances the states and evaluates force and tangents at every point. Does not allocate. Parameters outside their
  /// range, as sigma points of an unknown may have, give some force without failing; what is not finite gives NaN.
  virtual void respond(const LawPoints& points, LawResponse response) const = 0;
};

using ConnectorLawPtr = std::shared_ptr<const ConnectorLaw>;

}  // namespace kalfem
