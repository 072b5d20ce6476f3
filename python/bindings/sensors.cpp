// SPDX-License-Identifier: Apache-2.0
#include "sensors.hpp"

#include "kalfem/base/units.hpp"
#include "kalfem/records/clock_lag.hpp"

namespace kalfem::python {
namespace {

/// A part of a measurement chain, as one type for Python.
struct ChainPart {
  ChainSection section;
};

DofCombination points_of(const py::handle& given) {
  if (py::isinstance<py::str>(given)) return {{given.cast<std::string>(), 1.0}};
  DofCombination points;
  for (const auto& [point, weight] : given.cast<py::dict>()) points[point.cast<std::string>()] = weight.cast<double>();
  return points;
}

template <ObservedQuantity quantity>
Observation observe(const py::object& at, const py::object& noise, bool relative, const std::vector<ChainPart>& chain) {
  Observation made;
  made.output = {"", quantity, points_of(at), relative};
  const auto percentage = percentage_of(noise);
  made.relative_noise = percentage.has_value();
  made.noise = percentage ? *percentage : number_of(noise, unit_of(quantity), "noise");
  for (const auto& part : chain) made.chain.sections.push_back(part.section);
  return made;
}

const Observation& observation_of(const py::handle& given, const std::string& argument) {
  if (!py::isinstance<Observation>(given))
    throw InvalidInput(
        argument + ": " + std::string(py::str(py::repr(given))) + " is given",
        "a sensor is made by acceleration(), velocity(), displacement(), strain(), force(), deformation() or rate()",
        "write kf.acceleration(\"body.3\", noise=0.3)");
  return given.cast<const Observation&>();
}

FilterSection filter_section(FilterBand band, const std::string& family, int order, double cutoff, double upper) {
  if (family != "butterworth" && family != "bessel")
    throw InvalidInput("family: '" + family + "' is given", "filters are of the family butterworth or bessel", "");
  return {.family = family == "bessel" ? FilterFamily::bessel : FilterFamily::butterworth,
          .band = band,
          .order = order,
          .cutoff = cutoff,
          .upper_cutoff = upper};
}

constexpr const char* observe_doc = R"(
Parameters
----------
at : str or dict of str to float
    A point, ``"body.3"``, or points with weights.
noise : float or str
    Standard deviation of its white noise [{unit}]; a filter needs it > 0. A text may have a unit, or be a percentage of
    the channel's rms.
relative : bool
    Without the motion of grounds that ``base_acceleration`` accelerates.
chain : list
    What lies between the motion and the sample: ``low_pass(100.0)``, ``delay(1e-3)``, ...
)";

py::tuple section_state(const ChainSection& section) {
  if (const auto* filter = std::get_if<FilterSection>(&section))
    return py::make_tuple("filter", static_cast<int>(filter->family), static_cast<int>(filter->band), filter->order,
                          filter->cutoff, filter->upper_cutoff);
  if (const auto* delay = std::get_if<DelaySection>(&section))
    return py::make_tuple("delay", delay->delay, delay->order);
  if (const auto* resonance = std::get_if<ResonanceSection>(&section))
    return py::make_tuple("resonance", resonance->frequency, resonance->damping);
  return py::make_tuple("gain", std::get<GainSection>(section).gain);
}

ChainSection section_from(const py::tuple& state) {
  const auto kind = state[0].cast<std::string>();
  const auto number = [&](std::size_t i) { return state[i].cast<double>(); };
  if (kind == "filter")
    return FilterSection{static_cast<FilterFamily>(state[1].cast<int>()), static_cast<FilterBand>(state[2].cast<int>()),
                         state[3].cast<int>(), number(4), number(5)};
  if (kind == "delay") return DelaySection{number(1), state[2].cast<int>()};
  if (kind == "resonance") return ResonanceSection{number(1), number(2)};
  return GainSection{number(1)};
}

/// What a pickle holds.
template <class T>
py::tuple state_of(const T& self) {
  if constexpr (std::is_same_v<T, ChainPart>) {
    return section_state(self.section);
  } else {
    py::list chain;
    for (const auto& section : self.chain.sections) chain.append(section_state(section));
    return py::make_tuple(static_cast<int>(self.output.quantity), self.output.points, self.output.relative_to_base,
                          self.output.carried_masses, self.noise, self.relative_noise, chain);
  }
}

template <class T>
T from_state(const py::tuple& state) {
  if constexpr (std::is_same_v<T, ChainPart>) {
    return {section_from(state)};
  } else {
    Observation made{
        .output = {"", static_cast<ObservedQuantity>(state[0].cast<int>()), state[1].cast<DofCombination>(),
                   state[2].cast<bool>(), state[3].cast<DofCombination>()},
        .noise = state[4].cast<double>(),
        .relative_noise = state[5].cast<bool>()};
    for (const auto& section : state[6].cast<py::list>())
      made.chain.sections.push_back(section_from(section.cast<py::tuple>()));
    return made;
  }
}

/// "Sensor(acceleration of body.3, noise 0.3 m/s^2)".
std::string in_words(const Observation& sensor) {
  std::string points;
  for (const auto& [point, weight] : sensor.output.points)
    points += (points.empty() ? "" : " + ") + (weight == 1.0 ? "" : shortest(weight) + " ") + point;
  const std::string noise = sensor.relative_noise ? shortest(100.0 * sensor.noise) + " %"
                                                  : shortest(sensor.noise) + " " + unit_of(sensor.output.quantity);
  return "Sensor(" + quantity_name(sensor.output.quantity) + " of " + points + ", noise " + noise + ")";
}

template <ObservedQuantity quantity>
void define(py::module_& module, const char* name, const std::string& meaning) {
  std::string doc = meaning + observe_doc;
  doc.replace(doc.find("{unit}"), 6, unit_of(quantity));
  module.def(name, &observe<quantity>, py::arg("at"), py::arg("noise") = 0.0, py::kw_only(),
             py::arg("relative") = false, py::arg("chain") = std::vector<ChainPart>{}, doc.c_str());
}

}  // namespace

