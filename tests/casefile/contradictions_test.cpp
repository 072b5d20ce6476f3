// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <ctime>
#include <fstream>

#include "base/scratch_folder.hpp"
#include "casefile/base_cases.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem::test {
namespace {

struct Change {
  const char* name;
  const char* base;      ///< one of base_cases()
  std::string from, to;  ///< in its text
  std::string place;     ///< text of the line that the message names, in the changed case
  std::vector<std::string> pieces;
};

void PrintTo(const Change& change, std::ostream* out) { *out << change.to; }

class CaseFiles {
public:
  explicit CaseFiles(const std::string& name) : folder_("case-" + name) { write_case_files(folder_); }

  Study load(const std::string& text) const {
    std::ofstream(folder_ / "case.yaml") << text;
    return load_study((folder_ / "case.yaml").string());
  }

private:
  ScratchFolder folder_;
};

std::string base_case(const std::string& wanted) {
  for (const auto& [name, text] : base_cases())
    if (name == wanted) return text;
  throw std::logic_error("there is no case " + wanted);
}

std::string changed(const Change& change) {
  std::string text = base_case(change.base);
  const auto place = text.find(change.from);
  if (place == std::string::npos) throw std::logic_error("the case does not hold " + change.from);
  return text.replace(place, change.from.size(), change.to);
}

/// Number of the line on which the last character of `place` stands.
std::string line_of(const std::string& text, const std::string& place) {
  const auto found = text.find(place);
  if (found == std::string::npos) throw std::logic_error("the changed case does not hold " + place);
  return std::to_string(
      1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(found + place.size()), '\n'));
}

class Contradictions : public testing::TestWithParam<Change> {};

TEST_P(Contradictions, AreRefusedWithTheirLine) {
  const CaseFiles files(GetParam().name);
  const std::string case_text = changed(GetParam());
  try {
    files.load(case_text);
    FAIL() << "accepted";
  } catch (const InvalidInput& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("case.yaml:" + line_of(case_text, GetParam().place) + ": "), std::string::npos) << text;
    for (const auto& piece : GetParam().pieces) EXPECT_NE(text.find(piece), std::string::npos) << piece << "\n" << text;
  }
}

const std::string first_unknown = "    suspension.mu_k1: {initial: 15 N,";

