// SPDX-License-Identifier: Apache-2.0
#include "kalfem/live/change_test.hpp"

#include <algorithm>
#include <cmath>

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double chi_square_95 = 3.84;  ///< one degree of freedom
constexpr double untold = 1e-6;         ///< part of a step's information that nothing else explains, at least

}  // namespace

ChangeTest::ChangeTest(const VectorXd& level, const VectorXd& effect, int memory)
    : parameters_(level.size()), memory_(static_cast<std::size_t>(memory)), before_(VectorXd::Zero(level.size())) {
  const Index count = parameters_ * (1 + effect.size());
  information_.setZero(count, count);
  information_.diagonal().head(parameters_) = level.cwiseAbs2().cwiseInverse();
  for (Index k = 0; k < effect.size(); ++k)
    information_.diagonal().segment((1 + k) * parameters_, parameters_).setConstant(1.0 / (effect[k] * effect[k]));
  weighted_.setZero(count);
  origin_.setZero(effect.size());
  solve();
}

void ChangeTest::solve() {
  factor_.compute(information_);
  solution_ = factor_.solve(weighted_);
}

MatrixXd ChangeTest::design(const Window& window) const {
  const Index p = parameters_;
  MatrixXd design = MatrixXd::Zero(p, information_.rows());
  design.leftCols(p).setIdentity();
  for (Index k = 0; k < window.relative.size(); ++k)
    design.middleCols((1 + k) * p, p).diagonal().setConstant(window.relative[k]);
  const Index first = p * (1 + window.relative.size());
  for (std::size_t s = 0; s < steps_.size(); ++s)
    if (window.start >= steps_[s].since) design(steps_[s].parameter, first + static_cast<Index>(s)) = 1.0;
  return design;
}

void ChangeTest::add(double start, WindowInformation told, const VectorXd& covariates, ScatterLearning learning) {
  if (count_ == 0) origin_ = covariates;
  ring_.push_back({start, std::move(told), covariates - origin_});
  if (ring_.size() > memory_) ring_.pop_front();
  ++count_;
  const Window& window = ring_.back();
  const MatrixXd x = design(window);
  if (learning != ScatterLearning::none) learn_scatter(window, x, learning);
  information_ += x.transpose() * window.told.information * x;
  weighted_ += x.transpose() * window.told.weighted;
  solve();
}

/// u = eta - Lambda X beta has the covariance S = Lambda + Lambda X A^-1 X' Lambda; the symmetric root of its inverse
/// whitens it, in directions that do not turn from window to window.
void ChangeTest::learn_scatter(const Window& window, const MatrixXd& x, ScatterLearning learning) {
  const MatrixXd& information = window.told.information;
  const VectorXd error = window.told.weighted - information * (x * solution_);
  const MatrixXd spread = information * x;
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(information + spread * factor_.solve(spread.transpose()));
  const double least = 1e-10 * eigen.eigenvalues().maxCoeff();
  const VectorXd scale =
      (eigen.eigenvalues().array() > least).select(eigen.eigenvalues().cwiseMax(least).cwiseSqrt().cwiseInverse(), 0.0);
  VectorXd white = eigen.eigenvectors() * scale.asDiagonal() * (eigen.eigenvectors().transpose() * error);
  if (learning == ScatterLearning::limited) {
    const double most = 3.0 * std::sqrt(std::max(1.0, squares_ / std::max(1.0, freedom_)));
    white = white.cwiseMin(most).cwiseMax(-most);
  }
  squares_ += white.squaredNorm();
  freedom_ += static_cast<double>((scale.array() > 0.0).count());
  products_ += white.dot(before_);
  before_ = white;
}

double ChangeTest::scatter() const {
  if (freedom_ < 2.0 || squares_ <= 0.0) return 1.0;
  const double variance = std::max(1.0, squares_ / freedom_);
  const double correlation = products_ / squares_;
  const bool significant = correlation > 2.0 / std::sqrt(freedom_);
  const double rho = significant ? std::min(correlation, 0.9) : 0.0;
  return variance * (1.0 + rho) / (1.0 - rho);
}

