// SPDX-License-Identifier: Apache-2.0
#include "kalfem/linalg/lowest_modes.hpp"

#include <Eigen/Dense>
#include <Eigen/Sparse>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/linalg/block_lanczos.hpp"
#include "kalfem/linalg/sparse_factor.hpp"
#include "kalfem/linalg/sparse_operations.hpp"

namespace kalfem {
namespace {

/// Eigenpairs of K phi = lambda M phi by dense solvers, ascending, Phi^T M Phi = 1.
struct DensePairs {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// R with R R^T = M, n x rank.
MatrixXd root(const MatrixXd& mass) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(mass);
  const double largest = solver.eigenvalues().tail(1)[0];
  const Index rank = (solver.eigenvalues().array() > 1e-13 * largest).count();
  return solver.eigenvectors().rightCols(rank) * solver.eigenvalues().tail(rank).cwiseSqrt().asDiagonal();
}

DensePairs condensed_modes(const Eigen::SparseMatrix<double>& mass, const SparseFactor& shifted, double shift) {
  std::vector<Index> massive;
  const VectorXd diagonal = mass.diagonal();
  for (Index j = 0; j < diagonal.size(); ++j)
    if (diagonal[j] > 0.0) massive.push_back(j);
  const MatrixXd loads = root(MatrixXd(select(mass, massive, massive)));
  MatrixXd displacements = MatrixXd::Zero(mass.rows(), loads.cols());
  displacements(massive, Eigen::all) = loads;
  shifted.solve(displacements, displacements);
  const MatrixXd flexibility = loads.transpose() * displacements(massive, Eigen::all);
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(0.5 * (flexibility + flexibility.transpose()));
  const VectorXd shifted_values = solver.eigenvalues().reverse().cwiseInverse();
  return {shifted_values.array() - shift,
          displacements * (solver.eigenvectors().rowwise().reverse() * shifted_values.asDiagonal())};
}

/// All pairs with finite lambda. Where M is positive definite, of the pencil itself. Else of G = L^T E^T A^-1 E L with
/// A = K + s M (`shifted`), E the columns of the identity that have mass and L L^T the mass there: G w = w / (lambda +
/// s), phi = (lambda + s) A^-1 E L w; its size is the number of degrees of freedom with mass.
DensePairs dense_modes(const Eigen::SparseMatrix<double>& stiffness, const Eigen::SparseMatrix<double>& mass,
                       const SparseFactor& shifted, double shift) {
  if ((mass.diagonal().array() > 0.0).all()) {
    const MatrixXd dense_mass(mass);
    const Eigen::LLT<MatrixXd> factor(dense_mass);
    if (factor.info() == Eigen::Success && factor.rcond() > 1e-13) {
      const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> solver(MatrixXd(stiffness), dense_mass);
      return {solver.eigenvalues(), solver.eigenvectors()};
    }
  }
  return condensed_modes(mass, shifted, shift);
}

}  // namespace

using Matrix = Eigen::SparseMatrix<double>;

namespace {

constexpr double guard_tolerance = 1e-2;  ///< of the first pair that is not wanted: only its place matters
constexpr double check_tolerance = 5e-2;
constexpr double same_value = 1e-7;  ///< eigenvalues that differ less are one
constexpr Index sturm_limit = 3000;
constexpr Index dense_limit = 200;
constexpr Index block_width = 8;
constexpr Index first_guess = 24;  ///< of the number of modes below a limit
constexpr int most_rooms = 60;
constexpr int most_checks = 20;

void check(const Matrix& stiffness, const Matrix& mass, const LowestModesOptions& options) {
  IssueList issues;
  if (stiffness.rows() != stiffness.cols() || mass.rows() != stiffness.rows() || mass.cols() != stiffness.cols())
    issues.add({},
               "modes of a " + std::to_string(stiffness.rows()) + "-row stiffness and a " +
                   std::to_string(mass.rows()) + "-row mass matrix",
               "both must be square and of the same size");
  if (!options.count && !options.below)
    issues.add({}, "neither a number of modes nor a limit is given", "one of them must limit the search");
  if (options.count && *options.count < 0)
    issues.add({}, std::to_string(*options.count) + " modes are requested", "the number must not be negative");
  if (!(options.tolerance > 0.0)) issues.add({}, "the tolerance is not positive");
  issues.raise();
}

// In theta the wanted pairs come first and their end is either a number or a least theta. A pair counts once its
// residual is a small part of its theta. The first pair beyond must be known roughly too: it proves that the wanted
// ones are complete, and is the first frequency left out.
/// The wanted pairs lead the list of all; how many they are may show only as they come.
class Wanted {
public:
  Wanted(const LowestModesOptions& options, double shift)
      : count_(options.count.value_or(std::numeric_limits<Index>::max())),
        at_least_(options.at_least),
        least_(options.below ? 1.0 / std::max(*options.below + shift, std::numeric_limits<double>::min()) : 0.0),
        tolerance_(options.tolerance) {}

