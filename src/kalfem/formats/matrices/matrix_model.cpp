// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/matrices/matrix_model.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/formats/matrices/entries.hpp"
#include "kalfem/model/finite_element_model.hpp"

namespace kalfem {
namespace {

using Eigen::Index;

std::string quoted(const std::string& role, const ForeignMatrix& matrix) {
  return "the " + role + " matrix '" + matrix.name + "'";
}

// The largest magnitude scales the tolerance of symmetry, so that it holds in any units.
double largest(const SparseMatrix& matrix) {
  double value = 0.0;
  for (Index i = 0; i < matrix.nonZeros(); ++i) value = std::max(value, std::abs(matrix.valuePtr()[i]));
  return value;
}

// Matrices of one structure may lack rows of zeros: the model has every degree of freedom that one of them has.
/// Degrees of freedom of the model: those asked for, or all that a matrix has.
std::vector<MatrixDof> all_dofs(const std::vector<const ForeignMatrix*>& matrices,
                                const std::vector<MatrixDof>& given) {
  if (!given.empty()) return given;
  std::vector<MatrixDof> dofs;
  for (const ForeignMatrix* matrix : matrices) {
    if (matrix->dofs.empty() || matrix->dofs == dofs) continue;
    if (dofs.empty()) {
      dofs = matrix->dofs;
      continue;
    }
    auto sorted = dofs;
    sorted.insert(sorted.end(), matrix->dofs.begin(), matrix->dofs.end());
    std::ranges::sort(sorted);
    sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
    if (sorted.size() > dofs.size()) dofs = std::move(sorted);
  }
  return dofs;
}

// Brings each matrix to the degrees of freedom of the model: rows are moved by their names, the size is checked against
// the map, an asymmetry of the size of rounding is taken out silently and a larger one only where that was asked for,
// and a diagonal that no mass or stiffness can have is refused.
class Preparation {
public:
  Preparation(const MatrixModelOptions& options, std::vector<MatrixDof> dofs, Index size)
      : options_(options), dofs_(std::move(dofs)), size_(size) {
    for (std::size_t i = 0; i < dofs_.size(); ++i)
      if (!places_.emplace(dofs_[i], static_cast<Index>(i)).second)
        issues_.add({}, "degree of freedom " + to_string(dofs_[i]) + " is listed twice in the map",
                    "every row needs its own");
  }

  /// The matrix over all degrees of freedom, exactly symmetric.
  SparseMatrix prepared(const std::string& role, const ForeignMatrix& matrix, bool semi_definite) {
    SparseMatrix full = placed(role, matrix);
    if (full.rows() != size_ || full.cols() != size_) return SparseMatrix(size_, size_);
    if (!full.coeffs().allFinite())
      issues_.add({}, quoted(role, matrix) + " has an entry that is not finite", "every entry must be a finite number");
    else
      check_symmetry(role, matrix, full);
    if (semi_definite) check_diagonal(role, matrix, full);
    return full;
  }

  [[nodiscard]] const IssueList& issues() const { return issues_; }
  IssueList& issues() { return issues_; }
  std::vector<std::string> notes;

private:
  SparseMatrix placed(const std::string& role, const ForeignMatrix& matrix) {
    const SparseMatrix& entries = matrix.matrix;
    const std::string size = std::to_string(entries.rows()) + " x " + std::to_string(entries.cols());
    if (entries.rows() != entries.cols()) {
      issues_.add({}, quoted(role, matrix) + " is " + size, "it must be square");
      return {};
    }
    if (matrix.dofs.empty() || matrix.dofs == dofs_) {
      if (entries.rows() != size_)
        issues_.add({}, quoted(role, matrix) + " is " + size,
                    "there are " + std::to_string(size_) + " degrees of freedom",
                    "give the map that belongs to this matrix");
      return entries;
    }
    return moved(role, matrix);
  }

