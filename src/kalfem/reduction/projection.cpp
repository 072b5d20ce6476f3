#include "kalfem/reduction/projection.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <numbers>
#include <ranges>
#include <unordered_map>

#include "kalfem/base/stopwatch.hpp"
#include "kalfem/linalg/long_products.hpp"
#include "kalfem/linalg/lowest_modes.hpp"
#include "kalfem/linalg/tall_matrices.hpp"
#include "kalfem/model/linear_model.hpp"
#include "kalfem/reduction/superelement.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Part of a column's size that the others must leave for it to count.
constexpr double least_remainder = 1e-5;

}  // namespace

void orthonormalise(LongVectors& X, const VectorXd& scale, const SparseMatrix& mass) {
  if (X.capacity() == 0) return;
  const Eigen::SelfAdjointEigenSolver<MatrixXd> products(scale.asDiagonal() * gram(X, mass, X.capacity()) *
                                                         scale.asDiagonal());
  const Index independent = (products.eigenvalues().array() > least_remainder * least_remainder).count();
  const VectorXd sizes = products.eigenvalues().tail(independent).cwiseSqrt();
  X.combine(scale.asDiagonal() * products.eigenvectors().rightCols(independent) * sizes.cwiseInverse().asDiagonal());
  X.reserve(independent);
}

VectorXd uncouple(LongVectors& X, const SparseMatrix& stiffness, const SparseMatrix& mass) {
  const Index count = X.capacity();
  if (count == 0) return {};
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> pairs(gram(X, stiffness, count), gram(X, mass, count));
  X.combine(pairs.eigenvectors());
  return pairs.eigenvalues();
}

namespace {

// A model in the coordinates p, z = T p with T = [Psi Phi; 1 0] in the order interior, boundary: constraint modes or
// other static shapes first, then modes of the interior with the boundary held. What is known exactly is not computed
// by products, which would leave rounding in its place: Phi^T M Phi = 1, Phi^T K Phi = diag(lambda) and
// Psi^T K Phi = 0 [CB68].
SparseMatrix projected_mass(const SparseMatrix& mass, const LongVectors& T, Index modes) {
  const Index r = T.capacity();
  MatrixXd reduced = MatrixXd::Identity(r, r);
  visit_products(mass, T, r - modes, [&](Index first, const TallMatrix& panel, const TallMatrix& inertia) {
    reduced.block(first, first, r - first, panel.cols()) = T.products(first, r, inertia);
  });
  return MatrixXd(reduced.selfadjointView<Eigen::Lower>()).sparseView();
}

SparseMatrix projected_stiffness(const SparseMatrix& stiffness, const LongVectors& T, const VectorXd& values) {
  const Index n_b = T.capacity() - values.size();
  const VectorXd diagonal = stiffness.diagonal();
  VectorXd scale = VectorXd::Zero(n_b);  // of the energies that add up to a coordinate's
  MatrixXd held = MatrixXd::Zero(n_b, n_b);
  visit_products(stiffness, T, n_b, [&](Index first, const TallMatrix& panel, const TallMatrix& forces) {
    held.block(first, first, n_b - first, panel.cols()) = T.products(first, n_b, forces);
    scale.segment(first, panel.cols()) = panel.cwiseAbs2().transpose() * diagonal;
  });
  MatrixXd reduced = MatrixXd::Zero(T.capacity(), T.capacity());
  reduced.topLeftCorner(n_b, n_b) = held.selfadjointView<Eigen::Lower>();
  // The energy of a coordinate that moves the whole rigidly is rounding, of either sign.
  for (Index j = 0; j < n_b; ++j)
    if (reduced(j, j) <= std::numeric_limits<double>::epsilon() * scale[j]) {
      reduced.row(j).setZero();
      reduced.col(j).setZero();
    }
  reduced.diagonal().tail(values.size()) = values;
  return reduced.sparseView();
}

SparseMatrix projected_damping(const LinearModel& model, const LongVectors& T) {
  const Index r = T.capacity();
  const MatrixXd local = gram(T, model.damping, r);
  const auto& [modes, rates] = model.modal_damping;
  if (rates.size() == 0) return local.sparseView();
  const MatrixXd mass_weighted_modes = T.products(0, r, model.mass * modes.shapes);
  return symmetric(local + mass_weighted_modes * rates.asDiagonal() * mass_weighted_modes.transpose()).sparseView();
}

/// Positions of the degrees of freedom that points and gauges are combinations of.
std::unordered_map<std::string, Index> places_of_combinations(const LinearModel& model) {
  std::unordered_map<std::string, Index> places;
  for (const auto* combinations : {&model.points, &model.gauges})
    for (const auto& [name, combination] : *combinations)
      for (const auto& [dof, coefficient] : combination) places.emplace(dof, -1);
  if (places.empty()) return places;
  for (Index i = 0; i < model.size(); ++i)
    if (const auto found = places.find(model.dofs[static_cast<std::size_t>(i)]); found != places.end())
      found->second = i;
  return places;
}

/// Combinations of the full model's degrees of freedom as those of the reduced ones.
class ProjectedCombinations {
public:
  ProjectedCombinations(const LinearModel& model, const MatrixXd& T, const std::vector<std::string>& names)
      : T_(T), names_(names), places_(places_of_combinations(model)) {}

