// SPDX-License-Identifier: Apache-2.0
#include <fstream>

#include "base/scratch_folder.hpp"
#include "casefile/case_run.hpp"
#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/steps/frequency_response/outcome.hpp"
#include "kalfem/steps/modes/outcome.hpp"
#include "kalfem/steps/statics/outcome.hpp"
#include "kalfem/study/study.hpp"
#include "kalfem/system/linearised.hpp"

// Two finite-element substructures whose meshes meet in coincident nodes, joined by naming the group of these nodes,
// against one mesh of the whole.

namespace kalfem::test {
namespace {

/// A stretch of a plate in the x-y plane, 0.5 m wide, of square cells; lines along both ends in x are groups.
struct Stretch {
  double from = 0.0, to = 0.0;        ///< along x [m]
  std::string first_end, second_end;  ///< names of the groups; "": none
  double shift = 0.0;                 ///< of all nodes along y [m]
};

constexpr int cells_across = 6;
constexpr double width = 0.5, cell = width / cells_across;

void write_plate(const std::filesystem::path& file, const Stretch& plate) {
  const int along = static_cast<int>(std::lround((plate.to - plate.from) / cell));
  const auto node = [](int i, int j) { return i * (cells_across + 1) + j + 1; };
  std::ofstream out(file);
  out.precision(17);
  struct End {
    int group, at;
    std::string name;
  };
  std::vector<End> ends{{2, 0, plate.first_end}, {3, along, plate.second_end}};
  std::erase_if(ends, [](const End& end) { return end.name.empty(); });
  out << "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n" << 1 + ends.size() << "\n2 1 \"plate\"\n";
  for (const auto& end : ends) out << "1 " << end.group << " \"" << end.name << "\"\n";
  out << "$EndPhysicalNames\n$Nodes\n" << (along + 1) * (cells_across + 1) << "\n";
  for (int i = 0; i <= along; ++i)
    for (int j = 0; j <= cells_across; ++j)
      out << node(i, j) << " " << plate.from + i * cell << " " << j * cell + plate.shift << " 0\n";
  out << "$EndNodes\n$Elements\n" << (along + static_cast<int>(ends.size())) * cells_across << "\n";
  int id = 0;
  for (int i = 0; i < along; ++i)
    for (int j = 0; j < cells_across; ++j)
      out << ++id << " 3 2 1 1 " << node(i, j) << " " << node(i + 1, j) << " " << node(i + 1, j + 1) << " "
          << node(i, j + 1) << "\n";
  for (const auto& end : ends)
    for (int j = 0; j < cells_across; ++j)
      out << ++id << " 1 2 " << end.group << " " << end.group << " " << node(end.at, j) << " " << node(end.at, j + 1)
          << "\n";
  out << "$EndElements\n";
}

std::string elements(const std::filesystem::path& file, const std::string& more) {
  return "finite_elements: {mesh: " + file.string() +
         ", materials: {steel: {youngs_modulus: 210 GPa, density: 7850 kg/m^3}}, regions: {plate: {material: steel, "
         "shell: {thickness: 4 mm}}}" +
         more + "}";
}

constexpr double cutoff = 1000.0;  // Hz

/// A cantilevered plate, 1.5 m long, of two parts that meet at 0.5 m.
class JoinedPlate : public testing::Test {
protected:
  JoinedPlate() : folder_("joints") {
    write_plate(folder_ / "whole.msh", {0.0, 1.5, "root", ""});
    write_plate(folder_ / "left.msh", {0.0, 0.5, "root", "seam"});
    write_plate(folder_ / "right.msh", {0.5, 1.5, "seam", ""});
  }

  [[nodiscard]] std::string whole() const {
    return "kalfem: 1\nsubstructures:\n  plate:\n    " +
           elements(folder_ / "whole.msh", ", fixed: {clamp: {nodes: root}}, nodes: {corner: [1.5, 0, 0]}") + "\n";
  }

