// SPDX-License-Identifier: Apache-2.0
#include "calls.hpp"
#include "options.hpp"
#include "results.hpp"
#include "sensors.hpp"
#include "structure.hpp"

namespace kalfem::python {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// Sets the numbers that a dictionary gives by name; `what` is the argument that it stands in.
void set_numbers(const py::dict& given, const std::string& what, const std::map<std::string, double*>& numbers,
                 const std::map<std::string, int*>& counts) {
  for (const auto& [key, value] : given) {
    const auto name = key.cast<std::string>();
    if (const auto number = numbers.find(name); number != numbers.end()) {
      *number->second = value.cast<double>();
    } else if (const auto count = counts.find(name); count != counts.end()) {
      *count->second = value.cast<int>();
    } else {
      std::vector<std::string> known;
      for (const auto& each : numbers) known.push_back(each.first);
      for (const auto& each : counts) known.push_back(each.first);
      throw InvalidInput(what + ": there is no '" + name + "'" + did_you_mean(name, known), "", "");
    }
  }
}

/// GateOptions from a dictionary of its numbers; nothing for None.
std::optional<GateOptions> gates_of(const py::object& given) {
  if (given.is_none()) return std::nullopt;
  GateOptions gates;
  set_numbers(given, "gates", {{"limit", &gates.limit}, {"inflation", &gates.inflation}},
              {{"warm_up", &gates.warm_up},
               {"memory", &gates.memory},
               {"suspend_after", &gates.suspend_after},
               {"stuck", &gates.stuck},
               {"patience", &gates.patience},
               {"silence", &gates.silence},
               {"most_events", &gates.most_events}});
  return gates;
}

/// ChangeOptions from a dictionary of its numbers, with the effect of each covariate by its name; nothing for None.
std::optional<ChangeOptions> changes_of(const py::object& given, const py::dict& covariates) {
  if (given.is_none()) return std::nullopt;
  ChangeOptions changes;
  set_numbers(given, "changes",
              {{"window", &changes.window},
               {"level", &changes.level},
               {"hysteresis", &changes.hysteresis},
               {"false_alarms_every", &changes.false_alarms_every}},
              {{"reference", &changes.reference}, {"memory", &changes.memory}, {"persistence", &changes.persistence}});
  for (const auto& [name, effect] : covariates)
    changes.covariates.push_back({name.cast<std::string>(), effect.cast<double>()});
  return changes;
}

template <class Work>
auto without_gil(const Work& work) {
  const py::gil_scoped_release released;
  return work();
}

/// A filter that Python moves, step by step or by channels as they come, but not both ways.
class PythonFilter {
public:
  PythonFilter(const Structure& structure, double sample_rate, const EstimateOptions& options, const LiveOptions& live)
      : structure_(structure), sample_rate_(sample_rate), live_([&] {
          const py::gil_scoped_release released;
          return LiveFilter(structure, sample_rate, options, live);
        }()) {
    for (const auto& sensor : options.sensors) sensors_.push_back(sensor.name);
    for (const auto& input : structure.description().parts.inputs) inputs_.push_back(input.name);
  }

  bool predict(const py::object& u) {
    require(Mode::steps);
    const bool moved = u.is_none() ? without_gil([&] { return filter().predict(); }) : predict_to(u);
    raise_of_laws(structure_);
    return moved;
  }

  bool update(const py::object& y) {
    require(Mode::steps);
    read(y, sensors_, "y", values_);
    const bool moved = without_gil([&] { return filter().update(values_); });
    raise_of_laws(structure_);
    return moved;
  }

