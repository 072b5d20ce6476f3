// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <array>
#include <cmath>
#include <iostream>
#include <map>
#include <numbers>
#include <random>

#include <fmt/format.h>

#include "calibration_runs.hpp"
#include "kalfem/api/compare.hpp"
#include "true_system.hpp"

// Four masses in a row with two accelerometers for 12 s, whose joint in the middle has an unknown linear and an unknown
// cubic stiffness. Everything that no sensor measures is compared with its band.

namespace kalfem::calibration {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

enum class Mistake { none, mass, friction, damping, law };

constexpr std::array wrong{Mistake::mass, Mistake::friction, Mistake::damping, Mistake::law};

const char* name_of(Mistake mistake) {
  switch (mistake) {
    case Mistake::none:
      return "right";
    case Mistake::mass:
      return "mass .3 % off";
    case Mistake::friction:
      return "friction of .8 % of the force left out";
    case Mistake::damping:
      return "a dashpot 30 % off";
    case Mistake::law:
      return "law .6 % off";
  }
  return "";
}

struct Case {
  Structure structure;
  Record record;
  EstimateOptions options;
  std::map<std::string, VectorXd> truth;  ///< of what no sensor measures
  double fifth = 0.0;                     ///< .6 % of the joint's force, over the fifth power of its deformation
};

class Maker {
public:
  Maker(int seed, Mistake mistake, double noise)
      : generator_(static_cast<std::uint64_t>(seed)), mistake_(mistake), noise_(noise) {}

  Case make() {
    draw();
    // The force of the joint without the mistake gives the mistake its size.
    const double of_joint = rms(force_of_joint(moved()));
    add_mistake(of_joint);
    return case_of(moved());
  }

private:
  static constexpr double rate = 200.0, k = 8e3, k3 = 2e7, c = 8.0;
  static constexpr Index samples = 2401, masses = 4;

  double uniform(double lower, double upper) {
    return lower + (upper - lower) * std::uniform_real_distribution<>(0.0, 1.0)(generator_);
  }
  double normal() { return std::normal_distribution<>()(generator_); }

  void draw() {
    system_.mass = system_.damping = system_.stiffness = MatrixXd::Zero(masses, masses);
    for (Index i = 0; i < masses; ++i) {
      mass_.push_back(uniform(1.0, 2.5));
      spring_.push_back(uniform(4e3, 1e4));
      dashpot_.push_back(uniform(3.0, 8.0));
      system_.mass(i, i) = mass_.back();
      VectorXd b = VectorXd::Unit(masses, i);
      if (i > 0) b[i - 1] = -1.0;
      if (i == 2) continue;  // the joint
      system_.stiffness += spring_.back() * b * b.transpose();
      system_.damping += dashpot_.back() * b * b.transpose();
    }
    shape_ = VectorXd::Unit(masses, 2) - VectorXd::Unit(masses, 1);
    const double true_k = k * std::exp(0.08 * normal()), true_k3 = k3 * std::exp(0.15 * normal());
    true_ = {true_k, true_k3};
    system_.local = {{shape_, [=](double d, double v, double) { return true_k * d + true_k3 * d * d * d + c * v; }}};
    for (int i = 0; i < 60; ++i)
      sines_.emplace_back(2.0 * std::numbers::pi * uniform(0.5, 18.0), uniform(0.0, 2.0 * std::numbers::pi));
    system_.load = [this](double t) { return VectorXd(force(t) * VectorXd::Unit(masses, 0)); };
  }

  [[nodiscard]] double force(double t) const {
    double sum = 0.0;
    for (const auto& [omega, phase] : sines_) sum += std::sin(omega * t + phase);
    const double rise = t >= 0.5 ? 1.0 : 0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * t);
    return 7.5 * rise * sum;
  }

  [[nodiscard]] TrueMotion moved() const { return integrate(system_, rate, samples, 4); }

  [[nodiscard]] VectorXd force_of_joint(const TrueMotion& motion) const {
    const VectorXd d = motion.displacement.transpose() * shape_, v = motion.velocity.transpose() * shape_;
    return true_.first * d.array() + true_.second * d.array().cube() + c * v.array();
  }

