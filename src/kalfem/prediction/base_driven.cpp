// SPDX-License-Identifier: Apache-2.0
#include "kalfem/prediction/base_driven.hpp"

#include <algorithm>
#include <cmath>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/dynamics/simulate.hpp"
#include "kalfem/linalg/sparse_factor.hpp"
#include "kalfem/linalg/sparse_operations.hpp"
#include "kalfem/reduction/interior_statics.hpp"
#include "kalfem/reduction/mode_selection.hpp"

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Value, rate and acceleration that were sampled together, straight between the samples.
class SampledMotion final : public Signal {
public:
  SampledMotion(double start, double sample_rate, SignalSamples samples)
      : start_(start), sample_rate_(sample_rate), samples_(std::move(samples)) {}

  [[nodiscard]] SignalSamples sample(double start, double step, Index count) const override {
    SignalSamples result(count, 3);
    for (Index k = 0; k < count; ++k) {
      const double position = (start + static_cast<double>(k) * step - start_) * sample_rate_;
      const Index before = std::clamp<Index>(static_cast<Index>(std::floor(position + 1e-9)), 0, samples_.rows() - 2);
      const double weight = std::clamp(position - static_cast<double>(before), 0.0, 1.0);
      result.row(k) = (1.0 - weight) * samples_.row(before) + weight * samples_.row(before + 1);
    }
    return result;
  }

private:
  double start_, sample_rate_;
  SignalSamples samples_;
};

/// Throws where the interior has rigid-body modes while the boundary is held.
void require_held(const MatrixXd& rigid_modes, const std::vector<std::string>& dofs) {
  if (rigid_modes.cols() == 0) return;
  Index free = 0;
  rigid_modes.col(0).cwiseAbs().maxCoeff(&free);
  throw InvalidInput(
      "with its boundary fixed, the substructure still moves freely at '" + dofs[static_cast<std::size_t>(free)] + "'",
      "the boundary does not determine its motion", "connect every part to the boundary by springs");
}

std::vector<std::string> names_of(const LinearModel& model, const std::vector<Index>& dofs) {
  std::vector<std::string> names;
  for (const Index i : dofs) names.push_back(model.dofs[static_cast<std::size_t>(i)]);
  return names;
}

/// The modal damping C_m of the whole on the interior alone, M_ii Phi' diag(rates) Phi'^T M_ii with M_ii Phi' = (M
/// Phi)_i.
ModalDamping interior_damping(const LinearModel& model, const SparseMatrix& interior_mass,
                              const std::vector<Index>& interior) {
  if (model.modal_damping.rates.size() == 0) return {};
  const MatrixXd mass_weighted_modes = model.mass * model.modal_damping.modes.shapes;
  return {{model.modal_damping.modes.frequencies,
           SparseFactor(interior_mass).solve(mass_weighted_modes(interior, Eigen::all))},
          model.modal_damping.rates};
}

VectorXd interior_part(const VectorXd& vector, const std::vector<Index>& interior) {
  return vector.size() == 0 ? VectorXd::Zero(static_cast<Index>(interior.size())) : VectorXd(vector(interior));
}

}  // namespace

// The interior i of a substructure whose boundary b moves in a known way. With the constraint modes
// Psi = -K_ii^-1 K_ib [CB68] the motion is split into what rides on the boundary and a remainder,
//     z_i = Psi z_b + q,
// and the remainder obeys, since K_ii Psi + K_ib = 0,
//     M_ii q'' + C_ii q' + K_ii q = f_i - (M [Psi; 1])_i z_b'' - (C [Psi; 1])_i z_b' - C_o,i z_o',
// with z_o points outside that act through the damping of the whole structure's modes. Steps:
//   1. factor K_ii (a free interior is refused) and solve for Psi;
//   2. make the linear system in q, with one input a boundary degree of freedom and a point outside;
//   3. predict(): q starts from what is known of z_i less Psi z_b and is simulated; small systems step exactly, large
//      ones by generalised-alpha in substeps of the sample interval.
BaseDrivenSubstructure::BaseDrivenSubstructure(const LinearModel& model, std::vector<Index> boundary,
                                               const MatrixXd& cross_damping)
    : boundary_(std::move(boundary)) {
  const Partition parts = partition(model, names_of(model, boundary_));
  interior_ = parts.interior;
  if (boundary_.empty() || interior_.empty())
    throw InvalidInput(
        boundary_.empty() ? "no connector is attached to the predicted substructure"
                          : "the predicted substructure has no degree of freedom other than those of its connectors",
        "the prediction drives the interior by the motion of the boundary", "predict another substructure");
  const StiffnessFactor factored = factor_stiffness(parts.stiffness_ii, parts.mass_ii, parts.interior_names);
  const MatrixXd rigid_modes = rigid_body_modes(parts, factored);
  require_held(rigid_modes, parts.interior_names);
  driven_.dofs = parts.interior_names;
  driven_.mass = parts.mass_ii;
  driven_.damping = select(model.damping, interior_, interior_);
  driven_.stiffness = parts.stiffness_ii;
  driven_.modal_damping = interior_damping(model, driven_.mass, interior_);

  const auto n_b = static_cast<Index>(boundary_.size());
  shapes_ = MatrixXd::Zero(model.size(), n_b);
  shapes_(interior_, Eigen::all) = InteriorStatics(parts, factored, rigid_modes).constraint_modes()->take();
  shapes_(boundary_, Eigen::all).setIdentity();
  const MatrixXd inertia = model.mass * shapes_,
                 damping = model.damping * shapes_ + damping_force(model.modal_damping, model.mass, shapes_);
  for (Index b = 0; b < n_b; ++b)
    driven_.inputs.push_back({model.dofs[static_cast<std::size_t>(boundary_[static_cast<std::size_t>(b)])], "m",
                              VectorXd::Zero(driven_.size()), -damping.col(b)(interior_), -inertia.col(b)(interior_)});
  const VectorXd none = VectorXd::Zero(driven_.size());
  for (Index o = 0; o < cross_damping.cols(); ++o)
    driven_.inputs.push_back({"outside " + std::to_string(o + 1), "m", none, -cross_damping.col(o)(interior_), none});
}

