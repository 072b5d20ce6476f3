#include "kalfem/study/study.hpp"

#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>

#include "kalfem/casefile/description_form.hpp"
#include "kalfem/identification/augmented_model_setup.hpp"
#include "kalfem/identification/filter_run.hpp"
#include "kalfem/identification/parameterised_structure.hpp"
#include "kalfem/study/assembly.hpp"
#include "kalfem/study/case_checks.hpp"
#include "kalfem/study/comparisons.hpp"
#include "kalfem/study/estimation_problem_of.hpp"
#include "kalfem/study/filter_checks.hpp"
#include "kalfem/study/modifications_setup.hpp"
#include "kalfem/study/record_noise.hpp"
#include "kalfem/study/record_source.hpp"
#include "kalfem/study/structural_modifications.hpp"
#include "kalfem/study/study_elements.hpp"
#include "kalfem/study/updating_setup.hpp"
#include "kalfem/yaml/bounds.hpp"
#include "kalfem/yaml/case_reader.hpp"

namespace kalfem {
namespace {

namespace d = description;

Sensor make_sensor(const std::string& name, const d::Sensor& given, const SourceLocation& location) {
  Sensor sensor;
  sensor.location = location;
  sensor.name = name;
  std::visit(
      [&](const auto& observed) {
        sensor.output = {
            name, observed.quantity, {observed.points.value.begin(), observed.points.value.end()}, given.relative};
      },
      given.observed);
  sensor.unit = unit_of(sensor.output.quantity);
  sensor.relative_noise = !given.noise.value.bare && given.noise.value.dimension == Dimension{};
  sensor.noise =
      sensor.relative_noise ? given.noise.value.value : checked_number(given.noise, sensor.unit, Bounds::nonnegative());
  if (!(sensor.noise >= 0.0))
    throw InvalidInput(given.noise.issue("the noise is negative", "a standard deviation must not be negative"));
  sensor.chain = MeasurementChain({given.chain});
  return sensor;
}

/// What a sensor relative to the base is relative to must move.
void check_relative(const CaseStudy& study, const d::Sensor& given, const d::Points& points, IssueList& issues) {
  const bool uniform = std::ranges::any_of(
      study.structure->parts.inputs, [](const auto& input) { return input.kind == InputKind::base_acceleration; });
  const bool of_connector = std::visit(
      [](const auto& observed) { return observed.quantity > ObservedQuantity::acceleration; }, given.observed);
  if (given.relative && !uniform && !of_connector)
    issues.add(points.location,
               points.path + " is relative to the accelerated base, but the case does not accelerate a whole base",
               "when single grounds move, displacements are absolute",
               "write {point: 1, ground: -1} for the motion relative to a ground");
}

void add_sensors(CaseStudy& study, IssueList& issues) {
  for (const auto& [name, given] : study.given.sensors) {
    const auto location = std::visit([](const auto& observed) { return observed.points.location; }, given.observed);
    try {
      study.sensors.push_back(make_sensor(name, given, study.given.source.at({"sensors", name})));
      std::visit([&](const auto& observed) { check_relative(study, given, observed.points, issues); }, given.observed);
      make_outputs(*study.model, {study.sensors.back().output});
    } catch (const InvalidInput& error) {
      issues.add(error, location);
    }
  }
}

SimulationPlan simulation_plan(const d::Simulation& given) {
  SimulationPlan plan{.duration = given.duration, .sample_rate = given.sample_rate};
  plan.integration.integrator = given.integrator;
  plan.integration.duration = given.duration;
  plan.integration.hht_alpha = given.hht_alpha;
  plan.integration.spectral_radius = given.spectral_radius;
  plan.convergence = {.sample_rate = given.sample_rate,
                      .first_substeps = given.substeps ? given.substeps->value : given.first_substeps,
                      .max_substeps = given.substeps ? given.substeps->value : given.max_substeps,
                      .tolerance = given.tolerance,
                      .refine = !given.substeps};
  plan.initial = given.initial;
  plan.seed = given.seed;
  return plan;
}

ReportPlan report_plan(const d::Report& given) {
  ReportPlan plan{.modes = given.modes, .zoom = given.zoom, .superelements = given.superelements.value};
  if (given.fields) plan.pictures = PicturePlan{given.fields->substructure.value, given.fields->every};
  for (const auto& point : given.displacements) plan.displacements.push_back(point.value);
  return plan;
}

/// The parts from which the augmented model is made: an updating begins at its own first guesses.
StructureParts starting_parts(const CaseStudy& study) {
  if (!study.updating) return study.structure->parts;
  return ParameterisedStructure(study.structure, study.updating->bindings,
                                static_cast<Eigen::Index>(study.updating->parameters.size()))
      .at(initial_values(study.updating->parameters))
      .parts;
}

/// What is allowed but probably not meant.
void warn(CaseStudy& study) {
  if (study.given.estimate && study.given.simulate && study.given.estimate->settle >= study.given.simulate->duration)
    study.warnings.push_back("estimate.settle is not shorter than the record: errors and NIS use the last sample only");
  if (!study.augmented_model) return;
  for (const auto& unknown : study.augmented_model->options.unknowns) {
    const auto entry =
        std::ranges::find(study.given.estimate->unknown, unknown.name, &std::pair<std::string, d::Unknown>::first);
    if (entry == study.given.estimate->unknown.end()) continue;  // a rest position, which may be negative
    const auto& given = entry->second;
    if (unknown.transform.kind == TransformKind::none && given.std && !given.std->value.bare &&
        unknown.initial != 0.0 && unknown.deviation > 0.6 * std::abs(unknown.initial))
      study.warnings.push_back(
          "unknown '" + unknown.name +
          "' has a wide prior and no transform, so sigma points may become negative; set transform: log");
  }
}

}  // namespace

double Study::sample_rate() const {
  return record ? record->record.sample_rate : simulation ? simulation->sample_rate : 0.0;
}

namespace {

/// Made once: a table of hundreds of keys.
const Schema<d::Case>& form_of_cases() {
  static const Schema<d::Case> form = d::case_schema();
  return form;
}

/// Makes a study step by step. A step is left out where something that it needs has a problem, so that the problems of
/// independent parts of a case are told together and none is told that only follows from another.
class StudyMaker {
public:
  StudyMaker(d::Case given, const std::string& file, const IssueList& already_found) : issues_(already_found) {
    study_.file = file;
    study_.structure = structure_;
    study_.given = std::move(given);
    if (study_.given.source.empty()) study_.given.source = CaseSource(file, nullptr);
    take_plans();
    unsound_ = study_.given.source.sections_of(issues_.issues());
    if (std::ranges::any_of(unsound_, [](const auto& name) { return !is_section(name); })) unsound_.insert("file");
    not_read_ = unsound_;
    leave_out_unsound();
  }