  void add_mistake(double of_joint) {
    const TrueMotion motion = moved();
    const VectorXd d = motion.displacement.transpose() * shape_, v = motion.velocity.transpose() * shape_;
    const double slow = 0.05 * rms(v), friction = 0.008 * of_joint;
    const double fifth = fifth_ = 0.006 * of_joint / rms(d.array().pow(5.0).matrix());
    if (mistake_ == Mistake::friction)
      system_.local.push_back({shape_, [=](double, double v, double) { return friction * std::tanh(v / slow); }});
    if (mistake_ == Mistake::law)
      system_.local.push_back({shape_, [=](double d, double, double) { return fifth * std::pow(d, 5.0); }});
  }

  Case case_of(const TrueMotion& motion) {
    const auto at = [](Index i) { return std::to_string(i + 1); };
    Case made;
    made.fifth = fifth_;
    auto part = lumped("s");
    for (Index i = 0; i < masses; ++i) {
      const auto place = static_cast<std::size_t>(i);
      part.mass(at(i), mass_[place] * (mistake_ == Mistake::mass && i == 2 ? 1.003 : 1.0));
      if (i == 2) continue;
      part.spring("k" + at(i), i == 0 ? "ground" : at(i - 1), at(i), spring_[place],
                  dashpot_[place] * (mistake_ == Mistake::damping && i == 3 ? 1.3 : 1.0));
    }
    made.structure.add(part).connect(
        "joint", "s.2", "s.3",
        expression("k*x + k3*x^3 + k5*x^5 + c*v", {{"k", k}, {"k3", k3}, {"k5", 0.0}, {"c", c}}));
    VectorXd push(samples);
    for (Index i = 0; i < samples; ++i) push[i] = force(static_cast<double>(i) / rate);
    made.structure.force("push", "s.1", {push, rate});
    std::vector<std::pair<std::string, VectorXd>> channels;
    for (const Index i : {1, 3}) {
      VectorXd values = motion.acceleration.row(i).transpose();
      const double deviation = noise_ * rms(values);
      for (double& value : values) value += deviation * normal();
      channels.emplace_back("a" + at(i), values);
      made.options.sensors.push_back({"a" + at(i), acceleration("s." + at(i)), deviation});
    }
    made.record = make_record(rate, channels);
    made.options.unknowns = {{"joint.k", {.initial = k, .std = 0.1 * k}},
                             {"joint.k3", {.initial = k3, .std = 0.2 * k3}}};
    for (Index i = 0; i < masses; ++i) {
      made.truth["s." + at(i) + ".displacement"] = motion.displacement.row(i).transpose();
      made.truth["s." + at(i) + ".velocity"] = motion.velocity.row(i).transpose();
      if (i == 0 || i == 2) made.options.outputs.push_back({"a" + at(i) + " unmeasured", acceleration("s." + at(i))});
      if (i == 0 || i == 2) made.truth["a" + at(i) + " unmeasured"] = motion.acceleration.row(i).transpose();
    }
    return made;
  }

  std::mt19937_64 generator_;
  Mistake mistake_;
  double noise_;
  TrueSystem system_;
  VectorXd shape_;
  std::pair<double, double> true_;
  double fifth_ = 0.0;
  std::vector<double> mass_, spring_, dashpot_;
  std::vector<std::pair<double, double>> sines_;
};

double share_inside(const EstimatedQuantity& quantity, const VectorXd& truth) {
  const Index judged = truth.size() - truth.size() / 20;
  return ((quantity.mean - truth).tail(judged).array().abs() <= 1.96 * quantity.std.tail(judged).array())
      .cast<double>()
      .mean();
}

struct Count {
  int runs = 0, consistent = 0, named = 0, mended = 0;
  std::map<std::string, double> inside;  ///< by quantity, summed over the consistent runs

  [[nodiscard]] double worst() const {
    double worst = 1.0;
    for (const auto& [name, sum] : inside) worst = std::min(worst, sum / std::max(1, consistent));
    return worst;
  }
};

bool doubts_bands(const EstimateResult& found) {
  return std::ranges::any_of(found.held_out_sensors, [](const HeldOutSensor& sensor) { return !sensor.holds(); });
}

