// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <numbers>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/linalg/lowest_modes.hpp"
#include "kalfem/model/linear_model.hpp"
#include "kalfem/reduction/superelement.hpp"
#include "reduction/frequencies.hpp"
#include "reduction/lattice.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using lattice::edge;
using test::frequencies;

const std::vector<std::string> corners = {"0_0", "0_9", "9_0", "9_9"};

TEST(CraigBampton, WithAllModesIsTheFullModel) {
  const LinearModel full = lattice::model({.columns = 10, .rows = 10, .support = 50.0});
  const Superelement element = craig_bampton(full, corners, {.modes = {.count = 96}});
  EXPECT_EQ(element.model.size(), 100);
  EXPECT_EQ(element.error_indicators.next_left_out, 0.0);
  // a change of coordinates: rounding times the condition of T, found 6e-13 Hz and 6e-15
  EXPECT_LT((frequencies(element.model, 100) - frequencies(full, 100)).cwiseAbs().maxCoeff(), 7e-12);
  EXPECT_LT((MatrixXd(element.model.damping) - element.basis.transpose() * full.damping * element.basis).norm(), 7e-14);
  // compliance between the kept degrees of freedom and anything else; rounding times the condition
  const MatrixXd load = element.basis.transpose();
  const MatrixXd reduced = element.recover(MatrixXd(element.model.stiffness).llt().solve(load));
  const MatrixXd exact = MatrixXd(full.stiffness).inverse();
  EXPECT_LT((reduced - exact).norm(), 2e-13 * exact.norm());
}

TEST(CraigBampton, WithoutModesIsGuyan) {
  const LinearModel full = lattice::model({.support = 50.0});
  const Superelement none = craig_bampton(full, corners, {.modes = {.count = 0}}), static_one = guyan(full, corners);
  EXPECT_EQ(MatrixXd(none.model.mass), MatrixXd(static_one.model.mass));
  // the Schur complement by dense algebra
  const MatrixXd K(full.stiffness);
  std::vector<Index> interior;
  for (Index i = 0; i < 100; ++i)
    if (std::ranges::find(none.boundary, i) == none.boundary.end()) interior.push_back(i);
  const MatrixXd K_bi = K(none.boundary, interior), K_ii = K(interior, interior);
  const MatrixXd schur = K(none.boundary, none.boundary) - K_bi * K_ii.llt().solve(MatrixXd(K_bi.transpose()));
  EXPECT_LT((MatrixXd(static_one.model.stiffness) - schur).norm(), 1e-14 * schur.norm());  // rounding
  EXPECT_GT(static_one.error_indicators.next_left_out, 0.0);
}

TEST(CraigBampton, FrequenciesFallToTheFullOnes) {
  const LinearModel full = lattice::model({.columns = 30, .rows = 20, .support = 100.0});
  const std::vector<std::string> boundary = {"0_0", "0_19", "29_0", "29_19", "15_10"};
  const VectorXd exact = frequencies(full, 5);
  // rounding of two solutions by iteration
  VectorXd last = VectorXd::Constant(5, std::numeric_limits<double>::infinity());
  for (const Index count : {0, 1, 4, 16, 64, 200}) {
    const Superelement element = craig_bampton(full, boundary, {.modes = {.count = count}, .error_indicators = false});
    const VectorXd reduced = frequencies(element.model, 5);
    EXPECT_TRUE((reduced.array() >= exact.array() * (1.0 - 1e-12)).all()) << count;
    EXPECT_TRUE((reduced.array() <= last.array() * (1.0 + 1e-12)).all()) << count;
    last = reduced;
  }
  EXPECT_LT(((last - exact).array() / exact.array()).maxCoeff(), 1.5e-5);  // found 5.6e-6 with 200 of 595 modes
}

double worst_error(const ReductionErrorIndicators& error_indicators) {
  double worst = 0.0;
  for (const auto& mode : error_indicators.modes) worst = std::max(worst, mode.reduced / mode.full - 1.0);
  return worst;
}

