// SPDX-License-Identifier: Apache-2.0
#include "kalfem/study/updating_setup.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "kalfem/casefile/update_description.hpp"
#include "kalfem/formats/frequency_response_file.hpp"
#include "kalfem/formats/record_file.hpp"
#include "kalfem/updating/frf_record_residual.hpp"
#include "kalfem/updating/frf_residual.hpp"
#include "kalfem/updating/modal_residual.hpp"
#include "kalfem/updating/static_residual.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

namespace d = description;

/// Smoothing of frequency responses decreases to the first width divided by this number, then stops.
constexpr double smoothing_range = 10.0;

/// ", dampings and mode shapes", as far as they are there.
std::string kinds_beside(const std::vector<MeasuredMode>& modes) {
  const bool dampings = std::ranges::any_of(modes, [](const auto&mode) { return mode.damping.has_value(); }),
             shapes = std::ranges::any_of(modes, [](const auto&mode) { return mode.shape.size() > 0; });
  return dampings && shapes ? ", dampings and mode shapes"
         : dampings         ? " and dampings"
         : shapes           ? " and mode shapes"
                            : "";
}

/// Makes the residual of each kind of comparison. Each reads its measurement, converts it to SI with a deviation per
/// value, and attaches it to the substructure as a function of the updated parameters. With smoothing, an FRF
/// comparison gives one residual per width, from the widest to the narrowest; the search follows them in this order
/// (continuation).
class ResidualMaker {
public:
  ResidualMaker(const CaseStudy& study, std::shared_ptr<const ParameterisedStructure> structure, std::string name,
                std::vector<std::string>& warnings)
      : study_(study), structure_(std::move(structure)), name_(std::move(name)), warnings_(warnings) {}

  ComparisonResidual operator()(const d::ModalData& given) const {
    const auto model = structure_->model_of(given.substructure.value);
    auto measured = modal_measurement(given, model->at(start()).model);
    ModalResidualOptions options;
    options.above = given.above;
    options.pairing.least_mac = given.minimum_mac;
    return {name_,
            "natural frequencies" + kinds_beside(measured.modes) + " of '" + given.substructure.value + "'",
            {std::make_shared<ModalResidual>(model, measured.modes, measured.points, start(), options)}};
  }

  ComparisonResidual operator()(const d::FrfData& given) const {
    const auto records = std::ranges::count_if(given.inputs, is_record);
    if (records > 0 && records < std::ssize(given.inputs))
      throw InvalidInput(owner() + " mixes records and tables of frequency responses",
                         "records are compared by their spectra, which have deviations of their own",
                         "put the tables into a comparison of their own under `compare`");
    FrfResidualOptions options;
    options.form = given.compare == d::FrfComparison::logarithm       ? FrfForm::log
                   : given.compare == d::FrfComparison::log_magnitude ? FrfForm::log_magnitude
                                                                      : FrfForm::complex_difference;
    options.scale = given.scale;
    for (const auto& band : given.bands) options.bands.push_back({band[0], band[1]});
    options.relative_deviation = given.deviation;
    options.floor = given.floor;
    const bool of_spectra = records > 0 && given.compare != d::FrfComparison::log_magnitude;
    return of_spectra ? spectra_comparison(given, options) : response_comparison(given, options);
  }

  ComparisonResidual operator()(const d::StaticData& given) const {
    const auto model = structure_->model_of(given.substructure.value);
    const auto start_model = model->at(start()).model;
    StaticTest test{name_, {}, {}};
    double largest = 0.0;
    for (const auto& [point, value] : given.displacements) largest = std::max(largest, std::abs(value.value));
    for (const auto& [point, force] : given.loads)
      test.forces.push_back({point_of(start_model, {point, force.location, force.path}), force.value});
    for (const auto& [point, value] : given.displacements)
      test.displacements.push_back(
          {point_of(start_model, {point, value.location, value.path}), value.value, given.deviation * largest});
    return {name_,
            "static displacements of '" + given.substructure.value + "'",
            {std::make_shared<StaticResidual>(model, std::vector{test}, start())}};
  }

  template <class History>
  ComparisonResidual operator()(const History&) const {
    throw std::logic_error("a comparison with the record is not a residual before there is one");
  }

private:
  [[nodiscard]] VectorXd start() const { return initial_values(study_.updating->parameters); }

  static bool is_record(const d::FrfInput& input) { return std::holds_alternative<d::FrfRecordSource>(input.source); }

  /// FRFs as they are in a file, or magnitudes from records.
  [[nodiscard]] ComparisonResidual response_comparison(const d::FrfData& given,
                                                       const FrfResidualOptions& options) const {
    std::vector<MeasuredFrf> measured;
    for (const auto& input : given.inputs) measured.push_back(measured_frf(given, input));
    ComparisonResidual comparison{name_, "frequency responses of '" + given.substructure.value + "'", {}};
    add_responses(given, measured, options, comparison);
    return comparison;
  }

