// SPDX-License-Identifier: Apache-2.0
#include "kalfem/study/study.hpp"

#include <algorithm>
#include <iterator>

#include "kalfem/base/stopwatch.hpp"
#include "kalfem/casefile/case_schema.hpp"
#include "kalfem/identification/augmented_model_setup.hpp"
#include "kalfem/identification/filter_run.hpp"
#include "kalfem/identification/parameterised_structure.hpp"
#include "kalfem/study/assembly.hpp"
#include "kalfem/study/case_checks.hpp"
#include "kalfem/study/component_parts.hpp"
#include "kalfem/study/estimation_problem_of.hpp"
#include "kalfem/study/filter_checks.hpp"
#include "kalfem/study/inference_plan.hpp"
#include "kalfem/study/joints.hpp"
#include "kalfem/study/known_to_of.hpp"
#include "kalfem/study/law_alternatives.hpp"
#include "kalfem/study/live_plan.hpp"
#include "kalfem/study/making_steps.hpp"
#include "kalfem/study/placement_plan.hpp"
#include "kalfem/study/record_source.hpp"
#include "kalfem/study/structural_modifications.hpp"
#include "kalfem/study/study_elements.hpp"
#include "kalfem/study/updating_setup.hpp"
#include "kalfem/study/written_units.hpp"
#include "kalfem/yaml/case_reader.hpp"

namespace kalfem {

std::string Study::written_unit(const std::string& parameter) const {
  const auto found = units.find(parameter);
  return found == units.end() ? "" : found->second;
}

double Study::sample_rate() const {
  if (record) return record->record.sample_rate;
  if (simulation) return simulation->sample_rate;
  return description && description->live ? description->live->value.sample_rate : 0.0;
}

namespace {

namespace d = description;

/// The schema holds hundreds of keys, so it is made once.
const Schema<d::Case>& shared_case_schema() {
  static const Schema<d::Case> schema = d::case_schema();
  return schema;
}

/// The study of a case before any step: its plans, which need no name looked up.
CaseStudy planned_study(d::Case given, const std::string& file) {
  CaseStudy study;
  study.file = file;
  study.title = given.title;
  study.resolved_case = to_yaml(*shared_case_schema().write(given));
  study.excitation_band = excitation_band(given);
  if (given.simulate) study.simulation = make_simulation_plan(*given.simulate);
  if (given.predict) study.prediction = make_prediction_plan(*given.predict);
  study.report = make_report_plan(given.report);
  study.given = std::move(given);
  if (study.given.source.empty()) study.given.source = CaseSource(file, nullptr);
  return study;
}

bool has_finite_elements(const d::Case& given) {
  return std::ranges::any_of(given.substructures,
                             [](const auto& part) { return part.second.finite_elements.has_value(); });
}

/// Whether the signal has no duration of its own and so lasts as long as the simulation.
bool lasts_as_long_as_the_simulation(const std::pair<std::string, d::Excitation>& given) {
  if (!given.second.signal) return false;
  return std::visit(
      [](const auto& signal) {
        if constexpr (requires { signal.duration.has_value(); }) return !signal.duration.has_value();
        return false;
      },
      *given.second.signal);
}

/// The parts from which the augmented model is made: with an updating, those at its initial values.
StructureParts starting_parts(const CaseStudy& study) {
  if (!study.updating) return study.structure->parts;
  return ParameterisedStructure(study.structure, study.updating->bindings,
                                static_cast<Eigen::Index>(study.updating->parameters.size()))
      .at(initial_values(study.updating->parameters))
      .parts;
}

/// Makes a study of a case. Each step names its result, the items that it needs and the key at which its problems stand
/// if they state no place themselves; MakingSteps decides whether it runs.
class StudyMaker {
  using enum StudyItem;

public:
  StudyMaker(d::Case given, const std::string& file, const IssueList& found_by_reader, Progress progress = {})
      : study_(planned_study(std::move(given), file)),
        steps_(study_.given.source, found_by_reader),
        progress_(std::move(progress)) {
    study_.structure = structure_;
    leave_out_unread_sections();
    study_.description = std::make_shared<const d::Case>(study_.given);
    study_.files = study_.given.source.files();
    study_.units = written_units(study_.given.source);
    step(component, {}, {"component"}, [&](IssueList& issues) { expand_component(study_.given, issues); });
  }