  [[nodiscard]] Index among(const RitzPairs& pairs) const {
    const Index number = std::max(at_least_, (pairs.values.array() >= least_).count());
    return std::min({count_, number, pairs.values.size()});
  }

  /// The wanted pairs have converged, and so has, roughly, the first that is not wanted.
  [[nodiscard]] bool found(const RitzPairs& pairs) const {
    const Index k = among(pairs);
    if (pairs.values.size() <= k) return false;
    const bool beyond_limit = k == count_ || pairs.values[k] + pairs.residuals[k] < least_;
    return beyond_limit && pairs.residuals[k] <= guard_tolerance * pairs.values[k] &&
           (pairs.residuals.head(k).array() <= tolerance_ * pairs.values.head(k).array()).all();
  }

  /// Size of a space that may hold them and the next.
  [[nodiscard]] Index space() const { return (least_ > 0.0 ? std::min(at_least_, count_) : count_) + 1; }

  /// Every pair with a theta above this must be among the `count` that were found.
  [[nodiscard]] double floor(const RitzPairs& pairs, Index count) const {
    const double last = pairs.values[count - 1];
    return count == count_ || last < least_ ? (1.0 + same_value) * last : least_;
  }

private:
  Index count_, at_least_;
  double least_;  ///< theta of the limit
  double tolerance_;
};

/// A limit is mostly given with a number that it keeps from mattering.
Index expected(const LowestModesOptions& options) {
  const Index count = options.count.value_or(first_guess);
  return options.below ? std::min(count, std::max(first_guess, options.at_least)) : count;
}

/// Space for a basis in which so many pairs converge; where they are more than was thought, it grows.
Index capacity_for(Index wanted) { return 2 * wanted + 12 * block_width; }

void make_room(BlockLanczos& lanczos, const RitzPairs& pairs, Index wanted) {
  if (capacity_for(wanted) > lanczos.size() + 2 * block_width)
    lanczos.set_capacity(capacity_for(2 * wanted));
  else
    lanczos.compress(pairs, wanted + (lanczos.size() - wanted) / 3);
}

/// Extends the space until the wanted pairs have converged in it, or nothing is left outside.
RitzPairs iterate(BlockLanczos& lanczos, const Wanted& wanted) {
  Index next_look = wanted.space();
  for (int rooms = 0; rooms < most_rooms;) {
    if (!lanczos.step() && !(lanczos.restart_at_random() && lanczos.step())) return lanczos.pairs();
    if (lanczos.size() < next_look && !lanczos.full()) continue;
    next_look = lanczos.size() + lanczos.size() / 12;  // the pairs of the small problem cost more than a step
    RitzPairs pairs = lanczos.pairs();
    if (wanted.found(pairs)) return pairs;
    if (!lanczos.full()) continue;
    make_room(lanczos, pairs, wanted.among(pairs));
    next_look = lanczos.size();
    ++rooms;
  }
  throw InvalidInput("the eigenvalue iteration does not converge",
                     "after " + std::to_string(most_rooms) + " restarts the residuals are above the tolerance",
                     "request fewer modes or a larger tolerance, and check the stiffness matrix");
}

/// Whether a random block, iterated in the complement of the `count` leading pairs, brings nothing above `floor`.
bool fresh_block_agrees(BlockLanczos& lanczos, const RitzPairs& pairs, Index count, double floor) {
  const Index known = (pairs.values.head(count).array() > floor).count();
  lanczos.compress(pairs, count);
  if (!lanczos.restart_at_random()) return true;
  while (lanczos.step()) {
    const RitzPairs now = lanczos.pairs();
    if ((now.values.array() > floor).count() > known) return false;
    if (now.residuals[count] <= check_tolerance * now.values[count] || lanczos.full()) return true;
  }
  return true;
}

/// Number of eigenvalues below lambda: the negative pivots of K - lambda M (Sylvester's law of inertia).
Index count_below(const Matrix& stiffness, const Matrix& mass, double lambda) {
  if (lambda <= 0.0) return 0;
  const Eigen::SimplicialLDLT<Matrix> factor(Matrix(stiffness - lambda * mass));
  return factor.info() == Eigen::Success ? (factor.vectorD().array() < 0.0).count() : 0;
}

struct Problem {
  const Matrix& stiffness;
  const Matrix& mass;
  const StiffnessFactor& factored;
  const LowestModesOptions& options;  ///< of the modes beside the rigid ones that the factor knows

