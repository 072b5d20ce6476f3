// SPDX-License-Identifier: Apache-2.0
#include "random_record.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "kalfem/base/random.hpp"
#include "true_system.hpp"

namespace kalfem::calibration {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double pi = std::numbers::pi;
constexpr double relative_prior = 0.3;  ///< standard deviation of the logarithm of an initial value
constexpr int ground = -1;

/// Numbers of one record.
class Draw {
public:
  explicit Draw(std::uint64_t seed) : stream_(seed, "random record") {}
  double within(double lower, double upper) { return lower + (upper - lower) * stream_.uniform(); }
  double within_decades(double lower, double upper) { return lower * std::pow(upper / lower, stream_.uniform()); }
  int integer(int lower, int upper) { return lower + static_cast<int>(stream_.uniform() * (upper - lower + 1)); }
  bool chance(double probability) { return stream_.uniform() < probability; }
  double normal() { return stream_.normal(); }

private:
  RandomStream stream_;
};

/// A sum of sines that rises within a second.
class Sines {
public:
  Sines(Draw& draw, double lower, double upper) {
    for (int i = 0; i < 60; ++i)
      parts_.push_back({2.0 * pi * draw.within(lower, upper), 2.0 * pi * draw.within(0.0, 1.0)});
  }
  void scale(double factor) { amplitude_ *= factor; }
  [[nodiscard]] double value(double t) const {
    double sum = 0.0;
    for (const auto& each : parts_) sum += std::sin(each.omega * t + each.phase);
    return amplitude_ * rise(t) * sum;
  }

private:
  struct Part {
    double omega, phase;
  };
  [[nodiscard]] static double rise(double t) { return t >= 1.0 ? 1.0 : t * t * t * (10.0 - 15.0 * t + 6.0 * t * t); }
  std::vector<Part> parts_;
  double amplitude_ = 1.0;
};

/// A parameter of the structure by its name in the library and its true value.
struct Candidate {
  std::string name;
  double value;
};

/// A linear combination of the motion that a sensor shows.
struct Shown {
  enum class Kind { acceleration, displacement, strain } kind;
  VectorXd shape;
  OutputDescription output;
};

/// What is common to masses on springs and to frames, on the way to a record.
struct Made {
  std::string kind;
  TrueSystem system;
  std::function<void(Structure&)> build;  ///< adds the parts and connectors at their true values
  std::vector<Candidate> candidates;
  std::vector<Shown> shown;         ///< all that a sensor may show
  std::vector<VectorXd> places;     ///< where a force may act
  std::vector<std::string> points;  ///< their names
  VectorXd mount;                   ///< deformation of the connector that may be nonlinear
};

struct Spring {
  int from, to;
  double stiffness, damping;
};

VectorXd deformation(const Spring& spring, Index dofs) {
  VectorXd b = VectorXd::Zero(dofs);
  b[spring.to] += 1.0;
  if (spring.from != ground) b[spring.from] -= 1.0;
  return b;
}

std::string mass_name(int i) { return fmt::format("m{}", i); }

/// Masses on springs in a tree that hangs on the ground, or in a ring that two springs hold.
Made masses_on_springs(Draw& draw) {
  Made made;
  const int count = draw.integer(2, 6);
  const bool ring = count >= 3 && draw.chance(0.4);
  std::vector<double> mass;
  for (int i = 0; i < count; ++i) mass.push_back(draw.within(0.5, 3.0));
  std::vector<Spring> springs;
  const auto add = [&](int from, int to) {
    const double k = draw.within_decades(4e3, 4e4), ratio = draw.within(0.005, 0.04);
    springs.push_back({from, to, k, 2.0 * ratio * std::sqrt(k * mass[static_cast<std::size_t>(to)])});
  };
  for (int i = 0; i < count; ++i) add(ring ? i - 1 : i == 0 ? ground : draw.integer(std::max(0, i - 3), i - 1), i);
  if (ring) {
    add(count - 1, 0);
    springs.front() = {0, count / 2, 0.3 * springs.front().stiffness, 0.3 * springs.front().damping};
    add(ground, 0);
    add(ground, count / 2);
  }
  made.kind = fmt::format("{} of {}", ring ? "ring" : "tree", count);

  made.system.mass = Eigen::Map<const VectorXd>(mass.data(), count).asDiagonal();
  made.system.damping = made.system.stiffness = MatrixXd::Zero(count, count);
  for (const auto& each : springs) {
    const VectorXd b = deformation(each, count);
    made.system.stiffness += each.stiffness * b * b.transpose();
    made.system.damping += each.damping * b * b.transpose();
  }
  // The mount is parallel to one of the springs.
  const Spring& beside = springs[static_cast<std::size_t>(draw.integer(0, static_cast<int>(springs.size()) - 1))];
  made.mount = deformation(beside, count);
  const std::string from = beside.from == ground ? "ground" : "s." + mass_name(beside.from),
                    to = "s." + mass_name(beside.to);
  for (std::size_t i = 0; i < springs.size(); ++i) {
    made.candidates.push_back({fmt::format("s.k{}.stiffness", i), springs[i].stiffness});
    if (i < 2) made.candidates.push_back({fmt::format("s.k{}.damping", i), springs[i].damping});
  }
  made.build = [mass, springs](Structure& structure) {
    LumpedPart part = lumped("s");
    for (std::size_t i = 0; i < mass.size(); ++i) part.mass(mass_name(static_cast<int>(i)), mass[i]);
    for (std::size_t i = 0; i < springs.size(); ++i) {
      const auto& each = springs[i];
      part.spring(fmt::format("k{}", i), each.from == ground ? "ground" : mass_name(each.from), mass_name(each.to),
                  each.stiffness, each.damping);
    }
    structure.add(part);
  };
  made.points = {from, to};
  for (int i = 0; i < count; ++i) {
    const VectorXd unit = VectorXd::Unit(count, i);
    made.places.push_back(unit);
    made.points.push_back("s." + mass_name(i));
    made.shown.push_back({Shown::Kind::acceleration, unit, acceleration("s." + mass_name(i))});
    made.shown.push_back({Shown::Kind::displacement, unit, displacement("s." + mass_name(i))});
  }
  return made;
}

/// A portal of square steel bars in its plane: two columns held at their feet and a beam, Euler-Bernoulli elements with
/// consistent mass, motions x, y and the rotation at each node.
Made portal_frame(Draw& draw) {
  Made made;
  const double height = draw.within(0.4, 0.8), width = draw.within(0.5, 1.0), side = draw.within(0.006, 0.01);
  const double modulus = 2.1e11 * draw.within(0.8, 1.2), density = 7850.0, area = side * side;
  const double inertia = area * area / 12.0;
  const int column = 3, beam = 3, count = 2 * column + beam + 1;  // nodes along the portal, from foot to foot
  std::vector<Eigen::Vector2d> nodes;
  for (int i = 0; i < count; ++i) {
    if (i <= column)
      nodes.emplace_back(0.0, height * i / column);
    else if (i <= column + beam)
      nodes.emplace_back(width * (i - column) / beam, height);
    else
      nodes.emplace_back(width, height * (count - 1 - i) / column);
  }
  const Index all = 3 * count, dofs = all - 6;
  MatrixXd stiffness = MatrixXd::Zero(all, all), mass = stiffness;
  VectorXd strain = VectorXd::Zero(all);
  for (int i = 0; i + 1 < count; ++i) {
    const Eigen::Vector2d along = nodes[static_cast<std::size_t>(i) + 1] - nodes[static_cast<std::size_t>(i)];
    const double l = along.norm(), ea = modulus * area / l, ei = modulus * inertia, m = density * area * l;
    Eigen::Matrix<double, 6, 6> k = Eigen::Matrix<double, 6, 6>::Zero(), mm = k, turn = k;
    k(0, 0) = k(3, 3) = ea;
    k(0, 3) = k(3, 0) = -ea;
    mm(0, 0) = mm(3, 3) = m / 3.0;
    mm(0, 3) = mm(3, 0) = m / 6.0;
    const std::array<int, 4> b = {1, 2, 4, 5};
    Eigen::Matrix4d bending, inertial;
    bending << 12, 6 * l, -12, 6 * l, 6 * l, 4 * l * l, -6 * l, 2 * l * l, -12, -6 * l, 12, -6 * l, 6 * l, 2 * l * l,
        -6 * l, 4 * l * l;
    inertial << 156, 22 * l, 54, -13 * l, 22 * l, 4 * l * l, 13 * l, -3 * l * l, 54, 13 * l, 156, -22 * l, -13 * l,
        -3 * l * l, -22 * l, 4 * l * l;
    for (int r = 0; r < 4; ++r)
      for (int c = 0; c < 4; ++c) {
        k(b[r], b[c]) = ei / (l * l * l) * bending(r, c);
        mm(b[r], b[c]) = m / 420.0 * inertial(r, c);
      }
    const Eigen::Vector2d e = along / l;
    Eigen::Matrix2d axes;
    axes << e.x(), e.y(), -e.y(), e.x();
    for (const int end : {0, 3}) {
      turn.block<2, 2>(end, end) = axes;
      turn(end + 2, end + 2) = 1.0;
    }
    stiffness.block<6, 6>(3 * i, 3 * i) += turn.transpose() * k * turn;
    mass.block<6, 6>(3 * i, 3 * i) += turn.transpose() * mm * turn;
    if (i == 0) {  // middle of the first element, its side at local y = side / 2
      Eigen::Matrix<double, 1, 6> local;
      local << -1.0 / l, 0.0, side / 2.0 / l, 1.0 / l, 0.0, -side / 2.0 / l;
      strain.head(6) = (local * turn).transpose();
    }
  }
  made.kind = "portal frame";
  made.system.mass = mass.block(3, 3, dofs, dofs);
  made.system.stiffness = stiffness.block(3, 3, dofs, dofs);
  const double omega = 2.0 * pi * frequencies(made.system)[0], ratio = draw.within(0.005, 0.02);
  const double beta = ratio / omega, alpha = ratio * omega;
  made.system.damping = alpha * made.system.mass + beta * made.system.stiffness;

  const auto dof = [](int node, int direction) { return Index{3} * (node - 1) + direction; };
  made.mount = VectorXd::Unit(dofs, dof(column, 0));
  made.points = {"ground", "frame.corner.x"};
  made.candidates = {{"frame.steel.youngs_modulus", modulus}};
  made.build = [=](Structure& structure) {
    FiniteElementModel model;
    model.mesh.nodes.resize(3, count);
    FixedNodes plane{.name = "plane", .nodes = {}, .directions = {false, false, true, true, true, false}};
    for (int i = 0; i < count; ++i) {
      model.mesh.nodes.col(i) << nodes[static_cast<std::size_t>(i)], 0.0;
      model.mesh.node_ids.push_back(i + 1);
      plane.nodes.push_back(i);
    }
    for (Index i = 0; i + 1 < count; ++i) {
      const std::array<Index, 2> ends = {i, i + 1};
      model.mesh.regions["bar"].push_back(model.mesh.add_cell(CellShape::line2, i + 1, ends));
    }
    model.materials["steel"] = {modulus, 0.3, density};
    BeamSection section = rectangular_section(side, side);
    section.shear_factor_y = section.shear_factor_z = 0.0;
    model.properties["bar"] = BeamProperty{"steel", section};
    model.fixed = {plane, {.name = "feet", .nodes = {0, Index{count} - 1}}};
    structure.add(FiniteElements("frame", model)
                      .node("corner", column + 1)
                      .node("other", column + beam + 1)
                      .node("middle", column + 2)
                      .gauge({.name = "g", .place = std::int64_t{1}, .fibre = Eigen::Vector2d(side / 2.0, 0.0)})
                      .rayleigh_damping(alpha, beta));
  };
  const std::vector<std::pair<std::string, Index>> measured = {{"frame.corner.x", dof(column, 0)},
                                                               {"frame.other.x", dof(column + beam, 0)},
                                                               {"frame.middle.y", dof(column + 1, 1)}};
  for (const auto& [name, place] : measured) {
    made.places.push_back(VectorXd::Unit(dofs, place));
    made.points.push_back(name);
    made.shown.push_back({Shown::Kind::acceleration, made.places.back(), acceleration(name)});
  }
  made.shown.push_back({Shown::Kind::strain, strain.segment(3, dofs), kalfem::strain("frame.g")});
  return made;
}

/// Root mean square of a deformation in the linear structure.
double size_of_mount(const Made& made, double rate, Index samples) {
  const VectorXd d = integrate(made.system, rate, samples, 2).displacement.transpose() * made.mount;
  return rms(d.tail(samples / 2));
}

enum class MountLaw { none, cubic, gap, hysteretic };

/// The law of the mount for a deformation of that size, beside a spring of stiffness k.
Law nonlinear_mount(Draw& draw, MountLaw which, double size, double k, Made& made) {
  LocalForce local{.shape = made.mount};
  const double c = 0.01 * k / (2.0 * pi * frequencies(made.system)[0]);
  if (which == MountLaw::cubic) {
    const double k3 = draw.within_decades(0.1, 1.0) * k / (size * size);
    made.kind += ", cubic";
    made.candidates.insert(made.candidates.begin(), {"mount.k3", k3});
    local.force = [=](double d, double v, double) { return c * v + k3 * d * d * d; };
    made.system.local = {local};
    return law("cubic", {{"k3", k3}, {"c", c}});
  }
  if (which == MountLaw::gap) {
    const double gap = draw.within(1.0, 1.8) * size, stop = draw.within(0.5, 2.0) * k;
    made.kind += ", gap";
    made.candidates.insert(made.candidates.begin(), {"mount.k_stop", stop});
    local.force = [=](double d, double v, double) {
      return c * v + (d > gap ? stop * (d - gap) : d < -gap ? stop * (d + gap) : 0.0);
    };
    made.system.local = {local};
    return law("gap", {{"k_stop", stop}, {"gap_upper", gap}, {"gap_lower", gap}, {"c", c}});
  }
  const double limit = draw.within(0.4, 0.9) * size, alpha = 0.3, beta = 0.5 / limit, kk = draw.within(0.3, 1.0) * k;
  made.kind += ", hysteretic";
  made.candidates.insert(made.candidates.begin(), {{"mount.k", kk}, {"mount.beta", beta}});
  local.force = [=](double d, double v, double z) { return alpha * kk * d + (1.0 - alpha) * kk * z + c * v; };
  local.flow = [=](double, double v, double z) { return v - beta * std::abs(v) * z - beta * v * std::abs(z); };
  made.system.local = {local};
  return law("bouc_wen", {{"k", kk}, {"alpha", alpha}, {"beta", beta}, {"gamma", beta}, {"c", c}});
}

std::vector<Unmeasured> unmeasured(std::uint64_t seed, const Made& made, const std::vector<SensorDescription>& sensors,
                                   const TrueMotion& motion, Index samples) {
  const std::size_t first = made.points.size() - made.places.size();
  const auto is_measured = [&](const std::string& point) {
    return std::ranges::any_of(sensors, [&](const SensorDescription& sensor) {
      return sensor.output.quantity == ObservedQuantity::displacement &&
             sensor.output.points == displacement(point).points;
    });
  };
  std::vector<std::size_t> free;
  for (std::size_t i = 0; i < made.places.size(); ++i)
    if (!is_measured(made.points[first + i])) free.push_back(i);
  std::vector<Unmeasured> all;
  if (!free.empty()) {
    Draw draw(seed + 1000000);
    const std::size_t i = free[static_cast<std::size_t>(draw.integer(0, static_cast<int>(free.size()) - 1))];
    all.push_back({{"motion", displacement(made.points[first + i])},
                   motion.displacement.rightCols(samples).transpose() * made.places[i]});
  }
  if (motion.force.rows() > 0)
    all.push_back({{"force", connector_force("mount")}, motion.force.row(0).tail(samples).transpose()});
  return all;
}

/// One or two forces, or a ground that is accelerated.
class Drive {
public:
  Drive(Draw& draw, const Made& made, double upper) {
    const Index first = static_cast<Index>(made.points.size() - made.places.size());
    const bool frame = made.kind.starts_with("portal");
    by_ground_ = draw.chance(frame ? 0.0 : 0.3);
    const int count = by_ground_ ? 1 : draw.integer(1, 2);
    for (int i = 0; i < count; ++i) {
      const int place = draw.integer(0, static_cast<int>(made.places.size()) - 1);
      if (i == 1 && names_.front() == made.points[static_cast<std::size_t>(first + place)]) continue;
      names_.push_back(made.points[static_cast<std::size_t>(first + place)]);
      shapes_.push_back(by_ground_ ? VectorXd(-made.system.mass * VectorXd::Ones(made.system.dofs()))
                                   : made.places[static_cast<std::size_t>(place)]);
      signals_.emplace_back(draw, 0.3, upper);
    }
  }

