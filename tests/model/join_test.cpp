#include "kalfem/model/assembly/assemble_parts.hpp"

#include <gtest/gtest.h>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// Masses in a row between springs, the first held to the ground where it is wanted.
LinearModel chain(const std::vector<std::string>& names, double stiffness, bool grounded) {
  const auto n = static_cast<Index>(names.size());
  MatrixXd k = MatrixXd::Zero(n, n);
  for (Index i = 0; i + 1 < n; ++i) k.block(i, i, 2, 2) += stiffness * (Eigen::Matrix2d() << 1, -1, -1, 1).finished();
  LinearModel model;
  if (grounded) {
    k(0, 0) += stiffness;
    model.grounds.push_back({"ground", stiffness * Eigen::VectorXd::Unit(n, 0), Eigen::VectorXd::Zero(n)});
  }
  model.dofs = names;
  model.stiffness = k.sparseView();
  model.mass = MatrixXd(Eigen::VectorXd::LinSpaced(n, 1.0, 2.0).asDiagonal()).sparseView();
  model.damping = SparseMatrix(0.01 * model.stiffness);
  return model;
}

MatrixXd total_damping(const LinearModel& model) {
  return MatrixXd(model.damping) +
         damping_force(model.modal_damping, model.mass, MatrixXd::Identity(model.size(), model.size()));
}

TEST(Join, AddsPartsAtTheirCommonDegreesOfFreedom) {
  LinearModel a = chain({"1", "2", "3"}, 5.0, true), b = chain({"4", "3", "2"}, 7.0, true);
  a.points["middle"] = {{"1", 0.5}, {"2", 0.5}};
  b.points["middle"] = a.points["middle"];
  b.coordinate_scale = Eigen::Vector3d(1, 3, 1);
  const LinearModel joined = assemble_parts({&a, &b});
  EXPECT_EQ(joined.dofs, (std::vector<std::string>{"1", "2", "3", "4"}));
  const MatrixXd k =
      (Eigen::Matrix4d() << 10, -5, 0, 0, -5, 10 + 7, -5 - 7, 0, 0, -5 - 7, 5 + 14, -7, 0, 0, -7, 14).finished();
  EXPECT_EQ(MatrixXd(joined.stiffness), k);
  EXPECT_EQ(MatrixXd(joined.mass), MatrixXd(Eigen::Vector4d(1, 1.5 + 2, 2 + 1.5, 1).asDiagonal()));
  EXPECT_LT((MatrixXd(joined.damping) - 0.01 * k).norm(), 4e-16);  // rounding
  ASSERT_EQ(joined.grounds.size(), 1u);
  EXPECT_EQ(joined.grounds[0].stiffness, Eigen::Vector4d(5, 0, 0, 7));
  EXPECT_EQ(joined.points.size(), 1u);
  EXPECT_EQ(joined.coordinate_scale, Eigen::Vector4d(1, 1, 3, 1));
}

TEST(Join, CarriesTheModalDampingOfAPartExactly) {
  LinearModel a = chain({"1", "2", "3"}, 5.0, true), b = chain({"3", "4"}, 7.0, false);
  const NormalModes modes = normal_modes(a.mass, a.stiffness);
  a.modal_damping = {modes, damping_rates(modes.frequencies, {0.02, 0.05})};
  const LinearModel joined = assemble_parts({&a, &b});
  MatrixXd expected = MatrixXd::Zero(4, 4);
  expected.topLeftCorner(3, 3) = total_damping(a);
  expected.bottomRightCorner(2, 2) += total_damping(b);
  EXPECT_LT((total_damping(joined) - expected).norm(), 1e-15);  // rounding
  EXPECT_THROW(assemble_parts({&a, &b}, 2), InvalidInput);
  EXPECT_EQ(assemble_parts({&a}, 2).modal_damping.rates, a.modal_damping.rates);
}

TEST(Join, RefusesNamesThatMeanTwoThings) {
  LinearModel a = chain({"1", "2"}, 5.0, true), b = chain({"2", "3"}, 7.0, false);
  EXPECT_THROW(assemble_parts({}), InvalidInput);
  a.points["p"] = {{"1", 1.0}};
  b.points["p"] = {{"3", 1.0}};
  EXPECT_THROW(assemble_parts({&a, &b}), InvalidInput);
  b.points = {{"1", {{"3", 1.0}}}};
  EXPECT_THROW(assemble_parts({&a, &b}), InvalidInput);
  b = chain({"2", "2"}, 7.0, false);
  EXPECT_THROW(assemble_parts({&a, &b}), InvalidInput);
}

}  // namespace
}  // namespace kalfem
