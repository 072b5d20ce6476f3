// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <numbers>
#include <sstream>

#include "base/absent.hpp"
#include "base/data_folder.hpp"
#include "kalfem/dynamics/simulate.hpp"
#include "kalfem/formats/matrices/matrix_model.hpp"
#include "kalfem/linalg/lowest_modes.hpp"
#include "kalfem/linalg/sparse_operations.hpp"
#include "kalfem/prediction/base_driven.hpp"
#include "kalfem/reduction/superelement.hpp"
#include "kalfem/system/sensors/output_map.hpp"
#include "kalfem/system/signals/deterministic.hpp"
#include "model/assemble_parts.hpp"
#include "reduction/frequencies.hpp"

// Solid parts a and c and their assembly ac by a production code, with its Craig-Bampton model of a.

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::frequencies;

std::filesystem::path folder() { return data_folder("sandia-substructures"); }

LinearModel part(const std::string& name) {
  const std::string block = "block_" + name;
  return read_superelement({folder() / (block + "_K.mtx.gz"), folder() / (block + "_M.mtx.gz")},
                           {.dof_map = folder() / (block + "_node_ids.txt"), .map = {.directions = 3}})
      .model;
}

LinearModel superelement_of_a() { return read_superelement({folder() / "block_1-cbr.nc4"}).model; }

/// Names of the nodal degrees of freedom of a superelement.
std::vector<std::string> interface_of(const LinearModel& element) {
  std::vector<std::string> names;
  for (const auto& name : element.dofs)
    if (name.starts_with("n")) names.push_back(name);
  return names;
}

std::vector<Index> places(const LinearModel& model, const std::vector<std::string>& names) {
  std::vector<Index> found;
  for (const auto& name : names) found.push_back(std::ranges::find(model.dofs, name) - model.dofs.begin());
  return found;
}

double largest(const SparseMatrix& matrix) { return matrix.nonZeros() > 0 ? matrix.coeffs().abs().maxCoeff() : 0.0; }

constexpr double printed = 6e-7;  ///< [Hz]: the production code's table has six decimals

/// Column `name` of that table of frequencies [Hz]; shorter columns end early.
VectorXd published(const std::string& name) {
  std::ifstream file(folder() / "sierra_sd_frequencies_Hz.csv");
  std::string line, cell;
  std::getline(file, line);
  std::istringstream header(line.substr(0, line.find('\r')));
  Index column = 0;
  while (std::getline(header, cell, ',') && cell != name) ++column;
  std::vector<double> values;
  while (std::getline(file, line)) {
    std::istringstream cells(line);
    for (Index i = 0; i <= column; ++i)
      if (!std::getline(cells, cell, ',')) cell.clear();
    if (!cell.empty() && cell != "\r") values.push_back(std::stod(cell));
  }
  return Eigen::Map<VectorXd>(values.data(), static_cast<Index>(values.size()));
}

/// The reduced part with its modes under names of its own, so that joining does not make them one with another's.
LinearModel reduced(const LinearModel& full, const std::vector<std::string>& boundary, const std::string& prefix,
                    const std::vector<std::string>& also_kept = {}) {
  LinearModel model =
      craig_bampton(full, boundary, {.modes = {.count = 40}, .also_kept = also_kept, .error_indicators = false}).model;
  for (auto& name : model.dofs)
    if (name.starts_with("mode")) name = prefix + name;
  return model;
}

class Sandia : public testing::Test {
protected:
  void SetUp() override {
    if (!std::filesystem::exists(folder() / "block_1-cbr.nc4"))
      KALFEM_ABSENT("the production code's matrices are not at " + folder().string());
  }
};

TEST_F(Sandia, TwoPartsJoinedByNodeNumberAreTheAssembly) {
  const LinearModel a = part("a"), c = part("c"), ac = part("ac");
  const LinearModel joined = assemble_parts({&a, &c});
  ASSERT_EQ(joined.size(), ac.size());
  const auto order = places(joined, ac.dofs);
  // The production code prints 17 digits and adds in another order.
  EXPECT_LT(largest(select(joined.stiffness, order, order) - ac.stiffness), 5e-15 * largest(ac.stiffness));
  EXPECT_LT(largest(select(joined.mass, order, order) - ac.mass), 5e-15 * largest(ac.mass));
  const VectorXd theirs = published("ac"), ours = frequencies(ac, 26);
  for (Index i = 0; i < 6; ++i) EXPECT_EQ(ours[i], 0.0) << i;
  for (Index i = 6; i < ours.size(); ++i) EXPECT_NEAR(ours[i], theirs[i], printed) << i + 1;
}

