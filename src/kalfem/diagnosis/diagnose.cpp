// SPDX-License-Identifier: Apache-2.0
#include "kalfem/diagnosis/diagnose.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include <fmt/format.h>

#include "kalfem/base/parallel.hpp"
#include "kalfem/base/stopwatch.hpp"
#include "kalfem/diagnosis/evidence.hpp"
#include "kalfem/diagnosis/law_terms.hpp"
#include "kalfem/diagnosis/trial.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double trials = 100.0;        ///< of a diagnosis, about
constexpr double most_work = 6e10;      ///< operations of all trials, about: decides how much of the record they see
constexpr double telling_part = 0.3;    ///< of the sum of NIS that the trials should see
constexpr Index fewest_samples = 1500;  ///< of the record, where it has as many
constexpr Index fewest_raced = 200;     ///< of it, in a race
constexpr double worth_refining = 0.2;  ///< part of the best's rise
constexpr double significant = 20.0;    ///< rise of the log-likelihood
constexpr double worth_looking = 0.1;   ///< part of the best's rise: a second law that is looked into
constexpr double worth_telling = 0.01;  ///< part of the rise: a further force of a law
constexpr std::size_t most_laws = 3;    ///< connectors whose laws are looked into term by term
constexpr std::size_t most_terms = 3;   ///< of one law
constexpr double as_good = 0.002;       ///< log-likelihood per measured value by which equal explanations differ

/// Operations of one step of the filter, about.
double work_of_step(const FilterRun& run) {
  const auto n = static_cast<double>(run.choice.augmented_model->layout().size());
  const bool partially_linear = run.choice.filter == FilterKind::partially_linear ||
                                run.choice.filter == FilterKind::partially_linear_square_root;
  return partially_linear ? 50.0 * n * n : 10.0 * n * n * n;
}

/// Samples until the sum of NIS has reached a good part of its whole; where the filter stopped before the end, twice as
/// many as it reached.
Index telling_samples(const VectorXd& nis, Index samples) {
  if (nis.size() < samples) return 2 * nis.size();
  const VectorXd known = nis.array().isFinite().select(nis, 0.0);
  const double wanted = telling_part * known.sum();
  double sum = 0.0;
  for (Index k = 0; k < samples; ++k) {
    sum += known[k];
    if (sum >= wanted) return k + 1;
  }
  return samples;
}

/// First samples of the record: enough to tell what is wrong, and no more than so many trials can afford.
Index part_for(const DiagnosisInput& input, const FilterRun& run) {
  const auto affordable = static_cast<Index>(most_work / (trials * work_of_step(run)));
  const Index wanted =
      std::max(fewest_samples, std::min(affordable, telling_samples(input.nis, input.record.samples_used())));
  return std::min(input.record.samples(), wanted);
}

/// Hypotheses that see so many first samples of the part.
struct Round {
  std::size_t hypotheses = 0;
  Index samples = 0;
};

/// What the trials may take. Without a limit every hypothesis sees the whole part. With one they are raced (successive
/// halving: Karnin, Koren and Somekh 2013, ICML, 1238-1246): all see a short part, a third of them a longer one, and
/// the best the whole; what is left goes into the search of their numbers.
struct TrialPlan {
  int substeps = 1;
  Index samples = 0;  ///< of the part
  std::size_t refined = 8;
  int most_steps = 10;
  std::size_t laws = most_laws, terms = most_terms;
  std::size_t next_terms = 5;  ///< that are tried beside the best
  std::size_t finalists = 12;
  double raced = std::numeric_limits<double>::infinity();  ///< whole parts that each round before the last may take

