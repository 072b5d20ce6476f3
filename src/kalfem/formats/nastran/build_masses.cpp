#include <Eigen/Eigenvalues>

#include "kalfem/formats/nastran/model_building.hpp"
#include "kalfem/model/elements/point_mass.hpp"

namespace kalfem::nastran {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Axes of a system at a node, as columns.
std::optional<Eigen::Matrix3d> axes_at(Building& building, Id system, Eigen::Index node, const Place& where) {
  if (system <= 0) return Eigen::Matrix3d::Identity();
  const Frame* frame = building.frames.find(system, where);
  if (frame == nullptr) return std::nullopt;
  return frame->directions(building.place(node));
}

void add_matrix(Building& building, Eigen::Index node, const Matrix6& matrix) {
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j)
      if (matrix(i, j) != 0.0)
        building.matrices.add(MatrixGather::mass, {{{node, i}, 1.0}}, {{{node, j}, 1.0}}, matrix(i, j));
}

/// Digits of the card may make a thin body's inertia indefinite by rounding; a body has none that is more so.
bool is_body(const PointMass& mass) {
  const auto lowest =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(mass.inertia, Eigen::EigenvaluesOnly).eigenvalues().minCoeff();
  return mass.mass >= 0.0 && lowest >= -1e-9 * mass.inertia.cwiseAbs().maxCoeff();
}

void add_mass(Building& building, const Conm2Card& card) {
  const auto title = "CONM2 " + std::to_string(card.id);
  const auto node = building.node(card.node, title, card.where);
  if (node < 0) return;
  const auto axes = axes_at(building, card.system, node, card.where);
  if (!axes) return;
  PointMass mass;
  mass.name = "conm2_" + std::to_string(card.id);
  mass.node = node;
  mass.mass = card.mass * building.bulk.mass_factor;
  mass.inertia = *axes * (card.inertia * building.bulk.mass_factor) * axes->transpose();
  mass.inertia = 0.5 * (mass.inertia + mass.inertia.transpose()).eval();
  mass.offset =
      card.system == -1 ? Eigen::Vector3d(card.offset - building.place(node)) : Eigen::Vector3d(*axes * card.offset);
  if (is_body(mass)) {
    building.model.masses.push_back(std::move(mass));
    return;
  }
  building.note(card.where, "CONM2 with a negative mass or an inertia that no body has",
                "it is kept as a matrix; its mass is not a parameter of the model");
  add_matrix(building, node, point_mass(mass));
}

void add_mass(Building& building, const Conm1Card& card) {
  const auto node = building.node(card.node, "CONM1 " + std::to_string(card.id), card.where);
  if (node < 0) return;
  const auto axes = axes_at(building, card.system, node, card.where);
  if (!axes) return;
  Matrix6 turn = Matrix6::Zero();
  turn.topLeftCorner<3, 3>() = turn.bottomRightCorner<3, 3>() = *axes;
  const Matrix6 matrix = turn * card.matrix * turn.transpose() * building.bulk.mass_factor;
  add_matrix(building, node, 0.5 * (matrix + matrix.transpose()));
}

using Chosen = std::vector<std::pair<double, std::string>>;

/// One direct input matrix in the displacement axes of its nodes.
bool add_direct(Building& building, MatrixGather& gather, MatrixGather::Kind kind, const DmigMatrix& matrix,
                double factor, const std::string& title) {
  if (matrix.complex || (matrix.form && *matrix.form != 6 && *matrix.form != 1)) {
    building.files.problem(matrix.where, title + " is complex or not square (IFO, TIN)",
                           "stiffness, mass and damping are real and symmetric", "write it with IFO 6 and TIN 1 or 2");
    return false;
  }
  const bool is_symmetric = matrix.form.value_or(6) == 6;
  for (const auto& entry : matrix.entries) {
    const auto row = building.node(entry.row, title, entry.where),
               column = building.node(entry.column, title, entry.where);
    if (row < 0 || column < 0) return false;
    DofSum left, right;
    building.append(left, row, entry.row_direction, 1.0);
    building.append(right, column, entry.column_direction, 1.0);
    gather.add(kind, left, right, factor * entry.value);
    const bool is_diagonal = entry.row == entry.column && entry.row_direction == entry.column_direction;
    if (is_symmetric && !is_diagonal) gather.add(kind, right, left, factor * entry.value);
  }
  return true;
}

}  // namespace

void build_masses(Building& building) {
  for (const auto& card : building.bulk.masses) add_mass(building, card);
  for (const auto& card : building.bulk.mass_matrices) add_mass(building, card);
}

void build_direct_matrices(Building& building) {
  std::map<std::string, bool> used;
  const auto take = [&](MatrixGather::Kind kind, const Chosen& chosen, const char* command) {
    for (const auto& [factor, name] : chosen) {
      const auto title = std::string(command) + " = " + name;
      const auto matrix = building.bulk.matrices.find(name);
      if (matrix == building.bulk.matrices.end()) {
        building.files.problem({}, title + " names a DMIG that the bulk data does not have", "",
                               "add it, or take it out");
        continue;
      }
      used[name] = true;
      MatrixGather gather;
      if (add_direct(building, gather, kind, matrix->second, factor, title) && !gather.empty())
        building.model.matrices.push_back(gather.finish(name));
    }
  };
  take(MatrixGather::stiffness, building.control.stiffness, "K2GG");
  take(MatrixGather::mass, building.control.mass, "M2GG");
  take(MatrixGather::damping, building.control.damping, "B2GG");
  for (const auto& [name, matrix] : building.bulk.matrices)
    if (!used.contains(name))
      building.note(matrix.where, "DMIG " + name,
                    "no K2GG, M2GG or B2GG of the case control names it; it is not part of the model");
  if (!building.matrices.empty()) building.model.matrices.push_back(building.matrices.finish("scalar_elements"));
}

}  // namespace kalfem::nastran
