#pragma once

#include <Eigen/Sparse>

namespace kalfem::precompiled {

/// Never called. What Eigen makes of these expressions, which most files use, is made once in a precompiled header that
/// includes this, not in every file again: a tenth less to compile for the stages, a sixth for the tests.
inline void eigen_expressions(double s, Eigen::VectorXd& v, const Eigen::VectorXd& w, Eigen::MatrixXd& a,
                              const Eigen::MatrixXd& b, Eigen::SparseMatrix<double>& K,
                              const Eigen::SparseMatrix<double>& M, Eigen::Vector3d& x, const Eigen::Vector3d& y,
                              Eigen::Matrix3d& r) {
  using Eigen::MatrixXd, Eigen::VectorXd, Eigen::Vector3d, Eigen::Matrix3d;

  // sums and multiples
  v = s * w, v = w * s, v = v + w, v = v - w, v = -w, v = s * v + w, v = v - s * w;
  v += w, v -= w, v += s * w, v -= s * w;
  a = s * b, a = b * s, a = a + b, a = a - b, a += b, a -= b, a *= s, a /= s;

  // products
  v = a * w, v = a.transpose() * w, v = w - a * v, v += a * w, v -= a * w;
  a = b * a, a = b.transpose() * a, a = b * a.transpose(), a = b.transpose() * a * b, a = b * a * b.transpose();
  v.noalias() = a * w, v.noalias() += a * w, a.noalias() = b * a, a.noalias() += b * a;
  a = w * v.transpose(), a += w * v.transpose(), a += s * w * v.transpose();
  s = v.dot(w), s = v.dot(a * w);

  // diagonals and symmetric parts
  a = w.asDiagonal(), a = b * w.asDiagonal(), a = w.asDiagonal() * b, a = b.transpose() * w.asDiagonal() * b;
  a = v.asDiagonal() * b * v.asDiagonal();
  v = b.diagonal(), a.diagonal() = w, a.diagonal() += w, a.diagonal().array() += s;
  a = 0.5 * (a + a.transpose()), a = a.transpose().eval();

  // parts
  v.head(1) = w, v = w.head(1), v.tail(1) = w, v = w.tail(1);
  v.segment(0, 1) = w, v.segment(0, 1) += w, v = w.segment(0, 1), v.segment<3>(0) = x, x = w.segment<3>(0);
  a.col(0) = w, a.col(0) = s * w, a.col(0) += w, a.col(0) -= s * w, a.col(0) = b * w, a.col(0) = b.col(1);
  v = b.col(0), v = b.row(0).transpose(), a.row(0) = w.transpose();
  a.block(0, 0, 1, 1) = b, a = b.block(0, 0, 1, 1), a.topLeftCorner(1, 1) = b;
  a.leftCols(1) = b, a = b.leftCols(1), a.middleCols(0, 1) = b, a = b.middleCols(0, 1);
  a.topRows(1) = b, a = b.topRows(1), a = b.bottomRows(1);

  // norms and sums
  s = v.norm(), s = v.squaredNorm(), s = (v - w).norm(), s = v.lpNorm<Eigen::Infinity>();
  s = v.sum(), s = v.mean(), s = v.maxCoeff(), s = v.minCoeff(), s = v.cwiseAbs().maxCoeff();
  s = (v - w).cwiseAbs().maxCoeff(), s = (v - w).lpNorm<Eigen::Infinity>(), s = v.array().square().sum();
  s = a.norm(), s = (a - b).norm(), s = a.sum(), s = a.trace(), s = a.cwiseAbs().maxCoeff();
  s = (a - b).cwiseAbs().maxCoeff(), s = a.lpNorm<Eigen::Infinity>(), s = (a - b).lpNorm<Eigen::Infinity>();
  s = b.col(0).norm(), s = b.col(0).squaredNorm(), s = b.col(0).dot(b.col(1)), s = b.col(0).dot(w);
  s = b.row(0).dot(w);
  s += a.isApprox(b) || a.allFinite() || v.allFinite() || (v.array() > 0.0).all() ? 1.0 : 0.0;

  // constants
  v = VectorXd::Zero(1), v = VectorXd::Ones(1), v = VectorXd::Constant(1, s), v = VectorXd::Unit(1, 0);
  v = VectorXd::LinSpaced(2, 0.0, s), v.setZero(), v << 1.0, 2.0;
  a = MatrixXd::Zero(1, 1), a = MatrixXd::Identity(1, 1), a.setZero(), a.setIdentity(), a << 1.0, 2.0;

  // entry by entry
  v = w.cwiseProduct(v), v = w.cwiseQuotient(v), v = w.cwiseSqrt(), v = w.cwiseAbs(), v = w.cwiseInverse();
  v = w.array().square(), v = w.array().sqrt(), v = w.array() * v.array(), v = w.array() / v.array();
  v.array() += s, v.array() *= w.array(), v.array() /= w.array(), a = a.cwiseAbs();

  // sparse
  v = K * w, v += K * w, v = K.transpose() * w, s = v.dot(K * w);
  a = K * b, a = K.transpose() * b, a = b.transpose() * (K * b), a = K, v = K.diagonal();
  K = K + M, K = K - M, K = s * K, K += M, K += s * M, K = K.transpose(), K = K * M, K = M.block(0, 0, 1, 1);

  // in space
  x = y + x, x = y - x, x = s * y, x = -y, x /= s, x += s * y, x = y.cross(x), x = y.normalized();
  x = (y - x).normalized(), x = y.cross(x).normalized(), x = Vector3d::Zero();
  s = x.norm(), s = x.dot(y), s = (x - y).norm();
  r = r * r, r = r.transpose() * r, x = r * y, r.col(0) = x, x = r.col(0), r = r.transpose().eval();
  r = Matrix3d::Identity(), r = Matrix3d::Zero();
  a.block<3, 3>(0, 0) = r, a.block<3, 3>(0, 0) += r, a.col(0) = x, x = a.col(0).head<3>();

  // decompositions
  const Eigen::LLT<MatrixXd> cholesky(a);
  v = cholesky.solve(w), a = cholesky.solve(b), a = cholesky.matrixL();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(a);
  v = eigen.eigenvalues(), a = eigen.eigenvectors();
}

}  // namespace kalfem::precompiled
