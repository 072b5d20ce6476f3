// SPDX-License-Identifier: Apache-2.0
#include "kalfem/study/frequency_response_plan.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/casefile/description.hpp"
#include "kalfem/system/linearised.hpp"

namespace kalfem {
namespace {

namespace d = description;
using Eigen::Index;
using Eigen::VectorXd;

VectorXd lines_of(const d::FrequencyLines& given) {
  if (const auto* listed = std::get_if<std::vector<double>>(&given))
    return VectorXd::Map(listed->data(), std::ssize(*listed));
  const auto& band = std::get<d::FrequencyBandLines>(given);
  if (!band.logarithmic) return VectorXd::LinSpaced(band.lines, band.from, band.to);
  return VectorXd::LinSpaced(band.lines, std::log(band.from), std::log(band.to)).array().exp();
}

/// The structure with its finite elements at full order, or one substructure alone. Its own excitation is left out.
void take_parts(const d::FrequencyResponses& given, const StructureModel& structure, FrequencyResponsePlan& plan) {
  const auto is_wanted = [&](const std::string& name) {
    return !given.substructure || given.substructure->value == name;
  };
  std::vector<std::string> known;
  for (const auto& part : structure.parts.substructures) {
    known.push_back(part.name);
    if (is_wanted(part.name)) plan.parts.substructures.push_back(part);
  }
  for (const auto& elements : structure.finite_elements) {
    known.push_back(elements.part->name);
    if (!is_wanted(elements.part->name)) continue;
    plan.finite_elements.push_back(elements);
    plan.parts.finite_elements.push_back(
        {elements.part->name, std::shared_ptr<const LinearModel>(elements.part, &elements.part->full)});
  }
  if (given.substructure && plan.parts.substructures.empty() && plan.parts.finite_elements.empty())
    throw InvalidInput(Issue{given.substructure->location,
                             given.substructure->path + ": there is no substructure '" + given.substructure->value +
                                 "'" + did_you_mean(given.substructure->value, known),
                             "", "name one of `substructures`, or leave the key out for the whole structure"});
  if (given.substructure) return;
  plan.parts.connectors = structure.parts.connectors;
  plan.parts.damping = structure.parts.damping;
  plan.parts.shared = structure.parts.shared;
}

/// Looks up points, gauges and grounds of the parts; unknown ones become issues.
class ResponsePlaces {
public:
  ResponsePlaces(const StructureParts& parts, IssueList& issues) : grounds_(ground_names(parts)), issues_(issues) {
    const CoupledModel alone = couple({parts.substructures, parts.finite_elements, {}, {}});
    points_ = alone.reported_points();
    gauges_ = alone.gauges();
  }

  [[nodiscard]] bool is_ground(const Name& name) const { return contains(grounds_, name.value); }

  void check_input(const Name& input) const {
    if (is_ground(input) || contains(points_, input.value)) return;
    auto known = points_;
    known.insert(known.end(), grounds_.begin(), grounds_.end());
    refuse(input, "there is no point or ground", known, "a force acts at a point, and grounds move");
  }
  void check_output(const d::ResponseOutput& output) const {
    const Name& place = output.point;
    if (output.quantity == ResponseQuantity::strain) {
      if (!contains(gauges_, place.value))
        issues_.add(
            place.location,
            place.path + ": there is no strain gauge '" + place.value + "'" + did_you_mean(place.value, gauges_),
            "strains are those of gauges on finite elements",
            "define it under `gauges` of the finite elements, and write substructure.name");
    } else if (!contains(points_, place.value)) {
      refuse(place, "there is no point", points_, "the responses are motions of points");
    }
  }

private:
  static bool contains(const std::vector<std::string>& names, const std::string& name) {
    return std::ranges::find(names, name) != names.end();
  }
  void refuse(const Name& name, const std::string& what, const std::vector<std::string>& known,
              const std::string& why) const {
    issues_.add(name.location, name.path + ": " + what + " '" + name.value + "'" + did_you_mean(name.value, known), why,
                "write it as substructure.name, such as body.1 or frame.p1.z");
  }

  std::vector<std::string> grounds_, points_, gauges_;
  IssueList& issues_;
};

/// The sets of an input: its outputs by quantity, in their order.
void add_sets(const d::FrequencyResponses& given, const Name& input, FrfInput kind, std::vector<FrfSet>& sets) {
  const auto first = sets.size();
  for (const auto& output : given.outputs) {
    auto set = std::find_if(sets.begin() + static_cast<std::ptrdiff_t>(first), sets.end(),
                            [&](const FrfSet& each) { return each.quantity == output.quantity; });
    if (set == sets.end())
      set = sets.insert(sets.end(), {.input = kind, .place = input.value, .outputs = {}, .quantity = output.quantity});
    set->outputs.push_back(output.point.value);
  }
}

/// Grounds that move must carry something, which is known once the structure is coupled.
void check_grounds(const d::FrequencyResponses& given, const FrequencyResponsePlan& plan, IssueList& issues) {
  for (const auto& set : plan.sets) {
    if (set.input == FrfInput::force) continue;
    IssueList found;
    places_of(set, *plan.full, found);
    const auto input = std::ranges::find(given.inputs, set.place, &Name::value);
    for (const auto& [location, what, why, fix] : found.issues())
      issues.add(input->location, input->path + ": " + what, why, fix);
  }
}

void check_model(const d::FrequencyResponses& given, const FrequencyResponsePlan& plan, IssueList& issues) {
  if (plan.model == ResponseModel::full || !plan.finite_elements.empty()) return;
  issues.add(given.model.location, given.model.path + ": there are no finite elements to reduce",
             "full and reduced model are the same", "write `model: full`");
}

}  // namespace

FrequencyResponsePlan make_frequency_response_plan(const d::Case& given, const StructureModel& structure,
                                                   IssueList& issues) {
  const auto& responses = given.frequency_response->value;
  FrequencyResponsePlan plan{{.frequencies = lines_of(responses.frequencies.value),
                              .model = responses.model.value,
                              .method = responses.method},
                             responses.frequencies.location};
  take_parts(responses, structure, plan);
  check_model(responses, plan, issues);
  const ResponsePlaces places(plan.parts, issues);
  for (const auto& output : responses.outputs) places.check_output(output);
  for (const auto& input : responses.inputs) {
    places.check_input(input);
    const bool moves = places.is_ground(input);
    add_sets(responses, input, moves ? FrfInput::ground_displacement : FrfInput::force, plan.sets);
    if (moves)
      plan.parts.inputs.push_back({.name = input.value,
                                   .kind = InputKind::base_displacement,
                                   .target = input.value,
                                   .location = input.location});
  }
  if (!issues.empty()) return plan;
  plan.full = std::make_shared<const LinearModel>(linearised_at_rest(couple(plan.parts)));
  check_grounds(responses, plan, issues);
  return plan;
}

}  // namespace kalfem
