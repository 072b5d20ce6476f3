// SPDX-License-Identifier: Apache-2.0
#include "kalfem/study/placement_plan.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "kalfem/identification/expected_record.hpp"
#include "kalfem/identification/filter_run.hpp"
#include "kalfem/identification/stated_unknowns.hpp"
#include "kalfem/identification/unknown_prior.hpp"
#include "kalfem/study/candidate_nodes.hpp"
#include "kalfem/study/case_study.hpp"
#include "kalfem/study/stated_prior.hpp"
#include "kalfem/yaml/bounds.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
namespace d = description;

constexpr std::array along = {".x", ".y", ".z"};
constexpr std::array quantity_words = {"displacement", "velocity", "acceleration"};

/// A quantity at a point: what one channel measures.
using Measured = std::pair<ObservedQuantity, std::string>;

/// Reads the groups of candidates one place after the other. A place is `all`, a point, a node, or a region of a mesh;
/// it gives one or more stands, each a name with the points of its channels. What is named twice is refused; what a
/// region or `all` gives again is left out, and so is what a sensor that stays measures already.
class CandidateReader {
public:
  CandidateReader(const CaseStudy& study, PlacementPlan& plan, IssueList& issues)
      : study_(study), plan_(plan), issues_(issues) {
    const auto grounds = ground_names(study.structure->parts);
    grounds_ = {grounds.begin(), grounds.end()};
    const auto points = study.model->point_names(), shown = study.model->reported_points();
    points_ = {points.begin(), points.end()};
    for (const auto& point : shown)
      if (!grounds_.contains(point) && !is_rotation(point)) reported_.push_back(point);
  }

  void read() {
    for (const auto& name : study_.given.place->value.keep) keep(name);
    for (const auto& [name, group] : study_.given.place->value.candidates) read_group(group);
    name_clearly();
    set_own();
  }

private:
  /// A place of a sensor: its name and the points of its channels.
  struct Stand {
    std::string name;
    std::vector<std::string> points;
  };

  /// Whether a point is a rotation of a finite-element node, which no accelerometer measures.
  [[nodiscard]] bool is_rotation(const std::string& point) const {
    const auto dot = point.rfind('.');
    return part_of(point) && direction_index(point.substr(dot + 1)) >= 3;
  }

  [[nodiscard]] const FiniteElementPart* part_of(const std::string& place) const {
    for (const auto& elements : study_.structure->finite_elements)
      if (place.starts_with(elements.part->name + ".")) return elements.part.get();
    return nullptr;
  }

  void keep(const Name& name) {
    const auto& sensors = study_.sensors;
    std::vector<std::string> names;
    for (const auto& sensor : sensors) names.push_back(sensor.name);
    const auto found = std::ranges::find(sensors, name.value, &Sensor::name);
    if (found == sensors.end()) {
      issues_.add(name.location,
                  name.path + ": there is no sensor '" + name.value + "'" + did_you_mean(name.value, names),
                  "sensors of the case stay in any set", "name one of the `sensors`");
      return;
    }
    if (std::ranges::find(plan_.options.fixed, name.value) != plan_.options.fixed.end()) {
      issues_.add(name.location, name.path + ": the sensor '" + name.value + "' is named twice", "", "name it once");
      return;
    }
    if (!(found->noise > 0.0))
      issues_.add(name.location, name.path + ": the sensor '" + name.value + "' has no noise",
                  "information is relative to the noise", "give it a `noise` > 0 under `sensors`");
    plan_.options.fixed.push_back(name.value);
    plan_.candidates.push_back({name.value, {*found}});
    plan_.places.push_back(place_of(found->output.points.begin()->first));
    if (found->output.points.size() == 1) taken_.insert({found->output.quantity, found->output.points.begin()->first});
  }

  void read_group(const Located<d::CandidateGroup>& group) {
    const auto& given = group.value;
    const auto quantity = std::visit([](const auto& observed) { return observed.quantity; }, given.observed);
    const auto& places =
        std::visit([](const auto& observed) -> const std::vector<Name>& { return observed.points; }, given.observed);
    Sensor channel{.output = {.quantity = quantity}, .unit = unit_of(quantity), .location = group.location};
    try {
      set_noise(given, channel);
    } catch (const InvalidInput& error) {
      issues_.add(error, given.noise.location);
    }
    for (const auto& place : places) {
      bool several = true;
      for (const auto& stand : stands_of(place, given, several)) add(stand, channel, place, !several);
    }
  }

  static void set_noise(const d::CandidateGroup& given, Sensor& channel) {
    channel.relative_noise = !given.noise.value.bare && given.noise.value.dimension == Dimension{};
    channel.noise = channel.relative_noise ? given.noise.value.value : checked_number(given.noise, channel.unit);
    if (!(channel.noise > 0.0))
      throw InvalidInput(given.noise.issue(
          "the noise is " + (channel.relative_noise ? shortest(100.0 * channel.noise) + " %" : shortest(channel.noise)),
          "information is relative to the noise, which must be > 0", "give the sensor's standard deviation"));
  }

