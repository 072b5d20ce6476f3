// SPDX-License-Identifier: Apache-2.0
#include "options.hpp"

#include <cmath>

#include "kalfem/base/units.hpp"
#include "kalfem/identification/measurement_unknowns.hpp"
#include "sensors.hpp"

namespace kalfem::python {
namespace {

double parameter_value(const py::handle& given, const Structure& structure, const std::string& name,
                       const std::string& argument) {
  // Otherwise its unit need not be looked up, and the structure does not know that of a number of the measurement.
  const bool text = py::isinstance<py::str>(given) && !is_measurement_unknown(name);
  return number_of(given, text ? structure.unit(name) : "", argument);
}

/// Reads the value of one entry of `unknown`.
class PriorReader {
public:
  PriorReader(const Structure& structure, std::string name)
      : structure_(structure), name_(std::move(name)), argument_(entry_of("unknown", name_)) {}

  UnknownDescription read(const py::handle& given) {
    if (py::isinstance<py::dict>(given))
      read_entries(given.cast<py::dict>());
    else if (py::isinstance<py::tuple>(given) || py::isinstance<py::list>(given))
      read_pair(given.cast<py::sequence>());
    else if (!given.is_none())
      prior_.initial = value(given);
    return {name_, prior_};
  }

private:
  [[nodiscard]] double value(const py::handle& given) const {
    return parameter_value(given, structure_, target(), argument_);
  }
  [[nodiscard]] std::string target() const { return prior_.applies_to.empty() ? name_ : prior_.applies_to.front(); }

  void read_pair(const py::sequence& pair) {
    if (pair.size() != 2)
      throw InvalidInput(argument_ + ": " + std::to_string(pair.size()) + " values are given",
                         "a prior is its mean and its standard deviation", "write (1e8, \"50 %\")");
    prior_.initial = value(py::object(pair[0]));
    read_std(py::object(pair[1]));
  }

  void read_std(const py::handle& given) {
    const auto part = percentage_of(given);
    if (!part) {
      prior_.std = value(given);
      return;
    }
    prior_.std = *part * std::abs(prior_.initial ? *prior_.initial : structure_.value(target()));
  }

  void read_entries(const py::dict& entries) {
    const std::vector<std::string> known{"initial", "std", "random_walk", "transform", "bounds", "applies_to"};
    for (const auto& [key, given] : entries)
      if (const auto name = key.cast<std::string>(); std::ranges::find(known, name) == known.end())
        throw InvalidInput(argument_ + ": there is no entry '" + name + "'" + did_you_mean(name, known), "", "");
    if (entries.contains("applies_to")) prior_.applies_to = entries["applies_to"].cast<std::vector<std::string>>();
    if (entries.contains("initial")) prior_.initial = value(entries["initial"]);
    if (entries.contains("std")) read_std(entries["std"]);
    if (entries.contains("random_walk")) prior_.random_walk = number_of(entries["random_walk"], "", argument_);
    if (entries.contains("bounds")) read_bounds(entries["bounds"].cast<py::sequence>());
    if (entries.contains("transform")) read_transform(entries["transform"].cast<std::string>());
  }

  void read_bounds(const py::sequence& bounds) {
    if (bounds.size() != 2)
      throw InvalidInput(argument_ + ": " + std::to_string(bounds.size()) + " bounds",
                         "there are a lower and an upper one", "");
    prior_.transform = {TransformKind::logit, value(py::object(bounds[0])), value(py::object(bounds[1]))};
  }

  void read_transform(const std::string& name) {
    if (name == "logit" && prior_.transform) return;
    if (name != "log" && name != "none")
      throw InvalidInput(argument_ + ": the transform '" + name + "' is given",
                         "it is log or none, or logit with bounds", "");
    prior_.transform = {name == "log" ? TransformKind::log : TransformKind::none};
  }

