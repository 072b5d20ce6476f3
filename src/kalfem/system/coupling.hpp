// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/system/locally_nonlinear_system.hpp"

namespace kalfem {

/// Damping of the modes of a whole structure, as it stands on its connectors.
struct GlobalModalDamping {
  std::vector<double> ratios;     ///< ratio to critical per mode; the last one holds for all further modes
  std::optional<double> up_to{};  ///< modes up to here have their own ratio, see add_modal_damping() [Hz]; empty: all
};

/// df/dd of a law where nothing moves [N/m]; not finite where it has no stiffness there.
double stiffness_at_rest(const ConnectorLaw& law, const Eigen::VectorXd& parameters);

/// K with every connector as stiff as at rest, K + sum_j (df_j/dd_j)(0) b_j b_j^T.
SparseMatrix stiffness_at_rest(const LocallyNonlinearSystem& system);

/// Adds C_m = M Phi diag(2 zeta omega) Phi^T M of the modes of M and stiffness_at_rest(). It acts on the motion
/// relative to that with which the structure at rest follows its slowly moving grounds r_i,
///     C_m (z' - sum_i s_i r_i'),    (K + sum_j k_j b_j b_j^T) s_i = p_i + sum_j k_j b_j g_ji,
/// so that a structure that moves with its grounds is not damped.
/// `grounds`: which inputs are displacements of grounds. Throws InvalidInput for unsuitable ratios, where the system
/// has modal damping already, and where a connector is not elastic at rest.
void add_global_modal_damping(LocallyNonlinearSystem& system, const GlobalModalDamping& damping,
                              const std::vector<Eigen::Index>& grounds);

/// A linear substructure under the name that qualifies its points: "wheel.w".
struct Substructure {
  Substructure(std::string name_, LinearModel model_)
      : Substructure(std::move(name_), std::make_shared<const LinearModel>(std::move(model_))) {}
  Substructure(std::string name_, std::shared_ptr<const LinearModel> model_)
      : name(std::move(name_)), model(std::move(model_)) {}

  std::string name;
  std::shared_ptr<const LinearModel> model;  ///< shared by all that hold it: a full model is large
};

/// The fixed ground, which belongs to no substructure: a connector may end there.
inline const std::string fixed_ground = "ground";

/// A connector as the user describes it: a law between two qualified points, or one and the fixed ground.
struct ConnectorDescription {
  std::string name;
  std::string from;
  std::string to;
  ConnectorLawPtr law;
  Eigen::VectorXd parameters;
  SourceLocation location = {};  ///< where the user describes it, for messages
};

/// What an input does to the structure.
enum class InputKind {
  base_displacement,  ///< moves grounds in absolute coordinates, through what touches them
  base_acceleration,  ///< accelerates all grounds alike; displacements are then relative to them
  force               ///< acts at the point `target`
};

/// SI unit of an input's value: "m", "m/s^2" or "N".
std::string unit_of(InputKind kind);

struct InputDescription {
  std::string name;
  InputKind kind = InputKind::force;
  std::string target;             ///< qualified point; for base_acceleration the direction below counts instead
  DofCombination direction = {};  ///< base_acceleration: rigid motion per unit, by qualified DOF (empty: all 1);
                                  ///< base_displacement: motion of each ground per unit (empty: `target` by 1)
  SourceLocation location = {};   ///< where the user describes it, for messages
};

/// Two degrees of freedom of different substructures that move as one, by qualified names: "left.n4.x", "right.n9.x".
struct SharedDof {
  std::string first, second;
};

/// Displacement of a point, z_p = dofs^T z + base^T r.
struct PointMotion {
  Eigen::VectorXd dofs;  ///< n
  Eigen::VectorXd base;  ///< n_u
};

/// Everything that joins: substructures, connectors between their points, and inputs. The system and the names of its
/// points in one, so that sensors can be placed.
class CoupledModel {
public:
  /// `damping`: of the whole structure's modes, where no substructure has modal damping of its own.
  /// `shared`: degrees of freedom that become one coordinate (primal assembly). A substructure with a shared one must
  /// not have modal damping of low rank: its own modes are none of the assembled structure.
  /// Throws InvalidInput with every unknown point, doubled name or unsuitable parameter found.
  CoupledModel(std::vector<Substructure> substructures, const std::vector<ConnectorDescription>& connectors,
               const std::vector<InputDescription>& inputs, const std::optional<GlobalModalDamping>& damping = {},
               const std::vector<SharedDof>& shared = {});

