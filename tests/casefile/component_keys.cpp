// SPDX-License-Identifier: Apache-2.0
#include "casefile/probes.hpp"
#include "kalfem/records/channel_preparation.hpp"
#include "kalfem/system/signals/deterministic.hpp"
#include "kalfem/system/signals/random_signal.hpp"
#include "kalfem/system/signals/sampled.hpp"

/// Keys of a component, and of the signals of laws.
namespace kalfem::wiring {
namespace {

const std::string law = "law: expression, force: k*x + b*w, parameters: {k: 2 kN/m, b: 3}";
const std::string moved = "sine: {amplitude: 1 mm, frequency: 2 Hz}";

/// A component whose law reads a signal w, with `text` as that key.
struct ComponentText {
  std::string motion = moved, base_motion = moved, signal = "constant: 2", more = "";

  [[nodiscard]] Study study(const std::string& law_keys = law) const {
    return study_of({{"kalfem", "1"},
                     {"component", "{" + law_keys + ", signals: {w: {" + signal + "}}, motion: {" + motion +
                                       "}, base_motion: {" + base_motion + "}" + more + "}"},
                     {"sensors", "{F: {force: component, noise: 1 N}}"},
                     {"simulate", "{duration: 0.5 s, sample_rate: 100 Hz}"}});
  }
};

/// The input that a key with signals is of: the study and the input's number.
struct Fed {
  std::string prefix;
  std::function<Study(const std::string&)> study;
  std::size_t input;
};

std::vector<Fed> fed() {
  return {
      {"component.motion.", [](const std::string& text) { return ComponentText{.motion = text}.study(); }, 0},
      {"component.base_motion.", [](const std::string& text) { return ComponentText{.base_motion = text}.study(); }, 1},
      {"component.signals.*.", [](const std::string& text) { return ComponentText{.signal = text}.study(); }, 2},
      {"connectors.*.signals.*.",
       [](const std::string& text) {
         return study_of(
             lumped_case({{"connectors", "{c: {from: s.a, to: s.b, " + law + ", signals: {w: {" + text + "}}}}"}}));
       },
       1}};
}

/// Each key of `prepare`, at a column whose keys stand between the two texts, against the preparation itself.
/// `derivative`: of the input that the column gives.
void add_preparation_keys(const Fed& of, const std::string& prefix, const std::string& before, const std::string& after,
                          Eigen::Index derivative, KeyChecks& checks) {
  const auto check = [=](const std::string& text, const ChannelPreparation& asked) {
    std::vector<double> column(400);
    for (std::size_t k = 0; k < column.size(); ++k)
      column[k] = 1.0 + 0.01 * double(k) + std::sin(0.2 * double(k)) + std::sin(1.1 * double(k));
    write_file("w.csv", csv_of(100.0, {{"p", column}, {"s", std::vector<double>(column.size(), 1.0)}}));
    PreparedRecord expected{{.sample_rate = 100.0,
                             .channels = {{"p", "-"}},
                             .values = Eigen::RowVectorXd::Map(column.data(), std::ssize(column))}};
    prepare_channels(expected, asked);
    const auto signal = make_sampled(expected.record.values.row(0).transpose(),
                                     {.sample_rate = expected.record.sample_rate, .start = expected.record.start});
    const Study study = of.study(before + "file: w.csv, channel: p, prepare: {" + text + "}" + after);
    near(study.structure->signals.at(of.input)->sample(1.7, 1.0, 1)(0, derivative), signal->sample(1.7, 1.0, 1)(0, 0));
  };
  const auto add = [&](const std::string& key, const std::string& text, const ChannelPreparation& asked) {
    checks[of.prefix + prefix + "prepare." + key] = [=] { check(text, asked); };
  };
  for (const std::string end : {"from", "to"})
    add("remove_offset." + end, "remove_offset: {from: 1 s, to: 2 s}", {.offset = RecordPart{.from = 1.0, .to = 2.0}});
  add("remove_trend", "remove_trend: true", {.trend = true});
  add("high_pass", "high_pass: 5 Hz", {.high_pass = 5.0});
  add("low_pass", "low_pass: 10 Hz", {.low_pass = 10.0});
  add("sample_rate", "sample_rate: 50 Hz", {.sample_rate = 50.0});
}

void add_signal_keys(const Fed& of, KeyChecks& checks) {
  const auto same = [of](const std::string& text, const SignalPtr& expected) {
    same_signal(*of.study(text).structure->signals.at(of.input), *expected, 0.01, 40);
  };
  const auto add = [&](const std::vector<std::string>& keys, const std::function<void()>& check) {
    for (const auto& key : keys) checks[of.prefix + key] = check;
  };
  const bool length = of.prefix.find("motion") != std::string::npos;
  add({"random.rms", "random.band", "random.duration", "random.fade_in", "random.seed"}, [=] {
    const Study study = of.study("random: {rms: 2, band: [3, 17], duration: 1.5, fade_in: 0.2, seed: 9}");
    same_signal(*study.structure->signals.at(of.input),
                *make_random({.rms = 2,
                              .lower = 3,
                              .upper = 17,
                              .duration = 1.5,
                              .fade_in = 0.2,
                              .seed = 9,
                              .name = study.structure->parts.inputs.at(of.input).name}));
  });
  add({"sine.amplitude", "sine.frequency", "sine.phase", "sine.fade_in"}, [=] {
    same("sine: {amplitude: 3, frequency: 7 Hz, phase: 30 deg, fade_in: 0.2 s}",
         make_sine({.amplitude = 3, .frequency = 7, .phase = 3.14159265358979323846 / 6, .fade_in = 0.2}));
  });
  add({"sweep.amplitude", "sweep.from", "sweep.to", "sweep.duration", "sweep.kind", "sweep.fade_in"}, [=] {
    same("sweep: {amplitude: 3, from: 2, to: 20, duration: 0.4, kind: logarithmic, fade_in: 0.1}",
         make_swept_sine(
             {.amplitude = 3, .from = 2, .to = 20, .duration = 0.4, .sweep = Sweep::logarithmic, .fade_in = 0.1}));
  });
  add({"constant"}, [=] { same(length ? "constant: 4 mm" : "constant: 4 mV", make_constant(4e-3)); });
  add({"scale"}, [=] { same("constant: 4, scale: 0.5", make_constant(2.0)); });
  add({"channel", "file", "sample_rate", "unit"}, [=] {
    write_file("w.csv", "p\n0\n1\n4\n2\n-1\n0.5\n3\n1\n");
    Eigen::VectorXd values(8);
    values << 0, 1, 4, 2, -1, 0.5, 3, 1;
    same(std::string("file: w.csv, channel: p, sample_rate: 10 Hz, unit: ") + (length ? "mm" : "mV"),
         make_sampled(1e-3 * values, {.sample_rate = 10.0}));
  });
  add_preparation_keys(of, "", "", "", 0, checks);
  add({"bridge_gaps"}, [=] {
    write_file("w.csv", "p\n0\n1\nnan\n3\n4\n5\n6\n");
    const Study study = of.study("file: w.csv, channel: p, sample_rate: 10 Hz, bridge_gaps: 0.2 s");
    near(signal_at(study, 0.2, of.input)[0], 2.0);
  });
  if (!length) return;
  add({"velocity.bridge_gaps"}, [=] {
    write_file("w.csv", "p,q\n0,0\n1,1\n2,nan\n3,3\n4,4\n5,5\n6,6\n");
    const Study study = of.study(
        "file: w.csv, channel: p, sample_rate: 10 Hz, velocity: {file: w.csv, channel: q, sample_rate: 10 Hz, "
        "bridge_gaps: 0.2 s}");
    near(signal_at(study, 0.2, of.input)[1], 2.0);
  });
  add_preparation_keys(of, "velocity.", "file: w.csv, channel: s, velocity: {", "}", 1, checks);
  add({"velocity.channel", "velocity.file", "velocity.sample_rate", "velocity.unit"}, [=] {
    write_file("d.csv", "p,q\n0,1\n1,3\n4,2\n2,5\n");
    const Eigen::Vector3d at =
        signal_at(of.study("file: d.csv, channel: p, sample_rate: 5 Hz, unit: mm, velocity: {file: "
                           "d.csv, channel: q, sample_rate: 5 Hz, unit: cm/s}"),
                  0.2, of.input);
    near(at[0], 1e-3);
    near(at[1], 0.03);
    Eigen::VectorXd rates(4);
    rates << 0.01, 0.03, 0.02, 0.05;
    near(at[2], make_sampled(rates, {.sample_rate = 5.0})->sample(0.2, 1.0, 1)(0, 1));
  });
}

/// Force of the component at an instant, with x = 2, v = 3 and the signal w = 5.
double force_of(const std::string& law_keys) {
  const Study study = ComponentText{}.study(law_keys);
  const auto& connector = system_of(study).connectors.at(0);
  const auto states = static_cast<Eigen::Index>(connector.law->states().size());
  const Eigen::ArrayXXd parameters = connector.parameters.transpose().array();
  const Eigen::ArrayXXd begin = Eigen::ArrayXXd::Constant(1, states, 7.0), w = Eigen::ArrayXXd::Constant(1, 1, 5.0);
  const Eigen::ArrayXd d = Eigen::ArrayXd::Constant(1, 2.0), v = Eigen::ArrayXd::Constant(1, 3.0),
                       a = Eigen::ArrayXd::Zero(1);
  Eigen::ArrayXd force(1), stiffness(1), damping(1), inertance(1);
  Eigen::ArrayXXd end(1, states);
  const LawSignals signal(w.data(), 1, 1, Eigen::OuterStride<>(1));
  connector.law->respond({0.0, parameters, d, v, begin, d, v, a, signal, signal},
                         {force, stiffness, damping, inertance, end});
  return force[0];
}

}  // namespace

KeyChecks component_keys() {
  KeyChecks checks;
  for (const auto& each : fed()) add_signal_keys(each, checks);
  const auto add = [&](const std::vector<std::string>& keys, const std::function<void()>& check) {
    for (const auto& key : keys) checks["component." + key] = check;
  };
  add({"law", "force", "parameters"}, [] { near(force_of(law), 2e3 * 2.0 + 3.0 * 5.0); });
  add({"let"}, [] { near(force_of("law: expression, force: q + w, let: {p: 2*x, q: p*v}"), 12.0 + 5.0); });
  add({"states.*.rate", "states.*.unit"}, [] {
    const std::string with_state = "law: expression, force: z + w, states: {z: {rate: v, unit: m}}";
    near(force_of(with_state), 7.0 + 5.0);
    EXPECT_EQ(system_of(ComponentText{}.study(with_state)).connectors.at(0).law->states().at(0).unit, "m");
  });
  checks["connectors.*.let"] = [] {
    const auto study = study_of(lumped_case(
        {{"connectors", "{c: {from: s.a, to: s.b, law: expression, force: q*k, let: {q: 2*x}, parameters: {k: 3}}}"}}));
    EXPECT_EQ(system_of(study).connectors.at(0).law->name(), "expression");
  };
  return checks;
}

}  // namespace kalfem::wiring
