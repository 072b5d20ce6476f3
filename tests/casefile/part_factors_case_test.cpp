// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>

#include "base/scratch_folder.hpp"
#include "casefile/case_run.hpp"
#include "kalfem/base/random.hpp"
#include "kalfem/formats/matrices/write.hpp"
#include "kalfem/linalg/lowest_modes.hpp"
#include "kalfem/model/assembly/assembly.hpp"
#include "kalfem/steps/study_results.hpp"
#include "kalfem/steps/updating/outcome.hpp"
#include "kalfem/study/study.hpp"

// Factors of imported matrices, from files to the updated values.

namespace kalfem::test {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

void write_text(const std::filesystem::path& file, const std::string& text) { std::ofstream(file) << text; }

void write_matrix(const std::filesystem::path& file, const SparseMatrix& matrix) {
  write_matrices(file, {{file.stem().string(), matrix, {}, true}}, MatrixFormat::matrix_market);
}

/// A truss bridge of two girders with 39 panels: chords, diagonals and posts of tubes, floor beams, laterals; bearings
/// at the ends and two piers. 946 degrees of freedom. Each of 17 regions has a material of its own; the end portals
/// belong to none.
class Bridge {
public:
  Bridge() {
    model_.name = "bridge";
    for (int side = 0; side < 2; ++side)
      for (int level = 0; level < 2; ++level)
        for (int i = 0; i < stations; ++i) add_node({4.0 * i, 6.0 * side, 6.0 * level});
    for (int side = 0; side < 2; ++side) add_girder(side);
    for (int i = 0; i < stations; ++i) {
      add_beam("floor", node(0, 0, i), node(1, 0, i), 0.3, 0.015);
      add_beam("upper_laterals", node(0, 1, i), node(1, 1, i), 0.15, 0.008);
      model_.masses.push_back({"deck" + std::to_string(i), node(0, 0, i), 6000.0});
      model_.masses.push_back({"road" + std::to_string(i), node(1, 0, i), 6000.0});
      if (i + 1 == stations) continue;
      add_beam("lower_laterals", node(i % 2, 0, i), node((i + 1) % 2, 0, i + 1), 0.15, 0.008);
      add_beam("upper_laterals", node(i % 2, 1, i), node((i + 1) % 2, 1, i + 1), 0.15, 0.008);
    }
    hold(node(0, 0, 0), "xyz");
    hold(node(1, 0, 0), "xyz");
    hold(node(0, 0, stations - 1), "yz");
    hold(node(1, 0, stations - 1), "z");
    hold(node(0, 0, 13), "yz");
    hold(node(1, 0, 13), "z");
    hold(node(0, 0, 26), "z");
    hold(node(1, 0, 26), "z");
    assembled_ = assemble(model_);
  }

  [[nodiscard]] const AssembledModel& assembled() const { return assembled_; }
  [[nodiscard]] std::vector<std::string> groups() const {
    std::vector<std::string> names;
    for (const auto& [region, property] : model_.properties)
      if (region != "portals") names.push_back(region);
    return names;
  }
  /// The part of the stiffness of one region.
  [[nodiscard]] SparseMatrix stiffness_of(const std::string& region) const {
    SparseMatrix sum(assembled_.size(), assembled_.size());
    for (const auto& term : assembled_.stiffness)
      if (term.powers.contains("steel of " + region + ".youngs_modulus"))
        sum = SparseMatrix(sum + affine_factor(term, assembled_.parameters) * term.matrix);
    return sum;
  }
  [[nodiscard]] SparseMatrix mass() const { return evaluate(assembled_.mass, assembled_.parameters); }
  [[nodiscard]] std::string name_of(Index row) const {
    return dof_name(model_.mesh, assembled_.dofs[static_cast<std::size_t>(row)]);
  }
  [[nodiscard]] std::vector<MatrixDof> rows() const {
    std::vector<MatrixDof> rows;
    for (const auto& dof : assembled_.dofs) rows.push_back({dof.node + 1, dof.direction});
    return rows;
  }
  /// Rows of the motions across and upward of 29 nodes of the lower chords.
  [[nodiscard]] std::vector<Index> measured_rows() const {
    std::vector<Index> rows;
    for (int k = 0; k < 29; ++k)
      for (const int direction : {1, 2}) {
        const int station = 1 + (k * 37) / 28;
        const bool is_held = station == 13 || station == 26;
        rows.push_back(assembled_.find({node(k % 2, 0, is_held ? station + 1 : station), direction}));
      }
    return rows;
  }

private:
  static constexpr int stations = 40;

