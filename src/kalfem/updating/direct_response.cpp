// SPDX-License-Identifier: Apache-2.0
#include "kalfem/updating/direct_response.hpp"

#include <cmath>
#include <complex>
#include <numbers>

#include "kalfem/base/interruption.hpp"
#include "kalfem/base/invalid_input.hpp"
#include "kalfem/linalg/complex_factor.hpp"

namespace kalfem {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

/// Of the elastic and inertia forces, that the loads are at least: below it, fewer than three digits of the answer are
/// right.
constexpr double least_balance = 1e-13;

/// [A B; C D] in 64-bit indices.
ComplexSparseMatrix bordered(const SparseMatrix& a, const MatrixXd& b, const MatrixXd& c, const VectorXd& d) {
  const Index size = a.rows(), border = d.size();
  std::vector<Eigen::Triplet<Complex, std::int64_t>> entries;
  entries.reserve(static_cast<std::size_t>(a.nonZeros() + b.size() + c.size() + border));
  for (Index j = 0; j < size; ++j)
    for (SparseMatrix::InnerIterator it(a, j); it; ++it) entries.emplace_back(it.row(), j, it.value());
  for (Index j = 0; j < border; ++j) {
    for (Index i = 0; i < size; ++i) {
      entries.emplace_back(i, size + j, b(i, j));
      entries.emplace_back(size + j, i, c(j, i));
    }
    entries.emplace_back(size + j, size + j, d[j]);
  }
  ComplexSparseMatrix matrix(size + border, size + border);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

// The modal damping C_m = M Phi diag(g) Phi^T M is full, but of low rank. With the amplitudes' rates a = diag(g) Phi^T
// M z as further unknowns the equations stay sparse but for a border of as many columns as there are damped modes:
//     [ K + s C + s^2 M   s M Phi diag(g) ] [ z ]   [ f_0 + s f_1 ]
//     [ Phi^T M           -1              ] [ a ] = [ 0           ].
/// The dynamic stiffness of a model with this border.
class DynamicStiffness {
public:
  explicit DynamicStiffness(const LinearModel& model) {
    const auto& [modes, rates] = model.modal_damping;
    const Index size = model.size(), border = rates.size();
    const MatrixXd weighted = border > 0 ? MatrixXd(model.mass * modes.shapes) : MatrixXd(size, 0);
    const MatrixXd none = MatrixXd::Zero(size, border);
    const VectorXd zeros = VectorXd::Zero(border);
    stiffness_ = bordered(model.stiffness, none, weighted.transpose(), -VectorXd::Ones(border));
    damping_ = bordered(model.damping, weighted * rates.asDiagonal(), none.transpose(), zeros);
    mass_ = bordered(model.mass, none, none.transpose(), zeros);
  }

  [[nodiscard]] ComplexSparseMatrix at(Complex s) const { return stiffness_ + s * damping_ + (s * s) * mass_; }
  [[nodiscard]] Index size() const { return stiffness_.rows(); }

  /// Whether the loads are what is left of elastic and inertia forces that cancel: the frequency is one of an undamped
  /// resonance to rounding.
  [[nodiscard]] bool cancels(const MatrixXcd& answers, const MatrixXcd& loads, Complex s) const {
    const MatrixXd size = answers.cwiseAbs();
    const MatrixXd forces = stiffness_.cwiseAbs() * size + std::norm(s) * (mass_.cwiseAbs() * size);
    return !(loads.colwise().norm().array() >= least_balance * forces.colwise().norm().array()).all();
  }

private:
  ComplexSparseMatrix stiffness_, damping_, mass_;
};

/// Unit inputs f_0 and f_1, one column a set.
struct Loads {
  MatrixXd constant, per_s;

  Loads(const LinearModel& model, const std::vector<FrfSet>& sets, const std::vector<FrfPlaces>& places, Index rows) {
    constant = per_s = MatrixXd::Zero(rows, std::ssize(sets));
    for (std::size_t i = 0; i < sets.size(); ++i) {
      const auto column = static_cast<Index>(i);
      if (sets[i].input == FrfInput::force) {
        constant.col(column).head(model.size()) = places[i].force;
        continue;
      }
      const GroundCoupling& ground = ground_of(model, sets[i].place);
      constant.col(column).head(model.size()) = ground.stiffness;
      per_s.col(column).head(model.size()) = ground.damping;
    }
  }

  [[nodiscard]] MatrixXcd at(Complex s) const { return constant + s * per_s; }
};

}  // namespace

std::vector<MatrixXcd> direct_responses(const LinearModel& model, const std::vector<FrfSet>& sets,
                                        const VectorXd& frequencies, const Progress& progress) {
  IssueList issues;
  std::vector<FrfPlaces> places;
  for (const auto& set : sets) places.push_back(places_of(set, model, issues));
  issues.raise();

  const DynamicStiffness stiffness(model);
  const Loads loads(model, sets, places, stiffness.size());
  ComplexFactor factor(stiffness.at(Complex(0.0, 1.0)));
  std::vector<MatrixXcd> responses;
  for (const auto& set : sets) responses.emplace_back(frequencies.size(), std::ssize(set.outputs));
  for (Index line = 0; line < frequencies.size(); ++line) {
    stop_if_asked();
    if (progress)
      progress("line " + std::to_string(line + 1) + " of " + std::to_string(frequencies.size()),
               static_cast<double>(line) / static_cast<double>(frequencies.size()));
    const Complex s(0.0, 2.0 * std::numbers::pi * frequencies[line]);
    const ComplexSparseMatrix matrix = stiffness.at(s);
    const MatrixXcd load = loads.at(s);
    if (!factor.factor(matrix)) throw singular_at(frequencies[line]);
    const MatrixXcd answers = factor.solve(load);
    if (stiffness.cancels(answers, load, s)) throw singular_at(frequencies[line]);
    for (std::size_t i = 0; i < sets.size(); ++i)
      responses[i].row(line) = (std::pow(s, derivative_order(sets[i])) *
                                (places[i].outputs.transpose() * answers.col(static_cast<Index>(i)).head(model.size())))
                                   .transpose();
  }
  return responses;
}

}  // namespace kalfem
