// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/inference/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "kalfem/page/display_unit.hpp"
#include "kalfem/page/words.hpp"
#include "kalfem/sampling/peak_search.hpp"
#include "kalfem/steps/inference/outcome.hpp"

namespace kalfem {

using Eigen::Index;

namespace {

template <typename Value>
std::optional<Value> entry(const std::vector<Value>& values, std::size_t index) {
  return index < values.size() ? std::optional(values[index]) : std::nullopt;
}

std::string cell(const std::optional<double>& value) { return value ? four_digits(*value) : "-"; }

std::string three_digits(double value) { return std::isfinite(value) ? fmt::format("{:.3g}", value) : "-"; }

std::string interval(double lower, double upper) { return four_digits(lower) + " to " + four_digits(upper); }
/// One that may be open on either side.
std::string interval(const std::optional<double>& lower, const std::optional<double>& upper) {
  if (lower && upper) return interval(*lower, *upper);
  if (lower) return "above " + four_digits(*lower);
  return upper ? "below " + four_digits(*upper) : "not bounded";
}

std::string with_unit(const std::string& value, const std::string& unit) {
  return unit.empty() || unit == "-" ? value : value + " " + unit;
}

std::string with_unit_in_brackets(const std::string& name, const std::string& unit) {
  return unit.empty() || unit == "-" ? name : name + " [" + unit + "]";
}

std::string correlation_text(double value) { return std::isfinite(value) ? fmt::format("{:.3f}", value) : "-"; }

std::string share(double probability) {
  if (!std::isfinite(probability)) return "-";
  return probability > 0.0 && probability < 1e-4 ? fmt::format("{:.1e}", probability) : per_cent(probability);
}

std::string whole_per_cent(double share) { return fmt::format("{:.0f} %", 100.0 * share); }

std::string joined(const std::vector<std::string>& names) { return fmt::format("{}", fmt::join(names, ", ")); }

/// In a sentence.
constexpr std::size_t most_named = 4;

/// Each with its value; of many the best known.
std::string determined_words(std::vector<InferredValues> values) {
  std::ranges::stable_sort(values, {}, [](const auto& each) { return each.deviation_left().value_or(1.0); });
  std::vector<std::string> words;
  for (std::size_t i = 0; i < std::min(values.size(), most_named); ++i) {
    const auto& [mean, deviation] = std::pair(values[i].posterior->mean, values[i].posterior->deviation);
    const DisplayUnit shown(values[i].unit, {mean, deviation});
    words.push_back(values[i].name + " = " +
                    with_unit(with_deviation(shown.scaled(mean), shown.scaled(deviation)), shown.unit()));
  }
  return joined(words) + (values.size() > most_named ? ", ..." : "");
}

std::string undetermined_words(const std::vector<InferredValues>& values) {
  std::vector<std::string> words;
  for (std::size_t i = 0; i < std::min(values.size(), most_named); ++i) {
    const auto left = values[i].deviation_left();
    words.push_back(values[i].name + (left && std::isfinite(*left)
                                          ? fmt::format(" ({:.0f} % of its prior deviation is left)", 100.0 * *left)
                                          : ""));
  }
  return "The data tell little of " + joined(words) +
         (values.size() > most_named ? fmt::format(" and {} others.", values.size() - most_named) : ".");
}

/// "all 4 parameters", "1 of 4 parameters".
std::string counted(const std::vector<InferredValues>& some, const std::vector<InferredValues>& all) {
  if (some.size() < all.size()) return fmt::format("{} of {} parameters", some.size(), all.size());
  if (all.size() == 1) return "the parameter";
  return all.size() == 2 ? "both parameters" : fmt::format("all {} parameters", all.size());
}

/// "k1 = 30.1 ± 0.8 kN/m, k2 = 39.9 ± 1.1 kN/m" of one mode.
std::string mode_words(const PosteriorMode& mode, const std::vector<InferredValues>& all) {
  std::vector<std::string> words;
  for (std::size_t i = 0; i < std::min(all.size(), most_named); ++i) {
    const auto row = static_cast<Index>(i);
    const DisplayUnit shown(all[i].unit, {mode.mean[row], mode.deviation[row]});
    words.push_back(
        all[i].name + " = " +
        with_unit(with_deviation(shown.scaled(mode.mean[row]), shown.scaled(mode.deviation[row])), shown.unit()));
  }
  return joined(words) + (all.size() > most_named ? ", ..." : "");
}

/// Of several modes, between which no values fit.
std::string modes_words(const InferenceOutcome& outcome, const std::vector<InferredValues>& all) {
  std::vector<std::string> words;
  for (std::size_t k = 0; k < std::min(outcome.modes.size(), most_named); ++k)
    words.push_back(whole_per_cent(outcome.modes[k].weight) + ": " + mode_words(outcome.modes[k], all));
  return fmt::format(
      "{} separate sets of values explain the data (modes of the posterior, with their probability). {}{}. "
      "Another measurement or a narrower prior must tell them apart.",
      outcome.modes.size(), fmt::join(words, "; "), outcome.modes.size() > most_named ? "; ..." : "");
}

std::string parameter_words(const InferenceOutcome& outcome) {
  const auto all = inferred_values(outcome);
  if (all.empty()) return "";
  if (outcome.posterior.empty())
    return "There is no posterior" + (outcome.warnings.empty() ? "." : ": " + outcome.warnings.front() + ".");
  if (outcome.modes.size() > 1) return modes_words(outcome, all);
  std::vector<InferredValues> known, unknown;
  for (const auto& each : all) (each.determined() ? known : unknown).push_back(each);
  std::string text;
  if (!known.empty()) text = fmt::format("The data determine {}: {}.", counted(known, all), determined_words(known));
  if (!unknown.empty()) text += (text.empty() ? "" : " ") + undetermined_words(unknown);
  return text;
}

/// A logarithm of a probability density: differences count, so it keeps its decimals.
std::string nats(double value, double deviation = 0.0) {
  return deviation > 0.0 ? with_deviation(value, deviation) : fmt::format("{:.2f}", value);
}

}  // namespace

std::optional<double> InferredValues::z() const {
  if (!truth || !posterior || !(posterior->deviation > 0.0)) return std::nullopt;
  return (posterior->mean - *truth) / posterior->deviation;
}

std::optional<double> InferredValues::deviation_left() const {
  if (!prior || !posterior || !(prior->deviation > 0.0)) return std::nullopt;
  return posterior->deviation / prior->deviation;
}

bool InferredValues::determined() const {
  if (!posterior || !std::isfinite(posterior->mean) || !std::isfinite(posterior->deviation)) return false;
  const auto left = deviation_left();
  return !left || *left < IdentifiabilityOptions{}.weak;
}

std::vector<InferredValues> inferred_values(const InferenceOutcome& outcome) {
  std::vector<InferredValues> all(std::max(outcome.prior.size(), outcome.posterior.size()));
  for (std::size_t i = 0; i < all.size(); ++i) {
    auto& values = all[i];
    values.prior = entry(outcome.prior, i);
    values.posterior = entry(outcome.posterior, i);
    values.name = values.posterior ? values.posterior->name : values.prior->name;
    values.unit = entry(outcome.units, i).value_or("");
    if (i < outcome.truths.size()) values.truth = outcome.truths[i];
    if (const auto row = static_cast<Index>(i); row < outcome.most_probable.size())
      values.most_probable = outcome.most_probable[row];
    values.convergence = entry(outcome.convergence, i);
  }
  return all;
}

std::string with_deviation(double mean, double deviation) {
  if (!std::isfinite(mean) || !std::isfinite(deviation) || deviation <= 0.0) return four_digits(mean);
  const int place = last_place(deviation);
  const double largest = std::max(std::abs(mean), deviation);
  if (largest < 1e6 && largest >= 1e-3) return rounded_at(place, mean) + " ± " + rounded_at(place, deviation);
  const int digits = std::max(1, static_cast<int>(std::floor(std::log10(largest))) - place);
  return fmt::format("{:.{}e} ± {:.1e}", mean, std::min(digits, 15), deviation);
}

std::string inference_answer(const InferenceOutcome& outcome) {
  std::vector<std::string> sentences;
  for (auto& words : {parameter_words(outcome), law_words(outcome)})
    if (!words.empty()) sentences.push_back(words);
  if (const auto count = outcome.warnings.size(); count > 0 && !outcome.posterior.empty())
    sentences.push_back(count == 1 ? "One warning stands against the posterior."
                                   : fmt::format("{} warnings stand against the posterior.", count));
  return fmt::format("{}", fmt::join(sentences, " "));
}

std::string inference_method_words(const InferenceOutcome& outcome) {
  std::string text = outcome.method.empty() ? "Bayesian inference" : "By " + outcome.method;
  if (!outcome.likelihood.empty()) text += "; likelihood of " + outcome.likelihood;
  if (const auto count = outcome.samples.values.cols(); count > 0) text += fmt::format("; {} samples", count);
  if (const auto& worth = outcome.effective_samples; worth && std::isfinite(*worth))
    text += fmt::format(", worth {:.0f} independent ones", *worth);
  if (const auto& k = outcome.pareto_k; k && std::isfinite(*k)) text += fmt::format(", Pareto k {:.2f}", *k);
  if (const auto& evidence = outcome.log_evidence; evidence && std::isfinite(*evidence))
    text += "; ln Z = " + nats(*evidence, outcome.log_evidence_deviation.value_or(0.0));
  text += fmt::format("; {} likelihoods", outcome.evaluations);
  text += std::isfinite(outcome.seconds) ? fmt::format(", {:.1f} s.", outcome.seconds) : ".";
  if (const auto search = search_words(outcome); !search.empty()) text += " " + search;
  return text;
}

std::string search_words(const InferenceOutcome& outcome) {
  if (!outcome.prior_starts) return "";
  if (*outcome.prior_starts == 0)
    return "Other maxima were not searched for, as a likelihood takes long: method tempered finds them.";
  return fmt::format(
      "After {} searches from samples of the prior, a further maximum to which more than {} of the prior leads is "
      "excluded with 95 %.",
      *outcome.prior_starts, whole_per_cent(unseen_share(*outcome.prior_starts)));
}

std::string after_words(const InferenceOutcome& outcome) {
  const std::string where = outcome.modes.size() > 1 ? "In the heaviest mode: " : "At the posterior's mean: ";
  return where + outcome.after->text;
}

std::string filter_words(const InferenceOutcome& outcome) {
  if (outcome.beside_filter.empty()) return "";
  std::string text;
  for (const auto& each : outcome.beside_filter)
    if (!each.agrees() && std::isfinite(each.mean_difference) && std::isfinite(each.deviation_ratio))
      text += fmt::format(
          "{}{}: the filter's mean lies {:.2g} posterior deviations away, its deviation is {:.2g} times the "
          "posterior's.",
          text.empty() ? "" : " ", each.name, std::abs(each.mean_difference), each.deviation_ratio);
  const bool all_agree = std::ranges::all_of(outcome.beside_filter, &FilterComparison::agrees);
  return all_agree ? "The filter's normal distribution agrees with the posterior." : text;
}

std::string law_words(const InferenceOutcome& outcome) {
  if (!outcome.laws || outcome.laws->laws.empty()) return "";
  const auto& [connector, laws] = *outcome.laws;
  const auto& best = laws.front();
  if (!best.failure.empty() || !std::isfinite(best.log_evidence))
    return fmt::format("No law of '{}' has an evidence.", connector);
  std::string text = fmt::format("Of {} laws for '{}', {} is the most probable ({}).", laws.size(), connector,
                                 best.name, share(best.probability));
  if (laws.size() > 1 && laws[1].failure.empty() && !laws[1].words.empty())
    text += fmt::format(" The evidence against the next one, {}, is {}.", laws[1].name, laws[1].words);
  return text;
}

std::vector<std::string> inference_warnings(const InferenceOutcome& outcome) {
  std::vector<std::string> all = outcome.warnings;
  if (outcome.laws)
    for (const auto& law : outcome.laws->laws)
      for (const auto& warning : law.warnings) all.push_back("law " + law.name + ": " + warning);
  return all;
}

Table posterior_table(const InferenceOutcome& outcome) {
  Table table{"Posterior",
              {"parameter", "prior", "posterior", "95 % interval", "std / prior std", "truth", "error / std"},
              {},
              {}};
  for (const auto& values : inferred_values(outcome)) {
    const auto& [name, unit, prior, posterior, truth, most_probable, convergence] = values;
    const auto left = values.deviation_left(), z = values.z();
    const DisplayUnit shown(unit, {posterior ? posterior->mean : 0.0, prior ? prior->mean : 0.0});
    const auto with_its_deviation = [&](const std::optional<ParameterSummary>& of) {
      return of ? with_deviation(shown.scaled(of->mean), shown.scaled(of->deviation)) : "-";
    };
    table.rows.push_back(
        {with_unit_in_brackets(name, shown.unit()), with_its_deviation(prior), with_its_deviation(posterior),
         posterior ? interval(shown.scaled(posterior->q2_5), shown.scaled(posterior->q97_5)) : "-",
         left && std::isfinite(*left) ? fmt::format("{:.1f} %", 100.0 * *left) : "-", truth ? shown.value(*truth) : "-",
         z && std::isfinite(*z) ? fmt::format("{:+.2f}", *z) : "-"});
  }
  return without_empty_columns(std::move(table));
}

Table mode_table(const InferenceOutcome& outcome) {
  Table table{"Modes of the posterior", {"parameter"}, {}, {}};
  if (outcome.modes.size() < 2) return table;
  for (const auto& mode : outcome.modes) table.columns.push_back(whole_per_cent(mode.weight));
  const auto all = inferred_values(outcome);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const auto row = static_cast<Index>(i);
    const DisplayUnit shown(all[i].unit, {outcome.modes.front().mean[row], outcome.modes.back().mean[row]});
    table.rows.push_back({with_unit_in_brackets(all[i].name, shown.unit())});
    for (const auto& mode : outcome.modes)
      table.rows.back().push_back(with_deviation(shown.scaled(mode.mean[row]), shown.scaled(mode.deviation[row])));
  }
  return table;
}

