// SPDX-License-Identifier: Apache-2.0
#include "kalfem/reduction/free_interface.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "base/figures.hpp"
#include "kalfem/base/invalid_input.hpp"
#include "kalfem/linalg/lowest_modes.hpp"
#include "kalfem/model/linear_model.hpp"
#include "reduction/frequencies.hpp"
#include "reduction/lattice.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using lattice::edge;
using test::frequencies;

using Names = std::vector<std::string>;

Superelement reduced(const LinearModel& model, const Names& boundary, Index modes,
                     FreeInterfaceKind kind = FreeInterfaceKind::rubin) {
  return free_interface(model, boundary, {.kind = kind, .modes = {.count = modes}, .error_indicators = false});
}

/// Two models with some degrees of freedom in common, given by their places in each.
LinearModel coupled(const LinearModel& one, const std::vector<Index>& of_one, const LinearModel& other,
                    const std::vector<Index>& of_other) {
  std::vector<Index> place(static_cast<std::size_t>(other.size()), -1);
  for (std::size_t i = 0; i < of_one.size(); ++i) place[static_cast<std::size_t>(of_other[i])] = of_one[i];
  Index size = one.size();
  for (auto& index : place)
    if (index < 0) index = size++;
  const auto sum = [&](const SparseMatrix& a, const SparseMatrix& b) {
    MatrixXd total = MatrixXd::Zero(size, size);
    total.topLeftCorner(one.size(), one.size()) = MatrixXd(a);
    total(place, place) += MatrixXd(b);
    return SparseMatrix(total.sparseView());
  };
  LinearModel model;
  model.dofs.resize(static_cast<std::size_t>(size));
  model.mass = sum(one.mass, other.mass);
  model.stiffness = sum(one.stiffness, other.stiffness);
  return model;
}

std::vector<Index> first(std::size_t count) {
  std::vector<Index> places(count);
  for (std::size_t i = 0; i < count; ++i) places[i] = static_cast<Index>(i);
  return places;
}

/// Two free beams joined at their ends: each is reduced with that end as boundary.
struct TwoBeams {
  LinearModel left = lattice::beam(40), right = lattice::beam(30);
  Names left_end = {"40.y", "40.rz"}, right_end = {"0.y", "0.rz"};

  [[nodiscard]] VectorXd exact(Index count) const { return frequencies(coupled(left, {80, 81}, right, {0, 1}), count); }
  template <typename Reduce>
  VectorXd from_parts(Index count, const Reduce& reduce) const {
    const Superelement one = reduce(left, left_end), other = reduce(right, right_end);
    return frequencies(coupled(one.model, first(2), other.model, first(2)), count);
  }
};

double largest_error(const VectorXd& found, const VectorXd& exact) {
  return ((found - exact).array().abs() / exact.array().max(1e-3)).maxCoeff();
}

TEST(FreeInterface, WithAllModesIsTheFullModel) {
  for (const double support : {0.0, 50.0}) {
    const LinearModel full = lattice::model({.columns = 10, .rows = 10, .support = support});
    const Names corners = {"0_0", "0_9", "9_0", "9_9"};
    for (const auto kind : {FreeInterfaceKind::rubin, FreeInterfaceKind::macneal}) {
      const Superelement element = reduced(full, corners, 100, kind);
      EXPECT_EQ(element.model.size(), 100);
      EXPECT_EQ(element.error_indicators.next_left_out, 0.0);
      // a change of coordinates: rounding times the condition of T, found 3e-13 Hz and 7e-15
      EXPECT_LT((frequencies(element.model, 100) - frequencies(full, 100)).cwiseAbs().maxCoeff(), 5e-12);
      EXPECT_LT((MatrixXd(element.model.damping) - element.basis.transpose() * full.damping * element.basis).norm(),
                7e-14);
    }
    EXPECT_NE(reduced(full, corners, 100, FreeInterfaceKind::macneal).error_indicators.reason.find("MacNeal"),
              std::string::npos);
  }
}