  /// predict() and update() over many samples; returns how many there were before a stop.
  Index advance(const Column& u, const Column& y) {
    require(Mode::steps);
    const auto inputs = std::ssize(inputs_), sensors = std::ssize(sensors_);
    if (y.ndim() != 2 || y.shape(1) != sensors || u.ndim() != 2 || u.shape(1) != inputs || u.shape(0) != y.shape(0))
      throw InvalidInput("advance: u and y have other shapes than (samples, " + std::to_string(inputs) +
                             ") and (samples, " + std::to_string(sensors) + ")",
                         "a row is one sample", "");
    const Eigen::Map<const Eigen::MatrixXd> of_inputs(u.data(), inputs, u.shape(0)),
        of_sensors(y.data(), sensors, y.shape(0));
    const Index count = without_gil([&] {
      for (Index k = 0; k < of_sensors.cols(); ++k)
        if (!filter().predict_values(of_inputs.col(k)) || !filter().update(of_sensors.col(k))) return k;
      return of_sensors.cols();
    });
    raise_of_laws(structure_);
    return count;
  }

  void start(const py::object& u) {
    require(Mode::steps);
    read(u, inputs_, "u", values_);
    filter().start(values_);
  }

  Index push(const std::string& name, const py::object& t, const py::object& values) {
    require(Mode::blocks);
    const Column block = Column::ensure(values);
    if (!block || block.ndim() > 1) {
      PyErr_Clear();
      throw InvalidInput("push: the values of '" + name + "' are no array of one dimension", "", "give shape (n,)");
    }
    const Eigen::Map<const VectorXd> samples(block.data(), block.size());
    const Column times = Column::ensure(t);
    if (!times || times.ndim() > 1) {
      PyErr_Clear();
      throw InvalidInput("push: t is no time", "", "give the time of the first value, or one for each value");
    }
    const Index taken =
        times.ndim() == 0 ? without_gil([&] { return live_.push(name, *times.data(), samples); }) : without_gil([&] {
          return live_.push(name, Eigen::Map<const VectorXd>(times.data(), times.size()), samples);
        });
    raise_of_laws(structure_);
    return taken;
  }

  Index flush() {
    const Index taken = without_gil([&] {
      if (mode_ != Mode::steps) return live_.flush();
      const double before = filter().time();
      filter().finish();
      return static_cast<Index>(std::llround((filter().time() - before) * sample_rate_));
    });
    raise_of_laws(structure_);
    return taken;
  }

  py::tuple state(const std::string& name) {
    const auto [mean, std] = without_gil([&] { return filter().state(name); });
    return py::make_tuple(mean, std);
  }

  void write_state(const std::string& file) const { live_.write_state(file); }
  void read_state(const std::string& file) { live_.read_state(file); }

  [[nodiscard]] OnlineFilter& filter() { return live_.filter(); }
  [[nodiscard]] const LiveFilter& live() const { return live_; }
  [[nodiscard]] const std::vector<std::string>& sensors() const { return sensors_; }
  [[nodiscard]] const std::vector<std::string>& inputs() const { return inputs_; }

private:
  enum class Mode { none, steps, blocks };

  void require(Mode mode) {
    if (mode_ == mode) return;
    if (mode_ != Mode::none)
      throw InvalidInput(mode == Mode::steps ? "predict() and update() are called after push()"
                                             : "push() is called after predict() or update()",
                         "a filter is moved one way or the other", "make another Filter");
    mode_ = mode;
  }

  /// Values in the order of `names`: an array, or a dictionary in which missing sensors are missing values.
  void read(const py::object& given, const std::vector<std::string>& names, const char* argument,
            VectorXd& values) const {
    values.resize(std::ssize(names));
    if (PyDict_Check(given.ptr())) {
      read_entries(given, names, argument, values);
      return;
    }
    const Column column = Column::ensure(given);
    if (!column) PyErr_Clear();
    if (!column || column.ndim() > 1 || column.size() != values.size())
      throw InvalidInput(
          std::string(argument) + ": " + (column ? std::to_string(column.size()) + " values" : "no array of numbers"),
          "there are " + std::to_string(names.size()) + ": " + joined(names),
          "give them as an array in this order, or a dictionary");
    std::copy_n(column.data(), values.size(), values.data());
  }