Table convergence_table(const InferenceOutcome& outcome) {
  Table table{"Convergence of the chains", {"parameter", "R-hat", "bulk ESS", "tail ESS"}, {}, {}};
  for (const auto& values : inferred_values(outcome))
    if (const auto& found = values.convergence)
      table.rows.push_back({values.name, std::isfinite(found->r_hat) ? fmt::format("{:.4f}", found->r_hat) : "stuck",
                            four_digits(found->bulk_ess), four_digits(found->tail_ess)});
  return table;
}

Table posterior_correlation_table(const InferenceOutcome& outcome) {
  Table table{"Correlation in the posterior", {"parameter"}, {}, {}};
  const auto size = static_cast<Index>(outcome.posterior.size());
  if (size < 2 || outcome.correlation.rows() != size || outcome.correlation.cols() != size) return table;
  for (Index i = 0; i < size; ++i) {
    const auto& name = outcome.posterior[static_cast<std::size_t>(i)].name;
    table.columns.push_back(name);
    table.rows.push_back({name});
    for (Index j = 0; j < size; ++j) table.rows.back().push_back(correlation_text(outcome.correlation(i, j)));
  }
  return table;
}

Table identifiability_table(const InferenceOutcome& outcome) {
  Table table{"Standard deviations: Cramer-Rao bounds of the record alone, and the posterior's",
              {"parameter", "bound before", "bound after", "posterior"},
              {},
              {}};
  if (!outcome.before && !outcome.after) return table;
  const auto bound = [](const std::optional<Identifiability>& judged, std::size_t i) -> std::string {
    if (!judged || static_cast<Index>(i) >= judged->cramer_rao.size()) return "-";
    const double value = judged->cramer_rao[static_cast<Index>(i)];
    return std::isfinite(value) ? four_digits(value) : "not determined";
  };
  const auto all = inferred_values(outcome);
  for (std::size_t i = 0; i < all.size(); ++i)
    table.rows.push_back({with_unit_in_brackets(all[i].name, all[i].unit), bound(outcome.before, i),
                          bound(outcome.after, i), all[i].posterior ? four_digits(all[i].posterior->deviation) : "-"});
  return without_empty_columns(std::move(table));
}