  [[nodiscard]] std::map<std::string, DofCombination> of(const std::map<std::string, DofCombination>& named) const {
    std::map<std::string, DofCombination> all;
    for (const auto& [name, combination] : named) {
      Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(T_.cols());
      for (const auto& [dof, coefficient] : combination) row += coefficient * T_.row(places_.at(dof));
      DofCombination& reduced = all[name];
      for (Index j = 0; j < row.size(); ++j)
        if (row[j] != 0.0) reduced[names_[static_cast<std::size_t>(j)]] = row[j];
    }
    return all;
  }

private:
  const MatrixXd& T_;
  const std::vector<std::string>& names_;
  std::unordered_map<std::string, Index> places_;
};

}  // namespace

VectorXd natural_frequencies(const VectorXd& values) {
  return values.cwiseMax(0.0).cwiseSqrt() / (2.0 * std::numbers::pi);
}

MatrixXd symmetric(const MatrixXd& matrix) { return 0.5 * (matrix + matrix.transpose()); }

// From the last column to the first: the shapes shrink as T grows, whose memory is taken where it is written.
std::unique_ptr<LongVectors> transformation(const Partition& parts, const std::vector<LongVectors*>& shapes) {
  constexpr Index widest = 8;
  const auto n_b = static_cast<Index>(parts.boundary.size()), n = n_b + static_cast<Index>(parts.interior.size());
  Index r = 0;
  for (const LongVectors* part : shapes) r += part->capacity();
  auto T = make_long_vectors(n);
  T->reserve(r);
  MatrixXd columns(n, widest);
  Index end = r;
  for (LongVectors* part : std::views::reverse(shapes))
    while (const Index count = std::min(widest, part->capacity())) {
      const Index rest = part->capacity() - count;
      end -= count;
      columns(parts.interior, Eigen::seqN(0, count)) = part->columns(rest, rest + count);
      columns(parts.boundary, Eigen::seqN(0, count)) = MatrixXd::Identity(n_b, r).middleCols(end, count);
      T->put(end, columns.leftCols(count));
      part->reserve(rest);
    }
  return T;
}

LinearModel projected_model(const LinearModel& model, const LongVectors& T, const VectorXd& values) {
  LinearModel reduced;
  reduced.mass = projected_mass(model.mass, T, values.size());
  reduced.damping = projected_damping(model, T);
  reduced.stiffness = projected_stiffness(model.stiffness, T, values);
  return reduced;
}