  static Index node(int side, int level, int station) { return (2 * side + level) * stations + station; }

  void add_node(const Eigen::Vector3d& place) {
    const Index count = model_.mesh.nodes.cols();
    model_.mesh.nodes.conservativeResize(3, count + 1);
    model_.mesh.nodes.col(count) = place;
    model_.mesh.node_ids.push_back(count + 1);
  }

  void add_beam(const std::string& region, Index from, Index to, double diameter, double wall) {
    auto& cells = model_.mesh.regions[region];
    const std::array<Index, 2> ends = {from, to};
    cells.push_back(model_.mesh.add_cell(CellShape::line2, std::ssize(model_.mesh.cells) + 1, ends));
    if (model_.properties.contains(region)) return;
    const std::string material = "steel of " + region;
    model_.materials[material] = {.youngs_modulus = 2.1e11, .poissons_ratio = 0.3, .density = 7850.0};
    BeamProperty beam;
    beam.material = material;
    beam.section = circular_tube_section(diameter, wall);
    beam.placements.front().up = Eigen::Vector3d(0.3, 0.5, 0.8);  // round: any direction that no beam has
    model_.properties[region] = beam;
  }

  void add_girder(int side) {
    for (int i = 0; i < stations; ++i) {
      const std::string quarter = std::to_string(1 + std::min(i, stations - 2) / 10);
      const bool is_end = i == 0 || i + 1 == stations;
      add_beam(is_end             ? "portals"
               : i < stations / 2 ? "posts_1"
                                  : "posts_2",
               node(side, 0, i), node(side, 1, i), 0.25, 0.012);
      if (i + 1 == stations) continue;
      add_beam("lower_" + quarter, node(side, 0, i), node(side, 0, i + 1), 0.4, 0.02);
      add_beam("upper_" + quarter, node(side, 1, i), node(side, 1, i + 1), 0.4, 0.02);
      add_beam("diagonals_" + quarter, node(side, i % 2, i), node(side, 1 - i % 2, i + 1), 0.25, 0.012);
    }
  }

  void hold(Index at, const std::string& axes) {
    FixedNodes fixed{"held" + std::to_string(at) + axes, {at}, {}};
    for (const char axis : axes) fixed.directions[static_cast<std::size_t>(axis - 'x')] = true;
    model_.fixed.push_back(fixed);
  }

  FiniteElementModel model_;
  AssembledModel assembled_;
};

/// Files of the bridge and a case that updates 17 factors from five modes at 58 points.
class BridgeCase {
public:
  BridgeCase(const std::filesystem::path& folder, std::uint64_t seed) : folder_(folder), groups_(bridge_.groups()) {
    SparseMatrix constant = bridge_.stiffness_of("portals"), whole = constant;
    write_matrix(folder / "K0.mtx", constant);
    write_matrix(folder / "M0.mtx", bridge_.mass());
    write_dof_map(folder / "rows.dof", bridge_.rows());
    RandomStream stream(seed, "factors");
    for (std::size_t i = 0; i < groups_.size(); ++i) {
      const SparseMatrix part = bridge_.stiffness_of(groups_[i]);
      write_matrix(folder / ("K" + std::to_string(i + 1) + ".mtx"), part);
      truth_.push_back(0.8 + 0.45 * stream.uniform());
      whole = SparseMatrix(whole + truth_.back() * part);
    }
    measure(whole, stream);
  }