std::vector<ParameterStep> ChangeTest::likely_steps() const {
  const Index p = parameters_;
  std::vector<ParameterStep> best(static_cast<std::size_t>(p));
  MatrixXd total = MatrixXd::Zero(p, p), coupling = MatrixXd::Zero(p, information_.rows());
  VectorXd told = VectorXd::Zero(p);
  const double factor = scatter();
  MatrixXd squares = MatrixXd::Zero(std::ssize(ring_), p);
  for (Index w = std::ssize(ring_) - 1; w >= 0; --w) {
    const Window& window = ring_[static_cast<std::size_t>(w)];
    total += window.told.information;
    coupling += window.told.information * design(window);
    told += window.told.weighted;
    const MatrixXd explained = factor_.solve(coupling.transpose());
    const VectorXd score = told - coupling * solution_;
    for (Index j = 0; j < p; ++j) {
      const double left = total(j, j) - coupling.row(j).dot(explained.col(j));
      if (!(left > untold * total(j, j))) continue;
      squares(w, j) = score[j] * score[j] / (factor * left);
      auto& step = best[static_cast<std::size_t>(j)];
      if (squares(w, j) > step.statistic * step.statistic)
        step = {.parameter = j,
                .since = window.start,
                .change = score[j] / left,
                .deviation = std::sqrt(factor / left),
                .statistic = std::sqrt(squares(w, j))};
    }
  }
  for (auto& step : best) {
    step.parameter = &step - best.data();
    step.earliest = step.latest = step.since;
    for (Index w = 0; w < std::ssize(ring_); ++w)
      if (squares(w, step.parameter) > step.statistic * step.statistic - chi_square_95) {
        const double start = ring_[static_cast<std::size_t>(w)].start;
        step.earliest = std::min(step.earliest, start);
        step.latest = std::max(step.latest, start);
      }
  }
  return best;
}

void ChangeTest::accept(const ParameterStep& step) {
  const Index q = information_.rows();
  VectorXd coupling = VectorXd::Zero(q);
  double own = 0.0, told = 0.0;
  for (const auto& window : ring_) {
    if (window.start < step.since) continue;
    coupling += design(window).transpose() * window.told.information.col(step.parameter);
    own += window.told.information(step.parameter, step.parameter);
    told += window.told.weighted[step.parameter];
  }
  information_.conservativeResize(q + 1, q + 1);
  information_.col(q).head(q) = coupling;
  information_.row(q).head(q) = coupling.transpose();
  information_(q, q) = own;
  weighted_.conservativeResize(q + 1);
  weighted_[q] = told;
  steps_.push_back(step);
  solve();
}

ParameterStep ChangeTest::total_change(Index parameter) const {
  const Index q = information_.rows(), first = q - std::ssize(steps_);
  VectorXd sum = VectorXd::Zero(q);
  ParameterStep total{.parameter = parameter};
  for (std::size_t s = 0; s < steps_.size(); ++s)
    if (steps_[s].parameter == parameter) {
      sum[first + static_cast<Index>(s)] = 1.0;
      total.since = steps_[s].since;
      total.earliest = steps_[s].earliest;
      total.latest = steps_[s].latest;
      total.statistic = steps_[s].statistic;
    }
  total.change = sum.dot(solution_);
  total.deviation = std::sqrt(std::max(0.0, scatter() * sum.dot(factor_.solve(sum))));
  return total;
}

MatrixXd ChangeTest::effects() const {
  return solution_.segment(parameters_, parameters_ * origin_.size()).reshaped(parameters_, origin_.size());
}

VectorXd ChangeTest::effect_variance(const VectorXd& relative) const {
  VectorXd variance(parameters_);
  for (Index j = 0; j < parameters_; ++j) {
    VectorXd sum = VectorXd::Zero(information_.rows());
    for (Index k = 0; k < relative.size(); ++k) sum[(1 + k) * parameters_ + j] = relative[k];
    variance[j] = std::max(0.0, scatter() * sum.dot(factor_.solve(sum)));
  }
  return variance;
}

}  // namespace kalfem
