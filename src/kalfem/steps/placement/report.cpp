// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/placement/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "kalfem/base/text.hpp"
#include "kalfem/page/json_number.hpp"
#include "kalfem/page/words.hpp"
#include "kalfem/pictures/mesh_picture.hpp"
#include "kalfem/steps/placement/outcome.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;
using Json = nlohmann::ordered_json;

namespace {

/// From the best candidate to the worst; people who cannot tell red from green tell these apart.
const std::vector<std::string> rank_colours = {"#d7191c", "#f07c4a", "#fec981", "#c4e0ee", "#7fb6d6", "#2c7bb6"};

std::string to_string(PlacementCriterion criterion) {
  switch (criterion) {
    case PlacementCriterion::d_optimality:
      return "determinant";
    case PlacementCriterion::a_optimality:
      return "trace";
    case PlacementCriterion::e_optimality:
      return "smallest_eigenvalue";
    case PlacementCriterion::expected_deviation:
      return "deviation";
    case PlacementCriterion::mutual_information:
      return "information";
  }
  return "";
}

std::vector<std::string> names_of(const PlacementOutcome& outcome, const PlacedSet& set) {
  std::vector<std::string> names;
  for (const auto i : set.candidates) names.push_back(outcome.candidates[i].name);
  return names;
}

std::string listed(const PlacementOutcome& outcome, const PlacedSet& set) {
  return fmt::format("{}", fmt::join(names_of(outcome, set), ", "));
}

/// Counted from 1; null for none.
Json rank_json(const std::optional<std::size_t>& rank) { return rank ? Json(*rank + 1) : Json(nullptr); }
std::string rank_text(const std::optional<std::size_t>& rank) { return rank ? std::to_string(*rank + 1) : "-"; }

Json by_parameter(const PlacementOutcome& outcome, const VectorXd& deviation) {
  Json json = Json::object();
  for (std::size_t i = 0; i < outcome.parameters.size(); ++i)
    json[outcome.parameters[i]] = deviation.size() > 0 ? number(deviation[static_cast<Index>(i)]) : Json(nullptr);
  return json;
}

Json set_json(const PlacementOutcome& outcome, const PlacedSet& set) {
  return {{"sensors", names_of(outcome, set)},
          {"criterion", number(set.criterion)},
          {"deviations", by_parameter(outcome, set.bound)}};
}

/// Root mean square of the deviations over those of the prior.
double left_of(const PlacementOutcome& outcome, const PlacedSet& set) {
  return std::sqrt((set.bound.array() / outcome.prior.array()).square().mean());
}

/// With zeros at the end, so that columns show how many digits count.
std::string digits(double value, int count) {
  if (!std::isfinite(value)) return "-";
  std::string text = fmt::format("{:#.{}g}", value, count);
  if (text.ends_with('.')) text.pop_back();
  return text;
}
std::string three_digits(double value) { return digits(value, 3); }

std::string with_unit(double value, const std::string& unit) {
  return three_digits(value) + (unit.empty() || unit == "-" ? "" : " " + unit);
}

std::string deviations_in_words(const PlacementOutcome& outcome, const PlacedSet& set) {
  constexpr std::size_t most = 4;
  std::string words;
  for (std::size_t i = 0; i < std::min(outcome.parameters.size(), most); ++i)
    words += (i == 0 ? "" : ", ") + outcome.parameters[i] + " " +
             with_unit(set.bound[static_cast<Index>(i)], outcome.units[i]);
  return words + (outcome.parameters.size() > most ? ", ..." : "");
}

std::vector<std::string> headings(const PlacementOutcome& outcome, std::vector<std::string> first) {
  for (std::size_t i = 0; i < outcome.parameters.size(); ++i)
    first.push_back(outcome.parameters[i] + (outcome.units[i] == "-" ? "" : " [" + outcome.units[i] + "]"));
  return first;
}

Table sets_table(const PlacementOutcome& outcome, std::size_t most) {
  Table table{"Best sets: expected standard deviations", headings(outcome, {"rank", "sensors", "criterion"}), {}, {}};
  const auto add = [&](const PlacedSet& set, const std::string& rank) {
    std::vector<std::string> row{rank, listed(outcome, set), digits(set.criterion, 5)};
    for (const double deviation : set.bound) row.push_back(three_digits(deviation));
    table.rows.push_back(std::move(row));
  };
  for (std::size_t i = 0; i < std::min(outcome.best.size(), most); ++i)
    add(outcome.best[i], rank_text(outcome.best[i].rank));
  if (outcome.own) add(*outcome.own, rank_text(outcome.own->rank) + ", own");
  return table;
}

Table candidates_table(const PlacementOutcome& outcome, std::size_t most) {
  std::vector<const CandidateRank*> order;
  for (const auto& candidate : outcome.candidates)
    if (candidate.rank) order.push_back(&candidate);
  std::ranges::sort(order, {}, [](const CandidateRank* candidate) { return *candidate->rank; });
  const auto& best = outcome.placement.best().candidates;
  Table table{
      "Candidates alone", {"rank", "candidate", "criterion", "deviation left of the prior's", "chosen"}, {}, {}};
  for (std::size_t i = 0; i < std::min(order.size(), most); ++i) {
    const auto& candidate = *order[i];
    const auto index = static_cast<std::size_t>(&candidate - outcome.candidates.data());
    table.rows.push_back({rank_text(candidate.rank), candidate.name, digits(candidate.criterion, 5),
                          candidate.moves ? per_cent(candidate.left) : "tells nothing",
                          std::ranges::find(best, index) != best.end() ? "yes" : ""});
  }
  return table;
}

Table filter_table(const PlacementOutcome& outcome) {
  Table table{"Standard deviations: bound, and a run of the filter over the expected record",
              headings(outcome, {"rank", "sensors"}),
              {},
              {}};
  for (const auto& [set, filter] : outcome.checked) {
    std::vector<std::string> row{rank_text(set.rank), listed(outcome, set)};
    for (Index i = 0; i < set.bound.size(); ++i)
      row.push_back(three_digits(set.bound[i]) + " / " + (filter.size() > 0 ? three_digits(filter[i]) : "failed"));
    table.rows.push_back(std::move(row));
  }
  return table;
}

/// Of the case's own sensors against the best set.
std::string own_in_words(const PlacementOutcome& outcome) {
  if (!outcome.own) return "";
  const double ratio = left_of(outcome, *outcome.own) / left_of(outcome, outcome.best.front());
  std::string rank;
  if (outcome.own->rank)
    rank = fmt::format(" have rank {}{}; their deviations are", *outcome.own->rank + 1,
                       outcome.placement.exact ? fmt::format(" of {:.0f}", outcome.placement.tried)
                                               : " among the sets that were tried last");
  else
    rank = outcome.own->candidates.size() == outcome.placement.best().candidates.size()
               ? " are not among the ranked sets; their deviations are"
               : fmt::format(", {} in number, leave deviations", outcome.own->candidates.size());
  return fmt::format("The case's own sensors ({}){} {:.3g} times as large as those of the best set.",
                     listed(outcome, *outcome.own), rank, ratio);
}

std::string averaged_words(const PlacementOutcome& outcome) {
  return outcome.draws > 1
             ? fmt::format(" Criterion and deviations are means over {} draws from the priors.", outcome.draws)
             : "";
}

std::string colour_of(const PlacementOutcome& outcome, std::size_t rank) {
  const auto ranked = static_cast<double>(
      std::ranges::count_if(outcome.candidates, [](const auto& each) { return each.rank.has_value(); }));
  const double part = ranked > 1.0 ? static_cast<double>(rank) / (ranked - 1.0) : 0.0;
  const auto last = static_cast<double>(rank_colours.size() - 1);
  return rank_colours[static_cast<std::size_t>(std::lround(part * last))];
}

bool is_chosen(const PlacementOutcome& outcome, std::size_t candidate) {
  const auto& best = outcome.placement.best().candidates;
  return std::ranges::find(best, candidate) != best.end();
}

/// A candidate without its substructure: "p5.z".
std::string short_name(const std::string& name) {
  const auto dot = name.find('.');
  return dot == std::string::npos ? name : name.substr(dot + 1);
}

/// One mark a node, in the colour of the best candidate there; the chosen ones first, so that they get their labels.
std::vector<PictureMark> marks_on(const std::string& substructure, const Study& study,
                                  const PlacementOutcome& outcome) {
  std::map<Index, std::size_t> best;  // candidate of each node
  std::map<Index, std::vector<std::string>> chosen;
  const auto& places = study.placement->places;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (places[i].substructure != substructure || !places[i].node) continue;
    const Index node = *places[i].node;
    const auto& candidate = outcome.candidates[i];
    if (is_chosen(outcome, i))
      chosen[node].push_back(candidate.rank ? fmt::format("{}: {}", *candidate.rank + 1, short_name(candidate.name))
                                            : candidate.name + " (stays)");
    const auto [at, is_new] = best.try_emplace(node, i);
    const auto& other = outcome.candidates[at->second];
    if (!is_new && candidate.rank && (!other.rank || *candidate.rank < *other.rank)) at->second = i;
  }
  std::vector<PictureMark> marks;
  const auto colour = [&](std::size_t candidate) {
    const auto& rank = outcome.candidates[candidate].rank;
    return rank ? colour_of(outcome, *rank) : std::string("#3a424b");
  };
  for (const auto& [node, names] : chosen)
    marks.push_back({MarkKind::chosen, node, fmt::format("{}", fmt::join(names, ", ")), colour(best[node])});
  std::vector<std::pair<std::size_t, Index>> others;
  for (const auto& [node, candidate] : best)
    if (!chosen.contains(node) && outcome.candidates[candidate].rank)
      others.emplace_back(*outcome.candidates[candidate].rank, node);
  std::ranges::sort(others);
  constexpr std::size_t most_numbers = 40;
  for (std::size_t i = 0; i < others.size(); ++i) {
    const auto [rank, node] = others[i];
    const std::string number = i < most_numbers ? std::to_string(rank + 1) : "";
    marks.push_back({MarkKind::candidate, node, number, colour_of(outcome, rank)});
  }
  return marks;
}