  /// `several`: the place stands for all that there is, so that it may give again what was named before.
  std::vector<Stand> stands_of(const Name& place, const d::CandidateGroup& given, bool& several) {
    if (place.value == "all") return stands_of_all(given.triaxial);
    if (const auto* part = part_of(place.value))
      if (const auto nodes = candidate_nodes(*part, place.value.substr(part->name.size() + 1), given.spacing)) {
        several = nodes->of_region;
        return stands_of_nodes(place, *part, *nodes, given.triaxial);
      }
    several = false;
    if (grounds_.contains(place.value))
      issues_.add(place.location, place.path + ": '" + place.value + "' is a ground",
                  "its motion is given by the excitation, so a sensor there tells nothing",
                  "name a point that is free");
    else if (points_.contains(place.value))
      return one_point(place, given.triaxial);
    else if (auto stands = directions_of(place.value, {0, 1, 2}, given.triaxial); !stands.empty())
      return stands;
    else
      refuse_unknown(place);
    return {};
  }

  std::vector<Stand> one_point(const Name& place, bool triaxial) {
    if (triaxial)
      issues_.add(place.location, place.path + ": '" + place.value + "' is one direction",
                  "triaxial: true makes the directions x, y and z of a node one sensor",
                  "name a node without a direction, or put this point into a group of its own");
    return {{place.value, {place.value}}};
  }

  std::vector<Stand> stands_of_nodes(const Name& place, const FiniteElementPart& part, const CandidateNodes& found,
                                     bool triaxial) {
    std::vector<Stand> stands;
    if (triaxial && found.directions.size() == 1) return one_point(place, true);
    for (const auto node : found.nodes)
      for (auto& stand : directions_of(part.name + "." + name_of_node(part, node), found.directions, triaxial))
        stands.push_back(std::move(stand));
    if (stands.empty())
      issues_.add(place.location, place.path + ": '" + place.value + "' cannot move",
                  "it is held, or has no element, spring or mass", "name a place that is free");
    return stands;
  }

  /// The motions of a node along these directions that exist: one stand each, or all of them in one.
  [[nodiscard]] std::vector<Stand> directions_of(const std::string& node, const std::vector<int>& directions,
                                                 bool together) const {
    std::vector<std::string> points;
    for (const int direction : directions) {
      const std::string point = node + "." + direction_names[static_cast<std::size_t>(direction)];
      if (points_.contains(point)) points.push_back(point);
    }
    if (together && !points.empty()) return {{node, points}};
    std::vector<Stand> stands;
    for (const auto& point : points) stands.push_back({point, {point}});
    return stands;
  }

  [[nodiscard]] std::vector<Stand> stands_of_all(bool triaxial) const {
    std::vector<Stand> stands;
    for (const auto& point : reported_) {
      const auto end = std::ranges::find_if(along, [&](const char* direction) { return point.ends_with(direction); });
      const std::string node = end == along.end() ? "" : point.substr(0, point.rfind('.'));
      if (!triaxial || node.empty() || node.find('.') == std::string::npos)
        stands.push_back({point, {point}});
      else if (std::ranges::find(stands, node, &Stand::name) == stands.end())
        stands.push_back(directions_of(node, {0, 1, 2}, true).front());
    }
    return stands;
  }

  void refuse_unknown(const Name& place) {
    std::vector<std::string> known = reported_;
    for (const auto& elements : study_.structure->finite_elements) {
      for (const auto& node : elements.part->nodes) known.push_back(elements.part->name + "." + node.name);
      for (const auto& [region, cells] : elements.part->elements.mesh.regions)
        known.push_back(elements.part->name + "." + region);
    }
    issues_.add(place.location,
                place.path + ": there is no point or node '" + place.value + "'" + did_you_mean(place.value, known),
                "write points as substructure.name", "name a point, a node or a region of a mesh, or write `all`");
  }

  void add(const Stand& stand, const Sensor& like, const Name& given, bool named) {
    const auto is_taken = [&](const std::string& point) { return taken_.contains({like.output.quantity, point}); };
    if (std::ranges::any_of(stand.points, is_taken)) {
      if (named && std::ranges::any_of(stand.points, [&](const std::string& point) {
            return candidates_.contains({like.output.quantity, point});
          }))
        issues_.add(given.location, given.path + ": the candidate '" + stand.name + "' is given twice",
                    "one sensor can stand at a place", "name it once");
      if (std::ranges::all_of(stand.points, is_taken) || named) return;
    }
    CandidateSensor candidate{stand.name, {}};
    for (const auto& point : stand.points) {
      taken_.insert({like.output.quantity, point});
      candidates_.insert({like.output.quantity, point});
      candidate.channels.push_back(like);
      candidate.channels.back().name = candidate.channels.back().output.name = point;
      candidate.channels.back().output.points = {{point, 1.0}};
    }
    plan_.candidates.push_back(std::move(candidate));
    plan_.places.push_back(place_of(stand.points.front()));
  }

