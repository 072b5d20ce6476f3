// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <Eigen/Sparse>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace kalfem {

struct StiffnessFactor;

/// A sparse matrix by columns that is moved without a copy, which Eigen's own (3.4) is not: that of a large model has
/// gigabytes.
class SparseMatrix : public Eigen::SparseMatrix<double> {
public:
  using Base = Eigen::SparseMatrix<double>;
  using Base::Base;
  using Base::operator=;
  SparseMatrix() = default;
  ~SparseMatrix() = default;
  SparseMatrix(const SparseMatrix&) = default;
  SparseMatrix(const Base& other) : Base(other) {}
  SparseMatrix(SparseMatrix&& other) noexcept { swap(other); }
  SparseMatrix(Base&& other) noexcept { swap(other); }
  SparseMatrix& operator=(const SparseMatrix&) = default;
  SparseMatrix& operator=(SparseMatrix&& other) noexcept {
    swap(other);
    return *this;
  }
  SparseMatrix& operator=(Base&& other) noexcept {
    swap(other);
    return *this;
  }
};

/// Coefficients over the degrees of freedom of a model: a point's displacement is sum_i coefficient_i z_i.
using DofCombination = std::map<std::string, double>;

/// A linear spring-dashpot between a degree of freedom combination and a named moving ground.
struct GroundCoupling {
  std::string ground;
  Eigen::VectorXd stiffness;  ///< force on the model per ground displacement [N/m], n
  Eigen::VectorXd damping;    ///< force on the model per ground velocity [N s/m], n
};

/// Undamped free vibration K phi = omega^2 M phi with phi^T M phi = 1.
struct NormalModes {
  Eigen::VectorXd frequencies;  ///< [Hz], ascending; rigid-body modes are 0
  Eigen::MatrixXd shapes;       ///< n x modes, mass-normalised
};

/// Damping of some normal modes of a large model, C_m = M Phi diag(rates) Phi^T M: of low rank, never formed.
struct ModalDamping {
  NormalModes modes;      ///< of the model's own M and K
  Eigen::VectorXd rates;  ///< 2 zeta omega per mode [1/s]
};

/// C_m V = M Phi diag(rates) Phi^T M V for velocities V, n x k.
Eigen::MatrixXd damping_force(const ModalDamping& damping, const SparseMatrix& mass, const Eigen::MatrixXd& velocities);

/// 2 zeta omega [1/s] per mode for the given ratios (the last one holds for all further modes).
Eigen::VectorXd damping_rates(const Eigen::VectorXd& frequencies, const std::vector<double>& ratios);

/// M z'' + (C + C_m) z' + K z = sum_g (k_g r_g + c_g r_g'), a linear substructure with named degrees of freedom.
struct LinearModel {
  std::vector<std::string> dofs;
  SparseMatrix mass;           ///< [kg], n x n, symmetric
  SparseMatrix damping;        ///< [N s/m], n x n, symmetric; without C_m
  SparseMatrix stiffness;      ///< [N/m], n x n, symmetric
  ModalDamping modal_damping;  ///< C_m; empty where there is none
  std::vector<GroundCoupling> grounds;
  std::map<std::string, DofCombination> points;  ///< named combinations beside the degrees of freedom themselves
  bool points_only = false;  ///< the degrees of freedom are too many, or no places: only points are reported

  Eigen::VectorXd coordinate_scale;  ///< coordinate per displacement of a typical point: 1, or sqrt(mass) of a
                                     ///< mass-normalised mode; empty: all 1
  std::map<std::string, DofCombination> gauges = {};  ///< strains at named gauges, coefficients [1/m] or [1/rad]

  [[nodiscard]] Eigen::Index size() const { return static_cast<Eigen::Index>(dofs.size()); }
};

/// All modes of a model of moderate size by the dense generalised eigenproblem.
/// Throws InvalidInput where the mass matrix is not positive definite.
NormalModes normal_modes(const SparseMatrix& mass, const SparseMatrix& stiffness);

/// C = M Phi diag(2 zeta_i omega_i) Phi^T M for the given ratios, one a mode (the last one holds for all further
/// modes).
SparseMatrix modal_damping(const SparseMatrix& mass, const NormalModes& modes, const std::vector<double>& ratios);

/// Which modes get a damping ratio of their own: so many, or all up to a frequency, or both (whichever ends first).
struct ModalDampingOptions {
  std::optional<Eigen::Index> count = {};
  std::optional<double> up_to = {};  ///< [Hz]
  bool damp_the_rest = true;         ///< modes beyond the last one as well, see add_modal_damping
};

/// Adds damping by ratios to a large model: its lowest modes, of its own M and K, get the rates
///     phi_i^T C phi_i = 2 zeta_i omega_i [1/s],
/// the last ratio holding for all further modes, as the low-rank C_m = M Phi diag(rates) Phi^T M of the model.
///
/// Modes beyond the p computed ones would be undamped. They get the rate of the last one, alpha = 2 zeta_p omega_p, by
/// C += alpha M, which is taken off again from the stored rates: the computed modes keep theirs, rigid-body modes none
/// at all (their stored rate is -alpha). The ratio above omega_p so falls as omega_p / omega.
/// Damping that the model has already stays. Throws InvalidInput where a ratio is negative or not finite, where neither
/// a number nor a frequency is given, or the model has modal damping already.
/// `factor`: of the model's K, where it is at hand.
void add_modal_damping(LinearModel& model, const std::vector<double>& ratios, const ModalDampingOptions& options,
                       const StiffnessFactor* factor = nullptr);

/// Which of the normal modes are wanted, from the lowest on.
struct NormalModesRange {
  Eigen::Index count = 0;            ///< fewer where the model has no more
  std::optional<double> up_to = {};  ///< [Hz]: fewer where they end there
  Eigen::Index at_least = 0;         ///< of the count, whatever their frequency
};

/// The model's lowest normal modes. They are not computed where the modal damping knows them already. `factor`: of the
/// model's K, where it is at hand.
NormalModes lowest_normal_modes(const LinearModel& model, const NormalModesRange& range,
                                const StiffnessFactor* factor = nullptr);

}  // namespace kalfem
