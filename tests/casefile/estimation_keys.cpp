// SPDX-License-Identifier: Apache-2.0
#include "casefile/probes.hpp"
#include "kalfem/base/parallel.hpp"
#include "kalfem/estimation/estimate.hpp"
#include "kalfem/identification/filter_run.hpp"
#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/steps/prediction/outcome.hpp"
#include "kalfem/steps/run_study.hpp"
#include "kalfem/steps/simulation/outcome.hpp"

/// Keys of the estimation: what the augmented model and its filter are made of.
namespace kalfem::wiring {
namespace {

const std::string at = "estimate.", stiffness_unknown = "unknown: {c.k: {initial: 400 N/m, std: 100 N/m}}";

Study with_estimate(const std::string& text, const Sections& more = {}) {
  Sections sections{{"estimate", "{" + text + "}"}};
  for (const auto& [key, value] : more) sections[key] = value;
  return study_of(estimated_case(sections));
}

const AugmentedModelOptions& options_of(const Study& study) { return study.augmented_model->options; }

UnknownParameter unknown_of(const std::string& text) {
  return options_of(with_estimate("unknown: {c.k: {" + text + "}}")).unknowns.at(0);
}

void first_guesses_and_deviations() {
  const auto study = with_estimate("unknown: {c.k: {initial: 0.4 N/mm, std: 90 N/m}, c.c: {initial: 2, std: 25 %}}");
  const auto& unknowns = options_of(study).unknowns;
  near(unknowns[0].initial, 400.0);
  near(unknowns[0].deviation, 90.0);
  EXPECT_EQ(unknowns[0].random_walk, 0.0);
  near(unknowns[1].deviation, 0.5);
  near(unknown_of("initial: 400").deviation, 200.0);
  // The augmented model's model holds the first guesses, the structure the true values.
  near(study.augmented_model->model->system().connectors[0].parameters, vector({400.0, 2.0}));
  near(system_of(study).connectors[0].parameters, vector({500.0, 3.0}));
  EXPECT_EQ(unknowns[1].targets[0].connector, 0);
  EXPECT_EQ(unknowns[1].targets[0].parameter, 1);
}

void transforms() {
  EXPECT_EQ(unknown_of("initial: 400").transform.kind, TransformKind::none);
  EXPECT_EQ(unknown_of("initial: 400, transform: none").transform.kind, TransformKind::none);
  EXPECT_EQ(unknown_of("initial: 400, transform: log").transform.kind, TransformKind::log);
  const auto bounded = unknown_of("initial: 400, bounds: [0.1 N/mm, 900]").transform;
  EXPECT_EQ(bounded.kind, TransformKind::logit);
  near(bounded.lower, 100.0);
  near(bounded.upper, 900.0);
  EXPECT_EQ(unknown_of("initial: 400, transform: logit, bounds: [0, 900]").transform.kind, TransformKind::logit);
  EXPECT_EQ(unknown_of("initial: 400, transform: log, bounds: [0, 900]").transform.kind, TransformKind::log);
}

void drifts() {
  near(unknown_of("initial: 400, random_walk: 7 N/m").random_walk, 7.0);
  near(unknown_of("initial: 400, random_walk: 7 N/m/sqrt(s)").random_walk, 7.0);
  near(unknown_of("initial: 400, random_walk: 60 N/m/sqrt(min)").random_walk, 60.0 / std::sqrt(60.0));
  near(unknown_of("initial: 400, random_walk: 5 %").random_walk, 20.0);
}

void truths() {
  const auto truth = [](const std::string& more, const Sections& sections = {}) {
    return with_estimate("unknown: {c.k: {initial: 400" + more + "}}", sections).augmented_model->true_parameters.at(0);
  };
  near(truth("").value(), 500.0);
  near(truth(", truth: 0.45 N/mm").value(), 450.0);
  write_file("record.csv", csv_of(100.0, {{"y", {1, -1, 2, -2, 1, -1, 2, -2, 1, -1, 2, -2, 1, -1, 2, -2}}}));
  const Sections measured{{"simulate", ""}, {"record", "{file: record.csv}"}};
  EXPECT_FALSE(truth("", measured));
  near(truth(", truth: 450", measured).value(), 450.0);
}

void shared_values() {
  const auto study = with_estimate("unknown: {both: {initial: 400, applies_to: [c.k, d.k]}}",
                                   {{"connectors",
                                     "{c: {from: s.a, to: s.b, law: linear, parameters: {k: 500, c: 3}}, d: "
                                     "{from: s.ground, to: s.b, law: linear, parameters: {k: 50, c: 1}}}"}});
  ASSERT_EQ(options_of(study).unknowns.size(), 1u);
  ASSERT_EQ(options_of(study).unknowns[0].targets.size(), 2u);
  for (const auto& connector : study.augmented_model->model->system().connectors) near(connector.parameters[0], 400.0);
}

/// Force of a connector without internal states at a deformation, a rate and an acceleration of 1.
double force_of(const Connector& connector, const Eigen::VectorXd& parameters) {
  const Eigen::ArrayXXd p = parameters.transpose().array(), none(1, 0);
  const Eigen::ArrayXd one = Eigen::ArrayXd::Ones(1);
  Eigen::ArrayXd force(1), stiffness(1), damping(1), inertance(1);
  Eigen::ArrayXXd end(1, 0);
  connector.law->respond({0.0, p, one, one, none, one, one, one}, {force, stiffness, damping, inertance, end});
  return force[0];
}

/// A spring, dashpot and mass of the linear part: this holds the first guesses, and connectors what differs from them.
void linear_elements_are_released() {
  const auto study =
      with_estimate("unknown: {s.k.stiffness: {initial: 700}, s.k.damping: {initial: 5}, s.b.mass: {initial: 2.5}}");
  const auto& system = study.augmented_model->model->system();
  near(system.stiffness.coeff(0, 0), 700.0);
  near(system.damping.coeff(0, 0), 5.0);
  near(system.mass.coeff(1, 1), 2.5);
  near(*study.augmented_model->true_parameters[0], 800.0);
  near(*study.augmented_model->true_parameters[1], 4.0);
  near(*study.augmented_model->true_parameters[2], 3.0);
  ASSERT_EQ(system.connectors.size(), 3u);  // the case's own, one of the spring with its dashpot, one of the mass
  for (std::size_t j : {1, 2}) EXPECT_EQ(force_of(system.connectors[j], system.connectors[j].parameters), 0.0) << j;
  for (Eigen::Index i = 0; i < 3; ++i) {
    const auto target = options_of(study).unknowns[std::size_t(i)].targets.at(0);
    const auto& connector = system.connectors[std::size_t(target.connector)];
    Eigen::VectorXd moved = connector.parameters;
    moved[target.parameter] += 0.25;
    near(force_of(connector, moved), 0.25);
    EXPECT_EQ(std::abs(connector.deformation[i < 2 ? 0 : 1]), 1.0);
  }
}

void initial_states() {
  const auto prior = [](const std::string& text) {
    return options_of(with_estimate(stiffness_unknown + ", initial_state: {" + text + "}")).prior;
  };
  const auto one = prior("s.b: {displacement: 3 mm, velocity: 2 m/s, displacement_std: 0.5 mm, velocity_std: 0.1}");
  near(one.mean.displacement, vector({0, 3e-3}));
  near(one.mean.velocity, vector({0, 2}));
  near(one.displacement_deviation, vector({0, 5e-4}));
  near(one.velocity_deviation, vector({0, 0.1}));
  const auto all = prior("all: {displacement_std: 1 mm}, s.a: {velocity_std: 0.2}");
  near(all.displacement_deviation, vector({0, 1e-3}));
  near(all.velocity_deviation, vector({0.2, 0}));
  EXPECT_EQ(all.mean.displacement.norm(), 0.0);
}

/// Displacement and velocity at the start of the case from the record's first samples.
void start_from_the_record() {
  std::vector<double> a(40), b(40);
  for (int k = 0; k < 40; ++k) a[std::size_t(k)] = 1e-3 + 0.02 * k / 100, b[std::size_t(k)] = -2e-3 - 0.05 * k / 100;
  write_file("record.csv", csv_of(100.0, {{"ya", a}, {"yb", b}}));
  const Sections measured{{"simulate", ""},
                          {"record", "{file: record.csv, start: 0.1 s}"},
                          {"sensors", "{yb: {displacement: s.b, noise: 1 mm}, ya: {displacement: s.a, noise: 1 mm}}"}};
  const auto start = [&](const std::string& text) {
    const auto study = with_estimate(stiffness_unknown + text, measured);
    const auto run = make_filter_run(study.problem, *study.augmented_model, record_of(study, {}));
    return run.choice.augmented_model->options().prior.mean;
  };
  const auto found = start(", initial_state_from_record: true");
  near(found.displacement, vector({3e-3, -7e-3}), many_roundings);
  near(found.velocity, vector({0.02, -0.05}), many_roundings);
  EXPECT_EQ(start("").displacement.norm(), 0.0);
  EXPECT_EQ(start(", initial_state_from_record: false").velocity.norm(), 0.0);
}

void initial_connector_states() {
  const auto study = with_estimate(
      "unknown: {c.k: {initial: 400}}, initial_connector_states: {c.z: {value: 2e-3, std: 1e-4}}",
      {{"connectors",
        "{e: {from: s.ground, to: s.b, law: jenkins, parameters: {k_stick: 10, f_slip: 1}}, c: {from: s.a, to: "
        "s.b, law: bouc_wen, parameters: {k: 500, alpha: 0.3, beta: 250, gamma: 250, n: 1}}}"}});
  ASSERT_EQ(study.augmented_model->model->system().connector_states(), 2);
  near(options_of(study).prior.mean.connector_states, vector({0, 2e-3}));
  near(options_of(study).prior.connector_state_deviation, vector({0, 1e-4}));
}

void process_noise() {
  const auto noise = [](const std::string& text) {
    return options_of(with_estimate(stiffness_unknown + ", process_noise: {" + text + "}")).process_noise.acceleration;
  };
  near(noise("acceleration: 0.3"), vector({0.3, 0.3}));
  near(noise("accelerations: {s.b: 0.7}"), vector({0.0, 0.7}));
  near(noise("acceleration: 0.3, accelerations: {s.a: 0.7}"), vector({0.7, 0.3}));
}

Sections local_case(const std::string& interface) {
  return {{"substructures",
           "{w: {masses: {w: 1.5}, springs: [{from: ground, to: w, stiffness: 2e3}]}, s: {masses: {a: 2, b: "
           "3}, springs: [{from: a, to: b, stiffness: 800}]}}"},
          {"connectors", "{c: {from: w.w, to: s.a, law: linear, parameters: {k: 500, c: 3}}}"},
          {"excitation", "{f: {force: s.b, sine: {amplitude: 10, frequency: 2}}}"},
          {"sensors",
           "{yw: {acceleration: w.w, noise: 0.01}, foot: {acceleration: s.a, noise: 0.02}, yb: {acceleration: "
           "s.b, noise: 0.03}}"},
          {"estimate", "{unknown: {c.k: {initial: 400}}, local: {substructures: w, interface: {" + interface + "}}}"}};
}

void local_models_move_as_measured() {
  const auto study = study_of(estimated_case(
      local_case("s.a: {acceleration: {sensor: foot, displacement_std: 2 mm, velocity_std: 0.05 m/s}}")));
  const auto& setup = *study.augmented_model;
  EXPECT_EQ(setup.model->system().dofs, (std::vector<std::string>{"w.w"}));
  EXPECT_EQ(setup.input_sources, (std::vector<std::string>{"@foot"}));
  EXPECT_EQ(setup.options.inputs.at(0).model, InputModel::integrated);
  near(setup.options.prior.input_deviation[0], 2e-3);
  near(setup.options.prior.input_rate_deviation[0], 0.05);
  ASSERT_EQ(setup.sensors.size(), 1u);  // not what drives it, nor what lies outside
  EXPECT_EQ(setup.sensors[0].name, "yw");
  near(setup.model->system().connectors[0].deformation, vector({-1.0}));
  // Its own record drives it, and its noise is that of a white signal held over the sample interval: s / sqrt(f).
  const auto results = run(study, "simulate");
  const auto filter = make_filter_run(study.problem, setup, record_of(study, results));
  near(filter.choice.augmented_model->options().process_noise.input, vector({0.02 / std::sqrt(100.0)}));
  const auto foot = results.get<SimulationOutcome>().measurements.values.row(1);
  near(filter.input.inputs(2, 4), foot[1]);  // four parts a sample
  near(filter.input.inputs(2, 6), 0.5 * (foot[1] + foot[2]));
  EXPECT_EQ(filter.input.inputs.topRows(2).norm(), 0.0);
}

void local_models_are_pushed_by_unknown_forces() {
  const auto setup = [](const std::string& text) {
    auto sections = local_case("w.w: {force: {" + text + "}}");
    sections["estimate"] =
        "{unknown: {w.ground-w.stiffness: {initial: 1900}}, local: {substructures: [w], interface: "
        "{w.w: {force: {" +
        text + "}}}}}";
    return *study_of(estimated_case(sections)).augmented_model;
  };
  const auto given = setup("std: 5 N, correlation_time: 0.2 s");
  EXPECT_EQ(given.options.inputs.at(0).model, InputModel::latent);
  near(given.options.inputs[0].process.correlation_time, 0.2);
  near(given.options.prior.input_deviation[0], 5.0);
  near(given.options.process_noise.input[0], 5.0 * std::sqrt(2.0 / 0.2));  // stationary: q^2 tau / 2 = std^2
  near(setup("std: 5 N").options.inputs[0].process.correlation_time, 0.1);
  near(given.model->system().inputs[0].value, vector({1.0}));
}

// --- the filter ------------------------------------------------------------------------------------------------------

/// Strongly nonlinear, so that the spread of the sigma points is seen.
const Sections nonlinear{{"connectors", "{c: {from: s.a, to: s.b, law: cubic, parameters: {k: 500, k3: 3e5, c: 3}}}"},
                         {"sensors", "{y: {displacement: s.b, noise: 1 mm}, x: {displacement: s.a, noise: 1 mm}}"}};
const std::string prior =
    "unknown: {c.k3: {initial: 2e5, std: 1e5}}, initial_state: {all: {displacement_std: 10 mm, "
    "velocity_std: 0.1}}, process_noise: {acceleration: 0.1}";

/// The study's own estimation, and what the library's filter finds with these options on the same record.
std::pair<EstimationResult, EstimationResult> both_filters(const std::string& text, const EstimationOptions& options) {
  const auto study = with_estimate(prior + text, nonlinear);
  const auto results = run(study, "estimate");
  const auto& outcome = results.get<EstimationOutcome>();
  EXPECT_EQ(outcome.filter, options.filter) << text;
  const auto filter = make_filter_run(study.problem, *study.augmented_model, record_of(study, results));
  return {outcome.result, estimate(*filter.choice.augmented_model, filter.input, options)};
}

void filter_kinds() {
  const std::vector<std::pair<std::string, FilterKind>> kinds{
      {"auto", FilterKind::partially_linear},
      {"partially_linear_ukf", FilterKind::partially_linear},
      {"partially_linear_ukf_square_root", FilterKind::partially_linear_square_root},
      {"ukf", FilterKind::unscented},
      {"ukf_square_root", FilterKind::unscented_square_root},
      {"ekf", FilterKind::extended}};
  for (const auto& [word, kind] : kinds) {
    const auto [found, expected] = both_filters(", filter: " + word, {.filter = kind});
    near(found.log_likelihood, expected.log_likelihood, many_roundings);
    near(found.unknowns.mean(0, 50), expected.unknowns.mean(0, 50), many_roundings);
  }
}

void spreads_of_sigma_points() {
  const auto found = [](const std::string& text, const UnscentedOptions& options) {
    const auto [own, expected] =
        both_filters(", filter: ukf" + text, {.filter = FilterKind::unscented, .unscented = options});
    near(own.log_likelihood, expected.log_likelihood, many_roundings);
    return own.log_likelihood;
  };
  const double usual = found("", {});
  EXPECT_GT(std::abs(found(", alpha: 0.3", {.alpha = 0.3}) - usual), 2e-5);
  EXPECT_GT(std::abs(found(", beta: 0", {.beta = 0.0}) - usual), 2e-5);
  EXPECT_GT(std::abs(found(", kappa: 2", {.kappa = 2.0}) - usual), 2e-5);
}

void passes_of_an_update() {
  const auto passes = [](const std::string& text) {
    return with_estimate(prior + text, nonlinear).problem->settings.unscented.update_iterations;
  };
  EXPECT_EQ(passes(""), 1);
  EXPECT_EQ(passes(", update_iterations: 3"), 3);
}

void noise_that_adapts() {
  const auto settings = [](const std::string& text) {
    return with_estimate(stiffness_unknown + text).problem->settings.adaptive_noise;
  };
  EXPECT_FALSE(settings("").any());
  const auto given = settings(", adaptive_noise: {sensors: true, memory: 0.5 s}");
  EXPECT_TRUE(given.sensors);
  EXPECT_FALSE(given.process);
  near(given.memory, 0.5);
  EXPECT_TRUE(settings(", adaptive_noise: {process: true}").process);
  near(settings(", adaptive_noise: {process: true}").memory, 2.0);
  const auto [own, expected] = both_filters(
      ", filter: ukf, adaptive_noise: {sensors: true, process: true, memory: 0.5 s}",
      {.filter = FilterKind::unscented, .adaptive_noise = {.sensors = true, .process = true, .memory = 0.5}});
  near(own.log_likelihood, expected.log_likelihood, many_roundings);
  near(own.noise->sensors.rightCols(1), expected.noise->sensors.rightCols(1), many_roundings);
}

void passes_over_the_record() {
  const auto study = with_estimate(prior + ", estimate_initial_state: true, passes: 2", nonlinear);
  EXPECT_TRUE(options_of(study).keep_initial_state);
  const auto results = run(study, "estimate");
  const auto& outcome = results.get<EstimationOutcome>();
  const auto filter = make_filter_run(study.problem, *study.augmented_model, record_of(study, results));
  const auto expected = [&](int passes) {
    return estimate(*filter.choice.augmented_model, filter.input, {.filter = outcome.filter, .passes = passes})
        .log_likelihood;
  };
  near(outcome.result.log_likelihood, expected(2), many_roundings);
  EXPECT_GT(std::abs(expected(2) - expected(1)), 1e-3);
  EXPECT_TRUE(outcome.open_loop.has_value());
  EXPECT_FALSE(options_of(with_estimate(prior, nonlinear)).keep_initial_state);
}

void estimates_from_the_whole_record() {
  const auto results = run(with_estimate(prior + ", smooth: true", nonlinear), "estimate");
  const auto& outcome = results.get<EstimationOutcome>();
  ASSERT_TRUE(outcome.smoothed.has_value());
  EXPECT_EQ(outcome.smoothed_points.size(), outcome.points.size());
  const Eigen::Index last = outcome.result.state.mean.cols() - 1;
  const Eigen::VectorXd end = outcome.result.state.mean.col(last);
  EXPECT_LT((outcome.smoothed->state.mean.col(last) - end).norm(), 1e-9 * end.norm());
  EXPECT_GT((outcome.smoothed->state.mean.col(last / 2) - outcome.result.state.mean.col(last / 2)).norm(), 0.0);
  EXPECT_FALSE(run(with_estimate(prior, nonlinear), "estimate").get<EstimationOutcome>().smoothed.has_value());
}

void sums_begin_after_settling() {
  for (const auto& [text, first] :
       std::vector<std::pair<std::string, Eigen::Index>>{{", settle: 0.2 s", 20}, {", settle: 0", 0}}) {
    const auto results = run(with_estimate(stiffness_unknown + text), "estimate");
    const auto& outcome = results.get<EstimationOutcome>();
    EXPECT_EQ(outcome.settled, first);
    const Eigen::Index count = outcome.result.nis.size() - first;
    near(outcome.consistency.mean_nis, outcome.result.nis.tail(count).mean());
    for (const auto& point : outcome.points)
      if (point.quantity == ObservedQuantity::displacement)
        near(point.nrmse.value(), nrmse(point.mean.tail(count), point.truth.tail(count)));
  }
  EXPECT_EQ(run(with_estimate(stiffness_unknown + ", settle: 9 s"), "estimate").get<EstimationOutcome>().settled, 50);
  EXPECT_FALSE(with_estimate(stiffness_unknown + ", settle: 9 s").warnings.empty());
  // At rest at first, as this case says, every sample counts.
  EXPECT_EQ(run(with_estimate(stiffness_unknown), "estimate").get<EstimationOutcome>().settled, 0);
}

void order_of_the_step() {
  EXPECT_EQ(options_of(with_estimate(stiffness_unknown)).step_order, 4);
  EXPECT_EQ(options_of(with_estimate(stiffness_unknown + ", step_order: 2")).step_order, 2);
  const auto study = with_estimate(stiffness_unknown + ", substeps: 7");
  const auto results = run(study, "simulate");  // inputs in the middle of each part too
  EXPECT_EQ(make_filter_run(study.problem, *study.augmented_model, record_of(study, results)).input.inputs.cols(), 701);
  EXPECT_THROW(with_estimate(stiffness_unknown + ", step_order: 3"), InvalidInput);
}

void parts_of_an_interval() {
  const auto study = with_estimate(stiffness_unknown + ", substeps: 7, step_order: 2");
  EXPECT_EQ(options_of(study).substeps, 7);
  near(options_of(study).step, 0.01);
  EXPECT_EQ(study.problem->settings.substeps, 7);
  EXPECT_EQ(options_of(with_estimate(stiffness_unknown)).substeps, 2);  // to begin with
  for (const std::string text : {"", ", substeps: auto"})
    EXPECT_FALSE(with_estimate(stiffness_unknown + text).problem->settings.substeps);
  const auto results = run(study, "simulate");
  EXPECT_EQ(make_filter_run(study.problem, *study.augmented_model, record_of(study, results)).input.inputs.cols(), 351);
}

void diagnosis() {
  EXPECT_TRUE(with_estimate(stiffness_unknown).problem->settings.diagnose);
  EXPECT_FALSE(with_estimate(stiffness_unknown + ", diagnose: false").problem->settings.diagnose);
}

void what_may_follow_the_first_answer() {
  const auto allowed = [](const std::string& text) {
    return with_estimate(stiffness_unknown + text).problem->settings.second_thoughts;
  };
  EXPECT_TRUE(std::isinf(allowed("")));
  EXPECT_EQ(allowed(", diagnose: false"), 0.0);
  EXPECT_EQ(allowed(", diagnose: false, second_thoughts: 3"), 3.0);
  EXPECT_TRUE(std::isinf(allowed(", second_thoughts: full")));
  EXPECT_EQ(allowed(", second_thoughts: none"), 0.0);
  EXPECT_EQ(allowed(", second_thoughts: 2.5"), 2.5);
}

void what_is_known_of_fixed_numbers() {
  const auto stated = [](const std::string& text) {
    return with_estimate(stiffness_unknown + ", known_to: {" + text + "}").problem->settings.known_to;
  };
  EXPECT_TRUE(with_estimate(stiffness_unknown).problem->settings.known_to.empty());
  const auto known = stated("masses: 1 %, s.b.mass: 20 g, delays: 0.2 ms");
  ASSERT_EQ(known.size(), 3U);
  EXPECT_EQ(known[0].name, "masses");
  EXPECT_TRUE(known[0].relative);
  near(known[0].deviation, 0.01);
  EXPECT_FALSE(known[1].relative);
  near(known[1].deviation, 0.02);
  near(known[2].deviation, 2e-4);
}

void what_becomes_of_numbers_that_a_record_asks_to_change() {
  const auto free = [](const std::string& text) {
    return with_estimate(stiffness_unknown + text).problem->settings.free;
  };
  EXPECT_EQ(free(""), FreeNumbers::ask);
  EXPECT_EQ(free(", free: ask"), FreeNumbers::ask);
  EXPECT_EQ(free(", free: none"), FreeNumbers::none);
  EXPECT_EQ(free(", free: auto"), FreeNumbers::automatic);
}

void outliers() {
  const auto treatment = [](const std::string& text) {
    return with_estimate(stiffness_unknown + text).problem->settings.outliers;
  };
  EXPECT_FALSE(treatment(""));
  EXPECT_FALSE(treatment(", outliers: auto"));
  EXPECT_EQ(treatment(", outliers: gate"), OutlierTreatment::gate);
  EXPECT_EQ(treatment(", outliers: robust"), OutlierTreatment::robust);
  EXPECT_EQ(treatment(", outliers: keep"), OutlierTreatment::keep);
}

void threads() {
  EXPECT_EQ(filter_threads(with_estimate(stiffness_unknown + ", threads: 3").problem->settings), 3);
  EXPECT_EQ(filter_threads(with_estimate(stiffness_unknown + ", threads: 0").problem->settings), processors());
  EXPECT_EQ(filter_threads(with_estimate(stiffness_unknown).problem->settings), processors());
}

/// Two substructures joined by a connector; the one that is predicted is named.
void predictions() {
  for (const std::string name : {"s", "w"}) {
    const auto results =
        run(study_of(estimated_case(
                {{"substructures",
                  "{w: {masses: {w: 1.5, v: 1}, springs: [{from: ground, to: w, stiffness: 2e3}, {from: w, to: "
                  "v, stiffness: 900}]}, s: {masses: {a: 2, b: 3, c: 1}, springs: [{from: a, to: b, stiffness: "
                  "800}, {from: b, to: c, stiffness: 700}]}}"},
                 {"connectors", "{c: {from: w.w, to: s.a, law: linear, parameters: {k: 500, c: 3}}}"},
                 {"predict", "{substructure: " + name + "}"}})),
            "predict");
    EXPECT_EQ(results.get<PredictionOutcome>().substructure, name);
    for (const auto& point : results.get<PredictionOutcome>().points)
      EXPECT_TRUE(point.point.starts_with(name + ".")) << point.point;
    EXPECT_EQ(results.get<PredictionOutcome>().points.size(), name == "s" ? 6u : 4u);
  }
}

/// A substructure of more than 400 degrees of freedom is stepped by a scheme of second order in its substep.
void prediction_steps() {
  std::string nodes = "node,x_m,y_m,z_m\n1,0,0,0\n", elements = "element,node1,node2,region\n";
  for (int i = 1; i <= 80; ++i) {
    nodes += std::to_string(i + 1) + "," + std::to_string(i * 0.0125) + ",0,0\n";
    elements += std::to_string(i) + "," + std::to_string(i) + "," + std::to_string(i + 1) + ",bar\n";
  }
  const auto predicted = [&](const std::string& substeps) {
    const auto part = beam_elements();
    write_file("fine_nodes.csv", nodes);
    write_file("fine_elements.csv", elements);
    auto sections =
        beam_case({{"substructures",
                    "{w: {masses: {w: 1}, springs: [{from: ground, to: w, stiffness: 2e3}]}, b: {finite_elements: {" +
                        part + "}, reduction: {modes: 6}}}"},
                   {"connectors", "{c: {from: w.w, to: b.tip.z, law: linear, parameters: {k: 3e4}}}"},
                   {"excitation", "{f: {force: w.w, sine: {amplitude: 10, frequency: 60}}}"},
                   {"simulate", "{duration: 0.03 s, sample_rate: 1 kHz, tolerance: 1, first_substeps: 1}"},
                   {"estimate", "{unknown: {c.k: {initial: 3e4, std: 1 %}}, settle: 0, substeps: 1}"},
                   {"predict", "{substructure: b" + substeps + "}"}});
    auto& part_text = sections["substructures"];
    part_text.replace(part_text.find("tip: 3"), 6, "tip: 81");
    part_text.replace(part_text.find("nodes.csv"), 9, "fine_nodes.csv");
    part_text.replace(part_text.find("elements.csv"), 12, "fine_elements.csv");
    const auto results = run(study_of(sections), "predict");
    return find_quantity(results.get<PredictionOutcome>().points, "b.mid.z", ObservedQuantity::displacement)->mean;
  };
  const Eigen::VectorXd one = predicted(", substeps: 1"), two = predicted(""), four = predicted(", substeps: 4");
  near(predicted(", substeps: 2"), two);
  const double first = (one - two).norm(), second = (two - four).norm();
  EXPECT_GT(first, 2.0 * second);
  EXPECT_GT(second, 1e-9 * four.norm());
}

}  // namespace

KeyChecks estimation_keys() {
  KeyChecks keys;
  const auto add = [&](const std::string& prefix, const std::vector<std::string>& names, void (*check)()) {
    for (const auto& name : names) keys[prefix + name] = check;
  };
  add(at + "unknown.*.", {"initial", "std"}, first_guesses_and_deviations);
  add(at + "unknown.*.", {"transform", "bounds"}, transforms);
  add(at + "unknown.*.", {"random_walk"}, drifts);
  add(at + "unknown.*.", {"truth"}, truths);
  add(at + "unknown.*.", {"applies_to"}, [] {
    shared_values();
    linear_elements_are_released();
  });
  add(at + "initial_state.*.", {"displacement", "velocity", "displacement_std", "velocity_std"}, initial_states);
  add(at, {"initial_state_from_record"}, start_from_the_record);
  add(at + "initial_connector_states.*.", {"value", "std"}, initial_connector_states);
  add(at + "process_noise.", {"acceleration", "accelerations"}, process_noise);
  add(at + "local.", {"substructures"}, local_models_move_as_measured);
  add(at + "local.interface.*.acceleration.", {"sensor", "displacement_std", "velocity_std"},
      local_models_move_as_measured);
  add(at + "local.interface.*.force.", {"std", "correlation_time"}, local_models_are_pushed_by_unknown_forces);
  add(at, {"filter"}, filter_kinds);
  add(at, {"alpha", "beta", "kappa"}, spreads_of_sigma_points);
  add(at, {"update_iterations"}, passes_of_an_update);
  add(at + "adaptive_noise.", {"sensors", "process", "memory"}, noise_that_adapts);
  add(at, {"passes", "estimate_initial_state"}, passes_over_the_record);
  add(at, {"smooth"}, estimates_from_the_whole_record);
  add(at, {"settle"}, sums_begin_after_settling);
  add(at, {"substeps"}, parts_of_an_interval);
  add(at, {"step_order"}, order_of_the_step);
  add(at, {"threads"}, threads);
  add(at, {"outliers"}, outliers);
  add(at, {"diagnose"}, diagnosis);
  add(at, {"second_thoughts"}, what_may_follow_the_first_answer);
  add(at, {"known_to"}, what_is_known_of_fixed_numbers);
  add(at, {"free"}, what_becomes_of_numbers_that_a_record_asks_to_change);
  add("predict.", {"substructure"}, predictions);
  add("predict.", {"substeps"}, prediction_steps);
  return keys;
}

}  // namespace kalfem::wiring
