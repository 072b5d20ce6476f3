// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Eigenvalues>
#include <algorithm>

#include "kalfem/formats/nastran/model_building.hpp"
#include "kalfem/model/assembly/rigid_motion.hpp"

namespace kalfem::nastran {
namespace {

/// Springs of their own name are parameters of the model; more than these are one matrix, which costs less.
constexpr std::size_t most_named_springs = 500;

const char* card_name(ScalarCard::Kind kind) {
  return kind == ScalarCard::Kind::spring ? "celas" : kind == ScalarCard::Kind::dashpot ? "cdamp" : "cmass";
}

// CELAS2 and CELAS4, and their kin, state the value on the element, the others on a property.
std::optional<double> value_of(Building& building, const ScalarCard& card, const std::string& title) {
  if (card.property == 0) return card.value;
  const auto& values = card.kind == ScalarCard::Kind::spring    ? building.bulk.spring_stiffness
                       : card.kind == ScalarCard::Kind::dashpot ? building.bulk.dashpot_damping
                                                                : building.bulk.scalar_mass;
  if (const auto value = values.find(card.property); value != values.end()) return value->second;
  find_property(building, card.property, title, card.where, [](const PropertyCard&) { return false; });
  return std::nullopt;
}

/// d = u1 - u2 of the two components, the ground standing still.
std::optional<DofSum> deformation(Building& building, const ScalarCard& card, const std::string& title) {
  DofSum terms;
  for (std::size_t end = 0; end < 2; ++end) {
    if (card.nodes[end] == 0) continue;
    const auto node = building.node(card.nodes[end], title, card.where);
    if (node < 0) return std::nullopt;
    building.append(terms, node, card.components[end], end == 0 ? 1.0 : -1.0);
  }
  return terms;
}

/// Springs and dashpots of a bushing in its axes (columns), its point off either node by `arms`.
struct Bushing {
  std::array<Eigen::Index, 2> nodes = {-1, -1};  ///< -1: the ground
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  std::array<Eigen::Vector3d, 2> arms = {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};