TEST(CraigBampton, BelowHalfTheCutOffFrequenciesAreRight) {
  const LinearModel full = lattice::model({.columns = 60, .rows = 40, .support = 100.0});
  const std::vector<std::string> boundary = edge(59, 40);
  const auto reduced = [&](bool augmentation_vectors) {
    return craig_bampton(
        full, boundary, {.modes = {.cutoff = 8.0}, .augmentation_vectors = augmentation_vectors, .compare_up_to = 4.0});
  };
  const Superelement element = reduced(true), without = reduced(false);
  const auto& error_indicators = element.error_indicators;
  EXPECT_LE(error_indicators.highest_kept, 8.0);
  EXPECT_GT(error_indicators.next_left_out, 8.0);
  ASSERT_GT(error_indicators.modes.size(), 10u);
  for (const auto& mode : error_indicators.modes) {
    EXPECT_LE(mode.full, 4.0 + 1e-3);
    EXPECT_LT(1.0 - mode.reduced / mode.full, 2e-11);  // an upper bound, but for rounding of the whole model's solution
    EXPECT_LT(1.0 - mode.mac, 1e-5) << mode.full;
  }
  EXPECT_LT(worst_error(error_indicators), 1.2e-5);  // found 4.4e-6; 2.7e-4 without the vectors
  EXPECT_LT(worst_error(error_indicators),
            0.04 * worst_error(without.error_indicators));  // the vectors are what does it
  EXPECT_LT(error_indicators.static_error, 1e-14);          // rounding
}

// The others are there for other uses: the comparison is that of the modes in the band alone.
TEST(CraigBampton, AsManyModesOfTheFullModelAreComputedAsAreAskedFor) {
  const LinearModel full = lattice::model({.columns = 60, .rows = 40, .support = 100.0});
  const auto reduced = [&](Index full_modes) {
    return craig_bampton(
        full, edge(59, 40),
        {.modes = {.cutoff = 8.0}, .augmentation_vectors = true, .compare_up_to = 4.0, .full_modes = full_modes});
  };
  const Superelement few = reduced(0), many = reduced(150);
  const auto compared = static_cast<Index>(few.error_indicators.modes.size());
  EXPECT_EQ(few.full_modes->frequencies.size(), compared);
  const auto& [frequencies, shapes] = *many.full_modes;
  ASSERT_EQ(frequencies.size(), 150);
  EXPECT_EQ(shapes.cols(), 150);
  EXPECT_LT((frequencies - lowest_normal_modes(full, {150}).frequencies).norm(), 1e-10 * frequencies[149]);
  ASSERT_EQ(many.error_indicators.modes.size(), few.error_indicators.modes.size());
  for (std::size_t i = 0; i < many.error_indicators.modes.size(); ++i) {
    EXPECT_NEAR(many.error_indicators.modes[i].full, few.error_indicators.modes[i].full, 1e-9 * frequencies[149]);
    EXPECT_NEAR(many.error_indicators.modes[i].mac, few.error_indicators.modes[i].mac, 1e-6);
  }
}

TEST(CraigBampton, NoTruncationVectorsAreLeftWhereAllModesAreKept) {
  const LinearModel full = lattice::model({.columns = 10, .rows = 10, .support = 50.0});
  EXPECT_EQ(craig_bampton(full, corners, {.modes = {.count = 96}, .augmentation_vectors = true}).model.size(), 100);
  EXPECT_EQ(craig_bampton(full, corners, {.modes = {.count = 10}, .augmentation_vectors = true}).model.size(), 18);
}

TEST(CraigBampton, TruncationVectorsAreUncoupledFromTheModes) {
  const LinearModel full = lattice::model({.columns = 20, .rows = 10, .support = 50.0});
  const Superelement element =
      craig_bampton(full, {"0_0", "0_9", "19_5"}, {.modes = {.count = 6}, .augmentation_vectors = true});
  const MatrixXd mass = element.basis.transpose() * full.mass * element.basis,
                 stiffness = element.basis.transpose() * full.stiffness * element.basis;
  // rounding of the products, found 7e-17 and 1e-14 of their size
  EXPECT_LT((mass - MatrixXd(element.model.mass)).norm(), 1e-15 * mass.norm());
  EXPECT_LT((stiffness - MatrixXd(element.model.stiffness)).norm(), 1e-13 * stiffness.norm());
}

