// SPDX-License-Identifier: Apache-2.0
#include "casefile/probes.hpp"
#include "kalfem/inference/parameter_likelihood.hpp"
#include "kalfem/sampling/evidence.hpp"
#include "kalfem/steps/run_study.hpp"

/// Keys of the inference: the plan against the numbers of the case, laws against the case that has them.
namespace kalfem::wiring {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

const std::string at = "infer.";

/// Two unknowns of the connector c of the lumped case.
const std::string two_unknowns =
    "{unknown: {c.k: {initial: 480 N/m, std: 10 %, transform: log}, c.c: {initial: 5, std: 1}}, diagnose: false}";

Study with_infer(const std::string& text, const Sections& more = {}) {
  Sections sections{{"estimate", two_unknowns}, {"infer", "{" + text + "}"}};
  for (const auto& [key, value] : more) sections[key] = value;
  return study_of(estimated_case(sections));
}

const InferencePlan& plan_of(const Study& study) { return *study.inference; }

template <class P>
P prior_of(const std::string& text, std::size_t i = 0) {
  return std::get<P>(plan_of(with_infer(text)).prior.marginals().at(i).second);
}

void priors() {
  near(prior_of<LogNormalPrior>("").median, 480.0);  // as `estimate` says
  near(prior_of<LogNormalPrior>("").log_deviation, 0.1);
  near(prior_of<NormalPrior>("", 1).mean, 5.0);
  near(prior_of<NormalPrior>("", 1).deviation, 1.0);
  const auto normal =
      prior_of<NormalPrior>("priors: {c.k: {normal: {mean: 0.5 N/mm, std: 10 %}, bounds: [0.4 N/mm, 700 N/m]}}");
  near(normal.mean, 500.0);
  near(normal.deviation, 50.0);
  near(normal.lower, 400.0);
  near(normal.upper, 700.0);
  near(prior_of<NormalPrior>("priors: {c.k: {normal: {mean: 500, std: 20 N/m}}}").deviation, 20.0);
  const auto lognormal =
      prior_of<LogNormalPrior>("priors: {c.k: {lognormal: {median: 0.5 N/mm, std: 40 %}, bounds: [100, 900]}}");
  near(lognormal.median, 500.0);
  near(lognormal.log_deviation, 0.4);
  near(lognormal.upper, 900.0);
  near(prior_of<UniformPrior>("priors: {c.k: {uniform: [0.1 N/mm, 900]}}").lower, 100.0);
  near(prior_of<UniformPrior>("priors: {c.k: {uniform: [0.1 N/mm, 900]}}").upper, 900.0);
}

void prior_correlations() {
  EXPECT_EQ(plan_of(with_infer("")).prior.correlation().size(), 0);
  const auto correlation = plan_of(with_infer("correlations: [{between: [c.c, c.k], value: 0.4}]")).prior.correlation();
  near(correlation(0, 1), 0.4);
  near(correlation(1, 0), 0.4);
  near(correlation(1, 1), 1.0);
}

void numbers() {
  const auto usual = with_infer("");
  EXPECT_EQ(plan_of(usual).likelihood, LikelihoodKind::filter);
  EXPECT_EQ(plan_of(usual).method, PosteriorMethod::importance);
  EXPECT_EQ(plan_of(usual).samples, 1000);
  EXPECT_EQ(plan_of(usual).predictions, 40);
  EXPECT_TRUE(plan_of(usual).profile.empty());
  const auto study = with_infer(
      "likelihood: simulation, correlation_time: 20 ms, method: tempered, samples: 300, seed: 7, predictions: 5, "
      "profile: c.c");
  EXPECT_EQ(plan_of(study).likelihood, LikelihoodKind::simulation);
  near(plan_of(study).correlation_time, 0.02);
  EXPECT_EQ(plan_of(study).method, PosteriorMethod::tempered);
  EXPECT_EQ(plan_of(study).samples, 300);
  EXPECT_EQ(plan_of(study).seed, 7u);
  EXPECT_EQ(plan_of(study).predictions, 5);
  EXPECT_EQ(plan_of(study).profile, std::vector<std::size_t>{1});
  EXPECT_EQ(plan_of(with_infer("method: laplace")).method, PosteriorMethod::laplace);
  EXPECT_EQ(plan_of(with_infer("method: filter")).method, PosteriorMethod::filter);
  EXPECT_EQ(plan_of(with_infer("method: metropolis")).method, PosteriorMethod::metropolis);
}

/// The correlation time reaches the likelihood: longer than a sample, the same errors are likelier or less so.
/// The other unknown stays in the filter's state.
void chosen_parameters() {
  const Study study = with_infer("parameters: c.c");
  ASSERT_EQ(plan_of(study).parameters.size(), 1u);
  EXPECT_EQ(plan_of(study).parameters[0].name, "c.c");
  near(std::get<NormalPrior>(plan_of(study).prior.marginals().at(0).second).mean, 5.0);
}

void likelihoods() {
  const auto of = [](const std::string& text) {
    const Study study = with_infer(text);
    const StudyResults results = run(study, "simulate");
    const VectorXd start = start_of(*study.inference);
    return likelihood_of_record(*study.inference, record_of(study, results), start).log_likelihood(start);
  };
  const double by_filter = of("likelihood: filter"), white = of("likelihood: simulation"),
               correlated = of("likelihood: simulation, correlation_time: 50 ms");
  EXPECT_NE(by_filter, white);
  EXPECT_NE(white, correlated);
  EXPECT_EQ(of("likelihood: auto"), by_filter);
}

/// A law with everything that a law can have.
const std::string everything =
    "law: expression, force: \"g*x + q*s + c*v + 0.1*tone\", let: {g: 2*k}, states: {s: {rate: \"v - s\", unit: m}}, "
    "parameters: {q: 3 N/m, c: 4}, signals: {tone: {sine: {amplitude: 1 V, frequency: 3 Hz}}}, ";
const std::string alternative = everything + "priors: {k: {uniform: [200 N/m, 300 N/m]}}";

const std::string linear =
    "law: linear, priors: {k: {normal: {mean: 500 N/m, std: 50}, bounds: [0, 900]}, c: "
    "{lognormal: {median: 4, std: 30 %}}}";

const std::string unbounded_linear =
    "law: linear, priors: {k: {normal: {mean: 500 N/m, std: 50}}, c: {lognormal: {median: 4, std: 30 %}}}";

/// The same case with the laws among the alternatives of `estimate`.
Study with_alternatives(const std::string& laws) {
  std::string estimate = two_unknowns;
  estimate.insert(1, "alternatives: {connector: c, laws: {" + laws + "}}, ");
  return study_of(estimated_case({{"estimate", estimate}}));
}

/// What an alternative of `estimate` may not have is refused; the rest is the same study as in `infer`.
void estimated_laws() {
  const std::string with_normal = everything + "priors: {k: {normal: {mean: 250 N/m, std: 50}}}";
  const Study study = with_alternatives("one: {" + with_normal + "}, two: {" + unbounded_linear + "}");
  ASSERT_EQ(study.alternatives.size(), 2u);
  const auto& [name, law, other] = study.alternatives[0];
  EXPECT_EQ(name, "one");
  EXPECT_EQ(law, "expression");
  const Study inferred =
      with_infer("compare_laws: {connector: c, laws: {one: {" + with_normal + "}, two: {" + unbounded_linear + "}}}");
  const auto& expected = system_of(*plan_of(inferred).laws[0].study).connectors.at(0);
  const auto& found = system_of(*other).connectors.at(0);
  near(VectorXd(found.parameters), VectorXd(expected.parameters));
  EXPECT_EQ(found.law->states().size(), 1u);
  const auto& unknowns = other->problem->settings.unknowns;
  ASSERT_EQ(unknowns.size(), 1u);
  near(unknowns[0].initial, 250.0);
  near(unknowns[0].deviation, 50.0);
  const auto& of_linear = study.alternatives[1].study->problem->settings.unknowns;
  ASSERT_EQ(of_linear.size(), 2u);
  near(of_linear[1].initial, 4.0);
  near(of_linear[1].deviation, 1.2);
  EXPECT_EQ(of_linear[1].transform.kind, TransformKind::log);
  EXPECT_THROW((void)with_alternatives("one: {" + alternative + "}"), InvalidInput);
  EXPECT_THROW((void)with_alternatives("two: {" + linear + "}"), InvalidInput);
}

/// The alternative is the case with that law in the connector, and its parameters are its unknowns.
void laws() {
  const Study study =
      with_infer("compare_laws: {connector: c, laws: {one: {" + alternative + "}, two: {" + linear + "}}}");
  ASSERT_EQ(plan_of(study).laws.size(), 2u);
  EXPECT_EQ(plan_of(study).connectors, std::vector<std::string>{"c"});
  const auto& [name, law, other] = plan_of(study).laws[0];
  EXPECT_EQ(name, "one");
  EXPECT_EQ(law, "expression");
  const auto& connector = system_of(*other).connectors.at(0);
  const auto& expected =
      system_of(
          study_of(estimated_case({{"estimate", ""},
                                   {"connectors",
                                    "{c: {from: s.a, to: s.b, law: expression, force: \"g*x + q*s + c*v + "
                                    "0.1*tone\", let: {g: 2*k}, states: {s: {rate: \"v - s\", unit: m}}, "
                                    "parameters: {q: 3 N/m, c: 4, k: 250 N/m}, signals: {tone: {sine: {amplitude: "
                                    "1 V, frequency: 3 Hz}}}}}"}})))
          .connectors.at(0);
  near(VectorXd(connector.parameters), VectorXd(expected.parameters));
  EXPECT_EQ(connector.law->states().size(), 1u);
  EXPECT_EQ(other->structure->signals.size(), study.structure->signals.size() + 1);
  ASSERT_EQ(other->inference->parameters.size(), 1u);
  EXPECT_EQ(other->inference->parameters[0].name, "c.k");
  near(std::get<UniformPrior>(other->inference->prior.marginals()[0].second).upper, 300.0);
  const auto& second = plan_of(study).laws[1].study->inference->prior.marginals();
  near(std::get<NormalPrior>(second[0].second).deviation, 50.0);
  near(std::get<NormalPrior>(second[0].second).upper, 900.0);
  near(std::get<LogNormalPrior>(second[1].second).median, 4.0);
  near(std::get<LogNormalPrior>(second[1].second).log_deviation, 0.3);
}

/// The signals of an alternative are those of the case that has its connector; component_keys.cpp and
/// structure_keys.cpp hold them against their definitions.
void law_signals() {
  std::vector<double> column(300);
  for (std::size_t k = 0; k < column.size(); ++k) column[k] = std::sin(0.2 * static_cast<double>(k));
  write_file("fed.csv", csv_of(100.0, {{"f", column}}));
  const std::string connector =
      "law: expression, force: \"k*x + 3*v + noise + tone + chirp + level + column\", signals: {"
      "noise: {random: {rms: 2 V, band: [0.5, 5 Hz], duration: 1 s, fade_in: 0.1 s, seed: 2}, scale: 2}, "
      "tone: {sine: {amplitude: 1 V, frequency: 3 Hz, phase: 0.1, fade_in: 0.1 s}}, "
      "chirp: {sweep: {amplitude: 1 V, from: 1 Hz, to: 5 Hz, duration: 1 s, kind: logarithmic, fade_in: 0.1 s}}, "
      "level: {constant: 2 V}, "
      "column: {channel: f, file: fed.csv, sample_rate: 100 Hz, unit: mV, bridge_gaps: 20 ms, prepare: {remove_offset: "
      "{from: 0.1 s, to: 0.2 s}, remove_trend: true, high_pass: 0.5 Hz, low_pass: 30 Hz, sample_rate: 80 Hz}}}";
  const std::string laws =
      "one: {" + connector + ", priors: {k: {normal: {mean: 250, std: 50}}}}, two: {" + unbounded_linear + "}";
  const Study inferred = with_infer("compare_laws: {connector: c, laws: {" + laws + "}}");
  const Study estimated = with_alternatives(laws);
  const Study expected = study_of(estimated_case(
      {{"estimate", ""}, {"connectors", "{c: {from: s.a, to: s.b, parameters: {k: 250}, " + connector + "}}"}}));
  const auto& signals = expected.structure->signals;
  for (const auto& study : {plan_of(inferred).laws.at(0).study, estimated.alternatives.at(0).study}) {
    const auto& found = study->structure->signals;
    ASSERT_EQ(found.size(), signals.size());
    ASSERT_EQ(found.size(), 6u);
    for (std::size_t i = 0; i < found.size(); ++i) same_signal(*found[i], *signals[i], 0.01, 40);
  }
}

void sensitivities() {
  const Study study = with_infer("sensitivity: {outputs: [frequency.2, force.c, nis], samples: 64}");
  const auto& plan = *plan_of(study).sensitivity;
  EXPECT_EQ(plan.samples, 64);
  ASSERT_EQ(plan.outputs.size(), 3u);
  EXPECT_EQ(plan.outputs[0].mode, 1);
  EXPECT_EQ(plan.outputs[1].connector, "c");
  EXPECT_EQ(plan.outputs[2].kind, SensitivityOutput::mean_nis);
  EXPECT_EQ(with_infer("sensitivity: {outputs: nis}").inference->sensitivity->samples, 256);
}

}  // namespace

