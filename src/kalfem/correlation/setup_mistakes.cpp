// SPDX-License-Identifier: Apache-2.0
#include "kalfem/correlation/setup_mistakes.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <numbers>

#include "kalfem/correlation/shape_fit.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Rows = std::vector<Index>;

/// "n12.z" is node "n12" and direction "z"; a place without a point is a node without a direction.
struct Place {
  std::string node, direction;
};
Place place_of(const std::string& name) {
  const auto dot = name.rfind('.');
  return dot == std::string::npos ? Place{name, ""} : Place{name.substr(0, dot), name.substr(dot + 1)};
}

/// A mistake with the rows that the model gets by it.
struct Trial {
  SetupMistake mistake;
  Rows rows;
  MatrixXd motions;
  double misfit = std::numeric_limits<double>::infinity();
};

/// The best mistake of one kind, and how many were tried.
struct BestOfKind {
  Trial best;
  Index tried = 0;
  void take(const ShapeFit& fit, const Rows& rows, const MatrixXd& motions, const auto& name_it) {
    ++tried;
    const double misfit = fit.misfit_with(rows, motions);
    if (misfit >= best.misfit) return;
    best = {name_it(), rows, motions, misfit};
  }
};

class Search {
public:
  Search(const ShapeFit& fit, const std::vector<ShapeSensor>& sensors, const ModelPlaces& places)
      : fit_(fit), sensors_(sensors), places_(places) {
    for (const auto& sensor : sensors) at_.push_back(place_of(sensor.place));
    for (std::size_t i = 0; i < places.names.size(); ++i) {
      const auto place = place_of(places.names[i]);
      by_direction_[place.direction].push_back(static_cast<Index>(i));
      by_node_[place.node].push_back(static_cast<Index>(i));
    }
  }

  /// The mistake with the most evidence.
  Trial best() const {
    Trial found;
    for (const auto& [kind, cost] : {turned(), swapped(), direction(), rotated(2), rotated(3), node()}) {
      if (kind.tried == 0) continue;
      Trial trial = kind.best;
      trial.mistake.evidence = 0.5 * static_cast<double>(fit_.entries()) * std::log(fit_.misfit() / trial.misfit) -
                               std::log(static_cast<double>(kind.tried)) - cost;
      if (found.rows.empty() || trial.mistake.evidence > found.mistake.evidence) found = trial;
    }
    return found;
  }

private:
  using Kind = std::pair<BestOfKind, double>;  ///< with what its fitted numbers cost

  [[nodiscard]] const std::string& name(Index sensor) const { return sensors_[static_cast<std::size_t>(sensor)].name; }
  [[nodiscard]] const Place& at(Index sensor) const { return at_[static_cast<std::size_t>(sensor)]; }

  [[nodiscard]] Kind turned() const {
    BestOfKind kind;
    for (Index i = 0; i < fit_.sensors(); ++i)
      kind.take(fit_, {i}, -fit_.model().row(i),
                [&] { return SetupMistake{.kind = MistakeKind::turned, .sensors = {name(i)}}; });
    return {kind, 0.0};
  }

  [[nodiscard]] Kind swapped() const {
    BestOfKind kind;
    for (Index i = 0; i < fit_.sensors(); ++i)
      for (Index j = i + 1; j < fit_.sensors(); ++j)
        kind.take(fit_, {i, j}, fit_.model()(Rows{j, i}, Eigen::all), [&] {
          return SetupMistake{.kind = MistakeKind::swapped, .sensors = {name(i), name(j)}};
        });
    return {kind, 0.0};
  }

  /// Another place instead of that of sensor i, along it or against it.
  void try_place(BestOfKind& kind, MistakeKind what, Index i, Index place, bool against) const {
    kind.take(fit_, {i}, (against ? -1.0 : 1.0) * places_.motions.row(place), [&] {
      const std::string& found = places_.names[static_cast<std::size_t>(place)];
      return SetupMistake{.kind = what, .sensors = {name(i)}, .place = (against ? "-" : "") + found};
    });
  }

  [[nodiscard]] Kind direction() const {
    BestOfKind kind;
    for (Index i = 0; i < fit_.sensors(); ++i)
      if (const auto found = by_node_.find(at(i).node); found != by_node_.end())
        for (const Index place : found->second)
          for (const bool against : {false, true})
            if (const auto other = place_of(places_.names[static_cast<std::size_t>(place)]).direction;
                other != at(i).direction && other.size() == at(i).direction.size())
              try_place(kind, MistakeKind::direction, i, place, against);
    return {kind, 0.0};
  }

  [[nodiscard]] Kind node() const {
    BestOfKind kind;
    for (Index i = 0; i < fit_.sensors(); ++i)
      if (const auto found = by_direction_.find(at(i).direction); found != by_direction_.end())
        for (const Index place : found->second)
          if (place_of(places_.names[static_cast<std::size_t>(place)]).node != at(i).node)
            try_place(kind, MistakeKind::node, i, place, false);
    return {kind, 0.0};
  }

