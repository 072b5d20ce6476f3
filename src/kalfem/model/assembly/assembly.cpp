// SPDX-License-Identifier: Apache-2.0
#include "kalfem/model/assembly/assembly.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <set>

#include "kalfem/model/assembly/constraints.hpp"
#include "kalfem/model/assembly/matrix_sums.hpp"
#include "kalfem/model/assembly/rigid_motion.hpp"
#include "kalfem/model/assembly/shell_edges.hpp"
#include "kalfem/model/elements/beam.hpp"
#include "kalfem/model/elements/shell.hpp"
#include "kalfem/model/elements/solid.hpp"

namespace kalfem {
namespace {

using Powers = std::map<std::string, int>;
using Terms = std::map<Powers, SparseMatrix>;
using Values = std::map<std::string, double>;

/// Of more problems of one kind than this, only the number is told.
constexpr std::size_t most_cells_told = 5;

template <int columns>
Eigen::Matrix<double, 3, columns> corners(const Mesh& mesh, const Cell& cell) {
  Eigen::Matrix<double, 3, columns> places;
  for (int i = 0; i < columns; ++i) places.col(i) = mesh.nodes.col(mesh.nodes_of(cell)[static_cast<std::size_t>(i)]);
  return places;
}

/// Element matrices of the cells of one kind of property.
struct ElementMaker {
  const FiniteElementModel& model;
  const Cell& cell;
  const DrillingOptions& drilling;
  std::size_t place;  ///< of the cell in its region
  const std::vector<BeamPart>& parts;

  ElementMatrices operator()(const ShellProperty& shell) const {
    const double nu = model.materials.at(shell.material).poissons_ratio;
    return cell.shape == CellShape::triangle3
               ? shell3(corners<3>(model.mesh, cell), nu, shell, model.mass_kind, drilling)
               : shell4(corners<4>(model.mesh, cell), nu, shell, model.mass_kind, drilling);
  }
  ElementMatrices operator()(const BeamProperty& property) const {
    const double nu = model.materials.at(property.material).poissons_ratio;
    return beam(corners<2>(model.mesh, cell), property, property.placement(place), nu, model.mass_kind, parts);
  }
  ElementMatrices operator()(const LaminateProperty& property) const {
    return laminate(all_nodes(), property, property.direction(place), model.mass_kind, drilling);
  }
  ElementMatrices operator()(const SolidProperty& property) const {
    const double nu = model.materials.at(property.material).poissons_ratio;
    return solid(cell.shape, all_nodes(), property, nu, model.mass_kind);
  }