  // Rows keep their values and change their places: entry (i, j) goes to (to[i], to[j]). Degrees of freedom that the
  // matrix lacks keep rows of zeros.
  SparseMatrix moved(const std::string& role, const ForeignMatrix& matrix) {
    std::vector<Index> to(matrix.dofs.size(), 0);
    for (std::size_t i = 0; i < to.size(); ++i) {
      const auto place = places_.find(matrix.dofs[i]);
      if (place == places_.end()) {
        issues_.add({}, quoted(role, matrix) + " has degree of freedom " + to_string(matrix.dofs[i]),
                    "the map does not list it", "give the map that belongs to this matrix");
        return {};
      }
      to[i] = place->second;
    }
    std::vector<Eigen::Triplet<double>> entries;
    for (Index column = 0; column < matrix.matrix.outerSize(); ++column)
      for (SparseMatrix::InnerIterator it(matrix.matrix, column); it; ++it)
        entries.emplace_back(to[static_cast<std::size_t>(it.row())], to[static_cast<std::size_t>(column)], it.value());
    SparseMatrix full(size_, size_);
    full.setFromTriplets(entries.begin(), entries.end());
    return full;
  }

  void check_symmetry(const std::string& role, const ForeignMatrix& matrix, SparseMatrix& full) {
    const SparseMatrix transposed = full.transpose();
    const double difference = largest(full - transposed), scale = largest(full);
    if (difference == 0.0) return;
    full = SparseMatrix(0.5 * (full + transposed));
    const std::string part = shortest(difference / scale) + " of its largest entry";
    if (difference <= options_.rounding * scale) return;
    if (options_.symmetrise)
      notes.push_back(quoted(role, matrix) + " was not symmetric: its asymmetry is " + part +
                      "; its symmetric part is used");
    else
      issues_.add({}, quoted(role, matrix) + " is not symmetric: its asymmetry is " + part,
                  "the matrices of a linear structure are symmetric",
                  "export both triangles from the same data, or request the symmetric part");
  }

  // A necessary condition of a semi-definite matrix: no negative diagonal entry, and no other entry in the row of a
  // zero one. It costs one pass and names the row; the full test by a factorisation is part of the model check.
  void check_diagonal(const std::string& role, const ForeignMatrix& matrix, const SparseMatrix& full) {
    for (Index column = 0; column < size_; ++column) {
      const double diagonal = full.coeff(column, column);
      double beside = 0.0;
      for (SparseMatrix::InnerIterator it(full, column); it; ++it)
        if (it.row() != column) beside = std::max(beside, std::abs(it.value()));
      if (diagonal > 0.0 || (diagonal == 0.0 && beside == 0.0)) continue;
      issues_.add({}, quoted(role, matrix) + " has " + shortest(diagonal) + " on its diagonal at " + name(column),
                  diagonal < 0.0 ? "a mass or stiffness must not be negative"
                                 : "a row with other entries needs a positive diagonal",
                  "check the matrix and the sign convention of the other code");
      return;
    }
  }

  [[nodiscard]] std::string name(Index row) const {
    return dofs_.empty() ? "row " + std::to_string(row + 1) : to_string(dofs_[static_cast<std::size_t>(row)]);
  }