INSTANTIATE_TEST_SUITE_P(
    Parameters, Contradictions,
    testing::Values(
        Change{"ItselfAndInAppliesTo",
               "chain",
               first_unknown,
               "    both: {initial: 15 N, applies_to: [suspension.mu_k1, suspension.mu_c1]}\n" + first_unknown,
               "    suspension.mu_k1:",
               {"'suspension.mu_k1' is estimated already by estimate.unknown.both"}},
        Change{"EntryTwice",
               "chain",
               first_unknown,
               "    both: {initial: 15 N, applies_to: [suspension.mu_c1, suspension.mu_c1]}\n" + first_unknown,
               "both:",
               {"'suspension.mu_c1' is estimated already"}},
        Change{"MixedUnits",
               "chain",
               first_unknown,
               "    both: {initial: 15, applies_to: [suspension.c, suspension.mu_c1]}\n" + first_unknown,
               "both:",
               {"applies to parameters in N s/m and in N"}},
        Change{"RefinedAndEstimated",
               "updating",
               "{strut.k: {",
               "{body.b.stiffness: {initial: 3e4, std: 5 %}, strut.k: {",
               "estimate:",
               {"'body.b.stiffness' is updated already by update.parameters.others"}},
        Change{"StdOfNothing",
               "chain",
               "initial: 15 N, std: 30 %",
               "initial: 15 N, std: 0 N",
               "    suspension.mu_k1:",
               {"standard deviation of the prior is 0"}},
        Change{"NegativeStd",
               "chain",
               "initial: 15 N, std: 30 %",
               "initial: 15 N, std: -30 %",
               "    suspension.mu_k1:",
               {"-30 %"}},
        Change{"PartOfZero",
               "chain",
               "initial: 15 N, std: 30 %, transform: log",
               "initial: 0 N, std: 30 %",
               "    suspension.mu_k1:",
               {"per cent of a value of 0"}},
        Change{"ZeroWithoutStd",
               "chain",
               "initial: 15 N, std: 30 %, transform: log",
               "initial: 0 N",
               "    suspension.mu_k1:",
               {"no `std`"}},
        Change{"LogOfNegative",
               "chain",
               "initial: 15 N, std: 30 %",
               "initial: -15 N, std: 3 N",
               "    suspension.mu_k1:",
               {"-15", "log"}},
        Change{"BoundsExcludeTheStart",
               "chain",
               "bounds: [10 kN/m, 40 kN/m]",
               "bounds: [30 kN/m, 40 kN/m]",
               "    wheel.k_w.stiffness",
               {"21000, outside its bounds 30000 to 40000"}},
        Change{"BoundsExchanged",
               "chain",
               "bounds: [10 kN/m, 40 kN/m]",
               "bounds: [40 kN/m, 10 kN/m]",
               "    wheel.k_w.stiffness",
               {"not below the upper"}},
        Change{"BoundsOfUpdateExcludeTheStart",
               "updating",
               "bounds: [10 kN/m, 60 kN/m], truth",
               "bounds: [29 kN/m, 60 kN/m], truth",
               "    body.a.stiffness",
               {"28000, outside its bounds"}},
        Change{"ParameterOutOfItsRange",
               "chain",
               "mu_k2: 2 mm",
               "mu_k2: -2 mm",
               "    parameters:",
               {"'mu_k2'", "must be positive"}}),
    [](const auto& each) { return std::string(each.param.name); });

INSTANTIATE_TEST_SUITE_P(
    Filter, Contradictions,
    testing::Values(
        Change{"KappaBelowMinusTheVariables", "chain", "kappa: 1\n", "kappa: -24\n", "kappa:", {"kappa -24"}},
        Change{"StartFromRecordWithoutDisplacements",
               "local",
               "  settle: 0.1 s\n",
               "  settle: 0.1 s\n  initial_state_from_record: true\n",
               "initial_state_from_record",
               {"no sensor of the filter's model measures"}},
        Change{"StartFromRecordAndMeans",
               "recorded",
               "displacement_std: 1 mm",
               "displacement: 1 mm",
               "  initial_state: ",
               {"a mean is given together with initial_state_from_record"}},
        Change{"AdaptiveNoiseInPasses",
               "chain",
               "  passes: 2\n",
               "  passes: 2\n  adaptive_noise: {sensors: true}\n",
               "passes:",
               {"estimate.passes is > 1 with estimate.adaptive_noise"}},
        Change{"AdaptiveAndUnknownNoiseOfASensor",
               "recorded",
               "estimate:\n  unknown: {",
               "estimate:\n  adaptive_noise: {sensors: true}\n  unknown: {sensors.u.noise: {initial: 0.1 mm}, ",
               "  unknown: {sensors.u.noise: {",
               {"estimate.unknown.sensors.u.noise is an unknown, and estimate.adaptive_noise.sensors adapts it"}},
        Change{"AdaptiveAndUnknownProcessNoise",
               "recorded",
               "estimate:\n  unknown: {",
               "estimate:\n  adaptive_noise: {process: true}\n  unknown: {process_noise: {initial: 0.1}, ",
               "  unknown: {process_noise: {",
               {"estimate.unknown.process_noise is an unknown, and estimate.adaptive_noise.process adapts it"}},
        Change{"SensorOfAnotherPoint",
               "local",
               "sensor: foot",
               "sensor: wheel",
               "sensor: wheel",
               {"sensor 'wheel' measures 'wheel.w', not 'body.b'"}},
        Change{"UnknownSensorAtTheInterface",
               "local",
               "sensor: foot",
               "sensor: fot",
               "sensor: fot",
               {"'fot'", "mean 'foot'"}},
        Change{"SensorWithoutAcceleration",
               "local",
               "foot: {acceleration",
               "foot: {velocity",
               "sensor: foot",
               {"does not measure acceleration"}},
        Change{"NoNoise", "chain", "noise: 0.2 m/s^2", "noise: 0", "  a2:", {"the noise is 0"}},
        Change{"PredictionWithoutBoundary",
               "local",
               "  settle: 0.1 s\n",
               "  settle: 0.1 s\npredict: {substructure: load}\n",
               "predict:",
               {"does not contain the motion of 'load.m'"}},
        Change{
            "SettleAsLongAsTheRecord", "updating", "settle: 0.1 s", "settle: 5 s", "estimate:", {"the whole record"}}),
    [](const auto& each) { return std::string(each.param.name); });

