// SPDX-License-Identifier: Apache-2.0
#include <fstream>

#include "base/scratch_folder.hpp"
#include "casefile/case_run.hpp"
#include "formats/plate_msh.hpp"
#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/steps/run_study.hpp"

// Connectors that end at a ground: of a finite-element substructure without springs, the fixed one, and two grounds.

namespace kalfem::test {
namespace {

using enum ObservedQuantity;

/// @1 springs and grounds of the plate, @2 connectors, @3 the ground that moves.
const std::string plate_case = R"(kalfem: 1
substructures:
  plate:
    finite_elements:
      mesh: @0
      materials: {steel: {youngs_modulus: 210 GPa, density: 7850 kg/m^3}}
      regions: {plate: {material: steel, shell: {thickness: 5 mm}}}
      nodes: {f: far}
      fixed: {clamp: {nodes: edge}}
    @1
    reduction: {modes: 8}
connectors: {@2}
excitation:
  road: {base_displacement: @3, random: {rms: 1 mm, band: [1, 20 Hz]}}
sensors: {a: {acceleration: plate.f.z, noise: 1 %}}
simulate: {duration: 1 s, sample_rate: 1 kHz, integrator: generalized_alpha, tolerance: 1e-3}
)";

class PlateOnAGround : public testing::Test {
protected:
  PlateOnAGround() : folder_("plate-ground") { std::ofstream(folder_ / "plate.msh") << plate_msh; }

  [[nodiscard]] std::string with(const std::string& part, const std::string& connectors,
                                 const std::string& moved) const {
    auto text = changed(plate_case, "@0", (folder_ / "plate.msh").string());
    text = changed(changed(text, "    @1\n", part.empty() ? "" : "    " + part + "\n"), "@2", connectors);
    return changed(text, "@3", moved);
  }

private:
  ScratchFolder folder_;
};

const std::string mount = "mount: {from: plate.@, to: plate.f.z, law: linear, parameters: {k: 8000, c: 30}}";

TEST_F(PlateOnAGround, AConnectorPullsAsASpringToTheSameGround) {
  const auto spring = results_of(
      with("springs: [{name: s, from: ground, to: f.z, stiffness: 8000, damping: 30}]\n"
           "    points: {p: {f.z: 1}}",
           "feeler: {from: ground, to: plate.f.z, law: linear, parameters: {k: 1e-6, c: 0}}", "plate.ground"));
  const auto connector = results_of(with("", changed(mount, "@", "ground"), "plate.ground"));
  const auto named = results_of(with("grounds: [table]", changed(mount, "@", "table"), "plate.table"));
  ASSERT_TRUE(spring.complete()) << spring.failure;
  const auto reduced = results_of(changed(with("", changed(mount, "@", "ground"), "plate.ground"), "tolerance: 1e-3",
                                          "tolerance: 1e-3, reference: superelement, modes_up_to: 2 kHz"));
  ASSERT_TRUE(connector.complete()) << connector.failure;
  ASSERT_TRUE(reduced.complete()) << reduced.failure;
  const auto& expected = simulated(spring, "plate.f.z", acceleration);
  // the same equations: found 4e-10, and with the superelement, which lacks what is above 2 kHz, 2.3e-7
  EXPECT_LT(difference(simulated(connector, "plate.f.z", acceleration), expected), 2e-9);  // two references of 1e-3
  EXPECT_LT(difference(simulated(named, "plate.f.z", acceleration), expected), 2e-9);
  EXPECT_LT(difference(simulated(reduced, "plate.f.z", acceleration), expected), 1e-6);
}

TEST_F(PlateOnAGround, TheFilterHoldsTheConnector) {
  const auto results = results_of(with("", changed(mount, "@", "ground"), "plate.ground") +
                                  "estimate: {unknown: {mount.k: {initial: 7 kN/m, std: 1 kN/m}}, settle: 0.2 s, "
                                  "process_noise: {acceleration: 1e-3}}\n");
  ASSERT_TRUE(results.complete()) << results.failure;
  const auto& unknowns = results.get<EstimationOutcome>().result.unknowns;
  // four deviations of one record; found .27 of one
  EXPECT_NEAR(unknowns.mean.rightCols(1)(0), 8000.0, 4.0 * unknowns.deviation.rightCols(1)(0));
  EXPECT_GT(unknowns.deviation.rightCols(1)(0), 5.0);
  EXPECT_LT(unknowns.deviation.rightCols(1)(0), 25.0);  // found 11 N/m
}

/// A mass between a support that moves and the fixed ground, and a connector from one ground to the other.
const std::string frame = R"(kalfem: 1
substructures:
  frame:
    masses: {m: 2 kg}
    grounds: [table, wall]
    springs: [{name: s, from: table, to: m, stiffness: 5 kN/m, damping: 10}]
  other: {masses: {m: 1 kg}, springs: [{from: ground, to: m, stiffness: 1 kN/m, damping: 10}]}
connectors:
  across: {from: @1, to: @2, law: cubic, parameters: {k: 300, k3: 1e7, c: 4}}
  stay: {from: ground, to: frame.m, law: linear, parameters: {k: 2000, c: 5}}
excitation:
  road: {base_displacement: frame.table, random: {rms: 3 mm, band: [1, 20 Hz]}}
sensors: {a: {acceleration: frame.m, noise: 1 %}, f: {force: across, noise: 1 %}}
simulate: {duration: 2 s, sample_rate: 500 Hz, integrator: @3, tolerance: 1e-4}
)";

