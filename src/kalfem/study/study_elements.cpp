// SPDX-License-Identifier: Apache-2.0
#include "kalfem/study/study_elements.hpp"

#include <algorithm>
#include <limits>
#include <map>

#include "kalfem/base/stopwatch.hpp"
#include "kalfem/casefile/case_schema.hpp"
#include "kalfem/study/assembly.hpp"
#include "kalfem/study/candidate_nodes.hpp"
#include "kalfem/study/finite_element_part.hpp"
#include "kalfem/study/joints.hpp"
#include "kalfem/study/statics_plan.hpp"

namespace kalfem {
namespace {

namespace d = description;

/// Frequency above which no sensor responds [Hz].
double sensor_bandwidth(const d::Case& given) {
  double widest = 0.0;
  const double rate = given.simulate ? given.simulate->sample_rate : std::numeric_limits<double>::infinity();
  for (const auto& [name, sensor] : given.sensors)
    widest = std::max(widest, std::min(0.5 * rate, bandwidth({sensor.chain})));
  return widest > 0.0 ? widest : std::numeric_limits<double>::infinity();
}

/// Names, within the substructure, of the parameters that the case estimates, updates, modifies or states.
std::vector<std::string> changing_parameters(const d::Case& given, const std::string& substructure) {
  const std::string prefix = substructure + ".";
  std::vector<std::string> names;
  const auto include = [&](const std::string& name) {
    if (name.starts_with(prefix)) names.push_back(name.substr(prefix.size()));
  };
  if (given.estimate)
    for (const auto& [name, unknown] : given.estimate->unknown) {
      include(name);
      for (const auto& target : unknown.applies_to) include(target.value);
    }
  const auto include_updated = [&](const Named<Located<d::UpdatedParameter>>& parameters) {
    for (const auto& [name, parameter] : parameters) {
      include(name);
      for (const auto& target : parameter.value.applies_to) include(target.value);
    }
  };
  if (given.update) {
    include_updated(given.update->parameters);
    for (const auto& [name, alternative] : given.update->alternatives) include_updated(alternative.value.parameters);
  }
  if (given.estimate)
    for (const auto& [name, value] : given.estimate->known_to) include(name);
  if (given.update)
    for (const auto& [name, value] : given.update->known_to) include(name);
  for (const auto& [name, modification] : given.modifications)
    for (const auto& [target, value] : modification.value.set)
      include(modification.value.substructure.value + "." + target);
  return names;
}

/// Whether a parameter may take other values, also one that the case does not name: the search for the cause of a
/// contradiction tries them.
bool tries_parameters(const d::Case& given) { return given.estimate || given.update || !given.modifications.empty(); }

/// Warns of each note that may affect the model, and of the number of ignored entries.
void warn_of_notes(const ElementNotes& part, std::vector<std::string>& warnings) {
  std::size_t unused = 0;
  for (const auto& note : part.notes)
    if (note.kind == DeckNoteKind::unused)
      ++unused;
    else
      warnings.push_back("substructure '" + part.substructure +
                         "': " + kalfem::to_string(Issue{note.where, note_subject(note), note.consequence, ""}));
  if (unused > 0)
    warnings.push_back("substructure '" + part.substructure + "': its deck holds " + std::to_string(unused) +
                       (unused == 1 ? " kind" : " kinds") +
                       " of entries that kalfem ignores; `kalfem check` lists them");
}

/// Finite-element substructures that the case describes alike, and of which its other sections touch the same, are
/// read, assembled and reduced once: four suspension arms of one deck.
class MadeParts {
public:
  struct Made {
    FiniteElementSubstructure elements;
    std::vector<DeckNote> notes;
  };

  /// Empty where none can be like it: static load cases and places of sensors name their substructure.
  [[nodiscard]] std::string description_of(const d::Case& given, const d::Substructure& substructure,
                                           const PartUses& uses) const {
    if (given.place || uses.statics != nullptr) return {};
    std::string words = to_yaml(*schema_.write(substructure));
    for (const auto* names : {&uses.attached, &uses.parameters}) {
      words += "\n---";
      for (const auto& name : *names) words += "\n" + name;
    }
    for (const auto& group : uses.joined) words += "\n" + group.value;
    return words;
  }

  [[nodiscard]] const Made* find(const std::string& description) const {
    const auto made = made_.find(description);
    return made == made_.end() ? nullptr : &made->second;
  }

