// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <numbers>

#include "base/absent.hpp"
#include "base/data_folder.hpp"
#include "base/scratch_folder.hpp"
#include "kalfem/formats/matrices/matrix_model.hpp"
#include "kalfem/linalg/lowest_modes.hpp"
#include "model/assemble_parts.hpp"
#include "model/calculix.hpp"
#include "model/inp_writer.hpp"

namespace kalfem {
namespace {

using Eigen::Index;

std::filesystem::path decks() { return data_folder("calculix-decks"); }

Eigen::VectorXd frequencies(const LinearModel& model, Index count) {
  return lowest_modes(model.stiffness, model.mass, {.count = count}).values.cwiseSqrt() / (2.0 * std::numbers::pi);
}

void expect_equal(const Eigen::VectorXd& ours, const std::vector<double>& theirs) {
  ASSERT_GE(theirs.size(), static_cast<std::size_t>(ours.size()));
  for (Index i = 0; i < ours.size(); ++i) {
    const double reference = theirs[static_cast<std::size_t>(i)];
    EXPECT_NEAR(ours[i], reference, 1e-6 * reference) << i + 1;  // seven digits are printed
  }
}

/// A text with what follows a keyword's name on its line replaced.
std::string with_keyword(std::string text, const std::string& keyword, const std::string& line) {
  const std::size_t at = text.find(keyword);
  EXPECT_NE(at, std::string::npos) << keyword;
  return text.replace(at, text.find('\n', at) - at, line);
}

std::string content(const std::filesystem::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

TEST(CalculixMatrices, VehicleFrameHasCalculixsOwnFrequencies) {
  if (!has_calculix()) KALFEM_ABSENT("CalculiX (ccx) is not installed");
  const ScratchFolder folder("calculix-matrices");
  auto model = frame("small.msh");
  // The file's 14 digits of the stiffest entries, 1e14 N/m, would drown soft springs.
  for (auto& spring : model.springs) spring.stiffness = 1e7;
  write_deck(model, folder / "modes.inp");
  write_deck(model, folder / "frame.inp", 18, "MATRIXSTORAGE");
  ASSERT_TRUE(run_calculix(folder, "modes"));
  (void)run_calculix(folder, "frame");  // it ends with a word, and a code, that no modes were computed
  const MatrixModel imported = read_superelement({folder / "frame.sti", folder / "frame.mas"});
  ASSERT_EQ(imported.dofs.size(), static_cast<std::size_t>(imported.model.size()));
  // Two nodes of the expanded shell share the number of a node of the mesh: its motion is their mean.
  EXPECT_FALSE(imported.notes.empty());
  EXPECT_FALSE(imported.model.points.empty());
  expect_equal(frequencies(imported.model, 16), frequencies_in(folder / "modes.dat"));
}

TEST(CalculixMatrices, SolidBeamHasThePublishedFrequencies) {
  if (!has_calculix()) KALFEM_ABSENT("CalculiX (ccx) is not installed");
  if (!std::filesystem::exists(decks())) KALFEM_ABSENT("the decks are not at " + decks().string());
  const ScratchFolder folder("calculix-beam");
  std::ofstream(folder / "beam.inp") << with_keyword(content(decks() / "beamf.inp"), "*FREQUENCY",
                                                     "*FREQUENCY, SOLVER=MATRIXSTORAGE");
  (void)run_calculix(folder, "beam");
  const MatrixModel imported = read_superelement({folder / "beam.sti", folder / "beam.mas"});
  expect_equal(frequencies(imported.model, 10), frequencies_in(decks() / "beamf.dat.ref"));
}

TEST(CalculixMatrices, SuperelementOfASolidJoinsWithTheRest) {
  if (!has_calculix()) KALFEM_ABSENT("CalculiX (ccx) is not installed");
  if (!std::filesystem::exists(decks())) KALFEM_ABSENT("the decks are not at " + decks().string());
  const MatrixModel element = read_superelement({decks() / "beamfsuper.stiff", decks() / "beamfsuper.mass"});
  EXPECT_EQ(element.model.size(), 60);  // the 20 nodes of one solid element
  EXPECT_NE(std::ranges::find(element.model.dofs, "n258.x"), element.model.dofs.end());

  const ScratchFolder folder("calculix-super");
  std::string deck = content(decks() / "beamfsuper.inp");
  deck = with_keyword(deck, "*MATRIX ASSEMBLE", "** without the superelement");
  deck = with_keyword(deck, "*FREQUENCY", "*FREQUENCY, SOLVER=MATRIXSTORAGE");
  std::ofstream(folder / "rest.inp") << deck;
  (void)run_calculix(folder, "rest");
  const MatrixModel rest = read_superelement({folder / "rest.sti", folder / "rest.mas"});
  expect_equal(frequencies(assemble_parts({&rest.model, &element.model}), 10),
               frequencies_in(decks() / "beamfsuper.dat.ref"));
}

}  // namespace
}  // namespace kalfem