std::string across(const std::string& from, const std::string& to, const std::string& integrator = "newmark") {
  return changed(changed(changed(frame, "@1", from), "@2", to), "@3", integrator);
}

TEST(ConnectorGrounds, AConnectorStandsBetweenAMovedAndAFixedGround) {
  for (const char* fixed : {"frame.wall", "ground", "other.ground"})
    for (const char* integrator : {"newmark", "exact"}) {
      const auto study = study_of(across("frame.table", fixed, integrator));
      const auto results = run_study(study, "simulate");
      ASSERT_TRUE(results.complete()) << results.failure;
      const auto r = study.structure->signals[0]->sample(0.0, 2e-3, 1001);
      const Eigen::ArrayXd d = -r.col(0);
      // rounding: the two grounds move by themselves
      EXPECT_LT(difference(simulated(results, "across", connector_deformation), d.matrix()), 2e-13);
      const Eigen::VectorXd force = 300.0 * d + 1e7 * d.cube() - 4.0 * r.col(1);
      EXPECT_LT(difference(simulated(results, "across", connector_force), force), 2e-13);
    }
}

TEST(ConnectorGrounds, TheFixedGroundIsThatOfASubstructure) {
  const auto fixed = results_of(across("frame.table", "ground"));
  const auto wall = results_of(
      changed(across("frame.table", "ground"), "{from: ground, to: frame.m", "{from: frame.wall, to: frame.m"));
  EXPECT_EQ(simulated(fixed, "frame.m", acceleration), simulated(wall, "frame.m", acceleration));
}

TEST(ConnectorGrounds, TheFilterFindsTheLawBetweenTwoGrounds) {
  for (const std::string filter : {"auto", "partially_linear_ukf_square_root", "ukf", "ukf_square_root", "ekf"}) {
    const auto results =
        results_of(across("frame.table", "ground") + "estimate: {filter: " + filter +
                   ", unknown: {across.k: {initial: 200, std: 100}, stay.k: {initial: 1500, std: 500}}, "
                   "settle: 0.2 s}\n");
    ASSERT_TRUE(results.complete()) << results.failure;
    const auto& unknowns = results.get<EstimationOutcome>().result.unknowns;
    for (const auto& [i, truth] : {std::pair{0, 300.0}, std::pair{1, 2000.0}})
      // four deviations of one record; found .7 and .15 of one
      EXPECT_NEAR(unknowns.mean.rightCols(1)(i), truth, 4.0 * unknowns.deviation.rightCols(1)(i));
    EXPECT_GT(unknowns.deviation.rightCols(1)(0), 0.1);
    EXPECT_LT(unknowns.deviation.rightCols(1)(0), 0.4);  // found .19
    // 900 samples of two channels: three standard errors
    EXPECT_NEAR(results.get<EstimationOutcome>().consistency.mean_nis, 2.0, 0.2);
  }
}

/// A part of the structure keeps the connectors that hold it to grounds of the rest.
TEST(ConnectorGrounds, ALocalModelKeepsItsConnectorsToGrounds) {
  const auto text = across("frame.table", "ground") +
                    "estimate: {unknown: {stay.k: {initial: 1500, std: 500}}, settle: 0.2 s, local: {substructures: "
                    "frame, interface: {}}}\n";
  for (const char* stay : {"{from: ground, to: frame.m", "{from: other.ground, to: frame.m"}) {
    const auto results = results_of(changed(text, "{from: ground, to: frame.m", stay));
    ASSERT_TRUE(results.complete()) << results.failure;
    const auto& unknowns = results.get<EstimationOutcome>().result.unknowns;
    // four deviations of one record; found .15 of one
    EXPECT_NEAR(unknowns.mean.rightCols(1)(0), 2000.0, 4.0 * unknowns.deviation.rightCols(1)(0)) << stay;
  }
  // the moved ground of a part that is left out still drives the kept one
  const auto driven =
      results_of(changed(changed(text, "stay: {from: ground, to: frame.m", "stay: {from: frame.table, to: other.m"),
                         "substructures: frame, interface: {}}",
                         "substructures: other, interface: {}}, process_noise: {acceleration: 1e-3}") +
                 "");
  ASSERT_TRUE(driven.complete()) << driven.failure;
}

TEST(ConnectorGrounds, TwoGroundsThatDoNotMoveAreRefusedWithTheirLine) {
  const auto found = problems_of(across("frame.wall", "ground"));
  EXPECT_NE(
      found.find("case.yaml:9: connector 'across' connects the grounds 'frame.wall' and 'ground', which do not move"),
      std::string::npos)
      << found;
  EXPECT_NE(problems_of(across("frame.table", "frame.table")).find("case.yaml:9"), std::string::npos);
  EXPECT_NE(problems_of(changed(across("frame.table", "ground"), "acceleration: frame.m", "acceleration: ground"))
                .find("there is no point 'ground'"),
            std::string::npos);
}

}  // namespace
}  // namespace kalfem::test
