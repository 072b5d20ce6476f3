// SPDX-License-Identifier: Apache-2.0
#include "kalfem/casefile/component_schema.hpp"

#include "kalfem/casefile/case_schema.hpp"
#include "kalfem/casefile/plausible.hpp"

namespace kalfem::description {

using namespace schema;

namespace {

/// A column of the record, or of another file.
Fields<ChannelSignal> channel() {
  return Fields<ChannelSignal>()
      .required("channel", &ChannelSignal::channel, name(), "title of the column, with or without the unit")
      .optional("file", &ChannelSignal::file, path(), "its table; default: the file of the record")
      .optional("sample_rate", &ChannelSignal::sample_rate, number("Hz", plausible::frequency()),
                "sampling rate, if the file has no time column; default for the file of the record: that of the record")
      .optional("unit", &ChannelSignal::unit, located(text()),
                "unit of the column; default: the unit in its title, otherwise SI")
      .optional("bridge_gaps", &ChannelSignal::bridge_gaps, number("s", plausible::time()),
                "gaps up to this length, between two samples, are filled by a spline; default: none may be missing")
      .optional("prepare", &ChannelSignal::prepare, channel_preparation(), "what is done to the column, in this order");
}

/// The member `signal` of a T, by one of the kinds.
template <class T>
Fields<T> with_signal(Fields<T> fields) {
  const SignalKinds kinds = signal_kinds();
  fields.one_of(&T::signal, when(channel()), kinds.random, kinds.sine, kinds.sweep, kinds.constant);
  fields.optional("scale", &T::scale, number("-"), "factor on the signal");
  return fields;
}

/// `time`, or the name of an input.
Schema<LawSignal> named_signal() {
  return convert<LawSignal>(
      written_as("time", name()),
      [](const Name& given) -> LawSignal {
        if (given.value == "time") return {Clock{}};
        return {Delayed{given, 0.0}};
      },
      [](const LawSignal& signal) {
        const auto* input = std::get_if<Delayed>(&signal.signal);
        return input ? input->input : Name{"time", {}, {}};
      });
}

Schema<LawSignal> law_signal() {
  const auto full = mapping(with_signal(Fields<LawSignal>()));
  const auto either_way = either(named_signal(), full);
  const auto read = [=](const CaseNode& node, LawSignal& signal) { return either_way.read(node, signal); };
  const auto write = [=, by_name = named_signal()](const LawSignal& signal) {
    const bool named = std::holds_alternative<Clock>(signal.signal) || std::holds_alternative<Delayed>(signal.signal);
    return named ? by_name.write(signal) : full.write(signal);
  };
  return make_schema<LawSignal>(read, write, either_way.json_schema());
}

Schema<ImposedMotion> imposed_motion() {
  return mapping(with_signal(Fields<ImposedMotion>())
                     .optional("velocity", &ImposedMotion::velocity, mapping(channel()),
                               "the velocity was measured too: its column, in place of the derivative of the "
                               "displacement's spline"));
}

}  // namespace

Fields<Connector> law_keys() {
  const auto state =
      Fields<ExpressionState>()
          .required("rate", &ExpressionState::rate, text(), "time derivative as an expression; f stands for the force")
          .optional("unit", &ExpressionState::unit, text(), "unit of the state");
  return Fields<Connector>()
      .required("law", &Connector::law, name(), "name of the law; `kalfem schema --laws` lists them")
      .optional("parameters", &Connector::parameters, named(value()), "parameters of the law by name")
      .optional("force", &Connector::force, text(),
                "for law: expression: the force [N] as a function of x (deformation), v (rate), a (relative "
                "acceleration), states, signals and parameters")
      .optional("let", &Connector::let, named(text()),
                "for law: expression: named sub-expressions, each of what stands above it")
      .optional("states", &Connector::states, named(mapping(state)), "for law: expression: internal states")
      .optional("signals", &Connector::signals, named(located(law_signal())),
                "for law: expression: known functions of time that it reads, in SI: {channel: ..., unit: V}, a signal "
                "as of `excitation`, `time`, or the name of an input");
}

Schema<Component> component() {
  return mapping(Fields<Component>()
                     .inlined(&Component::connector, law_keys())
                     .required("motion", &Component::motion, located(imposed_motion()),
                               "imposed displacement of the component's end [m]")
                     .optional("base_motion", &Component::base_motion, located(imposed_motion()),
                               "imposed displacement of its other end [m]; default: it is fixed"));
}

}  // namespace kalfem::description
