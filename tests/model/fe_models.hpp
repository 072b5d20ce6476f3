// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/model/finite_element_model.hpp"

namespace kalfem {
struct AssembledModel;
}

/// Meshes and models that many tests build.
namespace kalfem::test {

inline const IsotropicMaterial steel{.youngs_modulus = 2.1e11, .poissons_ratio = 0.3, .density = 7850.0};
inline const IsotropicMaterial nafems_steel{.youngs_modulus = 200e9, .poissons_ratio = 0.3, .density = 8000.0};

/// All issues of a model as one text.
std::string issues_of(const FiniteElementModel& model);

/// The message of the InvalidInput that `action` throws, "" if it throws none.
template <typename Action>
std::string message_of(const Action& action) {
  try {
    action();
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

Eigen::Index add_node(Mesh& mesh, const Eigen::Vector3d& place);
void add_cell(Mesh& mesh, const std::string& region, CellShape shape, const std::vector<Eigen::Index>& nodes);

/// Nodes 0 .. count on the line from `start` to `end`, joined by `count` cells of `region`. Node numbers begin at 1.
Mesh line_mesh(const Eigen::Vector3d& start, const Eigen::Vector3d& end, int count, const std::string& region = "line");
/// `nx` x `ny` quadrilaterals on the rectangle a x b in the x-y plane, first corner at the origin.
Mesh plate_mesh(double a, double b, int nx, int ny, const std::string& region = "plate");

BeamProperty beam_property(const BeamSection& section, const Eigen::Vector3d& offset = Eigen::Vector3d::Zero(),
                           const Eigen::Vector3d& up = Eigen::Vector3d::UnitZ());
FiniteElementModel model_of(Mesh mesh);
/// Beams of one section along a line from the origin.
FiniteElementModel beam_model(const Eigen::Vector3d& end, int count, const BeamSection& section);

Eigen::MatrixXd stiffness_of(const AssembledModel& model);
Eigen::MatrixXd mass_of(const AssembledModel& model);
/// Lowest natural frequencies [Hz], ascending.
Eigen::VectorXd frequencies(const FiniteElementModel& model, Eigen::Index count);

/// Relative difference in the Frobenius norm.
double difference(const Eigen::MatrixXd& one, const Eigen::MatrixXd& other);

}  // namespace kalfem::test