TEST_F(Sandia, OurCraigBamptonModelIsThatOfTheProductionCode) {
  const LinearModel theirs = superelement_of_a(), a = part("a");
  const auto boundary = interface_of(theirs);
  ASSERT_EQ(boundary.size(), 75u);
  const Superelement ours = craig_bampton(a, boundary, {.modes = {.count = 30}, .error_indicators = false});
  ASSERT_EQ(ours.model.size(), theirs.size());

  const auto published_frequencies = published("cbr1_fixed_interface");
  ASSERT_EQ(published_frequencies.size(), 30);
  for (Index i = 0; i < 30; ++i)
    EXPECT_NEAR(ours.error_indicators.fixed_interface_frequencies[i], published_frequencies[i], printed);

  std::vector<std::string> modes;
  for (int i = 1; i <= 30; ++i) modes.push_back("q" + std::to_string(i));
  const auto their_modes = places(theirs, modes), their_boundary = places(theirs, boundary);
  std::vector<Index> our_boundary(75), our_modes(30);
  for (Index i = 0; i < 75; ++i) our_boundary[static_cast<std::size_t>(i)] = i;
  for (Index i = 0; i < 30; ++i) our_modes[static_cast<std::size_t>(i)] = 75 + i;

  const auto difference = [&](const SparseMatrix& one, const SparseMatrix& other) {
    return largest(one - other) / largest(other);
  };
  const auto& [k, m] = std::pair(ours.model.stiffness, ours.model.mass);
  // rounding times the condition, found 1e-14 to 6e-13
  EXPECT_LT(difference(select(k, our_boundary, our_boundary), select(theirs.stiffness, their_boundary, their_boundary)),
            2e-13);
  EXPECT_LT(difference(select(m, our_boundary, our_boundary), select(theirs.mass, their_boundary, their_boundary)),
            6e-12);
  EXPECT_LT(difference(select(k, our_modes, our_modes), select(theirs.stiffness, their_modes, their_modes)), 2e-12);
  EXPECT_LT(difference(select(m, our_modes, our_modes), select(theirs.mass, their_modes, their_modes)), 1e-14);
  // Signs of modes and the basis of repeated ones are free; the part that modes of one frequency take of the boundary's
  // momentum, M_bm M_bm^T, is not. The last mode is one of a pair, of which the other is left out; its frequency is
  // known to 1 %.
  EXPECT_NEAR(ours.error_indicators.next_left_out, ours.error_indicators.highest_kept,
              0.01 * ours.error_indicators.highest_kept);
  const MatrixXd our_part(select(m, our_boundary, our_modes));
  const MatrixXd their_part(select(theirs.mass, their_boundary, their_modes));
  const double scale = (their_part * their_part.transpose()).cwiseAbs().maxCoeff();
  for (Index begin = 0, end = 0; begin < 29; begin = end) {
    while (end < 30 && published_frequencies[end] < published_frequencies[begin] * (1.0 + 1e-6)) ++end;
    if (end == 30) break;
    const auto of_group = [&](const MatrixXd& part) -> MatrixXd {
      return part.middleCols(begin, end - begin) * part.middleCols(begin, end - begin).transpose();
    };
    EXPECT_LT((of_group(our_part) - of_group(their_part)).cwiseAbs().maxCoeff(), 6e-12 * scale) << begin + 1;
  }
}

TEST_F(Sandia, ItsSuperelementJoinsWithTheFullOtherPart) {
  const LinearModel element = superelement_of_a(), c = part("c");
  const VectorXd assembly = published("ac");
  const VectorXd with_full = frequencies(assemble_parts({&element, &c}), 20);
  // found 1.2e-4: 30 modes
  for (Index i = 6; i < 20; ++i) EXPECT_NEAR(with_full[i], assembly[i], 3e-4 * assembly[i]) << i + 1;
  // Reduction can only stiffen.
  for (Index i = 6; i < 20; ++i) EXPECT_GT(with_full[i], assembly[i] - printed) << i + 1;
}