KeyChecks inference_keys() {
  KeyChecks keys;
  const auto add = [&](const std::string& prefix, const std::vector<std::string>& names, void (*check)()) {
    for (const auto& name : names) keys[prefix + name] = check;
  };
  const std::vector<std::string> prior{"normal.mean",   "normal.std", "lognormal.median",
                                       "lognormal.std", "uniform",    "bounds"};
  add(at + "priors.*.", prior, priors);
  add(at, {"parameters"}, chosen_parameters);
  add(at + "correlations[].", {"between", "value"}, prior_correlations);
  add(at, {"method", "samples", "seed", "predictions", "profile"}, numbers);
  add(at, {"likelihood", "correlation_time"}, likelihoods);
  const std::vector<std::string> of_law{"law", "parameters", "force", "let", "states.*.rate", "states.*.unit"};
  const std::vector<std::string> of_signals{"bridge_gaps",
                                            "channel",
                                            "constant",
                                            "file",
                                            "prepare.high_pass",
                                            "prepare.low_pass",
                                            "prepare.remove_offset.from",
                                            "prepare.remove_offset.to",
                                            "prepare.remove_trend",
                                            "prepare.sample_rate",
                                            "random.band",
                                            "random.duration",
                                            "random.fade_in",
                                            "random.rms",
                                            "random.seed",
                                            "sample_rate",
                                            "scale",
                                            "sine.amplitude",
                                            "sine.fade_in",
                                            "sine.frequency",
                                            "sine.phase",
                                            "sweep.amplitude",
                                            "sweep.duration",
                                            "sweep.fade_in",
                                            "sweep.from",
                                            "sweep.kind",
                                            "sweep.to",
                                            "unit"};
  const std::vector<std::pair<std::string, void (*)()>> places{{at + "compare_laws.", laws},
                                                               {"estimate.alternatives.", estimated_laws}};
  for (const auto& [place, check] : places) {
    add(place, {"connector"}, check);
    add(place + "laws.*.", of_law, check);
    add(place + "laws.*.priors.*.", prior, check);
    add(place + "laws.*.signals.*.", of_signals, law_signals);
  }
  add(at + "sensitivity.", {"outputs", "samples"}, sensitivities);
  return keys;
}

}  // namespace kalfem::wiring