  void read_entries(const py::object& given, const std::vector<std::string>& names, const char* argument,
                    VectorXd& values) const {
    values.setConstant(std::numeric_limits<double>::quiet_NaN());
    for (const auto& [key, value] : py::reinterpret_borrow<py::dict>(given)) {
      const auto name = key.cast<std::string>();
      const auto at = std::ranges::find(names, name);
      if (at == names.end())
        throw InvalidInput(entry_of(argument, name) + ": there is none of that name" + did_you_mean(name, names), "",
                           "there are " + joined(names));
      values[at - names.begin()] = value.cast<double>();
    }
  }

  static std::string joined(const std::vector<std::string>& names) {
    std::string all;
    for (const auto& name : names) all += (all.empty() ? "" : ", ") + name;
    return all.empty() ? "none" : all;
  }

  /// Values alone, or value, rate and acceleration of each input: shape (inputs,) or (inputs, 3).
  bool predict_to(const py::object& u) {
    if (const Column column = PyArray_like(u); column && column.ndim() == 2) return predict_with_rates(column);
    read(u, inputs_, "u", values_);
    return without_gil([&] { return filter().predict_values(values_); });
  }

  static Column PyArray_like(const py::object& u) {
    return py::isinstance<py::array>(u) ? Column::ensure(u) : Column(py::none());
  }

  bool predict_with_rates(const Column& column) {
    if (column.shape(1) != 3)
      throw InvalidInput("u: an array of " + std::to_string(column.shape(1)) + " columns",
                         "columns are value, rate and acceleration", "give shape (inputs,) or (inputs, 3)");
    std::vector<InputSample> samples;
    for (Index i = 0; i < column.shape(0); ++i) samples.push_back({column.at(i, 0), column.at(i, 1), column.at(i, 2)});
    return without_gil([&] { return filter().predict(samples); });
  }

  Structure structure_;
  double sample_rate_;  ///< [Hz]
  LiveFilter live_;
  std::vector<std::string> sensors_, inputs_;
  VectorXd values_;
  Mode mode_ = Mode::none;
};

py::dict entry_of(const std::string& unit, const PresentEstimate& now, double lower, double upper) {
  py::dict entry;
  entry["estimate"] = now.mean;
  entry["std"] = now.std;
  entry["interval_95"] = py::make_tuple(lower, upper);
  entry["unit"] = unit;
  return entry;
}

py::dict parameters_of(PythonFilter& self) {
  py::dict all;
  for (const auto& each : self.filter().parameters())
    all[py::str(each.name)] =
        entry_of(each.unit, {each.mean, each.std}, each.interval_95.lower, each.interval_95.upper);
  return all;
}

/// (time, parameters, states); None without a lag and before the first sample.
py::object smoothed_of(PythonFilter& self) {
  const auto found = without_gil([&] { return self.filter().smoothed(); });
  if (!found) return py::none();
  py::dict parameters, states;
  for (const auto& each : found->parameters)
    parameters[py::str(each.name)] = entry_of(each.unit, {each.mean, each.std}, each.lower, each.upper);
  for (const auto& [name, each] : found->outputs) states[py::str(name)] = py::make_tuple(each.mean, each.std);
  return py::make_tuple(found->time, parameters, states);
}

py::list events_of(PythonFilter& self) {
  py::list all;
  for (const auto& event : self.filter().events())
    all.append(py::make_tuple(event.time, to_string(event.kind), event.channel, event.text));
  return all;
}

py::dict dict_of(const SpanHealth& health) {
  py::dict shares;
  using enum FilterCondition;
  for (const auto condition : {warming_up, consistent, suspicious, unusable, silent})
    if (health.share(condition) > 0.0) shares[py::str(to_string(condition))] = health.share(condition);
  py::list reasons;
  for (const auto& [code, subject, share] : health.reasons) reasons.append(py::make_tuple(code, subject, share));
  return py::dict(py::arg("seconds") = health.duration, py::arg("shares") = shares, py::arg("nis") = health.mean_nis,
                  py::arg("expected_nis") = health.expected_nis, py::arg("reasons") = reasons);
}

py::dict health_of(PythonFilter& self) {
  const auto& filter = self.filter();
  return py::dict(py::arg("minute") = dict_of(filter.health(HealthSpan::minute)),
                  py::arg("hour") = dict_of(filter.health(HealthSpan::hour)),
                  py::arg("day") = dict_of(filter.health(HealthSpan::day)));
}

py::tuple tuple_of(const ParameterChange& what) {
  return py::make_tuple(what.parameter, what.change, what.std, py::make_tuple(what.lower, what.upper), what.since,
                        py::make_tuple(what.earliest, what.latest));
}

py::list alarms_of(PythonFilter& self) {
  py::list all;
  for (const auto& alarm : self.filter().alarms())
    all.append(py::make_tuple(alarm.number, to_string(alarm.kind), alarm.time, tuple_of(alarm.what), alarm.text));
  return all;
}

py::list present_changes_of(PythonFilter& self) {
  py::list all;
  for (const auto& what : self.filter().changes()) all.append(tuple_of(what));
  return all;
}

py::list trend_of(PythonFilter& self) {
  py::list all;
  for (const auto& each : self.filter().trend()) {
    const auto& [mean, std, lower, upper] = each.corrected;
    all.append(py::make_tuple(each.day, each.parameter, each.unit, each.measured.mean, each.measured.std, mean, std,
                              each.windows));
  }
  return all;
}

py::tuple consistency_of(PythonFilter& self) {
  const auto found = self.filter().consistency();
  return py::make_tuple(found.mean_nis, found.expected_nis, found.fraction_in_95);
}

}  // namespace

