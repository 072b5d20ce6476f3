// SPDX-License-Identifier: Apache-2.0
#include "model/fe_models.hpp"

#include <cmath>
#include <numbers>

#include "kalfem/linalg/lowest_modes.hpp"
#include "kalfem/model/assembly/assembly.hpp"

namespace kalfem::test {

std::string issues_of(const FiniteElementModel& model) {
  std::string text;
  for (const auto& issue : validate(model)) text += to_string(issue) + "\n";
  return text;
}

Eigen::Index add_node(Mesh& mesh, const Eigen::Vector3d& place) {
  const Eigen::Index index = mesh.node_count();
  mesh.nodes.conservativeResize(3, index + 1);
  mesh.nodes.col(index) = place;
  mesh.node_ids.push_back(index + 1);
  return index;
}

void add_cell(Mesh& mesh, const std::string& region, CellShape shape, const std::vector<Eigen::Index>& nodes) {
  mesh.regions[region].push_back(mesh.add_cell(shape, static_cast<std::int64_t>(mesh.cells.size()) + 1, nodes));
}

Mesh line_mesh(const Eigen::Vector3d& start, const Eigen::Vector3d& end, int count, const std::string& region) {
  Mesh mesh;
  mesh.source = "line.msh";
  for (int i = 0; i <= count; ++i) add_node(mesh, start + (end - start) * i / count);
  for (Eigen::Index i = 0; i < count; ++i) add_cell(mesh, region, CellShape::line2, {i, i + 1});
  return mesh;
}

Mesh plate_mesh(double a, double b, int nx, int ny, const std::string& region) {
  Mesh mesh;
  mesh.source = "plate.msh";
  for (int j = 0; j <= ny; ++j)
    for (int i = 0; i <= nx; ++i) add_node(mesh, {a * i / nx, b * j / ny, 0.0});
  for (Eigen::Index j = 0; j < ny; ++j)
    for (Eigen::Index i = 0; i < nx; ++i) {
      const Eigen::Index first = j * (nx + 1) + i;
      add_cell(mesh, region, CellShape::quadrilateral4, {first, first + 1, first + nx + 2, first + nx + 1});
    }
  return mesh;
}

BeamProperty beam_property(const BeamSection& section, const Eigen::Vector3d& offset, const Eigen::Vector3d& up) {
  BeamProperty property;
  property.material = "steel";
  property.section = section;
  property.placements = {{up, offset.replicate<1, 2>(), {}}};
  return property;
}

FiniteElementModel model_of(Mesh mesh) {
  FiniteElementModel model;
  model.name = "model";
  model.mesh = std::move(mesh);
  model.materials["steel"] = steel;
  return model;
}

FiniteElementModel beam_model(const Eigen::Vector3d& end, int count, const BeamSection& section) {
  auto model = model_of(line_mesh({0.0, 0.0, 0.0}, end, count));
  model.properties["line"] = beam_property(section);
  return model;
}

Eigen::MatrixXd stiffness_of(const AssembledModel& model) {
  return Eigen::MatrixXd(evaluate(model.stiffness, model.parameters));
}
Eigen::MatrixXd mass_of(const AssembledModel& model) { return Eigen::MatrixXd(evaluate(model.mass, model.parameters)); }

Eigen::VectorXd frequencies(const FiniteElementModel& model, Eigen::Index count) {
  const auto assembled = assemble(model);
  const auto modes = lowest_modes(evaluate(assembled.stiffness, assembled.parameters),
                                  evaluate(assembled.mass, assembled.parameters), {.count = count});
  return modes.values.cwiseMax(0.0).cwiseSqrt() / (2.0 * std::numbers::pi);
}

double difference(const Eigen::MatrixXd& one, const Eigen::MatrixXd& other) {
  return (one - other).norm() / other.norm();
}

}  // namespace kalfem::test
