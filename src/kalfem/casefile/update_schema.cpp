// SPDX-License-Identifier: Apache-2.0
#include "kalfem/casefile/case_schema.hpp"
#include "kalfem/casefile/plausible.hpp"
#include "kalfem/yaml/map_schema.hpp"

namespace kalfem::description {

using namespace schema;

namespace {

Schema<UpdatedParameter> updated_parameter() {
  return mapping(
      Fields<UpdatedParameter>()
          .optional("initial", &UpdatedParameter::initial, value(),
                    "value at which the updating starts; default: the substructure's own value")
          .optional(
              "std", &UpdatedParameter::std, value(),
              "standard deviation of the prior, in the parameter's unit or in per cent of `initial`; default: no prior")
          .optional("bounds", &UpdatedParameter::bounds, located(tuple<2>(quantity())), "lower and upper bound")
          .optional("truth", &UpdatedParameter::truth, value(), "true value, if known; default: the simulated one")
          .optional("applies_to", &UpdatedParameter::applies_to, list(name()),
                    "several parameters that share this value"));
}

Schema<TableColumn> column_of(std::string_view what) {
  return mapping(Fields<TableColumn>()
                     .required("file", &TableColumn::file, path(), "text table")
                     .required("column", &TableColumn::column, text(), what)
                     .optional("first", &TableColumn::first, integer(1, 100000), "number of rows to read"));
}

/// Numbers by themselves, or a map that names a column of a table. The kind of the node decides.
template <class T>
Schema<std::variant<T, TableColumn>> or_column(const Schema<T>& values, std::string_view what) {
  using Either = std::variant<T, TableColumn>;
  const auto column = column_of(what);
  const auto read = [=](const CaseNode& node, Either& given) {
    return node.yaml().kind == YamlNode::Kind::map ? column.read(node, given.template emplace<TableColumn>())
                                                   : values.read(node, given.template emplace<T>());
  };
  const auto write = [=](const Either& given) {
    const auto* own = std::get_if<T>(&given);
    return own ? values.write(*own) : column.write(std::get<TableColumn>(given));
  };
  return make_schema<Either>(read, write, either_schema(values.json_schema(), column.json_schema()));
}

Fields<ListedModes> listed_modes() {
  const auto shapes =
      Fields<ShapeTable>()
          .required("file", &ShapeTable::file, path(),
                    "text table: one row per point, one column per mode; an empty cell or nan was not measured")
          .required("points", &ShapeTable::points, list(name(), 1), "points of the rows, in order")
          .optional("deviation", &ShapeTable::deviation, number("-", Bounds::positive()),
                    "standard deviation of an entry, as a fraction of the shape's largest entry")
          .optional("deviations", &ShapeTable::deviations, path(),
                    "text table like that of the shapes: the standard deviation of each entry, in the shapes' unit");
  return Fields<ListedModes>()
      .required("frequencies", &ListedModes::frequencies,
                located(or_column(list(number("Hz", plausible::frequency()), 1), "column of frequencies [Hz]")),
                "measured natural frequencies")
      .optional("shapes", &ListedModes::shapes, mapping(shapes), "measured mode shapes")
      .optional("dampings", &ListedModes::dampings,
                located(or_column(list(number("-", Bounds::between(0, 1)), 1), "column of damping ratios")),
                "measured damping ratios, one a mode, to compare with those of the model");
}

Fields<ModeFile> mode_file() {
  return Fields<ModeFile>()
      .required(
          "file", &ModeFile::file, located(path()),
          "modes.json of `kalfem modal`, a universal file (datasets 55, 2414) or a MATLAB file (frequencies, shapes, "
          "points, ...): frequencies, dampings, shapes")
      .optional("points", &ModeFile::points, named(located(text()), NameRule::dotted),
                "points of the substructure, each with the file's name of it: a channel, or node and direction like "
                "12:+Z (12:-Z, -a3: against it); default: those that have the same name, or node.x, node.y ... of it")
      .optional("only", &ModeFile::only, list(integer(1, 100000)),
                "numbers of the file's modes that are compared, from 1; default: all")
      .optional("shape_deviation", &ModeFile::shape_deviation, number("-", Bounds::positive()),
                "standard deviation of an entry, as a fraction of the shape's largest entry; default: what the file "
                "says of them, or 0.05")
      .optional("compare_dampings", &ModeFile::dampings, boolean(), "compare the damping ratios as well")
      .optional("max_complexity", &ModeFile::max_complexity, number("-", Bounds::between(0, 1)),
                "share of a complex shape that may be out of phase; it is turned to be real");
}

kalfem::Case<ModalData> modal_data() {
  return when(
      Fields<ModalData>()
          .required("modes", &ModalData::substructure, name(), "substructure whose modes are compared")
          .one_of(&ModalData::measured, when(listed_modes()), when(mode_file()))
          .optional(
              "deviation", &ModalData::deviation, or_column(value(), "column of standard deviations [Hz]"),
              "standard deviation: in per cent of each frequency, in Hz, or a column; default: what the file says "
              "of it, or 1 %")
          .optional(
              "damping_deviation", &ModalData::damping_deviation,
              or_column(value(), "column of standard deviations of the ratios"),
              "standard deviation of the damping ratios: in per cent of each, or a column; default: what the file "
              "says of it, or 10 %")
          .optional(
              "model_modes", &ModalData::model_modes, list(integer(1, 100000)),
              "number of the model's mode that each one corresponds to at the start; default: in order, or by shape")
          .optional("above", &ModalData::above, number("Hz", Bounds::nonnegative()),
                    "leave out the model's modes below this frequency, such as rigid-body modes on a soft suspension")
          .optional("minimum_mac", &ModalData::minimum_mac, number("-", Bounds::between(0, 1)),
                    "smallest MAC of two shapes of the same mode")
          .optional("expansion", &ModalData::expansion,
                    choice<ExpansionMethod>(
                        {{"model", ExpansionMethod::model, "the model's mode, mixed with others as the shape asks for"},
                         {"serep", ExpansionMethod::serep, "the paired modes that fit the shape best"},
                         {"dynamic", ExpansionMethod::dynamic,
                          "the model's motion at the measured frequency with forces at the sensors alone"}}),
                    "how a measured shape is carried on to points without a sensor"));
}

kalfem::Case<FrfData> frf_data() {
  const auto table =
      Fields<FrfFile>()
          .required(
              "file", &FrfFile::file, located(path()),
              "table: frequency, then for each output one complex column (1.2+3.4j), two columns, or a magnitude; or a "
              "universal file")
          .optional("values", &FrfFile::values,
                    choice<FrfColumnContent>({{"complex", FrfColumnContent::complex, "real and imaginary part"},
                                              {"magnitude", FrfColumnContent::magnitude, "|H|"},
                                              {"dB", FrfColumnContent::decibel, "20 log10 |H|"}}),
                    "contents of columns whose names do not end in _re, _im, _mag, _db or _phase");
  const auto record =
      Fields<FrfRecordSource>()
          .required("record", &FrfRecordSource::file, located(path()),
                    "time record whose spectra are compared, without a window; several of one input: one entry each")
          .required("input", &FrfRecordSource::input, text(), "column of the input")
          .optional("segment", &FrfRecordSource::segment, number("s", plausible::duration()),
                    "length of the segments that H1 is averaged over, for compare: log_magnitude only")
          .optional("dataset", &FrfRecordSource::dataset, text(), "dataset, for an .h5 file")
          .optional("sample_rate", &FrfRecordSource::sample_rate, number("Hz", plausible::frequency()),
                    "sampling rate, if the file does not state it");
  const auto force = convert<FrfForce>(
      name(), [](const Name& point) { return FrfForce{point}; }, [](const FrfForce& given) { return given.point; });
  const auto ground = convert<FrfGround>(
      name(), [](const Name& moving) { return FrfGround{moving}; },
      [](const FrfGround& given) { return given.ground; });
  const auto input =
      mapping(Fields<FrfInput>()
                  .one_of(&FrfInput::input, when("force", force, "point at which a force acts [N]"),
                          when("ground", ground, "ground that moves; responses are per unit of its acceleration"))
                  .one_of(&FrfInput::source, when(table), when(record))
                  .optional("columns", &FrfInput::columns, list(text()),
                            "one column per output; default: the columns of a table in order, those of a record by the "
                            "outputs' names"));
  return when(
      Fields<FrfData>()
          .required("frf", &FrfData::substructure, name(), "substructure whose frequency responses are compared")
          .required("inputs", &FrfData::inputs, list(input, 1), "inputs, each with its measured responses")
          .required("outputs", &FrfData::outputs, list(name(), 1), "points at which the responses were measured")
          .optional("quantity", &FrfData::quantity,
                    choice<FrfQuantity>({{"acceleration", FrfQuantity::acceleration, "accelerance, (m/s^2)/N"},
                                         {"velocity", FrfQuantity::velocity, "mobility"},
                                         {"displacement", FrfQuantity::displacement, "receptance"}}),
                    "quantity of the outputs")
          .optional("bands", &FrfData::bands, list(tuple<2>(number("Hz", Bounds::nonnegative()))),
                    "frequency bands to use; default: all")
          .optional("compare", &FrfData::compare,
                    choice<FrfComparison>(
                        {{"logarithm", FrfComparison::logarithm, "magnitude and phase"},
                         {"log_magnitude", FrfComparison::log_magnitude, "magnitude only, for data without phases"},
                         {"difference", FrfComparison::difference, "real and imaginary parts"}}),
                    "how the responses are compared")
          .optional("scale", &FrfData::scale,
                    choice<FrfScale>({{"fixed", FrfScale::fixed, "no factor: the responses are calibrated"},
                                      {"per_input", FrfScale::per_input, "one free factor per input"},
                                      {"per_response", FrfScale::per_response, "one free factor per response"}}),
                    "factor between measured and computed responses, estimated together with the parameters; not for "
                    "compare: difference")
          .optional("deviation", &FrfData::deviation, number("-", Bounds::positive()),
                    "standard deviation relative to each value; of a record nothing is added to its noise unless this "
                    "is given")
          .optional("floor", &FrfData::floor, number("-", Bounds::nonnegative()),
                    "standard deviation relative to the rms of the lines used, added to it if the data state none of "
                    "their own")
          .optional("smoothing", &FrfData::smoothing, number("Hz", Bounds::nonnegative()),
                    "bandwidth by which resonances of measurement and model are widened at first, so that distant ones "
                    "overlap"));
}

kalfem::Case<StaticData> static_data() {
  return when(
      Fields<StaticData>()
          .required("static", &StaticData::substructure, name(), "substructure whose deflection is compared")
          .required("loads", &StaticData::loads, named(located(number("N")), NameRule::dotted), "forces by point")
          .required("displacements", &StaticData::displacements, named(located(number("m")), NameRule::dotted),
                    "measured displacements by point")
          .optional("deviation", &StaticData::deviation, number("-", Bounds::positive()),
                    "standard deviation, as a fraction of the largest displacement"));
}

kalfem::Case<DrivenHistory> driven_history() {
  return when(
      Fields<DrivenHistory>()
          .required("time_history", &DrivenHistory::substructure, name(),
                    "substructure that the estimated motion of its boundary drives")
          .optional("sensors", &DrivenHistory::sensors, one_or_list(name()),
                    "sensors to compare; default: all on the substructure")
          .optional("derivatives", &DrivenHistory::derivatives,
                    choice<HistoryDerivatives>(
                        {{"auto", HistoryDerivatives::automatic,
                          "filter_passes; with finite elements held_gains where they give nearly the same derivatives"},
                         {"filter_passes", HistoryDerivatives::filter_passes, "one filter run per parameter: exact"},
                         {"held_gains", HistoryDerivatives::held_gains,
                          "one run per parameter with the filter's gains held: approximate, at a tenth of the time"}}),
                    "derivatives of the boundary's estimated motion"));
}

kalfem::Case<SimulatedHistory> simulated_history() {
  return when(Fields<SimulatedHistory>().required("simulation", &SimulatedHistory::sensors, one_or_list(name()),
                                                  "sensors compared with the simulation of the whole structure, or "
                                                  "`all`"));
}

}  // namespace

Schema<Updating> updating() {
  const auto comparison =
      Fields<Comparison>()
          .one_of(&Comparison::data, modal_data(), frf_data(), static_data(), driven_history(), simulated_history())
          .optional("weight", &Comparison::weight, number("-", Bounds::nonnegative()), "factor on its sum of squares");
  const auto evolution =
      Fields<Evolution>()
          .optional("generations", &Evolution::generations, integer(1, 100000), "largest number of generations")
          .optional("population", &Evolution::population, integer(0, 10000),
                    "points per generation; 0: chosen from the number of parameters")
          .optional("seed", &Evolution::seed, seed(), "seed of its random numbers");
  const auto alternative = Fields<UpdatingAlternative>().required(
      "parameters", &UpdatingAlternative::parameters, named(located(updated_parameter()), NameRule::dotted),
      "parameters that are updated in the place of update.parameters, each with `std`");
  return mapping(
      Fields<Updating>()
          .required("parameters", &Updating::parameters, named(located(updated_parameter()), NameRule::dotted),
                    "parameters to update: substructure.spring.stiffness, substructure.material.youngs_modulus, "
                    "substructure.region.thickness, substructure.damping.modal ..., or a name with applies_to")
          .required("compare", &Updating::comparisons, named(located(mapping(comparison))),
                    "measurements to compare with, by names of your own")
          .optional("method", &Updating::method,
                    choice<UpdatingMethod>(
                        {{"least_squares", UpdatingMethod::least_squares, "Gauss-Newton in a trust region"},
                         {"cma_es", UpdatingMethod::evolution,
                          "evolution strategy for many local minima, followed by least_squares"}}),
                    "method that minimises the residual")
          .optional("starts", &Updating::starts, integer(1, 10000), "number of starting points, spread over the bounds")
          .optional("seed", &Updating::seed, seed(), "seed of the starting points")
          .optional("stages", &Updating::stages, integer(1, 10000), "largest number of iterations")
          .optional("tolerance", &Updating::tolerance, number("-", Bounds{.low = 0.0, .high = 0.1, .low_open = true}),
                    "the updating ends when the parameters change by less than this (relative) between iterations")
          .optional("evolution", &Updating::evolution, mapping(evolution), "options of method: cma_es")
          .optional("check_sensitivities", &Updating::check_sensitivities, boolean(),
                    "check the residual's derivatives against finite differences at the start")
          .optional("write_deck", &Updating::write_deck, path(false),
                    "folder into which decks with the updated values are written, each below the name of its "
                    "substructure; default: updated_decks in the folder of the results")
          .optional("known_to", &Updating::known_to, named(value(), NameRule::dotted),
                    "standard deviations of numbers that are not updated, which intervals then hold, as in "
                    "estimate.known_to; gains are those of what is compared: tip.z.gain of a response, "
                    "input.tip.z.gain of its force, a1.gain of a sensor, road.gain of an excitation")
          .optional(
              "alternatives", &Updating::alternatives, named(located(mapping(alternative))),
              "other choices of parameters, by names of your own, fitted to the same measurements and weighted by "
              "their evidence; modifications are predicted by all of them"));
}

Schema<Modification> modification() {
  return mapping(
      Fields<Modification>()
          .required("substructure", &Modification::substructure, name(), "substructure that is changed")
          .required("set", &Modification::set, named(value(), NameRule::dotted),
                    "new values of parameters, by their names in the substructure")
          .optional("modes", &Modification::modes, integer(1, 10000), "number of natural frequencies to predict")
          .optional("above", &Modification::above, number("Hz", Bounds::nonnegative()),
                    "leave out frequencies below this, such as rigid-body modes on a soft suspension"));
}

}  // namespace kalfem::description
