#include "kalfem/estimation/innovation.hpp"

#include <cmath>
#include <numbers>

namespace kalfem {

void whiten(const Eigen::MatrixXd& lower, Eigen::VectorXd& vector) {
  for (Eigen::Index i = 0; i < vector.size(); ++i) {
    for (Eigen::Index k = 0; k < i; ++k) vector[i] -= lower(i, k) * vector[k];
    vector[i] /= lower(i, i);
  }
}

Eigen::MatrixXd gain_of(const Eigen::MatrixXd& whitened_cross, const Eigen::MatrixXd& lower) {
  return lower.triangularView<Eigen::Lower>().solve<Eigen::OnTheRight>(whitened_cross);
}

void score(Innovation& innovation, const Eigen::MatrixXd& factor, const Eigen::VectorXd& whitened) {
  innovation.nis = whitened.squaredNorm();
  const double log_determinant = 2.0 * factor.diagonal().array().log().sum();
  innovation.log_likelihood = -0.5 * (innovation.nis + log_determinant +
                                      static_cast<double>(innovation.value.size()) * std::log(2.0 * std::numbers::pi));
}

}  // namespace kalfem