INSTANTIATE_TEST_SUITE_P(
    Elsewhere, Contradictions,
    testing::Values(
        Change{"ForceBesideABuiltInLaw",
               "chain",
               "    law: saturating\n",
               "    law: saturating\n    force: \"k*x\"\n",
               "law: saturating",
               {"`force` is given beside the law 'saturating'"}},
        Change{"StatesBesideABuiltInLaw",
               "expression",
               "law: linear,",
               "law: linear, states: {z: {rate: v}},",
               "  strut:",
               {"`states` is given beside"}},
        Change{"UnknownReportPoint",
               "chain",
               "displacements: [body.2]",
               "displacements: [body.3]",
               "report:",
               {"there is no point 'body.3'", "did you mean 'body."}},
        Change{"MaterialOfNoDeck",
               "foreign",
               "      nodes: {end: 2}\n",
               "      nodes: {end: 2}\n      materials: {stel: {youngs_modulus: 200 GPa, density: 7850}}\n",
               "deck:",
               {"truss.finite_elements.materials.stel", "the deck has no material 'stel'"}},
        Change{"PictureOfNoSample", "chain", "zoom: 0.2 s", "zoom: 1e-9 s", "report:", {"fewer than two samples"}},
        Change{"TwoRecords",
               "recorded",
               "record:",
               "simulate: {duration: 1, sample_rate: 100}\nrecord:",
               "\nrecord:",
               {"both `simulate` and `record`"}},
        Change{"InputShorterThanTheRecord",
               "inputs",
               "duration: 0.5 s, sample_rate",
               "duration: 1.5 s, sample_rate",
               "  measured:",
               {"excitation.measured", "the input ends at 1 s, 500 ms before 1.5 s"}},
        Change{"DelayedBeforeItsRecord",
               "inputs",
               "delayed: {input: sine",
               "delayed: {input: measured",
               "  later:",
               {"excitation.later"}},
        Change{"FadeInLongerThanTheSignal", "chain", "fade_in: 0.1 s", "fade_in: 3 s", "  road:", {"fade_in is 3 s"}},
        Change{"NoSampleAtAll",
               "chain",
               "duration: 0.5 s",
               "duration: 1 ms",
               "  duration: 1 ms",
               {"is less than one sample"}},
        Change{"StepsFromManyToFew",
               "chain",
               "max_substeps: 256",
               "max_substeps: 2",
               "max_substeps",
               {"first_substeps of 4"}},
        Change{"MassOfNothing", "chain", "w: 1.5 kg", "w: 1e-300 kg", "masses: {w:", {"1e-300 kg given", "[1e-21, "}},
        Change{"ParameterBeyondAllNumbers",
               "chain",
               "k: 5 kN/m",
               "k: 1e300 N/m",
               "    parameters:",
               {"suspension.parameters.k: 1e+300 given", "between 1e-100 and 1e+100"}},
        Change{"RatioNextToNothing", "chain", "modal: 1 %", "modal: 1e-300", "    damping:", {"1e-300 given"}},
        Change{"DelayOfThirtyYears", "inputs", "delay: 1 ms", "delay: 1e9 s", "- delay:", {"1e9 s given", "[0, 100]"}},
        Change{"ValuesTooFarApart",
               "local",
               "stiffness: 1e4, damping: 5",
               "stiffness: 1e4, damping: 1e18",
               "simulate:",
               {"not positive definite at 'load.n'"}},
        Change{
            "StartOfNoDegreeOfFreedom", "chain", "initial: {body.1:", "initial: {body.9:", "  initial: ", {"'body.9'"}},
        Change{"EvolutionWithoutBounds",
               "evolution",
               "bounds: [10 kN/m, 60 kN/m]",
               "std: 10 %",
               "body.a.stiffness",
               {"has no bounds"}},
        Change{
            "EvolutionOfFew", "evolution", "population: 8", "population: 3", "population", {"3 given", "at least 5"}}),
    [](const auto& each) { return std::string(each.param.name); });

