// SPDX-License-Identifier: Apache-2.0
#include "kalfem/study/validation_plan.hpp"

#include <algorithm>
#include <filesystem>
#include <iterator>

#include "kalfem/study/assembly.hpp"
#include "kalfem/study/case_study.hpp"
#include "kalfem/study/record_source.hpp"

namespace kalfem {
namespace {

namespace d = description;

/// Lead-in of a part, as a fraction of it, if the case gives none.
constexpr double usual_lead_in = 0.1;

bool same_file(const std::filesystem::path& one, const std::filesystem::path& other) {
  std::error_code error;
  return one == other || std::filesystem::equivalent(one, other, error);
}

/// The record of the validation: its own one, or that of the case, cut to another part.
d::Record record_of(const d::Case& given) {
  const auto& [validate, location, path] = *given.validate;
  d::Record record = validate.record ? *validate.record : *given.record;
  if (!validate.record) {
    record.file.location = location;
    record.start = record.end = std::nullopt;
  }
  if (validate.start) record.start = validate.start;
  if (validate.end) record.end = validate.end;
  return record;
}

/// A message names the keys of `record`; those of the validation stand elsewhere.
Issue renamed(Issue issue, bool own_record) {
  const std::string part = "record.start, record.end";
  if (issue.what.starts_with(part))
    issue.what.replace(0, part.size(), "validate.start, validate.end");
  else if (issue.what.starts_with("record.") && own_record)
    issue.what = "validate." + issue.what;
  return issue;
}

/// The case with the record of the validation in the place of its own, and inputs from the files of that record.
d::Case case_of_validation(const d::Case& given, IssueList& issues) {
  const auto& validate = given.validate->value;
  d::Case other = given;
  other.record = record_of(given);
  for (const auto& [name, file] : validate.excitation)
    if (std::ranges::none_of(given.excitation, [&](const auto& each) { return each.first == name; }))
      issues.add(file.location, file.path + ": there is no excitation '" + name + "'", "",
                 "name one of the case's `excitation`");
  if (!validate.record) return other;
  for (const auto& [name, sensor] : given.sensors)
    if (sensor.file)
      issues.add(given.validate->location, "validate: sensor '" + name + "' has a file of its own",
                 "its course during another record is not known",
                 "validate on another part of the case's own record: validate.start and end");
  for (auto& [name, excitation] : other.excitation) {
    const auto own =
        std::ranges::find(validate.excitation, name, &std::pair<std::string, Located<std::filesystem::path>>::first);
    auto* measured = excitation.signal ? std::get_if<d::FileSignal>(&*excitation.signal) : nullptr;
    const auto* channel = excitation.signal_as<d::ChannelSignal>();
    const bool of_record = channel != nullptr && !channel->file;
    const bool follows = of_record || excitation.signal_as<d::Clock>() || excitation.signal_as<d::Delayed>() ||
                         excitation.signal_as<d::Trailing>() || excitation.signal_as<d::Constant>();
    if (measured && own != validate.excitation.end())
      measured->file = own->second.value;
    else if (measured && given.record && same_file(measured->file, given.record->file.value))
      measured->file = validate.record->file.value;
    else if (measured)
      issues.add(given.validate->location,
                 "validate: excitation '" + name + "' comes from '" + measured->file.filename().string() +
                     "', which is not the file of the record",
                 "its course during the validation record is not known",
                 "name its file: validate.excitation: {" + name + ": FILE}");
    else if (!follows)
      issues.add(given.validate->location, "validate: excitation '" + name + "' is not measured",
                 "its course during another record is not known",
                 "validate on another part of the case's own record, or read the excitation from a file");
  }
  return other;
}

/// Refuses a part that shares samples with the one that is estimated from.
void check_overlap(const CaseStudy& study, const d::Record& asked, const Record& part, IssueList& issues) {
  if (!study.record || !study.given.record) return;
  const auto& own = study.record->record;
  const auto& given = *study.given.record;
  if (!same_file(asked.file.value, given.file.value) || asked.group != given.group) return;
  if (part.start > own.end() || part.end() < own.start) return;
  const auto span = [](const Record& record) {
    return shortest(record.start) + " s to " + shortest(record.end()) + " s";
  };
  issues.add(study.given.validate->location,
             "validate: its part, " + span(part) + ", overlaps the part that is estimated from, " + span(own),
             "a validation needs data that were not used", "change validate.start and end, or record.start and end");
}

/// The signals must be known over the whole part.
void check_cover(const CaseStudy& study, const ValidationPlan& plan, IssueList& issues) {
  for (std::size_t i = 0; i < plan.signals.size(); ++i) try {
      for (const double time : {plan.record.record.start, plan.record.record.end()})
        static_cast<void>(plan.signals[i]->sample(time, 1.0, 1));
    } catch (const InvalidInput& error) {
      const auto& name = study.structure->parts.inputs[i].name;
      for (const auto& issue : error.issues())
        issues.add(study.given.validate->location, "validate: excitation '" + name + "': " + issue.what, issue.why,
                   issue.fix);
    }
}

void set_start(const d::Validation& given, const SourceLocation& place, ValidationPlan& plan, IssueList& issues) {
  const Record& part = plan.record.record;
  const double length = part.end() - part.start;
  constexpr Eigen::Index fewest_samples = 4;  // two of a lead-in and two that count
  if (part.samples() < fewest_samples)
    issues.add(place,
               "validate: its part, " + shortest(part.start) + " s to " + shortest(part.end()) + " s, has only " +
                   std::to_string(part.samples()) + " samples",
               "an error of so few says nothing", "take a longer part");
  plan.from_rest = given.from_rest;
  plan.lead_in = given.lead_in.value_or(usual_lead_in * length);
  if (given.from_rest && given.lead_in)
    issues.add(place, "validate.lead_in is given with initial: rest", "a known initial state is not estimated",
               "remove one of them");
  if (plan.lead_in >= length)
    issues.add(place,
               "validate.lead_in is " + shortest(plan.lead_in) + " s, but the part is " + shortest(length) + " s long",
               "nothing would be left to compare", "give a shorter lead-in or a longer part");
}

}  // namespace

void check_validation(const CaseStudy& study, IssueList& issues) {
  const auto& given = study.given;
  const auto& [validate, place, path] = *given.validate;
  const auto refuse = [&](const std::string& what, const std::string& why, const std::string& fix) {
    issues.add(place, "validate: " + what, why, fix);
  };
  if (given.simulate)
    refuse("the case simulates its record", "a validation needs measured data; the truth of a simulation is known",
           "remove it: the summary compares the estimates with the truth");
  else if (!validate.record && !given.record)
    refuse("the case has no record", "there are no data to validate on", "give validate.record: {file: ...}");
  else if (!validate.record && !validate.start && !validate.end)
    refuse("nothing says which data to use", "the case's own record is estimated from",
           "give start and end of another part of it, or another record");
  if (!given.estimate && !given.update)
    refuse("the case estimates nothing", "there are no estimates to validate", "add `estimate` or `update`");
  if (given.estimate && given.estimate->local)
    refuse("the filter has a local model", "a part of a structure cannot be simulated alone",
           "remove estimate.local or `validate`");
  if (given.sensors.empty())
    refuse("the case has no sensors", "there is nothing to compare", "add at least one sensor under `sensors`");
  if (!validate.record && !validate.excitation.empty())
    refuse("excitation is given without a record", "during the case's own record its own excitation goes on",
           "remove it, or give validate.record");
  if (!validate.record) return;
  if ((validate.start && validate.record->start) || (validate.end && validate.record->end))
    refuse("its part is given twice", "in validate and in validate.record", "give start and end once");
}

ValidationPlan make_validation_plan(const CaseStudy& study, IssueList& issues) {
  const auto& [validate, place, path] = *study.given.validate;
  const d::Case other = case_of_validation(study.given, issues);
  ValidationPlan plan{{}, other.record->file.value.string()};
  try {
    plan.record = read_measured_record(other);
  } catch (const InvalidInput& error) {
    for (const auto& issue : error.issues()) {
      const auto [location, what, why, fix] = renamed(issue, validate.record.has_value());
      issues.add(location, what, why, fix);
    }
  }
  if (!issues.empty()) return plan;
  set_noise(study, plan.record.record);
  check_overlap(study, *other.record, plan.record.record, issues);
  set_start(validate, place, plan, issues);
  plan.signals = study.structure->signals;
  SignalNotes notes;  // the case's own record has told the remarks
  if (validate.record) plan.signals = make_signals(other, plan.record.record.end(), issues, notes);
  std::ranges::move(notes.preparation, std::back_inserter(plan.record.preparation));
  if (issues.empty()) check_cover(study, plan, issues);
  return plan;
}

}  // namespace kalfem