TEST(CraigBampton, StaticsAtTheBoundaryAreExactWithAnyNumberOfModes) {
  const LinearModel full = lattice::model({.columns = 40, .rows = 30, .support = 10.0});
  const std::vector<std::string> boundary = {"39_0", "39_29", "20_11"};
  const SparseFactor factor(full.stiffness);
  for (const Index count : {0, 3}) {
    const Superelement element = craig_bampton(full, boundary, {.modes = {.count = count}, .error_indicators = false});
    const MatrixXd flexible(element.model.stiffness);
    for (std::size_t j = 0; j < boundary.size(); ++j) {
      const VectorXd exact = factor.solve(VectorXd::Unit(full.size(), element.boundary[j]));
      const VectorXd reduced = flexible.llt().solve(VectorXd::Unit(flexible.rows(), Index(j)));
      EXPECT_LT((element.recover(reduced) - exact).norm(), 3e-12 * exact.norm());  // rounding times the condition 1e4
    }
    // and the ground's displacement moves the whole as a rigid body
    const VectorXd carried = element.recover(flexible.llt().solve(element.model.grounds[0].stiffness));
    // found .031: exact where the boundary is, about elsewhere
    EXPECT_LT((carried - VectorXd::Ones(full.size())).cwiseAbs().maxCoeff(), 0.07);
    EXPECT_NEAR(carried[element.boundary[2]], 1.0, 6e-12);  // rounding
  }
}

TEST(CraigBampton, TwoCoupledPartsAreTheWhole) {
  // one model in one piece; cut at column 12, its two halves share the nodes there (masses and springs of the cut
  // column belong to the left part)
  const Index rows = 8;
  LinearModel whole = lattice::model({.columns = 25, .rows = rows, .support = 30.0});
  const Index left_size = 13 * rows;
  SparseMatrix left_K = whole.stiffness, left_M = whole.mass;
  const auto in_left = [&](Index i, Index j) { return i < left_size && j < left_size; };
  LinearModel left, right;
  left.dofs.assign(whole.dofs.begin(), whole.dofs.begin() + left_size);
  right.dofs.assign(whole.dofs.begin() + left_size - rows, whole.dofs.end());
  left.mass = left_M.topLeftCorner(left_size, left_size);
  left.stiffness = left_K.topLeftCorner(left_size, left_size);
  // the springs beyond the cut load its nodes: they belong to the right part
  const Index right_size = right.dofs.size();
  std::vector<Eigen::Triplet<double>> mass, stiffness;
  for (Index j = 0; j < whole.size(); ++j)
    for (SparseMatrix::InnerIterator it(whole.stiffness, j); it; ++it)
      if (!in_left(it.row(), j)) stiffness.emplace_back(it.row() - left_size + rows, j - left_size + rows, it.value());
  for (Index y = 0; y < rows; ++y) {
    const Index cut = left_size - rows + y;
    const double beyond = -whole.stiffness.coeff(cut, cut + rows);
    left.stiffness.coeffRef(cut, cut) -= beyond;
    stiffness.emplace_back(y, y, beyond);
  }
  for (Index i = left_size; i < whole.size(); ++i)
    mass.emplace_back(i - left_size + rows, i - left_size + rows, whole.mass.coeff(i, i));
  right.mass = lattice::from(right_size, mass);
  right.stiffness = lattice::from(right_size, stiffness);
  left.damping = SparseMatrix(left_size, left_size);
  right.damping = SparseMatrix(right_size, right_size);

  const auto couple = [&](Index modes) {
    const ReductionOptions options{.modes = {.count = modes}, .error_indicators = false};
    const Superelement one = craig_bampton(left, edge(12, rows), options);
    const Superelement two = craig_bampton(right, edge(12, rows), options);
    const Index m = one.model.size() - rows, n = two.model.size() - rows;
    const auto assembled = [&](const SparseMatrix& a, const SparseMatrix& b) {
      const MatrixXd A(a), B(b);
      MatrixXd sum = MatrixXd::Zero(rows + m + n, rows + m + n);
      sum.topLeftCorner(rows + m, rows + m) = A;
      std::vector<Index> places;
      for (Index i = 0; i < rows; ++i) places.push_back(i);
      for (Index i = 0; i < n; ++i) places.push_back(rows + m + i);
      sum(places, places) += B;
      return SparseMatrix(sum.sparseView());
    };
    LinearModel model;
    model.mass = assembled(one.model.mass, two.model.mass);
    model.stiffness = assembled(one.model.stiffness, two.model.stiffness);
    return frequencies(model, 20);
  };
  const VectorXd exact = frequencies(whole, 20);
  EXPECT_LT((couple(1000) - exact).cwiseAbs().maxCoeff(), 4e-12 * exact[19]);    // all modes: rounding
  EXPECT_LT(((couple(60) - exact).array() / exact.array()).maxCoeff(), 2.5e-4);  // found 9.5e-5
}

