// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "command.hpp"
#include "formats/plate_msh.hpp"

namespace kalfem::test {
namespace {

const std::string sound_deck_case = R"(kalfem: 1
substructures:
  wheel: {masses: {z: 3 kg}, springs: [{from: ground, to: z, stiffness: 1e5}]}
  plate:
    finite_elements:
      mesh: plate.msh
      materials: {steel: {youngs_modulus: 210 GPa, density: 7850 kg/m^3}}
      regions: {plate: {material: steel, shell: {thickness: 5 mm}}}
      nodes: {c: corner, f: far, m: [0.5, 0.4, 0]}
      fixed: {clamp: {nodes: edge}}
    reduction: {modes: 4, truncation_vectors: false}
connectors:
  mount: {from: wheel.z, to: plate.f.z, law: linear, parameters: {k: 1e4, c: 10}}
excitation:
  road: {base_displacement: wheel.ground, random: {rms: 1 mm, band: [0.5, 30 Hz], fade_in: 0.05 s}}
sensors:
  a: {acceleration: plate.m.z, noise: 5 %}
simulate: {duration: 0.2 s, sample_rate: 1 kHz}
)";

struct DeckMistake {
  const char* name;
  std::string from, to;               ///< what is changed, in the mesh where it is found there, else in the case
  std::vector<std::string> messages;  ///< pieces that the errors must hold
};

Outcome run_with(const DeckMistake& mistake, const std::string& verb, const std::filesystem::path& folder) {
  std::string mesh = plate_msh, text = sound_deck_case;
  std::string& changed = mesh.find(mistake.from) != std::string::npos ? mesh : text;
  const auto place = changed.find(mistake.from);
  EXPECT_NE(place, std::string::npos);
  changed.replace(place, mistake.from.size(), mistake.to);
  std::ofstream(folder / "plate.msh") << mesh;
  std::ofstream(folder / "case.yaml") << text;
  return run_command(verb + " " + (folder / "case.yaml").string(), folder);
}

/// Of low rank on the full model, and the same on superelements in the augmented model and in the place of the truth.
TEST(FiniteElements, AreDampedInTheModesOfTheWholeStructure) {
  const std::string estimated = R"(simulate: {duration: 3 s, sample_rate: 1 kHz, modes_up_to: 3 kHz, reference: @}
damping: {modal: 5 %, up_to: 60 Hz}
estimate: {unknown: {mount.k: {initial: 11 kN/m, std: 1 kN/m}}, settle: 1 s}
predict: {substructure: plate})";
  for (const std::string reference : {"full", "superelement"}) {
    const ScratchFolder folder("damped-plate-" + reference);
    std::string text = estimated;
    text.replace(text.find('@'), 1, reference);
    const auto outcome = run_with({"", "simulate: {duration: 0.2 s, sample_rate: 1 kHz}", text, {}}, "run", folder);
    ASSERT_EQ(outcome.code, 0) << outcome.errors;
    const auto summary = read_summary(folder / "case.kalfem-out");
    // found .2 % off; the prior is 10 % off and 10 % wide
    EXPECT_NEAR(summary["parameters"]["mount.k"]["estimate"].get<double>(), 1e4, 50.0) << reference;
    // three standard errors over 2,000 samples, 0.032 each
    EXPECT_NEAR(summary["estimation"]["nis"]["mean"].get<double>(), 1.0, 0.095) << reference;
    EXPECT_LE(summary["prediction"]["plate"]["m.z"]["acceleration_nrmse"].get<double>(), 0.008)
        << reference;  // found .3 %
  }
}

TEST(FiniteElements, FreeInterfaceReductionRunsAsTheOthersDo) {
  const ScratchFolder folder("rubin");
  const auto outcome =
      run_with({"Rubin", "{modes: 4, truncation_vectors: false}", "{method: rubin, modes: 6}", {}}, "simulate", folder);
  EXPECT_EQ(outcome.code, 0) << outcome.errors;
}

TEST(FiniteElements, SoundCaseRunsAtFullAndReducedOrder) {
  const ScratchFolder folder("plate");
  for (const std::string reference : {"full", "superelement"}) {
    const auto outcome =
        run_with({"", "sample_rate: 1 kHz", "sample_rate: 1 kHz, reference: " + reference, {}}, "simulate", folder);
    EXPECT_EQ(outcome.code, 0) << outcome.errors;
    EXPECT_EQ(outcome.errors, "");
    const auto plate = read_summary(folder / "case.kalfem-out")["model"]["substructures"]["plate"];
    EXPECT_EQ(plate["dofs"], 24);
    EXPECT_EQ(plate["reduction"]["dofs"], 7);
    EXPECT_NEAR(plate["mass"].get<double>(), 0.4 * 0.005 * 7850.0, 1e-13);  // rounding
  }
}

