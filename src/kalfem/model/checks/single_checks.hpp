// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/model/checks/model_check.hpp"

namespace kalfem::report {

/// So many names are listed in a finding, and so many nodes shown.
inline constexpr std::size_t most_named = 8, most_shown = 1000;

/// Number in the form in which findings tell it: "2.1e+11".
std::string to_string(double value);
/// "quadrilateral 17", by its index in the mesh.
std::string cell_name(const Mesh& mesh, Eigen::Index index);
/// "a, b, c and 17 more" of the first few of `count` names.
std::string listed(const std::vector<std::string>& names, Eigen::Index count);

/// The degree of freedom at which a Cholesky factorisation of A + 1e-10 diag(A) fails; -1: A is semi-definite.
Eigen::Index indefinite_dof(const SparseMatrix& matrix);

/// Degrees of freedom without mass and stiffness.
void check_massless(const std::vector<std::string>& dofs, const SparseMatrix& mass, const SparseMatrix& stiffness,
                    std::vector<ModelFinding>& findings);

/// Degrees of freedom on which a ground acts.
Eigen::Index count_grounded(const std::vector<GroundCoupling>& grounds, Eigen::Index size);

/// About the middle of the box, scaled by half its diagonal.
RigidFrame frame_of(const ModelCheckReport& report);

/// Symmetry and signs of a matrix; with `definite`, an attempt to factor it. Findings name it ("stiffness matrix").
MatrixCheck check_matrix(const SparseMatrix& matrix, const std::string& name, FindingTopic topic, bool definite,
                         const std::vector<std::string>& dofs, std::vector<ModelFinding>& findings);

/// Findings on how the structure is held, and the names of the stray degrees of freedom.
/// `supported`: supports or grounds are known to hold it.
std::vector<std::string> tell_grounding(const GroundingCheck& grounding, bool supported,
                                        const std::vector<std::string>& dofs, std::vector<ModelFinding>& findings);

/// Findings on the mass of the whole, its centre and inertia, and on the part of it that moves along x, y and z.
/// `needed`: a model without mass is an error.
void tell_mass(const MassProperties& mass, const Eigen::Vector3d& moving, const Eigen::Vector3d& lowest,
               const Eigen::Vector3d& highest, bool needed, std::vector<ModelFinding>& findings);

/// Materials and dimensions, and findings on units.
void check_materials(const FiniteElementModel& model, ModelCheckReport& report);

/// Nodes that nothing touches or that stand at one place, parts that hang on nothing.
void check_connections(const FiniteElementModel& model, const ModelCheckOptions& options, ModelCheckReport& report);

/// Shapes of cells by region.
void check_elements(const FiniteElementModel& model, const ModelCheckOptions& options, ModelCheckReport& report);

/// Springs that are out of proportion to what they hang on.
void check_springs(const FiniteElementModel& model, const AssembledModel& assembled, const SparseMatrix& stiffness,
                   ModelCheckReport& report);

/// Box around nodes.
void set_box(const Eigen::Matrix3Xd& places, ModelCheckReport& report);

/// Errors first, then by topic.
void sort(std::vector<ModelFinding>& findings);

}  // namespace kalfem::report