  /// Sensors of one node along so many of the axes x, y and z, no more and no fewer.
  [[nodiscard]] std::vector<Rows> together(Index axes) const {
    std::map<std::string, std::map<std::string, Index>> nodes;
    for (Index i = 0; i < fit_.sensors(); ++i)
      if (at(i).direction == "x" || at(i).direction == "y" || at(i).direction == "z")
        nodes[at(i).node][at(i).direction] = i;
    std::vector<Rows> all;
    for (const auto& [node, sensors] : nodes) {
      if (std::ssize(sensors) != axes) continue;
      all.emplace_back();
      for (const auto& [direction, sensor] : sensors) all.back().push_back(sensor);
    }
    return all;
  }

  /// The rotation R that brings c a of the node nearest to what its sensors measured: with the singular value
  /// decomposition U S V^T of sum f (c a)^T, R = U diag(1, ..., det(U V^T)) V^T.
  [[nodiscard]] MatrixXd rotation_of(const Rows& rows) const {
    const Eigen::VectorXd scales = fit_.scales_without(rows);
    const auto size = std::ssize(rows);
    MatrixXd sum = MatrixXd::Zero(size, size);
    for (Index pair = 0; pair < fit_.pairs(); ++pair)
      for (Index i = 0; i < size; ++i)
        for (Index j = 0; j < size; ++j)
          sum(i, j) += fit_.measured(rows[static_cast<std::size_t>(i)], pair) * scales[pair] *
                       fit_.model()(rows[static_cast<std::size_t>(j)], pair);
    const Eigen::JacobiSVD<MatrixXd> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::VectorXd signs = Eigen::VectorXd::Ones(size);
    signs[size - 1] = (svd.matrixU() * svd.matrixV().transpose()).determinant();
    return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  }

  /// From the axes of the model to those of the sensors.
  static std::string rotation_in_words(const MatrixXd& R) {
    constexpr double degrees = 180.0 / std::numbers::pi;
    if (R.rows() == 2)
      return fmt::format("{:.0f} degrees in their plane", degrees * std::abs(std::atan2(R(0, 1), R(0, 0))));
    const Eigen::AngleAxisd turn(Matrix3d(R.transpose()));
    const Eigen::Vector3d axis = turn.axis();
    return fmt::format("{:.0f} degrees about ({:.2f}, {:.2f}, {:.2f})", degrees * turn.angle(), axis.x(), axis.y(),
                       axis.z());
  }

  [[nodiscard]] Kind rotated(Index axes) const {
    BestOfKind kind;
    for (const Rows& rows : together(axes)) {
      const MatrixXd R = rotation_of(rows);
      kind.take(fit_, rows, R * fit_.model()(rows, Eigen::all), [&] {
        SetupMistake mistake{.kind = MistakeKind::rotated, .place = rotation_in_words(R)};
        for (const Index row : rows) mistake.sensors.push_back(name(row));
        return mistake;
      });
    }
    const double angles = 0.5 * static_cast<double>(axes * (axes - 1));
    return {kind, 0.5 * angles * std::log(static_cast<double>(axes * fit_.pairs()))};
  }

  const ShapeFit& fit_;
  const std::vector<ShapeSensor>& sensors_;
  const ModelPlaces& places_;
  std::vector<Place> at_;
  std::map<std::string, Rows> by_direction_, by_node_;  ///< numbers of places
};

}  // namespace

std::string_view word_of(MistakeKind kind) {
  switch (kind) {
    case MistakeKind::turned:
      return "turned";
    case MistakeKind::swapped:
      return "swapped";
    case MistakeKind::direction:
      return "direction";
    case MistakeKind::rotated:
      return "rotated";
    case MistakeKind::node:
      break;
  }
  return "node";
}

std::string SetupMistake::in_words() const {
  const std::string first = sensors.empty() ? "" : sensors.front();
  switch (kind) {
    case MistakeKind::turned:
      return first + " is turned: it measures against its direction";
    case MistakeKind::swapped:
      return first + " and " + sensors.back() + " are swapped";
    case MistakeKind::direction:
      return first + " looks along another axis: it measures " + place;
    case MistakeKind::rotated:
      return fmt::format("{} and {} are rotated together, by {}",
                         fmt::join(sensors.begin(), std::prev(sensors.end()), ", "), sensors.back(), place);
    case MistakeKind::node:
      break;
  }
  return first + " sits elsewhere: it measures " + place;
}

std::vector<SetupMistake> setup_mistakes(const MatrixXd& measured, const MatrixXd& given,
                                         const std::vector<ShapeSensor>& sensors, const ModelPlaces& places,
                                         const MistakeOptions& options) {
  std::vector<SetupMistake> mistakes;
  if (measured.cols() == 0 || measured.rows() < 3) return mistakes;
  MatrixXd model = given;
  while (std::ssize(mistakes) < options.most) {
    const ShapeFit fit(measured, model);
    if (!(fit.misfit() > 0.0)) break;
    Trial trial = Search(fit, sensors, places).best();
    if (trial.rows.empty() || trial.mistake.evidence < options.least_evidence ||
        trial.misfit > (1.0 - options.least_share) * fit.misfit())
      break;
    for (std::size_t i = 0; i < trial.rows.size(); ++i)
      model.row(trial.rows[i]) = trial.motions.row(static_cast<Index>(i));
    trial.mistake.mac_before = fit.mac().mean();
    trial.mistake.mac_after = ShapeFit(measured, model).mac().mean();
    mistakes.push_back(trial.mistake);
  }
  return mistakes;
}

}  // namespace kalfem