  /// Whole parts that a race takes beside its rounds.
  [[nodiscard]] double passes(const FilterRun& run) const {
    constexpr double first_guesses = 18.0;  // of the terms of a law
    return static_cast<double>(runs_for_hypotheses(run)) + 1.0 + static_cast<double>(finalists) +
           static_cast<double>(refined) * most_steps +
           static_cast<double>(laws * terms) * (first_guesses + 0.3 * most_steps);
  }
  /// `starts`: first guesses of all hypotheses together.
  [[nodiscard]] std::vector<Round> rounds(std::size_t hypotheses, std::size_t starts) const {
    const auto share = [&](std::size_t runs) {
      return static_cast<Index>(std::min(1.0, raced / static_cast<double>(runs)) * static_cast<double>(samples));
    };
    const std::size_t second = std::max(finalists, hypotheses / 3);
    std::vector<Round> all{{hypotheses, share(starts)}};
    if (all.back().samples < samples && second < hypotheses) all.push_back({second, share(second)});
    if (all.back().samples < samples) all.push_back({finalists, samples});
    return all;
  }
};

/// The plan for the steps that are allowed: with as many substeps as leave the part long enough to tell anything.
/// Nothing where none do.
std::optional<TrialPlan> plan_for(const DiagnosisInput& input, const FilterRun& run) {
  TrialPlan plan{.substeps = input.problem->settings.substeps.value_or(1), .samples = part_for(input, run)};
  if (!std::isfinite(input.steps)) return plan;
  plan.finalists = 6;
  plan.refined = 2;
  plan.most_steps = 5;
  plan.laws = 1;
  plan.terms = 2;
  plan.raced = 15.0;
  const double parts = plan.passes(run) + 2.0 * plan.raced;
  const auto affordable = [&] { return static_cast<Index>(input.steps / (parts * plan.substeps)); };
  while (plan.substeps > 1 && affordable() < std::min(plan.samples, fewest_samples)) plan.substeps /= 2;
  plan.samples = std::min(plan.samples, affordable());
  return plan.samples < std::min(fewest_raced, input.record.samples()) ? std::nullopt : std::optional(plan);
}

class Trials {
public:
  Trials(DiagnosisInput input, const TrialPlan& plan) : input_(std::move(input)), plan_(plan) {
    input_.record = first_samples(std::move(input_.record), plan.samples);
    auto problem = std::make_shared<EstimationProblem>(*input_.problem);
    problem->settings.substeps = plan.substeps;
    input_.problem = std::move(problem);
    base_ = input_.run_of(input_.problem, input_.parts);
    options_ = {.filter = base_.choice.filter,
                .unscented = input_.options.unscented,
                .state_deviations = false,
                .adaptive_noise = input_.options.adaptive_noise};
  }

  Diagnosis run() {
    const Stopwatch watch;
    TrialScore given = score_of({base_, 0.0}, options_, {});
    given.samples = measured_samples(plan_.samples);  // also of a run that stopped
    Diagnosis diagnosis{.duration = static_cast<double>(input_.record.samples()) / input_.record.sample_rate,
                        .failed = !std::isfinite(given.log_likelihood),
                        .mean_nis = given.mean_nis,
                        .expected_nis = given.expected_nis,
                        .widening = given.widening};
    auto candidates = all_candidates(input_, base_, options_);
    hypotheses_ = std::move(candidates.hypotheses);
    scores_.resize(hypotheses_.size());
    values_.resize(hypotheses_.size());
    race(given);
    look_into_laws(given, candidates.motion);
    refine_the_best(given);
    collect(given, diagnosis);
    diagnosis.seconds = watch.seconds();
    return diagnosis;
  }

private:
  /// The first round takes every first guess, later ones the best of each. Who is left behind keeps no score.
  void race(const TrialScore& given) {
    std::size_t starts = 0;
    for (const auto& hypothesis : hypotheses_) starts += hypothesis.starts.size();
    const auto rounds = plan_.rounds(hypotheses_.size(), starts);
    std::vector<std::size_t> order(hypotheses_.size());
    for (std::size_t h = 0; h < order.size(); ++h) order[h] = h;
    for (std::size_t r = 0; r < rounds.size(); ++r) {
      samples_ = rounds[r].samples;
      order.resize(std::min(order.size(), rounds[r].hypotheses));
      std::vector<TrialScore> before(hypotheses_.size());
      std::swap(scores_, before);
      for_each_index(order.size(), processors(), [&](std::size_t i) {
        const std::size_t h = order[i];
        if (r == 0)
          for (const double start : hypotheses_[h].starts) try_value(h, start);
        else
          try_value(h, values_[h]);
      });
      order = best_first(given);
    }
  }

