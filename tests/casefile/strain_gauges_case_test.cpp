// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <fstream>

#include "base/scratch_folder.hpp"
#include "casefile/case_run.hpp"

#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/steps/prediction/outcome.hpp"

// Strain gauges in cases: measured, estimated, predicted; of reduced against full models; records of strains.

namespace kalfem::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

/// A cantilever of steel along x, 1 m long, of ten beams under a force at its tip, with gauges 5 mm above the axis.
class StrainGauges : public testing::Test {
protected:
  StrainGauges() {
    std::ofstream nodes(folder_ / "nodes.csv"), elements(folder_ / "elements.csv");
    nodes << "node,x_m,y_m,z_m\n";
    elements << "element,node1,node2,region\n";
    for (int i = 0; i <= 10; ++i) nodes << i + 1 << "," << 0.1 * i << ",0,0\n";
    for (int i = 1; i <= 10; ++i) elements << i << "," << i << "," << i + 1 << ",bar\n";
  }

  /// The case with the keys of the gauge `g`, and with more sections.
  [[nodiscard]] std::string text(const std::string& more = "",
                                 const std::string& g = "element: 2, fibre: [0, 5 mm]") const {
    return R"(kalfem: 1
substructures:
  b:
    finite_elements:
      tables: {nodes: )" +
           (folder_ / "nodes.csv").string() + ", elements: " + (folder_ / "elements.csv").string() + R"(}
      materials: {steel: {youngs_modulus: 210 GPa, density: 7850 kg/m^3}}
      regions: {bar: {material: steel, beam: {section: {rectangle: {width: 20 mm, height: 10 mm}}}}}
      nodes: {root: 1, tip: 11}
      fixed: {clamp: {nodes: root}}
      gauges: {g: {)" +
           g + R"(}, h: {element: 6, fibre: [0, 5 mm]}}
    damping: {modal: 1 %}
    reduction: {modes: 4}
excitation:
  f: {force: b.tip.z, random: {rms: 10 N, band: [0.5, 30 Hz], fade_in: 0.1 s, seed: 3}}
sensors:
  a: {acceleration: b.tip.z, noise: 5 %}
  s: {strain: b.g, noise: 2 um/m}
)" + more;
  }

  [[nodiscard]] std::string simulated_case(const std::string& reference) const {
    return text("simulate: {duration: 2 s, sample_rate: 500 Hz, tolerance: 1e-3, reference: " + reference +
                ", modes_up_to: 2 kHz}\n");
  }

  ScratchFolder folder_{"strain-gauges"};
};

TEST_F(StrainGauges, OfASuperelementSeeTheStrainOfTheFullModel) {
  const auto full = results_of(simulated_case("full"), "simulate");
  const auto reduced = results_of(simulated_case("superelement"), "simulate");
  ASSERT_TRUE(full.complete() && reduced.complete()) << full.failure << reduced.failure;
  for (const char* gauge : {"b.g", "b.h"})
    EXPECT_LT(difference(simulated(reduced, gauge, ObservedQuantity::strain),
                         simulated(full, gauge, ObservedQuantity::strain)),
              5e-3)
        << gauge;
}

// The strain at h is not measured: it follows from the force, which is known, and from the two sensors.
TEST_F(StrainGauges, AreEstimatedWithTheirBandAndPredicted) {
  const auto results =
      results_of(text("simulate: {duration: 4 s, sample_rate: 500 Hz, tolerance: 1e-4}\n"
                      "estimate: {settle: 1 s, process_noise: {acceleration: 0.01 m/s^2/sqrt(Hz)}}\n"
                      "predict: {substructure: b}\n"));
  ASSERT_TRUE(results.complete()) << results.failure;
  const auto* estimated = find_quantity(results.get<EstimationOutcome>().points, "b.h", ObservedQuantity::strain);
  ASSERT_NE(estimated, nullptr);
  EXPECT_LT(estimated->nrmse.value(), 0.03);
  EXPECT_LT(estimated->nrmse_in_band.value(), 0.03);
  EXPECT_GT(estimated->coverage.value(), 0.85);  // correlated in time: some tens of independent values
  const auto* predicted = find_quantity(results.get<PredictionOutcome>().points, "b.h", ObservedQuantity::strain);
  ASSERT_NE(predicted, nullptr);
  EXPECT_LT(predicted->nrmse_in_band.value(), 0.05);
  EXPECT_EQ(predicted->deviation.size(), 0);
}