std::optional<double> percentage_of(const py::handle& given) {
  if (!py::isinstance<py::str>(given)) return std::nullopt;
  const auto text = given.cast<std::string>();
  if (text.empty() || text.back() != '%') return std::nullopt;
  return parse_quantity(text).value;
}

double number_of(const py::handle& given, const std::string& unit, const std::string& argument) {
  try {
    if (!py::isinstance<py::str>(given)) return given.cast<double>();
    const auto text = given.cast<std::string>();
    return unit.empty() ? parse_quantity(text).value : to_si(text, unit);
  } catch (const InvalidInput& error) {
    std::vector<Issue> issues = error.issues();
    for (auto& issue : issues) issue.what = argument + ": " + issue.what;
    throw InvalidInput(std::move(issues));
  } catch (const py::cast_error&) {
    throw InvalidInput(argument + ": " + std::string(py::str(py::repr(given))) + " is given",
                       "a number is needed, or a text with a unit", "give it in " + (unit.empty() ? "SI units" : unit));
  }
}

std::vector<SensorDescription> sensors_of(const py::dict& sensors) {
  std::vector<SensorDescription> all;
  for (const auto& [name, given] : sensors) {
    const auto key = name.cast<std::string>();
    const auto& [output, noise, chain, relative] = observation_of(given, entry_of("sensors", key));
    all.push_back({key, output, relative ? 0.0 : noise, chain});
  }
  return all;
}

std::string quantity_name(ObservedQuantity quantity) {
  using enum ObservedQuantity;
  switch (quantity) {
    case displacement:
      return "displacement";
    case velocity:
      return "velocity";
    case acceleration:
      return "acceleration";
    case connector_force:
      return "force";
    case connector_deformation:
      return "deformation";
    case connector_rate:
      return "rate";
    case strain:
      return "strain";
  }
  return "";
}

py::dict sensors_in_python(const std::vector<SensorDescription>& sensors) {
  py::dict all;
  for (const auto& [name, output, noise, chain] : sensors)
    all[py::str(name)] = Observation{.output = output, .noise = noise, .chain = chain};
  return all;
}

void set_relative_noise(const py::dict& sensors, const Record& record, std::vector<SensorDescription>& all) {
  for (Eigen::Index i = 0; const auto& [name, given] : sensors) {
    const auto& observation = given.cast<const Observation&>();
    if (observation.relative_noise)
      all[static_cast<std::size_t>(i)].noise = observation.noise * rms_of_present(record.values.row(i).transpose());
    ++i;
  }
}

void refuse_relative_noise(const py::dict& sensors) {
  IssueList issues;
  for (const auto& [name, given] : sensors)
    if (const auto& observation = given.cast<const Observation&>(); observation.relative_noise)
      issues.add({}, entry_of("sensors", name.cast<std::string>()) + ": its noise is a percentage of the channel's rms",
                 "a Filter does not know the channel before it comes",
                 "give its standard deviation in " + unit_of(observation.output.quantity));
  issues.raise();
}

