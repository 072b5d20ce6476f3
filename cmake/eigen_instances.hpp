// SPDX-License-Identifier: Apache-2.0
// What most sources do with matrices, so that the precompiled headers hold these templates instantiated: a file that
// does the same need not instantiate them again. Nothing here is ever called.
#pragma once

#include <Eigen/Dense>
#include <Eigen/Sparse>
#include <cmath>

namespace kalfem::precompiled {

inline double products(Eigen::MatrixXd& a, const Eigen::MatrixXd& b, Eigen::VectorXd& v, double s) {
  a = b * b;
  a += b * b.transpose();
  a -= b.transpose() * b;
  a.noalias() = b * b;
  a.noalias() += b.transpose() * b;
  a.noalias() -= b * b.transpose();
  a.noalias() = b * b * b.transpose();
  v = b * v;
  v += b.transpose() * v;
  v -= b * v;
  v.noalias() = b * v;
  v.noalias() += b.transpose() * v;
  a.col(0) = b * v;
  a.col(0).noalias() = b * v;
  v.noalias() = b * b.col(0);
  a = s * b + b * s - b / s;
  a.block(0, 0, 1, 1) = b.block(0, 0, 1, 1) * b.block(0, 0, 1, 1);
  a.leftCols(1) = b.rightCols(1);
  a.topRows(1) = b.bottomRows(1);
  a.row(0) = b.row(0);
  a.col(0) = v;
  a = v.asDiagonal() * b;
  a = b * v.asDiagonal();
  a = v * v.transpose();
  a.noalias() += s * v * v.transpose();
  a.diagonal() = v;
  a.diagonal().array() += s;
  v = b.diagonal();
  a = Eigen::MatrixXd::Identity(2, 2);
  a = Eigen::MatrixXd::Zero(2, 2);
  v = Eigen::VectorXd::Zero(2);
  v = Eigen::VectorXd::Constant(2, s);
  v = Eigen::VectorXd::LinSpaced(2, 0.0, s);
  v = s * v + v / s - v;
  v = v.cwiseProduct(v).cwiseQuotient(v).cwiseAbs().cwiseSqrt();
  v.array() *= v.array().square().sqrt().abs();
  a = (a + a.transpose()).eval() / 2.0;
  v.head(1) = v.tail(1);
  v.segment(0, 1) += v.segment(1, 1);
  v = b.rowwise().sum() + b.colwise().mean().transpose();
  return v.dot(v) + v.norm() + v.squaredNorm() + a.norm() + (a - b).norm() + (v - v).norm() + a.trace() + v.sum() +
         v.mean() + v.maxCoeff() + v.minCoeff() + a.cwiseAbs().maxCoeff() + v.cwiseAbs().maxCoeff() + v.dot(b * v) +
         (a.allFinite() && v.allFinite() ? 1.0 : 0.0);
}

inline void decompositions(Eigen::MatrixXd& a, Eigen::VectorXd& v) {
  const Eigen::LLT<Eigen::MatrixXd> llt(a);
  v = llt.solve(v);
  a = llt.solve(a);
  a = llt.matrixL();
  const Eigen::LDLT<Eigen::MatrixXd> ldlt(a);
  v = ldlt.solve(v);
  a = ldlt.solve(a);
  const Eigen::PartialPivLU<Eigen::MatrixXd> lu(a);
  v = lu.solve(v);
  a = lu.solve(a);
  a = lu.inverse();
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(a);
  a = qr.householderQ() * a;
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> pivoted(a);
  v = pivoted.solve(v);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> symmetric(a);
  v = symmetric.eigenvalues();
  a = symmetric.eigenvectors();
}

inline void small(Eigen::Vector3d& v, Eigen::Matrix3d& m, const Eigen::MatrixXd& nodes) {
  v = m * v + m.transpose() * v - 2.0 * v;
  v = nodes.col(0);
  v += nodes.col(1);
  v = v.cross(v).normalized() * v.dot(v) / v.norm();
  m = m * m * m.transpose();
  m = v * v.transpose();
  m = m.inverse();
  m.col(0) = v;
  m = Eigen::Matrix3d::Identity() * m.determinant();
}

inline void sparse(Eigen::SparseMatrix<double>& a, Eigen::VectorXd& v, Eigen::MatrixXd& dense,
                   const std::vector<Eigen::Triplet<double>>& entries) {
  a.setFromTriplets(entries.begin(), entries.end());
  v = a * v;
  v += a.transpose() * v;
  dense = a * dense;
  dense = Eigen::MatrixXd(a);
  a = a.transpose();
  a = a + a;
  for (Eigen::SparseMatrix<double>::InnerIterator it(a, 0); it; ++it) v[it.row()] += it.value();
}

}  // namespace kalfem::precompiled