  void scale(double factor) {
    for (auto& each : signals_) each.scale(factor);
  }
  [[nodiscard]] VectorXd load(double t) const {
    VectorXd load = VectorXd::Zero(shapes_.front().size());
    for (std::size_t i = 0; i < shapes_.size(); ++i) load += shapes_[i] * signals_[i].value(t);
    return load;
  }
  [[nodiscard]] double ground_acceleration(double t) const { return by_ground_ ? signals_.front().value(t) : 0.0; }
  [[nodiscard]] bool by_ground() const { return by_ground_; }
  [[nodiscard]] std::string text() const {
    return by_ground_ ? "ground" : signals_.size() == 2 ? "two forces" : "force";
  }
  void drive(Structure& structure, double rate, Index first, Index samples) const {
    for (std::size_t i = 0; i < signals_.size(); ++i) {
      Samples given{VectorXd(samples), rate, 0.0};
      for (Index k = 0; k < samples; ++k) given.values[k] = signals_[i].value(static_cast<double>(first + k) / rate);
      const std::string name = fmt::format("u{}", i);
      if (by_ground_)
        structure.base_acceleration(name, given);
      else
        structure.force(name, names_[i], given);
    }
  }

private:
  bool by_ground_ = false;
  std::vector<std::string> names_;
  std::vector<VectorXd> shapes_;
  std::vector<Sines> signals_;
};

}  // namespace

