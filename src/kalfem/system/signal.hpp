// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <limits>
#include <memory>
#include <vector>

namespace kalfem {

/// Value, first and second time derivative of an excitation, one row per instant: a base displacement acts through its
/// rate and its acceleration as well [unit, unit/s, unit/s^2].
using SignalSamples = Eigen::ArrayX3d;

/// An excitation as a function of time. Signals are immutable, safe to share between threads, and depend on the time
/// alone: the same instant gives the same numbers however the call is partitioned.
class Signal {
public:
  virtual ~Signal() = default;

  /// Row k holds value, first and second derivative at the time start + k * step, k = 0 ... count - 1.
  /// Throws InvalidInput unless start is finite, step positive and count >= 0, and where the signal is not known there.
  [[nodiscard]] virtual SignalSamples sample(double start, double step, Eigen::Index count) const = 0;

  /// Whether the signal is known on the whole of [begin, end]; formulas are, records may not be.
  [[nodiscard]] virtual bool covers(double begin, double end) const {
    (void)begin, (void)end;
    return true;
  }

  /// Until when values between samples follow from the samples [s]: behind it they rest on how a record is taken to go
  /// on beyond its last sample. Of formulas for ever.
  [[nodiscard]] virtual double determined_until() const { return std::numeric_limits<double>::infinity(); }
};

/// A signal by a formula that gives each instant by itself.
class FormulaSignal : public Signal {
public:
  [[nodiscard]] SignalSamples sample(double start, double step, Eigen::Index count) const final;

private:
  /// Value, first and second derivative.
  [[nodiscard]] virtual Eigen::Array<double, 1, 3> at(double time) const = 0;
};

using SignalPtr = std::shared_ptr<const Signal>;

/// Throws InvalidInput unless start is finite, step is positive and finite, and count >= 0.
void check_sampling(double start, double step, Eigen::Index count);

/// factor * signal.
SignalPtr scaled(SignalPtr signal, double factor);

/// The sum of the signals, zero for none.
SignalPtr sum(std::vector<SignalPtr> signals);

/// signal(t - delay): what the rear axle meets when the front axle met `signal`, with delay = wheelbase / speed [s].
SignalPtr delayed(SignalPtr signal, double delay);

}  // namespace kalfem
