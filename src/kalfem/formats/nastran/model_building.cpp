#include "kalfem/formats/nastran/model_building.hpp"

namespace kalfem::nastran {

int MatrixGather::index_of(const NodalDof& dof) {
  return index_.try_emplace(dof, static_cast<int>(index_.size())).first->second;
}

void MatrixGather::add(Kind kind, const DofSum& row, const DofSum& column, double value) {
  for (const auto& [i, left] : row)
    for (const auto& [j, right] : column) entries_[kind].emplace_back(index_of(i), index_of(j), value * left * right);
}

NodalMatrices MatrixGather::finish(const std::string& name) const {
  NodalMatrices result;
  result.name = name;
  result.dofs.resize(index_.size());
  for (const auto& [dof, position] : index_) result.dofs[static_cast<std::size_t>(position)] = dof;
  const auto size = static_cast<Eigen::Index>(index_.size());
  const auto fill = [&](Kind kind, Eigen::SparseMatrix<double>& matrix) {
    if (entries_[kind].empty()) return;
    matrix.resize(size, size);
    matrix.setFromTriplets(entries_[kind].begin(), entries_[kind].end());
  };
  fill(stiffness, result.stiffness);
  fill(mass, result.mass);
  fill(damping, result.damping);
  return result;
}

Eigen::Index Building::node(Id id, const std::string& title, const Place& where) {
  const auto index = nodes.find(id);
  if (index < 0)
    files.problem(where, title + ": grid point " + std::to_string(id) + " is missing", "the card names it",
                  "add the GRID card, or mend the number");
  return index;
}

bool Building::is_turned(Eigen::Index index) const {
  return bulk.grids[static_cast<std::size_t>(index)].motion_system > 0;
}

bool Building::is_scalar(Eigen::Index index) const {
  return bulk.grids[static_cast<std::size_t>(index)].motion_system == scalar_point;
}

Eigen::Matrix3d Building::motion_axes(Eigen::Index index) const {
  if (!is_turned(index)) return Eigen::Matrix3d::Identity();
  const auto& grid = bulk.grids[static_cast<std::size_t>(index)];
  const Frame* frame = frames.find(grid.motion_system, grid.where);
  return frame != nullptr ? frame->directions(place(index)) : Eigen::Matrix3d::Identity();
}

void Building::append(DofSum& terms, Eigen::Index index, int component, double factor) const {
  if (!is_turned(index)) {
    terms.push_back({NodalDof{index, component}, factor});
    return;
  }
  const Eigen::Vector3d axis = motion_axes(index).col(component % 3);
  for (int k = 0; k < 3; ++k)
    if (std::abs(axis[k]) > 1e-14) terms.push_back({NodalDof{index, component / 3 * 3 + k}, factor * axis[k]});
}

std::pair<std::string, bool> RegionNames::name(const std::string& base, const std::vector<double>& key) {
  const auto [place, is_new] = names_.try_emplace({base, key});
  if (is_new) {
    const int variant = ++variants_[base];
    place->second = variant == 1 ? base : base + "." + std::to_string(variant);
  }
  return {place->second, is_new};
}

const PropertyCard* find_property(Building& building, Id property, const std::string& title, const Place& where) {
  const auto card = building.bulk.properties.find(property);
  if (card != building.bulk.properties.end()) return &card->second;
  const auto unread = building.bulk.unread_properties.find(property);
  if (unread != building.bulk.unread_properties.end())
    building.files.problem(where, title + " names the " + unread->second + " " + std::to_string(property),
                           "this kind of property is not read", "give the section by another card");
  else
    building.files.problem(where, title + ": property " + std::to_string(property) + " is missing", "the card names it",
                           "add the property, or mend the number");
  return nullptr;
}

void wrong_property(Building& building, const PropertyCard& card, const std::string& title, const Place& where) {
  building.files.problem(where, title + " has a " + card.kind + " as its property", "it is one of another element",
                         "mend the number of the property");
}

}  // namespace kalfem::nastran