  [[nodiscard]] VectorXd lambda(const RitzPairs& pairs, Index count) const {
    return pairs.values.head(count).cwiseInverse().array() - factored.shift;
  }

  [[nodiscard]] bool complete(BlockLanczos& lanczos, const RitzPairs& pairs, Index count, double floor) const {
    if (options.check == ModeCheck::none) return true;
    const bool sturm =
        options.check == ModeCheck::sturm || (options.check == ModeCheck::automatic && mass.rows() <= sturm_limit);
    const Index known = factored.rigid_modes.cols() + (pairs.values.head(count).array() > floor).count();
    if (sturm && count_below(stiffness, mass, 1.0 / floor - factored.shift) <= known) return true;
    return fresh_block_agrees(lanczos, pairs, count, floor) && !sturm;
  }
};

/// One more application of (K + s M)^-1 M takes out what M does not see.
MatrixXd purified(const Matrix& mass, const StiffnessFactor& factored, MatrixXd vectors) {
  vectors = mass * vectors;
  factored.respond(vectors, vectors);
  const VectorXd lengths = vectors.cwiseProduct(mass * vectors).colwise().sum().cwiseSqrt();
  return vectors * lengths.cwiseInverse().asDiagonal();
}

// The lowest modes of a large model are found in four steps:
//   1. shift and invert: A = K + s M is factored once; its inverse has the values theta = 1 / (lambda + s), so that the
//      lowest modes are the largest theta, which a Krylov space shows first. Known rigid modes stay out of the space;
//   2. iterate: the space grows by blocks until the wanted pairs have converged in it, and shrinks to its leading Ritz
//      vectors where it is full (thick restart);
//   3. check: either the inertia of K - lambda M counts the values below (Sylvester), or a random block that is
//      iterated in the complement must bring nothing above the last value found. Where a pair was missed, go on;
//   4. purify: a mass matrix with zeros lets components grow that M does not see; one more A^-1 M takes them out.
LowestModes by_lanczos(const Problem& problem) {
  const auto& [stiffness, mass, factored, options] = problem;
  const Wanted wanted(options, factored.shift);
  BlockLanczos lanczos(factored, mass, block_width, capacity_for(expected(options)));
  lanczos.restart_at_random();
  for (int attempt = 0; attempt < most_checks; ++attempt) {
    const RitzPairs pairs = iterate(lanczos, wanted);
    const Index count = wanted.among(pairs);
    MatrixXd vectors = lanczos.vectors(pairs, count);
    if (count > 0 && !problem.complete(lanczos, pairs, count, wanted.floor(pairs, count))) continue;
    LowestModes modes{problem.lambda(pairs, count), std::move(vectors), {}, lanczos.solves()};
    if (pairs.values.size() > count) modes.next = 1.0 / pairs.values[count] - factored.shift;
    if ((mass.diagonal().array() <= 0.0).any()) modes.vectors = purified(mass, factored, modes.vectors);
    return modes;
  }
  throw InvalidInput("eigenvalues below the highest one found are missing",
                     "K - lambda M has more negative pivots than eigenvalues found, even after " +
                         std::to_string(most_checks) + " attempts",
                     "check that the stiffness and mass matrices are symmetric and well scaled");
}

LowestModes by_dense(const Problem& problem) {
  const DensePairs pairs =
      dense_modes(problem.stiffness, problem.mass, problem.factored.factor, problem.factored.shift);
  const double limit = problem.options.below.value_or(std::numeric_limits<double>::infinity());
  const Index all = pairs.values.size();
  const Index number = std::max(problem.options.at_least, (pairs.values.array() <= limit).count());
  const Index count = std::min({number, all, problem.options.count.value_or(all)});
  LowestModes modes{pairs.values.head(count), pairs.vectors.leftCols(count), {}, 0};
  if (count < all) modes.next = pairs.values[count];
  return modes;
}

void clean_rigid_modes(const Matrix& stiffness, LowestModes& modes) {
  for (Index i = 0; i < modes.values.size() && moves_rigidly(stiffness, modes.vectors.col(i)); ++i)
    modes.values[i] = 0.0;
}

/// The modes with the rigid ones, which the factor knows, before them. They are moved within their memory.
LowestModes behind(const MatrixXd& rigid_modes, LowestModes modes) {
  const Index rigid = rigid_modes.cols(), elastic = modes.values.size();
  if (rigid == 0) return modes;
  VectorXd values = VectorXd::Zero(rigid + elastic);
  values.tail(elastic) = modes.values;
  modes.values = std::move(values);
  modes.vectors.conservativeResize(Eigen::NoChange, rigid + elastic);
  for (Index j = rigid + elastic; j-- > rigid;) modes.vectors.col(j) = modes.vectors.col(j - rigid);
  modes.vectors.leftCols(rigid) = rigid_modes;
  return modes;
}

void fix_signs(MatrixXd& vectors) {
  for (auto shape : vectors.colwise()) {
    Index largest = 0;
    // The first of entries that are equal but for rounding, so that a symmetric shape does not depend on it.
    const double most = shape.cwiseAbs().maxCoeff();
    while (std::abs(shape[largest]) < (1.0 - same_value) * most) ++largest;
    if (shape[largest] < 0.0) shape = -shape;
  }
}

}  // namespace

LowestModes lowest_modes(const Matrix& stiffness, const Matrix& mass, const LowestModesOptions& options) {
  check(stiffness, mass, options);
  if (stiffness.rows() == 0) return lowest_modes(stiffness, mass, {SparseFactor(stiffness), 0.0}, options);
  return lowest_modes(stiffness, mass, factor_stiffness(stiffness, mass), options);
}

LowestModes lowest_modes(const Matrix& stiffness, const Matrix& mass, const StiffnessFactor& factored,
                         const LowestModesOptions& options) {
  check(stiffness, mass, options);
  const Index massive = (mass.diagonal().array() > 0.0).count();
  if (options.count.value_or(0) > massive)
    throw InvalidInput(std::to_string(*options.count) + " modes are requested of a model with mass at " +
                           std::to_string(massive) + " degrees of freedom",
                       "a model has no more modes than degrees of freedom with mass", "request fewer modes");
  if (massive == 0) return {VectorXd(0), MatrixXd(mass.rows(), 0), {}, 0};
  const Index rigid = factored.rigid_modes.cols();
  const bool most_of_all =
      3 * std::max(options.at_least, options.count.value_or(0)) >= massive && mass.rows() <= sturm_limit;
  const bool dense = massive <= dense_limit || most_of_all;
  if (rigid > 0 && (dense || options.count.value_or(rigid) < rigid)) return lowest_modes(stiffness, mass, options);
  LowestModesOptions elastic = options;
  if (options.count) elastic.count = *options.count - rigid;
  elastic.at_least = std::max<Index>(0, options.at_least - rigid);
  const Problem problem{stiffness, mass, factored, elastic};
  LowestModes modes = dense ? by_dense(problem) : behind(factored.rigid_modes, by_lanczos(problem));
  if (factored.shift > 0.0) clean_rigid_modes(stiffness, modes);
  fix_signs(modes.vectors);
  return modes;
}

}  // namespace kalfem
