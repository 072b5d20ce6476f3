#include "kalfem/model/linear_model.hpp"

#include <algorithm>
#include <numbers>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {

NormalModes normal_modes(const SparseMatrix& mass, const SparseMatrix& stiffness) {
  const Eigen::MatrixXd dense_mass(mass);
  if (Eigen::LLT<Eigen::MatrixXd>(dense_mass).info() != Eigen::Success)
    throw InvalidInput("the mass matrix is not positive definite", "modes need a mass at every degree of freedom",
                       "give every degree of freedom a mass");
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(Eigen::MatrixXd(stiffness), dense_mass);
  NormalModes modes{solver.eigenvalues().cwiseMax(0.0).cwiseSqrt(), solver.eigenvectors()};
  // Rounding leaves rigid-body modes at sqrt(eps) of the highest frequency: they are zero.
  const double threshold = 1e-7 * modes.frequencies.maxCoeff();
  modes.frequencies = (modes.frequencies.array() < threshold).select(0.0, modes.frequencies) / (2.0 * std::numbers::pi);
  return modes;
}

Eigen::MatrixXd damping_force(const ModalDamping& damping, const SparseMatrix& mass,
                              const Eigen::MatrixXd& velocities) {
  const auto& [modes, rates] = damping;
  if (rates.size() == 0) return Eigen::MatrixXd::Zero(velocities.rows(), velocities.cols());
  const Eigen::MatrixXd amplitudes = modes.shapes.transpose() * (mass * velocities);
  return mass * (modes.shapes * (rates.asDiagonal() * amplitudes));
}

Eigen::VectorXd damping_rates(const Eigen::VectorXd& frequencies, const std::vector<double>& ratios) {
  Eigen::VectorXd rates = 4.0 * std::numbers::pi * frequencies;
  for (Eigen::Index i = 0; i < rates.size(); ++i)
    rates[i] *= ratios[std::min<std::size_t>(static_cast<std::size_t>(i), ratios.size() - 1)];
  return rates;
}

SparseMatrix modal_damping(const SparseMatrix& mass, const NormalModes& modes, const std::vector<double>& ratios) {
  if (ratios.empty()) return SparseMatrix(mass.rows(), mass.cols());
  const ModalDamping damping{modes, damping_rates(modes.frequencies, ratios)};
  return damping_force(damping, mass, Eigen::MatrixXd::Identity(mass.rows(), mass.cols())).sparseView();
}

}  // namespace kalfem