  [[nodiscard]] Eigen::Matrix3Xd all_nodes() const { return model.mesh.nodes(Eigen::all, model.mesh.nodes_of(cell)); }
};

std::string part_factor_name(const std::string& factor) { return factor + ".factor"; }
std::string factor_name(const std::string& region, BeamPart part) { return region + "." + to_string(part); }

Powers named_powers(const PropertyPowers& powers, const std::string& region, const std::string& material) {
  Powers named;
  if (powers.youngs_modulus != 0) named[material + ".youngs_modulus"] = powers.youngs_modulus;
  if (powers.density != 0) named[material + ".density"] = powers.density;
  if (powers.thickness != 0) named[region + ".thickness"] = powers.thickness;
  if (powers.part != BeamPart::none) named[factor_name(region, powers.part)] = 1;
  return named;
}

void add_to(Terms& terms, const Powers& powers, SparseMatrix matrix) {
  auto [place, is_new] = terms.try_emplace(powers, std::move(matrix));
  if (!is_new) place->second = SparseMatrix(place->second + matrix);
}

std::vector<AffineTerm> to_list(Terms terms) {
  std::vector<AffineTerm> list;
  while (!terms.empty()) {
    auto first = terms.extract(terms.begin());
    list.push_back({first.key(), std::move(first.mapped())});
  }
  return list;
}

/// At least one term, so that the sum has its size.
std::vector<AffineTerm> to_list(Terms terms, Eigen::Index size) {
  if (terms.empty()) terms.emplace(Powers{}, SparseMatrix(size, size));
  return to_list(std::move(terms));
}

// A degree of freedom without element, spring or mass has no equation: it is left out before the elimination, so that a
// solid's nodes have three and a beam's six.
/// Degrees of freedom at which an element, spring or mass acts, by position among all.
std::vector<bool> touched_dofs(const FiniteElementModel& model) {
  std::vector<bool> touched(static_cast<std::size_t>(6 * model.mesh.node_count()), false);
  const auto touch = [&](const NodalDof& dof) { touched[static_cast<std::size_t>(all_index(dof))] = true; };
  for (const auto& [region, property] : model.properties)
    for (const auto cell : model.mesh.regions.at(region))
      for (const auto node : model.mesh.nodes_of(model.mesh.cells[static_cast<std::size_t>(cell)]))
        for (int direction = 0; direction < motions_per_node(property); ++direction) touch({node, direction});
  for (const auto& mass : model.masses) {
    const auto matrix = point_mass(mass);
    for (int direction = 0; direction < 6; ++direction)
      if (matrix(direction, direction) != 0.0) touch({mass.node, direction});
  }
  for (const auto& spring : model.springs) {
    touch(spring.from);
    if (spring.to) touch(*spring.to);
  }
  for (const auto& joint : model.joints)
    for (const auto& [dof, coefficient] : joint.deformation) touch(dof);
  for (const auto& item : model.matrices)
    for (const auto& dof : item.dofs) touch(dof);
  return touched;
}

/// Which factors of parts each element has. Elements of the same ones share a set.
class FactorSets {
public:
  explicit FactorSets(const FiniteElementModel& model) : sets_(1) {
    if (model.factors.empty()) return;
    of_cell_.resize(model.mesh.cells.size(), 0);
    std::map<std::pair<std::size_t, const PartFactor*>, std::size_t> joined;
    for (const auto& factor : model.factors)
      for (const auto cell : factor.cells) {
        auto& set = of_cell_[static_cast<std::size_t>(cell)];
        const auto [place, is_new] = joined.try_emplace({set, &factor}, sets_.size());
        if (is_new) {
          sets_.push_back(sets_[set]);
          sets_.back().push_back(&factor);
        }
        set = place->second;
      }
  }

  [[nodiscard]] std::size_t of(Eigen::Index cell) const {
    return of_cell_.empty() ? 0 : of_cell_[static_cast<std::size_t>(cell)];
  }
  void add_powers(std::size_t set, FactorOf what, Powers& powers) const {
    for (const auto* factor : sets_[set])
      if (factor->of == what || factor->of == FactorOf::both) powers[part_factor_name(factor->name)] = 1;
  }

private:
  std::vector<std::vector<const PartFactor*>> sets_;
  std::vector<std::size_t> of_cell_;
};

// How a model is assembled:
//   1. eliminate() leaves the free degrees of freedom and S with u_all = S u_free, S sparse;
//   2. a region: the pattern of its matrices once, then every element adds S_e^T k S_e into the values. Terms that
//      depend on different powers of parameters (E t, E t^3, rho t) are separate sums over the same pattern, or one at
//      their present values;
//   3. masses, springs and joints are each a term of the parameter of their own; matrices of another code have none, or
//      that of the factor of their part. A factor that no parameter asks for multiplies at its value.
// So K and M at other parameters are sums of what was assembled once. Element shapes that cannot be integrated are
// collected over a region and reported together.
/// Sums up the parts of a model over the free degrees of freedom that the elimination leaves.
class Assembler {
public:
  /// `factors`: those by which the stiffness of beam regions and point masses are divided. `held`: factors of parts
  /// that are no parameters. `present`: values of all parameters, where the terms shall be summed at them.
  Assembler(const FiniteElementModel& model, const Elimination& elimination, const Values& factors, const Values& held,
            const Values* present)
      : rigid_mass(model.mesh),
        model_(model),
        edges_(model),
        sets_(model),
        transform_(elimination.transform),
        factors_(factors),
        held_(held),
        present_(present) {}

  void add_region(const std::string& region, const RegionProperty& property, IssueList& issues);
  void add_masses();
  void add_springs();
  void add_matrices();

  Terms stiffness, mass;
  SparseMatrix damping;
  Terms factored_damping;
  std::vector<GroundCoupling> grounds;
  RigidMassSum rigid_mass;

private:
  using Triplets = std::vector<Eigen::Triplet<double>>;
  using TripletTerms = std::map<Powers, Triplets>;
  /// Values of a region's terms over its pattern, and to which of them its element matrices are added, times a factor.
  struct Sums {
    struct Share {
      std::vector<double>* values;
      double factor;
    };
    std::map<Powers, std::vector<double>> values;
    std::map<std::pair<std::size_t, PropertyPowers>, Share> shares;  ///< by the factors of the element, too
  };