TEST(FreeInterface, BoundaryComesFirstUnderItsOwnNames) {
  const LinearModel full = lattice::model({.support = 20.0});
  for (const auto kind : {FreeInterfaceKind::rubin, FreeInterfaceKind::macneal}) {
    const Superelement element =
        free_interface(full, {"9_9", "0_3"}, {.kind = kind, .modes = {.count = 3}, .also_kept = {"4_4", "9_9"}});
    EXPECT_EQ(element.model.dofs, (Names{"9_9", "0_3", "4_4", "mode1", "mode2", "mode3"}));
    // rounding
    for (Index j = 0; j < 3; ++j)
      EXPECT_LT((element.basis.row(element.boundary[std::size_t(j)]) - VectorXd::Unit(6, j).transpose()).norm(), 5e-15);
    for (const SparseMatrix* matrix : {&element.model.mass, &element.model.damping, &element.model.stiffness})
      EXPECT_EQ(MatrixXd(*matrix), MatrixXd(matrix->transpose()));
  }
}

TEST(FreeInterface, ModesKeptAreExactWhileNothingIsAttached) {
  for (const double support : {0.0, 100.0}) {
    const LinearModel full = lattice::model({.columns = 30, .rows = 20, .support = support});
    const VectorXd exact = frequencies(full, 12);
    for (const auto kind : {FreeInterfaceKind::rubin, FreeInterfaceKind::macneal}) {
      const Superelement element = free_interface(full, {"29_0", "29_19", "15_10"},
                                                  {.kind = kind, .modes = {.count = 12}, .compare_up_to = exact[10]});
      // found 5e-11, of the free lattice: its stiffness is factored with a small shift
      EXPECT_LT(largest_error(frequencies(element.model, 12), exact), 5e-10);
      ASSERT_GE(element.error_indicators.modes.size(), 10u);
      for (const auto& mode : element.error_indicators.modes) {
        EXPECT_GT(mode.mac, 1.0 - 1e-12);
        EXPECT_LT(mode.residual, 3e-8);  // found 3e-9, for the same reason
      }
      EXPECT_EQ(element.error_indicators.rigid_modes, support == 0.0 ? 1 : 0);
      EXPECT_GT(element.error_indicators.next_left_out, element.error_indicators.highest_kept);
      EXPECT_GT(element.error_indicators.solves, 3);
    }
  }
}

TEST(FreeInterface, StaticsAtTheBoundaryAreExactWithAnyNumberOfModes) {
  const LinearModel full = lattice::model({.columns = 40, .rows = 30, .support = 10.0});
  const Names boundary = {"39_0", "39_29", "20_11"};
  const SparseFactor factor(full.stiffness);
  for (const auto kind : {FreeInterfaceKind::rubin, FreeInterfaceKind::macneal})
    for (const Index count : {0, 1, 7}) {
      const Superelement element = reduced(full, boundary, count, kind);
      EXPECT_LT(element.error_indicators.static_error, 1e-13);  // rounding
      const MatrixXd stiffness(element.model.stiffness);
      for (std::size_t j = 0; j < boundary.size(); ++j) {
        const VectorXd exact = factor.solve(VectorXd::Unit(full.size(), element.boundary[j]));
        const VectorXd found = stiffness.ldlt().solve(VectorXd::Unit(stiffness.rows(), Index(j)));
        // rounding times the condition 1e4
        EXPECT_LT((element.recover(found) - exact).norm(), 5e-12 * exact.norm()) << count;
      }
    }
}

