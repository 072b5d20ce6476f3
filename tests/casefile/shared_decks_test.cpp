// SPDX-License-Identifier: Apache-2.0
#include <filesystem>
#include <fstream>

#include "base/scratch_folder.hpp"
#include "casefile/case_run.hpp"
#include "kalfem/base/invalid_input.hpp"
#include "kalfem/casefile/case_schema.hpp"
#include "kalfem/casefile/description.hpp"
#include "kalfem/study/deck_files.hpp"
#include "kalfem/study/study.hpp"
#include "kalfem/yaml/case_reader.hpp"

// Finite-element substructures of one deck that stand elsewhere, or differ in what the case adds: the deck is parsed
// once, and each is made from a copy of it.

namespace kalfem::test {
namespace {

const char* const bar =
    "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,2.,0.,0.\nCBAR,1,1,1,2,0.,0.,1.\nCBAR,2,1,2,3,0.,0.,1.\n"
    "PBAR,1,1,1.-3,1.-7,4.-7,3.-7\nMAT1,1,2.+11,,.3,7850.\nSPC1,3,123456,1\nGENEL,1\nENDDATA\n";

class SharedDecks : public testing::Test {
protected:
  SharedDecks() : folder_("shared-decks") { write("bar.bdf", bar); }

  void write(const std::string& name, const std::string& cards) const {
    std::ofstream(folder_ / name) << "SOL 103\nCEND\nSPC = 3\nBEGIN BULK\n" << cards;
  }

  /// Two bars, joined by a spring at their ends; `here`, `there`: what the case says of each beside its deck.
  [[nodiscard]] std::string two(const std::string& second_deck, const std::string& here,
                                const std::string& there) const {
    const auto part = [&](const std::string& name, const std::string& deck, const std::string& more) {
      return "  " + name + ": {finite_elements: {deck: " + (folder_ / deck).string() + more + "}}\n";
    };
    return "kalfem: 1\nsubstructures:\n" + part("near", "bar.bdf", here) + part("far", second_deck, there) +
           "connectors: {spring: {from: near.end.y, to: far.end.y, law: linear, parameters: {k: 1e3, c: 1}}}\n";
  }

  [[nodiscard]] description::Case described(const std::string& text) const {
    const Environment none = [](const std::string&) { return std::nullopt; };
    return read_case_text(text, "case.yaml", description::case_schema(), none);
  }

  ScratchFolder folder_;
};

const std::string accepted = ", accept_missing: [GENEL], nodes: {end: 3}";
const std::string placed = accepted + ", rotate: {axis: [1, 0, 0], angle: 90 deg}, translate: [0, 0, 4]";

TEST_F(SharedDecks, MakeTheSameModelAsTwoFiles) {
  write("same.bdf", bar);
  const Study shared = study_of(two("bar.bdf", accepted, placed)), apart = study_of(two("same.bdf", accepted, placed));
  ASSERT_EQ(shared.structure->finite_elements.size(), 2u);
  for (const std::size_t i : {0u, 1u}) {
    const FiniteElementPart &found = *shared.structure->finite_elements[i].part,
                            &expected = *apart.structure->finite_elements[i].part;
    EXPECT_EQ(found.name, expected.name);
    EXPECT_EQ(found.elements.mesh.nodes, expected.elements.mesh.nodes);
    EXPECT_EQ(found.full.dofs, expected.full.dofs);
    EXPECT_EQ(Eigen::MatrixXd(found.full.stiffness), Eigen::MatrixXd(expected.full.stiffness));
    EXPECT_EQ(Eigen::MatrixXd(found.full.mass), Eigen::MatrixXd(expected.full.mass));
    EXPECT_EQ(shared.element_notes[i].notes.size(), 1u);
  }
  EXPECT_EQ(shared.structure->finite_elements[0].part->elements.mesh.nodes(2, 2), 0.0);
  EXPECT_EQ(shared.structure->finite_elements[1].part->elements.mesh.nodes(2, 2), 4.0);
  EXPECT_EQ(shared.warnings.size(), apart.warnings.size());
}

TEST_F(SharedDecks, AcceptWhatIsMissingEachForItself) {
  const auto found = problems_of(two("bar.bdf", accepted, ", nodes: {end: 3}, translate: [0, 0, 4]"));
  EXPECT_NE(found.find("GENEL"), std::string::npos) << found;
  EXPECT_EQ(std::ranges::count(found, '\n'), 0) << found;
}

TEST_F(SharedDecks, ReportAnErrorAsTwoFilesDo) {
  const std::string broken = changed(bar, "2.+11", "many");
  write("bar.bdf", broken);
  write("same.bdf", broken);
  const auto shared = problems_of(two("bar.bdf", accepted, placed));
  auto apart = problems_of(two("same.bdf", accepted, placed));
  EXPECT_NE(shared.find("many"), std::string::npos) << shared;
  EXPECT_NE(apart, shared);
  for (auto at = apart.find("same.bdf"); at != std::string::npos; at = apart.find("same.bdf"))
    apart.replace(at, 8, "bar.bdf");
  EXPECT_EQ(shared, apart);
}

TEST_F(SharedDecks, AreParsedOnceForEachSetOfOptions) {
  const auto file = folder_ / "bar.bdf";
  DeckFiles decks(described(two("bar.bdf", accepted, placed)));
  const Deck first = decks.read(file, {});
  write("bar.bdf", changed(bar, "2.+11", "1.+11"));
  const auto modulus = [](const Deck& deck) { return deck.model.materials.begin()->second.youngs_modulus; };
  EXPECT_EQ(modulus(decks.read(file, {})), modulus(first));
  EXPECT_EQ(modulus(decks.read(file, {.load_cases = true})), 0.5 * modulus(first));
}

TEST_F(SharedDecks, AreNotKeptForOneSubstructure) {
  write("same.bdf", bar);
  const auto file = folder_ / "bar.bdf";
  DeckFiles decks(described(two("same.bdf", accepted, placed)));
  EXPECT_EQ(decks.read(file, {}).model.mesh.cells.size(), 2u);
  std::filesystem::remove(file);
  EXPECT_THROW((void)decks.read(file, {}), InvalidInput);
}

}  // namespace
}  // namespace kalfem::test