TEST(CraigBampton, AnInteriorThatIsFreeToMoveKeepsItsRigidBodyModes) {
  // a free beam held by one translation turns about it
  const LinearModel full = lattice::beam(300);
  for (const char* boundary : {"0.y", "150.y", "300.y"}) {
    const Superelement element = craig_bampton(full, {boundary}, {.modes = {.count = 6}});
    EXPECT_EQ(element.error_indicators.rigid_modes, 1);
    EXPECT_EQ(element.error_indicators.fixed_interface_frequencies[0], 0.0);
    EXPECT_LT(element.error_indicators.static_error, 1e-13);  // rounding
    EXPECT_EQ(element.error_indicators.modes[0].reduced, 0.0);
    EXPECT_EQ(element.error_indicators.modes[1].reduced, 0.0);
    EXPECT_EQ(element.model.stiffness.coeff(0, 0), 0.0);  // its one boundary coordinate moves the whole
    // found 7e-5 with six modes
    EXPECT_NEAR(element.error_indicators.modes[2].reduced / element.error_indicators.modes[2].full, 1.0, 2e-4);
    // exact at zero frequency: both rigid-body motions of the beam, without force; rounding times the condition of 300
    // elements
    MatrixXd motions(full.size(), 2);
    for (Index i = 0; i < full.size(); i += 2) motions.middleRows(i, 2) << 1.0, double(i) / 600.0, 0.0, 1.0;
    const MatrixXd& T = element.basis;
    const MatrixXd q = T.colPivHouseholderQr().solve(motions);
    EXPECT_LT((T * q - motions).norm(), 1.5e-9 * motions.norm());
    EXPECT_LT((element.model.stiffness * q).norm(), 6e-10 * element.model.stiffness.norm() * q.norm());
    const MatrixXd inertia = motions.transpose() * full.mass * motions;
    EXPECT_LT((q.transpose() * element.model.mass * q - inertia).norm(), 1.5e-11 * inertia.norm());
  }
  const Superelement none = guyan(full, {"150.y"});
  EXPECT_EQ(none.model.size(), 2);
  EXPECT_EQ(guyan(full, {"0.y", "300.y"}).model.size(), 2);  // held by two: nothing to add
}

TEST(CraigBampton, WithoutABoundaryTheModesAreTheModelsOwn) {
  const LinearModel full = lattice::model({.columns = 24, .rows = 17});
  const Superelement element = craig_bampton(full, {}, {.modes = {.count = 7}});
  EXPECT_EQ(element.error_indicators.rigid_modes, 1);
  EXPECT_LT((element.error_indicators.fixed_interface_frequencies - frequencies(full, 7)).norm(),
            1e-12);  // the same computation
  std::vector<std::string> everything = lattice::model({.columns = 3, .rows = 2}).dofs;
  const Superelement whole =
      craig_bampton(lattice::model({.columns = 3, .rows = 2}), everything, {.modes = {.count = 3}});
  EXPECT_EQ(whole.basis, MatrixXd::Identity(6, 6));
}

TEST(CraigBampton, DampingIsTheProjectionOfTheWholeOfIt) {
  LinearModel full = lattice::model({.columns = 12, .rows = 9, .support = 40.0});
  add_modal_damping(full, {0.02, 0.05}, {.count = 10});
  const MatrixXd mass_weighted_modes = full.mass * full.modal_damping.modes.shapes;
  const MatrixXd C = MatrixXd(full.damping) +
                     mass_weighted_modes * full.modal_damping.rates.asDiagonal() * mass_weighted_modes.transpose();
  const Superelement element = craig_bampton(full, {"11_0", "5_5"}, {.modes = {.count = 8}});
  const MatrixXd expected = element.basis.transpose() * C * element.basis;
  EXPECT_LT((MatrixXd(element.model.damping) - expected).norm(), 4e-14 * expected.norm());  // rounding
  EXPECT_EQ(element.model.modal_damping.rates.size(), 0);
  for (const SparseMatrix* matrix : {&element.model.mass, &element.model.damping, &element.model.stiffness})
    EXPECT_EQ(MatrixXd(*matrix), MatrixXd(matrix->transpose()));
}