  [[nodiscard]] std::string joined(const std::string& right = "right.msh") const {
    const std::string reduction = "    reduction: {up_to: 1000 Hz}\n";
    return "kalfem: 1\nsubstructures:\n  left:\n    " +
           elements(folder_ / "left.msh", ", fixed: {clamp: {nodes: root}}") + "\n" + reduction + "  right:\n    " +
           elements(folder_ / right, ", nodes: {corner: [1.5, 0, 0]}") + "\n" + reduction +
           "joints:\n  seam: {between: [left.seam, right.seam]}\n";
  }

  ScratchFolder folder_;
};

Eigen::VectorXd frequencies_of(const StructureParts& parts, Eigen::Index count) {
  return lowest_normal_modes(linearised_at_rest(couple(parts)), {count}).frequencies;
}

Eigen::VectorXd relative_error(const Eigen::VectorXd& found, const Eigen::VectorXd& expected) {
  return (found - expected).cwiseQuotient(expected).cwiseAbs();
}

TEST_F(JoinedPlate, IsTheWholeAtFullOrder) {
  const Study joint = study_of(joined()), reference = study_of(whole());
  const Eigen::Index n = reference.model->system().size();
  EXPECT_EQ(joint.model->system().size(), n);
  EXPECT_LE(relative_error(frequencies_of(joint.structure->reference_parts(), 20),
                           frequencies_of(reference.structure->reference_parts(), 20))
                .maxCoeff(),
            1e-8);
}

TEST_F(JoinedPlate, HasTheFrequenciesOfTheWholeWhenBothPartsAreReduced) {
  const Study joint = study_of(joined()), reference = study_of(whole());
  const auto& reduced = joint.structure->parts;
  const auto size = [&](std::size_t i) { return reduced.finite_elements[i].model->size(); };
  EXPECT_EQ(reduced.shared.size(), 6u * (cells_across + 1));
  EXPECT_LT(size(0) + size(1), joint.model->system().size() / 2);
  const Eigen::VectorXd expected = frequencies_of(reference.structure->reference_parts(), 60);
  const Eigen::Index count = (expected.array() < 0.5 * cutoff).count();
  ASSERT_GT(count, 20);
  ASSERT_LT(count, expected.size());
  EXPECT_LE(relative_error(frequencies_of(reduced, count), expected.head(count)).maxCoeff(), 1e-3);
}

TEST_F(JoinedPlate, TellsTheFrequenciesOfTheWhole) {
  const auto joint = results_of(joined(), "modes"), reference = results_of(whole(), "modes");
  EXPECT_EQ(reference.get<ModesOutcome>().joined_frequencies.size(), 0);
  ASSERT_EQ(joint.get<ModesOutcome>().joined_frequencies.size(),
            reference.get<ModesOutcome>().substructures[0].frequencies.size());
  EXPECT_LE(relative_error(joint.get<ModesOutcome>().joined_frequencies,
                           reference.get<ModesOutcome>().substructures[0].frequencies)
                .maxCoeff(),
            1e-3);
}

/// A force at the free corner, and what the corner does: the same with one mesh and with two.
TEST_F(JoinedPlate, MovesAsTheWhole) {
  const std::string driven =
      "excitation:\n  push: {force: @.corner.z, sine: {amplitude: 10 N, frequency: 25 Hz}}\n"
      "sensors:\n  a: {acceleration: @.corner.z, noise: 1 %}\n"
      "damping: {modal: 1 %, up_to: 200 Hz}\n"
      "simulate: {duration: 0.1 s, sample_rate: 500 Hz, substeps: 4}\n";
  const auto one = results_of(whole() + changed(changed(driven, "@", "plate"), "@", "plate"), "simulate");
  const auto two = results_of(joined() + changed(changed(driven, "@", "right"), "@", "right"), "simulate");
  ASSERT_TRUE(one.complete() && two.complete()) << one.failure << two.failure;
  EXPECT_LE(difference(simulated(two, "right.corner.z", ObservedQuantity::acceleration),
                       simulated(one, "plate.corner.z", ObservedQuantity::acceleration)),
            1e-6);
}

TEST_F(JoinedPlate, IsEstimatedFromARecord) {
  const std::string case_text =
      changed(joined(), "reduction: {up_to: 1000 Hz}", "reduction: {up_to: 100 Hz, truncation_vectors: false}");
  const auto results = results_of(
      changed(case_text, "reduction: {up_to: 1000 Hz}", "reduction: {up_to: 100 Hz, truncation_vectors: false}") +
          "damping: {modal: 2 %, up_to: 200 Hz}\n"
          "excitation: {push: {force: right.corner.z, random: {rms: 10 N, band: [1, 40 Hz], "
          "seed: 3}}}\n"
          "sensors:\n  a: {acceleration: right.corner.z, noise: 2 %}\n"
          "simulate: {duration: 1 s, sample_rate: 400 Hz, tolerance: 1e-2}\n"
          "estimate: {settle: 0.2 s, diagnose: false}\n",
      "estimate");
  ASSERT_TRUE(results.complete()) << results.failure;
  const auto* corner =
      find_quantity(results.get<EstimationOutcome>().points, "right.corner.z", ObservedQuantity::displacement);
  ASSERT_NE(corner, nullptr);
  EXPECT_LE(difference(corner->mean.tail(300),
                       simulated(results, "right.corner.z", ObservedQuantity::displacement).tail(300)),
            0.1);
}

/// Two superelements of one file, whose nodes have the same numbers: the top of the first is the foot of the second.
TEST(JoinedMatrices, KeepTheirOwnNumbers) {
  const ScratchFolder folder("joined-matrices");
  const std::string head = "%%MatrixMarket matrix coordinate real symmetric\n2 2 3\n";
  std::ofstream(folder / "K.mtx") << head << "1 1 100\n2 1 -100\n2 2 100\n";
  std::ofstream(folder / "M.mtx") << head << "1 1 3\n2 1 0\n2 2 1\n";
  std::ofstream(folder / "rows.dof") << "11.3\n12.3\n";
  const std::string part = "{finite_elements: {matrices: {files: [" + (folder / "K.mtx").string() + ", " +
                           (folder / "M.mtx").string() + "], dofs: " + (folder / "rows.dof").string() +
                           "}, nodes: {foot: 11, top: 12}}}\n";
  const Study study = study_of("kalfem: 1\nsubstructures:\n  a: " + part + "  b: " + part +
                               "joints: {weld: {between: [a.top, b.foot]}}\n");
  const Eigen::Matrix3d mass{{3, 0, 0}, {0, 4, 0}, {0, 0, 1}},
      stiffness{{100, -100, 0}, {-100, 200, -100}, {0, -100, 100}};
  EXPECT_EQ(Eigen::MatrixXd(study.model->system().mass), mass);
  EXPECT_EQ(Eigen::MatrixXd(study.model->system().stiffness), stiffness);
}

TEST_F(JoinedPlate, RefusesGroupsThatDoNotExist) {
  const auto group = problems_of(changed(joined(), "right.seam]", "right.sean]"));
  EXPECT_NE(group.find("substructure 'right' has no group of nodes 'sean' (did you mean 'seam'?)"), std::string::npos)
      << group;
  const auto part = problems_of(changed(joined(), "right.seam]", "righ.seam]"));
  EXPECT_NE(part.find("no finite-element substructure 'righ' (did you mean 'right'?)"), std::string::npos) << part;
  EXPECT_EQ(part.find("no boundary"), std::string::npos) << part;  // which follows from the wrong name
  const auto same = problems_of(changed(joined(), "right.seam]", "left.plate]"));
  EXPECT_NE(same.find("both groups belong to substructure 'left'"), std::string::npos) << same;
}

TEST_F(JoinedPlate, RefusesNodesWithoutAPartner) {
  write_plate(folder_ / "shifted.msh", {0.5, 1.5, "seam", "", 0.3 * cell});
  const auto found = problems_of(joined("shifted.msh"));
  EXPECT_NE(
      found.find("7 of the 7 nodes of 'left.seam' have no partner in 'right.seam'; the nearest to one is 0.025 m"),
      std::string::npos)
      << found;
  EXPECT_EQ(problems_of(changed(joined("shifted.msh"), "right.seam]", "right.seam], tolerance: 26 mm")), "");
  write_plate(folder_ / "left.msh", {0.0, 0.5, "root", ""});
  const auto partly = problems_of(changed(joined(), "left.seam", "left.plate"));
  EXPECT_NE(partly.find("42 of the 49 nodes of 'left.plate' have no partner"), std::string::npos) << partly;
}

TEST_F(JoinedPlate, RefusesASupportOnOneSideOnly) {
  const auto held = [&](const std::string& directions) {
    return problems_of(
        changed(joined(), "clamp: {nodes: root}", "clamp: {nodes: root}, more: {nodes: seam" + directions + "}"));
  };
  const auto all = held("");
  EXPECT_NE(all.find("'seam' cannot move"), std::string::npos) << all;
  const auto one = held(", directions: [x]");
  EXPECT_NE(one.find("and its partner cannot move alike along x"), std::string::npos) << one;
  EXPECT_NE(one.find("in 'left' a support holds it there"), std::string::npos) << one;
}

TEST_F(JoinedPlate, RefusesModalDampingOfAPart) {
  const auto found = problems_of(changed(joined(), "reduction:", "damping: {modal: 1 %}\n    reduction:"));
  EXPECT_NE(found.find("the joined substructure 'left' has modal damping"), std::string::npos) << found;
}

TEST_F(JoinedPlate, StaysWholeInALocalModel) {
  const auto found =
      problems_of(joined() +
                  "excitation: {push: {force: right.corner.z, sine: {amplitude: 1 N, frequency: 9 Hz}}}\n"
                  "sensors: {a: {acceleration: right.corner.z, noise: 2 %}}\n"
                  "simulate: {duration: 1 s, sample_rate: 400 Hz}\n"
                  "estimate: {local: {substructures: [right], interface: {right.corner.x: {force: {std: 1 "
                  "N}}}}}\n");
  EXPECT_NE(found.find("leads out of the local model"), std::string::npos) << found;
}

TEST_F(JoinedPlate, HasTheFrequencyResponsesOfTheWhole) {
  const auto asked = [](const std::string& part) {
    return "frequency_response: {frequencies: [1 Hz, 12 Hz, 30 Hz], inputs: [" + part +
           ".corner.z], outputs: "
           "[{displacement: " +
           part + ".corner.z}, {displacement: " + part + ".edge.z}], method: direct}\n";
  };
  const auto one =
      results_of(changed(whole(), "nodes: {corner", "nodes: {edge: [0.5, 0, 0], corner") + asked("plate"), "frf");
  // The node at the seam is a point of the second part, whose degrees of freedom there have the names of the first.
  const auto two =
      results_of(changed(joined(), "nodes: {corner", "nodes: {edge: [0.5, 0, 0], corner") + asked("right"), "frf");
  ASSERT_TRUE(one.complete() && two.complete()) << one.failure << two.failure;
  for (const std::size_t i : {0u, 1u}) {
    const Eigen::VectorXcd &found = two.get<FrequencyResponseOutcome>().responses[i].full,
                           &expected = one.get<FrequencyResponseOutcome>().responses[i].full;
    EXPECT_LE((found - expected).norm(), 1e-6 * expected.norm()) << i;
  }
}

TEST_F(JoinedPlate, RefusesJointsThatRepeatOrContradictOthers) {
  const auto again =
      problems_of(changed(joined(), "right.seam]}", "right.seam]}\n  again: {between: [right.seam, left.seam]}"));
  EXPECT_NE(again.find("joints.again: joint 'seam' joins these nodes already"), std::string::npos) << again;
  const auto other = problems_of(changed(
      changed(joined(), "right.seam]}", "right.seam]}\n  tie: {between: [left.end, right.inner], tolerance: 1 m}"),
      "clamp: {nodes: root}}", "clamp: {nodes: root}}, nodes: {end: [0.5, 0, 0]}"));
  const auto contradiction =
      problems_of(changed(changed(changed(joined(), "right.seam]}",
                                          "right.seam]}\n  tie: {between: [left.end, right.inner], tolerance: 1 m}"),
                                  "clamp: {nodes: root}}", "clamp: {nodes: root}}, nodes: {end: [0.5, 0, 0]}"),
                          "nodes: {corner", "nodes: {inner: [0.75, 0, 0], corner"));
  EXPECT_NE(other.find("has no group of nodes 'inner'"), std::string::npos) << other;
  EXPECT_NE(contradiction.find("and joint 'seam' joins it to node 1"), std::string::npos) << contradiction;
}

TEST_F(JoinedPlate, WarnsOfPartnersFarApart) {
  write_plate(folder_ / "shifted.msh", {0.5, 1.5, "seam", "", 0.3 * cell});
  const Study study = study_of(changed(joined("shifted.msh"), "right.seam]", "right.seam], tolerance: 26 mm"));
  EXPECT_TRUE(std::ranges::any_of(study.warnings, [](const auto& warning) {
    return warning.find("unites nodes up to 0.025 m apart") != std::string::npos;
  }));
}

TEST_F(JoinedPlate, TellsOfMissingPartnersOnce) {
  write_plate(folder_ / "shifted.msh", {0.5, 1.5, "seam", "", 0.3 * cell});
  const auto found = problems_of(joined("shifted.msh"));
  EXPECT_EQ(std::ranges::count(found, '\n'), 0) << found;
}

// --- turned copies ---------------------------------------------------------------------------------------------------

/// The plate's second half as the first one turned by half a turn about its end: a deck is read once and used twice.
TEST_F(JoinedPlate, OfATurnedCopyIsTheWhole) {
  write_plate(folder_ / "half.msh", {0.0, 0.75, "", "seam"});
  const std::string turned = ", rotate: {axis: [0, 0, 1], angle: 180 deg, about: [0.75, 0.25, 0]}";
  const std::string text = "kalfem: 1\nsubstructures:\n  left:\n    " + elements(folder_ / "half.msh", "") +
                           "\n  right:\n    " + elements(folder_ / "half.msh", turned) +
                           "\njoints:\n  seam: {between: [left.seam, right.seam]}\n";
  write_plate(folder_ / "free.msh", {0.0, 1.5, "", ""});
  const Study joint = study_of(text), reference = study_of("kalfem: 1\nsubstructures:\n  plate:\n    " +
                                                           elements(folder_ / "free.msh", "") + "\n");
  const Eigen::VectorXd found = frequencies_of(joint.structure->reference_parts(), 20).tail(14),
                        expected = frequencies_of(reference.structure->reference_parts(), 20).tail(14);
  EXPECT_LE(relative_error(found, expected).maxCoeff(), 1e-7);
}

/// A support, a spring and a load of a deck turn with it: along its own z, which becomes -y.
TEST(TurnedDeck, KeepsItsSupportsSpringsAndLoads) {
  const ScratchFolder folder("turned-deck");
  std::ofstream(folder / "bar.bdf")
      << "SOL 101\nCEND\nSPC = 3\nSUBCASE 1\nLOAD = 9\nBEGIN BULK\n"
         "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,2.,0.,0.\nCBAR,1,1,1,2,0.,0.,1.\nCBAR,2,1,2,3,0.,0.,1.\n"
         "PBAR,1,1,1.-3,1.-7,4.-7,3.-7\nMAT1,1,2.+11,,.3,7850.\nSPC1,3,12346,1\nSPC1,3,3,3\n"
         "CELAS2,7,1.+4,2,3\nFORCE,9,2,,100.,0.,0.,-1.\nENDDATA\n";
  const auto solved = [&](const std::string& turn) {
    const auto results =
        results_of("kalfem: 1\nsubstructures:\n  bar: {finite_elements: {deck: " + (folder / "bar.bdf").string() +
                       turn + ", nodes: {middle: 2, end: 3}}}\nstatic: {substructure: bar, deck_cases: true}\n",
                   "static");
    EXPECT_TRUE(results.complete()) << results.failure;
    return results;
  };
  const auto upright = solved(""), turned = solved(", rotate: {axis: [1, 0, 0], angle: 90 deg}, translate: [0, 0, 4]");
  const auto moved = [](const StudyResults& results, std::size_t point) -> Eigen::Vector3d {
    return results.get<StaticsOutcome>().cases[0].points[point].displacement.head<3>();
  };
  const Eigen::Vector3d middle = moved(upright, 0);
  EXPECT_LT(middle.z(), -1e-6);
  EXPECT_LT((moved(turned, 0) - Eigen::Vector3d(0.0, -middle.z(), 0.0)).norm(), 1e-9 * middle.norm());
  EXPECT_LT(moved(turned, 1).norm(), 1e-9 * middle.norm());
  EXPECT_LT(turned.get<StaticsOutcome>().cases[0].solution.imbalance, 1e-9);
}

/// Two clamped plates of one mesh, their corners joined by a spring.
class AlikePlates : public JoinedPlate {
protected:
  AlikePlates() { write_plate(folder_ / "plate.msh", {0.0, 0.5, "root", ""}); }