void carry_over(const LinearModel& model, const MatrixXd& T, std::vector<std::string> names, LinearModel& reduced) {
  for (const auto& ground : model.grounds)
    reduced.grounds.push_back({ground.ground, T.transpose() * ground.stiffness, T.transpose() * ground.damping});
  const ProjectedCombinations combinations(model, T, names);
  reduced.points = combinations.of(model.points);
  reduced.gauges = combinations.of(model.gauges);
  reduced.points_only = model.points_only;
  reduced.dofs = std::move(names);
}

std::vector<std::string> joined(const std::vector<std::string>& boundary, const std::vector<std::string>& also_kept) {
  std::vector<std::string> names = boundary;
  for (const auto& name : also_kept)
    if (std::ranges::find(boundary, name) == boundary.end()) names.push_back(name);
  return names;
}

namespace {

constexpr double same_frequency = 1e-3;
constexpr double rounding_of_frequency = 1e-6;

double frequency(double value) { return std::sqrt(std::max(value, 0.0)) / (2.0 * std::numbers::pi); }

/// Part of a shape by mass in the span of the recovered shapes with the same frequency as the one at `place`.
double captured(const VectorXd& momentum, const MatrixXd& shapes, const VectorXd& values, Index place) {
  double part = 0.0;
  for (Index j = 0; j < values.size(); ++j)
    if (std::abs(frequency(values[j]) - frequency(values[place])) <= same_frequency * frequency(values[place]))
      part += std::pow(momentum.dot(shapes.col(j)), 2);
  return std::min(part, 1.0);
}

/// |K phi - lambda M phi| / |K phi| of the leading shapes; 0 where lambda is, as that is rounding against rounding.
VectorXd residuals(const LinearModel& full, const TallMatrix& shapes, const VectorXd& values) {
  VectorXd sizes = VectorXd::Zero(shapes.cols());
  visit_products(full.stiffness, shapes, [&](Index first, const TallMatrix& forces) {
    for (Index j = 0; j < forces.cols(); ++j)
      if (const double value = values[first + j]; value != 0.0)
        sizes[first + j] = (forces.col(j) - value * (full.mass * shapes.col(first + j))).norm() / forces.col(j).norm();
  });
  return sizes;
}

}  // namespace

double comparison_band(const ReductionErrorIndicators& error_indicators, double asked) {
  if (asked > 0.0) return asked;
  const double highest = error_indicators.highest_kept;
  return highest > 0.0 ? highest * (1.0 + rounding_of_frequency) : error_indicators.next_left_out;
}

namespace {

/// Largest difference of a gauge's strains in the full modes from those in the span of the recovered shapes, Phi Phi^T
/// M phi, relative to the gauge's largest strain. `exact`, `shapes`: mass-normalised.
std::map<std::string, double> compare_strains(const LinearModel& full, const MatrixXd& exact, const MatrixXd& shapes) {
  if (full.gauges.empty()) return {};
  const auto places = places_of_combinations(full);
  const MatrixXd missing = exact - shapes * (shapes.transpose() * (full.mass * exact));
  std::map<std::string, double> errors;
  for (const auto& [gauge, combination] : full.gauges) {
    Eigen::RowVectorXd strain = Eigen::RowVectorXd::Zero(exact.cols()), difference = strain;
    for (const auto& [dof, coefficient] : combination) {
      strain += coefficient * exact.row(places.at(dof));
      difference += coefficient * missing.row(places.at(dof));
    }
    const double largest = strain.cwiseAbs().maxCoeff();
    errors[gauge] = largest > 0.0 ? difference.cwiseAbs().maxCoeff() / largest : 0.0;
  }
  return errors;
}

}  // namespace