  /// Records by their spectra. The search comes near by local rational fits of the FRFs, as logarithms are far less
  /// sensitive to the start.
  [[nodiscard]] ComparisonResidual spectra_comparison(const d::FrfData& given,
                                                      const FrfResidualOptions& options) const {
    std::vector<FrfRecord> records;
    for (const auto& input : given.inputs) {
      const auto [record, outputs] = read_record(given, input);
      const auto& source = std::get<d::FrfRecordSource>(input.source);
      if (source.segment != d::FrfRecordSource{}.segment)
        warnings_.push_back(owner() +
                            ".inputs: `segment` has no effect: the whole record is compared, without "
                            "segments; they are for compare: log_magnitude");
      records.push_back(
          frf_record(source.file.value.string(), record, source.input, outputs, set_of(given, input), options.bands));
    }
    ComparisonResidual comparison{
        name_, "spectra of records of '" + given.substructure.value + "' by its frequency responses", {}};
    add_responses(given, local_rational_responses(records), options, comparison);
    FrfResidualOptions of_noise = options;
    if (!study_.given.source.gives({"update", "compare", name_, "deviation"})) of_noise.relative_deviation = 0.0;
    comparison.continuation_steps.push_back(std::make_shared<FrfRecordResidual>(
        structure_->model_of(given.substructure.value), records, start(), of_noise));
    return comparison;
  }

  /// From the widest smoothing to none.
  void add_responses(const d::FrfData& given, const std::vector<MeasuredFrf>& measured, FrfResidualOptions options,
                     ComparisonResidual& comparison) const {
    const auto model = structure_->model_of(given.substructure.value);
    const auto widths = given.smoothing > 0.0 ? smoothing_widths(given.smoothing, given.smoothing / smoothing_range)
                                              : std::vector<double>{0.0};
    for (const double width : widths) {
      options.smoothing = width;
      comparison.continuation_steps.push_back(std::make_shared<FrfResidual>(model, measured, start(), options));
    }
  }

  [[nodiscard]] FrfSet set_of(const d::FrfData& given, const d::FrfInput& input) const {
    FrfSet set;
    if (const auto* force = std::get_if<d::FrfForce>(&input.input))
      set = {FrfInput::force, force->point.value, {}, {}};
    else
      set = {FrfInput::ground_acceleration, std::get<d::FrfGround>(input.input).ground.value, {}, {}};
    for (const auto& output : given.outputs) set.outputs.push_back(output.value);
    set.quantity = given.quantity == d::FrfQuantity::displacement ? ResponseQuantity::displacement
                   : given.quantity == d::FrfQuantity::velocity   ? ResponseQuantity::velocity
                                                                  : ResponseQuantity::acceleration;
    return set;
  }

  /// The record of an input with the names of its outputs.
  [[nodiscard]] std::pair<Record, std::vector<std::string>> read_record(const d::FrfData& given,
                                                                        const d::FrfInput& input) const {
    const auto& source = std::get<d::FrfRecordSource>(input.source);
    std::vector<std::string> outputs = input.columns;
    if (outputs.empty())
      for (const auto& output : given.outputs) outputs.push_back(output.value);
    if (std::ranges::find(outputs, source.input) != outputs.end())
      throw InvalidInput(source.file.issue("the column '" + source.input + "' is both input and output", "",
                                           "list the columns of the outputs under `columns`"));
    if (outputs.size() != given.outputs.size())
      throw InvalidInput(source.file.issue(
          std::to_string(outputs.size()) + " columns for " + std::to_string(given.outputs.size()) + " outputs",
          "every output needs a column", "name one column per output"));
    std::vector<WantedChannel> columns;
    for (const auto& output : outputs)
      columns.push_back({.column = output, .owner = owner(), .unit = unit_of(given.quantity)});
    columns.push_back({.column = source.input, .owner = owner(), .unit = unit_of(input)});
    return {
        read_record_file(source.file.value, columns, {.sample_rate = source.sample_rate, .dataset = source.dataset}),
        std::move(outputs)};
  }

  [[nodiscard]] MeasuredFrf measured_frf(const d::FrfData& given, const d::FrfInput& input) const {
    MeasuredFrf measured{.name = {}, .response = {}, .set = set_of(given, input)};
    if (const auto* table = std::get_if<d::FrfFile>(&input.source)) {
      measured.name = table->file.value.string();
      measured.response =
          read_frequency_responses(table->file.value, {.outputs = input.columns, .content = table->values});
      convert_to_si(measured.response, unit_of(given.quantity), input, table->file.value.string());
      return measured;
    }
    const auto& source = std::get<d::FrfRecordSource>(input.source);
    measured.name = source.file.value.string();
    const auto [record, outputs] = read_record(given, input);
    const auto segment = static_cast<Index>(std::llround(source.segment * record.sample_rate));
    measured.response = estimate_h1(std::span(&record, 1), source.input, outputs, {.segment = segment}).response;
    refuse_leakage(measured.response, given, source);
    return measured;
  }