class Warnings : public testing::TestWithParam<Change> {};

TEST_P(Warnings, NameTheKeyWithoutEffect) {
  const CaseFiles files(GetParam().name);
  const std::string case_text = changed(GetParam());
  const Study study = files.load(case_text);
  std::string all;
  for (const auto& warning : study.warnings) all += warning + "\n";
  EXPECT_NE(all.find("line " + line_of(case_text, GetParam().place) + ": "), std::string::npos) << all;
  for (const auto& piece : GetParam().pieces) EXPECT_NE(all.find(piece), std::string::npos) << piece << "\n" << all;
}

INSTANTIATE_TEST_SUITE_P(
    Keys, Warnings,
    testing::Values(
        Change{"HhtAlphaOfNewmark",
               "inputs",
               "integrator: hht_alpha,",
               "integrator: newmark,",
               "simulate:",
               {"simulate.hht_alpha has no effect"}},
        Change{"SpectralRadius",
               "chain",
               "  tolerance: 1e-2\n",
               "  tolerance: 1e-2\n  spectral_radius: 0.5\n",
               "spectral_radius",
               {"simulate.spectral_radius"}},
        Change{"ModesOfTheFullReference",
               "beams",
               "reference: superelement",
               "reference: full",
               "modes_up_to",
               {"simulate.modes_up_to"}},
        Change{"ReferenceWithoutElements",
               "local",
               "tolerance: 0.1",
               "tolerance: 0.1, reference: superelement",
               "simulate:",
               {"simulate.reference"}},
        Change{"ReductionOfMasses",
               "chain",
               "    damping: {modal",
               "    reduction: {modes: 2}\n    damping: {modal",
               "reduction:",
               {"substructures.body.reduction"}},
        Change{"ModalUpToOfMasses",
               "chain",
               "{modal: 1 %,",
               "{modal: 1 %, modal_up_to: 100,",
               "modal_up_to",
               {"modal_up_to"}},
        Change{"ModesOfGuyan", "beams", "method: craig_bampton", "method: guyan", "method: guyan", {"reduction.modes"}},
        Change{"RelativeConnector",
               "expression",
               "f: {force: strut,",
               "f: {force: strut, relative: true,",
               "  f:",
               {"sensors.f.relative"}},
        Change{"ChannelWithoutRecord", "chain", "a1: {", "a1: {channel: x, ", "  a1:", {"sensors.a1.channel"}},
        Change{"AlphaOfEkf",
               "expression",
               "  filter: ekf\n",
               "  filter: ekf\n  alpha: 0.5\n",
               "alpha: 0.5",
               {"estimate.alpha"}},
        Change{"ThreadsOfEkf",
               "expression",
               "  filter: ekf\n",
               "  filter: ekf\n  threads: 2\n",
               "threads: 2",
               {"estimate.threads"}},
        Change{"BoundsWithoutLogit",
               "chain",
               "std: 30 %, transform: log",
               "std: 30 %, transform: log, bounds: [1, 90]",
               "    suspension.mu_k1:",
               {"suspension.mu_k1.bounds"}},
        Change{"EvolutionOfLeastSquares",
               "updating",
               "  starts: 1\n",
               "  starts: 1\n  evolution: {generations: 3}\n",
               "evolution:",
               {"update.evolution"}},
        Change{"SeedOfOneStart", "updating", "  starts: 1\n", "  starts: 1\n  seed: 3\n", "  seed: 3", {"update.seed"}},
        Change{"MassKindOfMatrices",
               "foreign",
               "      nodes: {foot: 11, top: 13}\n",
               "      nodes: {foot: 11, top: 13}\n      mass_matrix: lumped\n",
               "mass_matrix",
               {"bar.finite_elements.mass_matrix"}},
        Change{"PicturesOfNoEstimate",
               "plate",
               "  points: [f, m]\n",
               "  points: [f, m]\nreport: {displacements: plate.f.z, frequencies: 2, zoom: 1}\n",
               "report:",
               {"report.displacements", "report.frequencies", "report.zoom"}},
        Change{"CutConnector",
               "local",
               "      wheel.w: {force: {std: 10 N, correlation_time: 0.05 s}}\n",
               "",
               "  mount:",
               {"connectors.mount", "load.m"}}),
    [](const auto& each) { return std::string(each.param.name); });