TEST(FreeInterface, RigidBodyMotionsOfAFreeComponentAreExact) {
  const LinearModel full = lattice::beam(200);
  MatrixXd motions(full.size(), 2);
  for (Index i = 0; i < full.size(); i += 2) motions.middleRows(i, 2) << 1.0, double(i) / 400.0, 0.0, 1.0;
  const MatrixXd inertia = motions.transpose() * full.mass * motions;
  for (const Names& boundary : {Names{"0.y"}, Names{"100.y", "100.rz"}, Names{"0.y", "37.rz", "200.y"}})
    for (const auto kind : {FreeInterfaceKind::rubin, FreeInterfaceKind::macneal}) {
      const Superelement element = reduced(full, boundary, 5, kind);
      EXPECT_EQ(element.error_indicators.rigid_modes, 2);
      EXPECT_EQ(element.model.size(), Index(boundary.size()) + 5);
      const MatrixXd q = element.basis.colPivHouseholderQr().solve(motions);
      // rounding times the condition of 200 elements
      EXPECT_LT((element.basis * q - motions).norm(), 1e-9 * motions.norm());
      EXPECT_LT((element.model.stiffness * q).norm(), 1e-10 * element.model.stiffness.norm() * q.norm());
      if (kind == FreeInterfaceKind::rubin) {
        EXPECT_LT((q.transpose() * element.model.mass * q - inertia).norm(), 1.5e-11 * inertia.norm());
      }
      // the bending modes of the free beam, (beta L)^2 = 22.3733, 61.6728 (EI = 100, rho A = 2, L = 1): six digits
      const VectorXd found = frequencies(element.model, 4);
      EXPECT_NEAR(found[2], 22.3733 * std::sqrt(50.0) / (2.0 * std::numbers::pi), 6e-5);
      EXPECT_NEAR(found[3], 61.6728 * std::sqrt(50.0) / (2.0 * std::numbers::pi), 6e-5);
    }
}

TEST(FreeInterface, TwoFreeBeamsCoupledAreTheWhole) {
  const TwoBeams beams;
  const VectorXd exact = beams.exact(10);
  const auto with = [&](Index modes, FreeInterfaceKind kind) {
    return beams.from_parts(10, [&](const auto& model, const auto& end) { return reduced(model, end, modes, kind); });
  };
  const VectorXd all = with(1000, FreeInterfaceKind::rubin);
  EXPECT_LT(all[1], 1e-3);  // two rigid-body modes, but for the root of rounding: sqrt(eps) times 4e5 rad/s, over 2 pi
  // found 5e-9: rounding times the condition of 70 elements
  EXPECT_LT(largest_error(all.tail(8), exact.tail(8)), 5e-8);
  const VectorXd rubin = with(8, FreeInterfaceKind::rubin);
  // upper bounds, but for the rounding of the rigid-body modes
  EXPECT_TRUE((rubin.array() >= exact.array() * (1.0 - 1e-8) - 1e-4).all());
  EXPECT_LT(largest_error(rubin.tail(8), exact.tail(8)), 2e-5);  // found 8e-6
}

/// Free modes alone (and no residual), coupled at the end by making the boundary's displacements equal.
VectorXd truncated(const TwoBeams& beams, Index modes, Index count) {
  const auto alone = [&](const LinearModel& model) {
    return lowest_modes(model.stiffness, model.mass, {.count = modes});
  };
  const LowestModes one = alone(beams.left), other = alone(beams.right);
  MatrixXd gap(2, 2 * modes);
  gap << one.vectors.bottomRows(2), -other.vectors.topRows(2);
  const MatrixXd closed = Eigen::FullPivLU<MatrixXd>(gap).kernel();
  VectorXd values(2 * modes);
  values << one.values, other.values;
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> pairs(closed.transpose() * values.asDiagonal() * closed,
                                                                 closed.transpose() * closed);
  return pairs.eigenvalues().head(count).cwiseMax(0.0).cwiseSqrt() / (2.0 * std::numbers::pi);
}