TEST(CraigBampton, PointsAndSensorsAreCarriedAlong) {
  LinearModel full = lattice::model({.columns = 9, .rows = 9, .support = 20.0});
  full.points["mean"] = {{"3_3", 0.25}, {"8_8", 0.75}};
  const Superelement element = craig_bampton(full, {"8_8"}, {.modes = {.count = 5}, .also_kept = {"4_4", "8_8"}});
  EXPECT_EQ(element.model.dofs, (std::vector<std::string>{"8_8", "4_4", "mode1", "mode2", "mode3", "mode4", "mode5"}));
  const VectorXd q = VectorXd::LinSpaced(7, -1.0, 2.0), z = element.recover(q);
  EXPECT_EQ(z[40], q[1]);
  double mean = 0.0;
  for (const auto& [dof, coefficient] : element.model.points.at("mean"))
    mean += coefficient * q[std::ranges::find(element.model.dofs, dof) - element.model.dofs.begin()];
  EXPECT_NEAR(mean, 0.25 * z[30] + 0.75 * z[80], 4e-15);  // rounding
}

TEST(CraigBampton, EffectiveMassChoosesTheFewestModes) {
  const LinearModel full = lattice::model({.columns = 30, .rows = 20});
  const std::vector<std::string> boundary = edge(0, 20);
  const auto part = [&](Index count) {
    const Superelement element = craig_bampton(full, boundary, {.modes = {.count = count}, .error_indicators = false});
    // held along an edge the interior follows as a whole: its mass is the sum of the masses
    VectorXd following = VectorXd::Ones(600);
    following(element.boundary).setZero();
    const MatrixXd shapes = element.basis.rightCols(count);
    return (shapes.transpose() * (full.mass * following)).squaredNorm() / following.dot(full.mass * following);
  };
  const Superelement element =
      craig_bampton(full, boundary, {.modes = {.effective_mass = 0.9}, .error_indicators = false});
  const Index kept = element.error_indicators.fixed_interface_frequencies.size();
  EXPECT_GE(part(kept), 0.9);
  EXPECT_LT(part(kept - 1), 0.9);
  const Superelement both =
      craig_bampton(full, boundary, {.modes = {.count = 60, .effective_mass = 0.9}, .error_indicators = false});
  EXPECT_EQ(both.error_indicators.fixed_interface_frequencies.size(), std::max<Index>(60, kept));
}

TEST(CraigBampton, SaysWhatIsWrongWithTheInput) {
  const LinearModel full = lattice::model({.columns = 4, .rows = 4, .support = 1.0});
  try {
    craig_bampton(full, {"0_0", "0_O", "3_3", "nothing_like", "0_0"}, {.modes = {.count = 1}});
    ADD_FAILURE();
  } catch (const InvalidInput& error) {
    ASSERT_EQ(error.issues().size(), 3u);
    EXPECT_NE(error.issues()[0].what.find("did you mean '0_"), std::string::npos) << error.what();
    EXPECT_NE(error.issues()[2].what.find("twice"), std::string::npos);
  }
  EXPECT_THROW(craig_bampton(full, {"0_0"}, {}), InvalidInput);
  EXPECT_THROW(craig_bampton(full, {"0_0"}, {.modes = {.count = -1}}), InvalidInput);
  EXPECT_THROW(craig_bampton(full, {"0_0"}, {.modes = {.effective_mass = 1.0}}), InvalidInput);
  LinearModel loose = full;
  loose.stiffness.coeffRef(5, 5) = -1.0;
  try {
    craig_bampton(loose, {"0_0"}, {.modes = {.count = 1}});
    ADD_FAILURE();
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find('_'), std::string::npos) << error.what();  // by name
  }
}