  Study make() {
    read_structure();
    read_record();
    read_updating();
    read_estimation();
    raise_in_line_order(issues_);
    warn(study_);
    for (auto& warning : keys_without_effect(study_.given)) study_.warnings.push_back(std::move(warning));
    warn_of_reductions(study_);
    return std::move(study_);  // without the case
  }

private:
  using Names = std::vector<std::string>;

  void read_structure() {
    const Names around = {"connectors", "excitation", "sensors", "simulate", "estimate", "update", "modifications"};
    step("sections", {"file", "substructures", "sensors"}, {},
         [&](IssueList& issues) { check_sections(study_.given, issues); });
    step("elements", has_finite_elements() ? joined({"substructures"}, around) : Names{"substructures"},
         {"substructures"}, [&](IssueList& issues) { add_finite_elements(*structure_, study_, issues); });
    step("parts", {"substructures", "elements"}, {"substructures"},
         [&](IssueList& issues) { structure_->parts = make_parts(study_.given, structure_->reduced_parts(), issues); });
    step("names", {"substructures", "elements"}, {"substructures"}, [&](IssueList& issues) { check_names(issues); });
    step("model", {"substructures", "elements", "parts", "connectors", "excitation", "damping"}, {"damping"},
         [&](IssueList&) {
           study_.model = std::make_shared<const CoupledModel>(couple(structure_->reference_parts()));
         });
  }