  Study make() {
    make_structure();
    place_sensors();
    make_updating();
    make_estimation();
    make_stream();
    make_validation();
    make_inference();
    make_statics();
    make_frequency_response();
    raise_in_line_order(steps_.issues());
    add_warnings();
    return std::move(study_);  // without the rest that only the making needs
  }

private:
  void make_structure() {
    step(agreement_of_sections, {other_keys, substructures, sensors}, {},
         [&](IssueList& issues) { check_sections(study_.given, issues); });
    step(joint_names, {substructures, joints}, {"joints"},
         [&](IssueList& issues) { check_joints(study_.given, issues); });
    read_signals();
    step(elements, needs_of_elements(), {"substructures"},
         [&](IssueList& issues) { add_finite_elements(*structure_, study_, progress_, issues); });
    step(parts, {substructures, elements, component}, {"substructures"},
         [&](IssueList& issues) { structure_->parts = make_parts(study_.given, structure_->reduced_parts(), issues); });
    step(joined_nodes, {joint_names, elements, parts}, {"joints"}, [&](IssueList& issues) {
      structure_->parts.shared = make_joints(study_.given, *structure_, study_.warnings, issues);
    });
    step(names, {substructures, elements}, {"substructures"}, [&](IssueList& issues) { check_names(issues); });
    step(model, {substructures, elements, parts, joined_nodes, connectors, component, excitation, damping}, {"damping"},
         [&](IssueList&) {
           study_.model = std::make_shared<const CoupledModel>(couple(structure_->reference_parts()));
         });
  }

  /// What can be wrong without the matrices is told before they are made.
  void read_signals() {
    step(record, {record, sensors}, {"record", "file"}, [&](IssueList&) {
      if (study_.given.record) study_.record = read_measured_record(study_.given);
    });
    step(signals, needs_of_signals(), {"excitation"}, [&](IssueList& issues) { make_signals_of_inputs(issues); });
  }

  void place_sensors() {
    step(placed_sensors, {model, sensors}, {"sensors"},
         [&](IssueList& issues) { study_.sensors = make_sensors(study_, issues); });
    step(record_noise, {record, placed_sensors}, {"record"}, [&](IssueList&) {
      if (study_.record) set_noise(study_);  // throws if a channel has no noise
    });
    step(simulate, {model, simulate}, {"simulate"}, [&](IssueList& issues) { check_simulation(study_, issues); });
    step(pictures, {report, record, simulate}, {"report"}, [&](IssueList& issues) { check_pictures(study_, issues); });
    step(excitation, {parts, signals, simulate, record}, {"excitation"},
         [&](IssueList& issues) { check_signals(study_, issues); });
  }

  void make_updating() {
    step(parameters, {estimate, update}, {"estimate"},
         [&](IssueList& issues) { check_parameters_once(study_.given, issues); });
    step(update, {parts, model, placed_sensors, simulate, record, estimate, update}, {"update"},
         [&](IssueList& issues) {
           if (study_.given.update) study_.updating = make_updating_setup(study_, issues);
         });
    step(comparisons, {update, parameters}, {"update"}, [&](IssueList&) {
      if (study_.updating) study_.updating_plan = make_updating_plan(study_, study_.warnings);
    });
    step(modifications, {parts, model, modifications}, {"modifications"},
         [&](IssueList& issues) { study_.modifications = make_modifications(study_, issues); });
    step(modified_frequencies, {modifications}, {"modifications"},
         [&](IssueList&) { predict_modifications(study_, std::nullopt); });
  }

  void make_estimation() {
    step(estimate, {sensors, estimate}, {"estimate"},
         [&](IssueList& issues) { check_estimation(study_.given, issues); });
    step(augmented_model,
         {agreement_of_sections, parts, model, placed_sensors, signals, record, simulate, estimate, update, excitation,
          parameters},
         {"estimate"}, [&](IssueList& issues) {
           if (study_.given.estimate) make_augmented_model(issues);
         });
    step(filter, {augmented_model}, {"estimate", "kappa"}, [&](IssueList&) {
      if (study_.augmented_model) check_filter(study_);
    });
    step(alternatives, {augmented_model, filter, update}, {"estimate", "alternatives"}, [&](IssueList& issues) {
      if (study_.given.estimate && study_.given.estimate->alternatives)
        study_.alternatives = estimated_alternatives(study_, issues);
    });
    step(driven_substructure, {augmented_model, predict, record, simulate, estimate, update, excitation},
         {"predict", "substructure"}, [&](IssueList&) {
           if (study_.given.predict) check_driven(study_, *start_, study_.given.predict->substructure);
         });
    step(driven_comparisons, {augmented_model, record, simulate, estimate, update, excitation}, {"update", "compare"},
         [&](IssueList& issues) {
           if (study_.given.update && start_) check_driven_histories(study_, *start_, issues);
         });
  }

  void make_stream() {
    step(stream, {live, excitation, placed_sensors, augmented_model}, {"live"}, [&](IssueList& issues) {
      if (study_.given.live) check_live(study_, issues);
    });
  }

  void make_validation() {
    step(validate, {sensors, simulate, record, estimate, update, validate}, {"validate"}, [&](IssueList& issues) {
      if (study_.given.validate) check_validation(study_, issues);
    });
    step(validation,
         {agreement_of_sections, parts, placed_sensors, signals, record, record_noise, excitation, validate},
         {"validate"}, [&](IssueList& issues) {
           if (study_.given.validate) study_.validation = make_validation_plan(study_, issues);
         });
  }

  void make_inference() {
    step(inference, {augmented_model, filter, comparisons, validation, infer}, {"infer"}, [&](IssueList& issues) {
      if (study_.given.infer) study_.inference = make_inference_plan(study_, issues);
    });
    step(placement, {augmented_model, filter, inference, place}, {"place"}, [&](IssueList& issues) {
      if (study_.given.place) study_.placement = make_placement_plan(study_, issues);
    });
  }

