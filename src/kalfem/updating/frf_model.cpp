// SPDX-License-Identifier: Apache-2.0
#include "kalfem/updating/frf_model.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

namespace {

constexpr double difference_step = 1e-4;  ///< of a parameter, for the derivatives of ground loads
constexpr double no_coupling = 1e-14;     ///< off-diagonal damping against the diagonal's two entries

MatrixXd projected(const MatrixXd& shapes, const SparseMatrix& matrix) {
  if (matrix.nonZeros() == 0) return {};
  return shapes.transpose() * (matrix * shapes);
}

/// V^T (C + C_m) V; that of the ratios is given as its diagonal.
MatrixXd reduced_damping(const ResponseBasis& basis, const LinearModel& model, const VectorXd& rates) {
  const MatrixXd& shapes = basis.shapes;
  MatrixXd damping = shapes.transpose() * (model.damping * shapes);
  damping += shapes.transpose() * damping_force(model.modal_damping, model.mass, shapes);
  damping.diagonal() += rates;
  return damping;
}

bool is_diagonal(const MatrixXd& matrix) {
  for (Index j = 0; j < matrix.cols(); ++j)
    for (Index i = 0; i < j; ++i)
      if (std::abs(matrix(i, j)) > no_coupling * (std::abs(matrix(i, i)) + std::abs(matrix(j, j)))) return false;
  return true;
}

/// Amplitudes of the basis in which the structure follows a slow motion with these loads: they do not strain it, so
/// damping by ratios does not act on them.
VectorXd static_amplitudes(const ResponseBasis& basis, const VectorXd& load) {
  return (basis.stiffness.array() > 0.0).select(load.array() / basis.stiffness.array(), 0.0);
}

FrfEvaluation::Derivative reduced(const ResponseBasis& basis, const ModelDerivative& derivative,
                                  const ModalRatios& ratios) {
  FrfEvaluation::Derivative reduced{projected(basis.shapes, derivative.stiffness),
                                    projected(basis.shapes, derivative.mass),
                                    projected(basis.shapes, derivative.damping),
                                    {}};
  if (ratios.empty() || derivative.is_zero()) return reduced;
  reduced.modal_damping =
      modal_damping_derivative(basis, ratios, derivative.modal_ratios, reduced.stiffness, reduced.mass);
  if (reduced.damping.size() == 0) reduced.damping = MatrixXd::Zero(basis.size(), basis.size());
  reduced.damping += reduced.modal_damping;
  return reduced;
}

}  // namespace

// How FRFs are evaluated (equations in the header):
//   1. evaluate(): a basis V that spans the response up to the highest line (modes and static answers to the loads and
//      outputs), and everything reduced once: V^T C V with modal damping, V^T f, S V, and V^T dK V ... a parameter.
//   2. at(): per line only Z = V^T (K + s C + s^2 M) V is formed; in the basis K and M are diagonal, and so is Z where
//      damping is. One solve gives H, and with the outputs as further right-hand sides the adjoint answers.
//   3. dH needs no further solve: adjoint answers times (df - dZ V Z^-1 V^T f).
//   4. Loads of a moving ground depend on the parameters too; those derivatives are central differences.
MatrixXcd FrfEvaluation::solved(Complex s, MatrixXcd columns) const {
  const VectorXcd undamped = basis.stiffness + s * s * basis.mass;
  if (diagonal) return (undamped + s * damping.diagonal()).cwiseInverse().asDiagonal() * columns;
  MatrixXcd impedance = s * damping;
  impedance.diagonal() += undamped;
  return impedance.partialPivLu().solve(columns);
}

VectorXcd FrfEvaluation::load(std::size_t index, Complex s) const {
  return sets[index].load.constant + s * sets[index].load.per_s;
}

MatrixXcd FrfEvaluation::transfer(std::size_t index, Complex s) const {
  return std::pow(s, sets[index].order) * solved(s, sets[index].outputs.transpose().cast<Complex>()).transpose();
}