  /// A window widens a resonance by about one and a half lines: where its half-power bandwidth 2 zeta f is not much
  /// more, the damping comes out too large.
  static void refuse_leakage(const FrequencyResponse& response, const d::FrfData& given,
                             const d::FrfRecordSource& source) {
    constexpr double fewest_lines = 2.0;
    const auto in_bands = [&](double frequency) {
      return given.bands.empty() || std::ranges::any_of(given.bands, [&](const auto& band) {
               return frequency >= band[0] && frequency <= band[1];
             });
    };
    for (const auto& peak : find_peaks(response)) {
      if (!peak.damping || !in_bands(peak.frequency)) continue;
      const double width = 2.0 * *peak.damping * peak.frequency;
      if (width * source.segment >= fewest_lines) continue;
      throw InvalidInput(source.file.issue(
          "the resonance at " + shortest(std::round(10.0 * peak.frequency) / 10.0) +
              " Hz is narrower than two lines of a segment of " + shortest(source.segment) + " s (" +
              shortest(std::round(1e3 * fewest_lines / source.segment) / 1e3) + " Hz)",
          "with compare: log_magnitude the window of the segments makes its damping too large",
          "remove compare: log_magnitude, as the spectra of the whole record need no window, or give longer segments"));
    }
  }

  [[nodiscard]] std::string owner() const { return "update.compare." + name_; }

  static std::string unit_of(d::FrfQuantity quantity) {
    return quantity == d::FrfQuantity::displacement ? "m" : quantity == d::FrfQuantity::velocity ? "m/s" : "m/s^2";
  }
  static std::string unit_of(const d::FrfInput& input) {
    return std::holds_alternative<d::FrfForce>(input.input) ? "N" : "m/s^2";
  }

  /// Converts the responses of a table to SI. Their titles name units per force or per ground acceleration.
  void convert_to_si(FrequencyResponse& response, const std::string& output_unit, const d::FrfInput& input,
                     const std::string& file) const {
    const std::string unit = "(" + output_unit + ")/(" + unit_of(input) + ")";
    IssueList issues;
    for (std::size_t j = 0; j < response.outputs.size(); ++j) {
      Channel& output = response.outputs[j];
      const double factor =
          factor_to_si({.column = output.name, .owner = owner(), .unit = unit}, output, {file, 0}, issues);
      response.values.col(static_cast<Index>(j)) *= factor;
      if (response.deviations.size() > 0) response.deviations.col(static_cast<Index>(j)) *= factor;
      output.unit = unit;
    }
    issues.raise();
  }

  const CaseStudy& study_;
  std::shared_ptr<const ParameterisedStructure> structure_;
  std::string name_;
  std::vector<std::string>& warnings_;
};

/// Resolves the names of a comparison with the record. The residual itself is made once the record is known.
class RecordComparisonMaker {
public:
  RecordComparisonMaker(const CaseStudy& study, const std::string& name) : study_(study), name_(name) {}

  RecordComparison operator()(const d::DrivenHistory& given) const {
    using Derivatives = RecordResidual::Derivatives;
    const auto automatic =
        study_.structure->finite_elements.empty() ? Derivatives::filter_passes : Derivatives::held_gains_where_accurate;
    const auto requested =
        given.derivatives == d::HistoryDerivatives::held_gains ? Derivatives::held_gains : Derivatives::filter_passes;
    const bool is_automatic = given.derivatives == d::HistoryDerivatives::automatic;
    return {.name = name_,
            .kind = "record of '" + given.substructure.value + "' driven by the estimated motion of its boundary",
            .what = RecordResidual::Options{.name = name_,
                                            .substructure = given.substructure.value,
                                            .sensors = compared_sensors(study_, given),
                                            .derivatives = is_automatic ? automatic : requested}};
  }

  RecordComparison operator()(const d::SimulatedHistory& given) const {
    RecordComparison::OfSimulation simulation{.sensors = {}, .options = {.name = name_}};
    for (const auto& name : compared_sensors(study_, given))
      simulation.sensors.push_back(*std::ranges::find(study_.sensors, name, &Sensor::name));
    if (study_.given.simulate) simulation.options.initial = study_.given.simulate->initial;
    if (study_.given.estimate) simulation.options.settle = study_.given.estimate->settle.value_or(0.0);
    return {.name = name_, .kind = "record against the simulation", .what = std::move(simulation)};
  }

private:
  const CaseStudy& study_;
  const std::string& name_;
};

}  // namespace

void add_comparisons(const CaseStudy& study, UpdatingPlan& plan, std::vector<std::string>& warnings) {
  IssueList issues;
  for (const auto& [name, given] : study.given.update->comparisons) {
    const auto of_record = [&](const auto& data) {
      plan.record_comparisons.push_back(RecordComparisonMaker(study, name)(data));
      plan.record_comparisons.back().weight = given.value.weight;
      plan.record_comparisons.back().location = given.location;
    };
    try {
      if (const auto* driven = std::get_if<d::DrivenHistory>(&given.value.data)) {
        of_record(*driven);
      } else if (const auto* simulated = std::get_if<d::SimulatedHistory>(&given.value.data)) {
        of_record(*simulated);
      } else {
        plan.comparisons.push_back(std::visit(ResidualMaker(study, plan.structure, name, warnings), given.value.data));
        plan.comparisons.back().weight = given.value.weight;
      }
    } catch (const InvalidInput& error) {
      add_at(given.location, error, issues);
    }
  }
  issues.raise();
}

}  // namespace kalfem