/// Whether the mesh has places to draw; matrices of another code may have none.
bool has_places(const FiniteElementPart& part) { return !part.elements.mesh.nodes.isZero(0.0); }

/// Bars of candidates in the order of the case, as long as the deviations that each leaves alone.
class BarPicture {
public:
  BarPicture(const PlacementOutcome& outcome, std::vector<std::size_t> candidates)
      : outcome_(outcome), candidates_(std::move(candidates)) {
    for (const auto i : candidates_) {
      longest_name_ = std::max(longest_name_, outcome_.candidates[i].name.size());
      largest_ = std::max(largest_, outcome_.candidates[i].left);
    }
  }

  [[nodiscard]] std::string svg() const {
    const double first = 36.0 + 8.2 * static_cast<double>(longest_name_),
                 height = row * static_cast<double>(candidates_.size());
    std::string out = fmt::format(
        "<svg class=\"placement-bars\" xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.0f} {1:.0f}\" "
        "width=\"{0:.0f}\" height=\"{1:.0f}\" role=\"img\" aria-label=\"Candidates alone\" font-family=\"system-ui, "
        "sans-serif\" font-size=\"13\">\n<style>.placement-bars{{color:#1b2129;max-width:100%;height:auto}}@media "
        "screen and (prefers-color-scheme:dark){{.placement-bars{{color:#e6eaee}}}}.placement-bars "
        "text{{fill:currentColor}}</style>\n",
        first + longest + 190.0, height + 16.0);
    double y = 8.0;
    for (const auto i : candidates_) {
      draw(i, first, y, out);
      y += row;
    }
    return out + "</svg>\n";
  }

private:
  static constexpr double row = 22.0, longest = 420.0;