  /// Into which a region's stiffness is divided.
  [[nodiscard]] std::vector<BeamPart> asked_parts(const std::string& region, const RegionProperty& property) const {
    const auto* beam = std::get_if<BeamProperty>(&property);
    if (!beam) return {BeamPart::none};
    auto parts = parts_of(*beam);
    return factors_.contains(factor_name(region, parts.front())) ? parts : std::vector{BeamPart::none};
  }

  /// The term to which a matrix with these powers is added, and the factor with which it is.
  [[nodiscard]] std::pair<Powers, double> term_of(const Powers& powers) const {
    auto [free, factor] = without_held(powers);
    if (!present_) return {std::move(free), factor};
    return {{}, factor * affine_factor(free, *present_)};
  }

  /// Powers of the parameters, and the product of the factors that are none.
  [[nodiscard]] std::pair<Powers, double> without_held(Powers powers) const {
    double factor = 1.0;
    for (const auto& [name, value] : held_)
      if (powers.erase(name) > 0) factor *= value;
    return {std::move(powers), factor};
  }

  [[nodiscard]] const Cell& cell(Eigen::Index index) const {
    return model_.mesh.cells[static_cast<std::size_t>(index)];
  }

  /// Targets of the row `row` of a small matrix that stands, times `share`, at the position `all` among all degrees of
  /// freedom.
  void append_targets(int row, Eigen::Index all, Scatter& scatter, double share = 1.0) const {
    for (Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator it(transform_, all); it; ++it)
      scatter.push_back({row, static_cast<int>(it.col()), share * it.value()});
  }

  template <typename Nodes>
  void scatter_of(const Nodes& nodes, int motions, Scatter& scatter) const {
    scatter.clear();
    int row = 0;
    for (const auto node : nodes)
      for (int direction = 0; direction < motions; ++direction) append_targets(row++, 6 * node + direction, scatter);
  }

  /// Of the motions of a cell's corners, to which more than those of its nodes may add.
  void stiffness_scatter_of(Eigen::Index index, int motions, Scatter& scatter) const {
    scatter_of(model_.mesh.nodes_of(cell(index)), motions, scatter);
    for (const auto& [row, dof, share] : edges_.shares(index)) append_targets(row, dof, scatter, share);
  }

  static void append(const Scatter& scatter, const Eigen::MatrixXd& matrix, Triplets& triplets) {
    for (const auto& [i, row, row_coefficient] : scatter)
      for (const auto& [j, column, column_coefficient] : scatter)
        triplets.emplace_back(row, column, row_coefficient * column_coefficient * matrix(i, j));
  }

  [[nodiscard]] SparseMatrix from_triplets(const Triplets& triplets) const {
    SparseMatrix matrix(transform_.cols(), transform_.cols());
    matrix.setFromTriplets(triplets.begin(), triplets.end());
    return matrix.pruned();
  }

  [[nodiscard]] SparseSumPattern pattern_of(const std::vector<Eigen::Index>& cells, int motions) const;
  void report(const std::vector<std::pair<Eigen::Index, std::string>>& bad, const std::string& region,
              IssueList& issues) const;

  GroundCoupling& ground(const std::string& name) {
    for (auto& coupling : grounds)
      if (coupling.ground == name) return coupling;
    const auto zero = Eigen::VectorXd::Zero(transform_.cols());
    return grounds.emplace_back(GroundCoupling{name, zero, zero});
  }

  /// A ground that moves by r pulls with k r at `from`.
  void add_ground_force(const NodalSpring& spring, const Scatter& from) {
    auto& coupling = ground(spring.ground);
    for (const auto& target : from) {
      coupling.stiffness[target.column] += spring.stiffness * target.coefficient;
      coupling.damping[target.column] += spring.damping * target.coefficient;
    }
  }

