// SPDX-License-Identifier: Apache-2.0
#include "kalfem/casefile/case_schema.hpp"

#include "kalfem/casefile/component_schema.hpp"
#include "kalfem/casefile/gravity.hpp"
#include "kalfem/casefile/plausible.hpp"
#include "kalfem/yaml/map_schema.hpp"

namespace kalfem::description {

using namespace schema;

Schema<Name> name() { return located(text()); }
Schema<Value> value() { return located(quantity()); }

Schema<Points> points(const std::string& short_name) {
  const auto single = convert<Named<double>>(
      written_as(short_name, text()),
      [](const std::string& point) {
        return Named<double>{{point, 1.0}};
      },
      [](const Named<double>& points) { return points.front().first; });
  const auto sum = written_as("{" + short_name + ": weight, ...}", named(number("-"), NameRule::dotted));
  return located(either(single, sum));
}

namespace {

Schema<Connector> connector() {
  return mapping(law_keys()
                     .required("from", &Connector::from, name(),
                               "point at one end: substructure.name, or `ground` for a fixed ground")
                     .required("to", &Connector::to, name(),
                               "point at the other end; deformation = displacement of `to` minus that of `from`"));
}

// The file writes each section of a chain as a map with the key of its kind. `to` makes the sections of the library
// from these maps and checks the chain as a whole; `from` goes the other way for the resolved case. A filter names its
// band by its cut-off key, so exactly one of these keys must be given.
Schema<std::vector<ChainSection>> measurement_chain() {
  struct Filter {
    int order = 4;
    std::optional<double> low_pass, high_pass;
    std::optional<std::array<double, 2>> band_pass;
  };
  struct Section {
    std::optional<Filter> butterworth, bessel;
    std::optional<double> delay;
    std::optional<ResonanceSection> resonance;
    std::optional<double> gain;
  };
  const auto filter = mapping(
      Fields<Filter>()
          .optional("order", &Filter::order, integer(1, 12), "order of the low-pass prototype")
          .optional("low_pass", &Filter::low_pass, number("Hz", plausible::frequency()), "cut-off frequency (-3 dB)")
          .optional("high_pass", &Filter::high_pass, number("Hz", plausible::frequency()), "cut-off frequency (-3 dB)")
          .optional("band_pass", &Filter::band_pass, tuple<2>(number("Hz", plausible::frequency())),
                    "lower and upper cut-off frequency (-3 dB)"));
  const auto resonance = mapping(
      Fields<ResonanceSection>()
          .required("frequency", &ResonanceSection::frequency, number("Hz", plausible::frequency()), "resonance")
          .optional("damping", &ResonanceSection::damping, number("-", Bounds::positive()), "damping ratio"));
  const auto section = mapping(
      Fields<Section>()
          .optional("butterworth", &Section::butterworth, filter, "Butterworth filter (maximally flat magnitude)")
          .optional("bessel", &Section::bessel, filter, "Bessel filter (nearly constant delay)")
          .optional("delay", &Section::delay, number("s", plausible::sensor_delay()), "pure delay")
          .optional("resonance", &Section::resonance, resonance, "resonance of the sensor: a second-order low-pass")
          .optional("gain", &Section::gain, number("-"), "constant factor"));
  const auto make_filter_section = [](const Filter& given, FilterFamily family) -> ChainSection {
    const int bands = given.low_pass.has_value() + given.high_pass.has_value() + given.band_pass.has_value();
    if (bands != 1)
      throw InvalidInput("the " + std::string(family == FilterFamily::bessel ? "bessel" : "butterworth") +
                             " filter has " + std::to_string(bands) + " bands",
                         "a filter has exactly one of low_pass, high_pass and band_pass", "give one of them");
    if (given.band_pass)
      return FilterSection{family, FilterBand::band_pass, given.order, (*given.band_pass)[0], (*given.band_pass)[1]};
    return FilterSection{family, given.low_pass ? FilterBand::low_pass : FilterBand::high_pass, given.order,
                         given.low_pass ? *given.low_pass : *given.high_pass, 0.0};
  };
  const auto to = [=](const std::vector<Section>& sections) {
    MeasurementChainOptions options;
    for (const auto& each : sections) {
      if (each.butterworth)
        options.sections.push_back(make_filter_section(*each.butterworth, FilterFamily::butterworth));
      if (each.bessel) options.sections.push_back(make_filter_section(*each.bessel, FilterFamily::bessel));
      if (each.delay) options.sections.push_back(DelaySection{*each.delay});
      if (each.resonance) options.sections.push_back(*each.resonance);
      if (each.gain) options.sections.push_back(GainSection{*each.gain});
    }
    validate(options).raise();
    return options.sections;
  };
  const auto from = [](const std::vector<ChainSection>& sections) {
    std::vector<Section> written;
    for (const auto& each : sections) {
      Section one;
      if (const auto* f = std::get_if<FilterSection>(&each)) {
        Filter filter_written{f->order, {}, {}, {}};
        if (f->band == FilterBand::low_pass) filter_written.low_pass = f->cutoff;
        if (f->band == FilterBand::high_pass) filter_written.high_pass = f->cutoff;
        if (f->band == FilterBand::band_pass) filter_written.band_pass = {f->cutoff, f->upper_cutoff};
        (f->family == FilterFamily::butterworth ? one.butterworth : one.bessel) = filter_written;
      }
      if (const auto* d = std::get_if<DelaySection>(&each)) one.delay = d->delay;
      if (const auto* r = std::get_if<ResonanceSection>(&each)) one.resonance = *r;
      if (const auto* g = std::get_if<GainSection>(&each)) one.gain = g->gain;
      written.push_back(one);
    }
    return written;
  };
  return convert<std::vector<ChainSection>>(list(section), to, from);
}

template <ObservedQuantity Q>
kalfem::Case<Observed<Q>> observing(std::string_view key, std::string_view target, std::string_view meaning) {
  const auto schema = convert<Observed<Q>>(
      points(std::string(target)), [](const Points& given) { return Observed<Q>{given}; },
      [](const Observed<Q>& observed) { return observed.points; });
  return when(key, schema, meaning);
}

Schema<Sensor> sensor_of_any_quantity() {
  using enum ObservedQuantity;
  return mapping(
      Fields<Sensor>()
          .one_of(
              &Sensor::observed, observing<displacement>("displacement", "point", "absolute displacement [m]"),
              observing<velocity>("velocity", "point", "absolute velocity [m/s]"),
              observing<acceleration>("acceleration", "point", "absolute acceleration [m/s^2]"),
              observing<connector_force>("force", "connector", "force of a connector [N]"),
              observing<connector_deformation>("deformation", "connector", "deformation of a connector [m]"),
              observing<connector_rate>("rate", "connector", "deformation rate of a connector [m/s]"),
              observing<strain>("strain", "gauge", "strain of a gauge of finite elements, or a weighted sum of some"))
          .optional("relative", &Sensor::relative, boolean(), "measure relative to the accelerated base")
          .required("noise", &Sensor::noise, value(),
                    "standard deviation of the noise: per cent of the channel's rms, or in the sensor's unit")
          .optional("chain", &Sensor::chain, measurement_chain(),
                    "measurement chain: dynamics between the quantity and its recorded sample")
          .optional("channel", &Sensor::channel, text(),
                    "title of its column in the record, with or without the unit, or a node and direction as \"12:+Z\" "
                    "in a file "
                    "that has them; default: the sensor's name")
          .optional("unit", &Sensor::unit, located(text()),
                    "unit of its column, if it differs from record.unit; for an acceleration, g is standard gravity; "
                    "default: the unit in the column's title, otherwise SI")
          .optional("file", &Sensor::file, located(path()),
                    "file of its channel, if it is another than record.file; its time is taken as it stands there")
          .optional("mass", &Sensor::mass, located(number("kg", Bounds::positive())),
                    "of a force sensor: mass between the load cell and the connector, whose inertia it measures too")
          .optional(
              "mass_at", &Sensor::mass_at,
              choice<ConnectorEnd>({{"to", ConnectorEnd::to, "it measures force + mass a of the end `to`"},
                                    {"from", ConnectorEnd::from, "it measures force - mass a of the end `from`"}}),
              "the end of the connector that carries the mass")
          .optional("accept_constant", &Sensor::accept_constant, boolean(),
                    "accept a channel with the same value throughout; otherwise it is refused as a dead sensor")
          .optional("gain", &Sensor::gain, number("-"),
                    "of a measured record: the channel holds gain signal + offset, late by delay + drift t; negative "
                    "for a sensor that looks the other way")
          .optional("offset", &Sensor::offset, value(), "offset of the channel, in the sensor's unit")
          .optional("delay", &Sensor::delay, number("s", plausible::clock()), "the channel is late by this")
          .optional("drift", &Sensor::drift, number("-", plausible::drift()),
                    "by so much its clock runs fast, as 50 ppm: a time t after the first sample of the record it is "
                    "late by delay + drift t"));
}

/// The same, with g as gravity in the values of an accelerometer.
Schema<Sensor> sensor() {
  const auto any = sensor_of_any_quantity();
  const auto read = [any](const CaseNode& node, Sensor& sensor) {
    if (!any.read(node, sensor)) return false;
    if (std::holds_alternative<Observed<ObservedQuantity::acceleration>>(sensor.observed)) {
      take_gravity(node, {"noise"}, sensor.noise);
      if (sensor.offset) take_gravity(node, {"offset"}, *sensor.offset);
    }
    return true;
  };
  return make_schema<Sensor>(
      read, [any](const Sensor& sensor) { return any.write(sensor); }, any.json_schema());
}

}  // namespace

Schema<ChannelPreparation> channel_preparation() {
  const auto part =
      Fields<RecordPart>()
          .optional("from", &RecordPart::from, number("s", plausible::clock()), "time in the file; default: its start")
          .optional("to", &RecordPart::to, number("s", plausible::clock()), "time in the file; default: its end");
  return mapping(Fields<ChannelPreparation>()
                     .optional("remove_offset", &ChannelPreparation::offset, mapping(part),
                               "subtract each channel's mean over a part of the file; {}: over all of it")
                     .optional("remove_trend", &ChannelPreparation::trend, boolean(),
                               "subtract each channel's straight line of least squares")
                     .optional("high_pass", &ChannelPreparation::high_pass, number("Hz", Bounds::nonnegative()),
                               "Butterworth filter without phase, of order 4: -3 dB at this frequency; 0: none")
                     .optional("low_pass", &ChannelPreparation::low_pass, number("Hz", Bounds::nonnegative()),
                               "Butterworth filter without phase, of order 4: -3 dB at this frequency; 0: none")
                     .optional("sample_rate", &ChannelPreparation::sample_rate, number("Hz", plausible::frequency()),
                               "resample to this lower rate behind an anti-alias filter"));
}

namespace {

Schema<Record> record() {
  const auto free_response =
      Fields<FreeResponse>()
          .optional("delay", &FreeResponse::delay, number("s", plausible::time()),
                    "time from the release to the first sample used")
          .optional("threshold", &FreeResponse::threshold, number("m", plausible::length()),
                    "the filter stops when every channel stays within this distance of rest")
          .optional("margin", &FreeResponse::margin, number("s", plausible::time()), "time added to that")
          .optional("rest_std", &FreeResponse::rest_std, number("m", Bounds::positive()),
                    "if the record ends before the structure is at rest, each channel's rest position is estimated: "
                    "its prior standard deviation; default: half of the last swing");

  return mapping(
      Fields<Record>()
          .required("file", &Record::file, located(path()),
                    "file of the measured record: .csv, .lvm, .h5, .unv, ...; see docs/records.md")
          .optional("sample_rate", &Record::sample_rate, number("Hz", plausible::frequency()),
                    "sampling rate, if the file does not state it")
          .optional("unit", &Record::unit, located(text()),
                    "unit of the columns; for accelerations, g is standard gravity; default: the units in their titles "
                    "(\"a [g]\"), otherwise SI")
          .optional("dataset", &Record::group, text(), "for an .h5 file: the dataset whose columns are the channels")
          .optional("start", &Record::start, number("s", plausible::clock()),
                    "time in the file of the first sample used")
          .optional("end", &Record::end, number("s", plausible::clock()), "time in the file of the last sample used")
          .optional("skip_missing", &Record::skip_missing, boolean(),
                    "skip samples that are NaN instead of refusing the record")
          .optional("repair_splice", &Record::repair_splice, boolean(),
                    "find the place where two recordings were joined and treat the samples lost there as missing")
          .optional("prepare", &Record::prepare, channel_preparation(),
                    "what is done to all channels, in this order, before `start` and `end` cut the record")
          .optional("free_response", &Record::free_response, mapping(free_response),
                    "the structure is held, released and comes to rest: find the release and the rest position, and "
                    "measure from that position"));
}

Schema<Validation> validation() {
  return mapping(
      Fields<Validation>()
          .optional("record", &Validation::record, record(),
                    "another measured record of the same sensors; default: another part of the case's own")
          .optional("start", &Validation::start, number("s", plausible::clock()),
                    "time in the file of the first sample used")
          .optional("end", &Validation::end, number("s", plausible::clock()),
                    "time in the file of the last sample used")
          .optional("lead_in", &Validation::lead_in, number("s", plausible::time()),
                    "first part of it, which does not count: the initial state is estimated from it with the "
                    "parameters held; default: a tenth of the part")
          .optional("initial", &Validation::from_rest,
                    choice<bool>({{"unknown", false, "estimated from the lead-in"},
                                  {"rest", true, "at rest at zero; there is no lead-in"}}),
                    "state at the first sample")
          .optional("excitation", &Validation::excitation, named(located(path())),
                    "files of measured inputs during another record, by the names of the inputs; default: an input in "
                    "the file of the case's record is read from the file of this one"));
}

Schema<Simulation> simulation() {
  const auto start =
      Fields<PointStart>()
          .optional("displacement", &PointStart::displacement, number("m", plausible::position()), "value at time 0")
          .optional("velocity", &PointStart::velocity, number("m/s"), "value at time 0");
  return mapping(
      Fields<Simulation>()
          .required("duration", &Simulation::duration, number("s", plausible::duration()), "duration of the record")
          .required("sample_rate", &Simulation::sample_rate, number("Hz", plausible::frequency()),
                    "sampling rate of the record")
          .optional("integrator", &Simulation::integrator,
                    choice<Integrator>(
                        {{"newmark", Integrator::newmark, "average acceleration"},
                         {"hht_alpha", Integrator::hht_alpha, "Hilber-Hughes-Taylor: dissipates high frequencies"},
                         {"generalized_alpha", Integrator::generalized_alpha,
                          "generalised-alpha method of Chung and Hulbert"},
                         {"exact", Integrator::exact,
                          "exact propagation of the linear part, connector forces linear over a step"}}),
                    "time integration method")
          .optional("hht_alpha", &Simulation::hht_alpha, number("-", Bounds::between(-1.0 / 3.0, 0.0)),
                    "parameter alpha of hht_alpha")
          .optional("spectral_radius", &Simulation::spectral_radius, number("-", Bounds::between(0, 1)),
                    "spectral radius of generalized_alpha at infinite frequency")
          .optional("tolerance", &Simulation::tolerance, number("-", Bounds::positive()),
                    "the step is refined until halving it would change no sensor's record by more than this fraction "
                    "of its rms")
          .optional("reference", &Simulation::superelements,
                    choice<bool>({{"full", false, "all degrees of freedom"},
                                  {"superelement", true, "a superelement with many modes"}}),
                    "model of the finite-element substructures that is simulated")
          .optional("modes_up_to", &Simulation::modes_up_to, number("Hz", plausible::frequency()),
                    "for reference: superelement: keep fixed-interface modes up to this frequency")
          .optional("first_substeps", &Simulation::first_substeps, integer(1, 65536),
                    "time steps per sample of the first, coarsest solution")
          .optional("max_substeps", &Simulation::max_substeps, integer(1, 65536),
                    "largest number of time steps per sample")
          .optional(
              "substeps", &Simulation::substeps, located(integer(1, 65536)),
              "fixed number of time steps per sample, without refinement, instead of tolerance, first_substeps and "
              "max_substeps; for motion so sensitive (contact, friction) that refining the step does not converge")
          .optional("seed", &Simulation::seed, seed(), "seed of the sensors' noise")
          .optional("initial", &Simulation::initial, named(located(mapping(start)), NameRule::dotted),
                    "initial values of degrees of freedom that do not start at rest at zero"));
}

}  // namespace

// The order of the keys is that of the reference and of the resolved case. Reading keeps the tree of the file in
// `source`, so that later steps can tell a key that was given from a default, and find the line of both.
Schema<Case> case_schema() {
  const auto fields =
      Fields<Pictures>()
          .required("substructure", &Pictures::substructure, name(), "finite-element substructure")
          .optional("every", &Pictures::every, number("s", plausible::duration()), "time between two frames");
  const auto report =
      Fields<Report>()
          .optional("fields", &Report::fields, mapping(fields),
                    "write the displacement field of a substructure over time for ParaView")
          .optional("modes", &Report::modes, integer(1, 10000),
                    "number of lowest modes computed and listed for a finite-element substructure")
          .optional("displacements", &Report::displacements, one_or_list(name()),
                    "points whose displacement is plotted; default: the first points of the predicted substructure")
          .optional("strains", &Report::strains, one_or_list(name()),
                    "gauges whose strain is plotted; default: the first gauges that are no sensors")
          .optional("superelements", &Report::superelements,
                    located(one_or_list(choice<MatrixFormat>(
                        {{"matrix_market", MatrixFormat::matrix_market, "K, M and C, with a file that names the rows"},
                         {"dmig", MatrixFormat::dmig, "Nastran"},
                         {"op4", MatrixFormat::op4, "Nastran OUTPUT4, binary"},
                         {"hdf5", MatrixFormat::hdf5, "with the reduction basis"}}))),
                    "write the reduced substructures as superelements for other codes")
          .optional("frequencies", &Report::frequencies, integer(0, 1000),
                    "number of lowest natural frequencies that are computed over time from the estimated parameters")
          .optional("zoom", &Report::zoom, number("s", plausible::duration()), "length of the zoomed charts");
  const auto prediction = Fields<Prediction>()
                              .required("substructure", &Prediction::substructure, name(),
                                        "linear substructure to drive by its estimated boundary motion")
                              .optional("substeps", &Prediction::substeps, integer(1, 1000),
                                        "time steps per sample for a large substructure");
  const auto damping =
      Fields<GlobalModalDamping>()
          .required("modal", &GlobalModalDamping::modal, one_or_list(number("-", Bounds::between(0, 0.999))),
                    "damping ratio of every mode, or a list with one ratio per mode (the last one applies to the rest)")
          .optional("up_to", &GlobalModalDamping::up_to, number("Hz", plausible::frequency()),
                    "finite elements only: modes up to this frequency have their own ratio; higher modes share the "
                    "damping rate of the last one");
  const auto joint =
      Fields<Joint>()
          .required("between", &Joint::between, tuple<2>(name()),
                    "two groups of nodes that lie at the same places, substructure.group: a group of the mesh, a node "
                    "set of the deck, or one of `nodes`")
          .optional("tolerance", &Joint::tolerance, number("m", plausible::length()),
                    "largest distance of two nodes that are joined; default: a thousandth of the elements' size");
  const auto all = mapping(
      Fields<Case>()
          .required("kalfem", &Case::version, integer(1, 1), "version of the case-file format")
          .optional("title", &Case::title, text(), "title of the report, in one line")
          .optional("substructures", &Case::substructures, named(substructure()), "linear parts")
          .optional("connectors", &Case::connectors, named(connector()), "local nonlinear elements between two points")
          .optional("joints", &Case::joints, named(mapping(joint)),
                    "rigid joints of finite-element substructures: coincident nodes of two groups move as one")
          .optional("component", &Case::component, located(component()),
                    "one connector law on a test machine: its motion is imposed and measured, and a sensor of `force: "
                    "component` measures its force; instead of substructures")
          .optional("damping", &Case::damping, located(mapping(damping)),
                    "modal damping of the whole structure (connectors with their stiffness at rest, unknowns at their "
                    "initial values), instead of modal damping of the substructures")
          .optional("excitation", &Case::excitation, named(excitation()), "inputs that drive the structure")
          .optional("sensors", &Case::sensors, named(sensor()), "measured quantities")
          .optional("simulate", &Case::simulate, simulation(), "make the record by simulation")
          .optional("record", &Case::record, record(), "read the record from a file")
          .optional("live", &Case::live, located(live()),
                    "in place of a record: samples as they come, for `kalfem watch`")
          .optional("estimate", &Case::estimate, estimation(),
                    "estimate the states and unknown parameters from the record")
          .optional("validate", &Case::validate, located(validation()),
                    "try the estimates on data that they were not found from: open-loop simulation of another part of "
                    "the record, or of another record")
          .optional("predict", &Case::predict, mapping(prediction), "predict the response of a linear substructure")
          .optional("update", &Case::update, updating(),
                    "update parameters of the linear substructures from measurements")
          .optional(
              "modifications", &Case::modifications, named(located(modification())),
              "structural modifications: changes of the updated structure whose natural frequencies are predicted")
          .optional("infer", &Case::infer, located(inference()),
                    "what the data tell of the unknowns: posterior, evidence, laws compared (`kalfem infer`)")
          .optional("place", &Case::place, located(placement()), "where to put sensors (`kalfem place`)")
          .optional("static", &Case::statics, located(statics()),
                    "static load cases of a finite-element substructure (`kalfem static`)")
          .optional("frequency_response", &Case::frequency_response, located(frequency_responses()),
                    "frequency responses of the structure, linear about rest (`kalfem frf`)")
          .optional("report", &Case::report, mapping(report), "contents of the report"));
  const auto read = [=](const CaseNode& node, Case& given) {
    const bool is_usable = all.read(node, given);
    given.source = {node.location().file, node.shared_yaml(), node.files()};
    return is_usable;
  };
  return make_schema<Case>(
      read, [=](const Case& given) { return all.write(given); }, all.json_schema());
}

}  // namespace kalfem::description
