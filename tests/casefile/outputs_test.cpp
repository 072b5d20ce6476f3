// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "casefile/probes.hpp"
#include "kalfem/estimation/consistency.hpp"
#include "kalfem/formats/hdf5/hdf5_file.hpp"
#include "kalfem/identification/stated_interval.hpp"
#include "kalfem/page/display_unit.hpp"
#include "kalfem/report/result_set.hpp"
#include "kalfem/statistics/quantiles.hpp"
#include "kalfem/steps/estimation/report.hpp"
#include "kalfem/steps/inference/outcome.hpp"
#include "kalfem/steps/modes/report.hpp"
#include "kalfem/steps/prediction/outcome.hpp"
#include "kalfem/steps/simulation/outcome.hpp"
#include "kalfem/steps/updating/outcome.hpp"
#include "steps/sample_inference.hpp"

/// summary.json and results.h5 say what was computed: each number stands under its own name and in its own unit.
namespace kalfem::wiring {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using Json = nlohmann::ordered_json;

/// Everything that a case may ask for, in one.
struct Everything {
  Study study = study_of(estimated_case(
      {{"title", "everything"},
       {"substructures",
        "{w: {masses: {w: 1.5}, springs: [{from: ground, to: w, stiffness: 2e3}]}, s: {masses: {a: 2, b: 3, c: 1}, "
        "springs: [{name: k, from: a, to: b, stiffness: 800}, {name: m, from: b, to: c, stiffness: 700}], "
        "damping: {modal: 2 %}}}"},
       {"connectors", "{c: {from: w.w, to: s.a, law: linear, parameters: {k: 500, c: 3}}}"},
       {"excitation", "{f: {force: w.w, random: {rms: 5, band: [0.5, 8], fade_in: 0.2}}}"},
       {"sensors", "{yw: {acceleration: w.w, noise: 2 %}, yb: {displacement: s.b, noise: 5 %}}"},
       {"simulate", "{duration: 2 s, sample_rate: 100 Hz}"},
       {"estimate",
        "{unknown: {c.k: {initial: 400, std: 80, transform: log}, c.c: {initial: 2, std: 1}}, settle: 0.5 s}"},
       {"predict", "{substructure: s}"},
       {"update",
        "{parameters: {s.k.stiffness: {initial: 640, bounds: [100, 3000], std: 300}, s.m.stiffness: {initial: 810}}, "
        "compare: {f: {modes: s, frequencies: [2.9, 5.5], above: 0.5 Hz, weight: 2}}, check_sensitivities: true}"},
       {"modifications", "{m: {substructure: s, set: {k.stiffness: 900}, above: 0.5 Hz, modes: 2}}"}}));
  StudyResults results = run(study, "update");
};

const Everything& everything() {
  static const Everything all;
  return all;
}

void same(const Json& json, double expected) {
  ASSERT_TRUE(json.is_number()) << json;
  near(json.get<double>(), expected);
}

TEST(Summary, HoldsTheParametersOfTheFilter) {
  const auto& [study, results] = everything();
  const auto& outcome = results.get<EstimationOutcome>();
  const auto summary = summarise(study, results);
  const Index last = outcome.result.unknowns.mean.cols() - 1, first = outcome.augmented_model->layout().unknown();
  const double truth[] = {500.0, 3.0}, initial[] = {400.0, 2.0};
  const char* names[] = {"c.k", "c.c"};
  const char* units[] = {"N/m", "N s/m"};
  for (Index i : {0, 1}) {
    const auto& own = summary["parameters"][names[i]];
    same(own["true"], truth[i]);
    same(own["initial"], initial[i]);
    same(own["estimate"], outcome.result.unknowns.mean(i, last));
    same(own["std"], outcome.result.unknowns.deviation(i, last));
    EXPECT_EQ(own["unit"], units[i]);
    const double mean = outcome.result.state.mean(first + i, last),
                 deviation = outcome.result.state.deviation(first + i, last);
    const auto value = [&](double x) { return i == 0 ? std::exp(x) : x; };
    const double widening = outcome.robust_deviation[i] / outcome.result.unknowns.deviation(i, last);
    const double half = 1.959963984540054 * deviation * std::max(1.0, widening);
    near(own["interval_95"][0].get<double>(), value(mean - half), many_roundings);
    near(own["interval_95"][1].get<double>(), value(mean + half), many_roundings);
    EXPECT_EQ(own["interval_95_from"], widening > 1.0 ? "std_robust" : "std");
    near(own["std"].get<double>(), deviation * (i == 0 ? std::exp(mean) : 1.0), many_roundings);
    const double prior = i == 0 ? 80.0 : 1.0, prior_in_state = i == 0 ? prior / initial[i] : prior;
    near(own["prior_std"].get<double>(), prior, many_roundings);
    near(own["shrinkage"].get<double>(), deviation / prior_in_state, many_roundings);
    near(own["moved_prior_std"].get<double>(),
         std::abs(mean - (i == 0 ? std::log(initial[i]) : initial[i])) / prior_in_state, many_roundings);
  }
}

/// c.k is in the filter's state by its logarithm, c.c as it is.
TEST(StatedInterval, ComesFromTheLargerOfTheTwoDeviations) {
  EstimationOutcome outcome = everything().results.get<EstimationOutcome>();
  const Index last = outcome.result.unknowns.mean.cols() - 1, first = outcome.augmented_model->layout().unknown();
  const VectorXd stated = outcome.result.unknowns.deviation.col(last), mean = outcome.result.unknowns.mean.col(last);
  outcome.robust_deviation = VectorXd{{3.0 * stated[0], 0.5 * stated[1]}};
  const auto wider = stated_interval(outcome, 0), usual = stated_interval(outcome, 1);
  EXPECT_TRUE(wider.robust);
  EXPECT_FALSE(usual.robust);
  const double factor = std::exp(3.0 * 1.959963984540054 * outcome.result.state.deviation(first, last));
  near(wider.upper, mean[0] * factor, many_roundings);
  near(wider.lower, mean[0] / factor, many_roundings);
  near(usual.upper, mean[1] + 1.959963984540054 * stated[1], many_roundings);
  near(usual.lower, mean[1] - 1.959963984540054 * stated[1], many_roundings);
  const auto table = parameter_table(everything().study, outcome);
  EXPECT_EQ(table.columns[4], "95 % interval");
  const double std = outcome.result.unknowns.deviation(0, outcome.result.unknowns.deviation.cols() - 1);
  const DisplayUnit shown(table.rows[0][1], {1.0});
  EXPECT_EQ(table.rows[0][4], shown.value(wider.lower, std) + " to " + shown.value(wider.upper, std));
  EXPECT_EQ(table.rows[0][5], "robust std");
  EXPECT_EQ(table.rows[1][5], "std");
}

TEST(StatedInterval, IsTheFiltersWhereThereIsNoRobustDeviation) {
  EstimationOutcome outcome = everything().results.get<EstimationOutcome>();
  outcome.robust_deviation.setConstant(std::numeric_limits<double>::quiet_NaN());
  const auto interval = stated_interval(outcome, 1);
  EXPECT_FALSE(interval.robust);
  const Index last = outcome.result.unknowns.mean.cols() - 1;
  near(interval.upper - interval.lower, 2.0 * 1.959963984540054 * outcome.result.unknowns.deviation(1, last),
       many_roundings);
}

TEST(Summary, HoldsTheConsistencyOfTheFilter) {
  const auto& [study, results] = everything();
  const auto& outcome = results.get<EstimationOutcome>();
  const auto summary = summarise(study, results)["estimation"];
  const VectorXd nis = outcome.result.nis.tail(201 - 50);
  same(summary["nis"]["mean"], nis.mean());
  same(summary["nis"]["expected"], 2.0);
  const double low = chi_squared_quantile(0.025, 2.0), high = chi_squared_quantile(0.975, 2.0);
  same(summary["nis"]["fraction_in_95"],
       double((nis.array() >= low && nis.array() <= high).count()) / double(nis.size()));
  near(low, 0.050636, 1e-5);  // the table prints six decimals
  near(high, 7.377759, 1e-7);
  for (Index i : {0, 1}) {
    const VectorXd innovation = outcome.result.innovation.row(i).tail(151).transpose();
    const double noise = outcome.measurements.channels[std::size_t(i)].noise;
    same(summary["innovation_to_noise"][i == 0 ? "yw" : "yb"], rms(innovation) / noise);
    near(noise, (i == 0 ? 0.02 : 0.05) * rms(results.get<SimulationOutcome>().reference.sensors.row(i).transpose()));
  }
  same(summary["log_likelihood"], outcome.result.log_likelihood);
  EXPECT_EQ(summary["steps"], 201);
  EXPECT_EQ(summary["state_dimension"], 2 * 4 + 2);
  EXPECT_EQ(summary["filter"], "partially_linear_ukf");
}

TEST(Summary, HoldsErrorsAgainstTheTruthAfterSettling) {
  const auto& [study, results] = everything();
  const auto summary = summarise(study, results);
  const char* keys[] = {"displacement_nrmse", "velocity_nrmse",    "acceleration_nrmse",
                        "force_nrmse",        "deformation_nrmse", "rate_nrmse"};
  const auto check = [&](const PointQuantity& point, const Json& own) {
    const auto* truth = [&]() -> const PointQuantity* {
      for (const auto& each : results.get<SimulationOutcome>().points)
        if (each.point == point.point && each.quantity == point.quantity) return &each;
      return nullptr;
    }();
    ASSERT_NE(truth, nullptr);
    same(own[keys[int(point.quantity)]], nrmse(point.mean.tail(151), truth->mean.tail(151)));
  };
  for (const auto& point : results.get<EstimationOutcome>().points)
    check(point, summary["estimation"]["states"][point.point]);
  for (const auto& point : results.get<PredictionOutcome>().points)
    check(point, summary["prediction"]["s"][point.point.substr(point.point.find('.') + 1)]);
  const VectorXd frequencies = results.get<ModificationsOutcome>().modifications.at(0).frequencies;
  for (Index i : {0, 1}) same(summary["prediction"]["m"]["frequencies_hz"][std::size_t(i)], frequencies[i]);
  EXPECT_EQ(summary["prediction"]["m"]["substructure"], "s");
}

TEST(Summary, HoldsTheUpdating) {
  const auto& [study, results] = everything();
  const auto& outcome = results.get<UpdatingOutcome>();
  const auto summary = summarise(study, results)["updating"];
  const char* names[] = {"s.k.stiffness", "s.m.stiffness"};
  for (Index i : {0, 1}) {
    const auto& own = summary["parameters"][names[i]];
    same(own["true"], i == 0 ? 800.0 : 700.0);
    same(own["initial"], i == 0 ? 640.0 : 810.0);
    same(own["estimate"], outcome.values[i]);
    same(own["std"], outcome.statistics.deviations[i]);
    near(own["std"].get<double>(), std::sqrt(summary["covariance"][std::size_t(i)][std::size_t(i)].get<double>()),
         many_roundings);
    same(summary["correlation"][0][std::size_t(i)], outcome.statistics.correlation(0, i));
    same(summary["sensitivities"][names[i]]["deviation"], outcome.sensitivities[std::size_t(i)].deviation);
    same(summary["sensitivities"][names[i]]["uncertainty"], outcome.sensitivities[std::size_t(i)].uncertainty);
  }
  same(summary["parameters"]["s.k.stiffness"]["lower"], 100.0);
  same(summary["parameters"]["s.k.stiffness"]["upper"], 3000.0);
  same(summary["parameters"]["s.k.stiffness"]["prior_std"], 300.0);
  same(summary["residual_initial"], outcome.residual_initial);
  same(summary["residual_final"], outcome.residual_final);
  EXPECT_LT(outcome.residual_final, outcome.residual_initial);
  EXPECT_EQ(summary["evaluations"], outcome.evaluations);
  EXPECT_EQ(summary["iterations"], outcome.iterations);
  const auto& comparison = summary["comparisons"]["f"];
  same(comparison["weight"], 2.0);
  EXPECT_EQ(comparison["values"], 2);
  same(comparison["rms_initial"], outcome.comparisons[0].rms_initial);
  same(comparison["rms_final"], outcome.comparisons[0].rms_final);
  for (std::size_t i : {0, 1}) {
    same(comparison["modes"][i]["measured_hz"], i == 0 ? 2.9 : 5.5);
    same(comparison["modes"][i]["model_hz"], outcome.comparisons[0].modes_final[i].model_frequency);
    near(comparison["modes"][i]["error"].get<double>(),
         comparison["modes"][i]["model_hz"].get<double>() / (i == 0 ? 2.9 : 5.5) - 1.0, 1e-9);  // of parts of 1e-5
  }
  EXPECT_EQ(summary["stages"].size(), outcome.trace.size());
  same(summary["stages"][1]["residual"], outcome.trace[1].residual);
  same(summary["stages"][1]["tried"][1], outcome.trace[1].tried[1]);
  same(summary["unknowns_without_updating"]["c.c"], outcome.unknowns_before[1]);
}

TEST(Summary, HoldsTheModel) {
  const auto& [study, results] = everything();
  const auto summary = summarise(study, results)["model"];
  EXPECT_EQ(summary["dofs"], 4);
  same(summary["substructures"]["s"]["mass"], 6.0);
  same(summary["substructures"]["s"]["frequencies_hz"][1], results.get<ModesOutcome>().substructures[1].frequencies[1]);
  const auto beam = study_of(beam_case());
  const auto reduced = summarise(beam, run(beam, "modes"))["model"]["substructures"]["b"];
  const auto& error_indicators = beam.structure->finite_elements[0].reduced->error_indicators;
  same(reduced["reduction"]["highest_kept_hz"], error_indicators.highest_kept);
  same(reduced["reduction"]["next_left_out_hz"], error_indicators.next_left_out);
  same(reduced["reduction"]["modes"][0]["full_hz"], error_indicators.modes[0].full);
  same(reduced["reduction"]["modes"][0]["reduced_hz"], error_indicators.modes[0].reduced);
  same(reduced["reduction"]["modes"][0]["mac"], error_indicators.modes[0].mac);
}

TEST(ModesTable, ComparesEveryModeThatAReductionKeeps) {
  const auto beam = study_of(beam_case());
  const auto table = modes_table(beam, run(beam, "modes"));
  const auto& indicators = beam.structure->finite_elements[0].reduced->error_indicators;
  EXPECT_EQ(table.columns, (std::vector<std::string>{"substructure", "mode", "full [Hz]", "reduced [Hz]", "difference",
                                                     "MAC", "residual"}));
  ASSERT_GE(indicators.modes.size(), 1u);
  EXPECT_LE(indicators.modes.back().full, indicators.highest_kept * 1.00001);
  for (std::size_t i = 0; i < indicators.modes.size(); ++i) {
    const auto row = std::ranges::find_if(
        table.rows, [&](const auto& each) { return each[0] == "b" && each[1] == std::to_string(i + 1); });
    ASSERT_NE(row, table.rows.end());
    for (const auto& cell : *row) EXPECT_NE(cell, "-") << i;
  }
  const bool is_complete =
      std::ranges::none_of(table.rows, [](const auto& row) { return row[0] == "b" && row[3] == "-"; });
  EXPECT_EQ(table.caption.find("The reduction of 'b' keeps modes up to") == std::string::npos, is_complete)
      << table.caption;
}

TEST(ModesTable, WritesSixDigitsWhereOnlyTheseTellFrequenciesApart) {
  auto beam = study_of(beam_case());
  auto reduced = *beam.structure->finite_elements[0].reduced;
  reduced.error_indicators.modes = {{.full = 12.3456, .reduced = 12.3471, .mac = 0.99, .residual = 2e-3},
                                    {.full = 12.3456, .reduced = 12.4, .mac = 0.99, .residual = 2e-3},
                                    {.full = 12.3456, .reduced = 12.34560001, .mac = 1.0, .residual = 2e-9}};
  auto structure = *beam.structure;
  structure.finite_elements[0].reduced = std::make_shared<const Superelement>(reduced);
  beam.structure = std::make_shared<const StructureModel>(structure);
  StudyResults results;
  results.put(ModesOutcome{{{.name = "b", .frequencies = VectorXd::Zero(3)}}, {}});
  const auto table = modes_table(beam, results);
  const auto frequencies = [&](std::size_t row) { return std::pair(table.rows[row][2], table.rows[row][3]); };
  EXPECT_EQ(frequencies(0), std::pair(std::string("12.3456"), std::string("12.3471")));
  EXPECT_EQ(frequencies(1), std::pair(std::string("12.35"), std::string("12.4")));
  EXPECT_EQ(frequencies(2), std::pair(std::string("12.35"), std::string("12.35")));
  EXPECT_EQ(table.rows[0][6], "2.0e-03");
  EXPECT_EQ(table.caption, "") << "nothing is left out";
}

TEST(ModesTable, SaysWhyNothingIsCompared) {
  const auto& [study, results] = everything();
  const auto table = modes_table(study, results);
  EXPECT_EQ(table.columns.size(), 4u)
      << "no empty columns: the case updates, so that its modes stand beside the initial ones";
  EXPECT_NE(table.caption.find("'w' and 's' are lumped: there is nothing to reduce"), std::string::npos)
      << table.caption;
}

TEST(ResultsFile, HoldsThePosteriorByChainAndDraw) {
  const Study& study = everything().study;
  StudyResults results;
  results.put(sample_inference());
  const auto& outcome = results.get<InferenceOutcome>();
  const auto path = write_file("posterior.h5", "").string();
  write_results(path, study, results, "this run");
  const auto file = Hdf5File::open(path);
  const auto& samples = outcome.samples;
  for (Index i = 0; i < 4; ++i) {
    const std::string name = "/posterior/" + samples.names[std::size_t(i)];
    EXPECT_EQ(file.read_matrix(name), samples.draws_of(i).transpose()) << name;
    EXPECT_EQ(file.text_attribute(name, "unit"), outcome.units[std::size_t(i)]);
    EXPECT_TRUE(file.has_attribute(name, "DIMENSION_LIST"));
  }
  EXPECT_EQ(file.read("/posterior/chain"), Eigen::Vector4d(0.0, 1.0, 2.0, 3.0));
  EXPECT_EQ(file.read("/posterior/draw"), VectorXd::LinSpaced(300, 0.0, 299.0));
  EXPECT_EQ(file.read_matrix("/sample_stats/lp")(1, 2), samples.log_likelihood[300 + 2] + samples.log_prior[300 + 2]);
  EXPECT_EQ(file.read_matrix("/sample_stats/log_likelihood")(3, 299), samples.log_likelihood[1199]);
  EXPECT_EQ(file.read("/predictive/a3/mean"), outcome.bands[0].mean);
  EXPECT_EQ(file.read("/predictive/a3/lower"), outcome.bands[0].lower);
  EXPECT_EQ(file.read("/predictive/a3/upper"), outcome.bands[0].upper);
  EXPECT_EQ(file.read("/predictive/time")[1], 1.005);
  EXPECT_EQ(file.read("/profile/suspension.mu_k1/value"), outcome.profiles[0].values);
  EXPECT_EQ(file.read("/profile/suspension.mu_k1/log_likelihood"), outcome.profiles[0].log_likelihood);
}

TEST(ResultsFile, HoldsWeightedSamplesWithEqualWeights) {
  const Study& study = everything().study;
  StudyResults results;
  results.put(sample_inference());
  auto& samples = results.get<InferenceOutcome>().samples;
  samples.chains = 1;
  samples.draws = samples.values.cols();
  samples.weights = VectorXd::Zero(samples.draws);
  samples.weights[7] = 0.25;
  samples.weights[9] = 0.75;
  const auto path = write_file("weighted.h5", "").string();
  write_results(path, study, results, "this run");
  const VectorXd drawn = Hdf5File::open(path).read("/posterior/suspension.k");
  EXPECT_EQ((drawn.array() == samples.values(0, 7)).count(), 300);
  EXPECT_EQ((drawn.array() == samples.values(0, 9)).count(), 900);
}

TEST(ResultsFile, HoldsEverySeriesUnderItsName) {
  const auto& [study, results] = everything();
  const auto path = write_file("results.h5", "").string();
  write_results(path, study, results, "this run");
  const auto file = Hdf5File::open(path);
  EXPECT_EQ(file.text_attribute("/", "run"), "this run");
  const auto check = [&](const std::string& name, const VectorXd& expected, const std::string& unit) {
    ASSERT_TRUE(file.contains(name)) << name;
    EXPECT_EQ(file.read(name), expected) << name;
    EXPECT_EQ(file.text_attribute(name, "unit"), unit) << name;
  };
  const char* names[] = {"displacement", "velocity", "acceleration", "force", "deformation", "rate"};
  const char* units[] = {"m", "m/s", "m/s^2", "N", "m", "m/s"};
  for (const auto& point : results.get<SimulationOutcome>().points)
    check("/truth/" + point.point + "/" + names[int(point.quantity)], point.mean, units[int(point.quantity)]);
  for (const auto& point : results.get<EstimationOutcome>().points) {
    const std::string name = "/estimate/" + point.point + "/" + names[int(point.quantity)];
    check(name, point.mean, units[int(point.quantity)]);
    check(name + "_std", point.deviation, units[int(point.quantity)]);
  }
  for (const auto& point : results.get<PredictionOutcome>().points)
    check("/prediction/" + point.point + "/" + names[int(point.quantity)], point.mean, units[int(point.quantity)]);
  const auto& estimate = results.get<EstimationOutcome>().result;
  check("/estimate/parameters/c.c", estimate.unknowns.mean.row(1).transpose(), "N s/m");
  check("/estimate/parameters/c.c_std", estimate.unknowns.deviation.row(1).transpose(), "N s/m");
  check("/innovation/value/yb", estimate.innovation.row(1).transpose(), "m");
  check("/innovation/deviation/yb", estimate.innovation_deviation.row(1).transpose(), "m");
  check("/innovation/nis", estimate.nis, "-");
  check("/measurements/yw", results.get<SimulationOutcome>().measurements.values.row(0).transpose(), "m/s^2");
  const VectorXd force = study.structure->signals[0]->sample(0.0, 0.01, 201).col(0).matrix();
  // the file holds doubles; the signal is evaluated at other blocks of times
  EXPECT_LT((file.read("/inputs/f") - force).norm(), 1e-13 * force.norm());
  EXPECT_EQ(file.text_attribute("/inputs/f", "unit"), "N");
  EXPECT_LT((file.read("/time") - VectorXd::LinSpaced(201, 0.0, 2.0)).norm(), 1e-14);
  check("/updating/parameters/s.m.stiffness_tried",
        VectorXd::NullaryExpr(Index(results.get<UpdatingOutcome>().trace.size()),
                              [&](Index k) { return results.get<UpdatingOutcome>().trace[std::size_t(k)].tried[1]; }),
        "N/m");
}

/// The estimated deviations are those of the errors: over all states that are not measured, in variances, and neither
/// under- nor overstated. 40 records of 2 s are independent; half of the points move nearly together.
TEST(EstimatedDeviations, AreThoseOfTheErrors) {
  double squares = 0.0, count = 0.0, parameter = 0.0;
  constexpr int seeds = 40;
  for (int seed = 1; seed <= seeds; ++seed) {
    const auto study = study_of(
        estimated_case({{"sensors", "{y: {acceleration: s.b, noise: 5 %}}"},
                        {"excitation", "{f: {force: s.b, random: {rms: 10, band: [0.5, 12], fade_in: 0.1}}}"},
                        {"simulate", "{duration: 2 s, sample_rate: 200 Hz, seed: " + std::to_string(seed) + "}"},
                        {"estimate", "{unknown: {c.k: {initial: 480, std: 40}}, settle: 0.5 s}"}}));
    const auto results = run(study, "estimate");
    for (const auto& point : results.get<EstimationOutcome>().points) {
      if (point.quantity != ObservedQuantity::displacement) continue;
      const VectorXd error = (point.mean - point.truth).cwiseQuotient(point.deviation);
      for (const Index k : {150, 250, 350}) squares += error[k] * error[k], count += 1.0;
    }
    const auto& unknowns = results.get<EstimationOutcome>().result.unknowns;
    parameter += std::pow((unknowns.mean(0, 400) - 500.0) / unknowns.deviation(0, 400), 2) / seeds;
  }
  std::printf("squared errors: displacements %.2f, parameter %.2f variances\n", squares / count, parameter);
  // The first guess is half a deviation off, which counts little. Chi-squared over 40 seeds: 0.55 to 1.56 hold 99 %.
  EXPECT_GT(parameter, 0.55);
  EXPECT_LT(parameter, 1.56);
  EXPECT_GT(squares / count, 0.55);
  EXPECT_LT(squares / count, 1.56);
}

}  // namespace
}  // namespace kalfem::wiring
