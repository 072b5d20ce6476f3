// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "kalfem/page/words.hpp"
#include "kalfem/report/model_check_section.hpp"
#include "kalfem/report/result_set.hpp"
#include "kalfem/report/study_page.hpp"
#include "kalfem/steps/compared.hpp"
#include "kalfem/steps/estimation/outcome.hpp"
#include "kalfem/steps/estimation/sections.hpp"
#include "kalfem/steps/identified_parameters.hpp"
#include "kalfem/steps/modes/outcome.hpp"
#include "kalfem/steps/table.hpp"

namespace kalfem {
namespace {

/// What fits on the first screen: the parameters, the law and the edit that the verdict asks for; beside them the law's
/// force and the structure with the names of everything.
Section overview_section(const Study& study, const StudyResults& results) {
  Section section{"Overview", "", {}};
  if (const auto found = identified_parameters(study, results); !found.empty())
    section.items.emplace_back(identified_parameter_table(found));
  const auto* estimation = results.find<EstimationOutcome>();
  LawOverview law = estimation ? law_overview(study, *estimation) : LawOverview{};
  if (auto edit = asked_edit(study, results)) section.items.emplace_back(std::move(*edit));
  if (law.equation) section.items.emplace_back(std::move(*law.equation));
  if (law.force) section.aside = section.items.size();
  if (law.force) section.items.emplace_back(std::move(*law.force));
  if (auto picture = structure_picture(study)) section.items.emplace_back(std::move(*picture));
  return section;
}

/// The mistakes that were tested, best explanation first; the page shows as many as somebody reads.
Table tested_table(const std::string& title, const std::vector<TestedHypothesis>& tested) {
  constexpr std::size_t shown = 12;
  Table table{title, {"if", "log-likelihood rises by", "mean NIS then"}, {}, {}};
  for (const auto& each : tested)
    if (!each.failed && table.rows.size() < shown)
      table.rows.push_back({each.words, fmt::format("{:.0f}", each.gain), fmt::format("{:.2f}", each.mean_nis)});
  return table;
}

/// Every reason that the verdict has, worst first, with what to do, and which causes were tested.
Section verdict_section(const StudyResults& results) {
  Table table{"Reasons, worst first", {"of", "found", "to do", "rule"}, {}, {}};
  for (const auto& reason : results.verdict.reasons())
    table.rows.push_back({reason.subject, reason.text, reason.remedy, reason.code});
  Section section{"Reasons for doubt", "", {table}};
  if (const auto* estimation = results.find<EstimationOutcome>(); estimation && estimation->diagnosis) {
    const auto& diagnosis = *estimation->diagnosis;
    section.text = fmt::format(
        "{} mistakes were tested one at a time on the first {:.4g} s of the record: the filter ran again with each of "
        "them "
        "undone. The one under which the record is most likely is the cause, if it explains the record far better.",
        diagnosis.tested.size(), diagnosis.duration);
    if (!diagnosis.together.empty()) {
      section.text += " No single one explains all: two were undone together.";
      section.items.emplace_back(tested_table("Two mistakes at once", diagnosis.together));
    }
    section.items.emplace_back(
        tested_table("Mistakes that were undone to see whether they explain it", diagnosis.tested));
  }
  return section;
}

Eigen::Index dofs_of_all(const StudyResults& results) {
  Eigen::Index dofs = 0;
  for (const auto& part : modes_found(results).substructures) dofs += part.dofs;
  return dofs;
}

/// What the steps show, from top to bottom.
std::vector<Section> sections_of_steps(const Study& study, const StudyResults& results) {
  std::vector<PlacedSection> placed;
  for (const auto* step : steps_that_ran(results))
    if (step->sections) std::ranges::move(step->sections(study, results), std::back_inserter(placed));
  std::ranges::stable_sort(placed, {}, &PlacedSection::place);
  std::vector<Section> sections;
  for (auto& each : placed) sections.push_back(std::move(each.section));
  return sections;
}

}  // namespace

Page make_page(const Study& study, const StudyResults& results) {
  Page page{.title = study.title.empty() ? "kalfem" : study.title,
            .subtitle = fmt::format("{} degrees of freedom, {}", dofs_of_all(results),
                                    counted(study.model->system().connector_count(), "connector")),
            .status = has_verdict(results) ? std::optional(results.verdict.state()) : std::nullopt,
            .summary = answer(study, results),
            .warnings = study.warnings};
  for (const auto& warning : results.warnings)
    if (std::ranges::none_of(results.verdict.reasons(), [&](const auto& each) { return sentence_of(each) == warning; }))
      page.warnings.push_back(warning);
  page.sections.push_back(overview_section(study, results));
  if (results.verdict.state() != VerdictState::consistent) page.sections.push_back(verdict_section(results));
  std::ranges::move(sections_of_steps(study, results), std::back_inserter(page.sections));
  for (std::size_t i = 0; i < study.structure->finite_elements.size(); ++i) {
    const FiniteElementPart& part = *study.structure->finite_elements[i].part;
    page.sections.push_back(model_check_section(
        part.name, part.elements,
        model_check_of(part,
                       {.mechanisms = false, .definiteness = false, .frequencies = 0, .needs_mass = !study.statics}),
        study.element_notes[i].notes));
  }
  page.sections.push_back(provenance_section(study, results));
  return page;
}

}  // namespace kalfem