  [[nodiscard]] Index size() const { return bridge_.assembled().size(); }
  [[nodiscard]] const std::vector<std::string>& groups() const { return groups_; }
  [[nodiscard]] const std::vector<double>& truth() const { return truth_; }
  [[nodiscard]] Index points() const { return std::ssize(bridge_.measured_rows()); }

  /// Compares frequencies and shapes, or frequencies only.
  [[nodiscard]] std::string text(bool with_shapes) const {
    std::string text = "kalfem: 1\nsubstructures:\n  bridge:\n    finite_elements:\n      matrices: {files: [" +
                       path("K0.mtx") + ", " + path("M0.mtx") + "], dofs: " + path("rows.dof") + "}\n      factors:\n";
    std::string parameters;
    for (std::size_t i = 0; i < groups_.size(); ++i) {
      text +=
          "        " + groups_[i] + ": {matrices: {stiffness: " + path("K" + std::to_string(i + 1) + ".mtx") + "}}\n";
      parameters += "    bridge." + groups_[i] + ".factor: {std: 0.3, bounds: [0.2, 5]}\n";
    }
    text +=
        "update:\n  parameters:\n" + parameters + "  compare:\n    test:\n      modes: bridge\n      frequencies: [";
    for (Index i = 0; i < frequencies_.size(); ++i) text += (i > 0 ? ", " : "") + std::to_string(frequencies_[i]);
    text += "]\n      deviation: 0.1 %\n";
    if (!with_shapes) return text;
    text += "      shapes: {file: " + path("shapes.csv") + ", deviation: 0.01, points: [";
    for (const Index row : bridge_.measured_rows()) text += (text.back() == '[' ? "" : ", ") + bridge_.name_of(row);
    return text + "]}\n";
  }

private:
  [[nodiscard]] std::string path(const std::string& name) const { return (folder_ / name).string(); }

  /// Five modes with errors of 0.1 % in frequency, and of 1 % of the largest entry in shape.
  void measure(const SparseMatrix& stiffness, RandomStream& stream) {
    const auto modes = lowest_modes(stiffness, bridge_.mass(), {.count = 5});
    frequencies_ = modes.values.cwiseSqrt() / (2.0 * M_PI);
    std::ofstream table(folder_ / "shapes.csv");
    table << "m1,m2,m3,m4,m5\n";
    const auto rows = bridge_.measured_rows();
    const Eigen::MatrixXd shapes = modes.vectors(rows, Eigen::all);
    for (Index i = 0; i < shapes.rows(); ++i)
      for (Index j = 0; j < 5; ++j)
        table << shapes(i, j) / shapes.col(j).cwiseAbs().maxCoeff() + 0.01 * stream.normal() << (j < 4 ? "," : "\n");
    for (auto& frequency : frequencies_) frequency *= 1.0 + 0.001 * stream.normal();
  }

  std::filesystem::path folder_;
  Bridge bridge_;
  std::vector<std::string> groups_;
  std::vector<double> truth_;
  VectorXd frequencies_;
};

/// The worst of the compared modes.
struct ModeErrors {
  double frequency = 0.0;  ///< relative
  double mac = 1.0;