Count counted(Mistake mistake, double noise, int seeds) {
  Count count;
  for (int seed = 1; seed <= seeds; ++seed) {
    const Case made = Maker(seed, mistake, noise).make();
    const auto found = estimate(made.structure, made.record, made.options);
    ++count.runs;
    count.named += doubts_bands(found) ? 1 : 0;
    count.mended += found.adapted_process && found.adapted_process->mends ? 1 : 0;
    std::string shares;
    for (const auto& each : found.held_out_sensors)
      shares += fmt::format(" {} {:.3f} ({:.2f} {:.2f})", each.name, each.inside, each.followed, each.in_band);
    std::cout << seed << " " << name_of(mistake) << ": " << to_string(found.verdict.state()) << codes_of(found.verdict)
              << shares << std::endl;
    if (found.verdict.state() != VerdictState::consistent) continue;
    ++count.consistent;
    for (const auto& [name, truth] : made.truth) {
      const bool is_output = name.ends_with("unmeasured");
      count.inside[name] += share_inside(is_output ? found.output(name) : found.state(name), truth);
    }
  }
  std::cout << fmt::format(
                   "{}, noise {} %: {} of {} consistent, worst quantity of these {:.3f}; bands doubted {}, mended {}\n",
                   name_of(mistake), 100.0 * noise, count.consistent, count.runs, count.worst(), count.named,
                   count.mended)
            << std::flush;
  return count;
}

TEST(VirtualSensors, OfRightModelsHold) {
  const Count count = counted(Mistake::none, 0.05, number("KALFEM_COUNT", 40));
  EXPECT_LE(count.named, 0.05 * count.runs);
  EXPECT_GE(count.worst(), 0.9);
}

// By held-out sensors and the score test of fixed numbers together. What .6 % of a joint's force adds that its unknowns
// cannot take up is an error of a few deviations of the noise over the whole record, which nothing tells: its share is
// printed.
TEST(VirtualSensors, OfWrongModelsAreDoubted) {
  for (const Mistake mistake : wrong) {
    const Count count = counted(mistake, 0.05, number("KALFEM_COUNT", 40) / 4);
    if (mistake != Mistake::law) EXPECT_LE(count.consistent, 0.1 * count.runs) << name_of(mistake);
  }
}

/// The same with everything that is compared among the outputs.
Case with_outputs(Case made) {
  made.options.outputs.clear();
  for (const auto& [name, truth] : made.truth) {
    const auto point = name.substr(0, name.rfind('.'));
    if (name.ends_with("unmeasured"))
      made.options.outputs.push_back({name, acceleration("s." + name.substr(1, 1))});
    else if (name.ends_with("displacement"))
      made.options.outputs.push_back({name, displacement(point)});
    else
      made.options.outputs.push_back({name, velocity(point)});
  }
  return made;
}

// What nothing tells can still be stated: that the joint may stiffen with the fifth power, too, by something of 1 % of
// its force. The mixture of both laws holds what the cubic one alone does not.
TEST(VirtualSensors, OfAMixtureOfLawsHold) {
  const int seeds = number("KALFEM_COUNT", 40) / 4;
  std::map<std::string, double> inside;
  double weight = 0.0;
  for (int seed = 1; seed <= seeds; ++seed) {
    Case made = with_outputs(Maker(seed, Mistake::law, 0.05).make());
    const auto cubic = estimate(made.structure, made.record, made.options);
    made.options.unknowns.push_back({"joint.k5", {.initial = 0.0, .std = 2.0 * made.fifth}});
    const auto quintic = estimate(made.structure, made.record, made.options);
    const auto mixed = mixture({cubic, quintic});
    weight += mixed.weights[1] / seeds;
    for (const auto& each : mixed.outputs) inside[each.name] += share_inside(each, made.truth.at(each.name)) / seeds;
  }
  double worst = 1.0;
  for (const auto& [name, share] : inside) worst = std::min(worst, share);
  std::cout << fmt::format("mixture of laws: worst quantity {:.3f}, mean weight of the law with k5 {:.2f}\n", worst,
                           weight);
  EXPECT_GE(worst, 0.85);
}

}  // namespace
}  // namespace kalfem::calibration
