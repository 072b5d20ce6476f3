#pragma once

#include <string>
#include <vector>

#include "kalfem/casefile/description.hpp"
#include "kalfem/study/assembly.hpp"
#include "kalfem/study/case_study.hpp"

/// What a case may not say, as far as it shows without computing: sections that need each other, names that do not
/// exist, keys that contradict one another. Problems go to `issues` with their place.
namespace kalfem {

/// Sections that need or exclude each other.
void check_sections(const description::Case& given, IssueList& issues);
/// Points and connectors that sensors name. `points`: those of the structure.
void check_sensor_names(const description::Case& given, const std::vector<std::string>& points, IssueList& issues);
/// Substructures and points that `predict` and `report` name. `points`: those whose motion is reported.
void check_reported_names(const description::Case& given, const std::vector<std::string>& points, IssueList& issues);
/// Length, sampling and steps of `simulate`, and where it starts.
void check_simulation(const CaseStudy& study, IssueList& issues);
/// Lengths of the report's pictures against the record's sampling.
void check_pictures(const CaseStudy& study, IssueList& issues);
/// Signals that are not known over the whole record.
void check_signals(const CaseStudy& study, IssueList& issues);
/// What the filter starts from and what drives it.
void check_estimation(const description::Case& given, IssueList& issues);
/// Parameters that `update` refines and `estimate` estimates.
void check_parameters_once(const description::Case& given, IssueList& issues);

/// Keys that the case gives and that nothing reads, one sentence each: options of another integrator, filter or search,
/// of finite elements where there are none, of connectors that a local augmented model leaves out.
std::vector<std::string> keys_without_effect(const description::Case& given);

/// Points and grounds that connectors and excitations name: they must exist, a moving ground must be one, be driven
/// once and be felt by something, and a connector must not end at two grounds that stand still. Problems go to `issues`
/// with their place in the file.
void check_places(const description::Case& given, const StructureParts& parts, IssueList& issues);

}  // namespace kalfem