  [[nodiscard]] const LocallyNonlinearSystem& system() const { return system_; }
  [[nodiscard]] const std::vector<Substructure>& substructures() const { return substructures_; }
  /// Motion of the qualified point; throws InvalidInput (with the nearest name) when there is none.
  [[nodiscard]] PointMotion motion(const std::string& point) const;
  /// Qualified points whose motion is reported: every degree of freedom of lumped substructures, and all named points.
  [[nodiscard]] std::vector<std::string> reported_points() const;
  /// All names that motion() knows.
  [[nodiscard]] std::vector<std::string> point_names() const;
  /// Coefficients of the strain at a qualified gauge over all degrees of freedom, n [1/m]; throws InvalidInput (with
  /// the nearest name) when there is none.
  [[nodiscard]] Eigen::VectorXd strain(const std::string& gauge) const;
  /// All qualified strain gauges.
  [[nodiscard]] std::vector<std::string> gauges() const;
  /// A substructure and the places of its degrees of freedom in the system; throws InvalidInput when there is none.
  struct Placed {
    const Substructure& part;
    const std::vector<Eigen::Index>& dofs;
  };
  [[nodiscard]] Placed find_substructure(const std::string& name) const;
  /// Whether damping is of the whole structure's modes.
  [[nodiscard]] bool global_modal_damping() const { return global_modal_damping_; }
  /// Index of a degree of freedom, -1 when there is none. A shared one has several names.
  [[nodiscard]] Eigen::Index dof_index(const std::string& dof) const;
  /// Coordinate per displacement of a typical point, n (LinearModel::scale).
  [[nodiscard]] const Eigen::VectorXd& coordinate_scale() const { return coordinate_scale_; }
  /// Direction of the uniform base acceleration per input, n x n_u (zero columns for other inputs): absolute = relative
  /// + this.
  [[nodiscard]] const Eigen::MatrixXd& base_accelerations() const { return base_accelerations_; }

private:
  void number_dofs(const std::vector<SharedDof>& shared);
  [[nodiscard]] Eigen::Index existing_dof(const std::string& name) const;
  void require_own_modes(const std::vector<SharedDof>& shared, IssueList& issues) const;
  void assemble_linear_part();
  void add_input(const InputDescription& description, std::size_t index);
  void add_ground_load(const std::string& ground, double weight, Input& input) const;
  void require_translation(const InputDescription& description) const;
  void add_connector(const ConnectorDescription& description, IssueList& issues);
  [[nodiscard]] PointMotion zero_motion() const;
  /// Whether a base acceleration moves every degree of freedom alike.
  [[nodiscard]] bool moves_alike_by_all() const;
  /// Of a connector's end: a point, or the fixed ground.
  [[nodiscard]] PointMotion end_motion(const std::string& end) const;

  std::vector<Substructure> substructures_;
  std::vector<InputDescription> inputs_;
  LocallyNonlinearSystem system_;
  bool global_modal_damping_ = false;
  std::unordered_map<std::string, Eigen::Index> dof_indices_;
  std::vector<std::vector<Eigen::Index>> places_;  ///< in the system, of each substructure's degrees of freedom
  Eigen::VectorXd coordinate_scale_;
  Eigen::MatrixXd base_accelerations_;
};

}  // namespace kalfem