  /// Relative motion of the two ends at the point along or about an axis: a . (u + theta x arm).
  [[nodiscard]] DofSum deformation(int component) const {
    DofSum terms;
    const Eigen::Vector3d a = axes.col(component % 3);
    for (std::size_t end = 0; end < 2; ++end) {
      if (nodes[end] < 0) continue;
      const double sign = end == 0 ? -1.0 : 1.0;
      const Eigen::Vector3d turning = component < 3 ? Eigen::Vector3d(arms[end].cross(a)) : a;
      for (int k = 0; k < 3; ++k) {
        if (component < 3 && std::abs(a[k]) > 1e-14) terms.push_back({{nodes[end], k}, sign * a[k]});
        if (std::abs(turning[k]) > 1e-14 * (1.0 + arms[end].norm()))
          terms.push_back({{nodes[end], 3 + k}, sign * turning[k]});
      }
    }
    return terms;
  }
};

// x runs from GA to GB, z = x cross v, y = z cross x. Without an orientation any v does, as long as only x is active.
/// Axes from CID, from the orientation, or along the nodes where only axial values are given.
std::optional<Eigen::Matrix3d> bushing_axes(Building& building, const BushCard& card,
                                            const std::array<Eigen::Index, 2>& nodes, bool only_axial,
                                            const std::string& title) {
  if (card.axes >= 0) {
    const Frame* frame = building.frames.find(card.axes, card.where);
    if (frame == nullptr) return std::nullopt;
    return frame->directions(building.place(nodes[0]));
  }
  const Eigen::Vector3d between =
      nodes[1] < 0 ? Eigen::Vector3d::Zero() : Eigen::Vector3d(building.place(nodes[1]) - building.place(nodes[0]));
  if (!(between.norm() > 0.0)) {
    building.files.problem(card.where, title + " connects one node or two coincident nodes and has no CID",
                           "its axes are undefined", "give CID");
    return std::nullopt;
  }
  const Eigen::Vector3d x = between.normalized();
  Eigen::Vector3d v = x.cwiseAbs().x() < 0.9 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY();
  if (card.orientation_node > 0) {
    const auto node = building.node(card.orientation_node, title, card.where);
    if (node < 0) return std::nullopt;
    v = building.place(node) - building.place(nodes[0]);
  } else if (card.orientation) {
    v = building.motion_axes(nodes[0]) * *card.orientation;
  } else if (!only_axial) {
    building.files.problem(card.where, title + " has neither an orientation nor CID",
                           "its transverse stiffnesses need one", "give X1, X2, X3, G0 or CID");
    return std::nullopt;
  }
  const Eigen::Vector3d z = x.cross(v);
  if (!(z.norm() > 1e-6 * v.norm())) {
    building.files.problem(card.where, title + ": its orientation is zero or parallel to its axis", "", "correct it");
    return std::nullopt;
  }
  Eigen::Matrix3d axes;
  axes << x, z.normalized().cross(x), z.normalized();
  return axes;
}

/// The point of a bushing: S between the nodes, or an offset from GA in OCID.
std::optional<Eigen::Vector3d> bushing_point(Building& building, const BushCard& card,
                                             const std::array<Eigen::Index, 2>& nodes) {
  const Eigen::Vector3d first = building.place(nodes[0]);
  if (card.offset_system >= 0) {
    const Frame* frame = building.frames.find(card.offset_system, card.where);
    if (frame == nullptr) return std::nullopt;
    return first + frame->directions(first) * card.offset;
  }
  return nodes[1] < 0 ? first : Eigen::Vector3d(first + card.location * (building.place(nodes[1]) - first));
}

// A bushing acts at one point, which both nodes carry by rigid arms. Each of its six springs becomes a joint k c c^T,
// so moments of offset forces arise by themselves.
void add_bush(Building& building, const BushCard& card) {
  const auto title = std::string(card.kind) + " " + std::to_string(card.id);
  const std::string kind = "P" + std::string(card.kind).substr(1);
  const auto* found = find_property(building, card.property, title, card.where,
                                    [&](const PropertyCard& property) { return property.kind == kind; });
  const auto* property = found == nullptr ? nullptr : std::get_if<BushProperty>(&found->law);
  Bushing bushing;
  bushing.nodes[0] = building.node(card.nodes[0], title, card.where);
  if (card.nodes[1] > 0) bushing.nodes[1] = building.node(card.nodes[1], title, card.where);
  if (property == nullptr || bushing.nodes[0] < 0 || (card.nodes[1] > 0 && bushing.nodes[1] < 0)) return;
  bool only_axial = true;
  for (const std::size_t i : {1, 2, 4, 5})
    only_axial = only_axial && property->stiffness[i] == 0.0 && property->damping[i] == 0.0;
  const auto axes = bushing_axes(building, card, bushing.nodes, only_axial, title);
  const auto point = bushing_point(building, card, bushing.nodes);
  if (!axes || !point) return;
  bushing.axes = *axes;
  for (std::size_t end = 0; end < 2; ++end)
    if (bushing.nodes[end] >= 0) bushing.arms[end] = *point - building.place(bushing.nodes[end]);
  std::string name = card.kind;
  std::ranges::transform(name, name.begin(),
                         [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  for (int i = 0; i < 6; ++i) {
    const double stiffness = property->stiffness[static_cast<std::size_t>(i)],
                 damping = property->damping[static_cast<std::size_t>(i)];
    if (stiffness != 0.0 || damping != 0.0)
      building.model.joints.push_back(
          {name + std::to_string(card.id) + ".k" + std::to_string(i + 1), bushing.deformation(i), stiffness, damping});
  }
  if (property->mass != 0.0)
    for (const auto node : bushing.nodes)
      for (int k = 0; k < 3 && node >= 0; ++k) {
        const double share = property->mass * building.bulk.mass_factor / (bushing.nodes[1] < 0 ? 1.0 : 2.0);
        building.matrices.add(MatrixGather::mass, {{{node, k}, 1.0}}, {{{node, k}, 1.0}}, share);
      }
}

/// Springs with a negative value, and springs in large numbers, become matrices.
void gather_joints(Building& building) {
  auto& joints = building.model.joints;
  const bool all = joints.size() > most_named_springs;
  if (all)
    building.note({}, std::to_string(joints.size()) + " springs and dashpots",
                  "they are kept as one matrix; their values cannot be parameters", DeckNoteKind::unused);
  std::erase_if(joints, [&](const JointSpring& joint) {
    if (!all && joint.stiffness >= 0.0 && joint.damping >= 0.0) return false;
    if (joint.stiffness != 0.0)
      building.matrices.add(MatrixGather::stiffness, joint.deformation, joint.deformation, joint.stiffness);
    if (joint.damping != 0.0)
      building.matrices.add(MatrixGather::damping, joint.deformation, joint.deformation, joint.damping);
    return true;
  });
}

}  // namespace

void build_scalars(Building& building) {
  for (const auto& card : building.bulk.scalars) {
    const auto name = card_name(card.kind) + std::to_string(card.id);
    const auto value = value_of(building, card, name);
    const auto terms = deformation(building, card, name);
    if (!value || !terms || *value == 0.0) continue;
    if (card.kind == ScalarCard::Kind::mass)
      building.matrices.add(MatrixGather::mass, *terms, *terms, *value * building.bulk.mass_factor);
    else if (card.kind == ScalarCard::Kind::spring)
      building.model.joints.push_back({name, *terms, *value, 0.0});
    else
      building.model.joints.push_back({name, *terms, 0.0, *value});
  }
}

void build_bushes(Building& building) {
  for (const auto& card : building.bulk.bushes) add_bush(building, card);
  gather_joints(building);
}

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

// The inertia is turned from the axes of CID to global ones. CID = -1 gives the offset as a place in the basic
// system.
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
  building.note(card.where, "CONM2 with a negative mass or an impossible inertia",
                "it is kept as a matrix; its mass cannot be a parameter", DeckNoteKind::unused);
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

// Entries of an IFO 6 matrix state one triangle, so each off-diagonal one is added twice. Directions are those of the
// displacement axes of each node.
/// One direct input matrix in the displacement axes of its nodes.
bool add_direct(Building& building, MatrixGather& gather, MatrixGather::Kind kind, const DmigMatrix& matrix,
                double factor, const std::string& title) {
  if (!matrix.form) {
    building.files.problem(matrix.where, title + " has no header", "the header says whether the matrix is symmetric",
                           "put 'DMIG, NAME, 0, 6, 1, 0' before its columns");
    return false;
  }
  if (matrix.complex || (*matrix.form != 6 && *matrix.form != 1)) {
    building.files.problem(matrix.where, title + " is complex or not square (IFO, TIN)",
                           "stiffness, mass and damping must be real and symmetric",
                           "write it with IFO 6 and TIN 1 or 2");
    return false;
  }
  const bool is_symmetric = *matrix.form == 6;
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
        building.files.problem({}, title + " refers to a DMIG that is not in the bulk data", "",
                               "add it, or remove it");
        continue;
      }
      used[name] = true;
      MatrixGather gather;
      if (add_direct(building, gather, kind, matrix->second, factor * building.bulk.direct_factors[kind], title) &&
          !gather.empty())
        building.model.matrices.push_back(gather.finish(name));
    }
  };
  take(MatrixGather::stiffness, building.control.stiffness, "K2GG");
  take(MatrixGather::mass, building.control.mass, "M2GG");
  take(MatrixGather::damping, building.control.damping, "B2GG");
  for (const auto& [name, matrix] : building.bulk.matrices)
    if (!used.contains(name))
      building.note(matrix.where, "DMIG " + name,
                    "no K2GG, M2GG or B2GG of the case control selects it, so it is not part of the model",
                    DeckNoteKind::unused);
  if (!building.matrices.empty()) building.model.matrices.push_back(building.matrices.finish("scalar_elements"));
}

}  // namespace kalfem::nastran