  void draw(std::size_t index, double first, double y, std::string& out) const {
    const auto& candidate = outcome_.candidates[index];
    const bool chosen = is_chosen(outcome_, index);
    const double length = std::max(1.0, longest * candidate.left / largest_), middle = y + 0.5 * row;
    const std::string weight = chosen ? " font-weight=\"700\"" : "";
    if (chosen) out += fmt::format("<circle cx=\"9\" cy=\"{:.1f}\" r=\"4.5\" fill=\"currentColor\"/>\n", middle);
    out += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"end\"{}>{}</text>\n", first - 8.0, middle + 4.5,
                       weight, escaped(candidate.name));
    const std::string colour = candidate.rank ? colour_of(outcome_, *candidate.rank) : "#3a424b";
    out += fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" rx=\"2\" fill=\"{}\"{}/>\n",
                       first, y + 3.5, length, row - 7.0, colour,
                       chosen ? " stroke=\"currentColor\" stroke-width=\"2\"" : "");
    const std::string words = !candidate.moves ? "tells nothing" : per_cent(candidate.left);
    out += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\"{}>{}</text>\n", first + length + 8.0, middle + 4.5, weight,
                       escaped(candidate.kept ? "stays" : rank_text(candidate.rank) + ": " + words));
  }

  const PlacementOutcome& outcome_;
  std::vector<std::size_t> candidates_;
  std::size_t longest_name_ = 0;
  double largest_ = 1e-300;
};