  [[nodiscard]] CandidatePlace place_of(const std::string& point) const {
    CandidatePlace place{.substructure = point.substr(0, point.find('.'))};
    if (const auto* part = part_of(point))
      if (const auto nodes = candidate_nodes(*part, point.substr(part->name.size() + 1), 0.0))
        if (!nodes->nodes.empty()) place.node = nodes->nodes.front();
    return place;
  }

  /// Adds the quantity to the names of candidates where it does not follow from the point, or where a sensor that stays
  /// has that name.
  void name_clearly() {
    std::map<std::string, std::set<ObservedQuantity>> quantities;
    for (const auto& [quantity, point] : candidates_) quantities[point].insert(quantity);
    const auto& kept = plan_.options.fixed;
    const auto is_kept = [&](const std::string& name) { return std::ranges::find(kept, name) != kept.end(); };
    for (std::size_t i = kept.size(); i < plan_.candidates.size(); ++i) {
      auto& [name, channels] = plan_.candidates[i];
      const bool unclear = is_kept(name) || std::ranges::any_of(channels, [&](const Sensor& channel) {
                             return quantities[channel.name].size() > 1 || is_kept(channel.name);
                           });
      if (!unclear) continue;
      const std::string word =
          std::string(" ") + quantity_words[static_cast<std::size_t>(channels.front().output.quantity)];
      name += word;
      for (auto& channel : channels) channel.name = channel.output.name = channel.name + word;
    }
  }

  /// The case's own sensors among the candidates, where all of them are.
  void set_own() {
    for (const auto& sensor : study_.sensors) {
      const auto same = [&](const CandidateSensor& candidate) {
        const auto& output = candidate.channels.front().output;
        return candidate.channels.size() == 1 && output.quantity == sensor.output.quantity &&
               output.points == sensor.output.points;
      };
      const auto found = std::ranges::find_if(plan_.candidates, same);
      if (found == plan_.candidates.end()) {
        plan_.own.clear();
        return;
      }
      plan_.own.push_back(static_cast<std::size_t>(found - plan_.candidates.begin()));
    }
    std::ranges::sort(plan_.own);
    const auto doubled = std::ranges::unique(plan_.own);
    plan_.own.erase(doubled.begin(), doubled.end());
  }

  const CaseStudy& study_;
  PlacementPlan& plan_;
  IssueList& issues_;
  std::set<std::string> grounds_, points_;
  std::vector<std::string> reported_;
  std::set<Measured> taken_;       ///< by candidates and by sensors that stay
  std::set<Measured> candidates_;  ///< by candidates
};

/// The unknowns that shall be known well, by the case or all that are constant.
std::vector<std::string> counted_unknowns(const std::vector<Unknown>& unknowns, const std::vector<Name>& given,
                                          IssueList& issues) {
  std::vector<std::string> constant, counted;
  for (const auto& unknown : unknowns)
    if (unknown.random_walk == 0.0) constant.push_back(unknown.name);
  if (given.empty()) return constant;
  for (const auto& name : given) {
    const auto found = std::ranges::find(unknowns, name.value, &Unknown::name);
    if (found == unknowns.end())
      issues.add(name.location,
                 name.path + ": there is no unknown '" + name.value + "' of the structure" +
                     did_you_mean(name.value, constant),
                 "sensors are placed for parameters of the structure", "name one of estimate.unknown");
    else if (found->random_walk > 0.0)
      issues.add(name.location, name.path + ": the unknown '" + name.value + "' drifts",
                 "the information of a whole record is that of a constant", "name a constant unknown");
    else if (std::ranges::find(counted, name.value) != counted.end())
      issues.add(name.location, name.path + ": the unknown '" + name.value + "' is named twice", "", "name it once");
    else
      counted.push_back(name.value);
  }
  return counted;
}

/// What the case gives under `infer`, otherwise what `estimate` says.
MarginalPrior prior_in(const CaseStudy& study, const Unknown& unknown) {
  if (study.given.infer)
    for (const auto& [name, prior] : study.given.infer->value.priors)
      if (name == unknown.name) return stated_prior(prior, unknown.unit());
  return prior_of(unknown);
}

