// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "kalfem/study/case_study.hpp"
#include "kalfem/updating/modal_residual.hpp"

/// The case's `update` as parameters, search options and residuals of the library.
namespace kalfem {

/// The parameters of the case's `update`. Problems go to `issues` with their place: names that no substructure has,
/// bounds that exclude the initial value, one parameter under two names.
UpdatingSetup make_updating_setup(const CaseStudy& study, IssueList& issues);

/// The search and the comparisons. Needs the study's setup. Throws InvalidInput with every problem of the comparisons.
UpdatingPlan make_updating_plan(const CaseStudy& study, std::vector<std::string>& warnings);

/// Adds everything under `update.compare` to the plan, in the order of the file: residuals of the comparisons that need
/// no record, and the requests of those that do. Throws InvalidInput with every problem and its place.
void add_comparisons(const CaseStudy& study, UpdatingPlan& plan, std::vector<std::string>& warnings);

/// What a comparison of modes measured, and the points of the substructure where it did.
struct ModalMeasurement {
  std::vector<MeasuredMode> modes;
  std::vector<DofCombination> points = {};  ///< of the shapes
  std::vector<std::string> places = {};     ///< their names in the substructure
  std::vector<std::string> sensors = {};    ///< and those of the sensors
};
/// As it stands in the case, in tables or in a file of modes. `model`: the substructure. Throws InvalidInput.
ModalMeasurement modal_measurement(const description::ModalData& given, const LinearModel& model);
/// The same without the shapes, of modes that the case or its tables list.
std::vector<MeasuredMode> listed_modes(const description::ModalData& given);
bool has_shapes(const description::ModalData& given);
bool has_dampings(const description::ModalData& given);

/// A point by its name in the substructure: a degree of freedom or a named combination. Throws InvalidInput.
DofCombination point_of(const LinearModel& model, const Name& name);

/// Checks the comparisons without computing: their substructures and sensors must exist, and so must the record if they
/// need one. Problems go to `issues`.
void check_comparisons(const CaseStudy& study, IssueList& issues);

/// Checks the comparisons that need the estimated motion of a boundary, once there is an augmented model. `start`: the
/// structure that the updating starts from. Problems go to `issues`.
void check_driven_histories(const CaseStudy& study, const CoupledModel& start, IssueList& issues);

/// The sensors that the comparison names, or all that measure the motion of its substructure alone. Throws InvalidInput
/// if a named one does not, or if there is none.
std::vector<std::string> compared_sensors(const CaseStudy& study, const description::DrivenHistory& given);
/// The sensors that the comparison names, or all. Throws InvalidInput if there is none.
std::vector<std::string> compared_sensors(const CaseStudy& study, const description::SimulatedHistory& given);

}  // namespace kalfem
