// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "kalfem/casefile/description.hpp"
#include "kalfem/study/assembly.hpp"
#include "kalfem/study/case_study.hpp"

/// Checks of a case that need no computation: sections that need each other, names that do not exist, keys that
/// contradict one another. Problems go to `issues` with their place.
namespace kalfem {

/// Sections that need or exclude each other.
void check_sections(const description::Case& given, IssueList& issues);
/// Points, connectors and gauges that sensors name. `model`: of the structure.
void check_sensor_names(const description::Case& given, const CoupledModel& model, IssueList& issues);
/// Substructures, points and gauges that `predict` and `report` name.
void check_reported_names(const description::Case& given, const CoupledModel& model, IssueList& issues);
/// Duration, sampling, steps and initial state of `simulate`.
void check_simulation(const CaseStudy& study, IssueList& issues);
/// Durations in `report` must fit the sampling of the record.
void check_pictures(const CaseStudy& study, IssueList& issues);
/// Signals must be known over the whole record.
void check_signals(const CaseStudy& study, IssueList& issues);
/// The filter's initial state and its inputs.
void check_estimation(const description::Case& given, IssueList& issues);
/// A parameter must not stand under both `update` and `estimate`.
void check_parameters_once(const description::Case& given, IssueList& issues);

/// Keys of the case that have no effect, one sentence each: options of an integrator, filter or search that is not
/// used, options of finite elements in a case without them, options of connectors outside a local augmented model.
std::vector<std::string> keys_without_effect(const description::Case& given);

/// Measured inputs that are filtered otherwise than the sensors' channels, one sentence each: the model would see
/// motion that the sensors do not show, or the other way round.
std::vector<std::string> unlike_filters(const description::Case& given);

/// Checks the points and grounds that connectors and excitations name. They must exist. A driven ground must be a
/// ground, be driven once, and move something. A connector must not join two fixed grounds. Problems go to `issues`
/// with their place in the file.
void check_places(const description::Case& given, const StructureParts& parts, IssueList& issues);

}  // namespace kalfem