  void read_record() {
    step("record", {"record", "sensors"}, {"record", "file"}, [&](IssueList&) {
      if (study_.given.record) study_.record = read_measured_record(study_.given);
    });
    step("placed sensors", {"model", "sensors"}, {"sensors"}, [&](IssueList& issues) { add_sensors(study_, issues); });
    step("noise of the record", {"record", "placed sensors"}, {"record"}, [&](IssueList&) {
      if (study_.record) set_noise(study_);
    });
    const bool needs_duration = std::ranges::any_of(study_.given.excitation, lasts_as_long_as_the_simulation);
    const bool has_duration = !needs_duration || !not_read_.contains("simulate");
    const Names grounds = {"substructures", "elements"};  // other problems of the excitation do not matter here
    step("signals", has_duration ? grounds : joined({"simulate"}, grounds), {"excitation"}, [&](IssueList& issues) {
      const double duration = study_.given.simulate ? study_.given.simulate->duration : 10.0;
      structure_->signals = make_signals(study_.given, structure_->parts.inputs, duration, issues, study_.warnings);
    });
    step("simulate", {"model", "simulate"}, {"simulate"}, [&](IssueList& issues) { check_simulation(study_, issues); });
    step("pictures", {"report", "record", "simulate"}, {"report"},
         [&](IssueList& issues) { check_pictures(study_, issues); });
    step("excitation", {"parts", "signals", "simulate", "record"}, {"excitation"},
         [&](IssueList& issues) { check_signals(study_, issues); });
  }

  void read_updating() {
    step("parameters", {"estimate", "update"}, {"estimate"},
         [&](IssueList& issues) { check_parameters_once(study_.given, issues); });
    step("update", {"parts", "model", "placed sensors", "simulate", "record", "estimate", "update"}, {"update"},
         [&](IssueList& issues) {
           if (study_.given.update) study_.updating = make_updating_setup(study_, issues);
         });
    step("comparisons", {"update", "parameters"}, {"update"}, [&](IssueList&) {
      if (study_.updating) study_.updating_plan = make_updating_plan(study_);
    });
    step("modifications", {"parts", "model", "modifications"}, {"modifications"},
         [&](IssueList& issues) { study_.modifications = make_modifications(study_, issues); });
    step("modified", {"modifications"}, {"modifications"},
         [&](IssueList&) { predict_modifications(study_, std::nullopt); });
  }

  void read_estimation() {
    step("estimate", {"sensors", "estimate"}, {"estimate"},
         [&](IssueList& issues) { check_estimation(study_.given, issues); });
    const Names all = {"sections", "parts",    "model",  "placed sensors", "signals",   "record",
                       "simulate", "estimate", "update", "excitation",     "parameters"};
    step("observer", all, {"estimate"}, [&](IssueList& issues) {
      if (!study_.given.estimate) return;
      study_.problem = std::make_shared<const EstimationProblem>(make_estimation_problem(study_, issues));
      if (!issues.empty()) return;
      const StructureParts start = starting_parts(study_);
      study_.augmented_model = make_augmented_model_setup(*study_.problem, start, {}, issues);
      check_augmented_model(study_, issues);
      start_ = study_.updating ? std::make_shared<const CoupledModel>(couple(start)) : study_.model;
    });
    step("filter", joined({"observer"}, all), {"estimate", "kappa"}, [&](IssueList&) {
      if (study_.augmented_model) check_filter(study_);
    });
    step("prediction", joined({"observer", "predict"}, all), {"predict", "substructure"}, [&](IssueList&) {
      if (study_.given.predict) check_driven(study_, *start_, study_.given.predict->substructure);
    });
    step("histories", joined({"observer"}, all), {"update", "compare"}, [&](IssueList& issues) {
      if (study_.given.update && start_) check_driven_histories(study_, *start_, issues);
    });
  }