TEST(CaseProblems, OfAllKindsAreToldTogether) {
  const CaseFiles files("together");
  std::string text = base_case("chain");
  const auto change = [&](const std::string& from, const std::string& to) {
    text.replace(text.find(from), from.size(), to);
  };
  change("rms: 3 mm", "rms: 3 kg");
  change("to: body.1", "to: body.7");
  change("acceleration: body.2", "acceleration: body.8");
  change("displacements: [body.2]", "displacements: [body.9]");
  change("substructure: body", "substructure: bodi");
  change("passes: 2", "passes: 2.5");
  change("max_substeps: 256", "max_substep: 256");
  try {
    files.load(text);
    FAIL();
  } catch (const InvalidInput& error) {
    const std::string message = error.what();
    std::size_t at = 0;
    for (const char* piece : {"body.7", "3 kg", "body.8", "max_substep", "2.5", "bodi", "body.9"}) {
      const auto found = message.find(piece, at);
      EXPECT_NE(found, std::string::npos) << piece << " in order of lines in\n" << message;
      if (found != std::string::npos) at = found;
    }
    EXPECT_EQ(error.issues().size(), 7U) << message;
  }
}

TEST(CaseProblems, MoreMassesThanFullMatricesHold) {
  const CaseFiles files("many-masses");
  try {
    files.load("kalfem: 1\nsubstructures:\n  a: {chain: {masses: 100000, mass: 1 kg, stiffness: 1}}\n");
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("case.yaml:3: substructures.a has 100000 masses"), std::string::npos)
        << error.what();
  }
}

TEST(CaseProblems, OfAHundredAndFiftyThousandKeysAreToldInSeconds) {
  const CaseFiles files("many");
  std::string unknown = base_case("chain"), doubled = "kalfem: 1\nsubstructures:\n  a:\n    masses:\n";
  for (int i = 0; i < 150'000; ++i) unknown += "key" + std::to_string(i) + ": 1\n";
  for (int i = 0; i < 150'000; ++i) doubled += "      m" + std::to_string(i % 75'000) + ": 1\n";
  const std::clock_t begin = std::clock();  // of the processor: others may be at work
  for (const auto& text : {unknown, doubled}) try {
      files.load(text);
      FAIL();
    } catch (const InvalidInput& error) {
      EXPECT_LT(std::string(error.what()).size(), 10'000U);
      EXPECT_GE(error.issues().size(), 75'000U);
    }
  EXPECT_LT(static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC, 15.0);  // quadratic look-ups take minutes
}

}  // namespace
}  // namespace kalfem::test