  const MatrixModelOptions& options_;
  std::vector<MatrixDof> dofs_;
  std::map<MatrixDof, Index> places_;
  Index size_;
  IssueList issues_;
};

// Massless degrees of freedom are common (rotations of lumped masses) and leave a note; no mass at all is an error.
void require_mass(const SparseMatrix& mass, IssueList& issues, std::vector<std::string>& notes) {
  const Index massless = (mass.diagonal().array() <= 0.0).count();
  if (massless == mass.rows())
    issues.add({}, "the mass matrix is zero", "a structure needs mass",
               "check that stiffness and mass are not exchanged");
  else if (massless > 0)
    notes.push_back(std::to_string(massless) + " degrees of freedom have no mass");
}

/// The motion of a node with several copies is their mean: the middle of an expanded shell or beam.
void add_means_of_copies(MatrixModel& result) {
  std::map<MatrixDof, std::vector<std::string>> copies;
  for (const auto& dof : result.dofs)
    if (dof.copy > 0) copies[{dof.node, dof.direction}].push_back(dof_name(dof));
  for (const auto& [dof, names] : copies)
    for (const auto& name : names) result.model.points[dof_name(dof)][name] = 1.0 / static_cast<double>(names.size());
  if (copies.empty()) return;
  const std::string first = dof_name(copies.begin()->first);
  result.notes.push_back(std::to_string(copies.size()) +
                         " degrees of freedom are listed several times in the map, as those of expanded shells do: " +
                         first + " is the mean of " + copies.begin()->second.front() + " and its copies");
}

// The three matrices of a model are recognised by the names of common codes: KAAX and MAAX of Nastran, K2GG of its
// DMIG, .sti and .mas of CalculiX, Kr and Mr of Sierra SD. The name is tried as it is, then behind its last separator
// (model_K), then without trailing digits. A matrix alone in its file also follows the extension of the file.
enum class Role { none, stiffness, mass, damping };

/// What a matrix is by its name: the whole of it, or what follows the last separator, without digits at the end.
Role role_of(std::string name) {
  static const std::map<std::string, Role> usual = [] {
    std::map<std::string, Role> roles;
    for (const char* k : {"k", "kr", "kaa", "kaax", "kxx", "kgg", "kff", "kll", "kred", "krr", "khh", "kg", "stiffness",
                          "stiff", "stif", "sti", "k2gg"})
      roles[k] = Role::stiffness;
    for (const char* m :
         {"m", "mr", "maa", "maax", "mxx", "mgg", "mff", "mll", "mred", "mrr", "mhh", "mg", "mass", "mas", "m2gg"})
      roles[m] = Role::mass;
    for (const char* c : {"c", "cr", "baa", "baax", "bxx", "bgg", "bff", "caa", "cxx", "cgg", "cred", "damping", "damp",
                          "dam", "dmpv", "d", "b2gg"})
      roles[c] = Role::damping;
    return roles;
  }();
  name = lower_case(name);
  for (int attempt = 0; attempt < 3; ++attempt) {
    if (const auto found = usual.find(name); found != usual.end()) return found->second;
    if (attempt == 0) name.erase(0, name.find_last_of("_-./ ") + 1);
    if (attempt == 1) name.erase(name.find_last_not_of("0123456789") + 1);
  }
  return Role::none;
}

struct Found {
  ForeignMatrix matrix;
  std::filesystem::path file;
  Role role = Role::none;
};

std::vector<Found> all_matrices(const std::vector<std::filesystem::path>& files, MatrixFormat format) {
  std::vector<Found> found;
  for (const auto& file : files) {
    auto matrices = read_matrices(file, {.format = format});
    const bool alone = matrices.size() == 1;
    for (auto& matrix : matrices) {
      Role role = role_of(matrix.name);
      auto plain = file;
      if (plain.extension() == ".gz") plain.replace_extension();
      const std::string end = plain.extension().string();
      if (alone && role_of(end) != Role::none) role = role_of(end);
      found.push_back({std::move(matrix), file, role});
    }
  }
  return found;
}

// By its name where one is given; otherwise by the usual names of the role, if exactly one square matrix has such a
// name.
std::optional<ForeignMatrix> chosen(const std::vector<Found>& all, Role role, const std::string& name,
                                    const std::string& meaning, bool needed, IssueList& issues) {
  std::vector<const Found*> fitting;
  std::vector<std::string> known;
  std::string list;
  for (const auto& found : all) {
    const bool square = found.matrix.matrix.rows() == found.matrix.matrix.cols();
    if (name.empty() ? found.role == role && square : lower_case(found.matrix.name) == lower_case(name))
      fitting.push_back(&found);
    known.push_back(found.matrix.name);
    list += (list.empty() ? "" : ", ") + found.matrix.name + " (" + std::to_string(found.matrix.matrix.rows()) + " x " +
            std::to_string(found.matrix.matrix.cols()) + ")";
  }
  if (fitting.size() == 1) return fitting.front()->matrix;
  const std::string file = all.empty() ? "" : all.front().file.string();
  if (fitting.size() > 1)
    issues.add({file, 0},
               std::to_string(fitting.size()) + " matrices may be the " + meaning + " matrix, '" +
                   fitting[0]->matrix.name + "' and '" + fitting[1]->matrix.name + "'",
               "one is required", "name it");
  else if (!name.empty())
    issues.add({file, 0}, "there is no matrix '" + name + "'" + did_you_mean(name, known), "there are " + list);
  else if (needed)
    issues.add({file, 0}, "it is unclear which matrix is the " + meaning + " matrix", "there are " + list, "name it");
  return {};
}

}  // namespace

namespace {

/// What the files hold beside the matrices that were chosen.
void add_notes_on_others(const std::vector<Found>& all, const std::vector<std::string>& chosen,
                         std::vector<std::string>& notes) {
  for (const auto& [matrix, file, role] : all) {
    const std::string where = file.filename().string() + ": ";
    for (const auto& note : matrix.notes) notes.push_back(where + note);
    if (std::ranges::find(chosen, matrix.name) == chosen.end())
      notes.push_back(where + "matrix '" + matrix.name + "' is not used");
  }
}

}  // namespace

std::string dof_name(const MatrixDof& dof) { return dof.direction < 0 ? to_string(dof) : "n" + to_string(dof); }

std::optional<MatrixDof> matrix_dof(const std::string& name) {
  if (name.size() < 2) return {};
  if (name[0] == 'q') {
    const auto number = whole_number(std::string_view(name).substr(1));
    return number && *number > 0 ? std::optional(MatrixDof{*number, -1}) : std::nullopt;
  }
  const std::size_t dot = name.find('.');
  if (name[0] != 'n' || dot == std::string::npos) return {};
  const auto node = whole_number(std::string_view(name).substr(1, dot - 1));
  const int direction = direction_index(name.substr(dot + 1));
  return node && *node > 0 && direction >= 0 ? std::optional(MatrixDof{*node, direction}) : std::nullopt;
}

// Steps: agree on the degrees of freedom, bring each matrix to them, check, name the rows. All matrices are prepared
// before problems are raised, so that one run tells all of them.
MatrixModel matrix_model(const ForeignMatrix& stiffness, const ForeignMatrix& mass,
                         const std::optional<ForeignMatrix>& damping, const MatrixModelOptions& options) {
  std::vector<const ForeignMatrix*> matrices{&stiffness, &mass};
  if (damping) matrices.push_back(&*damping);
  MatrixModel result;
  result.dofs = all_dofs(matrices, options.dofs);
  const Index size = result.dofs.empty() ? stiffness.matrix.rows() : static_cast<Index>(result.dofs.size());
  Preparation preparation(options, result.dofs, size);
  LinearModel& model = result.model;
  model.stiffness = preparation.prepared("stiffness", stiffness, true);
  model.mass = preparation.prepared("mass", mass, true);
  model.damping = damping ? preparation.prepared("damping", *damping, false) : SparseMatrix(size, size);
  if (preparation.issues().empty()) require_mass(model.mass, preparation.issues(), preparation.notes);
  preparation.issues().raise();
  for (Index i = 0; i < size; ++i)
    model.dofs.push_back(result.dofs.empty() ? "r" + std::to_string(i + 1)
                                             : dof_name(result.dofs[static_cast<std::size_t>(i)]));
  result.notes = std::move(preparation.notes);
  add_means_of_copies(result);
  return result;
}

MatrixModel part_matrices(const std::optional<ForeignMatrix>& stiffness, const std::optional<ForeignMatrix>& mass,
                          const std::optional<ForeignMatrix>& damping, const MatrixModelOptions& options,
                          std::optional<Index> rows) {
  std::vector<const ForeignMatrix*> matrices;
  for (const auto* each : {&stiffness, &mass, &damping})
    if (*each) matrices.push_back(&**each);
  MatrixModel result;
  result.dofs = all_dofs(matrices, options.dofs);
  if (result.dofs.empty() && !rows)
    throw InvalidInput("the rows of a factor's matrices are not known",
                       "neither their files nor the matrices of the structure say them",
                       "give `dofs`: a list of node.direction, or of nodes with `directions`");
  const Index size = result.dofs.empty() ? *rows : std::ssize(result.dofs);
  Preparation preparation(options, result.dofs, size);
  if (stiffness) result.model.stiffness = preparation.prepared("stiffness", *stiffness, false);
  if (mass) result.model.mass = preparation.prepared("mass", *mass, false);
  if (damping) result.model.damping = preparation.prepared("damping", *damping, false);
  preparation.issues().raise();
  result.notes = std::move(preparation.notes);
  return result;
}

MatrixModel read_superelement(const std::vector<std::filesystem::path>& files, const SuperelementReadOptions& options) {
  if (files.empty()) throw InvalidInput("no matrix file is given", "stiffness and mass are needed", "name one");
  const auto all = all_matrices(files, options.format);
  IssueList issues;
  const auto stiffness = chosen(all, Role::stiffness, options.stiffness, "stiffness", true, issues);
  const auto mass = chosen(all, Role::mass, options.mass, "mass", true, issues);
  const auto damping = chosen(all, Role::damping, options.damping, "damping", false, issues);
  issues.raise();
  MatrixModelOptions model = options.model;
  if (options.dof_map) model.dofs = read_dof_map(*options.dof_map, options.map);
  MatrixModel made = matrix_model(*stiffness, *mass, damping, model);
  add_notes_on_others(all, {stiffness->name, mass->name, damping ? damping->name : ""}, made.notes);
  return made;
}

}  // namespace kalfem
