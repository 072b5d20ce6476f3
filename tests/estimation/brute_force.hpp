// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <functional>

#include "kalfem/base/random.hpp"
#include "kalfem/estimation/partially_linear/partially_linear_map.hpp"
#include "kalfem/estimation/unscented_transform.hpp"

namespace kalfem {

/// A partially linear map whose nonlinear outputs are a given function of one row, with matrices that a test may set
/// before a filter works on it.
class FunctionMap final : public PartiallyLinearMap {
public:
  using Function = std::function<Eigen::VectorXd(const Eigen::VectorXd&)>;
  explicit FunctionMap(Function phi) : phi_(std::move(phi)) {}
  FunctionMap(const FunctionMap& other) : PartiallyLinearMap(other), phi_(other.phi_) {}
  FunctionMap& operator=(const FunctionMap&) = delete;

  Eigen::MatrixXd &linear = linear_, &gain = gain_, &selection = selection_;
  Eigen::VectorXd &offset = offset_, &input_offset = input_offset_;
  Eigen::Index& moving_gain = moving_gain_;

  bool evaluate(const Eigen::ArrayXXd& in, Eigen::ArrayXXd& out) override {
    for (Eigen::Index i = 0; i < in.rows(); ++i) out.row(i) = phi_(in.row(i).transpose().matrix()).transpose().array();
    return out.allFinite();
  }
  /// y of one x, the map written as it is defined.
  [[nodiscard]] Eigen::VectorXd operator()(const Eigen::VectorXd& x) const {
    return linear * x + gain * phi_(selection * x + input_offset) + offset;
  }

private:
  Function phi_;
};

/// Two nonlinear functions of three arguments: saturation, products, an exponential.
inline Eigen::VectorXd bent(const Eigen::VectorXd& w) {
  Eigen::VectorXd phi(2);
  phi << w[0] / (0.3 + std::abs(w[0])) + w[1] * w[2], std::exp(0.3 * w[1]) * w[0] + w[2] * w[2];
  return phi;
}

inline Eigen::MatrixXd random_matrix(RandomStream& random, Eigen::Index rows, Eigen::Index columns) {
  return Eigen::MatrixXd::NullaryExpr(rows, columns, [&] { return random.normal(); });
}

inline FunctionMap random_map(RandomStream& random, Eigen::Index n_y, Eigen::Index n_x, Eigen::Index q, Eigen::Index p,
                              FunctionMap::Function phi) {
  FunctionMap map(std::move(phi));
  map.linear = random_matrix(random, n_y, n_x);
  map.gain = random_matrix(random, n_y, p);
  map.selection = random_matrix(random, q, n_x);
  map.offset = random_matrix(random, n_y, 1);
  map.input_offset = random_matrix(random, q, 1);
  return map;
}

struct Moments {
  Eigen::VectorXd mean;
  Eigen::MatrixXd covariance, cross;
};

/// Table 1 with all 2 n + 1 points of the state and their images, one by one.
inline Moments table_1(const FunctionMap& map, const Eigen::VectorXd& m, const Eigen::MatrixXd& S,
                       const UnscentedOptions& options) {
  const auto n = m.size();
  const double lambda = options.alpha * options.alpha * (double(n) + options.kappa.value_or(0.0)) - double(n),
               c = double(n) + lambda;
  std::vector<Eigen::VectorXd> x{m}, y;
  std::vector<double> mean_weight{lambda / c};
  for (const double sign : {1.0, -1.0})
    for (Eigen::Index i = 0; i < n; ++i) {
      x.push_back(m + sign * std::sqrt(c) * S.col(i));
      mean_weight.push_back(0.5 / c);
    }
  auto covariance_weight = mean_weight;
  covariance_weight[0] += 1.0 - options.alpha * options.alpha + options.beta;
  for (const auto& point : x) y.push_back(map(point));
  Moments moments{Eigen::VectorXd::Zero(y[0].size()), Eigen::MatrixXd::Zero(y[0].size(), y[0].size()),
                  Eigen::MatrixXd::Zero(n, y[0].size())};
  for (std::size_t i = 0; i < x.size(); ++i) moments.mean += mean_weight[i] * y[i];
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Eigen::VectorXd deviation = y[i] - moments.mean;
    moments.covariance += covariance_weight[i] * deviation * deviation.transpose();
    moments.cross += covariance_weight[i] * (x[i] - m) * deviation.transpose();
  }
  return moments;
}

}  // namespace kalfem