  explicit ModeErrors(const std::vector<PairedMode>& modes) {
    for (const auto& mode : modes) {
      frequency = std::max(frequency, std::abs(mode.relative_error));
      mac = std::min(mac, mode.mac);
    }
  }
};

// Modes 2 and 3, 4 and 5 lie within 2 % of each other. With seed 2 the start mixes two so that a measured one is like
// neither; with 3, 7 and 10 two change places on the way.
TEST(PartFactorsCase, ABridgeOfMatricesIsUpdatedByItsModes) {
  for (const std::uint64_t seed : {2, 3, 7, 10}) {
    SCOPED_TRACE(seed);
    const ScratchFolder folder("bridge");
    const BridgeCase bridge(folder, seed);
    ASSERT_EQ(bridge.size(), 946);
    ASSERT_EQ(bridge.groups().size(), 17u);
    ASSERT_EQ(bridge.points(), 58);
    const auto outcome = results_of(bridge.text(true), "update").get<UpdatingOutcome>();
    const ModeErrors before(outcome.comparisons.front().modes_initial), after(outcome.comparisons.front().modes_final);
    int outside = 0;
    for (std::size_t i = 0; i < bridge.truth().size(); ++i) {
      const auto row = static_cast<Index>(i);
      if (std::abs(outcome.values[row] - bridge.truth()[i]) > 2.0 * outcome.statistics.deviations[row]) ++outside;
    }
    std::printf(
        "bridge of 946 degrees of freedom, 17 factors: modes within %.2f %% before, %.3f %% after, least MAC %.4f, %d "
        "of 17 factors beyond two deviations, the widest +- %.2f\n",
        100.0 * before.frequency, 100.0 * after.frequency, after.mac, outside,
        outcome.statistics.deviations.maxCoeff());
    EXPECT_GT(before.frequency, 0.01);
    EXPECT_LT(after.frequency, 0.005);
    EXPECT_GT(after.mac, 0.998);
    EXPECT_LE(outside, 3);  // of 17 true intervals, more lie outside in 1 of 100 bridges
    // The factors multiply all of the stiffness but that of the portals: d ln f / d ln a adds up to nearly 1/2.
    const auto& sensitivities = outcome.first.frequencies.front().relative;
    for (Index i = 0; i < sensitivities.rows(); ++i) EXPECT_NEAR(sensitivities.row(i).sum(), 0.5, 0.02);
  }
}

TEST(PartFactorsCase, WhatFiveFrequenciesOfABridgeDoNotTellIsNamed) {
  const ScratchFolder folder("bridge-frequencies");
  const BridgeCase bridge(folder, 7);
  const auto first = results_of(bridge.text(false), "update").get<UpdatingOutcome>().first;
  std::printf("17 factors, 5 frequencies: %zu combinations not told apart, %zu groups proposed, %zu held\n",
              first.remarks.size(), first.proposal.groups.size(), first.proposal.hold.size());
  for (const auto& remark : first.remarks) std::printf("  %s\n", remark.c_str());
  EXPECT_GE(first.remarks.size(), 12u);
  EXPECT_LE(first.proposal.groups.size(), 5u);
  EXPECT_GE(first.proposal.groups.size(), 2u);
  std::size_t members = first.proposal.hold.size();
  for (const auto& group : first.proposal.groups) members += group.size();
  EXPECT_EQ(members, 17u);
}

/// Three masses in a row on springs, as matrices with a factor for the second spring.
class ChainFiles {
public:
  explicit ChainFiles(const std::filesystem::path& folder) : folder_(folder) {
    write("K0", Eigen::Matrix3d{{3000, 0, 0}, {0, 1000, -1000}, {0, -1000, 1000}});
    write("M0", Eigen::Matrix3d::Identity());
    write("K1", Eigen::Matrix3d{{1000, -1000, 0}, {-1000, 1000, 0}, {0, 0, 0}});
    write_text(folder_ / "rows.dof", "1.1\n2.1\n3.1\n");
  }

  void write(const std::string& name, const Eigen::MatrixXd& entries) const {
    std::string text = "%%MatrixMarket matrix array real general\n" + std::to_string(entries.rows()) + " " +
                       std::to_string(entries.cols()) + "\n";
    for (const double entry : entries.reshaped()) text += std::to_string(entry) + "\n";
    write_text(folder_ / (name + ".mtx"), text);
  }