TEST(ReductionWarnings, SpeakOfWhatIsMissing) {
  ReductionErrorIndicators error_indicators{
      .modes = {{10.0, 10.01, 0.99, 0.01}, {20.0, 21.0, 0.7, 0.1}, {90.0, 120.0, 0.1, 1.0}}};
  EXPECT_EQ(reduction_warnings(error_indicators, 50.0, 15.0).size(), 0u);
  EXPECT_EQ(reduction_warnings(error_indicators, 50.0, 30.0).size(), 1u);  // the second mode
  error_indicators.next_left_out = 40.0;
  EXPECT_EQ(reduction_warnings(error_indicators, 30.0, 12.0).size(), 0u);
  EXPECT_EQ(reduction_warnings(error_indicators, 50.0, 12.0).size(), 1u);
  EXPECT_EQ(reduction_warnings(error_indicators, 30.0, 15.0).size(), 1u);
  EXPECT_EQ(reduction_warnings(error_indicators, 50.0, 15.0).size(), 2u);
  error_indicators.static_error = 1e-3;
  EXPECT_EQ(reduction_warnings(error_indicators, 30.0, 12.0).size(), 1u);
}

TEST(ModalDamping, GivesEachModeItsRatioAndTheRestTheLastRate) {
  for (const double support : {0.0, 40.0}) {
    const LinearModel undamped = [&] {
      LinearModel model = lattice::model({.columns = 15, .rows = 9, .support = support});
      model.damping.setZero();
      return model;
    }();
    LinearModel model = undamped;
    add_modal_damping(model, {0.01, 0.02, 0.05}, {.count = 12});
    const LowestModes all = lowest_modes(model.stiffness, model.mass, {.count = 135});
    const MatrixXd mass_weighted_modes = model.mass * model.modal_damping.modes.shapes;
    const MatrixXd C = MatrixXd(model.damping) +
                       mass_weighted_modes * model.modal_damping.rates.asDiagonal() * mass_weighted_modes.transpose();
    const MatrixXd modal = all.vectors.transpose() * C * all.vectors;
    const VectorXd omega = all.values.cwiseSqrt();
    // rounding, found 2e-15 of the highest
    for (Index i = 0; i < 135; ++i) {
      const double ratio = i == 0 ? 0.01 : i == 1 ? 0.02 : 0.05;
      EXPECT_NEAR(modal(i, i), 2.0 * ratio * omega[std::min<Index>(i, 11)], 3e-14 * omega[11]) << i;
    }
    EXPECT_LT((modal - MatrixXd(modal.diagonal().asDiagonal())).norm(), 3e-14 * modal.norm());
    LinearModel open = undamped;
    add_modal_damping(open, {0.05}, {.count = 12, .damp_the_rest = false});
    EXPECT_EQ(open.damping.norm(), 0.0);
    EXPECT_NEAR(open.modal_damping.rates[11], 0.1 * omega[11], 1e-14 * omega[11]);
    LinearModel limited = undamped;
    const double limit = 0.5 * (omega[4] + omega[5]) / (2.0 * std::numbers::pi);
    add_modal_damping(limited, {0.05}, {.up_to = limit});
    EXPECT_EQ(limited.modal_damping.rates.size(), 5);
    const NormalModes known = lowest_normal_modes(model, {12}), computed = lowest_normal_modes(undamped, {12});
    EXPECT_LT((known.frequencies - computed.frequencies).norm(), 1e-14 * computed.frequencies[11]);
    EXPECT_EQ(lowest_normal_modes(model, {14}).shapes.cols(), 14);
    EXPECT_EQ(lowest_normal_modes(model, {12, limit}).shapes.cols(), 5);
    EXPECT_EQ(lowest_normal_modes(limited, {12, limit}).shapes.cols(), 5);
    EXPECT_EQ(lowest_normal_modes(limited, {3, limit}).shapes.cols(), 3);
    for (const LinearModel& each : {undamped, model, limited}) {
      const NormalModes seven = lowest_normal_modes(each, {12, limit, 7});
      EXPECT_LT((seven.frequencies - computed.frequencies.head(7)).norm(), 1e-14 * computed.frequencies[11]);
      EXPECT_EQ(seven.shapes.cols(), 7);
      EXPECT_EQ(lowest_normal_modes(each, {12, limit, 3}).shapes.cols(), 5);
    }
    EXPECT_THROW(add_modal_damping(limited, {0.05}, {.count = 2}), InvalidInput);
    EXPECT_THROW(add_modal_damping(open, {-0.05}, {}), InvalidInput);
  }
}

}  // namespace
}  // namespace kalfem