  void make_statics() {
    step(static_analysis, {substructures, elements, statics}, {"static"}, [&](IssueList& issues) {
      if (study_.given.statics) study_.statics = make_statics_plan(study_.given, *structure_, issues);
    });
  }

  void make_frequency_response() {
    step(responses, {model, frequency_response}, {"frequency_response"}, [&](IssueList& issues) {
      if (study_.given.frequency_response)
        study_.frequency_response = make_frequency_response_plan(study_.given, *structure_, issues);
    });
  }

  void step(StudyItem result, StudyItems needs, std::vector<std::string> key,
            const std::function<void(IssueList&)>& make) {
    steps_.run({result, std::move(needs), std::move(key)}, make);
  }

  /// A section that cannot be used is left empty, so that no problem is told of its defaults.
  void leave_out_unread_sections() {
    auto& given = study_.given;
    if (!steps_.was_read(connectors)) given.connectors.clear();
    if (!steps_.was_read(component)) given.component.reset();
    if (!steps_.was_read(excitation)) given.excitation.clear();
    if (!steps_.was_read(damping)) given.damping.reset();
  }

  /// Finite elements are assembled for the points and parameters that other sections name.
  [[nodiscard]] StudyItems needs_of_elements() const {
    if (!has_finite_elements(study_.given)) return {substructures};
    return {substructures, joint_names, connectors,    excitation, sensors, simulate,
            estimate,      update,      modifications, statics,    signals};
  }

  /// Other problems of the excitation do not matter to its signals.
  [[nodiscard]] StudyItems needs_of_signals() const {
    const bool last_as_long = std::ranges::any_of(study_.given.excitation, lasts_as_long_as_the_simulation);
    if (last_as_long && !steps_.was_read(simulate)) return {simulate};
    return {};
  }

  void check_names(IssueList& issues) {
    const CoupledModel model = couple({structure_->parts.substructures, structure_->parts.finite_elements, {}, {}});
    if (steps_.is_sound(sensors) && steps_.was_read(connectors) && steps_.is_sound(component))
      check_sensor_names(study_.given, model, issues);
    if (steps_.is_sound(report) && steps_.is_sound(predict)) check_reported_names(study_.given, model, issues);
  }

  void make_signals_of_inputs(IssueList& issues) {
    constexpr double duration_without_simulation = 10.0;  // [s]
    const double duration = study_.given.simulate ? study_.given.simulate->duration : duration_without_simulation;
    SignalNotes notes;
    structure_->signals = make_signals(study_.given, duration, issues, notes);
    std::ranges::move(notes.remarks, std::back_inserter(study_.warnings));
    auto& preparation = study_.record ? study_.record->preparation : study_.warnings;
    std::ranges::move(notes.preparation, std::back_inserter(preparation));
  }

  void make_augmented_model(IssueList& issues) {
    auto problem = std::make_shared<EstimationProblem>(make_estimation_problem(study_, issues));
    study_.problem = problem;
    if (!issues.empty()) return;
    const StructureParts start = starting_parts(study_);
    study_.augmented_model = make_augmented_model_setup(*problem, start, {}, issues);
    problem->settings.known_to =
        known_to_of(study_.given.estimate->known_to, *problem, start, *study_.augmented_model, issues);
    check_augmented_model(study_, issues);
    start_ = study_.updating ? std::make_shared<const CoupledModel>(couple(start)) : study_.model;
  }

  void add_warnings() {
    for (auto& warning : doubtful_estimation(study_)) study_.warnings.push_back(std::move(warning));
    for (auto& warning : keys_without_effect(study_.given)) study_.warnings.push_back(std::move(warning));
    for (auto& warning : unlike_filters(study_.given)) study_.warnings.push_back(std::move(warning));
    warn_of_reductions(study_);
  }

  CaseStudy study_;
  std::shared_ptr<StructureModel> structure_ = std::make_shared<StructureModel>();  ///< of the study, while it is made
  std::shared_ptr<const CoupledModel> start_;  ///< the model from which a prediction or an updating starts
  MakingSteps steps_;
  Progress progress_;
};

}  // namespace

Study load_study(const std::string& file, const std::vector<CaseChange>& changes, const Progress& progress) try {
  const Stopwatch watch;
  IssueList issues;
  d::Case given =
      read_case_text(read_text_file(file), file, shared_case_schema(), issues, process_environment(), changes);
  if (given.source.empty()) raise_in_line_order(issues);
  Study study = StudyMaker(std::move(given), file, issues, progress).make();
  study.load_seconds = watch.seconds();
  return study;
} catch (const InvalidInput& error) {
  if (changes.empty()) throw;
  throw InvalidInput(with_changes_named(error.issues(), changes));
}

Study make_study(d::Case given, const std::string& file) { return StudyMaker(std::move(given), file, {}).make(); }

}  // namespace kalfem
