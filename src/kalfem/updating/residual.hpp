// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <exception>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/base/interruption.hpp"
#include "kalfem/base/worker_pool.hpp"

namespace kalfem {

/// A parameter that the updating changes.
struct UpdatingParameter {
  std::string name;                                         ///< "frame.rails.thickness"
  std::string unit;                                         ///< SI
  double initial = 0.0;                                     ///< start and, with a prior, its mean
  double lower = -std::numeric_limits<double>::infinity();  ///< initial lies between the bounds
  double upper = std::numeric_limits<double>::infinity();
  double deviation = std::numeric_limits<double>::infinity();  ///< standard deviation of the prior; infinite: no prior

  /// A step of this size changes the parameter noticeably: |initial|, or the width of the bounds where it is 0, or 1.
  [[nodiscard]] double scale() const;
};

/// Initial values, one a parameter.
Eigen::VectorXd initial_values(const std::vector<UpdatingParameter>& parameters);

/// Differences of model and measurement at one point theta of the parameter space.
struct ResidualValue {
  Eigen::VectorXd
      values;  ///< r: (model - measurement) / standard deviation, so that |r|^2 is about its length in truth
  Eigen::MatrixXd jacobian;  ///< dr/dtheta in the parameters' own units, size x parameters; 0 x 0 where not asked for
};

/// Which rows of a residual may have errors in common, for statistics that do not take rows as independent.
struct RowLayout {
  /// By row, from 0: rows of one step (an instant, a frequency line, a mode) are taken together.
  std::vector<Eigen::Index> step;
  bool ordered = false;  ///< neighbouring steps are correlated too: along time or frequency
  /// By row, from 0: parts of the measurement that repeat it under other conditions (sensors, places of the force);
  /// empty where there are none.
  std::vector<Eigen::Index> part;
  std::string steps, parts;  ///< in words, plural: "samples", "sensors"
};

/// The gain of a channel that a residual compares: of a sensor, or of what measures the input.
struct ComparedGain {
  std::string name;  ///< "a3.gain"
  bool of_input = false;

  bool operator==(const ComparedGain&) const = default;
};

/// A comparison of a model with measurements, as a function of the parameters. Evaluations may run in several threads.
class Residual {
public:
  virtual ~Residual() = default;

  [[nodiscard]] virtual std::string name() const = 0;
  /// Length of r, the same everywhere.
  [[nodiscard]] virtual Eigen::Index size() const = 0;
  /// Unless a residual knows better, every row is a step of its own, without order.
  [[nodiscard]] virtual RowLayout layout() const;
  /// Nothing where the model has no response there (a negative stiffness): an optimiser then takes a shorter step.
  [[nodiscard]] virtual std::optional<ResidualValue> evaluate(const Eigen::VectorXd& parameters,
                                                              bool with_jacobian) const = 0;
  /// Gains on which what was measured depends.
  [[nodiscard]] virtual std::vector<ComparedGain> gains() const { return {}; }
  /// dr / d gain of each, size x gains, with the channels as the model has them: recorded ones hold their noise, too.
  /// Nothing where the model has no response.
  [[nodiscard]] virtual std::optional<Eigen::MatrixXd> by_gains(const Eigen::VectorXd& parameters) const;
};
using ResidualPtr = std::shared_ptr<const Residual>;

/// Rows in equal series one after the other, one a sensor, with a sample in each step.
RowLayout layout_of_series(Eigen::Index samples, Eigen::Index series);

/// Several residuals of one set of parameters, r = [sqrt(w_1) r_1; sqrt(w_2) r_2; ...].
class ResidualSum final : public Residual {
public:
  struct Term {
    ResidualPtr residual;
    double weight = 1.0;  ///< w >= 0
  };
  explicit ResidualSum(std::vector<Term> terms) : terms_(std::move(terms)) {}

  [[nodiscard]] std::string name() const override { return "sum"; }
  [[nodiscard]] Eigen::Index size() const override;
  [[nodiscard]] std::optional<ResidualValue> evaluate(const Eigen::VectorXd& parameters,
                                                      bool with_jacobian) const override;
  [[nodiscard]] const std::vector<Term>& terms() const { return terms_; }

private:
  std::vector<Term> terms_;
};

/// A matrix whose columns cost much and do not depend on each other, column(i) -> std::optional<Eigen::VectorXd>, made
/// in several threads. Nothing where a column is missing; the first exception of a column is thrown again.
template <class Column>
std::optional<Eigen::MatrixXd> parallel_columns(Eigen::Index rows, Eigen::Index columns, int threads,
                                                const Column& column) {
  Eigen::MatrixXd matrix(rows, columns);
  std::vector<char> missing(static_cast<std::size_t>(columns), 0);
  std::vector<std::exception_ptr> thrown(static_cast<std::size_t>(columns));
  WorkerPool pool(std::max(1, std::min(threads, static_cast<int>(columns))));
  pool.run(static_cast<int>(columns), [&, asked = StopScope::question()](int i) {
    const StopScope scope(asked);
    const auto place = static_cast<std::size_t>(i);
    try {
      if (const auto values = column(static_cast<Eigen::Index>(i)))
        matrix.col(i) = *values;
      else
        missing[place] = 1;
    } catch (...) {
      thrown[place] = std::current_exception();
    }
  });
  for (const auto& each : thrown)
    if (each) std::rethrow_exception(each);
  if (std::ranges::find(missing, char{1}) != missing.end()) return std::nullopt;
  return matrix;
}

}  // namespace kalfem