  const FiniteElementModel& model_;
  const ShellEdges edges_;
  const FactorSets sets_;
  const Eigen::SparseMatrix<double, Eigen::RowMajor>& transform_;
  const Values& factors_;
  const Values& held_;
  const Values* present_;
};

SparseSumPattern Assembler::pattern_of(const std::vector<Eigen::Index>& cells, int motions) const {
  Scatter scatter;
  return {transform_.cols(), [&](const SparseSumPattern::Visitor& visit) {
            for (const auto index : cells) {
              stiffness_scatter_of(index, motions, scatter);
              visit(scatter);
            }
          }};
}

void Assembler::add_region(const std::string& region, const RegionProperty& property, IssueList& issues) {
  const auto& cells = model_.mesh.regions.at(region);
  const int motions = motions_per_node(property);
  const auto pattern = pattern_of(cells, motions);
  const auto parts = asked_parts(region, property);
  Sums stiffness_sums, mass_sums;
  std::map<std::pair<std::size_t, PropertyPowers>, Matrix6> rigid_sums;
  Scatter scatter;
  const auto powers_of = [&](const PropertyPowers& own, std::size_t set, FactorOf what) {
    Powers powers = named_powers(own, region, material_of(property));
    sets_.add_powers(set, what, powers);
    return powers;
  };
  const auto add_terms = [&](const std::vector<ElementTerm>& terms, std::size_t set, FactorOf what, Sums& sums) {
    for (const auto& term : terms) {
      const auto [share, is_new] = sums.shares.try_emplace({set, term.powers});
      if (is_new) {
        const auto [powers, factor] = term_of(powers_of(term.powers, set, what));
        auto& values = sums.values[powers];
        if (values.empty()) values = pattern.zero();
        share->second = {&values, factor};
      }
      pattern.add(scatter, share->second.factor * term.matrix, *share->second.values);
    }
  };
  std::vector<std::pair<Eigen::Index, std::string>> bad;
  for (std::size_t i = 0; i < cells.size(); ++i) try {
      const auto& each = cell(cells[i]);
      const auto set = sets_.of(cells[i]);
      const auto matrices = std::visit(ElementMaker{model_, each, edges_.drilling(cells[i]), i, parts}, property);
      stiffness_scatter_of(cells[i], motions, scatter);
      add_terms(matrices.stiffness, set, FactorOf::stiffness, stiffness_sums);
      scatter_of(model_.mesh.nodes_of(each), motions, scatter);
      add_terms(matrices.mass, set, FactorOf::mass, mass_sums);
      for (const auto& term : matrices.mass)
        rigid_sums.try_emplace({set, term.powers}, Matrix6::Zero()).first->second +=
            rigid_mass.of(model_.mesh.nodes_of(each), motions, term.matrix);
    } catch (const ElementShapeError& error) {
      bad.emplace_back(cells[i], error.what());
    }
  report(bad, region, issues);
  const auto move_sums = [&](Sums& sums, Terms& terms) {
    for (auto& [powers, sum] : sums.values) {
      const auto values = std::move(sum);  // as large as the matrix: not kept beside it for longer
      add_to(terms, powers, pattern.matrix(values));
    }
  };
  for (const auto& [key, sum] : rigid_sums) {
    const auto [powers, factor] = without_held(powers_of(key.second, key.first, FactorOf::mass));
    rigid_mass.add(powers, factor * sum);
  }
  move_sums(mass_sums, mass);
  move_sums(stiffness_sums, stiffness);
}

/// One message for each reason, with the first of its cells.
void Assembler::report(const std::vector<std::pair<Eigen::Index, std::string>>& bad, const std::string& region,
                       IssueList& issues) const {
  std::map<std::string, std::vector<Eigen::Index>> by_reason;
  for (const auto& [index, why] : bad) by_reason[why].push_back(index);
  for (const auto& [why, cells] : by_reason) {
    std::string names;
    for (std::size_t i = 0; i < std::min(cells.size(), most_cells_told); ++i)
      names += (i == 0 ? "" : ", ") + to_string(cell(cells[i]).shape) + " " + std::to_string(cell(cells[i]).id);
    if (cells.size() > most_cells_told) names += " and " + std::to_string(cells.size() - most_cells_told) + " more";
    const std::string count = cells.size() > 1 ? std::to_string(cells.size()) + " elements (" + names + ")" : names;
    issues.add({model_.mesh.source, 0}, count + " of region '" + region + "' cannot be integrated", why,
               "correct the mesh, or the property of the region");
  }
}

// A point mass is linear in its mass with the inertia held: M = m M_1 + M_J. M_1 has a unit mass at the offset and no
// inertia and belongs to the parameter, and to the offset where that is one; M_J is constant.
void Assembler::add_masses() {
  TripletTerms triplets;
  Scatter scatter;
  for (const auto& item : model_.masses) {
    scatter_of(std::array{item.node}, 6, scatter);
    PointMass inertia = item;
    inertia.mass = 0.0;
    const auto add = [&](const Eigen::MatrixXd& matrix, const Powers& powers) {
      const auto [term, factor] = term_of(powers);
      append(scatter, factor * matrix, triplets[term]);
      rigid_mass.add(powers, rigid_mass.of(std::array{item.node}, 6, matrix));
    };
    const std::string mass_name = item.name + ".mass";
    if (factors_.contains(item.name + ".offset_x"))
      for (auto& [powers, matrix] : unit_mass_by_offset(item.name)) {
        powers[mass_name] = 1;
        add(matrix, powers);
      }
    else
      add(unit_mass_at(item.offset), {{mass_name, 1}});
    if (!item.inertia.isZero(0.0)) add(point_mass(inertia), {});
  }
  for (const auto& [powers, entries] : triplets) add_to(mass, powers, from_triplets(entries));
}

void Assembler::add_springs() {
  TripletTerms triplets;
  Triplets dashpots;
  Scatter scatter;
  for (const auto& spring : model_.springs) {
    scatter.clear();
    append_targets(0, all_index(spring.from), scatter);
    if (spring.to)
      append_targets(1, all_index(*spring.to), scatter);
    else
      add_ground_force(spring, scatter);
    const Eigen::MatrixXd unit = Eigen::Matrix2d{{1.0, -1.0}, {-1.0, 1.0}};
    const auto [term, factor] = term_of({{spring.name + ".stiffness", 1}});
    append(scatter, factor * unit, triplets[term]);
    if (spring.damping != 0.0) append(scatter, spring.damping * unit, dashpots);
  }
  for (const auto& joint : model_.joints) {
    scatter.clear();
    Eigen::VectorXd coefficients(static_cast<Eigen::Index>(joint.deformation.size()));
    for (int row = 0; row < coefficients.size(); ++row) {
      const auto& [dof, coefficient] = joint.deformation[static_cast<std::size_t>(row)];
      append_targets(row, all_index(dof), scatter);
      coefficients[row] = coefficient;
    }
    const Eigen::MatrixXd unit = coefficients * coefficients.transpose();
    const auto [term, factor] = term_of({{joint.name + ".stiffness", 1}});
    append(scatter, factor * unit, triplets[term]);
    if (joint.damping != 0.0) append(scatter, joint.damping * unit, dashpots);
  }
  for (const auto& [powers, entries] : triplets) add_to(stiffness, powers, from_triplets(entries));
  damping = from_triplets(dashpots);
}

/// S^T A S with the rows S of the transform at the matrices' degrees of freedom.
void Assembler::add_matrices() {
  for (const auto& item : model_.matrices) {
    SparseMatrix rows(static_cast<Eigen::Index>(item.dofs.size()), transform_.cols());
    std::vector<Eigen::Triplet<double>> entries;
    Scatter scatter;
    for (std::size_t i = 0; i < item.dofs.size(); ++i)
      append_targets(static_cast<int>(i), all_index(item.dofs[i]), scatter);
    for (const auto& [row, column, coefficient] : scatter) entries.emplace_back(row, column, coefficient);
    rows.setFromTriplets(entries.begin(), entries.end());
    const Powers own = item.factor.empty() ? Powers{} : Powers{{part_factor_name(item.factor), 1}};
    const auto [powers, factor] = term_of(own);
    const auto projected = [&, share = factor](const SparseMatrix& matrix) {
      return SparseMatrix(share * (rows.transpose() * matrix * rows));
    };
    if (item.stiffness.size() > 0) add_to(stiffness, powers, projected(item.stiffness));
    if (item.mass.size() > 0) {
      add_to(mass, powers, projected(item.mass));
      const auto [of_rigid, share] = without_held(own);
      rigid_mass.add(of_rigid, share * rigid_mass.of(item.dofs, item.mass));
    }
    if (item.damping.size() == 0) continue;
    if (powers.empty())
      damping = SparseMatrix(damping + projected(item.damping));
    else
      add_to(factored_damping, powers, projected(item.damping));
  }
}

// Parts of a beam's stiffness are separate terms only where a parameter asks for them: each costs a matrix.
/// All factors of the beam regions, and all offsets of the point masses, that the options name one of.
Values asked_factors(const FiniteElementModel& model, const AssemblyOptions& options) {
  auto factors = beam_factors(model);
  factors.merge(mass_offsets(model));
  const auto region_of = [](const std::string& name) { return name.substr(0, name.rfind('.')); };
  std::set<std::string> regions;
  for (const auto& name : options.parameters)
    if (factors.contains(name)) regions.insert(region_of(name));
  std::erase_if(factors, [&](const auto& factor) { return !regions.contains(region_of(factor.first)); });
  return factors;
}

void require_own_names(const Values& factors, const Values& values, const std::string& source) {
  IssueList issues;
  for (const auto& [name, value] : factors)
    if (values.contains(name))
      issues.add({source, 0}, "'" + name + "' is both a factor of a beam region and the stiffness of a spring",
                 "names of parameters must be unique", "rename the spring or the region");
  issues.raise();
}

FiniteElementModel without_supports(FiniteElementModel model) {
  model.fixed.clear();
  return model;
}

Values present_values(const FiniteElementModel& model) {
  Values values;
  for (const auto& [region, property] : model.properties) {
    const auto name = material_of(property);
    if (name.empty()) continue;
    const auto& material = model.materials.at(name);
    values[name + ".youngs_modulus"] = material.youngs_modulus;
    values[name + ".density"] = material.density;
    if (const auto* shell = std::get_if<ShellProperty>(&property)) values[region + ".thickness"] = shell->thickness;
  }
  for (const auto& mass : model.masses) values[mass.name + ".mass"] = mass.mass;
  for (const auto& spring : model.springs) values[spring.name + ".stiffness"] = spring.stiffness;
  for (const auto& joint : model.joints) values[joint.name + ".stiffness"] = joint.stiffness;
  return values;
}

}  // namespace

Eigen::Index AssembledModel::find(const NodalDof& dof) const {
  const auto place = std::ranges::lower_bound(dofs, dof);
  return place != dofs.end() && *place == dof ? place - dofs.begin() : -1;
}

Values beam_factors(const FiniteElementModel& model) {
  Values factors;
  for (const auto& [region, property] : model.properties)
    if (const auto* beam = std::get_if<BeamProperty>(&property))
      for (const auto part : parts_of(*beam)) factors[factor_name(region, part)] = 1.0;
  return factors;
}

Values mass_offsets(const FiniteElementModel& model) {
  Values offsets;
  for (const auto& mass : model.masses) {
    offsets[mass.name + ".offset_x"] = mass.offset.x();
    offsets[mass.name + ".offset_y"] = mass.offset.y();
    offsets[mass.name + ".offset_z"] = mass.offset.z();
  }
  return offsets;
}

Values part_factors(const FiniteElementModel& model) {
  Values factors;
  for (const auto& factor : model.factors) factors[part_factor_name(factor.name)] = factor.value;
  return factors;
}

SparseMatrix AssembledModel::viscous_damping(const Values& values) const {
  SparseMatrix sum = damping;
  if (!factored_damping.empty()) add_to(sum, evaluate(factored_damping, values));
  return sum;
}

AssembledModel assemble(const FiniteElementModel& model, const AssemblyOptions& options) {
  if (auto issues = validate(model); !issues.empty()) throw InvalidInput(std::move(issues));
  auto elimination = options.release_supports
                         ? eliminate(without_supports(model), touched_dofs(model), options.independent)
                         : eliminate(model, touched_dofs(model), options.independent);
  auto values = present_values(model);
  const auto factors = asked_factors(model, options);
  require_own_names(factors, values, model.mesh.source);
  values.insert(factors.begin(), factors.end());
  Values held = part_factors(model);
  for (const auto& name : options.parameters)
    if (const auto asked = held.extract(name)) values.insert({asked.key(), asked.mapped()});
  Assembler assembler(model, elimination, factors, held, options.at_present_values ? &values : nullptr);
  IssueList issues;
  for (const auto& [region, property] : model.properties) assembler.add_region(region, property, issues);
  issues.raise();
  assembler.add_masses();
  assembler.add_springs();
  assembler.add_matrices();
  const auto size = static_cast<Eigen::Index>(elimination.dofs.size());
  return {.parameters = std::move(values),
          .stiffness = to_list(std::move(assembler.stiffness), size),
          .mass = to_list(std::move(assembler.mass), size),
          .damping = std::move(assembler.damping),
          .factored_damping = to_list(std::move(assembler.factored_damping)),
          .grounds = std::move(assembler.grounds),
          .rigid_mass = assembler.rigid_mass.list(),
          .dofs = std::move(elimination.dofs),
          .expansion = elimination.transform};
}

}  // namespace kalfem
