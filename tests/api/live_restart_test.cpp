// SPDX-License-Identifier: Apache-2.0
// A filter that is carried over a restart goes on as if there had been none.
#include <fstream>
#include <random>

#include "base/scratch_folder.hpp"
#include "quarter_car.hpp"

namespace kalfem::quarter_car {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double duration = 24.0;
const OnlineOptions gated{.window = 500, .gates = GateOptions{.warm_up = 300, .most_events = 20}};

SignalPtr road_here() { return road_of(duration); }

/// A stream with a sensor that dies and comes back, spikes and a gap.
const Record& faulty_record() {
  static const Record record = [] {
    Record made = drive(duration, road_here());
    made.values.row(1).segment(4000, 2000).setZero();
    for (Index k = 1500; k < made.samples(); k += 900) made.values(0, k) += 20.0;
    made.values.row(0).segment(9000, 300).setConstant(std::nan(""));
    return made;
  }();
  return record;
}

LiveFilter live_filter() {
  return {structure(2e6).base_displacement("road", "wheel.ground"),
          rate,
          {.sensors = sensors, .unknowns = {{"strut.k3", {.std = 2e6}}, {"wheel.tyre.stiffness", {.std = 2e4}}}},
          {.horizon = 0.2, .filter = gated}};
}

/// Pushes block b of the stream: 10 samples of each channel, the road later than the others.
void push(LiveFilter& live, Index b) {
  static const VectorXd road = road_here()->sample(0.0, 1.0 / rate, faulty_record().samples()).col(0).matrix();
  constexpr Index length = 10, late = 3;
  for (Index i = 0; i < 2; ++i)
    live.push(sensors[std::size_t(i)].name, double(b * length) / rate,
              faulty_record().values.row(i).segment(b * length, length).transpose());
  if (b >= late) live.push("road", double((b - late) * length) / rate, road.segment((b - late) * length, length));
}

constexpr Index blocks = Index(duration * rate) / 10;

std::vector<double> bits_of(LiveFilter& live) {
  std::vector<double> bits{live.filter().time(),
                           live.filter().nis(),
                           double(live.samples()),
                           double(live.dropped()),
                           double(live.filter().condition()),
                           double(live.filter().verdict().state())};
  for (const auto& parameter : live.filter().parameters()) bits.insert(bits.end(), {parameter.mean, parameter.std});
  for (const char* name : {"wheel.w.displacement", "body.b.velocity"}) {
    const auto state = live.filter().state(name);
    bits.insert(bits.end(), {state.mean, state.std});
  }
  for (const auto& event : live.filter().events()) bits.push_back(event.time);
  return bits;
}

const std::vector<double>& unbroken() {
  static const std::vector<double> bits = [] {
    LiveFilter live = live_filter();
    for (Index b = 0; b < blocks; ++b) push(live, b);
    return bits_of(live);
  }();
  return bits;
}

TEST(LiveRestart, GivesTheSameBitsAsAnUnbrokenRun) {
  const ScratchFolder folder("live_restart");
  const auto file = folder / "state";
  std::mt19937 random(3);
  for (int repetition = 0; repetition < 4; ++repetition) {
    std::optional<LiveFilter> live(live_filter());
    for (Index b = 0; b < blocks; ++b) {
      if (random() % 250 == 0) {
        live->write_state(file);
        live.emplace(live_filter());
        live->read_state(file);
      }
      push(*live, b);
    }
    EXPECT_EQ(bits_of(*live), unbroken());
  }
  LiveFilter live = live_filter();
  for (Index b = 0; b < blocks; ++b) push(live, b);
  EXPECT_GE(live.filter().events().size(), 10U);  // there was something to carry over
}

/// Each kind of filter keeps its covariance in another form.
TEST(LiveRestart, CarriesEveryKindOfFilterOver) {
  const ScratchFolder folder("live_restart_kinds");
  for (const auto kind : {FilterKind::unscented, FilterKind::unscented_square_root, FilterKind::partially_linear,
                          FilterKind::partially_linear_square_root, FilterKind::extended}) {
    const auto make = [&] {
      return OnlineFilter(driven_chain(), chain_record().sample_rate,
                          {.sensors = chain_sensors(),
                           .unknowns = {{"suspension.mu_k1", {.initial = 10.0, .std = 5.0}}},
                           .filter = kind,
                           .substeps = 2});
    };
    const auto move = [](OnlineFilter& filter, Index from, Index to) {
      for (Index k = from; k < to; ++k) {
        if (k > 0) filter.predict();
        filter.update(chain_record().values.col(k));
      }
    };
    OnlineFilter whole = make(), first = make(), second = make();
    move(whole, 0, 400);
    move(first, 0, 137);
    first.write_state(folder / "state");
    second.read_state(folder / "state");
    move(second, 137, 400);
    EXPECT_EQ(second.nis(), whole.nis()) << int(kind);
    EXPECT_EQ(second.parameter("suspension.mu_k1").mean, whole.parameter("suspension.mu_k1").mean) << int(kind);
    EXPECT_EQ(second.parameter("suspension.mu_k1").std, whole.parameter("suspension.mu_k1").std) << int(kind);
  }
}

TEST(LiveRestart, RefusesWhatIsNotItsOwn) {
  const ScratchFolder folder("live_restart_refusals");
  const auto file = folder / "state";
  LiveFilter live = live_filter();
  for (Index b = 0; b < 50; ++b) push(live, b);
  live.write_state(file);
  EXPECT_THAT(refusal_of([&] { live_filter().read_state(folder / "none"); }), testing::HasSubstr("no such file"));
  const auto other = [] {
    return LiveFilter(structure(2.5e6).base_displacement("road", "wheel.ground"), rate,
                      {.sensors = sensors, .unknowns = {{"strut.k3", {.std = 1e6}}}}, {.filter = gated});
  };
  EXPECT_THAT(refusal_of([&] { other().read_state(file); }), testing::HasSubstr("another structure"));
  std::string whole;
  {
    std::ifstream in(file, std::ios::binary);
    whole.assign(std::istreambuf_iterator<char>(in), {});
  }
  for (const std::size_t at : {whole.size() / 3, whole.size() - 5}) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 1);
    std::ofstream(file, std::ios::binary) << damaged;
    EXPECT_THAT(refusal_of([&] { live_filter().read_state(file); }), testing::HasSubstr("cannot be taken up"));
    std::ofstream(file, std::ios::binary) << whole.substr(0, at);
    EXPECT_THAT(refusal_of([&] { live_filter().read_state(file); }), testing::HasSubstr("damaged"));
  }
  std::ofstream(file, std::ios::binary) << "text";
  EXPECT_THAT(refusal_of([&] { live_filter().read_state(file); }), testing::HasSubstr("no state of kalfem"));
}

}  // namespace
}  // namespace kalfem::quarter_car
