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

}  // namespace

Study study_with(const Study& study, const std::vector<TriedNumber>& freed) {
  return make_study(case_with(study, freed), study.file);
}

std::optional<ProposedCase> propose(const Study& study, const std::vector<TriedNumber>& freed) try {
  study_with(study, freed);
  static const auto schema = d::case_schema();
  const auto written = as_given(schema.write(case_with(study, freed)), schema.write(*study.description),
                                study.description->source.root());
  ProposedCase proposed{.yaml = to_yaml(*written)};
  for (const auto& each : freed) proposed.edits.push_back(edit_of(each));
  return proposed;
} catch (const InvalidInput&) {
  return std::nullopt;
}

}  // namespace kalfem
