// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <numbers>

#include "casefile/probes.hpp"
#include "kalfem/system/signals/deterministic.hpp"
#include "kalfem/system/signals/ground_motion.hpp"
#include "kalfem/system/signals/random_signal.hpp"
#include "kalfem/system/signals/sampled.hpp"

/// Keys of the excitation: every signal is that of the library with the same options, none of which is a default.
namespace kalfem::wiring {
namespace {

const std::string at = "excitation.*.";

Study with_signal(const std::string& text) {
  return study_of(lumped_case({{"excitation", "{e: {force: s.b, " + text + "}}"}}));
}

/// The same check for each of these keys.
KeyChecks all_of(const std::string& prefix, const std::vector<std::string>& keys, const std::function<void()>& check) {
  KeyChecks checks;
  for (const auto& key : keys) checks[prefix + key] = check;
  return checks;
}

void random_signals() {
  same_signal(
      *with_signal("random: {rms: 2 kN, band: [3, 17], duration: 1.5, fade_in: 0.2, seed: 9}").structure->signals[0],
      *make_random({.rms = 2e3, .lower = 3, .upper = 17, .duration = 1.5, .fade_in = 0.2, .seed = 9, .name = "e"}));
  // Without them: the simulation's duration as period, half a second, the first seed.
  same_signal(
      *with_signal("random: {rms: 2, band: [3, 17]}").structure->signals[0],
      *make_random({.rms = 2, .lower = 3, .upper = 17, .duration = 0.5, .fade_in = 0.5, .seed = 1, .name = "e"}));
}

void sines() {
  same_signal(
      *with_signal("sine: {amplitude: 3 kN, frequency: 7 Hz, phase: 30 deg, fade_in: 0.2 s}").structure->signals[0],
      *make_sine({.amplitude = 3e3, .frequency = 7, .phase = 3.14159265358979323846 / 6, .fade_in = 0.2}));
  same_signal(*with_signal("sine: {amplitude: 3, frequency: 7}").structure->signals[0],
              *make_sine({.amplitude = 3, .frequency = 7, .phase = 0, .fade_in = 0}));
}

void sweeps() {
  same_signal(*with_signal("sweep: {amplitude: 3, from: 2, to: 20, duration: 0.4, kind: logarithmic, fade_in: 0.1}")
                   .structure->signals[0],
              *make_swept_sine(
                  {.amplitude = 3, .from = 2, .to = 20, .duration = 0.4, .sweep = Sweep::logarithmic, .fade_in = 0.1}));
  same_signal(*with_signal("sweep: {amplitude: 3, from: 2, to: 20}").structure->signals[0],
              *make_swept_sine({.amplitude = 3, .from = 2, .to = 20, .duration = 0.5, .sweep = Sweep::linear}));
}

void impulses() {
  same_signal(*with_signal("impulse: {amplitude: 4, start: 0.1, duration: 0.3, shape: smooth}").structure->signals[0],
              *make_pulse({.amplitude = 4, .start = 0.1, .duration = 0.3, .shape = PulseShape::smooth}));
  same_signal(*with_signal("impulse: {amplitude: 4}").structure->signals[0],
              *make_pulse({.amplitude = 4, .start = 0.0, .duration = 0.01, .shape = PulseShape::half_sine}), 1e-3);
}

void roads() {
  const auto road = [](const std::string& text) {
    return study_of(lumped_case({{"excitation", "{e: {base_displacement: s.ground, road: " + text + "}}"}}));
  };
  same_signal(
      *road("{class: E, speed: 36 km/h, band: [0.1, 2], duration: 3, fade_in: 0.1, seed: 5}").structure->signals[0],
      *make_road_profile({.road_class = 'E',
                          .speed = 10,
                          .lower = 0.1,
                          .upper = 2,
                          .duration = 3,
                          .fade_in = 0.1,
                          .seed = 5,
                          .name = "e"}));
  same_signal(*road("{class: A, speed: 30}").structure->signals[0], *make_road_profile({.road_class = 'A',
                                                                                        .speed = 30,
                                                                                        .lower = 0.011,
                                                                                        .upper = 2.83,
                                                                                        .duration = 0.5,
                                                                                        .fade_in = 0.5,
                                                                                        .seed = 1,
                                                                                        .name = "e"}));
}

/// A measured input on a clock of its own, without its mean, or behind a filter.
void prepared_signals() {
  std::vector<double> force(400), shifted(400);
  const auto motion = [](double t) { return 2.0 + std::sin(9.0 * t) + std::sin(23.0 * t + 1.0) * std::cos(1.3 * t); };
  for (int k = 0; k < 400; ++k)
    force[std::size_t(k)] = motion(k / 40.0), shifted[std::size_t(k)] = motion(k / 40.0 - 0.3);
  write_file("force.csv", csv_of(40.0, {{"p", force}}));
  const Eigen::VectorXd values = Eigen::VectorXd::Map(force.data(), std::ssize(force));
  same_signal(*with_signal("file: force.csv, channel: p, delay: 0.5 s").structure->signals[0],
              *make_sampled(values, {.sample_rate = 40.0, .start = -0.5}));
  same_signal(*with_signal("file: force.csv, channel: p, clock_drift: 300 ppm").structure->signals[0],
              *make_sampled(values, {.sample_rate = 40.0 * (1.0 + 300e-6)}));
  const auto prepared = [](const std::string& text) {
    return signal_at(with_signal("file: force.csv, channel: p, prepare: {" + text + "}"), 5.0)[0];
  };
  near(prepared("remove_offset: {}"), force[200] - values.mean());
  near(prepared("remove_offset: {from: 2 s, to: 3 s}"), force[200] - values.segment(80, 41).mean());
  near(prepared("remove_trend: true"), force[200] - values.mean(), 0.05);
  near(prepared("high_pass: 0.4 Hz"), force[200] - 2.0, 0.05);
  near(prepared("low_pass: 0.1 Hz"), 2.0, 0.06);  // what is left of 0.2 Hz
  near(prepared("sample_rate: 20 Hz"), force[200], 1e-3);
  // The file's clock is 0.3 s late, as its column q tells that measured what the sensor did.
  write_file("record.csv", csv_of(40.0, {{"y", force}}));
  write_file("force.csv", csv_of(40.0, {{"p", shifted}, {"q", shifted}}));
  const auto aligned = [](const std::string& text) {
    return study_of(lumped_case({{"simulate", ""},
                                 {"record", "{file: record.csv, end: 9 s}"},
                                 {"sensors", "{y: {displacement: s.b, noise: 1}}"},
                                 {"excitation", "{e: {force: s.a, file: force.csv, channel: p" + text + "}}"},
                                 {"estimate", "{unknown: {c.k: {initial: 400, std: 80}}}"}}));
  };
  const auto study = aligned(", align: {channel: q, sensor: y}");
  near(signal_at(study, 5.0)[0], force[200], 1e-3);
  EXPECT_NE(study.record->preparation.at(0).find("0.3"), std::string::npos) << study.record->preparation[0];
  EXPECT_THROW(aligned(", align: {channel: q, sensor: z}"), InvalidInput);
  EXPECT_THROW(aligned(", align: {channel: z, sensor: y}"), InvalidInput);
}

/// Lost samples between others lie on a spline; a longer gap, or one at an end, is refused.
void bridged_gaps() {
  const auto with_gap = [](int from, int to, const std::string& longest) {
    std::vector<double> force(80);
    for (int k = 0; k < 80; ++k) force[std::size_t(k)] = k >= from && k < to ? std::nan("") : std::sin(0.2 * k);
    write_file("lost.csv", csv_of(40.0, {{"p", force}}));
    return with_signal("file: lost.csv, channel: p, bridge_gaps: " + longest);
  };
  const auto study = with_gap(30, 32, "75 ms");
  near(signal_at(study, 30.0 / 40.0)[0], std::sin(6.0), 1e-3);
  near(signal_at(study, 31.0 / 40.0)[0], std::sin(6.2), 1e-3);
  EXPECT_THROW(with_gap(30, 33, "75 ms"), InvalidInput);
  EXPECT_THROW(with_gap(0, 1, "75 ms"), InvalidInput);
  EXPECT_THROW(with_gap(30, 31, "0 s"), InvalidInput);
}

const std::vector<double> samples{0.0, 1.0, 4.0, 2.0, -1.0, 0.5, 3.0, 1.0};

/// A column of a table with a time axis of its own, and of one without.
void recorded_signals() {
  write_file("force.csv", csv_of(10.0, {{"p", samples}, {"q", std::vector<double>(8, 7.0)}}));
  Eigen::VectorXd values = Eigen::VectorXd::Map(samples.data(), 8);
  same_signal(*with_signal("file: force.csv, channel: p").structure->signals[0],
              *make_sampled(values, {.sample_rate = 10.0}));
  near(signal_at(with_signal("file: force.csv, channel: q"), 0.3)[0], 7.0);
  same_signal(*with_signal("file: force.csv, channel: p, unit: kN").structure->signals[0],
              *make_sampled(1e3 * values, {.sample_rate = 10.0}));
  write_file("bare.csv", "p\n0\n1\n4\n2\n-1\n0.5\n3\n1\n");
  same_signal(*with_signal("file: bare.csv, channel: p, sample_rate: 5 Hz").structure->signals[0],
              *make_sampled(values, {.sample_rate = 5.0}));
  write_file("late.csv", csv_of(10.0, {{"p", samples}}, -0.2));
  same_signal(*with_signal("file: late.csv, channel: p").structure->signals[0],
              *make_sampled(values, {.sample_rate = 10.0, .start = -0.2}), 0.01, 40);
}

/// A ground of an acceleration moves as that says from rest, or without the parabola that fits best.
void drifts() {
  const auto moved = [](const std::string& text) {
    return study_of(lumped_case({{"excitation", "{e: {base_acceleration: s.ground, " + text + "}}"}}));
  };
  write_file("shaken.csv", csv_of(10.0, {{"p", samples}}));
  const auto acceleration = make_sampled(Eigen::VectorXd::Map(samples.data(), 8), {.sample_rate = 10.0});
  const auto expected = [&](Drift drift) {
    return GroundMotion(acceleration, {.start = 0.0, .step = 0.1, .knots = 8, .drift = drift});
  };
  const std::string file = "file: shaken.csv, channel: p";
  same_signal(*moved(file + ", drift: keep").structure->signals[0], expected(Drift::keep));
  same_signal(*moved(file + ", drift: remove").structure->signals[0], expected(Drift::remove));
  same_signal(*moved(file).structure->signals[0], expected(Drift::remove));
  // a = sin(w t) is r = (w t - sin(w t)) / w^2 from rest, and -sin(w t) / w^2 without its drift.
  const double w = 2 * 3.14159265358979323846 * 3.0, swing = std::sin(0.4 * w) / (w * w);
  const std::string sine = "sine: {amplitude: 1 m/s^2, frequency: 3}";
  near(signal_at(moved(sine + ", drift: keep"), 0.4)[0], 0.4 / w - swing,
       5e-9);  // the spline through the sine: found 6e-10
  near(signal_at(moved(sine + ", drift: remove"), 0.4)[0], -swing, many_roundings);
  near(signal_at(moved(sine), 0.4)[0], -swing, many_roundings);
  // A constant acceleration has no drift that could be taken out.
  near(signal_at(moved("constant: 3 m/s^2"), 0.4)[0], 3 * 0.4 * 0.4 / 2, many_roundings);
}

/// Inputs that follow the second of two others.
void delayed_signals() {
  const auto delay = [](const std::string& text, double seconds) {
    const auto study = study_of(
        lumped_case({{"excitation",
                      "{g: {force: s.a, sine: {amplitude: 5, frequency: 3}}, e: {force: s.a, sine: {amplitude: 2, "
                      "frequency: 4}}, late: {force: s.b, " +
                          text + "}}"}}));
    same_signal(*study.structure->signals[2], *delayed(make_sine({.amplitude = 2, .frequency = 4}), seconds));
  };
  delay("delayed: {input: e, delay: 30 ms}", 0.03);
  delay("trailing_axle: {input: e, wheelbase: 3 m, speed: 72 km/h}", 0.15);
}

/// A process in the place of the signal, in the filter's model.
void unknown_inputs() {
  const auto input = [](const std::string& target, const std::string& process) {
    const auto study = study_of(estimated_case(lumped_case(
        {{"excitation", "{e: {" + target + ", sine: {amplitude: 1, frequency: 3}, unknown: {" + process + "}}}"}})));
    return std::pair(study.problem->settings.unknown_inputs.at(0), study.augmented_model->options);
  };
  const auto [force, options] = input("force: s.b", "std: 2 kN, correlation_time: 30 ms, smoothness: 5/2");
  EXPECT_EQ(options.inputs.at(0).model, InputModel::latent);
  EXPECT_EQ(force.process.order, 3);
  near(force.process.correlation_time, 0.03);
  near(options.prior.input_deviation[0], 2e3);
  near(options.process_noise.input[0], LatentProcess{3, 0.03}.density(2e3));
  const auto [plain, unused] = input("force: s.b", "std: 2");
  EXPECT_EQ(plain.process.order, 2);
  near(plain.process.correlation_time, 0.1);
  EXPECT_EQ(input("base_displacement: s.ground", "std: 2 mm").first.process.order, 3);
  const auto [walk, of_walk] = input("force: s.b", "random_walk: 7 kN/sqrt(s), std: 3 N");
  EXPECT_EQ(walk.process.rate(), 0.0);
  near(of_walk.process_noise.input[0], 7e3);
  near(of_walk.prior.input_deviation[0], 3.0);
  const auto [ground, of_ground] = input("base_acceleration: s.ground", "std: 2 m/s^2");
  EXPECT_EQ(of_ground.inputs.at(0).model, InputModel::latent_acceleration);
  EXPECT_TRUE(ground.acceleration);
}

void targets() {
  const auto force = study_of(lumped_case({{"excitation", "{e: {force: s.b, constant: 2 kN}}"}}));
  near(system_of(force).inputs[0].value, vector({0.0, 1.0}));
  EXPECT_EQ(system_of(force).inputs[0].unit, "N");
  near(signal_at(force, 0.2), Eigen::Vector3d(2e3, 0, 0));
  const auto ground = study_of(lumped_case({{"excitation", "{e: {base_displacement: s.ground, constant: 2 mm}}"}}));
  near(system_of(ground).inputs[0].value, vector({800.0, 0.0}));
  near(system_of(ground).inputs[0].rate, vector({4.0, 0.0}));
  EXPECT_EQ(system_of(ground).inputs[0].unit, "m");
  near(signal_at(ground, 0.2)[0], 2e-3);
  // Of a swinging velocity V sin(w t) the displacement is -V / w cos(w t); the line that is taken out of ten seconds of
  // it is 7e-5 of that.
  const auto velocity = study_of(
      lumped_case({{"excitation", "{e: {base_velocity: s.ground, sine: {amplitude: 40 mm/s, frequency: 10}}}"}}));
  const double w = 2.0 * std::numbers::pi * 10.0;
  EXPECT_NEAR(signal_at(velocity, 0.225)[0], -0.04 / w * std::cos(w * 0.225), 1e-4 * 0.04 / w);
  EXPECT_NEAR(signal_at(velocity, 0.225)[1], 0.04 * std::sin(w * 0.225), 1e-4 * 0.04);
  // The whole ground accelerates: inertia forces -M 1, or with a weight for each degree of freedom.
  const auto all = study_of(lumped_case({{"excitation", "{e: {base_acceleration: all, constant: 0.5 m/s^2}}"}}));
  near(system_of(all).inputs[0].value, vector({-2.0, -3.0}));
  near(signal_at(all, 0.2)[0], 0.5);
  const auto some = study_of(lumped_case({{"excitation", "{e: {base_acceleration: {s.b: 0.5}, constant: 1}}"}}));
  near(system_of(some).inputs[0].value, vector({0.0, -1.5}));
  near(some.model->base_accelerations().col(0), vector({0.0, 0.5}));
}

}  // namespace

KeyChecks excitation_keys() {
  KeyChecks keys;
  keys.merge(all_of(at + "random.", {"rms", "band", "duration", "fade_in", "seed"}, random_signals));
  keys.merge(all_of(at + "sine.", {"amplitude", "frequency", "phase", "fade_in"}, sines));
  keys.merge(all_of(at + "sweep.", {"amplitude", "from", "to", "duration", "kind", "fade_in"}, sweeps));
  keys.merge(all_of(at + "impulse.", {"amplitude", "start", "duration", "shape"}, impulses));
  keys.merge(all_of(at + "road.", {"class", "speed", "band", "duration", "fade_in", "seed"}, roads));
  keys.merge(all_of(at, {"file", "channel", "sample_rate", "unit"}, recorded_signals));
  keys.merge(all_of(at,
                    {"delay", "clock_drift", "align.channel", "align.sensor", "prepare.remove_offset.from",
                     "prepare.remove_offset.to", "prepare.remove_trend", "prepare.high_pass", "prepare.low_pass",
                     "prepare.sample_rate"},
                    prepared_signals));
  keys[at + "bridge_gaps"] = bridged_gaps;
  keys.merge(all_of(
      at, {"delayed.input", "delayed.delay", "trailing_axle.input", "trailing_axle.wheelbase", "trailing_axle.speed"},
      delayed_signals));
  keys.merge(all_of(at, {"force", "base_displacement", "base_velocity", "base_acceleration", "constant"}, targets));
  keys.merge(all_of(at + "unknown.", {"std", "correlation_time", "smoothness", "random_walk"}, unknown_inputs));
  keys[at + "drift"] = drifts;
  keys[at + "scale"] = [] {
    same_signal(*with_signal("sine: {amplitude: 3, frequency: 7}, scale: -1.5").structure->signals[0],
                *make_sine({.amplitude = -4.5, .frequency = 7}));
  };
  return keys;
}

}  // namespace kalfem::wiring
