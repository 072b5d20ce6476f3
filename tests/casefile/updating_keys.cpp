// SPDX-License-Identifier: Apache-2.0
#include <complex>

#include "casefile/updating_probes.hpp"
#include "kalfem/formats/universal/universal.hpp"
#include "kalfem/steps/prediction/outcome.hpp"
#include "kalfem/steps/simulation/outcome.hpp"
#include "kalfem/study/updated_decks.hpp"
#include "kalfem/updating/global_search.hpp"

/// Keys of the updating: residuals against their definition, the search against the library's with the same options.
namespace kalfem::wiring {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// --- parameters ------------------------------------------------------------------------------------------------------

const std::string frequencies = "compare: {f: {modes: s, frequencies: [1.3, 3.9]}}";

UpdatingParameter parameter_of(const std::string& text) {
  return with_update("parameters: {s.k.stiffness: {" + text + "}}, " + frequencies).updating->parameters.at(0);
}

void parameters() {
  near(parameter_of("").initial, 800.0);
  near(parameter_of("initial: 0.9 N/mm").initial, 900.0);
  EXPECT_TRUE(std::isinf(parameter_of("").deviation));
  near(parameter_of("initial: 900, std: 50 N/m").deviation, 50.0);
  near(parameter_of("initial: 900, std: 10 %").deviation, 90.0);
  const auto bounded = parameter_of("bounds: [0.7 N/mm, 1100]");
  near(bounded.lower, 700.0);
  near(bounded.upper, 1100.0);
  EXPECT_EQ(parameter_of("").lower, 0.0);
  EXPECT_TRUE(std::isinf(parameter_of("").upper));
}

void parameter_truths() {
  const auto truth = [](const std::string& text, const Sections& more = {}) {
    return with_update("parameters: {s.k.stiffness: {" + text + "}}, " + frequencies, more)
        .updating->true_parameters.at(0);
  };
  EXPECT_FALSE(truth(""));
  near(*truth("truth: 850"), 850.0);
  near(*truth("initial: 700", {{"simulate", "{duration: 1, sample_rate: 100}"}}), 800.0);
}

void shared_parameters() {
  const auto study =
      with_update("parameters: {all: {initial: 600, applies_to: [s.k.stiffness, s.m.stiffness]}}, " + frequencies);
  ASSERT_EQ(study.updating->parameters.size(), 1u);
  ASSERT_EQ(study.updating->bindings.size(), 2u);
  const auto model = study.updating_plan->structure->model_of("s")->at(VectorXd::Constant(1, 700.0)).model;
  near(model.stiffness.coeff(0, 0), 1400.0);
  near(model.stiffness.coeff(1, 1), 700.0);
}

void alternative_parameters() {
  const auto study = with_update(
      "parameters: {s.k.stiffness: {initial: 850, std: 10 %}}, alternatives: {both: {parameters: {all: {initial: 0.6 "
      "N/mm, std: 10 %, bounds: [0.4 N/mm, 900], truth: 750, applies_to: [s.k.stiffness, s.m.stiffness]}}}}, " +
      frequencies);
  const auto& alternatives = study.updating_plan->alternatives;
  ASSERT_EQ(alternatives.size(), 1u);
  const auto& [name, setup, plan] = *alternatives.front();
  EXPECT_EQ(name, "both");
  ASSERT_EQ(setup.parameters.size(), 1u);
  EXPECT_EQ(setup.bindings.size(), 2u);
  near(setup.parameters[0].initial, 600.0);
  near(setup.parameters[0].deviation, 60.0);
  near(setup.parameters[0].lower, 400.0);
  near(setup.parameters[0].upper, 900.0);
  near(*setup.true_parameters.at(0), 750.0);
}

// --- natural frequencies ---------------------------------------------------------------------------------------------

void natural_frequencies() {
  const VectorXd f = modes_at().frequencies, stiffer = modes_at(900.0).frequencies;
  const auto expected = [](const VectorXd& model, double deviation_1, double deviation_2) {
    return vector({(model[0] - 1.5) / deviation_1, (model[1] - 3.5) / deviation_2});
  };
  near(residual_of("modes: s, frequencies: [1.5, 3.5]"), expected(f, 0.015, 0.035), many_roundings);
  near(residual_of("modes: s, frequencies: [1.5, 3.5]", 900.0), expected(stiffer, 0.015, 0.035), many_roundings);
  near(residual_of("modes: s, frequencies: [1.5, 3.5], deviation: 2 %"), expected(f, 0.03, 0.07), many_roundings);
  near(residual_of("modes: s, frequencies: [1.5, 3.5], deviation: 0.1 Hz"), expected(f, 0.1, 0.1), many_roundings);
  near(residual_of("modes: s, frequencies: [3.5], model_modes: [2]"), vector({(f[1] - 3.5) / 0.035}), many_roundings);
  near(residual_of("modes: s, frequencies: [3.5], above: 2 Hz"), vector({(f[1] - 3.5) / 0.035}), many_roundings);
  write_file("frequencies.csv", "number,f\n1,1.5\n2,3.5\n3,9\n");
  near(residual_of("modes: s, frequencies: {file: frequencies.csv, column: f, first: 2}"), expected(f, 0.015, 0.035),
       many_roundings);
  EXPECT_THROW(residual_of("modes: s, frequencies: {file: frequencies.csv, column: f}"), InvalidInput);  // a third one
}

void mode_shapes() {
  const MatrixXd shapes = modes_at().shapes;
  MatrixXd measured = shapes * Eigen::Vector2d(-2.0, 0.5).asDiagonal();
  measured(1, 0) *= 1.1;
  std::ostringstream text;
  text.precision(17);
  text << measured(0, 0) << "," << measured(0, 1) << "\n" << measured(1, 0) << "," << measured(1, 1) << "\n";
  write_file("shapes.csv", text.str());
  const auto misfit = [&](const std::string& more) {
    return VectorXd(
        residual_of("modes: s, frequencies: [1.5, 3.5], shapes: {file: shapes.csv, points: [a, b]" + more + "}")
            .tail(4));
  };
  // The model's shape times the scale factor that fits the measured one best, against it.
  const VectorXd m = measured.col(0), p = shapes.col(0), difference = p * (p.dot(m) / p.squaredNorm()) - m;
  const double largest = m.cwiseAbs().maxCoeff();
  near(VectorXd(misfit("").head(2)), difference / (0.05 * largest), many_roundings);
  near(VectorXd(misfit(", deviation: 0.2").head(2)), difference / (0.2 * largest), many_roundings);
  EXPECT_LT(misfit("").tail(2).norm(), 1e-9);  // the second shape is exact
  EXPECT_GT(VectorXd(residual_of(
                         "modes: s, frequencies: [1.5, 3.5], shapes: {file: shapes.csv, points: [b, a]}, minimum_mac: "
                         "0.01")
                         .tail(2))
                .norm(),
            1.0);
  // Shapes with a modal assurance criterion of 0.8 are of one mode unless the case asks for more.
  const double mac = std::pow(p.dot(m), 2) / (p.squaredNorm() * m.squaredNorm());
  const auto pairs_with = [&](double least) {
    return residual_of("modes: s, frequencies: [1.5, 3.5], shapes: {file: shapes.csv, points: [a, b]}, minimum_mac: " +
                       std::to_string(least))
        .size();
  };
  EXPECT_EQ(pairs_with(mac - 0.001), 6);
  EXPECT_THROW(pairs_with(mac + 0.5 * (1.0 - mac)), InvalidInput);
}

void expansion_methods() {
  write_file("shapes.csv", "1,1\n0.5,-1\n");
  for (const std::string word : {"model", "serep", "dynamic"}) {
    const auto study = with_update(
        "parameters: {s.k.stiffness: {}}, compare: {c: {modes: s, frequencies: [1.5, 3.5], shapes: {file: shapes.csv, "
        "points: [a, b]}, expansion: " +
        word + "}}");
    const auto& data = study.description->update->comparisons.front().second.value.data;
    EXPECT_EQ(word_of(std::get<description::ModalData>(data).expansion), word);
  }
}

/// Deviations and dampings entry by entry.
void listed_modes() {
  const VectorXd f = modes_at().frequencies;
  write_file("modes.csv", "f,std [Hz],d [%],d_std\n1.5,0.2,3,0.002\n3.5,0.4,4,0.004\n");
  const std::string table = "{file: modes.csv, column: ";
  const VectorXd values = residual_of("modes: s, frequencies: " + table + "f}, deviation: " + table +
                                      "std}, dampings: " + table + "d}, damping_deviation: " + table + "d_std}");
  near(values, vector({(f[0] - 1.5) / 0.2, (f[1] - 3.5) / 0.4, -0.01 / 0.002, -0.02 / 0.004}), many_roundings);
  const std::string some = "modes: s, frequencies: [1.5, 3.5], dampings: [0.03, 0.04]";
  near(VectorXd(residual_of(some).tail(2)), vector({-0.01 / 0.003, -0.02 / 0.004}), many_roundings);
  near(VectorXd(residual_of(some + ", damping_deviation: 20 %").tail(2)), vector({-0.01 / 0.006, -0.02 / 0.008}),
       many_roundings);
  EXPECT_THROW(residual_of("modes: s, frequencies: [1.5, 3.5], dampings: [0.03]"), InvalidInput);
  EXPECT_THROW(residual_of("modes: s, frequencies: " + table + "f, first: 1}, deviation: " + table + "std}"),
               InvalidInput);
  // An empty cell is left out; a column of them is a frequency alone.
  const VectorXd shape = modes_at().shapes.col(0);
  write_file("shapes.csv", "m1,m2\n0.5,\n0.7,nan\n");
  write_file("deviations.csv", "m1,m2\n0.1,\n0.2,\n");
  const std::string shapes = "modes: s, frequencies: [1.5, 3.5], shapes: {file: shapes.csv, points: [a, b]";
  EXPECT_EQ(residual_of(shapes + "}").size(), 4);
  const VectorXd w = vector({100, 25}), p = vector({0.5, 0.7});
  const double c = shape.cwiseProduct(w).dot(p) / shape.cwiseProduct(w).dot(shape);
  near(VectorXd(residual_of(shapes + ", deviations: deviations.csv}").tail(2)),
       VectorXd((c * shape - p).cwiseQuotient(vector({0.1, 0.2}))), many_roundings);
}

/// A universal file: exact shapes, the second looks against its axis and is complex.
void files_of_modes() {
  const auto modes = modes_at();
  MeasuredFile file;
  for (Index i = 0; i < 2; ++i) {
    MeasuredShape shape{.name = "mode", .frequency = i == 0 ? 1.5 : 3.5, .damping = 0.03, .nodes = {7, 9}};
    shape.values = MatrixXcd::Zero(2, 3);
    shape.values(0, 2) = modes.shapes(0, i);
    shape.values(1, 0) = -modes.shapes(1, i) * (i == 0 ? Complex(1.0) : Complex(1.0, 0.2));
    file.shapes.push_back(shape);
  }
  write_universal(write_file("modes.unv", ""), file);
  const std::string given = "modes: s, file: modes.unv, points: {a: 7:+Z, b: 9:-X}";
  const auto expected = [&](double deviation) {
    return vector({(modes.frequencies[0] - 1.5) / (1.5 * deviation), (modes.frequencies[1] - 3.5) / (3.5 * deviation)});
  };
  constexpr double digits = 3e-5;  // six of a frequency in the file, of which 15 % are left as the difference
  const VectorXd values = residual_of(given);
  ASSERT_EQ(values.size(), 6);
  near(VectorXd(values.head(2)), expected(0.01), digits);
  EXPECT_LT(values.segment(2, 2).norm(), 1e-3);
  near(VectorXd(residual_of(given + ", deviation: 2 %").head(2)), expected(0.02), digits);
  near(residual_of(given + ", only: [2]")[0], expected(0.01)[1], digits);
  EXPECT_THROW(residual_of(given + ", only: [3]"), InvalidInput);
  near(VectorXd(residual_of(given + ", shape_deviation: 0.1").tail(2)), VectorXd(0.5 * values.tail(2)), 1e-9);
  near(VectorXd(residual_of(given + ", compare_dampings: true").tail(2)), vector({-0.01 / 0.003, -0.01 / 0.003}), 1e-5);
  EXPECT_THROW(residual_of(given + ", max_complexity: 0.01"), InvalidInput);
  EXPECT_THROW(residual_of("modes: s, file: modes.unv"), InvalidInput);  // no namesakes of the points
  EXPECT_THROW(residual_of("modes: s, file: modes.unv, points: {a: 7:+X}"), InvalidInput);
}

// --- deflections -----------------------------------------------------------------------------------------------------

void deflections() {
  // 8 N at b: 10 mm at a, 26 mm at b.
  const auto values = [](const std::string& more) {
    return residual_of("static: s, loads: {b: 8 N}, displacements: {a: 9 mm, b: 28 mm}" + more);
  };
  near(values(""), vector({1e-3 / 0.28e-3, -2e-3 / 0.28e-3}), many_roundings);
  near(values(", deviation: 0.1"), vector({1e-3 / 2.8e-3, -2e-3 / 2.8e-3}), many_roundings);
  near(residual_of("static: s, loads: {a: 8 N, b: -4 N}, displacements: {b: 1 mm}"), vector({(-3e-3 - 1e-3) / 1e-5}),
       many_roundings);
  near(residual_of("static: s, loads: {a: 8 N, b: -4 N}, displacements: {a: 1 mm}"), vector({4e-3 / 1e-5}),
       many_roundings);
}

// --- records ---------------------------------------------------------------------------------------------------------

const Sections of_record{
    {"substructures",
     "{w: {masses: {w: 1.5}, springs: [{from: ground, to: w, stiffness: 2e3}]}, s: {masses: {a: 2, b: 3}, "
     "springs: [{name: k, from: a, to: b, stiffness: 800}], damping: {modal: 2 %}}}"},
    {"connectors", "{c: {from: w.w, to: s.a, law: linear, parameters: {k: 500, c: 3}}}"},
    {"excitation", "{f: {base_displacement: w.ground, random: {rms: 10 mm, band: [0.5, 10], fade_in: 0.2}}}"},
    {"sensors",
     "{yw: {acceleration: w.w, noise: 2 %}, yb: {acceleration: s.b, noise: 2 %}, ya: {acceleration: s.a, noise: 2 "
     "%}}"},
    {"simulate", "{duration: 3 s, sample_rate: 100 Hz}"},
    {"estimate", "{unknown: {c.k: {initial: 450, std: 50}}, settle: 0.5 s}"}};

void driven_histories() {
  const auto comparison = [](const std::string& text) {
    const auto study = with_comparison("time_history: s" + text, of_record);
    const auto results = run(study, "simulate");
    const auto residuals = residuals_of(study, results);
    return residuals.at(0).continuation_steps[0]->evaluate(VectorXd::Constant(1, 750.0), true).value();
  };
  const auto all = comparison(""), one = comparison(", sensors: yb"), other = comparison(", sensors: [ya]");
  EXPECT_EQ(all.values.size(), 2 * 251);
  EXPECT_EQ(one.values.size(), 251);
  near(VectorXd(all.values.head(251)), one.values, many_roundings);
  near(VectorXd(all.values.tail(251)), other.values, many_roundings);
  const auto passes = comparison(", derivatives: filter_passes"), held = comparison(", derivatives: held_gains");
  near(passes.values, held.values, many_roundings);
  // the same run
  EXPECT_LT(relative_difference(all.jacobian, passes.jacobian), 1e-14);
  EXPECT_LT(relative_difference(comparison(", derivatives: auto").jacobian, passes.jacobian), 1e-14);
  EXPECT_GT(relative_difference(held.jacobian, passes.jacobian), 1e-6);
}

/// The loop's filter is the case's own: its sigma points, its passes over the record and what it leaves out at first.
void driven_histories_have_the_filter_of_the_case() {
  const auto residual = [](const std::string& more) {
    auto sections = of_record;
    sections["connectors"] = "{c: {from: w.w, to: s.a, law: cubic, parameters: {k: 500, k3: 2e5, c: 3}}}";
    sections["estimate"] =
        "{filter: ukf, unknown: {c.k3: {initial: 1.5e5, std: 5e4}}, estimate_initial_state: true, "
        "initial_state: {all: {displacement_std: 5 mm, velocity_std: 0.05}}" +
        more + "}";
    const auto study = with_comparison("time_history: s, sensors: yb", sections);
    return residual_at(study, 750.0, run(study, "simulate"));
  };
  const VectorXd usual = residual(", settle: 0.5 s");
  EXPECT_EQ(usual.size(), 251);
  EXPECT_EQ(residual(", settle: 1 s").size(), 201);
  EXPECT_GT(relative_difference(usual, residual(", settle: 0.5 s, passes: 2")), 1e-4);
  EXPECT_GT(relative_difference(usual, residual(", settle: 0.5 s, alpha: 0.3")), 1e-6);
  EXPECT_EQ(residual(", settle: 0.5 s, passes: 1, alpha: 1"), usual);
}

void simulated_histories() {
  const auto study = [](const std::string& text) { return with_comparison("simulation: " + text, of_record); };
  const auto results = run(study("all"), "simulate");
  EXPECT_EQ(residual_at(study("all"), 800.0, results).size(), 3 * 251);
  EXPECT_EQ(residual_at(study("[ya, yw]"), 800.0, results).size(), 2 * 251);
  // At the true parameters what is left is the noise, in its deviations: 502 samples tell its rms to 3 %.
  // one seed: found .06, two standard errors
  EXPECT_NEAR(rms(residual_at(study("[ya, yw]"), 800.0, results)), 1.0, 0.1);
  EXPECT_GT(rms(residual_at(study("yb"), 700.0, results)), 2.0);
  const auto& simulation = results.get<SimulationOutcome>();
  const VectorXd noise = (simulation.reference.sensors - simulation.measurements.values).row(1).tail(251).transpose() /
                         simulation.measurements.channels[1].noise;
  near(residual_at(study("yb"), 800.0, results), noise, 0.1);  // a coarser step than the reference's
}

// --- the search ------------------------------------------------------------------------------------------------------

void weights() {
  const auto run_with = [](const std::string& first, const std::string& second) {
    return run(with_update("parameters: {s.k.stiffness: {}}, compare: {one: {modes: s, frequencies: [1.5]" + first +
                           "}, two: {static: s, loads: {b: 8 N}, displacements: {b: 20 mm}" + second + "}}"),
               "update")
        .get<UpdatingOutcome>();
  };
  const auto plain = run_with("", ""), weighted = run_with(", weight: 4", ", weight: 0.25");
  const double one = plain.comparisons[0].rms_initial, two = plain.comparisons[1].rms_initial;
  near(plain.residual_initial, std::sqrt((one * one + two * two) / 2), many_roundings);
  near(weighted.residual_initial, std::sqrt((4 * one * one + 0.25 * two * two) / 2), many_roundings);
  near(weighted.comparisons[0].rms_initial, one, many_roundings);  // of the comparison itself, without its weight
  near(weighted.comparisons[1].rms_initial, two, many_roundings);
  // The minimum moves towards what counts more.
  EXPECT_LT(weighted.comparisons[0].rms_final, 0.5 * plain.comparisons[0].rms_final);  // found .23
  EXPECT_GT(weighted.comparisons[1].rms_final, plain.comparisons[1].rms_final);
}

const std::string both =
    "parameters: {s.k.stiffness: {initial: 500, bounds: [200, 2000]}, s.m.stiffness: {initial: 900, bounds: "
    "[200, 2000]}}, compare: {f: {modes: s, frequencies: [1.55, 4.2]}}";

UpdatingOutcome search(const std::string& text) {
  return run(with_update(both + text), "update").get<UpdatingOutcome>();
}

ResidualSum sum_of(const Study& study) { return ResidualSum({{residuals_of(study)[0].continuation_steps[0], 1.0}}); }

GaussNewtonOptions usual_search() {
  GaussNewtonOptions options;
  options.max_evaluations = 100;
  options.step_tolerance = 1e-5;
  options.cost_floor = 1e-6;
  return options;
}

void numbers_of_stages() {
  const auto one = search(", stages: 1"), three = search(", stages: 3"), usual = search("");
  EXPECT_EQ(one.evaluations, 1);
  EXPECT_FALSE(one.converged);
  EXPECT_EQ(three.evaluations, 3);
  EXPECT_TRUE(usual.converged) << usual.termination;
  EXPECT_GT(usual.evaluations, 3);
  const auto study = with_update(both);
  const auto outcome =
      minimise(sum_of(study), study.updating->parameters, {.search = usual_search(), .start = {}, .watch = {}});
  EXPECT_EQ(usual.evaluations, outcome.evaluations);
  near(usual.values, outcome.parameters, many_roundings);
}

void tolerances() {
  const auto evaluations = [](const std::string& tolerance) {
    const std::string text = "parameters: {s.k.stiffness: {initial: 850}}, " + frequencies + ", tolerance: ";
    return run(with_update(text + tolerance), "update").get<UpdatingOutcome>().evaluations;
  };
  EXPECT_LT(evaluations("0.1"), evaluations("1e-8"));
  EXPECT_EQ(search("").evaluations, search(", tolerance: 1e-5").evaluations);
}

void many_starts() {
  for (const std::uint64_t seed : {1, 11}) {
    const auto found = search(", starts: 5, seed: " + std::to_string(seed));
    const auto study = with_update(both);
    MultiStartOptions options{.starts = 5, .seed = seed, .search = {}};
    options.search.search = usual_search();
    const auto expected = minimise_from_many(sum_of(study), study.updating->parameters, options);
    EXPECT_EQ(found.evaluations, expected.evaluations);
    near(found.values, expected.best.parameters, many_roundings);
    EXPECT_NE(found.method.find("from 5 starts"), std::string::npos) << found.method;
  }
  EXPECT_EQ(search(", starts: 5").evaluations, search(", starts: 5, seed: 1").evaluations);
}

void evolutions() {
  const auto study = with_update(both);
  for (const auto& [text, generations, population, seed] :
       std::vector<std::tuple<std::string, unsigned, unsigned, unsigned>>{
           {"{generations: 4, population: 9, seed: 5}", 4, 9, 5}, {"{generations: 3}", 3, 8, 1}}) {
    const auto found = search(", method: cma_es, evolution: " + text);
    EvolutionOptions options;
    options.search.generations = generations;
    options.search.population = population;
    options.search.seed = seed;
    options.polishing->search = usual_search();
    const auto expected = evolve(sum_of(study), study.updating->parameters, options);
    EXPECT_NE(found.method.find("CMA-ES"), std::string::npos);
    EXPECT_EQ(found.evaluations, expected.evaluations + expected.polished->evaluations);
    EXPECT_EQ(found.iterations, int(generations));
    near(found.values, expected.parameters, many_roundings);
  }
  EXPECT_EQ(search(", method: least_squares").method, search("").method);
  EXPECT_EQ(search("").method.find("CMA-ES"), std::string::npos);
}

void sensitivity_checks() {
  EXPECT_EQ(search(", check_sensitivities: true").sensitivities.size(), 2u);
  EXPECT_TRUE(search("").sensitivities.empty());
}

void what_is_known_of_fixed_numbers() {
  EXPECT_FALSE(search("").considered);
  const std::string text = "parameters: {s.k.stiffness: {initial: 850}}, " + frequencies + ", known_to: {masses: 1 %}";
  const auto found = run(with_update(text), "update").get<UpdatingOutcome>();
  ASSERT_TRUE(found.considered);
  EXPECT_GT(found.considered->deviations.minCoeff(), 0.0);
  EXPECT_GT(found.statistics.considered.minCoeff(), 0.0);
}

// --- modifications ---------------------------------------------------------------------------------------------------

void modifications() {
  const VectorXd changed = modes_at(1600.0).frequencies;
  const auto frequencies_of = [](const std::string& text) {
    return run(with_update("", {{"update", ""}, {"modifications", "{m: {substructure: s, " + text + "}}"}}), "predict")
        .get<ModificationsOutcome>()
        .modifications.at(0);
  };
  EXPECT_EQ(frequencies_of("set: {k.stiffness: 1600}").substructure, "s");
  near(frequencies_of("set: {k.stiffness: 1.6 N/mm}").frequencies, changed, many_roundings);
  near(frequencies_of("set: {k.stiffness: 1600}, modes: 1").frequencies, vector({changed[0]}), many_roundings);
  near(frequencies_of("set: {k.stiffness: 1600}, above: 2 Hz").frequencies, vector({changed[1]}), many_roundings);
}

/// The folder of updated decks, beside the case; without it, in that of the results.
void folders_of_decks() {
  const auto folder_of = [](const std::string& text) {
    const auto study = with_update(text + "parameters: {s.k.stiffness: {}}, " + frequencies);
    return updated_decks(study, Eigen::VectorXd::Ones(1)).folder;
  };
  EXPECT_EQ(folder_of(""), "updated_decks");
  EXPECT_EQ(folder_of("write_deck: decks, ").filename(), "decks");
  EXPECT_TRUE(folder_of("write_deck: decks, ").is_absolute());
}

}  // namespace

