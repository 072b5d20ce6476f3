// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/formats/matrices/matrix_model.hpp"

namespace kalfem {
namespace {

ForeignMatrix matrix(const std::string& name, const Eigen::MatrixXd& entries, std::vector<MatrixDof> dofs = {}) {
  return {name, entries.sparseView(), std::move(dofs), false};
}

const Eigen::MatrixXd k = (Eigen::Matrix3d() << 2, -1, 0, -1, 2, -1, 0, -1, 2).finished();
const Eigen::MatrixXd m = Eigen::Vector3d(1, 2, 3).asDiagonal();

std::string refusal(const ForeignMatrix& stiffness, const ForeignMatrix& mass, const MatrixModelOptions& options = {}) {
  try {
    matrix_model(stiffness, mass, {}, options);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

TEST(MatrixModel, NamesItsRows) {
  EXPECT_EQ(matrix_model(matrix("K", k), matrix("M", m)).model.dofs, (std::vector<std::string>{"r1", "r2", "r3"}));
  const std::vector<MatrixDof> dofs = {{4, -1}, {12, 0}, {12, 5}};
  const auto model = matrix_model(matrix("K", k), matrix("M", m), matrix("C", 0.1 * k), {.dofs = dofs}).model;
  EXPECT_EQ(model.dofs, (std::vector<std::string>{"q4", "n12.x", "n12.rz"}));
  EXPECT_EQ(Eigen::MatrixXd(model.damping), 0.1 * k);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(matrix_dof(model.dofs[i]), dofs[i]);
  for (const std::string name : {"body", "n", "n1", "n1.w", "q", "qx", "mode1"}) EXPECT_FALSE(matrix_dof(name)) << name;
}

TEST(MatrixModel, MatricesOfDifferentRowsAreAligned) {
  const auto stiffness = matrix("K", k, {{1, 0}, {2, 0}, {3, 0}});
  const auto mass = matrix("M", Eigen::Vector2d(5, 6).asDiagonal(), {{3, 0}, {2, 0}});
  const auto result = matrix_model(stiffness, mass);
  EXPECT_EQ(Eigen::MatrixXd(result.model.mass), Eigen::MatrixXd(Eigen::Vector3d(0, 6, 5).asDiagonal()));
  ASSERT_EQ(result.notes.size(), 1u);
  EXPECT_EQ(result.notes[0], "1 degrees of freedom have no mass");
}

TEST(MatrixModel, CopiesHaveTheirMeanAsAPoint) {
  const auto result = matrix_model(matrix("K", k), matrix("M", m), {}, {.dofs = {{9, 0, 1}, {8, 0}, {9, 0, 2}}});
  EXPECT_EQ(result.model.dofs, (std::vector<std::string>{"n9#1.x", "n8.x", "n9#2.x"}));
  EXPECT_EQ(result.model.points.at("n9.x"), (DofCombination{{"n9#1.x", 0.5}, {"n9#2.x", 0.5}}));
}

TEST(MatrixModel, RoundingIsMendedAndMoreIsNot) {
  Eigen::MatrixXd nearly = k, crooked = k;
  nearly(0, 1) *= 1.0 + 1e-12;
  crooked(0, 1) *= 1.01;
  const auto mended = matrix_model(matrix("K", nearly), matrix("M", m));
  EXPECT_TRUE(mended.notes.empty());
  EXPECT_EQ(mended.model.stiffness.coeff(0, 1), mended.model.stiffness.coeff(1, 0));
  EXPECT_NE(refusal(matrix("K", crooked), matrix("M", m)).find("the stiffness matrix 'K' is not symmetric"),
            std::string::npos);
  const auto asked = matrix_model(matrix("K", crooked), matrix("M", m), {}, {.symmetrise = true});
  EXPECT_EQ(asked.notes.size(), 1u);
  EXPECT_NEAR(asked.model.stiffness.coeff(0, 1), -1.005, 1e-15);
}

TEST(MatrixModel, SaysEverythingThatIsWrongTogether) {
  Eigen::MatrixXd negative = m, infinite = k, beside = m;
  negative(1, 1) = -2.0;
  infinite(2, 2) = std::numeric_limits<double>::infinity();
  const std::string both = refusal(matrix("K", infinite), matrix("M", negative));
  EXPECT_NE(both.find("the stiffness matrix 'K' has an entry that is not finite"), std::string::npos) << both;
  EXPECT_NE(both.find("the mass matrix 'M' has -2 on its diagonal at row 2"), std::string::npos) << both;
  beside(0, 0) = 0.0;
  beside(0, 1) = beside(1, 0) = 0.1;
  const struct {
    ForeignMatrix stiffness, mass;
    std::string message;
  } cases[] = {
      {matrix("K", k), matrix("M", m.topRows(2)), "the mass matrix 'M' is 2 x 3: it must be square"},
      {matrix("K", k), matrix("M", m.topLeftCorner(2, 2)), "the mass matrix 'M' is 2 x 2: there are 3 degrees"},
      {matrix("K", k), matrix("M", beside), "a row with other entries needs a positive diagonal"},
      {matrix("K", k), matrix("M", 0.0 * m), "the mass matrix is zero"},
  };
  for (const auto& [stiffness, mass, message] : cases)
    EXPECT_NE(refusal(stiffness, mass).find(message), std::string::npos) << refusal(stiffness, mass);
  EXPECT_NE(
      refusal(matrix("K", k), matrix("M", m), {.dofs = {{1, 0}, {1, 0}, {1, 1}}}).find("is listed twice in the map"),
      std::string::npos);
  EXPECT_NE(refusal(matrix("K", k, {{1, 0}, {2, 0}, {3, 0}}), matrix("M", m), {.dofs = {{1, 0}, {2, 0}, {4, 0}}})
                .find("has degree of freedom 3.x: the map does not list it"),
            std::string::npos);
}

}  // namespace
}  // namespace kalfem