std::vector<OutputRequest> outputs_of(const py::dict& outputs) {
  std::vector<OutputRequest> all;
  for (const auto& [name, given] : outputs) {
    const auto key = name.cast<std::string>();
    all.push_back({key, observation_of(given, entry_of("outputs", key)).output});
  }
  return all;
}

void bind_sensors(py::module_& module) {
  py::class_<Observation>(module, "Sensor", "What a sensor measures, and its noise. Made by acceleration() and so on.")
      .def_property_readonly(
          "noise",
          [](const Observation& self) -> py::object {
            if (self.relative_noise) return py::str(shortest(100.0 * self.noise) + " %");
            return py::float_(self.noise);
          },
          "Standard deviation of its white noise [its unit], or a percentage of the channel's rms.")
      .def_property_readonly(
          "unit", [](const Observation& self) { return unit_of(self.output.quantity); }, "SI unit.")
      .def_property_readonly(
          "points", [](const Observation& self) { return self.output.points; },
          "Points, or connectors, with their weights.")
      .def("__repr__", &in_words)
      .def(py::pickle(&state_of<Observation>, &from_state<Observation>));
  define<ObservedQuantity::displacement>(module, "displacement", "Absolute displacement of a point [m].\n");
  define<ObservedQuantity::velocity>(module, "velocity", "Absolute velocity of a point [m/s].\n");
  define<ObservedQuantity::acceleration>(module, "acceleration", "Absolute acceleration of a point [m/s^2].\n");
  define<ObservedQuantity::strain>(module, "strain", "Strain of a gauge of finite elements, ``\"frame.g1\"`` [m/m].\n");
  define<ObservedQuantity::connector_force>(module, "force", "Force of a connector [N].\n");
  define<ObservedQuantity::connector_deformation>(module, "deformation", "Deformation of a connector [m].\n");
  define<ObservedQuantity::connector_rate>(module, "rate", "Rate of deformation of a connector [m/s].\n");

  py::class_<ChainPart>(module, "ChainSection", "A part of a measurement chain.")
      .def(py::pickle(&state_of<ChainPart>, &from_state<ChainPart>));
  module.def(
      "low_pass",
      [](double cutoff, int order, const std::string& family) {
        return ChainPart{filter_section(FilterBand::low_pass, family, order, cutoff, 0.0)};
      },
      py::arg("cutoff"), py::arg("order") = 4, py::arg("family") = "butterworth",
      "Analogue low-pass filter of the measurement chain; `cutoff`: of -3.01 dB [Hz].");
  module.def(
      "high_pass",
      [](double cutoff, int order, const std::string& family) {
        return ChainPart{filter_section(FilterBand::high_pass, family, order, cutoff, 0.0)};
      },
      py::arg("cutoff"), py::arg("order") = 4, py::arg("family") = "butterworth",
      "Analogue high-pass filter of the measurement chain; `cutoff`: of -3.01 dB [Hz].");
  module.def(
      "delay",
      [](double seconds, int order) {
        return ChainPart{DelaySection{seconds, order}};
      },
      py::arg("seconds"), py::arg("order") = 6, "Pure delay of the measurement chain [s].");
  module.def(
      "without_lag",
      [](const Eigen::VectorXd& samples, double sample_rate, const py::object& delay, const py::object& drift) {
        const ClockLag lag{number_of(delay, "s", "delay"), number_of(drift, "-", "drift")};
        return array_of(without_lag(make_record(sample_rate, {{"samples", samples}}), 0, lag));
      },
      py::arg("samples"), py::arg("sample_rate"), py::kw_only(), py::arg("delay") = 0.0, py::arg("drift") = 0.0,
      R"(The samples of a channel with every motion at its own time: y(t + delay + drift t) stands at t.

Parameters
----------
samples : array of shape (n,)
    As its clock showed them; not a number where one is missing.
sample_rate : float
    [Hz]
delay : float or str
    By so much the channel is late [s].
drift : float or str
    By so much its clock runs fast, as ``"50 ppm"``; t counts from the first sample.

Returns
-------
array of shape (n,)
    Not a number where a sample would come from beyond an end. Exact at every frequency below Nyquist.)");
  module.def(
      "resonance",
      [](double frequency, double damping) {
        return ChainPart{ResonanceSection{frequency, damping}};
      },
      py::arg("frequency"), py::arg("damping") = 0.7, "Roll-off of a sensor with one resonance [Hz].");
  module.def(
      "gain", [](double factor) { return ChainPart{GainSection{factor}}; }, py::arg("factor"),
      "Constant factor of the measurement chain.");
}

}  // namespace kalfem::python
