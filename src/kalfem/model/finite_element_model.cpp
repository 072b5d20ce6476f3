// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/finite_element_model.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "kalfem/base/units.hpp"
#include "kalfem/model/assembly/constraints.hpp"

namespace kalfem {
namespace {

template <typename Map>
std::vector<std::string> names_of(const Map& map) {
  std::vector<std::string> names;
  for (const auto& [name, value] : map) names.push_back(name);
  return names;
}

/// Looks through a model part by part and collects what is wrong with it.
class Validator {
public:
  explicit Validator(const FiniteElementModel& model) : model_(model), mesh_(model.mesh) {}

  // In the order in which checks rest on each other: cells of a mesh that has wrong nodes are not looked at, and
  // constraints only where every node exists. So one mistake is told once, at its place.
  std::vector<Issue> run() {
    check_mesh();
    for (const auto& [name, material] : model_.materials) check_material(name, material);
    for (const auto& [region, property] : model_.properties) check_property(region, property);
    if (mesh_is_sound_) check_regions();
    check_masses();
    check_springs();
    check_joints();
    check_matrices();
    check_factors();
    check_links();
    check_constraints();
    check_supports();
    if (nodes_exist_ && mesh_is_sound_)
      for (auto& issue : constraint_issues(model_))
        issues_.add(issue.location.file.empty() ? SourceLocation{mesh_.source, 0} : issue.location,
                    std::move(issue.what), std::move(issue.why), std::move(issue.fix));
    return issues_.issues();
  }

private:
  void add(std::string what, std::string why, std::string fix = {}) {
    issues_.add({mesh_.source, 0}, std::move(what), std::move(why), std::move(fix));
  }

  void check_mesh();
  void check_material(const std::string& name, const IsotropicMaterial& material);
  void check_property(const std::string& region, const RegionProperty& property);
  void check_shape(const std::string& region, const RegionProperty& property);
  void check_directions(const std::string& region, const RegionProperty& property, std::size_t cells);
  void check_laminate(const std::string& region, const LaminateProperty& laminate);
  void check_section(const std::string& region, const BeamSection& section);
  void check_beam(const std::string& region, const BeamProperty& beam);
  void check_regions();
  void check_overlaps();
  void check_masses();
  void check_springs();
  void check_joints();
  void check_matrices();
  void check_factors();
  void check_links();
  void check_constraints();
  void check_supports();

  bool check_node(Eigen::Index node, const std::string& title);
  bool check_dof(const NodalDof& dof, const std::string& title);
  template <typename Item>
  void check_names(const std::vector<Item>& items, const std::string& kind);