Table filter_table(const InferenceOutcome& outcome) {
  Table table{"Posterior beside the filter's normal distribution",
              {"parameter", "filter", "posterior", "difference / std", "std of filter / posterior", "agrees"},
              {},
              {}};
  const auto all = inferred_values(outcome);
  for (const auto& each : outcome.beside_filter) {
    const auto found = std::ranges::find(all, each.name, &InferredValues::name);
    const bool known = found != all.end() && found->posterior;
    table.rows.push_back({each.name, with_deviation(each.filter_mean, each.filter_deviation),
                          known ? with_deviation(found->posterior->mean, found->posterior->deviation) : "-",
                          three_digits(each.mean_difference), three_digits(each.deviation_ratio),
                          each.agrees() ? "yes" : "no"});
  }
  return table;
}

Table profile_table(const InferenceOutcome& outcome) {
  Table table{"95 % intervals of the profile likelihood", {"parameter", "interval", "posterior's"}, {}, {}};
  const auto all = inferred_values(outcome);
  for (const auto& profile : outcome.profiles) {
    const auto found = std::ranges::find(all, profile.name, &InferredValues::name);
    table.rows.push_back(
        {with_unit_in_brackets(profile.name, profile.unit), interval(profile.lower, profile.upper),
         found != all.end() && found->posterior ? interval(found->posterior->q2_5, found->posterior->q97_5) : "-"});
  }
  return table;
}

