#include "kalfem/casefile/description_form.hpp"

#include "kalfem/casefile/plausible.hpp"
#include "kalfem/yaml/fields.hpp"

namespace kalfem::description {

using namespace form;

Form<Name> name() { return located(text()); }
Form<Value> value() { return located(quantity()); }

Form<Points> points(const std::string& short_name) {
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

Form<Connector> connector() {
  const auto state = Fields<ExpressionState>()
                         .required("rate", &ExpressionState::rate, text(), "time derivative as an expression")
                         .optional("unit", &ExpressionState::unit, text(), "unit of the state");
  return mapping(Fields<Connector>()
                     .required("from", &Connector::from, name(),
                               "point at one end, substructure.name, or `ground`, which is fixed")
                     .required("to", &Connector::to, name(), "point at the other end; the deformation is to minus from")
                     .required("law", &Connector::law, name(), "name of the law; `kalfem schema --laws` lists them")
                     .optional("parameters", &Connector::parameters, named(value()), "parameters of the law by name")
                     .optional("force", &Connector::force, text(),
                               "law expression: force [N] of x (deformation), v (rate), states and parameters")
                     .optional("states", &Connector::states, named(mapping(state)), "law expression: internal states"));
}

Form<std::vector<ChainSection>> measurement_chain() {
  struct Filter {
    int order = 4;
    std::optional<double> low_pass, high_pass;
    std::optional<std::array<double, 2>> band_pass;
  };
  struct Step {
    std::optional<Filter> butterworth, bessel;
    std::optional<double> delay;
    std::optional<ResonanceSection> resonance;
    std::optional<double> gain;
  };
  const auto filter =
      mapping(Fields<Filter>()
                  .optional("order", &Filter::order, integer(1, 12), "of the low-pass prototype")
                  .optional("low_pass", &Filter::low_pass, number("Hz", plausible::frequency()), "cut-off, -3 dB")
                  .optional("high_pass", &Filter::high_pass, number("Hz", plausible::frequency()), "cut-off, -3 dB")
                  .optional("band_pass", &Filter::band_pass, tuple<2>(number("Hz", plausible::frequency())),
                            "lower and upper edge, -3 dB"));
  const auto resonance = mapping(
      Fields<ResonanceSection>()
          .required("frequency", &ResonanceSection::frequency, number("Hz", plausible::frequency()), "resonance")
          .optional("damping", &ResonanceSection::damping, number("-", Bounds::positive()), "ratio to critical"));
  const auto stage = mapping(Fields<Step>()
                                 .optional("butterworth", &Step::butterworth, filter, "maximally flat filter")
                                 .optional("bessel", &Step::bessel, filter, "filter of constant delay")
                                 .optional("delay", &Step::delay, number("s", plausible::sensor_delay()), "pure delay")
                                 .optional("resonance", &Step::resonance, resonance, "roll-off of an accelerometer")
                                 .optional("gain", &Step::gain, number("-"), "constant factor"));
  const auto make_filter_section = [](const Filter& given, FilterFamily family) -> ChainSection {
    const int bands = given.low_pass.has_value() + given.high_pass.has_value() + given.band_pass.has_value();
    if (bands != 1)
      throw InvalidInput("the " + std::string(family == FilterFamily::bessel ? "bessel" : "butterworth") +
                             " filter has " + std::to_string(bands) + " bands",
                         "it has one of low_pass, high_pass, band_pass", "give one of them");
    if (given.band_pass)
      return FilterSection{family, FilterBand::band_pass, given.order, (*given.band_pass)[0], (*given.band_pass)[1]};
    return FilterSection{family, given.low_pass ? FilterBand::low_pass : FilterBand::high_pass, given.order,
                         given.low_pass ? *given.low_pass : *given.high_pass, 0.0};
  };
  const auto to = [=](const std::vector<Step>& stages) {
    MeasurementChainOptions options;
    for (const auto& each : stages) {
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
  const auto from = [](const std::vector<ChainSection>& stages) {
    std::vector<Step> written;
    for (const auto& each : stages) {
      Step one;
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
  return convert<std::vector<ChainSection>>(list(stage), to, from);
}

template <ObservedQuantity Q>
kalfem::Case<Observed<Q>> observing(std::string_view key, std::string_view target, std::string_view meaning) {
  const auto form = convert<Observed<Q>>(
      points(std::string(target)), [](const Points& given) { return Observed<Q>{given}; },
      [](const Observed<Q>& observed) { return observed.points; });
  return when(key, form, meaning);
}

Form<Sensor> sensor() {
  using enum ObservedQuantity;
  return mapping(
      Fields<Sensor>()
          .one_of(&Sensor::observed, observing<displacement>("displacement", "point", "absolute displacement [m]"),
                  observing<velocity>("velocity", "point", "absolute velocity [m/s]"),
                  observing<acceleration>("acceleration", "point", "absolute acceleration [m/s^2]"),
                  observing<connector_force>("force", "connector", "force of a connector [N]"),
                  observing<connector_deformation>("deformation", "connector", "deformation of a connector [m]"),
                  observing<connector_rate>("rate", "connector", "deformation rate of a connector [m/s]"))
          .optional("relative", &Sensor::relative, boolean(), "relative to the accelerated base")
          .required("noise", &Sensor::noise, value(),
                    "standard deviation: per cent of the channel's rms, or in the sensor's unit")
          .optional("chain", &Sensor::chain, measurement_chain(), "dynamics between the quantity and the record")
          .optional("channel", &Sensor::channel, text(),
                    "column of the record, with or without its unit; default: the sensor's name")
          .optional("unit", &Sensor::unit, located(text()),
                    "of its column, where it is another than record.unit; g is standard gravity for an acceleration; "
                    "default: that of the column's title, else SI")
          .optional("accept_constant", &Sensor::accept_constant, boolean(),
                    "its channel may hold one value throughout; else that is taken for a dead sensor"));
}

Form<Record> record() {
  const auto free_response =
      Fields<FreeResponse>()
          .optional("delay", &FreeResponse::delay, number("s", plausible::time()), "begin so long after the release")
          .optional("threshold", &FreeResponse::threshold, number("m", plausible::length()),
                    "the filter stops when no channel is further from rest")
          .optional("margin", &FreeResponse::margin, number("s", plausible::time()), "and so much later")
          .optional("rest_std", &FreeResponse::rest_std, number("m", Bounds::positive()),
                    "where the record ends before the rest: prior standard deviation of each channel's rest position, "
                    "which is estimated; default: half of the last swing");

  return mapping(
      Fields<Record>()
          .required("file", &Record::file, located(path()), "measured record: .csv, .lvm or .h5")
          .optional("sample_rate", &Record::sample_rate, number("Hz", plausible::frequency()),
                    "where the file does not say it")
          .optional("unit", &Record::unit, located(text()),
                    "unit of the columns, g is standard gravity for accelerations; default: those of their titles "
                    "(\"a [g]\"), else SI")
          .optional("dataset", &Record::group, text(), "in an .h5 file: the dataset whose columns are the channels")
          .optional("start", &Record::start, number("s", plausible::clock()), "time in the file where the case begins")
          .optional("end", &Record::end, number("s", plausible::clock()), "time in the file where it ends")
          .optional("skip_missing", &Record::skip_missing, boolean(),
                    "NaN in the record: skip the sample, not an error")
          .optional("repair_splice", &Record::repair_splice, boolean(),
                    "find a place where two recordings were put together and leave the samples missing there out")
          .optional("free_response", &Record::free_response, mapping(free_response),
                    "a structure is held, released and comes to rest: find both, take the record about the rest"));
}

Form<Simulation> simulation() {
  const auto start =
      Fields<PointStart>()
          .optional("displacement", &PointStart::displacement, number("m", plausible::position()), "at time 0")
          .optional("velocity", &PointStart::velocity, number("m/s"), "at time 0");
  return mapping(
      Fields<Simulation>()
          .required("duration", &Simulation::duration, number("s", plausible::duration()), "length of the record")
          .required("sample_rate", &Simulation::sample_rate, number("Hz", plausible::frequency()), "of the record")
          .optional("integrator", &Simulation::integrator,
                    choice<Integrator>({{"newmark", Integrator::newmark, "average acceleration"},
                                        {"hht_alpha", Integrator::hht_alpha, "with high-frequency dissipation"},
                                        {"generalized_alpha", Integrator::generalized_alpha, "Chung and Hulbert"},
                                        {"exact", Integrator::exact, "exact linear part, forces linear over a step"}}),
                    "time stepping of the reference")
          .optional("hht_alpha", &Simulation::hht_alpha, number("-", Bounds::between(-1.0 / 3.0, 0.0)), "of hht_alpha")
          .optional("spectral_radius", &Simulation::spectral_radius, number("-", Bounds::between(0, 1)),
                    "of generalized_alpha, at infinite frequency")
          .optional("tolerance", &Simulation::tolerance, number("-", Bounds::positive()),
                    "the step is halved until no sensor's record changes by more than this part of its rms")
          .optional("reference", &Simulation::superelements,
                    choice<bool>({{"full", false, "every degree of freedom"},
                                  {"superelement", true, "reduced, with many modes"}}),
                    "model of finite-element substructures")
          .optional("modes_up_to", &Simulation::modes_up_to, number("Hz", plausible::frequency()),
                    "fixed-interface modes of reference: superelement")
          .optional("first_substeps", &Simulation::first_substeps, integer(1, 65536),
                    "steps per sample of the first solution")
          .optional("max_substeps", &Simulation::max_substeps, integer(1, 65536), "steps per sample at the most")
          .optional("substeps", &Simulation::substeps, located(integer(1, 65536)),
                    "a fixed number of steps per sample, without halving: for motion so sensitive (contact, friction) "
                    "that no finer step brings the records together; in the place of tolerance, first_substeps and "
                    "max_substeps")
          .optional("seed", &Simulation::seed, seed(), "of the sensors' noise")
          .optional("initial", &Simulation::initial, named(located(mapping(start)), NameRule::dotted),
                    "degrees of freedom that do not start at rest at zero"));
}

}  // namespace

Form<Case> case_form() {
  const auto fields =
      Fields<Pictures>()
          .required("substructure", &Pictures::substructure, name(), "finite-element substructure")
          .optional("every", &Pictures::every, number("s", plausible::duration()), "time between two pictures");
  const auto report =
      Fields<Report>()
          .optional("fields", &Report::fields, mapping(fields),
                    "write the displacement of a whole substructure over time for ParaView")
          .optional("modes", &Report::modes, integer(1, 10000),
                    "lowest modes of a finite-element substructure that are computed and listed")
          .optional("displacements", &Report::displacements, one_or_list(name()),
                    "points whose displacement is drawn; default: the first of the predicted part")
          .optional("superelements", &Report::superelements,
                    located(one_or_list(choice<MatrixFormat>(
                        {{"matrix_market", MatrixFormat::matrix_market, "K, M and C, and the rows' names beside them"},
                         {"dmig", MatrixFormat::dmig, "Nastran"},
                         {"op4", MatrixFormat::op4, "Nastran OUTPUT4, binary"},
                         {"hdf5", MatrixFormat::hdf5, "with the basis"}}))),
                    "write the reduced substructures for other codes")
          .optional("zoom", &Report::zoom, number("s", plausible::duration()), "length of the zoomed pictures");
  const auto prediction = Fields<Prediction>()
                              .required("substructure", &Prediction::substructure, name(),
                                        "linear substructure to drive by its estimated boundary motion")
                              .optional("substeps", &Prediction::substeps, integer(1, 1000),
                                        "steps per sample of a large substructure's time integration");
  const auto damping =
      Fields<GlobalModalDamping>()
          .required("modal", &GlobalModalDamping::modal, one_or_list(number("-", Bounds::between(0, 0.999))),
                    "ratio to critical of every mode, or of each in turn (the last holds for the rest)")
          .optional(
              "up_to", &GlobalModalDamping::up_to, number("Hz", plausible::frequency()),
              "with finite elements: modes up to here have their own ratio, all above it the rate of the last one");
  const auto all = mapping(
      Fields<Case>()
          .required("kalfem", &Case::version, integer(1, 1), "version of the case-file format")
          .optional("title", &Case::title, text(), "one line for the report")
          .required("substructures", &Case::substructures, named(substructure()), "linear parts")
          .optional("connectors", &Case::connectors, named(connector()), "local nonlinear parts between points")
          .optional("damping", &Case::damping, located(mapping(damping)),
                    "of the modes of the whole structure, its connectors as stiff as at rest (unknowns at their first "
                    "values), in the place of the substructures' own modal damping")
          .optional("excitation", &Case::excitation, named(excitation()), "what drives the structure")
          .optional("sensors", &Case::sensors, named(sensor()), "what is measured")
          .optional("simulate", &Case::simulate, simulation(), "make the record by simulation")
          .optional("record", &Case::record, record(), "or read it from a file")
          .optional("estimate", &Case::estimate, estimation(), "states and unknown parameters from the record")
          .optional("predict", &Case::predict, mapping(prediction), "response of a linear substructure")
          .optional("update", &Case::update, updating(), "refine the linear substructures by measurements")
          .optional("modifications", &Case::modifications, named(located(modification())),
                    "changes of the updated structure whose natural frequencies are predicted")
          .optional("report", &Case::report, mapping(report), "what the report page shows"));
  const auto read = [=](const Cursor& cursor, Case& given) {
    given.source = {cursor.location().file, cursor.shared_node()};
    return all.read(cursor, given);
  };
  return make_form<Case>(
      read, [=](const Case& given) { return all.write(given); }, all.schema());
}

}  // namespace kalfem::description