  const FiniteElementModel& model_;
  const Mesh& mesh_;
  IssueList issues_;
  bool mesh_is_sound_ = true;
  bool nodes_exist_ = true;
};

// Later checks index nodes by cell and cells by region without tests of their own. So a wrong index in either marks
// the mesh as unsound and skips them. Without a number for each node no message could name one, so the check stops.
void Validator::check_mesh() {
  const auto in_range = [](Eigen::Index index, std::size_t size) {
    return index >= 0 && static_cast<std::size_t>(index) < size;
  };
  const auto refuse = [&](std::string what, std::string why) {
    add(std::move(what), std::move(why), "correct the mesh");
    mesh_is_sound_ = false;
  };
  const auto nodes = static_cast<std::size_t>(mesh_.node_count());
  if (mesh_.node_ids.size() != nodes) {
    refuse("the mesh has " + std::to_string(nodes) + " nodes and " + std::to_string(mesh_.node_ids.size()) + " numbers",
           "every node needs a number");
    nodes_exist_ = false;
    return;
  }
  if (!mesh_.nodes.allFinite())
    refuse("a coordinate of the mesh is not finite", "coordinates must be finite numbers in m");
  for (const auto& cell : mesh_.cells)
    if (!std::ranges::all_of(mesh_.nodes_of(cell), [&](auto node) { return in_range(node, nodes); }))
      refuse(to_string(cell.shape) + " " + std::to_string(cell.id) + " has a node that does not exist",
             "elements must connect nodes of the mesh");
  for (const auto& [region, cells] : mesh_.regions)
    if (!std::ranges::all_of(cells, [&](auto cell) { return in_range(cell, mesh_.cells.size()); }))
      refuse("region '" + region + "' has an element that does not exist", "a region must list elements of the mesh");
}

void Validator::check_material(const std::string& name, const IsotropicMaterial& material) {
  const std::string title = "material '" + name + "' has ";
  if (!is_positive(material.youngs_modulus))
    add(title + "Young's modulus " + shortest(material.youngs_modulus), "it must be positive and finite",
        "give it in Pa");
  if (!(material.poissons_ratio > -1.0 && material.poissons_ratio < 0.5))
    add(title + "Poisson's ratio " + shortest(material.poissons_ratio), "it must lie between -1 and 0.5");
  if (!(material.density >= 0.0) || !std::isfinite(material.density))
    add(title + "density " + shortest(material.density), "it must be positive and finite", "give it in kg/m^3");
}

// A laminate has its own stiffness and mass, so only the other properties need a material of the model.
void Validator::check_property(const std::string& region, const RegionProperty& property) {
  if (!mesh_.regions.contains(region))
    add("a property is given for the region '" + region + "', which the mesh does not have" +
            did_you_mean(region, names_of(mesh_.regions)),
        "a property must belong to a region of the mesh");
  else if (mesh_is_sound_)
    check_shape(region, property);
  const auto material = material_of(property);
  const auto* laminate = std::get_if<LaminateProperty>(&property);
  if (laminate)
    check_laminate(region, *laminate);
  else if (!model_.materials.contains(material))
    add("region '" + region + "' has the material '" + material + "', which is not defined" +
            did_you_mean(material, names_of(model_.materials)),
        "each property needs a material");
  if (const auto* shell = std::get_if<ShellProperty>(&property); shell && !is_positive(shell->thickness))
    add("region '" + region + "' has the thickness " + shortest(shell->thickness),
        "a thickness must be positive and finite", "give it in m");
  if (const auto* beam = std::get_if<BeamProperty>(&property)) check_beam(region, *beam);
}

// A, B and D together must be positive definite, not each alone: a large coupling B can make a laminate unstable
// although A and D are sound.
void Validator::check_laminate(const std::string& region, const LaminateProperty& laminate) {
  if (!(laminate.mass >= 0.0) || !std::isfinite(laminate.mass))
    add("the cross-section of region '" + region + "' has the mass " + shortest(laminate.mass),
        "a mass must be finite and not negative", "give it in kg/m^2");
  Matrix6 joined;
  joined << laminate.stiffness.membrane, laminate.stiffness.coupling, laminate.stiffness.coupling,
      laminate.stiffness.bending;
  const auto lowest = [](const Eigen::MatrixXd& matrix) {
    return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(matrix, Eigen::EigenvaluesOnly).eigenvalues().minCoeff();
  };
  if (!joined.allFinite() || !laminate.stiffness.shear.allFinite() || !(lowest(joined) > 0.0) ||
      !(lowest(laminate.stiffness.shear) > 0.0))
    add("the cross-section of region '" + region + "' has a stiffness that is not positive definite",
        "every strain, curvature and transverse shear must have positive energy",
        "complete its layers and their transverse shear moduli");
}

// Beams and shells exist for linear cells only; decks with quadratic ones have them split before. Solids exist for both
// orders. Of several wrong cells the first is named, since one wrong cell mostly means a mixed region.
/// Shells are made of surfaces, beams of lines, solids of bodies.
void Validator::check_shape(const std::string& region, const RegionProperty& property) {
  struct Kind {
    const char *title, *shapes;
    int dimension;
  };
  const Kind kind = std::holds_alternative<BeamProperty>(property) ? Kind{"beam", "beams need 2-node lines", 1}
                    : std::holds_alternative<SolidProperty>(property)
                        ? Kind{"solid", "solids need solid elements", 3}
                        : Kind{"shell", "shells need triangles of 3 nodes or quadrilaterals of 4 nodes", 2};
  const auto fits = [&](CellShape shape) {
    return dimension(shape) == kind.dimension && (kind.dimension == 3 || node_count(shape) == corner_count(shape));
  };
  const auto& cells = mesh_.regions.at(region);
  const auto wrong =
      std::ranges::find_if(cells, [&](auto cell) { return !fits(mesh_.cells[static_cast<std::size_t>(cell)].shape); });
  if (cells.empty()) add("region '" + region + "' has a property but no elements", "the property would have no effect");
  check_directions(region, property, cells.size());
  if (wrong == cells.end()) return;
  const auto& cell = mesh_.cells[static_cast<std::size_t>(*wrong)];
  add("region '" + region + "' has a " + kind.title + " property but contains the " + to_string(cell.shape) + " " +
          std::to_string(cell.id),
      kind.shapes, "put lines, surfaces and solids into separate regions");
}

/// What is given for each cell is given for all of them.
void Validator::check_directions(const std::string& region, const RegionProperty& property, std::size_t cells) {
  const auto* beam = std::get_if<BeamProperty>(&property);
  const auto* laminate = std::get_if<LaminateProperty>(&property);
  const std::size_t given = beam ? beam->placements.size() : laminate ? laminate->directions.size() : cells;
  if (given != cells && given != 1 && !(laminate && given == 0))
    add("region '" + region + "' has " + std::to_string(cells) + " elements and " + std::to_string(given) +
            (beam ? " placements" : " directions"),
        "give one for all elements, or one for each");
}

// A shear factor of 0 stands for a beam without shear deformation (Euler-Bernoulli), so it is allowed. Area and
// second moments are not: a zero would leave a motion of the beam without stiffness.
void Validator::check_section(const std::string& region, const BeamSection& section) {
  for (const auto& [what, value] : {std::pair{"area", section.area},
                                    {"inertia_y", section.inertia_y},
                                    {"inertia_z", section.inertia_z},
                                    {"torsion", section.torsion}})
    if (!is_positive(value))
      add("the section of region '" + region + "' has " + what + " " + shortest(value),
          "it must be positive and finite");
  for (const double value : {section.shear_factor_y, section.shear_factor_z})
    if (!(value >= 0.0) || !std::isfinite(value))
      add("the section of region '" + region + "' has the shear factor " + shortest(value),
          "a shear factor must be positive, or 0 for a beam that is rigid in shear");
}

void Validator::check_beam(const std::string& region, const BeamProperty& beam) {
  check_section(region, beam.section);
  for (const auto& station : beam.stations) check_section(region, station.section);
  const bool in_order = std::ranges::adjacent_find(beam.stations, std::ranges::greater_equal{}, &BeamStation::place) ==
                        beam.stations.end();
  if (!beam.stations.empty() && (beam.stations.size() < 2 || beam.stations.front().place != 0.0 ||
                                 beam.stations.back().place != 1.0 || !in_order))
    add("the stations of region '" + region + "' do not lead from the first end of the beam to the second",
        "their places must ascend from 0 to 1", "correct their places");
  for (const auto& placement : beam.placements)
    if (!placement.up.allFinite() || !placement.offsets.allFinite()) {
      add("'up' or 'offset' of region '" + region + "' is not finite", "both must be vectors of finite numbers");
      break;
    }
}

/// A region whose cells no property covers would be left out of the structure silently.
void Validator::check_regions() {
  if (model_.properties.empty() && model_.masses.empty() && model_.springs.empty() && model_.joints.empty() &&
      model_.matrices.empty())
    add("the model '" + model_.name + "' has no properties, masses or springs", "there is nothing to assemble",
        "give a region of the mesh a property");
  std::vector<bool> covered(mesh_.cells.size(), false);
  for (const auto& [region, property] : model_.properties)
    if (const auto cells = mesh_.regions.find(region); cells != mesh_.regions.end())
      for (const auto cell : cells->second) covered[static_cast<std::size_t>(cell)] = true;
  for (const auto& [region, cells] : mesh_.regions) {
    const auto missing = std::ranges::count_if(cells, [&](auto cell) {
      const auto index = static_cast<std::size_t>(cell);
      return dimension(mesh_.cells[index].shape) > 0 && !covered[index];
    });
    if (missing > 0)
      add("missing property for region '" + region + "': " + std::to_string(missing) + " of its elements have none",
          "these elements would be missing from the structure",
          "give the region a property or remove it from the mesh");
  }
  check_overlaps();
}

// Each cell keeps the region that claimed it first. A pair of regions is told once, however many cells they share.
/// A cell in two regions with properties, or twice in one, would count twice.
void Validator::check_overlaps() {
  std::vector<const std::string*> owner(mesh_.cells.size(), nullptr);
  std::set<std::pair<std::string, std::string>> told;
  for (const auto& [region, property] : model_.properties) {
    const auto cells = mesh_.regions.find(region);
    if (cells == mesh_.regions.end()) continue;
    for (const auto index : cells->second) {
      auto& first = owner[static_cast<std::size_t>(index)];
      if (first && told.insert({*first, region}).second) {
        const auto& cell = mesh_.cells[static_cast<std::size_t>(index)];
        add(to_string(cell.shape) + " " + std::to_string(cell.id) + " belongs to region '" + *first +
                "' and also to '" + region + "'",
            "it would be counted twice", "keep it in one region with a property");
      }
      first = &region;
    }
  }
}

bool Validator::check_node(Eigen::Index node, const std::string& title) {
  if (node >= 0 && node < mesh_.node_count()) return true;
  nodes_exist_ = false;
  add(title + " names the node at position " + std::to_string(node) + " of " + std::to_string(mesh_.node_count()),
      "it does not exist", "refer to a node of the mesh");
  return false;
}

bool Validator::check_dof(const NodalDof& dof, const std::string& title) {
  if (dof.direction >= 0 && dof.direction < 6) return check_node(dof.node, title);
  nodes_exist_ = false;
  add(title + " acts in direction " + std::to_string(dof.direction), "directions must be x, y, z, rx, ry, rz (0 to 5)");
  return false;
}

/// Names lead to parameters and stand in messages.
template <typename Item>
void Validator::check_names(const std::vector<Item>& items, const std::string& kind) {
  std::set<std::string> seen;
  for (const auto& item : items)
    if (!seen.insert(item.name).second)
      add("the " + kind + " '" + item.name + "' is given twice", "names must be unique", "rename one of them");
}

// An inertia tensor is symmetric with non-negative principal moments. A zero tensor is a pure point mass.
void Validator::check_masses() {
  check_names(model_.masses, "point mass");
  for (const auto& mass : model_.masses) {
    const std::string title = "point mass '" + mass.name + "'";
    check_node(mass.node, title);
    if (!(mass.mass >= 0.0) || !std::isfinite(mass.mass))
      add(title + " has the mass " + shortest(mass.mass), "a mass must be finite and not negative",
          "give the mass in kg");
    const auto& inertia = mass.inertia;
    if (!mass.offset.allFinite() || !inertia.allFinite()) {
      add(title + " has an offset or an inertia that is not finite", "both must be finite, in m and kg m^2");
      continue;
    }
    const double scale = inertia.cwiseAbs().maxCoeff();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal(inertia, Eigen::EigenvaluesOnly);
    // Entries typed with few digits may miss symmetry and definiteness by rounding.
    if ((inertia - inertia.transpose()).cwiseAbs().maxCoeff() > 1e-9 * scale ||
        principal.eigenvalues().minCoeff() < -1e-9 * scale)
      add(title + " has an inertia that is not symmetric or has a negative principal moment",
          "such an inertia is physically impossible");
  }
}

// A spring acts between two degrees of freedom, or between one and a named ground. Negative values are refused: they
// would make K or C indefinite.
void Validator::check_springs() {
  check_names(model_.springs, "spring");
  for (const auto& spring : model_.springs) {
    const std::string title = "spring '" + spring.name + "'";
    check_dof(spring.from, title);
    if (spring.to) check_dof(*spring.to, title);
    if (spring.to && *spring.to == spring.from)
      add(title + " connects a degree of freedom to itself", "it has no effect",
          "name two different ones, or one and a ground");
    for (const auto& [what, value] : {std::pair{"stiffness", spring.stiffness}, {"damping", spring.damping}})
      if (!(value >= 0.0) || !std::isfinite(value))
        add(title + " has the " + what + " " + shortest(value),
            "stiffness and damping of a spring must be finite and not negative");
  }
}

// A joint acts on a weighted sum of displacements, d = sum c_i u_i, and adds k c c^T to the stiffness.
void Validator::check_joints() {
  check_names(model_.joints, "joint");
  for (const auto& joint : model_.joints) {
    const std::string title = "joint '" + joint.name + "'";
    bool finite = std::isfinite(joint.stiffness) && std::isfinite(joint.damping);
    for (const auto& [dof, coefficient] : joint.deformation) {
      check_dof(dof, title);
      finite = finite && std::isfinite(coefficient);
    }
    if (!finite || joint.stiffness < 0.0 || joint.damping < 0.0 || joint.deformation.empty())
      add(title + " has no deformation, or a stiffness or damping that is negative or not finite",
          "a spring needs a deformation and finite, non-negative values");
  }
}

// Imported matrices may come from text with few digits, so symmetry is tested against 1e-9 of the matrix norm. The
// comparison is negated so that NaN fails it.
void Validator::check_matrices() {
  check_names(model_.matrices, "matrix");
  for (const auto& item : model_.matrices) {
    const std::string title = "matrix '" + item.name + "'";
    for (const auto& dof : item.dofs) check_dof(dof, title);
    const auto size = static_cast<Eigen::Index>(item.dofs.size());
    for (const auto* matrix : {&item.stiffness, &item.mass, &item.damping}) {
      if (matrix->size() == 0) continue;
      if (matrix->rows() != size || matrix->cols() != size) {
        add(title + " is " + std::to_string(matrix->rows()) + " x " + std::to_string(matrix->cols()) + " for " +
                std::to_string(size) + " degrees of freedom",
            "every row needs a degree of freedom");
        continue;
      }
      const Eigen::SparseMatrix<double> difference = *matrix - Eigen::SparseMatrix<double>(matrix->transpose());
      if (!(difference.norm() <= 1e-9 * matrix->norm()))
        add(title + " is not symmetric, or not finite", "stiffness, mass and damping must be symmetric and finite");
    }
  }
}

// A factor without a part would have no effect, and one of a part that does not exist hides a mistake.
void Validator::check_factors() {
  check_names(model_.factors, "factor");
  std::set<std::string> of_matrices;
  for (const auto& item : model_.matrices) {
    if (item.factor.empty()) continue;
    of_matrices.insert(item.factor);
    if (std::ranges::find(model_.factors, item.factor, &PartFactor::name) == model_.factors.end())
      add("matrix '" + item.name + "' has the factor '" + item.factor + "', which the model does not have",
          "its value is not known", "add it to the factors of the model");
  }
  for (const auto& factor : model_.factors) {
    const std::string title = "factor '" + factor.name + "'";
    if (!std::isfinite(factor.value)) add(title + " has no finite value", "it multiplies matrices");
    if (factor.cells.empty() && !of_matrices.contains(factor.name))
      add(title + " multiplies neither elements nor matrices", "it would have no effect", "remove it");
    const auto exists = [&](Eigen::Index cell) { return cell >= 0 && cell < std::ssize(mesh_.cells); };
    if (!std::ranges::all_of(factor.cells, exists))
      add(title + " has an element that does not exist", "a factor must list elements of the mesh");
  }
}

// A weighted link is the average motion of RBE3 (Nastran) or a distributing coupling (Abaqus), and needs positive
// weights. A rigid link is RBE2 or a kinematic coupling. Which of their motions are determined follows from geometry,
// and constraint_issues() tests that.
void Validator::check_links() {
  check_names(model_.links, "rigid link");
  check_names(model_.weighted_links, "weighted link");
  for (const auto& link : model_.weighted_links) {
    const std::string title = "weighted link '" + link.name + "'";
    check_node(link.follower, title);
    for (const auto& share : link.shares) {
      check_node(share.node, title);
      if (!is_positive(share.weight))
        add(title + " has the weight " + shortest(share.weight), "a weight must be positive and finite");
    }
    if (link.shares.empty())
      add(title + " follows no nodes", "it must take the weighted mean motion of other nodes", "name them");
  }
  for (const auto& link : model_.links) {
    const std::string title = "rigid link '" + link.name + "'";
    check_node(link.master, title);
    for (const auto slave : link.slaves) check_node(slave, title);
    if (link.slaves.empty())
      add(title + " has no slaves", "a rigid link needs at least one", "name the nodes that follow");
  }
}

void Validator::check_constraints() {
  check_names(model_.constraints, "constraint");
  for (const auto& constraint : model_.constraints)
    for (const auto& [dof, coefficient] : constraint.terms) check_dof(dof, "constraint '" + constraint.name + "'");
}

void Validator::check_supports() {
  for (const auto& support : model_.fixed)
    for (const auto node : support.nodes) check_node(node, "support '" + support.name + "'");
}

}  // namespace

int direction_index(const std::string& name) {
  const auto place = std::ranges::find(direction_names, name);
  return place == direction_names.end() ? -1 : static_cast<int>(place - direction_names.begin());
}

std::string dof_name(std::int64_t node_id, int direction) {
  return "n" + std::to_string(node_id) + "." + direction_names[static_cast<std::size_t>(direction)];
}

std::string dof_name(const Mesh& mesh, const NodalDof& dof) {
  return dof_name(mesh.node_ids[static_cast<std::size_t>(dof.node)], dof.direction);
}

std::vector<Issue> validate(const FiniteElementModel& model) { return Validator(model).run(); }

}  // namespace kalfem