TEST(FreeInterface, ResidualsConvergeFasterThanTruncationAndRubinFasterThanMacNeal) {
  const TwoBeams beams;
  const VectorXd exact = beams.exact(6);
  const auto error = [&](const VectorXd& found) { return largest_error(found.tail(4), exact.tail(4)); };
  double last = 1.0;
  for (const Index modes : {5, 7, 10}) {
    const auto with = [&](FreeInterfaceKind kind) {
      return error(
          beams.from_parts(6, [&](const auto& model, const auto& end) { return reduced(model, end, modes, kind); }));
    };
    const double rubin = with(FreeInterfaceKind::rubin), macneal = with(FreeInterfaceKind::macneal);
    const double without = error(truncated(beams, modes, 6));
    const std::string figure = "free_interface." + std::to_string(modes) + ".";
    test::expect_figure(figure + "truncated", without);
    test::expect_figure(figure + "macneal", macneal);
    test::expect_figure(figure + "rubin", rubin);
    EXPECT_LT(rubin, 0.02 * macneal);  // found at most .0066, .0045 and .024
    EXPECT_LT(macneal, 0.015 * without);
    EXPECT_LT(rubin, 0.06 * last);
    last = rubin;
  }
  EXPECT_LT(last, 4e-9);
}

TEST(FreeInterface, AHeldAndAFreeLatticeCoupledAlongAnEdge) {
  const Index rows = 8;
  const LinearModel held = lattice::model({.columns = 14, .rows = rows, .support = 80.0});
  const LinearModel free = lattice::model({.columns = 12, .rows = rows});
  std::vector<Index> of_held, of_free;
  for (Index y = 0; y < rows; ++y) {
    of_held.push_back(13 * rows + y);
    of_free.push_back(y);
  }
  const VectorXd exact = frequencies(coupled(held, of_held, free, of_free), 15);
  const auto error = [&](Index modes, FreeInterfaceKind kind) {
    const Superelement one = reduced(held, edge(13, rows), modes, kind),
                       other = reduced(free, edge(0, rows), modes, kind);
    const LinearModel both = coupled(one.model, first(rows), other.model, first(rows));
    return largest_error(frequencies(both, 15), exact);
  };
  EXPECT_LT(error(1000, FreeInterfaceKind::rubin), 1e-10);  // rounding times the condition
  const double rubin = error(25, FreeInterfaceKind::rubin), macneal = error(25, FreeInterfaceKind::macneal);
  EXPECT_LT(rubin, 2.5e-5);  // found 8.5e-6, 6.6e-4
  EXPECT_LT(rubin, 0.04 * macneal);
  EXPECT_LT(macneal, 2e-3);
}

TEST(FreeInterface, MacNealsMassIsThatOfTheModesAlone) {
  const LinearModel full = lattice::model({.columns = 12, .rows = 9, .support = 40.0});
  const Superelement element = reduced(full, {"11_0", "5_5"}, 6, FreeInterfaceKind::macneal);
  MatrixXd expected = MatrixXd::Identity(8, 8);
  expected.topLeftCorner(2, 2).setZero();
  EXPECT_EQ(MatrixXd(element.model.mass), expected);
  // the stiffness is the projection of the full one all the same
  const MatrixXd projected = element.basis.transpose() * full.stiffness * element.basis;
  EXPECT_LT((MatrixXd(element.model.stiffness) - projected).norm(), 2e-14 * projected.norm());  // rounding
  // a mass at the boundary makes it regular, and the frequencies those of the whole with that mass, but for the
  // residual's own mass
  LinearModel loaded = element.model, exact = full;
  for (std::size_t j = 0; j < 2; ++j) {
    loaded.mass.coeffRef(Index(j), Index(j)) += 3.0;
    exact.mass.coeffRef(element.boundary[j], element.boundary[j]) += 3.0;
  }
  EXPECT_LT(largest_error(frequencies(loaded, 4), frequencies(exact, 4)), 1e-2);  // found .0038
}