  const Structure& structure_;
  std::string name_, argument_;
  Prior prior_;
};

std::vector<UnknownDescription> unknowns_of(const Structure& structure, const py::object& unknown) {
  std::vector<UnknownDescription> all;
  if (!py::isinstance<py::dict>(unknown)) {
    for (const auto& name : unknown) all.push_back({name.cast<std::string>()});
    return all;
  }
  for (const auto& [name, given] : unknown.cast<py::dict>()) {
    const auto key = name.cast<std::string>();
    all.push_back(PriorReader(structure, key).read(given));
  }
  return all;
}

std::optional<FilterKind> filter_named(const std::string& name) {
  if (name == "auto") return std::nullopt;
  std::vector<std::string> known{"auto"};
  for (const auto kind : {FilterKind::unscented, FilterKind::unscented_square_root, FilterKind::partially_linear,
                          FilterKind::partially_linear_square_root, FilterKind::extended}) {
    if (to_string(kind) == name) return kind;
    known.push_back(to_string(kind));
  }
  std::string all;
  for (const auto& each : known) all += (all.empty() ? "" : ", ") + each;
  throw InvalidInput("filter: there is no filter '" + name + "'" + did_you_mean(name, known), "", "give one of " + all);
}

std::vector<std::pair<std::string, PointPrior>> initial_state_of(const py::dict& given) {
  std::vector<std::pair<std::string, PointPrior>> all;
  const std::vector<std::string> known{"displacement", "velocity", "displacement_std", "velocity_std"};
  for (const auto& [point, entries] : given) {
    const auto name = point.cast<std::string>();
    PointPrior prior;
    for (const auto& [key, value] : entries.cast<py::dict>()) {
      const auto entry = key.cast<std::string>();
      double* const members[] = {&prior.displacement, &prior.velocity, &prior.displacement_std, &prior.velocity_std};
      const auto at = std::ranges::find(known, entry);
      if (at == known.end())
        throw InvalidInput(
            entry_of("initial_state", name) + ": there is no entry '" + entry + "'" + did_you_mean(entry, known), "",
            "");
      const bool of_displacement = entry.starts_with("displacement");
      *members[at - known.begin()] = number_of(value, of_displacement ? "m" : "m/s", entry_of("initial_state", name));
    }
    all.push_back({name, prior});
  }
  return all;
}

std::vector<std::pair<std::string, ConnectorStatePrior>> connector_states_of(const py::dict& given) {
  std::vector<std::pair<std::string, ConnectorStatePrior>> all;
  for (const auto& [state, entries] : given) {
    const auto name = state.cast<std::string>();
    const std::string argument = entry_of("initial_connector_states", name);
    ConnectorStatePrior prior;
    for (const auto& [key, value] : entries.cast<py::dict>()) {
      const auto entry = key.cast<std::string>();
      if (entry != "value" && entry != "std")
        throw InvalidInput(argument + ": there is no entry '" + entry + "'", "it has value and std", "");
      (entry == "std" ? prior.std : prior.value) = number_of(value, "", argument);
    }
    all.push_back({name, prior});
  }
  return all;
}

/// "none", "full" or a number; nothing for None.
std::optional<double> second_thoughts_of(const py::handle& given) {
  if (given.is_none()) return std::nullopt;
  if (!py::isinstance<py::str>(given)) return cast_of<double>(given, "second_thoughts");
  const auto word = given.cast<std::string>();
  if (word == "none") return 0.0;
  if (word == "full") return std::numeric_limits<double>::infinity();
  throw InvalidInput("second_thoughts: '" + word + "' is not known", "", "give none, full or a number");
}

FreeNumbers free_of(const std::string& word) {
  for (const auto free : {FreeNumbers::none, FreeNumbers::ask, FreeNumbers::automatic})
    if (word == to_string(free)) return free;
  throw InvalidInput("free: '" + word + "' is not known", "", "give none, ask or auto");
}

}  // namespace

std::vector<KnownTo> known_to_of(const py::dict& given) {
  std::vector<KnownTo> all;
  for (const auto& [key, value] : given) {
    const auto name = cast_of<std::string>(key, "known_to");
    const auto percentage = percentage_of(value);
    all.push_back({.name = name,
                   .deviation = percentage ? *percentage : number_of(value, "", entry_of("known_to", name)),
                   .relative = percentage.has_value()});
  }
  return all;
}

/// {"process": True, "sensors": False, "memory": 2.0}; nothing for None.
AdaptiveNoise adaptive_noise_of(const py::object& given) {
  AdaptiveNoise options;
  if (given.is_none()) return options;
  for (const auto& [key, value] : cast_of<py::dict>(given, "adaptive_noise")) {
    const auto name = cast_of<std::string>(key, "adaptive_noise");
    const std::string place = entry_of("adaptive_noise", name);
    if (name == "sensors" || name == "process")
      (name == "sensors" ? options.sensors : options.process) = cast_of<bool>(value, place.c_str());
    else if (name == "memory")
      options.memory = number_of(value, "s", place);
    else
      throw InvalidInput(place + ": there is no such entry", "", "give sensors, process or memory");
  }
  if (!(options.memory > 0.0)) throw InvalidInput("adaptive_noise: memory must be positive", "", "give a time [s]");
  return options;
}

EstimateOptions options_of(const Structure& structure, const py::dict& arguments) {
  EstimateOptions options;
  const auto take = [&](const char* name, auto& member) {
    if (arguments.contains(name)) member = cast_of<std::decay_t<decltype(member)>>(arguments[name], name);
  };
  options.sensors = sensors_of(arguments["sensors"]);
  options.unknowns = unknowns_of(structure, arguments["unknown"]);
  options.outputs = outputs_of(arguments["outputs"]);
  options.filter = filter_named(cast_of<std::string>(arguments["filter"], "filter"));
  options.initial_state = initial_state_of(arguments["initial_state"]);
  if (arguments.contains("initial_connector_states"))
    options.initial_connector_states = connector_states_of(arguments["initial_connector_states"]);
  options.process_noise = number_of(arguments["process_noise"], "m/s^2/sqrt(Hz)", "process_noise");
  take("substeps", options.substeps);
  take("step_order", options.step_order);
  take("threads", options.threads);
  take("initial_state_from_record", options.initial_state_from_record);
  take("estimate_initial_state", options.estimate_initial_state);
  take("passes", options.passes);
  take("settle", options.settle);
  take("diagnose", options.diagnose);
  if (arguments.contains("adaptive_noise")) options.adaptive_noise = adaptive_noise_of(arguments["adaptive_noise"]);
  if (arguments.contains("known_to")) options.known_to = known_to_of(arguments["known_to"]);
  if (arguments.contains("free")) options.free = free_of(cast_of<std::string>(arguments["free"], "free"));
  if (arguments.contains("second_thoughts")) options.second_thoughts = second_thoughts_of(arguments["second_thoughts"]);
  return options;
}

}  // namespace kalfem::python