// Strains converge more slowly than shapes: with modes to 236 Hz the one at 146 Hz has a MAC of 0.985 and half its
// strain.
TEST_F(StrainGauges, AReductionThatMissesTheirStrainNamesThem) {
  const auto study = study_of(text());
  const auto& part = *study.structure->finite_elements[0].part;
  const auto indicators = [&](Eigen::Index modes) {
    return craig_bampton(part.full, part.boundary, {.modes = {.count = modes}, .compare_up_to = 150.0})
        .error_indicators;
  };
  const auto few = indicators(4), many = indicators(40);
  EXPECT_GT(few.gauges.at("g"), 0.02);
  EXPECT_LT(many.gauges.at("g"), 1e-3);
  const auto names_the_gauge = testing::Contains(HasSubstr("in the strain at gauge 'g'"));
  EXPECT_THAT(reduction_warnings(few, 30.0, 1.0), names_the_gauge);
  EXPECT_THAT(reduction_warnings(many, 30.0, 1.0), Not(names_the_gauge));
}

TEST_F(StrainGauges, ModesOfTheComparisonServeTheReport) {
  const auto study = study_of(text());
  const auto& elements = study.structure->finite_elements[0];
  ASSERT_NE(elements.reduced, nullptr);
  const auto& known = *elements.reduced->full_modes;
  ASSERT_GE(known.frequencies.size(), study.report.modes);
  const NormalModes modes = lowest_full_modes(elements, study.report.modes);
  EXPECT_EQ(modes.shapes, known.shapes.leftCols(study.report.modes));
  EXPECT_EQ(modes.frequencies, known.frequencies.head(study.report.modes));
  const Eigen::Index more = known.frequencies.size() + 2;
  EXPECT_EQ(lowest_full_modes(elements, more).frequencies.size(), more);
}

TEST_F(StrainGauges, OnAnElementThatDoesNotExistAreRefusedOnceWithTheirPlace) {
  const auto problems = problems_of(text("", "element: 99"));
  EXPECT_THAT(problems, AllOf(HasSubstr("case.yaml:10: strain gauge 'g' stands on element 99"),
                              HasSubstr("or give the place as at: [x, y, z]")));
  EXPECT_EQ(std::ranges::count(problems, '\n'), 0) << problems;
}

TEST_F(StrainGauges, AreNoPointsAndPointsAreNoGauges) {
  EXPECT_THAT(problems_of(changed(text(), "strain: b.g", "strain: b.k")), HasSubstr("strain gauge 'b.k'"));
  EXPECT_THAT(problems_of(changed(text(), "acceleration: b.tip.z", "acceleration: b.g")), HasSubstr("'b.g'"));
  EXPECT_THAT(problems_of(changed(text(), "force: b.tip.z", "force: b.g")), HasSubstr("'b.g'"));
  EXPECT_THAT(problems_of(text("report: {strains: [b.tip.z]}\n")), HasSubstr("'b.tip.z'"));
}

TEST_F(StrainGauges, NoiseIsWrittenAsItWasRead) {
  const auto resolved = study_of(simulated_case("full")).resolved_case;
  EXPECT_THAT(resolved, AllOf(HasSubstr("noise: 5 %"), HasSubstr("noise: 2e-06 -")));
  EXPECT_EQ(study_of(resolved).sensors[1].noise, 2e-6);
  EXPECT_FALSE(study_of(resolved).sensors[1].relative_noise);
}

/// A record of zeros and a strain of 50 um/m at the end.
class StrainRecords : public StrainGauges {
protected:
  [[nodiscard]] std::string reading(const std::string& title, const std::string& largest) const {
    std::ofstream file(folder_ / "record.csv");
    file << "time,a [m/s^2]," << title << "\n";
    for (int k = 0; k < 100; ++k) file << 0.01 * k << "," << 0.1 * k << "," << (k == 99 ? largest : "0") << "\n";
    return text("record: {file: " + (folder_ / "record.csv").string() + "}\n");
  }
};

TEST_F(StrainRecords, AreReadInTheUnitsOfTheField) {
  for (const auto& [title, largest] : {std::pair{"s [um/m]", "50"},
                                       {"s [µm/m]", "50"},
                                       {"s [ustrain]", "50"},
                                       {"s [µε]", "50"},
                                       {"s [uE]", "50"},
                                       {"s [microstrain]", "50"},
                                       {"s [ppm]", "50"},
                                       {"s [strain]", "5e-5"},
                                       {"s [%]", "0.005"},
                                       {"s [mm/m]", "0.05"},
                                       {"s", "5e-5"}})
    EXPECT_NEAR(study_of(reading(title, largest)).record->record.values(1, 99), 50e-6, 1e-17) << title;
}

TEST_F(StrainRecords, ThatNoStructureSurvivesAreRefused) {
  EXPECT_THAT(problems_of(reading("s", "50")),
              AllOf(HasSubstr("channel 's' spans a strain of 50 m/m"), HasSubstr("um/m")));
  EXPECT_THAT(problems_of(reading("s [mm]", "50")), HasSubstr("mm"));
}

}  // namespace
}  // namespace kalfem::test