TEST(FreeInterface, DampingAndPointsAndGroundsAreCarriedOver) {
  LinearModel full = lattice::model({.columns = 12, .rows = 9, .support = 40.0});
  full.points["mean"] = {{"3_3", 0.25}, {"8_8", 0.75}};
  add_modal_damping(full, {0.02, 0.05}, {.count = 10});
  const MatrixXd mass_weighted_modes = full.mass * full.modal_damping.modes.shapes;
  const MatrixXd C = MatrixXd(full.damping) +
                     mass_weighted_modes * full.modal_damping.rates.asDiagonal() * mass_weighted_modes.transpose();
  for (const auto kind : {FreeInterfaceKind::rubin, FreeInterfaceKind::macneal}) {
    const Superelement element = reduced(full, {"11_0", "5_5"}, 8, kind);
    const MatrixXd expected = element.basis.transpose() * C * element.basis;
    // rounding, as all of these
    EXPECT_LT((MatrixXd(element.model.damping) - expected).norm(), 4e-14 * expected.norm());
    const VectorXd q = VectorXd::LinSpaced(10, -1.0, 2.0), z = element.recover(q);
    double mean = 0.0;
    for (const auto& [dof, coefficient] : element.model.points.at("mean"))
      mean += coefficient * q[std::ranges::find(element.model.dofs, dof) - element.model.dofs.begin()];
    EXPECT_NEAR(mean, 0.25 * z[30] + 0.75 * z[80], 4e-15);
    ASSERT_EQ(element.model.grounds.size(), 1u);
    EXPECT_LT((element.model.grounds[0].stiffness - element.basis.transpose() * full.grounds[0].stiffness).norm(),
              1e-13);
  }
}

TEST(FreeInterface, WithoutABoundaryOrWithoutAnInterior) {
  const LinearModel full = lattice::model({.columns = 24, .rows = 17});
  const Superelement element = free_interface(full, {}, {.modes = {.count = 7}});
  EXPECT_EQ(element.error_indicators.rigid_modes, 1);
  // found 1.6e-10: the free lattice's stiffness is factored with a small shift
  EXPECT_LT((frequencies(element.model, 7) - frequencies(full, 7)).norm(), 2e-9);
  const LinearModel small = lattice::model({.columns = 3, .rows = 2});
  EXPECT_EQ(reduced(small, small.dofs, 3).basis, MatrixXd::Identity(6, 6));
}

TEST(FreeInterface, KeepsAllModesUpToACutOff) {
  const LinearModel full = lattice::model({.columns = 30, .rows = 20, .support = 100.0});
  const Superelement element = free_interface(full, {"29_0"}, {.modes = {.cutoff = 4.0}});
  EXPECT_LE(element.error_indicators.highest_kept, 4.0);
  EXPECT_GT(element.error_indicators.next_left_out, 4.0);
  EXPECT_EQ(element.model.size(), 1 + element.error_indicators.fixed_interface_frequencies.size());
  EXPECT_NE(element.error_indicators.reason.find("up to 4 Hz"), std::string::npos);
}

TEST(FreeInterface, SaysWhatIsWrongWithTheInput) {
  const LinearModel full = lattice::model({.columns = 4, .rows = 4, .support = 1.0});
  try {
    reduced(full, {"0_0", "0_O", "3_3", "nothing_like", "0_0"}, 1);
    ADD_FAILURE();
  } catch (const InvalidInput& error) {
    ASSERT_EQ(error.issues().size(), 3u);
    EXPECT_NE(error.issues()[0].what.find("did you mean '0_"), std::string::npos) << error.what();
    EXPECT_NE(error.issues()[2].what.find("twice"), std::string::npos);
  }
  EXPECT_THROW(free_interface(full, {"0_0"}, {}), InvalidInput);
  EXPECT_THROW(free_interface(full, {"0_0"}, {.modes = {.count = -1}}), InvalidInput);
  EXPECT_THROW(free_interface(full, {"0_0"}, {.modes = {.cutoff = -1.0}}), InvalidInput);
  EXPECT_THROW(free_interface(full, {"0_0"}, {.modes = {.count = 3, .effective_mass = 0.9}}), InvalidInput);
  LinearModel loose = full;
  loose.stiffness.coeffRef(5, 5) = -1.0;
  EXPECT_THROW(reduced(loose, {"0_0"}, 1), InvalidInput);
}

}  // namespace
}  // namespace kalfem