  /// Hypotheses of a wrong law stand for many forces together, enough to tell which connector is in question. Those of
  /// the most likely ones give way to the forces that make it up, one after another while each explains far more.
  void look_into_laws(const TrialScore& given, const std::vector<ConnectorMotion>& motion) {
    std::vector<std::size_t> laws;
    double best = 0.0;
    for (const std::size_t h : best_first(given)) {
      if (explains(hypotheses_[h], scores_[h])) best = std::max(best, gain(h, given));
      if (hypotheses_[h].code == "wrong_law" && laws.size() < plan_.laws &&
          (laws.empty() || gain(h, given) >= worth_looking * best))
        laws.push_back(h);
    }
    for (const std::size_t h : laws) {
      const auto& connectors = input_.parts.connectors;
      const auto at = std::ranges::find(connectors, hypotheses_[h].subject, &ConnectorDescription::name);
      add_terms(given, *at, motion[static_cast<std::size_t>(at - connectors.begin())]);
      scores_[h] = {};
    }
  }

  void add_terms(const TrialScore& given, const ConnectorDescription& connector, const ConnectorMotion& motion) {
    std::vector<LawTerm> left = law_terms(motion);
    std::vector<ChosenTerm> known;
    double before = 0.0;
    while (known.size() < plan_.terms && !left.empty()) {
      const std::size_t first = hypotheses_.size();
      for (const auto& term : left) {
        auto with_it = known;
        with_it.push_back({term});
        add(lacking_terms(input_, connector, with_it, known.size()));
      }
      for_each_index(left.size(), processors(), [&](std::size_t i) { try_starts(first + i); });
      std::size_t best = 0;
      for (std::size_t i = 0; i < left.size(); ++i)
        if (gain(first + i, given) > gain(first + best, given)) best = i;
      if (left[best].searched()) refine(first + best, plan_.most_steps / 2);
      const double reached = gain(first + best, given);
      if (!(reached > before + std::max(significant, worth_telling * before))) break;
      before = reached;
      known.push_back({left[best], values_[first + best]});
      left = the_next(left, first, best, given);
    }
    settle_places(connector, known);
  }