TEST(FiniteElements, ModesVerbListsThemAndWritesTheirShapes) {
  const ScratchFolder folder("modes");
  const auto outcome = run_with({"", "kalfem: 1", "kalfem: 1", {}}, "modes", folder);
  EXPECT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_NE(outcome.output.find("MAC"), std::string::npos) << outcome.output;
  const auto file = read(folder / "case.kalfem-out" / "plate_modes.vtu");
  EXPECT_NE(file.find("UnstructuredGrid"), std::string::npos);
  EXPECT_NE(file.find("mode 01"), std::string::npos);
}

class BadModel : public testing::TestWithParam<DeckMistake> {};

TEST_P(BadModel, IsOneClearMessageAndNothingIsLeft) {
  const auto& mistake = GetParam();
  const ScratchFolder folder(std::string("bad-model-") + mistake.name);
  for (const std::string verb : {"check", "simulate"}) {
    const auto outcome = run_with(mistake, verb, folder);
    EXPECT_EQ(outcome.code, 2) << outcome.errors;
    for (const auto& piece : mistake.messages)
      EXPECT_NE(outcome.errors.find(piece), std::string::npos) << outcome.errors;
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "case.kalfem-out"));
}

INSTANTIATE_TEST_SUITE_P(
    Mistakes, BadModel,
    testing::Values(
        DeckMistake{"NoMesh", "mesh: plate.msh", "mesh: plaet.msh", {"plaet.msh", "case.yaml:6"}},
        DeckMistake{"TruncatedMesh", "$Elements\n5\n1 3 2 1 1 1 2 5 4", "$Elements\n5\n", {"plate.msh:"}},
        DeckMistake{"NotAMesh", "$MeshFormat\n2.2 0 8", "hello", {"plate.msh:1"}},
        DeckMistake{"InvertedElement", "1 3 2 1 1 1 2 5 4", "1 3 2 1 1 1 5 2 4", {"quadrilateral 1 of region 'plate'"}},
        DeckMistake{"MissingProperty", "regions: {plate: {", "regions: {plaet: {", {"plaet", "case.yaml:8"}},
        DeckMistake{"RegionWithoutProperty", "1 3 2 1 1 1 2 5 4", "1 3 2 9 1 1 2 5 4", {"physical9", "property"}},
        DeckMistake{"NoDensity", ", density: 7850 kg/m^3", "", {"density", "case.yaml:7"}},
        DeckMistake{"UnknownMaterial", "{material: steel", "{material: steal", {"steal", "did you mean 'steel'"}},
        DeckMistake{"UnknownNode", "c: corner", "c: korner", {"korner", "case.yaml:9"}},
        DeckMistake{"UnknownPoint", "plate.f.z", "plate.g.z", {"plate.g.z"}},
        DeckMistake{"UnknownBoundary", "modes: 4,", "modes: 4, boundary: [c, q],", {"'q'", "case.yaml:11"}},
        DeckMistake{"PicturesOfAWheel",
                    "sample_rate: 1 kHz}",
                    "sample_rate: 1 kHz}\nreport: {fields: {substructure: wheel}}",
                    {"no finite-element substructure 'wheel'", "case.yaml:19"}},
        DeckMistake{"EverythingHeld",
                    "clamp: {nodes: edge}",
                    "clamp: {nodes: edge}, rest: {nodes: plate}",
                    {"nothing of substructure 'plate' can move", "case.yaml:6"}},
        DeckMistake{"LinkToItself",
                    "fixed: {",
                    "links: {l: {master: f, nodes: far}}\n      fixed: {",
                    {"'far' holds the master alone", "case.yaml:10"}},
        DeckMistake{"GaugeOnAnEdge",
                    "fixed: {",
                    "gauges: {g: {element: 99, direction: [1, 0, 0], surface: top}}\n      fixed: {",
                    {"element 99, which is no beam, shell or solid of ", "case.yaml:10"}},
        DeckMistake{
            "TwoNumbers", "nodes: {c:", "translate: [1, 0]\n      nodes: {c:", {"translate: 2 values", "case.yaml:9"}},
        DeckMistake{"TurnWithoutAxis",
                    "nodes: {c:",
                    "rotate: {axis: [0, 0, 0], angle: 90 deg}\n      nodes: {c:",
                    {"the turn has no axis or no angle", "case.yaml:9"}},
        DeckMistake{"TurnInDegrees",
                    "nodes: {c:",
                    "rotate: {axis: [0, 0, 1], angle: 90}\n      nodes: {c:",
                    {"rotate.angle: 90 given", "case.yaml:9"}},
        DeckMistake{"ShellOnLines",
                    "regions: {plate:",
                    "regions: {edge: {material: steel, shell: {thickness: 1 mm}}, plate:",
                    {"edge", "line"}}),
    [](const auto& mistake) { return std::string(mistake.param.name); });

}  // namespace
}  // namespace kalfem::test