/// In the order of the case; of many the best, and the chosen ones.
std::vector<std::size_t> shown_as_bars(const PlacementOutcome& outcome, std::vector<std::size_t> candidates) {
  constexpr std::size_t most = 60;
  if (candidates.size() <= most) return candidates;
  std::ranges::stable_sort(candidates, {}, [&](std::size_t i) {
    return is_chosen(outcome, i) ? 0 : outcome.candidates[i].rank.value_or(0) + 1;
  });
  candidates.resize(most);
  std::ranges::sort(candidates);
  return candidates;
}

void add_pictures(const Study& study, const PlacementOutcome& outcome, Section& section) {
  std::set<std::string> drawn;
  for (const auto& elements : study.structure->finite_elements) {
    if (!has_places(*elements.part)) continue;
    auto marks = marks_on(elements.part->name, study, outcome);
    if (marks.empty()) continue;
    drawn.insert(elements.part->name);
    section.items.emplace_back(Picture{
        .title = "Candidates on " + elements.part->name,
        .caption = "Colour and number: rank of the best candidate at the node, alone; the best ones are numbered. With "
                   "a rim: the best set, each "
                   "with its rank alone and its direction. Faint: behind the surface.",
        .svg = mesh_picture_svg(elements.part->elements.mesh,
                                {.marks = std::move(marks), .plain = true, .candidate_colours = rank_colours})});
  }
  std::vector<std::size_t> others;
  for (std::size_t i = 0; i < outcome.candidates.size(); ++i) {
    const auto& place = study.placement->places[i];
    if (!place.node || !drawn.contains(place.substructure)) others.push_back(i);
  }
  if (others.empty()) return;
  const auto shown = shown_as_bars(outcome, others);
  section.items.emplace_back(Picture{
      .title = "Candidates alone",
      .caption = std::string("Length: standard deviations that the candidate leaves, in per cent of the prior's "
                             "(root mean square over the parameters); shorter is better. Number and colour: "
                             "rank. With a dot and a rim: the best set.") +
                 (shown.size() < others.size() ? " Only the best and the chosen ones are drawn." : ""),
      .svg = BarPicture(outcome, shown).svg()});
}

}  // namespace

