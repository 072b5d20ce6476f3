// SPDX-License-Identifier: Apache-2.0
#include "kalfem/correlation/shape_fit.hpp"

#include <cmath>

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

ShapeFit::ShapeFit(const MatrixXd& measured, const MatrixXd& model)
    : measured_(measured.unaryExpr([](double entry) { return std::isfinite(entry) ? entry : 0.0; })),
      given_(measured.unaryExpr([](double entry) { return std::isfinite(entry) ? 1.0 : 0.0; })),
      model_(model),
      entries_(static_cast<Index>(given_.sum())) {
  for (Index pair = 0; pair < measured_.cols(); ++pair)
    if (const double length = measured_.col(pair).norm(); length > 0.0) measured_.col(pair) /= length;
  const MatrixXd seen = model_.cwiseProduct(given_);
  products_ = {seen.colwise().squaredNorm().transpose().array(),
               seen.cwiseProduct(measured_).colwise().sum().transpose().array()};
}

VectorXd ShapeFit::mac() const {
  return (products_.model > 0.0).select(products_.mixed.square() / products_.model, 0.0);
}

double ShapeFit::misfit_of(const Products& products) {
  return (1.0 - (products.model > 0.0).select(products.mixed.square() / products.model, 0.0)).max(0.0).sum();
}

void ShapeFit::exchange(Products& products, Index row, const Eigen::RowVectorXd& motion, double sign) const {
  const Eigen::ArrayXd seen = motion.cwiseProduct(given_.row(row)).transpose();
  products.model += sign * seen.square();
  products.mixed += sign * seen * measured_.row(row).transpose().array();
}

double ShapeFit::misfit_with(const std::vector<Index>& rows, const MatrixXd& motions) const {
  Products products = products_;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    exchange(products, rows[i], model_.row(rows[i]), -1.0);
    exchange(products, rows[i], motions.row(static_cast<Index>(i)), 1.0);
  }
  return misfit_of(products);
}

VectorXd ShapeFit::scales_without(const std::vector<Index>& rows) const {
  Products products = products_;
  for (const Index row : rows) exchange(products, row, model_.row(row), -1.0);
  return (products.model > 0.0).select(products.mixed / products.model, 0.0);
}

}  // namespace kalfem