KeyChecks updating_keys() {
  KeyChecks keys;
  const auto add = [&](const std::string& prefix, const std::vector<std::string>& names, void (*check)()) {
    for (const auto& name : names) keys[prefix + name] = check;
  };
  add(at + "parameters.*.", {"initial", "std", "bounds"}, parameters);
  add(at + "parameters.*.", {"truth"}, parameter_truths);
  add(at + "parameters.*.", {"applies_to"}, shared_parameters);
  add(at + "alternatives.*.parameters.*.", {"initial", "std", "bounds", "truth", "applies_to"}, alternative_parameters);
  add(compare_at, {"modes", "frequencies.file", "frequencies.column", "frequencies.first", "model_modes", "above"},
      natural_frequencies);
  add(compare_at,
      {"dampings.file", "dampings.column", "dampings.first", "deviation.file", "deviation.first",
       "damping_deviation.file", "damping_deviation.column", "damping_deviation.first", "shapes.deviations"},
      listed_modes);
  add(compare_at, {"file", "points", "only", "shape_deviation", "compare_dampings", "max_complexity"}, files_of_modes);
  add(compare_at, {"shapes.file", "shapes.points", "shapes.deviation", "minimum_mac"}, mode_shapes);
  add(compare_at, {"expansion"}, expansion_methods);
  add(compare_at, {"deviation.column"}, [] {
    listed_modes();
    natural_frequencies();
    frequency_responses_of_tables();
    deflections();
  });
  add(compare_at, {"static", "loads", "displacements"}, deflections);
  add(compare_at, {"sensors", "derivatives"}, driven_histories);
  add(compare_at, {"time_history"}, driven_histories_have_the_filter_of_the_case);
  add(compare_at, {"simulation"}, simulated_histories);
  add(compare_at, {"weight"}, weights);
  add(at, {"stages"}, numbers_of_stages);
  add(at, {"tolerance"}, tolerances);
  add(at, {"starts", "seed"}, many_starts);
  add(at, {"method", "evolution.generations", "evolution.population", "evolution.seed"}, evolutions);
  add(at, {"check_sensitivities"}, sensitivity_checks);
  add(at, {"write_deck"}, folders_of_decks);
  add(at, {"known_to"}, what_is_known_of_fixed_numbers);
  add("modifications.*.", {"substructure", "set", "modes", "above"}, modifications);
  return keys;
}

}  // namespace kalfem::wiring