TEST_F(Sandia, TwoReducedPartsJoinWithinATenthOfAPercent) {
  const LinearModel a = part("a"), c = part("c");
  const auto boundary = interface_of(superelement_of_a());
  const VectorXd assembly = published("ac");
  const LinearModel one = reduced(a, boundary, "a_"), other = reduced(c, boundary, "c_");
  EXPECT_EQ(one.size(), 75 + 40);
  const VectorXd joined = frequencies(assemble_parts({&one, &other}), 20);
  // found 1.9e-4: 40 modes of each part
  for (Index i = 6; i < 20; ++i) {
    EXPECT_NEAR(joined[i], assembly[i], 5e-4 * assembly[i]) << i + 1;
    EXPECT_GT(joined[i], assembly[i] - printed) << i + 1;  // reduction can only stiffen
  }
  const LinearModel element = superelement_of_a();
  const VectorXd with_theirs = frequencies(assemble_parts({&element, &other}), 20);
  for (Index i = 6; i < 20; ++i) EXPECT_NEAR(with_theirs[i], assembly[i], 6e-4 * assembly[i]) << i + 1;  // found 2.4e-4
}

void damp_by_stiffness(LinearModel& model) { model.damping = 1e-6 * model.stiffness; }

constexpr double sampling = 1e-5;  ///< [s]: 60 samples a period of the fastest motion of the pulse

/// Outputs over time of a model under a pulse at one of its degrees of freedom, outputs x samples.
MatrixXd motion_under_pulse(const LinearModel& model, const std::string& loaded,
                            const std::vector<std::pair<std::string, ObservedQuantity>>& wanted) {
  const CoupledModel coupled({{"s", model}}, {}, {{"F", InputKind::force, "s." + loaded}});
  std::vector<OutputDescription> outputs;
  for (const auto& [name, quantity] : wanted) outputs.push_back({name, quantity, {{"s." + name, 1.0}}});
  const SignalPtr pulse =
      make_pulse({.amplitude = 1e3, .start = 2e-4, .duration = 1.5e-3, .shape = PulseShape::smooth});
  const auto result = simulate(coupled.system(), {pulse}, at_rest(coupled.system().size(), 0),
                               {.integrator = Integrator::newmark,
                                .step = sampling,
                                .duration = 0.01,
                                .keep_motion = false,
                                .every_sample = make_outputs(coupled, outputs)});
  EXPECT_FALSE(result.failure);
  return result.every_sample;
}

TEST_F(Sandia, InterfaceMotionOfTheReducedAssemblyDrivesTheOtherPart) {
  LinearModel a = part("a"), c = part("c"), ac = part("ac");
  for (LinearModel* model : {&a, &c, &ac}) damp_by_stiffness(*model);
  const auto boundary = interface_of(superelement_of_a());
  const std::string loaded = "n1.y";  // at the free end of a
  const std::vector<std::string> inside = {c.dofs[601], c.dofs[1000], c.dofs[1204], c.dofs[1507], c.dofs[1801]};
  for (const auto& name : inside) ASSERT_EQ(std::ranges::find(boundary, name), boundary.end());

  std::vector<std::pair<std::string, ObservedQuantity>> wanted;
  for (const auto& name : inside) wanted.emplace_back(name, ObservedQuantity::acceleration);
  const MatrixXd truth = motion_under_pulse(ac, loaded, wanted);

  wanted.clear();
  for (const auto quantity :
       {ObservedQuantity::displacement, ObservedQuantity::velocity, ObservedQuantity::acceleration})
    for (const auto& name : boundary) wanted.emplace_back(name, quantity);
  const LinearModel one = reduced(a, boundary, "a_", {loaded}), other = reduced(c, boundary, "c_");
  const MatrixXd interface = motion_under_pulse(assemble_parts({&one, &other}), loaded, wanted);

  SparseRows points(static_cast<Index>(inside.size()), c.size());
  const auto rows = places(c, inside);
  for (std::size_t i = 0; i < rows.size(); ++i) points.insert(static_cast<Index>(i), rows[i]) = 1.0;
  const Index n_b = static_cast<Index>(boundary.size());
  const BaseDrivenSubstructure driven(c, places(c, boundary));
  const auto predicted =
      driven.predict(points, {interface.topRows(n_b), interface.middleRows(n_b, n_b), interface.bottomRows(n_b)}, {},
                     {}, {.sample_rate = 1.0 / sampling, .newmark_substeps = 1});
  // found 3e-4: 40 modes of each part, and two ways of stepping
  for (Index i = 0; i < truth.rows(); ++i)
    EXPECT_LT((predicted.acceleration.row(i) - truth.row(i)).norm(), 1e-3 * truth.row(i).norm())
        << inside[static_cast<std::size_t>(i)];
}

}  // namespace
}  // namespace kalfem
