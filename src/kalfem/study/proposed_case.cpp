// SPDX-License-Identifier: Apache-2.0
#include "kalfem/study/proposed_case.hpp"

#include <fmt/format.h>

#include "kalfem/casefile/case_schema.hpp"
#include "kalfem/study/case_study.hpp"
#include "kalfem/study/identified_case.hpp"

namespace kalfem {
namespace {

namespace d = description;

d::Case case_with(const Study& study, const std::vector<TriedNumber>& freed) {
  d::Case edited = *study.description;
  for (const auto& each : freed) {
    const auto& [name, unit, value] = std::tie(each.name, each.number.unit, each.number.value);
    edited.estimate->unknown.emplace_back(
        name, d::Unknown{.initial = value_in(value, unit), .std = value_in(each.prior, unit)});
    std::erase_if(edited.estimate->known_to, [&](const auto& known) { return known.first == each.number.name; });
  }
  return edited;
}

std::string edit_of(const TriedNumber& freed) {
  const std::string unit = freed.number.unit == "-" ? "" : " " + freed.number.unit;
  return fmt::format("estimate.unknown.{}: {{initial: {}{}, std: {}{}}}", freed.name, shortest(freed.number.value),
                     unit, shortest(freed.prior), unit);
}

/// As a file with the keys that the user gave and those edited; nothing where no study can be made of it.
std::optional<ProposedCase> proposed(const Study& study, const d::Case& edited, std::vector<std::string> edits) try {
  make_study(edited, study.file);
  static const auto schema = d::case_schema();
  const auto written =
      as_given(schema.write(edited), schema.write(*study.description), study.description->source.root());
  return ProposedCase{.yaml = to_yaml(*written), .edits = std::move(edits)};
} catch (const InvalidInput&) {
  return std::nullopt;
}

}  // namespace

Study study_with(const Study& study, const std::vector<TriedNumber>& freed) {
  return make_study(case_with(study, freed), study.file);
}

std::optional<ProposedCase> propose(const Study& study, const std::vector<TriedNumber>& freed) {
  std::vector<std::string> edits;
  for (const auto& each : freed) edits.push_back(edit_of(each));
  return proposed(study, case_with(study, freed), std::move(edits));
}

std::optional<ProposedCase> propose_adapted_process(const Study& study, double density) {
  d::Case edited = *study.description;
  const double rounded = std::stod(fmt::format("{:.2g}", density));
  edited.estimate->process_noise.acceleration = rounded;
  edited.estimate->adaptive_noise.process = true;
  return proposed(study, edited,
                  {fmt::format("estimate.process_noise.acceleration: {} m/s^2/sqrt(Hz)", shortest(rounded)),
                   "estimate.adaptive_noise.process: true"});
}

}  // namespace kalfem