  /// `other`: what the second plate says in the place of its corner, `end`: where the spring ends on it.
  [[nodiscard]] std::string two_plates(const std::string& other, const std::string& end = "corner.z") const {
    const auto plate = [&](const std::string& nodes) {
      return "    " + elements(folder_ / "plate.msh", ", fixed: {clamp: {nodes: root}}, nodes: " + nodes) +
             "\n    reduction: {up_to: 1000 Hz}\n";
    };
    return "kalfem: 1\nsubstructures:\n  one:\n" + plate("{corner: [0.5, 0, 0]}") + "  other:\n" + plate(other) +
           "connectors: {spring: {from: one.corner.z, to: other." + end +
           ", law: linear, parameters: {k: 1e3, c: 1}}}\n";
  }
};

TEST_F(AlikePlates, AreMadeOnce) {
  const Study study = study_of(two_plates("{corner: [0.5, 0, 0]}"));
  const auto& parts = study.structure->finite_elements;
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_EQ(parts[0].part->name, "one");
  EXPECT_EQ(parts[1].part->name, "other");
  EXPECT_EQ(parts[0].reduced, parts[1].reduced);
  // a further node changes the description, and no number
  const Study apart = study_of(two_plates("{corner: [0.5, 0, 0], further: [0.5, 0.5, 0]}"));
  EXPECT_NE(apart.structure->finite_elements[0].reduced, apart.structure->finite_elements[1].reduced);
  EXPECT_EQ(frequencies_of(study.structure->parts, 20), frequencies_of(apart.structure->parts, 20));
}

TEST_F(AlikePlates, AreMadeEachWhereTheyAreTouchedElsewhere) {
  const Study study = study_of(two_plates("{corner: [0.5, 0, 0]}", "corner.rx"));
  const auto& parts = study.structure->finite_elements;
  EXPECT_NE(parts[0].part->boundary, parts[1].part->boundary);
  EXPECT_NE(parts[0].reduced, parts[1].reduced);
}

}  // namespace
}  // namespace kalfem::test
