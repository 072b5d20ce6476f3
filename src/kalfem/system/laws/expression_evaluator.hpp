#pragma once

#include <Eigen/Dense>
#include <deque>
#include <memory>
#include <mutex>
#include <vector>

#include <muParser.h>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/system/laws/expression_law.hpp"

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

/// The compiled expressions of one law with the variables that they read. Belongs to one thread at a time.
class ExpressionEvaluator final : public StateRates {
public:
  /// Compiles; the options have been found free of issues.
  explicit ExpressionEvaluator(const ExpressionLawOptions& options);
  ExpressionEvaluator(const ExpressionEvaluator&) = delete;
  ExpressionEvaluator& operator=(const ExpressionEvaluator&) = delete;

  void set_parameter(std::size_t index, double value) { parameters_[index] = value; }
  [[nodiscard]] double force(const ConnectorMotion& motion, double acceleration, const StateVector& s) const;
  [[nodiscard]] StateVector operator()(const ConnectorMotion& motion, const StateVector& s) const override;

private:
  void set(const ConnectorMotion& motion, const StateVector& s) const;

  // The parsers read these through pointers.
  mutable double x_ = 0.0, v_ = 0.0, a_ = 0.0;
  mutable StateVector states_;
  std::vector<double> parameters_;
  mu::Parser force_;
  std::deque<mu::Parser> rates_;
};

/// Every problem of the options' names and expressions.
std::vector<Issue> find_issues(const ExpressionLawOptions& options);

/// Whether `a` stands in the expression for the force; the options have been found free of issues.
bool force_mentions_acceleration(const ExpressionLawOptions& options);

/// Evaluators for threads to borrow: muParser's parsers may be used by one thread at a time.
class EvaluatorPool {
public:
  explicit EvaluatorPool(ExpressionLawOptions options) : options_(std::move(options)) { give_back(make()); }

  std::unique_ptr<ExpressionEvaluator> borrow();
  void give_back(std::unique_ptr<ExpressionEvaluator> evaluator);

private:
  [[nodiscard]] std::unique_ptr<ExpressionEvaluator> make() const {
    return std::make_unique<ExpressionEvaluator>(options_);
  }

  ExpressionLawOptions options_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<ExpressionEvaluator>> idle_;
};

}  // namespace kalfem