  /// What needs no look-up.
  void take_plans() {
    const d::Case& given = study_.given;
    study_.title = given.title;
    study_.resolved_case = to_yaml(*form_of_cases().write(given));
    study_.excitation_band = excitation_band(given);
    if (given.simulate) study_.simulation = simulation_plan(*given.simulate);
    if (given.predict) study_.prediction = PredictionPlan{given.predict->substructure, given.predict->substeps};
    study_.report = report_plan(given.report);
  }

  /// Runs a step where all that it needs is sound. What it finds makes `result` unsound, and the sections that hold the
  /// places; `place` is for problems that do not know theirs.
  void step(const std::string& result, const Names& needs, const Names& place,
            const std::function<void(IssueList&)>& run) {
    if (std::ranges::any_of(needs, [&](const auto& name) { return unsound_.contains(name); })) {
      unsound_.insert(result);
      return;
    }
    IssueList found, placed;
    try {
      run(found);
    } catch (const InvalidInput& error) {
      add_at(study_.given.source.at(place), error, found);
    }
    if (found.empty()) return;
    add_at(study_.given.source.at(place), InvalidInput(found.issues()), placed);
    unsound_.insert(result);
    unsound_.merge(study_.given.source.sections_of(placed.issues()));
    for (const auto& [location, what, why, fix] : placed.issues()) issues_.add(location, what, why, fix);
  }

  void check_names(IssueList& issues) {
    const CoupledModel points = couple({structure_->parts.substructures, structure_->parts.finite_elements, {}, {}});
    if (!unsound_.contains("sensors") && !not_read_.contains("connectors"))
      check_sensor_names(study_.given, points.point_names(), issues);
    if (!unsound_.contains("report") && !unsound_.contains("predict"))
      check_reported_names(study_.given, points.reported_points(), issues);
  }

  /// Sections that cannot be used are left empty, so that no problem follows from what they may have meant.
  void leave_out_unsound() {
    auto& given = study_.given;
    if (unsound_.contains("connectors")) given.connectors.clear();
    if (unsound_.contains("excitation")) given.excitation.clear();
    if (unsound_.contains("damping")) given.damping.reset();
  }

  [[nodiscard]] bool has_finite_elements() const {
    return std::ranges::any_of(study_.given.substructures,
                               [](const auto& part) { return part.second.finite_elements.has_value(); });
  }

  /// Whether the signal's duration is that of the simulation, as it has none of its own.
  static bool lasts_as_long_as_the_simulation(const std::pair<std::string, d::Excitation>& given) {
    return std::visit(
        [](const auto& signal) {
          if constexpr (requires { signal.duration.has_value(); }) return !signal.duration.has_value();
          return false;
        },
        given.second.signal);
  }

  static bool is_section(const std::string& name) {
    return form_of_cases().json_schema().json().at("properties").contains(name);
  }

  static Names joined(Names one, const Names& other) {
    one.insert(one.end(), other.begin(), other.end());
    return one;
  }

  CaseStudy study_;
  std::shared_ptr<StructureModel> structure_ = std::make_shared<StructureModel>();  ///< of the study, while it is made
  std::shared_ptr<const CoupledModel> start_;  ///< what a prediction, or an updating, starts from
  IssueList issues_;
  std::set<std::string> unsound_;   ///< sections and results with a problem
  std::set<std::string> not_read_;  ///< sections that could not be read as they stand
};

}  // namespace

Study load_study(const std::string& file) {
  IssueList issues;
  d::Case given = read_case_text(read_text_file(file), file, form_of_cases(), issues);
  if (given.source.empty()) raise_in_line_order(issues);
  return StudyMaker(std::move(given), file, issues).make();
}

Study make_study(d::Case given, const std::string& file) { return StudyMaker(std::move(given), file, {}).make(); }

}  // namespace kalfem