MatrixXcd FrfEvaluation::answers_to(std::size_t index, Complex s, const VectorXcd& load) const {
  MatrixXcd columns(basis.size(), 1 + sets[index].outputs.rows());
  columns << load, sets[index].outputs.transpose().cast<Complex>();
  return solved(s, std::move(columns));
}

// Z is symmetric, so the adjoint answers Z^-1 V^T S^T are the transfer's transpose.
MatrixXcd FrfEvaluation::derivatives_from(std::size_t index, Complex s, Complex input, const MatrixXcd& answers) const {
  const Set& set = sets[index];
  const auto answer = answers.col(0);
  const auto adjoint = answers.rightCols(answers.cols() - 1);
  MatrixXcd all(adjoint.cols(), static_cast<Index>(derivatives.size()));
  for (std::size_t p = 0; p < derivatives.size(); ++p) {
    const auto& [stiffness, mass, change_of_damping, modal] = derivatives[p];
    VectorXcd change = VectorXcd::Zero(answer.size());
    if (!set.load_derivatives.empty())
      change = input * (set.load_derivatives[p].constant + s * set.load_derivatives[p].per_s);
    if (stiffness.size() > 0) change -= stiffness * answer;
    if (change_of_damping.size() > 0) change -= s * (change_of_damping * answer);
    if (mass.size() > 0) change -= s * s * (mass * answer);
    all.col(static_cast<Index>(p)) = adjoint.transpose() * change;
  }
  return std::pow(s, set.order) * all;
}

MatrixXcd FrfEvaluation::derivatives_under(std::size_t index, Complex s, Complex input, const VectorXcd& held) const {
  return derivatives_from(index, s, input, answers_to(index, s, input * load(index, s) + held));
}

FrfLine FrfEvaluation::at(std::size_t index, Complex s) const {
  const Complex factor = std::pow(s, sets[index].order);
  if (derivatives.empty()) return {factor * (sets[index].outputs * solved(s, load(index, s))), {}};
  const MatrixXcd answers = answers_to(index, s, load(index, s));
  return {factor * (sets[index].outputs * answers.col(0)), derivatives_from(index, s, 1.0, answers)};
}

bool FrfEvaluation::is_singular(Complex s) const {
  constexpr double rounding = 1e-13;
  const Eigen::ArrayXcd impedance = basis.stiffness + s * s * basis.mass + s * damping.diagonal();
  const Eigen::ArrayXd forces = basis.stiffness.array().abs() + std::norm(s) * basis.mass.array();
  return (impedance.abs() <= rounding * forces).any();
}

FrfModel::FrfModel(std::shared_ptr<const ParameterisedModel> model, std::vector<FrfSet> sets, double highest,
                   const VectorXd& parameters, const ResponseBasisOptions& options)
    : model_(std::move(model)), sets_(std::move(sets)), highest_(highest), options_(options) {
  const LinearModel at = model_->at(parameters).model;
  IssueList issues;
  for (const auto& set : sets_) places_.push_back(places_of(set, at, issues));
  issues.raise();
}

/// Loads and outputs whose static answers the basis is to hold, n x columns.
MatrixXd FrfModel::places(const LinearModel& model) const {
  Index columns = 0;
  for (const auto& each : places_) columns += each.outputs.cols() + (each.force.size() > 0 ? 1 : 2);
  MatrixXd places(model.size(), columns);
  Index next = 0;
  const auto add = [&](const auto& block) {
    places.middleCols(next, block.cols()) = block;
    next += block.cols();
  };
  for (std::size_t i = 0; i < sets_.size(); ++i) {
    add(places_[i].outputs);
    if (places_[i].force.size() > 0) {
      add(places_[i].force);
      continue;
    }
    const GroundCoupling& ground = ground_of(model, sets_[i].place);
    add(ground.stiffness);
    add(ground.damping);
  }
  return places;
}

