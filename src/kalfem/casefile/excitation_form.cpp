#include "kalfem/casefile/description_form.hpp"
#include "kalfem/casefile/plausible.hpp"
#include "kalfem/yaml/fields.hpp"

namespace kalfem::description {

using namespace form;

namespace {

Form<double> seconds() { return number("s", plausible::time()); }
Form<double> hertz() { return number("Hz", Bounds::between(0, plausible::frequency().high)); }

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
  return when(
      "base_acceleration",
      convert<BaseAcceleration>(
          points("ground"), [](const Points& given) { return BaseAcceleration{given}; },
          [](const BaseAcceleration& target) { return target.direction; }),
      "accelerate grounds [m/s^2]. By name (or several, each with a weight): displacements stay absolute. `all`: "
      "every ground and degree of freedom alike, or degrees of freedom with a weight each; displacements are "
      "then relative to the moving base");
}

}  // namespace

Form<Excitation> excitation() {
  const auto random = Fields<RandomSignal>()
                          .required("rms", &RandomSignal::rms, value(), "root mean square")
                          .required("band", &RandomSignal::band, tuple<2>(hertz()), "from, to")
                          .optional("duration", &RandomSignal::duration, seconds(), "period; default: the simulation's")
                          .optional("fade_in", &RandomSignal::fade_in, seconds(), "smooth start from rest")
                          .optional("seed", &RandomSignal::seed, seed(), "of the phases");
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
          .optional("duration", &SweptSine::duration, seconds(), "of the sweep; default: the simulation's")
          .optional("kind", &SweptSine::kind,
                    choice<Sweep>({{"linear", Sweep::linear, ""}, {"logarithmic", Sweep::logarithmic, ""}}),
                    "how the frequency runs")
          .optional("fade_in", &SweptSine::fade_in, seconds(), "smooth start from rest");
  const auto impulse =
      Fields<Impulse>()
          .required("amplitude", &Impulse::amplitude, value(), "peak")
          .optional("start", &Impulse::start, number("s", plausible::clock()), "begin of the pulse")
          .optional("duration", &Impulse::duration, number("s", plausible::duration()), "length of the pulse")
          .optional("shape", &Impulse::shape,
                    choice<PulseShape>({{"half_sine", PulseShape::half_sine, "for forces"},
                                        {"smooth", PulseShape::smooth, "for base displacements"}}),
                    "of the pulse");
  const auto road_class = convert<char>(
      word({"A", "B", "C", "D", "E", "F", "G", "H"}), [](const std::string& word) { return word.front(); },
      [](const char& letter) { return std::string(1, letter); });
  const auto road =
      Fields<Road>()
          .required("class", &Road::road_class, road_class, "of ISO 8608, A very good to H very poor")
          .required("speed", &Road::speed, number("m/s", Bounds::positive()), "of the vehicle")
          .optional("band", &Road::band, tuple<2>(number("1/m", Bounds::positive())), "spatial frequencies")
          .optional("duration", &Road::duration, seconds(), "period; default: the simulation's")
          .optional("fade_in", &Road::fade_in, seconds(), "smooth start from the level")
          .optional("seed", &Road::seed, seed(), "of the phases");
  const auto file = Fields<FileSignal>()
                        .required("file", &FileSignal::file, path(), "table with a column of samples")
                        .required("channel", &FileSignal::channel, name(), "column, with or without its unit")
                        .optional("sample_rate", &FileSignal::sample_rate, number("Hz", plausible::frequency()),
                                  "where the file has no time column")
                        .optional("unit", &FileSignal::unit, located(text()),
                                  "of the column; default: that of its title (\"F [kN]\"), else SI");
  const auto delayed = Fields<Delayed>()
                           .required("input", &Delayed::input, name(), "the input that comes first")
                           .required("delay", &Delayed::delay, seconds(), "how much later");
  const auto trailing =
      Fields<Trailing>()
          .required("input", &Trailing::input, name(), "input of the axle ahead")
          .required("wheelbase", &Trailing::wheelbase, number("m", plausible::length()), "distance of the axles")
          .required("speed", &Trailing::speed, number("m/s", Bounds::positive()), "of the vehicle");
  const auto constant = convert<Constant>(
      value(), [](const Value& given) { return Constant{given}; }, [](const Constant& c) { return c.value; });
  return mapping(
      Fields<Excitation>()
          .one_of(&Excitation::target, target("base_displacement", &BaseDisplacement::ground, "move a ground [m]"),
                  base_acceleration(), target("force", &Force::point, "force at a point [N]"))
          .one_of(&Excitation::signal, when("random", mapping(random), "flat spectrum in a band"),
                  when("sine", mapping(sine), "one frequency"), when("sweep", mapping(sweep), "swept sine"),
                  when("impulse", mapping(impulse), "one pulse"), when("road", mapping(road), "ISO 8608 road profile"),
                  when(file), when("delayed", mapping(delayed), "another input, later"),
                  when("trailing_axle", mapping(trailing), "another input, later by wheelbase / speed"),
                  when("constant", constant, "the same at all times (gravity, a preload)"))
          .optional("scale", &Excitation::scale, number("-"), "factor on the signal")
          .optional("drift", &Excitation::drift,
                    located(choice<Drift>(
                        {{"remove", Drift::remove, "take out the parabola over time that fits the displacement best"},
                         {"keep", Drift::keep, "integrate from rest as the acceleration is"}})),
                    "of the displacement that an accelerated ground has by integration; default: remove, but keep for "
                    "impulse and constant"));
}

}  // namespace kalfem::description