  void add(const std::string& description, Made made) {
    if (!description.empty()) made_.emplace(description, std::move(made));
  }

private:
  Schema<d::Substructure> schema_ = d::substructure();
  std::map<std::string, Made> made_;
};

FiniteElementSubstructure under_name(const std::string& name, FiniteElementSubstructure elements) {
  auto part = std::make_shared<FiniteElementPart>(*elements.part);
  part->name = name;
  part->times = {};
  elements.part = std::move(part);
  return elements;
}

/// Superelement files need a reduced substructure.
void check_superelement_files(const StructureModel& structure, CaseStudy& study, IssueList& issues) {
  const auto& files = study.given.report.superelements;
  if (files.value.empty() || !issues.empty()) return;
  const auto is_reduced = [](const FiniteElementSubstructure& elements) { return elements.reduced != nullptr; };
  if (std::ranges::none_of(structure.finite_elements, is_reduced))
    issues.add(files.location, files.path + ": the case reduces no substructure", "there is no superelement to write",
               "give a finite-element substructure `reduction: {boundary: [...]}`");
  else
    for (const auto& elements : structure.finite_elements)
      if (!is_reduced(elements))
        study.warnings.push_back("substructure '" + elements.part->name +
                                 "' is not reduced because nothing is attached to it: no superelement file is written");
}

}  // namespace

std::optional<FrequencyBand> excitation_band(const d::Case& given) {
  FrequencyBand band{std::numeric_limits<double>::infinity(), 0.0};
  const auto include = [&](double from, double to) {
    band = {std::min({band.from, from, to}), std::max({band.to, from, to})};
  };
  for (const auto& [name, excitation] : given.excitation) {
    if (const auto* random = excitation.signal_as<d::RandomSignal>()) include(random->band[0], random->band[1]);
    if (const auto* sine = excitation.signal_as<d::Sine>()) include(sine->frequency, sine->frequency);
    if (const auto* sweep = excitation.signal_as<d::SweptSine>()) include(sweep->from, sweep->to);
  }
  return band.to > band.from ? std::optional(band) : std::nullopt;
}

void add_finite_elements(StructureModel& structure, CaseStudy& study, const Progress& progress, IssueList& issues) {
  const Stopwatch watch;
  const auto all = std::ranges::count_if(study.given.substructures,
                                         [](const auto& each) { return each.second.finite_elements.has_value(); });
  std::ptrdiff_t done = 0;
  MadeParts made;
  DeckFiles decks(study.given);
  for (const auto& [name, given] : study.given.substructures) {
    if (!given.finite_elements) continue;
    if (progress)
      progress("reduce " + std::to_string(done + 1) + " of " + std::to_string(all),
               static_cast<double>(done) / static_cast<double>(all));
    ++done;
    try {
      const PartUses uses{.attached = attached_points(study.given, name),
                          .joined = joined_groups(study.given, name),
                          .parameters = changing_parameters(study.given, name),
                          .statics = statics_of(study.given, name),
                          .at_present_values = !tries_parameters(study.given)};
      const std::string description = all > 1 ? made.description_of(study.given, given, uses) : "";
      if (const auto* alike = made.find(description)) {
        study.element_notes.push_back({name, alike->notes});
        structure.finite_elements.push_back(under_name(name, alike->elements));
        continue;
      }
      auto [part, notes, warnings] = make_finite_element_part(name, given, uses, decks);
      study.element_notes.push_back({name, notes});
      warn_of_notes(study.element_notes.back(), study.warnings);
      for (const auto& warning : warnings) study.warnings.push_back("substructure '" + name + "': " + warning);
      add_candidate_points(study.given, part);
      study.reduce_phases.add(part.times);
      FiniteElementSubstructure elements;
      elements.part = std::make_shared<const FiniteElementPart>(std::move(part));
      elements.reduction = reduction_request(given.reduction);
      if (!elements.part->boundary.empty()) {
        elements.reduced = std::make_shared<const Superelement>(
            reduce(*elements.part, elements.reduction, sensor_bandwidth(study.given), study.given.report.modes));
        study.reduce_phases.add("reduce", elements.reduced->error_indicators.seconds);
        study.reduce_phases.add("compare", elements.reduced->error_indicators.compare_seconds);
        if (study.given.simulate && study.given.simulate->superelements)
          elements.reference = study.reduce_phases.measure("reference", [&] {
            return std::make_shared<const Superelement>(
                reduce_up_to(*elements.part, study.given.simulate->modes_up_to));
          });
      }
      made.add(description, {elements, std::move(notes)});
      structure.finite_elements.push_back(std::move(elements));
    } catch (const InvalidInput& error) {
      add_at(given.finite_elements->location(), error, issues);
    }
  }
  check_superelement_files(structure, study, issues);
  study.reduce_seconds = watch.seconds();
}

void warn_of_reductions(CaseStudy& study) {
  const auto excited = excitation_band(study.given);
  for (const auto& elements : study.structure->finite_elements)
    if (elements.reduced && study.augmented_model)
      for (const auto& warning : reduction_warnings(elements.reduced->error_indicators, excited ? excited->to : 0.0,
                                                    sensor_bandwidth(study.given)))
        study.warnings.push_back("substructure '" + elements.part->name + "': " + warning);
}

}  // namespace kalfem