Table coverage_table(const InferenceOutcome& outcome) {
  Table table{"Responses at draws of the posterior", {"sensor", "measured in the 95 % band"}, {}, {}};
  for (const auto& band : outcome.bands) table.rows.push_back({band.sensor, per_cent(band.coverage)});
  return table;
}

Table law_table(const LawRanking& ranking) {
  Table table{"Laws of '" + ranking.connector + "'",
              {"law", "unknowns", "ln Z", "probability", "Occam's cost", "largest ln p", "evidence against it",
               "validation ln p", "one step", "open loop"},
              {},
              {}};
  for (const auto& law : ranking.laws) {
    std::vector<std::string> row{law.name == law.law ? law.name : fmt::format("{} ({})", law.name, law.law)};
    if (law.failure.empty())
      row.insert(row.end(), {std::to_string(law.parameters), nats(law.log_evidence, law.log_evidence_deviation),
                             share(law.probability), nats(-law.occam), nats(law.log_likelihood),
                             law.words.empty() ? "-" : law.words, cell(law.validation), cell(law.validation_one_step),
                             cell(law.validation_open_loop)});
    else
      row.insert(row.end(), {"-", "-", "-", "-", "-", "not known: " + law.failure, "-", "-", "-"});
    table.rows.push_back(std::move(row));
  }
  return without_empty_columns(std::move(table));
}

Table sobol_table(const InferenceOutcome& outcome, const OutputSensitivity& sensitivity) {
  const auto& [output, unit, indices] = sensitivity;
  Table table{"Sobol' indices of " + with_unit_in_brackets(output, unit),
              {"parameter", "first order", "95 % bounds", "total", "95 % bounds"},
              {},
              {}};
  const auto all = inferred_values(outcome);
  std::vector<std::size_t> order(std::min({all.size(), indices.first.size(), indices.total.size()}));
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, std::greater(), [&](std::size_t i) {
    const double total = indices.total[i].value;
    return std::isfinite(total) ? total : -1.0;
  });
  const auto value = [](double index) { return std::isfinite(index) ? fmt::format("{:.3f}", index) : "-"; };
  const auto bounds = [&](const SobolIndex& index) { return value(index.lower) + " to " + value(index.upper); };
  for (const auto i : order)
    table.rows.push_back({all[i].name, value(indices.first[i].value), bounds(indices.first[i]),
                          value(indices.total[i].value), bounds(indices.total[i])});
  return table;
}

}  // namespace kalfem
