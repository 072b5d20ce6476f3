// SPDX-License-Identifier: Apache-2.0
#include "kalfem/sampling/prior.hpp"

#include <cmath>
#include <string>
#include <utility>

#include "kalfem/base/units.hpp"

namespace kalfem {
namespace {

void check_correlation(const Eigen::MatrixXd& r, Eigen::Index size, IssueList& issues) {
  if (r.rows() != size || r.cols() != size) {
    issues.add({}, "correlation of the prior: " + std::to_string(r.rows()) + " x " + std::to_string(r.cols()),
               "one row and column per parameter: " + std::to_string(size), "give all correlations or none");
    return;
  }
  const bool unit =
      (r.diagonal().array() - 1.0).abs().maxCoeff() < 1e-12 && (r - r.transpose()).cwiseAbs().maxCoeff() < 1e-12;
  if (!unit)
    issues.add({}, "correlation of the prior: not symmetric with ones on the diagonal", "a correlation matrix is",
               "state each pair once, with values between -1 and 1");
  else if (const double least =
               Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(r, Eigen::EigenvaluesOnly).eigenvalues()[0];
           !(least > 1e-12))
    issues.add({}, "correlation of the prior: not positive definite (least eigenvalue " + shortest(least) + ")",
               "no parameters are correlated like this", "make the correlations smaller or consistent with each other");
}

}  // namespace

IssueList validate(const Named<MarginalPrior>& marginals, const Eigen::MatrixXd& correlation) {
  IssueList issues;
  if (marginals.empty())
    issues.add({}, "a prior without parameters", "there is nothing to sample", "name at least one unknown parameter");
  for (const auto& [name, marginal] : marginals) check(name, marginal, issues);
  if (correlation.size() > 0) check_correlation(correlation, static_cast<Eigen::Index>(marginals.size()), issues);
  return issues;
}

JointPrior::JointPrior(Named<MarginalPrior> marginals, Eigen::MatrixXd correlation)
    : marginals_(std::move(marginals)), correlation_(std::move(correlation)) {
  validate(marginals_, correlation_).raise();
  if (correlation_.size() > 0) factor_ = correlation_.llt().matrixL();
}

double JointPrior::log_density(const Eigen::VectorXd& theta) const {
  double sum = 0.0;
  for (Eigen::Index i = 0; i < size(); ++i)
    sum += kalfem::log_density(marginals_[static_cast<std::size_t>(i)].second, theta[i]);
  if (factor_.size() == 0 || !std::isfinite(sum)) return sum;
  const Eigen::VectorXd z = to_standard_normal(theta);  // the copula's density: N(w; 0, R) / N(w; 0, I)
  const Eigen::VectorXd w = factor_ * z;
  return sum - 0.5 * (z.squaredNorm() - w.squaredNorm()) - factor_.diagonal().array().log().sum();
}

Eigen::VectorXd JointPrior::sample(RandomStream& random) const {
  Eigen::VectorXd z(size());
  for (auto& value : z) value = random.normal();
  return from_standard_normal(z);
}

Eigen::VectorXd JointPrior::from_standard_normal(const Eigen::VectorXd& z) const {
  Eigen::VectorXd theta = z;
  if (factor_.size() > 0) theta = factor_ * z;
  for (Eigen::Index i = 0; i < size(); ++i)
    theta[i] = from_normal(marginals_[static_cast<std::size_t>(i)].second, theta[i]);
  return theta;
}

Eigen::VectorXd JointPrior::to_standard_normal(const Eigen::VectorXd& theta) const {
  Eigen::VectorXd z(size());
  for (Eigen::Index i = 0; i < size(); ++i) z[i] = to_normal(marginals_[static_cast<std::size_t>(i)].second, theta[i]);
  if (factor_.size() > 0) factor_.triangularView<Eigen::Lower>().solveInPlace(z);
  return z;
}

Eigen::VectorXd JointPrior::mean() const {
  Eigen::VectorXd values(size());
  for (Eigen::Index i = 0; i < size(); ++i) values[i] = kalfem::mean(marginals_[static_cast<std::size_t>(i)].second);
  return values;
}

Eigen::VectorXd JointPrior::deviation() const {
  Eigen::VectorXd values(size());
  for (Eigen::Index i = 0; i < size(); ++i)
    values[i] = kalfem::deviation(marginals_[static_cast<std::size_t>(i)].second);
  return values;
}

}  // namespace kalfem
