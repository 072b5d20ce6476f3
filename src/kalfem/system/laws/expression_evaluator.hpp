#pragma once

#include <muParser.h>

#include <deque>
#include <memory>
#include <mutex>
#include <vector>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/system/laws/expression_law.hpp"
#include "kalfem/system/laws/implicit_states.hpp"

namespace kalfem {

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