RandomRecord random_record(std::uint64_t seed, const RandomRecordOptions& options) {
  Draw draw(seed);
  const bool frame = draw.chance(0.2) && !options.lumped;
  Made made = frame ? portal_frame(draw) : masses_on_springs(draw);
  const VectorXd natural = frequencies(made.system);
  const double slowest = natural[0], fastest = natural[std::min<Index>(natural.size() - 1, frame ? 2 : 5)];
  const double rate = std::ceil(draw.within(6.0, 12.0) * fastest);
  const double periods = options.periods > 0.0 ? options.periods : draw.within(40.0, 150.0);
  const auto mount = draw.chance(0.3) ? MountLaw::none : static_cast<MountLaw>(draw.integer(1, 3));
  const bool from_rest = options.from_rest || mount == MountLaw::hysteretic || draw.chance(0.7);
  const Index lead = from_rest ? 0 : static_cast<Index>(5.0 * rate / slowest);
  const Index samples = std::min<Index>(4000, static_cast<Index>(periods * rate / slowest));
  const double size = draw.within_decades(2e-4, 2e-3);

  Drive drive(draw, made, std::min(1.3 * fastest, 0.2 * rate));
  made.system.load = [&drive](double t) { return drive.load(t); };
  drive.scale(size / size_of_mount(made, rate, std::min<Index>(3000, lead + samples)));
  Structure at_truth;
  made.build(at_truth);
  if (mount != MountLaw::none) {
    const double k = 1.0 / (made.mount.transpose() * made.system.stiffness.inverse() * made.mount)(0);
    at_truth.connect("mount", made.points[0], made.points[1], nonlinear_mount(draw, mount, size, k, made));
  } else {
    made.kind += ", linear";
  }
  drive.drive(at_truth, rate, lead, samples);
  const TrueMotion motion = integrate(made.system, rate, lead + samples, 4);

  RandomRecord found{.kind = "", .structure = at_truth, .record = {}, .options = {}, .truth = {}, .unmeasured = {}};
  found.slowest = slowest;
  found.record.sample_rate = rate;
  const int sensors = draw.integer(1, std::min<int>(4, static_cast<int>(made.shown.size())));
  std::vector<VectorXd> channels;
  for (int i = 0; i < sensors; ++i) {
    auto& shown = made.shown[static_cast<std::size_t>(draw.integer(0, static_cast<int>(made.shown.size()) - 1))];
    if (shown.output.name == "taken") continue;
    if (i == 0 && shown.kind != Shown::Kind::acceleration) {
      --i;
      continue;
    }
    VectorXd values = (shown.kind == Shown::Kind::acceleration ? motion.acceleration : motion.displacement)
                          .rightCols(samples)
                          .transpose() *
                      shown.shape;
    if (drive.by_ground() && shown.kind == Shown::Kind::acceleration)
      for (Index k = 0; k < samples; ++k) values[k] += drive.ground_acceleration(static_cast<double>(lead + k) / rate);
    const double noise = draw.within_decades(0.01, 0.1) * rms(values);
    for (double& value : values) value += noise * draw.normal();
    const std::string name = fmt::format("y{}", i), unit = shown.kind == Shown::Kind::acceleration   ? "m/s^2"
                                                           : shown.kind == Shown::Kind::displacement ? "m"
                                                                                                     : "m/m";
    found.record.channels.push_back({name, unit});
    found.options.sensors.push_back({name, shown.output, noise});
    channels.push_back(values);
    shown.output.name = "taken";
  }
  found.record.values.resize(static_cast<Index>(channels.size()), samples);
  for (std::size_t i = 0; i < channels.size(); ++i) found.record.values.row(static_cast<Index>(i)) = channels[i];

  const int unknowns = draw.integer(1, std::min<int>(4, static_cast<int>(made.candidates.size())));
  NamedValues initial;
  for (int i = 0; i < unknowns; ++i) {
    const std::size_t which =
        i == 0 ? 0 : static_cast<std::size_t>(draw.integer(0, static_cast<int>(made.candidates.size()) - 1));
    const auto [name, value] = made.candidates[which];
    if (std::ranges::any_of(initial, [&](const auto& each) { return each.first == name; })) continue;
    const double start = value * std::exp(relative_prior * draw.normal());
    initial.emplace_back(name, start);
    found.options.unknowns.push_back(
        {name, {.initial = start, .std = relative_prior * start, .transform = ParameterTransform{TransformKind::log}}});
    found.truth.push_back(value);
  }
  found.structure = at_truth.at(initial);
  found.unmeasured = unmeasured(seed, made, found.options.sensors, motion, samples);
  if (lead > 0) {
    const double x = std::sqrt(motion.displacement.squaredNorm() / static_cast<double>(motion.displacement.size()));
    const double v = std::sqrt(motion.velocity.squaredNorm() / static_cast<double>(motion.velocity.size()));
    found.options.initial_state = {{"all", {0.0, 0.0, 2.0 * x, 2.0 * v}}};
  }
  found.kind = fmt::format("{}, {}, {} sensors, {} unknowns, {} samples at {:.0f} Hz{}", made.kind, drive.text(),
                           channels.size(), found.truth.size(), samples, rate, lead > 0 ? ", moving" : "");
  return found;
}

}  // namespace kalfem::calibration
