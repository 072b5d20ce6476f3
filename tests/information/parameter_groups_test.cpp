// SPDX-License-Identifier: Apache-2.0
#include "kalfem/information/parameter_groups.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace kalfem {
namespace {

using Groups = std::vector<std::vector<Eigen::Index>>;

std::vector<InformedParameter> factors(int count) {
  std::vector<InformedParameter> all;
  for (int i = 0; i < count; ++i)
    all.push_back({"a" + std::to_string(i + 1), 1.0, std::numeric_limits<double>::infinity()});
  return all;
}

ParameterGrouping groups_of(const Eigen::MatrixXd& jacobian) {
  return propose_groups(jacobian.transpose() * jacobian, factors(static_cast<int>(jacobian.cols())));
}

TEST(ParameterGroups, ParametersThatDataDetermineStayAlone) {
  const auto proposal = groups_of((Eigen::Matrix3d() << 10, 1, 0, 0, 20, 2, 0, 0, 5).finished());
  EXPECT_EQ(proposal.groups, (Groups{{0}, {1}, {2}}));
  EXPECT_TRUE(proposal.hold.empty());
}

TEST(ParameterGroups, ThoseThatActAlikeAreJoined) {
  Eigen::MatrixXd jacobian(3, 4);
  jacobian << 10, 0, 10.01, 1, 0, 20, 0.01, 0, 5, 3, 5, 30;
  const auto proposal = groups_of(jacobian);
  EXPECT_EQ(proposal.groups, (Groups{{0, 2}, {1}, {3}}));
}

/// Three columns of rank two, no two of them alike: no pair shows it.
TEST(ParameterGroups, CombinationsOfMoreThanTwoAreFound) {
  Eigen::MatrixXd jacobian(2, 3);
  jacobian << 10, 0, 7, 0, 10, 8;
  const auto proposal = groups_of(jacobian);
  EXPECT_EQ(proposal.groups, (Groups{{0}, {1, 2}}));
}

TEST(ParameterGroups, OneThatActsLikeNoOtherIsHeld) {
  Eigen::MatrixXd jacobian(2, 2);
  jacobian << 10, 0, 0, 0.1;
  const auto proposal = groups_of(jacobian);
  EXPECT_EQ(proposal.groups, (Groups{{0}}));
  EXPECT_EQ(proposal.hold, (std::vector<Eigen::Index>{1}));
}

}  // namespace
}  // namespace kalfem