void set_unknowns(const CaseStudy& study, PlacementPlan& plan, IssueList& issues) {
  const auto& unknowns = plan.problem->settings.unknowns;
  plan.unknowns = counted_unknowns(study.problem->settings.unknowns, study.given.place->value.parameters, issues);
  plan.counted = plan.unknowns.size();
  for (const auto& unknown : unknowns)
    if (unknown.random_walk == 0.0 && std::ranges::find(plan.unknowns, unknown.name) == plan.unknowns.end())
      plan.unknowns.push_back(unknown.name);
  if (plan.unknowns.empty() && issues.empty())
    issues.add(study.given.place->location, "place: `estimate` has no constant unknown",
               "sensors are placed where they tell most of the unknowns", "add one under estimate.unknown");
  Named<MarginalPrior> priors;
  plan.initial.resize(static_cast<Index>(plan.unknowns.size()));
  for (const auto& name : plan.unknowns) {
    const auto& unknown = *std::ranges::find(unknowns, name, &Unknown::name);
    plan.initial[static_cast<Index>(priors.size())] = unknown.initial;
    plan.units.push_back(unknown.unit());
    priors.emplace_back(name, prior_in(study, unknown));
  }
  if (!priors.empty()) plan.prior = JointPrior(std::move(priors));
}

void set_options(const CaseStudy& study, PlacementPlan& plan, IssueList& issues) {
  constexpr std::size_t most_ranked = 100'000;
  const auto& given = study.given.place->value;
  const auto kept = plan.options.fixed.size(), free = plan.candidates.size() - kept;
  if (static_cast<std::size_t>(given.count.value) > free)
    issues.add(given.count.location,
               given.count.path + ": " + std::to_string(given.count.value) +
                   " sensors are to be placed, but there are " + std::to_string(free) + " candidates" +
                   (kept > 0 ? " beside those of `keep`" : ""),
               "each sensor needs a place of its own", "place fewer, or add candidates");
  const Eigen::VectorXd deviation = plan.prior.size() > 0 ? plan.prior.deviation() : Eigen::VectorXd();
  plan.options.sensors = kept + static_cast<std::size_t>(given.count.value);
  plan.options.criterion = given.criterion;
  plan.options.scale = plan.options.prior_deviation = deviation.head(static_cast<Index>(plan.counted));
  plan.options.most_sets = given.largest_enumeration;
  plan.options.ranked = std::clamp<std::size_t>(static_cast<std::size_t>(given.largest_enumeration), 1000, most_ranked);
  plan.options.threads = filter_threads(study.problem->settings);
  plan.draws = given.draws;
  plan.seed = given.seed;
}

void set_drive(const CaseStudy& study, PlacementPlan& plan) {
  plan.drive.sample_rate = study.sample_rate();
  if (study.record) {
    plan.drive.start = study.record->record.start;
    plan.drive.values.resize(0, study.record->record.samples_used());
  } else if (study.simulation) {
    const double samples = study.simulation->duration * study.simulation->sample_rate;
    plan.drive.values.resize(0, std::lround(samples) + 1);
  }
}

/// The sensitivities of all channels are held at once.
void check_memory(const CaseStudy& study, const PlacementPlan& plan, IssueList& issues) {
  constexpr double most_numbers = 1e9;  // 8 GB
  double channels = 0.0;
  for (const auto& candidate : plan.candidates) channels += static_cast<double>(candidate.channels.size());
  const double samples = static_cast<double>(plan.drive.samples());
  const double numbers = channels * samples * static_cast<double>(plan.unknowns.size() + 2);
  if (numbers > most_numbers)
    issues.add(study.given.place->location,
               "place: the sensitivities of " + shortest(channels) + " channels over " + shortest(samples) +
                   " samples to " + std::to_string(plan.unknowns.size()) + " unknowns are " +
                   shortest(std::round(8e-9 * numbers)) + " GB",
               "they are held in memory at once",
               "give a group of a region a `spacing`, shorten the record or lower its sample rate");
}

}  // namespace

PlacementPlan make_placement_plan(const CaseStudy& study, IssueList& issues) {
  PlacementPlan plan;
  if (!study.problem)
    issues.add(study.given.place->location, "place: the case has no `estimate`",
               "sensors are placed where they tell most of its unknowns", "add `estimate` with the unknowns");
  else
    check_excitation_is_known(*study.problem, issues);
  CandidateReader(study, plan, issues).read();
  if (!study.problem) return plan;
  plan.problem = study.problem;
  if (study.augmented_model) {
    const StatedUnknowns stated = with_stated_unknowns(study.problem, *study.augmented_model);
    plan.problem = stated.problem;
    plan.not_counted = stated.of_signals();
  }
  try {
    set_unknowns(study, plan, issues);
  } catch (const InvalidInput& error) {
    issues.add(error, study.given.place->location);
  }
  set_options(study, plan, issues);
  set_drive(study, plan);
  check_memory(study, plan, issues);
  return plan;
}

}  // namespace kalfem