void bind_filter(py::module_& module) {
  py::class_<PythonFilter>(module, "Filter", "A filter that is moved by its caller: see kalfem.Filter.")
      .def(py::init([](const Structure& structure, double sample_rate, const py::dict& arguments, double start,
                       double horizon, int input_delay, int window, int lag, const py::object& gates,
                       const py::object& changes, const py::dict& covariates) {
             refuse_relative_noise(arguments["sensors"]);
             const LiveOptions live{.start = start,
                                    .horizon = horizon,
                                    .filter = {.input_delay = input_delay,
                                               .window = window,
                                               .lag = lag,
                                               .gates = gates_of(gates),
                                               .changes = changes_of(changes, covariates)}};
             return std::make_unique<PythonFilter>(structure, sample_rate, options_of(structure, arguments), live);
           }),
           py::arg("structure"), py::arg("sample_rate"), py::arg("arguments"), py::arg("start"), py::arg("horizon"),
           py::arg("input_delay"), py::arg("window"), py::arg("lag"), py::arg("gates"), py::arg("changes"),
           py::arg("covariates"))
      .def("predict", &PythonFilter::predict, py::arg("u") = py::none(), R"(Move to the next sample.

Parameters
----------
u : array of shape (inputs,) or (inputs, 3), or dict, optional
    The inputs there, in the order in which the structure has them: their values, or value, rate and acceleration of
    each. Values alone pass through a spline: the filter stays `input_delay` samples behind. Left out: the structure's
    own samples are used.

Returns
-------
bool
    False if the filter has stopped: see `failure`.
)")
      .def("update", &PythonFilter::update, py::arg("y"), R"(Condition on what the sensors show.

Parameters
----------
y : array of shape (sensors,), or dict
    In the order of the sensors [SI]; NaN, or a missing key, is a missing value.

Returns
-------
bool
    False if the filter has stopped: see `failure`.
)")
      .def("advance", &PythonFilter::advance, py::arg("u"), py::arg("y"), R"(Predict and update over many samples.

Parameters
----------
u : array, shape (samples, inputs)
y : array, shape (samples, sensors)

Returns
-------
int
    Samples that it was moved by: fewer where it has stopped.
)")
      .def("begin", &PythonFilter::start, py::arg("u"), "Tell the inputs at the first sample, before its update().")
      .def("push", &PythonFilter::push, py::arg("name"), py::arg("t"), py::arg("values"),
           R"(Hand over samples of one channel.

Parameters
----------
name : str
    A sensor, or an input that has no samples.
t : float or array of shape (n,)
    Time of the first value, those after it one sampling interval apart; or of each value, ascending [s].
values : array of shape (n,) or float
    [SI]; NaN is a missing value of a sensor.

Returns
-------
int
    How many samples the filter took: those that every channel has now, and those behind the horizon.

Notes
-----
The order in which channels and blocks come changes no bit, as long as none comes later than `horizon` behind another.
What comes later still is dropped and counted in `dropped`.
)")
      .def("flush", &PythonFilter::flush,
           R"(Take all samples that any channel has, and those that wait for later inputs.

Returns
-------
int
    How many there were.
)")
      .def("state", &PythonFilter::state, py::arg("name"),
           "Mean and standard deviation of ``body.2.displacement``, ``body.2.velocity``, or an output.")
      .def("_parameters", &parameters_of)
      .def("_smoothed", &smoothed_of)
      .def_property_readonly(
          "time", [](PythonFilter& self) { return self.filter().time(); },
          "Of the sample at which the filter stands, the first one at 0 [s].")
      .def_property_readonly(
          "innovation", [](PythonFilter& self) { return VectorXd(self.filter().innovation()); },
          "Measured minus predicted of the last update, shape (sensors,).")
      .def_property_readonly(
          "nis", [](PythonFilter& self) { return self.filter().nis(); },
          "Normalised innovation squared of the last update.")
      .def_property_readonly(
          "failure",
          [](PythonFilter& self) -> py::object {
            const auto& failure = self.filter().failure();
            if (!failure) return py::none();
            return py::str("the filter stopped at " + std::to_string(failure->time) + " s: " + failure->reason);
          },
          "When and why it stopped; None while it goes on.")
      .def_property_readonly(
          "running", [](PythonFilter& self) { return self.filter().running(); }, "Whether it has not stopped.")
      .def_property_readonly(
          "usable", [](PythonFilter& self) { return self.filter().usable(); },
          "Whether its numbers can be relied on: it is running, and its verdict is not unusable.")
      .def_property_readonly(
          "condition", [](PythonFilter& self) { return to_string(self.filter().condition()); },
          "``warming up``, ``consistent``, ``suspicious``, ``unusable`` or ``silent``.")
      .def_property_readonly("health", &health_of, R"(
How it has fared over the latest minute, hour and day of the stream, by one look a second: for each of ``minute``,
``hour`` and ``day`` a dictionary of

* ``seconds``, of the span as far as the filter has been there,
* ``shares``, of the time by `condition`,
* ``nis`` and ``expected_nis``, means; NaN where no sensor gave a value,
* ``reasons``, a list of (code, subject, share of the time), the largest share first.
)")
      .def("_events", &events_of)
      .def("_alarms", &alarms_of)
      .def("_changes", &present_changes_of)
      .def("_trend", &trend_of)
      .def(
          "covariate",
          [](PythonFilter& self, const std::string& name, double t, double value) {
            self.filter().covariate(name, t, value);
          },
          py::arg("name"), py::arg("t"), py::arg("value"),
          "Tell the value of a covariate at a time [s] from the first sample on, before the filter has passed it.")
      .def("write_state", &PythonFilter::write_state, py::arg("file"),
           "Write all that later steps depend on to a file, which is replaced at once.")
      .def("read_state", &PythonFilter::read_state, py::arg("file"),
           "Go on from such a file of the same structure and options, with the same bits.")
      .def("_verdict", [](PythonFilter& self) { return summary_of(self.filter().verdict()); })
      .def("_consistency", &consistency_of)
      .def_property_readonly(
          "samples", [](const PythonFilter& self) { return self.live().samples(); },
          "Samples that push() has moved it by.")
      .def_property_readonly(
          "dropped", [](const PythonFilter& self) { return self.live().dropped(); },
          "Values that came behind the horizon, or twice.")
      .def_property_readonly("sensors", &PythonFilter::sensors)
      .def_property_readonly("inputs", &PythonFilter::inputs);
}

}  // namespace kalfem::python