  [[nodiscard]] std::string text(const std::string& factors, const std::string& parameter) const {
    const std::string at = folder_.string() + "/";
    std::string text = "kalfem: 1\nsubstructures:\n  s:\n    finite_elements:\n      matrices: {files: [" + at +
                       "K0.mtx, " + at + "M0.mtx], dofs: " + at + "rows.dof}\n      factors:\n" + factors +
                       "update:\n  parameters:\n    s.a.factor: {" + parameter +
                       "}\n  compare: {test: {modes: s, frequencies: [5.0, 8.5]}}\n";
    for (auto place = text.find("DIR/"); place != std::string::npos; place = text.find("DIR/"))
      text.replace(place, 4, at);
    return text;
  }
  [[nodiscard]] std::string problems(const std::string& factors, const std::string& parameter = "") const {
    return problems_of(text(factors, parameter));
  }

private:
  std::filesystem::path folder_;
};

const std::string usual = "        a: {matrices: {stiffness: DIR/K1.mtx}}\n";

void expect_in(const std::string& text, const std::string& piece) {
  EXPECT_NE(text.find(piece), std::string::npos) << piece << "\nin: " << text;
}

TEST(PartFactorsCase, AFactorIsFoundFromFrequencies) {
  const ScratchFolder folder("chain-factors");
  const ChainFiles files(folder);
  EXPECT_EQ(files.problems(usual), "");
  auto text = files.text(usual, "bounds: [0.1, 10]");
  // Frequencies of a = 1.7.
  const Eigen::Matrix3d k = Eigen::Matrix3d{{4700, -1700, 0}, {-1700, 2700, -1000}, {0, -1000, 1000}};
  const VectorXd omega = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(k).eigenvalues().cwiseSqrt();
  text =
      changed(text, "5.0, 8.5", std::to_string(omega[0] / (2 * M_PI)) + ", " + std::to_string(omega[1] / (2 * M_PI)));
  EXPECT_NEAR(results_of(text, "update").get<UpdatingOutcome>().values[0], 1.7, 1e-4);
}

TEST(PartFactorsCase, FilesThatDoNotFitAreRefusedWithTheirLine) {
  const ScratchFolder folder("bad-factors");
  const ChainFiles files(folder);
  files.write("K4", Eigen::Matrix4d::Identity());
  files.write("Kx", Eigen::Matrix3d{{1, 2, 0}, {1, 1, 0}, {0, 0, 1}});
  const auto problems = [&](const std::string& stiffness) {
    return files.problems("        a: {matrices: {stiffness: DIR/" + stiffness + ".mtx}}\n");
  };
  expect_in(problems("K4"), "case.yaml:7:");
  expect_in(problems("K4"), "the stiffness matrix 'K4' is 4 x 4: there are 3 degrees of freedom");
  expect_in(problems("Kx"), "case.yaml:7:");
  expect_in(problems("Kx"), "the stiffness matrix 'Kx' is not symmetric");
  expect_in(problems("absent"), "absent.mtx");
  expect_in(files.problems("        a: {matrices: {}}\n"), "no matrix is given");
  expect_in(files.problems(usual + usual), "case.yaml:8:");
  expect_in(files.problems("        a: {elements: [left]}\n"), "there are no elements 'left'");
}

TEST(PartFactorsCase, BoundsThatLeaveTheStructuresAreRefused) {
  const ScratchFolder folder("bounds-of-factors");
  const ChainFiles files(folder);
  expect_in(files.problems(usual, "bounds: [-5, 2]"), "case.yaml:10:");
  expect_in(files.problems(usual, "bounds: [-5, 2]"), "at its bound -5 the stiffness of 's' is indefinite");
  // A matrix with a negative eigenvalue needs an upper bound, and one that it allows.
  files.write("Kd", Eigen::Matrix3d{{200, 0, 0}, {0, -100, 0}, {0, 0, 0}});
  const std::string change = "        a: {matrices: {stiffness: DIR/Kd.mtx}, value: 0.1}\n";
  expect_in(files.problems(change), "it has no upper bound");
  expect_in(files.problems(change, "bounds: [0, 30]"), "at its bound 30 the stiffness of 's' is indefinite");
}

}  // namespace
}  // namespace kalfem::test