/// Of a moving ground the load is k_g + s c_g, and the modal damping sees the motion relative to the ground: the rates
/// times the amplitudes of the motion that the ground carries along without strain.
FrfEvaluation::Set FrfModel::reduced_set(std::size_t index, const LinearModel& model, const ResponseBasis& basis,
                                         const VectorXd& rates) const {
  FrfEvaluation::Set set{.load = {},
                         .load_derivatives = {},
                         .outputs = places_[index].outputs.transpose() * basis.shapes,
                         .order = derivative_order(sets_[index])};
  if (places_[index].force.size() > 0) {
    set.load = {basis.shapes.transpose() * places_[index].force, VectorXd::Zero(basis.size())};
    return set;
  }
  const GroundCoupling& ground = ground_of(model, sets_[index].place);
  set.load.constant = basis.shapes.transpose() * ground.stiffness;
  set.load.per_s =
      basis.shapes.transpose() * ground.damping + rates.cwiseProduct(static_amplitudes(basis, set.load.constant));
  return set;
}

FrfEvaluation FrfModel::evaluate(const VectorXd& parameters, bool with_derivatives) const {
  const auto [model, ratios] = model_->at(parameters);
  FrfEvaluation evaluation;
  evaluation.basis = response_basis(model, places(model), highest_, options_);
  const ResponseBasis& basis = evaluation.basis;
  const VectorXd rates = modal_damping_rates(basis, ratios);
  evaluation.damping = reduced_damping(basis, model, rates);
  evaluation.diagonal = is_diagonal(evaluation.damping);
  for (std::size_t i = 0; i < sets_.size(); ++i) evaluation.sets.push_back(reduced_set(i, model, basis, rates));
  if (!with_derivatives) return evaluation;
  for (const ModelDerivative& derivative : model_->derivatives(parameters))
    evaluation.derivatives.push_back(reduced(basis, derivative, ratios));
  if (std::ranges::any_of(sets_, [](const FrfSet& set) { return set.input != FrfInput::force; }))
    add_load_derivatives(evaluation, parameters, rates);
  return evaluation;
}

// Of a ground's load only k_g and c_g depend on a parameter, which the model gives as values: central differences of
// these vectors serve, as they are affine or nearly so. What follows from them in the basis is differentiated exactly.
void FrfModel::add_load_derivatives(FrfEvaluation& evaluation, const VectorXd& parameters,
                                    const VectorXd& rates) const {
  const ResponseBasis& basis = evaluation.basis;
  for (Index p = 0; p < parameters.size(); ++p) {
    const double step = difference_step * (parameters[p] == 0.0 ? 1.0 : std::abs(parameters[p]));
    const auto& derivative = evaluation.derivatives[static_cast<std::size_t>(p)];
    VectorXd above = parameters, below = parameters;
    above[p] += step;
    below[p] -= step;
    const bool moves = derivative.stiffness.size() > 0 || derivative.damping.size() > 0;
    const LinearModel model_above = model_->at(moves ? above : parameters).model;
    const LinearModel model_below = model_->at(moves ? below : parameters).model;
    for (std::size_t i = 0; i < sets_.size(); ++i) {
      if (places_[i].force.size() > 0) continue;
      const GroundCoupling &high = ground_of(model_above, sets_[i].place),
                           &low = ground_of(model_below, sets_[i].place);
      FrfEvaluation::Set& set = evaluation.sets[i];
      FrfEvaluation::Load load{basis.shapes.transpose() * (high.stiffness - low.stiffness) / (2.0 * step),
                               basis.shapes.transpose() * (high.damping - low.damping) / (2.0 * step)};
      const VectorXd amplitudes = static_amplitudes(basis, set.load.constant);
      VectorXd change = load.constant;
      if (derivative.stiffness.size() > 0) change -= derivative.stiffness * amplitudes;
      load.per_s += rates.cwiseProduct(static_amplitudes(basis, change));
      if (derivative.modal_damping.size() > 0) load.per_s += derivative.modal_damping * amplitudes;
      set.load_derivatives.push_back(std::move(load));
    }
  }
}

}  // namespace kalfem