// Each mode of the full model is looked for in the span of the reduced modes of its frequency, recovered by T: modes of
// equal frequency may be any combination of each other, and a single MAC would call a good reduction bad.
void compare_modes(const LinearModel& full, const Superelement& reduced, double up_to, const StiffnessFactor* whole,
                   ReductionErrorIndicators& error_indicators) {
  const Stopwatch watch;
  const NormalModes exact = lowest_normal_modes(full, reduced.model.size(), up_to, whole);
  const Index finite = (reduced.model.mass.diagonal().array() > 0.0).count();
  // Beyond the band as well, so that each full mode finds its own and those of the same frequency.
  LowestModes own = lowest_modes(reduced.model.stiffness, reduced.model.mass,
                                 {.count = std::min(finite, exact.frequencies.size() + 8)});
  const MatrixXd shapes = reduced.basis * own.vectors;
  // Small as it is, the reduced stiffness does not show how large the energies are that cancel in a rigid-body mode.
  for (Index i = 0; i < own.values.size() && moves_rigidly(full.stiffness, shapes.col(i)); ++i) own.values[i] = 0.0;
  const Index count = std::min(exact.frequencies.size(), own.values.size());
  const VectorXd residual = residuals(full, shapes.leftCols(count), own.values);
  for (Index i = 0; i < count; ++i)
    error_indicators.modes.push_back({.full = exact.frequencies[i],
                                      .reduced = frequency(own.values[i]),
                                      .mac = captured(full.mass * exact.shapes.col(i), shapes, own.values, i),
                                      .residual = residual[i]});
  // The highest kept modes strain otherwise than the full model's in any reduction, far above what sensors see.
  if (const Index lower = std::min(count, (exact.frequencies.array() <= 0.5 * up_to).count()); lower > 0)
    error_indicators.gauges = compare_strains(full, exact.shapes.leftCols(lower), shapes);
  error_indicators.compare_seconds = watch.seconds();
}

namespace {

constexpr double static_tolerance = 1e-6;
constexpr double frequency_tolerance = 1e-2;
constexpr double least_mac = 0.9;
constexpr double strain_tolerance = 2e-2;

std::string per_cent(double ratio) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2g %%", 100.0 * ratio);
  return text;
}

std::string hertz(double frequency) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g Hz", frequency);
  return text;
}

}  // namespace

// Modes left out matter where the excitation or the sensors reach; modes kept, where they are off inside the sensors'
// band.
std::vector<std::string> reduction_warnings(const ReductionErrorIndicators& error_indicators, double excitation_band,
                                            double sensor_bandwidth) {
  std::vector<std::string> warnings;
  const double left_out = error_indicators.next_left_out;
  if (left_out > 0.0 && left_out < excitation_band)
    warnings.push_back("the first mode left out, at " + hertz(left_out) + ", is inside the band of the excitation, " +
                       hertz(excitation_band) +
                       ": the excitation causes motion that the reduced model cannot represent");
  if (left_out > 0.0 && left_out < 3.0 * sensor_bandwidth)
    warnings.push_back("the kept modes end below " + hertz(left_out) + ", less than three times the sensors' " +
                       "bandwidth of " + hertz(sensor_bandwidth) + ": keep modes up to " +
                       hertz(3.0 * sensor_bandwidth) + ", better up to " + hertz(6.0 * sensor_bandwidth));
  for (const auto& mode : error_indicators.modes) {
    if (mode.full > sensor_bandwidth) break;
    const bool frequency_off = mode.reduced - mode.full > frequency_tolerance * mode.full;
    if (!frequency_off && mode.mac >= least_mac) continue;
    char mac[16];
    std::snprintf(mac, sizeof mac, "%.2f", mode.mac);
    warnings.push_back("the mode of the full model at " + hertz(mode.full) + ", inside the sensors' bandwidth, is at " +
                       hertz(mode.reduced) + " in the reduced model, with a MAC of " + mac +
                       ": keep more modes or add boundary nodes");
  }
  for (const auto& [gauge, error] : error_indicators.gauges)
    if (error > strain_tolerance)
      warnings.push_back("the reduced model is off by up to " + per_cent(error) + " in the strain at gauge '" + gauge +
                         "', and the strain's band does not include that: keep more modes");
  if (error_indicators.static_error > static_tolerance)
    warnings.push_back("the constraint modes leave " + std::to_string(error_indicators.static_error) +
                       " of the boundary forces unbalanced: the stiffness of the interior is almost singular");
  return warnings;
}

}  // namespace kalfem