Json placement_summary(const PlacementOutcome& outcome) {
  Json summary = {{"criterion", to_string(outcome.criterion)}, {"remarks", outcome.remarks}};
  if (!outcome.failure.empty()) {
    summary["failure"] = outcome.failure;
    return summary;
  }
  summary["count"] = outcome.placement.best().candidates.size();
  summary["exact"] = outcome.placement.exact;
  summary["tried"] = static_cast<std::uint64_t>(outcome.placement.tried);
  summary["draws"] = outcome.draws;
  summary["sets"] = Json::array();
  for (const auto& set : outcome.best) summary["sets"].push_back(set_json(outcome, set));
  for (const auto& candidate : outcome.candidates)
    summary["candidates"][candidate.name] = {
        {"rank", rank_json(candidate.rank)}, {"criterion", number(candidate.criterion)}, {"stays", candidate.kept}};
  summary["own_set"] = nullptr;
  if (outcome.own) {
    summary["own_set"] = {{"rank", rank_json(outcome.own->rank)}};
    summary["own_set"].update(set_json(outcome, *outcome.own));
  }
  summary["filter"] = Json::array();
  for (const auto& [set, filter] : outcome.checked)
    summary["filter"].push_back({{"rank", rank_json(set.rank)},
                                 {"sensors", names_of(outcome, set)},
                                 {"bound", by_parameter(outcome, set.bound)},
                                 {"filter", by_parameter(outcome, filter)}});
  summary["seconds"] = number(outcome.seconds);
  return summary;
}

std::string placement_answer(const PlacementOutcome& outcome) {
  if (!outcome.failure.empty()) return "No sensors placed: " + outcome.failure + ".";
  const auto& best = outcome.best.front();
  const std::string sensors =
      fmt::format("{} sensor{}", best.candidates.size(), best.candidates.size() == 1 ? "" : "s");
  const std::string found =
      outcome.placement.exact
          ? fmt::format("Best of all {:.0f} sets of {}", outcome.placement.tried, sensors)
          : fmt::format("Best set of {} that {:.0f} trials found, not all sets", sensors, outcome.placement.tried);
  return fmt::format("{}: {}. Expected standard deviations: {}.", found, listed(outcome, best),
                     deviations_in_words(outcome, best));
}

std::string console_placement(const PlacementOutcome& outcome) {
  constexpr std::size_t most_sets = 10, most_candidates = 20;
  std::string text = placement_answer(outcome) + averaged_words(outcome) + "\n";
  if (const auto words = own_in_words(outcome); !words.empty()) text += words + "\n";
  for (const auto& remark : outcome.remarks) text += remark + "\n";
  if (!outcome.failure.empty()) return text + "\n";
  for (const auto& table :
       {sets_table(outcome, most_sets), candidates_table(outcome, most_candidates), filter_table(outcome)})
    text += "\n" + table.title + "\n" + to_text(table);
  return text + fmt::format("\n{} candidates, {:.0f} sets tried, {:.1f} s\n\n", outcome.candidates.size(),
                            outcome.placement.tried, outcome.seconds);
}

Section placement_section(const Study& study, const PlacementOutcome& outcome) {
  constexpr std::size_t most_candidates = 50;
  Section section{"Sensor placement", placement_answer(outcome) + averaged_words(outcome), {}};
  if (const auto words = own_in_words(outcome); !words.empty()) section.text += "\n\n" + words;
  for (const auto& remark : outcome.remarks) section.text += "\n\n" + remark;
  if (!outcome.failure.empty()) return section;
  section.items.emplace_back(sets_table(outcome, outcome.best.size()));
  add_pictures(study, outcome, section);
  section.items.emplace_back(candidates_table(outcome, most_candidates));
  section.items.emplace_back(filter_table(outcome));
  return section;
}

}  // namespace kalfem