/// Rows S of all degrees of freedom as S_i q + S [Psi; 1] z_b.
OutputMap BaseDrivenSubstructure::outputs(const SparseRows& points, Index inputs) const {
  const Index k = points.rows(), n_b = static_cast<Index>(boundary_.size());
  const SparseRows none(3 * k, driven_.size());
  const MatrixXd no_input = MatrixXd::Zero(3 * k, inputs);
  OutputMap map{std::vector<std::string>(static_cast<std::size_t>(3 * k)),
                std::vector<std::string>(static_cast<std::size_t>(3 * k)),
                none,
                none,
                none,
                no_input,
                no_input,
                no_input,
                MatrixXd(3 * k, 0)};
  std::vector<Index> position(static_cast<std::size_t>(points.cols()), -1);
  for (std::size_t i = 0; i < interior_.size(); ++i)
    position[static_cast<std::size_t>(interior_[i])] = static_cast<Index>(i);
  const MatrixXd ridden = points * shapes_;
  Index first = 0;
  for (auto [rows, input] : {std::pair{&map.displacement, &map.input_value}, std::pair{&map.velocity, &map.input_rate},
                             std::pair{&map.acceleration, &map.input_acceleration}}) {
    std::vector<Eigen::Triplet<double>> entries;
    for (Index row = 0; row < k; ++row)
      for (SparseRows::InnerIterator it(points, row); it; ++it)
        if (const Index i = position[static_cast<std::size_t>(it.col())]; i >= 0)
          entries.emplace_back(first + row, i, it.value());
    rows->setFromTriplets(entries.begin(), entries.end());
    input->block(first, 0, k, n_b) = ridden;
    first += k;
  }
  return map;
}

PredictedMotion BaseDrivenSubstructure::predict(const SparseRows& points, const BoundaryMotion& boundary,
                                                const std::vector<AppliedInput>& applied, const PredictionStart& start,
                                                const PredictionOptions& options) const {
  const auto n_b = static_cast<Index>(boundary_.size());
  LocallyNonlinearSystem driven = driven_;
  std::vector<SignalPtr> signals;
  for (Index b = 0; b < driven.input_count(); ++b) {
    SignalSamples samples(boundary.acceleration.cols(), 3);
    samples << boundary.displacement.row(b).transpose().array(), boundary.velocity.row(b).transpose().array(),
        boundary.acceleration.row(b).transpose().array();
    signals.push_back(std::make_shared<SampledMotion>(0.0, options.sample_rate, std::move(samples)));
  }
  for (const auto& [input, signal] : applied) {
    driven.inputs.push_back({input.name, input.unit, interior_part(input.value, interior_),
                             interior_part(input.rate, interior_), interior_part(input.acceleration, interior_)});
    signals.push_back(delayed(signal, -start.time));
  }
  InitialState relative = at_rest(driven.size(), 0);
  if (start.displacement.size() > 0)
    relative.displacement =
        start.displacement(interior_) - shapes_(interior_, Eigen::all) * boundary.displacement.col(0).head(n_b);
  if (start.velocity.size() > 0)
    relative.velocity = start.velocity(interior_) - shapes_(interior_, Eigen::all) * boundary.velocity.col(0).head(n_b);

  const bool exact = driven.size() <= options.exact_up_to;
  const Index substeps = exact ? 1 : options.newmark_substeps, samples = boundary.acceleration.cols();
  SimulationOptions simulation;
  simulation.integrator = exact ? Integrator::exact : Integrator::generalized_alpha;
  simulation.step = 1.0 / (options.sample_rate * static_cast<double>(substeps));
  simulation.duration = static_cast<double>(samples - 1) / options.sample_rate;
  simulation.keep_every = substeps;
  simulation.keep_motion = false;
  simulation.every_sample = outputs(points, driven.input_count());
  simulation.progress = options.progress;
  const MatrixXd motion = simulate(driven, signals, relative, simulation).every_sample;
  const Index k = points.rows();
  return {motion.topRows(k), motion.middleRows(k, k), motion.bottomRows(k)};
}

}  // namespace kalfem
