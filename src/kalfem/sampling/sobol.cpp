// SPDX-License-Identifier: Apache-2.0
#include "kalfem/sampling/sobol.hpp"

#include <algorithm>
#include <boost/random/sobol.hpp>
#include <cmath>

#include "kalfem/base/parallel.hpp"
#include "kalfem/statistics/quantiles.hpp"

namespace kalfem {
namespace {

/// N points of the unit cube of 2 p dimensions, by columns: A in the first p rows, B in the others.
Eigen::MatrixXd unit_points(Eigen::Index dimensions, const SobolOptions& options) {
  Eigen::MatrixXd points(dimensions, options.samples);
  RandomStream random(options.seed, "sobol points");
  if (options.points == SobolPoints::random) {
    for (auto& value : points.reshaped()) value = random.uniform();
  } else {
    std::vector<std::uint64_t> shift(static_cast<std::size_t>(dimensions), 0);
    if (options.points == SobolPoints::scrambled)
      for (auto& bits : shift) bits = static_cast<std::uint64_t>(random.uniform() * 0x1.0p53) << 11;
    boost::random::sobol sequence(static_cast<std::size_t>(dimensions));
    for (Eigen::Index k = 0; k < points.cols(); ++k)
      for (Eigen::Index i = 0; i < dimensions; ++i)
        points(i, k) = static_cast<double>((sequence() ^ shift[static_cast<std::size_t>(i)]) >> 11) * 0x1.0p-53;
  }
  return points.cwiseMax(0x1.0p-54).cwiseMin(1.0 - 0x1.0p-53);
}

Eigen::MatrixXd to_parameters(const JointPrior& prior, const Eigen::Ref<const Eigen::MatrixXd>& unit) {
  Eigen::MatrixXd theta(unit.rows(), unit.cols());
  for (Eigen::Index k = 0; k < unit.cols(); ++k)
    theta.col(k) = prior.from_standard_normal(unit.col(k).unaryExpr([](double u) { return normal_quantile(u); }));
  return theta;
}

/// Outputs of one row of the design: A, B, then A with parameter i of B, outputs x (p + 2).
Eigen::MatrixXd evaluate(const ModelOutputs& model, const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  Eigen::MatrixXd outputs;
  for (Eigen::Index column = 0; column < a.size() + 2; ++column) {
    stop_if_asked();
    Eigen::VectorXd theta = column == 1 ? b : a;
    if (column >= 2) theta[column - 2] = b[column - 2];
    const Eigen::VectorXd values = model(theta);
    if (column == 0) outputs.resize(values.size(), a.size() + 2);
    if (values.size() != outputs.rows())
      throw InvalidInput(
          "the model gave " + std::to_string(values.size()) + " outputs after " + std::to_string(outputs.rows()),
          "every sample has the same outputs", "use not a number for one that is unknown");
    outputs.col(column) = values;
  }
  return outputs;
}

/// First-order (column 0) and total indices (column 1) of one output from the rows of the design chosen, p x 2. `f`:
/// outputs, rows x (p + 2).
Eigen::MatrixX2d estimate(const Eigen::MatrixXd& f, const std::vector<Eigen::Index>& rows) {
  const Eigen::MatrixXd chosen = f(rows, Eigen::all);
  const Eigen::ArrayXd a = chosen.col(0), b = chosen.col(1);
  const double mean = 0.5 * (a.mean() + b.mean());
  const double variance = 0.5 * ((a - mean).square().mean() + (b - mean).square().mean());
  Eigen::MatrixX2d indices = Eigen::MatrixX2d::Zero(f.cols() - 2, 2);
  if (!(variance > 1e-28 * mean * mean)) return indices;
  for (Eigen::Index i = 0; i < indices.rows(); ++i) {
    const Eigen::ArrayXd mixed = chosen.col(i + 2);
    indices(i, 0) = ((b - mean) * (mixed - a)).mean() / variance;
    indices(i, 1) = 0.5 * (a - mixed).square().mean() / variance;
  }
  return indices;
}

/// Bounds of one index from its sorted values over the resamples.
SobolIndex with_bounds(double value, std::vector<double> resampled, double confidence) {
  if (resampled.empty()) return {value, value, value};
  std::sort(resampled.begin(), resampled.end());
  const auto at = [&](double probability) {
    return resampled[static_cast<std::size_t>(std::lround(probability * static_cast<double>(resampled.size() - 1)))];
  };
  return {value, at(0.5 * (1.0 - confidence)), at(0.5 * (1.0 + confidence))};
}

SobolIndices indices_of(const Eigen::MatrixXd& f, const SobolOptions& options, std::size_t output) {
  std::vector<Eigen::Index> rows(static_cast<std::size_t>(f.rows()));
  for (std::size_t k = 0; k < rows.size(); ++k) rows[k] = static_cast<Eigen::Index>(k);
  const Eigen::MatrixX2d value = estimate(f, rows);
  std::vector<Eigen::MatrixX2d> resampled(static_cast<std::size_t>(options.bootstrap));
  for_each_index(resampled.size(), options.threads, [&](std::size_t k) {
    RandomStream random(options.seed, "sobol bootstrap " + std::to_string(output) + " " + std::to_string(k));
    std::vector<Eigen::Index> drawn(rows.size());
    for (auto& row : drawn) row = static_cast<Eigen::Index>(random.uniform() * static_cast<double>(rows.size()));
    resampled[k] = estimate(f, drawn);
  });
  const auto index = [&](Eigen::Index i, Eigen::Index kind) {
    std::vector<double> values;
    for (const auto& one : resampled) values.push_back(one(i, kind));
    return with_bounds(value(i, kind), std::move(values), options.confidence);
  };
  SobolIndices result;
  result.mean = f.leftCols(2).mean();
  result.variance = (f.leftCols(2).array() - result.mean).square().mean();
  for (Eigen::Index i = 0; i < value.rows(); ++i) {
    result.first.push_back(index(i, 0));
    result.total.push_back(index(i, 1));
  }
  return result;
}

}  // namespace

IssueList validate(const SobolOptions& options) {
  IssueList issues;
  const auto check = [&](bool right, const std::string& what, const std::string& why) {
    if (!right) issues.add({}, "Sobol' indices: " + what, why, "use the default or a value in that range");
  };
  check(options.samples >= 2, std::to_string(options.samples) + " samples",
        "at least two; some hundreds tell something");
  check(options.bootstrap >= 0, "negative bootstrap", "a number of resamples, 0 for no bounds");
  check(options.confidence > 0.0 && options.confidence < 1.0, "confidence out of range", "between 0 and 1");
  check(options.threads >= 1, "threads below 1", "at least one");
  return issues;
}

std::vector<SobolIndices> sobol_indices(const JointPrior& prior, const ModelOutputs& model,
                                        const SobolOptions& options) {
  IssueList issues = validate(options);
  if (prior.correlation().size() > 0 && !prior.correlation().isIdentity(0.0))
    issues.add({}, "Sobol' indices of correlated parameters", "their variance cannot be divided among them",
               "use a prior without correlation");
  if (prior.size() < 1 || prior.size() > 1800)
    issues.add({}, "Sobol' indices of " + std::to_string(prior.size()) + " parameters", "1 to 1800 can be handled",
               "choose fewer");
  issues.raise();

  const Eigen::Index size = prior.size();
  const Eigen::MatrixXd unit = unit_points(2 * size, options);
  const Eigen::MatrixXd a = to_parameters(prior, unit.topRows(size)), b = to_parameters(prior, unit.bottomRows(size));
  std::vector<Eigen::MatrixXd> outputs(static_cast<std::size_t>(options.samples));
  for_each_index(outputs.size(), options.threads, [&](std::size_t k) {
    const auto column = static_cast<Eigen::Index>(k);
    outputs[k] = evaluate(model, a.col(column), b.col(column));
  });
  for (const auto& one : outputs)
    if (one.rows() != outputs.front().rows())
      throw InvalidInput("the model's number of outputs changes", "every sample has the same outputs",
                         "use not a number for one that is unknown");

  std::erase_if(outputs, [](const Eigen::MatrixXd& one) { return !one.allFinite(); });
  if (outputs.size() < 2)
    throw InvalidInput(
        "only " + std::to_string(outputs.size()) + " of " + std::to_string(options.samples) + " samples have outputs",
        "at least two are needed", "narrow the prior to where the model is possible, or take more samples");
  std::vector<SobolIndices> result;
  for (Eigen::Index output = 0; output < outputs.front().rows(); ++output) {
    Eigen::MatrixXd f(static_cast<Eigen::Index>(outputs.size()), size + 2);
    for (std::size_t k = 0; k < outputs.size(); ++k) f.row(static_cast<Eigen::Index>(k)) = outputs[k].row(output);
    result.push_back(indices_of(f, options, static_cast<std::size_t>(output)));
    result.back().left_out = options.samples - static_cast<int>(outputs.size());
  }
  return result;
}

}  // namespace kalfem
