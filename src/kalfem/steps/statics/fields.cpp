// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>

#include "kalfem/formats/vtu.hpp"
#include "kalfem/steps/statics/outcome.hpp"
#include "kalfem/steps/statics/report.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

MatrixXd unknown(Index rows, Index columns) { return MatrixXd::Constant(rows, columns, NAN); }

MatrixXd nodal_von_mises(const Mesh& mesh, const SolvedLoadCase& each) {
  MatrixXd values = unknown(1, mesh.node_count());
  for (const auto& region : each.nodal)
    for (const auto& mean : region)
      if (const double value = von_mises(mean.stress); !(values(0, mean.node) >= value)) values(0, mean.node) = value;
  return values;
}

struct CellTensors {
  MatrixXd stress, strain, axial;
};

/// Of a shell in the layer with the largest stress; of a beam the axial stress that is largest in magnitude.
CellTensors cell_tensors(const Mesh& mesh, const SolvedLoadCase& each) {
  const auto count = static_cast<Index>(mesh.cells.size());
  CellTensors tensors{unknown(6, count), unknown(6, count), unknown(1, count)};
  for (const auto& region : each.stresses) {
    for (const auto& cell : region.cells)
      for (const auto& layer : cell.layers)
        if (const Stress present = tensors.stress.col(cell.cell); !(von_mises(present) >= von_mises(layer.centre))) {
          tensors.stress.col(cell.cell) = layer.centre;
          tensors.strain.col(cell.cell) = layer.strain;
        }
    for (const auto& beam : region.beams)
      for (std::size_t end = 0; end < 2; ++end) {
        double& axial = tensors.axial(0, beam.cell);
        const auto fibres = beam.fibres[end].value_or(FibreStress{beam.axial[end], beam.axial[end]});
        for (const double value : {fibres.lowest, fibres.highest})
          if (!(std::abs(axial) >= std::abs(value))) axial = value;
      }
  }
  return tensors;
}

/// A field that some cell has.
void add_known(const std::string& name, MatrixXd values, std::vector<CellField>& fields) {
  if (!values.array().isNaN().all()) fields.push_back({name, std::move(values)});
}

/// The mesh; of a model without elements the lines of its springs and joints, so that its nodes are seen.
Mesh shown_mesh(const FiniteElementModel& model) {
  Mesh mesh = model.mesh;
  if (!mesh.cells.empty()) return mesh;
  const auto add_line = [&](Index from, Index to) {
    const std::array nodes = {from, to};
    if (from != to) mesh.add_cell(CellShape::line2, static_cast<std::int64_t>(mesh.cells.size()) + 1, nodes);
  };
  for (const auto& spring : model.springs)
    if (spring.to) add_line(spring.from.node, spring.to->node);
  for (const auto& joint : model.joints)
    if (!joint.deformation.empty()) add_line(joint.deformation.front().first.node, joint.deformation.back().first.node);
  for (const auto& matrices : model.matrices)
    if (!matrices.dofs.empty()) add_line(matrices.dofs.front().node, matrices.dofs.back().node);
  return mesh;
}

}  // namespace

void write_static_fields(const std::filesystem::path& folder, const StaticsPlan& plan, const StaticsOutcome& outcome) {
  const Mesh& mesh = plan.part->elements.mesh;
  std::vector<NodalField> nodal;
  std::vector<CellField> cells;
  for (const auto& each : outcome.cases) {
    const std::string prefix = each.solution.load_case + ": ";
    nodal.push_back({prefix + "displacement", each.solution.displacements.reshaped(6, mesh.node_count()).topRows(3)});
    nodal.push_back({prefix + "von Mises stress", nodal_von_mises(mesh, each)});
    auto tensors = cell_tensors(mesh, each);
    add_known(prefix + "stress", std::move(tensors.stress), cells);
    add_known(prefix + "strain", std::move(tensors.strain), cells);
    add_known(prefix + "axial stress of beams", std::move(tensors.axial), cells);
  }
  write_vtu(folder / (outcome.substructure + "_static.vtu"), shown_mesh(plan.part->elements), nodal, cells);
}

}  // namespace kalfem
