// SPDX-License-Identifier: Apache-2.0
// The Technion Pazy wing without skin: an industrial Nastran deck of shells, eccentric shear-flexible beams, rigid
// links and a point mass, against the modes and the weight that MSC Nastran printed for it [RC23].
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <map>
#include <numbers>
#include <sstream>

#include "base/absent.hpp"
#include "base/data_folder.hpp"
#include "base/figures.hpp"
#include "kalfem/formats/nastran.hpp"
#include "kalfem/linalg/lowest_modes.hpp"
#include "kalfem/model/assembly/assembly.hpp"
#include "kalfem/model/assembly/rigid_body.hpp"

namespace kalfem {
namespace {

std::filesystem::path folder() { return data_folder("pazy-wing"); }

/// What the printed output of Nastran holds.
struct Printed {
  std::vector<double> frequencies;                                          ///< [Hz]
  std::vector<std::map<std::int64_t, Eigen::Matrix<double, 6, 1>>> shapes;  ///< by mode and grid point
  double mass = 0.0;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
};

Printed read_printed(const std::filesystem::path& file) {
  std::ifstream in(file);
  Printed printed;
  bool in_weights = false, in_shape = false;
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    // "CYCLES = 4.2E+00   R E A L   E I G E N V E C T O R   N O .   1"; other tables follow with such a line as well.
    if (const auto at = line.find("CYCLES ="); at != std::string::npos) {
      in_shape = line.find("E I G E N V E C T O R") != std::string::npos;
      if (in_shape) {
        printed.frequencies.push_back(std::stod(line.substr(at + 8)));
        printed.shapes.emplace_back();
      }
      continue;
    }
    if (line.find("MASS AXIS SYSTEM (S)") != std::string::npos) in_weights = true;
    std::string first, second;
    words >> first >> second;
    if (in_weights && (first == "X" || first == "Y" || first == "Z")) {
      Eigen::Vector3d row;
      words >> row[0] >> row[1] >> row[2];
      printed.mass = std::stod(second);
      for (int i = 0; i < 3; ++i)
        if (std::abs(row[i]) > std::abs(printed.centre[i])) printed.centre[i] = row[i];
      in_weights = first != "Z";
    } else if (second == "G" && in_shape) {
      Eigen::Matrix<double, 6, 1> motion;
      for (int i = 0; i < 6; ++i) words >> motion[i];
      if (words) printed.shapes.back()[std::stoll(first)] = motion;
    }
  }
  return printed;
}

class PazyWing : public testing::Test {
protected:
  void SetUp() override {
    if (!std::filesystem::exists(folder() / "sol103_noskin.dat"))
      KALFEM_ABSENT("the Pazy wing is not there; set KALFEM_DATA to the folder of test data");
  }
};

TEST_F(PazyWing, HasTheModesThatNastranPrints) {
  const auto printed = read_printed(folder() / "sol103_noskin.f06");
  ASSERT_EQ(printed.frequencies.size(), 10u);
  const auto deck = read_nastran(folder() / "sol103_noskin.dat");
  const auto assembled = assemble(deck.model);
  const auto k = evaluate(assembled.stiffness, assembled.parameters),
             m = evaluate(assembled.mass, assembled.parameters);
  const auto modes = lowest_modes(k, m, {.count = 10});
  const Eigen::MatrixXd shapes = assembled.expansion * modes.vectors;
  for (Eigen::Index mode = 0; mode < 10; ++mode) {
    const auto index = static_cast<std::size_t>(mode);
    const double frequency = std::sqrt(modes.values[mode]) / (2.0 * std::numbers::pi),
                 reference = printed.frequencies[index];
    // Other elements on the same mesh: the first five to 1 %, the rest to 2 %.
    EXPECT_NEAR(frequency, reference, (mode < 5 ? 0.01 : 0.02) * reference) << "mode " << mode + 1;
    double own = 0.0, theirs = 0.0, both = 0.0;
    for (Eigen::Index node = 0; node < deck.model.mesh.node_count(); ++node) {
      // Nodes that the reader adds are not printed.
      const auto found = printed.shapes[index].find(deck.model.mesh.node_ids[static_cast<std::size_t>(node)]);
      if (found == printed.shapes[index].end()) continue;
      const auto& motion = found->second;
      const Eigen::Vector3d mine = shapes.block(6 * node, mode, 3, 1), other = motion.head<3>();
      own += mine.squaredNorm();
      theirs += other.squaredNorm();
      both += mine.dot(other);
    }
    EXPECT_GE(both * both / (own * theirs), 0.98) << "mode " << mode + 1;
    test::expect_figure("pazy_wing.mode_" + std::to_string(mode + 1), std::abs(frequency / reference - 1.0));
  }
}

TEST_F(PazyWing, HasTheMassThatNastranPrints) {
  const auto printed = read_printed(folder() / "sol103_noskin.f06");
  ASSERT_GT(printed.mass, 0.0);
  auto deck = read_nastran(folder() / "sol103_noskin.dat");
  deck.model.fixed.clear();
  const auto properties = mass_properties(assemble(deck.model));
  // Seven digits are printed.
  EXPECT_NEAR(properties.mass, printed.mass, 3e-7 * printed.mass);
  EXPECT_LT((properties.centre - printed.centre).norm(), 1e-7 * printed.centre.norm());
}

TEST_F(PazyWing, NothingOfTheStructureIsLeftOut) {
  const auto deck = read_nastran(folder() / "sol103_noskin.dat");
  EXPECT_GE(deck.model.mesh.node_count(), 3152);  // shells have nodes of their own where beams stand on them
  EXPECT_EQ(deck.model.mesh.cells.size(), 1964u + 168u + 987u);
  EXPECT_EQ(deck.model.links.size(), 135u);
  EXPECT_EQ(deck.model.masses.size(), 1u);
  for (const auto& note : deck.notes) EXPECT_EQ(note.consequence.find("missing"), std::string::npos) << note.what;
}

}  // namespace
}  // namespace kalfem