  /// The forces that explained most after the best one, each with the number at which it did.
  [[nodiscard]] std::vector<LawTerm> the_next(const std::vector<LawTerm>& terms, std::size_t first, std::size_t best,
                                              const TrialScore& given) const {
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < terms.size(); ++i)
      if (i != best) order.push_back(i);
    std::ranges::stable_sort(order, std::greater{}, [&](std::size_t i) { return gain(first + i, given); });
    if (order.size() > plan_.next_terms) order.resize(plan_.next_terms);
    std::vector<LawTerm> next;
    for (const std::size_t i : order) {
      next.push_back(terms[i]);
      if (next.back().searched() && values_[first + i] != 0.0) next.back().starts = {values_[first + i]};
    }
    return next;
  }

  /// The numbers of earlier forces again, beside those that came after them.
  void settle_places(const ConnectorDescription& connector, std::vector<ChosenTerm> known) {
    for (std::size_t i = known.size(); i-- > 0;) {
      if (!known[i].term.searched() || i + 1 == known.size()) continue;
      known[i].term.starts = {known[i].place};
      add(lacking_terms(input_, connector, known, i));
      try_starts(hypotheses_.size() - 1);
      refine(hypotheses_.size() - 1, plan_.most_steps / 2);
      known[i].place = values_.back();
    }
  }

  void add(Hypothesis hypothesis) {
    hypotheses_.push_back(std::move(hypothesis));
    scores_.emplace_back();
    values_.push_back(0.0);
  }

  void try_starts(std::size_t h) {
    for (const double start : hypotheses_[h].starts) try_value(h, start);
  }

  /// Keeps the value if it explains the record better than those before. Says whether it does. A correction that the
  /// problem does not admit (a negative mass) explains nothing.
  bool try_value(std::size_t h, double value) {
    TrialScore score;
    try {
      score = score_of(first_part(hypotheses_[h].correct(value), samples_), options_, measured_samples(samples_));
    } catch (const InvalidInput&) {
    }
    if (!(score.log_likelihood > scores_[h].log_likelihood)) return false;
    scores_[h] = std::move(score);
    values_[h] = value;
    return true;
  }

  /// Of each channel, among the first samples of what the filter learns from.
  [[nodiscard]] Eigen::VectorXi measured_samples(Index first) const {
    const auto& measured = base_.input.measured;
    return measured.values.leftCols(std::min(first, measured.samples_used()))
        .array()
        .isFinite()
        .rowwise()
        .count()
        .cast<int>();
  }

  [[nodiscard]] double gain(std::size_t h, const TrialScore& given) const {
    const double n = std::max(2.0, static_cast<double>(given.samples.sum()));
    const double before = std::isfinite(given.log_likelihood) ? given.log_likelihood : lowest();
    return scores_[h].log_likelihood - before - 0.5 * hypotheses_[h].fitted * std::log(n);
  }

  /// Where the filter failed as it was given, every hypothesis under which it does not is measured from the worst.
  [[nodiscard]] double lowest() const {
    double lowest = 0.0;
    for (const auto& score : scores_)
      if (std::isfinite(score.log_likelihood)) lowest = std::min(lowest, score.log_likelihood);
    return lowest;
  }

  [[nodiscard]] std::vector<std::size_t> best_first(const TrialScore& given) const {
    std::vector<std::size_t> order(hypotheses_.size());
    for (std::size_t h = 0; h < order.size(); ++h) order[h] = h;
    std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) { return gain(a, given) > gain(b, given); });
    return order;
  }

  void refine_the_best(const TrialScore& given) {
    std::vector<std::size_t> chosen;
    const auto order = best_first(given);
    const double least = std::max(0.0, worth_refining * gain(order.front(), given));
    for (const std::size_t h : order)
      if (hypotheses_[h].search != Search::none && chosen.size() < plan_.refined && gain(h, given) >= least)
        chosen.push_back(h);
    for_each_index(chosen.size(), processors(), [&](std::size_t c) { refine(chosen[c], plan_.most_steps); });
  }

  static double moved(const Hypothesis& hypothesis, double value, double steps) {
    return hypothesis.search == Search::factor ? value * std::exp(steps * hypothesis.step)
                                               : value + steps * hypothesis.step;
  }

  /// Walks uphill, twice as far after each success, and half as far, the other way, after each failure.
  void refine(std::size_t h, int most_steps) {
    const Hypothesis& hypothesis = hypotheses_[h];
    double steps = 1.0;
    for (int i = 0; i < most_steps; ++i) {
      if (hypothesis.search == Search::samples && std::abs(steps) < 1.0) break;
      const bool better = try_value(h, moved(hypothesis, values_[h], steps));
      const bool first_failure = !better && i == 0;
      steps = better ? 2.0 * steps : first_failure ? -steps : -0.5 * steps;
    }
  }

  void collect(const TrialScore& given, Diagnosis& diagnosis) const {
    const auto order = best_first(given);
    for (const std::size_t h : order) {
      const auto& hypothesis = hypotheses_[h];
      const auto& score = scores_[h];
      const bool failed = !std::isfinite(score.log_likelihood);
      diagnosis.tested.push_back({.code = hypothesis.code,
                                  .subject = hypothesis.subject,
                                  .words = failed ? "" : hypothesis.words(values_[h], score.estimates),
                                  .remedy = hypothesis.remedy,
                                  .value = values_[h],
                                  .turned = hypothesis.turned,
                                  .forces = failed || !hypothesis.forces
                                                ? std::vector<LackingForce>{}
                                                : hypothesis.forces(values_[h], score.estimates),
                                  .fitted = hypothesis.fitted,
                                  .failed = failed,
                                  .explains = !failed && explains(hypothesis, score),
                                  .gain = failed ? 0.0 : gain(h, given),
                                  .mean_nis = score.mean_nis,
                                  .expected_nis = score.expected_nis,
                                  .widening = score.widening});
    }
    std::ranges::stable_partition(diagnosis.tested, &TestedHypothesis::explains);
    prefer_the_simplest(std::max(significant, as_good * static_cast<double>(given.samples.sum())), diagnosis);
  }

  static bool explains(const Hypothesis& hypothesis, const TrialScore& score) {
    return !hypothesis.widens || (state_of(score.widening) == VerdictState::consistent &&
                                  state_of(score.loudest_part) == VerdictState::consistent);
  }

  /// Of those that explain as much as the best, the one that takes the fewest numbers from the record stands first.
  static void prefer_the_simplest(double tolerance, Diagnosis& diagnosis) {
    auto& tested = diagnosis.tested;
    if (tested.empty() || tested.front().failed) return;
    const double least = tested.front().gain - tolerance;
    const auto end = std::ranges::find_if(
        tested, [&](const auto& each) { return each.failed || !each.explains || each.gain < least; });
    std::stable_sort(tested.begin(), end, [](const auto& a, const auto& b) { return a.fitted < b.fitted; });
    for (auto other = tested.begin() + 1; other < end; ++other)
      if (other->fitted == tested.front().fitted) diagnosis.also.push_back(other->words);
  }

  DiagnosisInput input_;
  TrialPlan plan_;
  FilterRun base_;
  EstimationOptions options_;
  std::vector<Hypothesis> hypotheses_;
  std::vector<TrialScore> scores_;
  std::vector<double> values_;  ///< at which the score stands
  Index samples_ = 0;           ///< that the trials see
};

}  // namespace

