// SPDX-License-Identifier: Apache-2.0
#include "kalfem/casefile/case_schema.hpp"
#include "kalfem/casefile/component_schema.hpp"
#include "kalfem/casefile/gravity.hpp"
#include "kalfem/casefile/plausible.hpp"
#include "kalfem/yaml/map_schema.hpp"

namespace kalfem::description {

using namespace schema;

namespace {

Schema<double> seconds() { return number("s", plausible::time()); }
Schema<double> hertz() { return number("Hz", Bounds::between(0, plausible::frequency().high)); }

template <class T>
kalfem::Case<T> target(std::string_view key, Name T::*member, std::string_view meaning) {
  return when(key,
              convert<T>(
                  name(),
                  [=](const Name& given) {
                    T t;
                    t.*member = given;
                    return t;
                  },
                  [=](const T& t) { return t.*member; }),
              meaning);
}

kalfem::Case<BaseAcceleration> base_acceleration() {
  return when("base_acceleration",
              convert<BaseAcceleration>(
                  points("ground"), [](const Points& given) { return BaseAcceleration{given}; },
                  [](const BaseAcceleration& target) { return target.direction; }),
              "accelerate grounds [m/s^2]. A named ground, or several with weights: displacements stay absolute. "
              "`all`, or degrees of freedom with weights: the whole base moves and displacements are relative to it");
}

/// Only an unknown excitation may have no signal.
std::vector<Issue> check_signal(const Excitation& given) {
  if (given.signal || given.unknown) return {};
  return {{{},
           "the excitation has no signal",
           "",
           "give one of random, sine, sweep, impulse, road, file, delayed, trailing_axle, constant; or `unknown`, if "
           "the filter is to estimate it"}};
}

std::vector<Issue> check_process(const UnknownInput& given) {
  if (!given.std && !given.random_walk)
    return {{{},
             "the process of the unknown excitation has no size",
             "the filter needs to know how large the excitation may be",
             "give std and correlation_time, or random_walk"}};
  if (given.order && given.random_walk)
    return {{{},
             "both smoothness and random_walk are given",
             "a random walk has no smoothness to choose",
             "remove one of them"}};
  return {};
}

/// A path; the word `live` is the stream, and no file.
Schema<std::filesystem::path> table_or_stream() {
  const auto table = path();
  const auto read = [=](const CaseNode& node, std::filesystem::path& file) {
    if (node.yaml().kind != YamlNode::Kind::scalar || node.yaml().text != from_stream) return table.read(node, file);
    file = from_stream;
    return true;
  };
  return make_schema<std::filesystem::path>(
      read, [=](const std::filesystem::path& file) { return table.write(file); }, table.json_schema());
}

}  // namespace

SignalKinds signal_kinds() {
  const auto random =
      Fields<RandomSignal>()
          .required("rms", &RandomSignal::rms, value(), "root mean square")
          .required("band", &RandomSignal::band, tuple<2>(hertz()), "from, to")
          .optional("duration", &RandomSignal::duration, seconds(), "period; default: the duration of the simulation")
          .optional("fade_in", &RandomSignal::fade_in, seconds(), "smooth start from rest")
          .optional("seed", &RandomSignal::seed, seed(), "seed of the random phases");
  const auto sine = Fields<Sine>()
                        .required("amplitude", &Sine::amplitude, value(), "amplitude")
                        .required("frequency", &Sine::frequency, hertz(), "frequency")
                        .optional("phase", &Sine::phase, number("rad"), "phase at time 0")
                        .optional("fade_in", &Sine::fade_in, seconds(), "smooth start from rest");
  const auto sweep =
      Fields<SweptSine>()
          .required("amplitude", &SweptSine::amplitude, value(), "amplitude")
          .required("from", &SweptSine::from, hertz(), "first frequency")
          .required("to", &SweptSine::to, hertz(), "last frequency")
          .optional("duration", &SweptSine::duration, seconds(),
                    "duration of the sweep; default: that of the simulation")
          .optional("kind", &SweptSine::kind,
                    choice<Sweep>({{"linear", Sweep::linear, ""}, {"logarithmic", Sweep::logarithmic, ""}}),
                    "how the frequency changes with time")
          .optional("fade_in", &SweptSine::fade_in, seconds(), "smooth start from rest");
  const auto impulse =
      Fields<Impulse>()
          .required("amplitude", &Impulse::amplitude, value(), "peak")
          .optional("start", &Impulse::start, number("s", plausible::clock()), "start of the pulse")
          .optional("duration", &Impulse::duration, number("s", plausible::duration()), "duration of the pulse")
          .optional("shape", &Impulse::shape,
                    choice<PulseShape>({{"half_sine", PulseShape::half_sine, "for forces"},
                                        {"smooth", PulseShape::smooth, "for base displacements"}}),
                    "shape of the pulse");
  const auto constant = convert<Constant>(
      value(), [](const Value& given) { return Constant{given}; }, [](const Constant& c) { return c.value; });
  return {when("random", mapping(random), "random signal with a flat spectrum in a band"),
          when("sine", mapping(sine), "one frequency"), when("sweep", mapping(sweep), "swept sine"),
          when("impulse", mapping(impulse), "one pulse"),
          when("constant", constant, "constant value (gravity, a preload)")};
}

namespace {

/// The values of an acceleration, with g as gravity.
void take_gravity_of_signal(const CaseNode& node, Excitation& given) {
  if (auto* signal = std::get_if<RandomSignal>(&*given.signal)) take_gravity(node, {"random", "rms"}, signal->rms);
  if (auto* signal = std::get_if<Sine>(&*given.signal)) take_gravity(node, {"sine", "amplitude"}, signal->amplitude);
  if (auto* signal = std::get_if<SweptSine>(&*given.signal))
    take_gravity(node, {"sweep", "amplitude"}, signal->amplitude);
  if (auto* signal = std::get_if<Impulse>(&*given.signal))
    take_gravity(node, {"impulse", "amplitude"}, signal->amplitude);
  if (auto* signal = std::get_if<Constant>(&*given.signal)) take_gravity(node, {"constant"}, signal->value);
}

Schema<Excitation> excitation_of_any_quantity() {
  const auto road_class = convert<char>(
      word({"A", "B", "C", "D", "E", "F", "G", "H"}), [](const std::string& word) { return word.front(); },
      [](const char& letter) { return std::string(1, letter); });
  const auto road =
      Fields<Road>()
          .required("class", &Road::road_class, road_class,
                    "road class of ISO 8608, from A (very good) to H (very poor)")
          .required("speed", &Road::speed, number("m/s", Bounds::positive()), "speed of the vehicle")
          .optional("band", &Road::band, tuple<2>(number("1/m", Bounds::positive())), "spatial frequencies")
          .optional("duration", &Road::duration, seconds(), "period; default: the duration of the simulation")
          .optional("fade_in", &Road::fade_in, seconds(), "smooth start from a level road")
          .optional("seed", &Road::seed, seed(), "seed of the random phases");
  const auto alignment = Fields<Alignment>()
                             .required("channel", &Alignment::channel, name(),
                                       "column of this file that measured the same as a sensor of the record")
                             .required("sensor", &Alignment::sensor, name(), "that sensor");
  const auto file =
      Fields<FileSignal>()
          .required("file", &FileSignal::file, table_or_stream(),
                    "table with a column of samples; `live`, or any, where they come with the stream of `live`")
          .required("channel", &FileSignal::channel, name(), "title of the column, with or without the unit")
          .optional("sample_rate", &FileSignal::sample_rate, number("Hz", plausible::frequency()),
                    "sampling rate, if the file has no time column")
          .optional("unit", &FileSignal::unit, located(text()),
                    "unit of the column; default: the unit in its title (\"F [kN]\"), otherwise SI")
          .optional("delay", &FileSignal::delay, number("s", plausible::clock()), "the column is late by this")
          .optional("clock_drift", &FileSignal::clock_drift, number("-", plausible::drift()),
                    "by so much the clock of this file runs fast, as 50 ppm: a time t after its first sample the "
                    "column is late by delay + clock_drift t")
          .optional("align", &FileSignal::align, mapping(alignment),
                    "find the delay of this file's clock behind that of the record")
          .optional("bridge_gaps", &FileSignal::bridge_gaps, seconds(),
                    "gaps up to this length, between two samples, are filled by a spline; default: none may be missing")
          .optional("prepare", &FileSignal::prepare, channel_preparation(),
                    "what is done to the column, in this order");
  const auto delayed = Fields<Delayed>()
                           .required("input", &Delayed::input, name(), "the input that comes first")
                           .required("delay", &Delayed::delay, seconds(), "delay");
  const auto trailing =
      Fields<Trailing>()
          .required("input", &Trailing::input, name(), "input of the axle in front")
          .required("wheelbase", &Trailing::wheelbase, number("m", plausible::length()), "distance between the axles")
          .required("speed", &Trailing::speed, number("m/s", Bounds::positive()), "speed of the vehicle");
  const SignalKinds kinds = signal_kinds();
  const auto unknown =
      Fields<UnknownInput>()
          .optional("std", &UnknownInput::std, value(),
                    "standard deviation of the excitation, in its unit; of a random walk at its start")
          .optional("correlation_time", &UnknownInput::correlation_time, number("s", plausible::duration()),
                    "time over which the excitation remembers its value")
          .optional("smoothness", &UnknownInput::order,
                    choice<int>({{"1/2", 1, "first-order Gauss-Markov process"},
                                 {"3/2", 2, "with a rate"},
                                 {"5/2", 3, "with a rate and an acceleration"}}),
                    "of the Matern covariance; default: 3/2, or 5/2 of a base_displacement")
          .optional("random_walk", &UnknownInput::random_walk, value(),
                    "instead: a random walk with this standard deviation per square root of a second")
          .check(check_process);
  return mapping(
      Fields<Excitation>()
          .one_of(&Excitation::target, target("base_displacement", &BaseDisplacement::ground, "move a ground [m]"),
                  target("base_velocity", &BaseVelocity::ground,
                         "move a ground by its velocity [m/s], as geophones measure it: the displacement is the "
                         "integral, without the straight line that fits it best"),
                  base_acceleration(), target("force", &Force::point, "force at a point [N]"))
          .one_of(&Excitation::signal, kinds.random, kinds.sine, kinds.sweep, kinds.impulse,
                  when("road", mapping(road), "ISO 8608 road profile"), when(file),
                  when("delayed", mapping(delayed), "another input, delayed"),
                  when("trailing_axle", mapping(trailing), "another input, delayed by wheelbase / speed"),
                  kinds.constant)
          .optional("unknown", &Excitation::unknown, located(mapping(unknown)),
                    "the filter does not know this excitation: it estimates it as a random process. A signal beside it "
                    "drives `simulate` and is compared with the estimate")
          .check(check_signal)
          .optional("scale", &Excitation::scale, number("-"), "factor on the signal")
          .optional("drift", &Excitation::drift,
                    located(choice<Drift>(
                        {{"remove", Drift::remove, "subtract the parabola in time that fits the displacement best"},
                         {"keep", Drift::keep, "integrate the acceleration as it is, from rest"}})),
                    "what to do with the drift of an integrated ground acceleration; default: remove, but keep for "
                    "impulse and constant"));
}

}  // namespace

Schema<Excitation> excitation() {
  const auto any = excitation_of_any_quantity();
  const auto read = [any](const CaseNode& node, Excitation& excitation) {
    if (!any.read(node, excitation)) return false;
    if (std::holds_alternative<BaseAcceleration>(excitation.target)) {
      if (excitation.signal) take_gravity_of_signal(node, excitation);
      if (excitation.unknown && excitation.unknown->value.std)
        take_gravity(node, {"unknown", "std"}, *excitation.unknown->value.std);
    }
    return true;
  };
  return make_schema<Excitation>(
      read, [any](const Excitation& excitation) { return any.write(excitation); }, any.json_schema());
}

}  // namespace kalfem::description