std::optional<TestedHypothesis> Diagnosis::cause() const {
  if (tested.empty() || tested.front().failed || !tested.front().explains || !(tested.front().gain > significant))
    return std::nullopt;
  const auto& best = tested.front();
  const double excess = std::abs(mean_nis - expected_nis), left = std::abs(best.mean_nis - best.expected_nis);
  const bool explains = (failed && best.widening < unusable_widening) ||
                        (!failed && (left < 0.7 * excess || best.widening < 0.8 * widening));
  return explains ? std::optional(best) : std::nullopt;
}

std::optional<Diagnosis> diagnose(const DiagnosisInput& input) {
  const auto plan = plan_for(input, input.run_of(input.problem, input.parts));
  return plan ? std::optional(Trials(input, *plan).run()) : std::nullopt;
}

std::vector<Reason> reasons_of(const Diagnosis& diagnosis, VerdictState state) {
  const auto cause = diagnosis.cause();
  if (!cause) return {};
  std::string others;
  for (const auto& words : diagnosis.also) others += (others.empty() ? "; as likely: " : ", or ") + words;
  const std::string before = diagnosis.failed ? "the filter stopped" : fmt::format("it is {:.3g}", diagnosis.mean_nis);
  const std::string remainder =
      state_of(cause->widening) == VerdictState::consistent ? "" : ", which does not explain all";
  return {{.code = cause->code,
           .subject = cause->subject,
           .text = fmt::format("{}: with this undone the mean NIS is {:.3g} (expected {:.3g}), as given {}{}{}",
                               cause->words, cause->mean_nis, cause->expected_nis, before, remainder, others),
           .remedy = cause->remedy,
           .state = state,
           .weight = std::numeric_limits<double>::infinity()}};
}

}  // namespace kalfem
