// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/nastran/model_building.hpp"

#include <algorithm>
#include <numbers>

namespace kalfem::nastran {
namespace {

/// Systems that hang on one another deeper than this are taken for a ring.
constexpr int deepest = 500;
constexpr double radian = std::numbers::pi / 180.0;

Eigen::Matrix3d columns(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  Eigen::Matrix3d matrix;
  matrix << a, b, c;
  return matrix;
}

}  // namespace

// Coordinates of a CORD card: (x, y, z), (r, theta, z) or (r, theta, phi) with angles in degrees. In spherical
// coordinates theta is measured from the z axis and phi about it.
Eigen::Vector3d Frame::place(const Eigen::Vector3d& c) const {
  const double first = c[1] * radian, second = c[2] * radian;
  switch (kind) {
    case SystemKind::cylindrical:
      return origin + axes * Eigen::Vector3d(c[0] * std::cos(first), c[0] * std::sin(first), c[2]);
    case SystemKind::spherical:
      return origin + axes * (c[0] * Eigen::Vector3d(std::sin(first) * std::cos(second),
                                                     std::sin(first) * std::sin(second), std::cos(first)));
    default:
      return origin + axes * c;
  }
}

// Axes of motion at a place: columns are the directions r, theta, z or r, theta, phi there. On the z axis the angle
// about it is not defined; it is taken as 0, which keeps the axes orthonormal.
Eigen::Matrix3d Frame::directions(const Eigen::Vector3d& at) const {
  if (kind == SystemKind::rectangular) return axes;
  const Eigen::Vector3d local = axes.transpose() * (at - origin);
  const double radius = std::hypot(local.x(), local.y());
  const bool on_axis = radius <= 1e-9 * local.norm();
  const double cosine = on_axis ? 1.0 : local.x() / radius, sine = on_axis ? 0.0 : local.y() / radius;
  const Eigen::Vector3d around(-sine, cosine, 0.0);
  if (kind == SystemKind::cylindrical)
    return axes * columns(Eigen::Vector3d(cosine, sine, 0.0), around, Eigen::Vector3d::UnitZ());
  const double distance = local.norm();
  const double up = distance > 0.0 ? local.z() / distance : 1.0, out = distance > 0.0 ? radius / distance : 0.0;
  return axes *
         columns(Eigen::Vector3d(out * cosine, out * sine, up), Eigen::Vector3d(up * cosine, up * sine, -out), around);
}

Frames::Frames(BulkData& bulk, const NumberLookup& nodes, DeckFiles& files)
    : bulk_(bulk), nodes_(nodes), files_(files), placed_(bulk.grids.size(), false) {
  frames_[0] = {};
  for (const auto& [id, card] : bulk.systems) resolve(id, card.where, 0);
  for (std::size_t i = 0; i < bulk.grids.size(); ++i) resolve_grid(i, 0);
}

const Frame* Frames::find(Id system, const Place& where) const {
  const auto frame = frames_.find(system);
  if (frame != frames_.end()) return &frame->second;
  if (!failed_.contains(system))
    files_.problem(where, "coordinate system " + std::to_string(system) + " is missing", "the card refers to it",
                   "add its CORD card, or correct the number");
  return nullptr;
}

// Coordinate systems may refer to others, and by nodes whose place is given in yet others: each is resolved when it is
// first asked for, and kept. A depth beyond any real deck is taken for a ring.
const Frame* Frames::resolve(Id id, const Place& where, int depth) {
  if (const auto known = frames_.find(id); known != frames_.end()) return &known->second;
  if (failed_.contains(id)) return nullptr;
  const auto card = bulk_.systems.find(id);
  if (card == bulk_.systems.end()) return find(id, where);
  if (depth > deepest) {
    if (failed_.try_emplace(id, true).second)
      files_.problem(card->second.where, "coordinate system " + std::to_string(id) + " depends on itself",
                     "its position cannot be determined", "remove the circular reference");
    return nullptr;
  }
  Eigen::Matrix3d points;
  if (card->second.nodes) {
    for (int i = 0; i < 3; ++i) {
      Eigen::Vector3d place;
      if (!resolve_node((*card->second.nodes)[static_cast<std::size_t>(i)], card->second.where, depth + 1, place)) {
        failed_[id] = true;
        return nullptr;
      }
      points.col(i) = place;
    }
  } else {
    const Frame* reference = resolve(card->second.reference, card->second.where, depth + 1);
    if (reference == nullptr) {
      failed_[id] = true;
      return nullptr;
    }
    for (int i = 0; i < 3; ++i) points.col(i) = reference->place(card->second.points.col(i));
  }
  return &(frames_[id] = from_points(card->second, points));
}

// Three points define the axes: A the origin, B on the z axis, C in the x-z plane. y = z x (C - A), x = y x z.
Frame Frames::from_points(const SystemCard& card, const Eigen::Matrix3d& points) {
  Frame frame;
  frame.kind = card.kind;
  frame.origin = points.col(0);
  const Eigen::Vector3d up = points.col(1) - points.col(0), side = points.col(2) - points.col(0);
  const Eigen::Vector3d across = up.cross(side);
  if (!(across.norm() > 1e-10 * up.norm() * side.norm())) {
    files_.problem(card.where, "the three points of a coordinate system coincide or lie on one line",
                   "they must define its x-z plane", "correct the points");
    return frame;
  }
  const Eigen::Vector3d z = up.normalized(), y = across.normalized();
  frame.axes = columns(y.cross(z), y, z);
  return frame;
}

bool Frames::resolve_node(Id node, const Place& where, int depth, Eigen::Vector3d& place) {
  const auto index = nodes_.find(node);
  if (index < 0) {
    files_.problem(where, "grid point " + std::to_string(node) + " is missing", "the coordinate system depends on it",
                   "add the GRID card, or correct the number");
    return false;
  }
  if (!resolve_grid(static_cast<std::size_t>(index), depth)) return false;
  place = bulk_.grids[static_cast<std::size_t>(index)].place;
  return true;
}

bool Frames::resolve_grid(std::size_t index, int depth) {
  if (placed_[index]) return true;
  Grid& grid = bulk_.grids[index];
  const Frame* frame = resolve(grid.position_system, grid.where, depth + 1);
  if (frame == nullptr) return false;
  grid.place = frame->place(grid.place);
  placed_[index] = true;
  return true;
}

// Gathers entries over degrees of freedom in the order in which they come. Rows and columns are sums of global
// components, so an entry in turned axes spreads to up to 3 x 3 global ones.
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
    files.problem(where, title + ": grid point " + std::to_string(id) + " is missing", "the card refers to it",
                  "add the GRID card, or correct the number");
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

// A component in axes of the node's own becomes a sum of up to three global ones.
void Building::append(DofSum& terms, Eigen::Index index, int component, double factor) const {
  if (!is_turned(index)) {
    terms.push_back({NodalDof{index, component}, factor});
    return;
  }
  const Eigen::Vector3d axis = motion_axes(index).col(component % 3);
  for (int k = 0; k < 3; ++k)
    if (std::abs(axis[k]) > 1e-14) terms.push_back({NodalDof{index, component / 3 * 3 + k}, factor * axis[k]});
}

// Cells of one property that need different sections become regions of their own: the first takes the plain name,
// further ones a number.
std::pair<std::string, bool> RegionNames::name(const std::string& base, const std::vector<double>& key) {
  const auto [place, is_new] = names_.try_emplace({base, key});
  if (is_new) {
    const int variant = ++variants_[base];
    place->second = variant == 1 ? base : base + "." + std::to_string(variant);
  }
  return {place->second, is_new};
}

const PropertyCard* find_property(Building& building, Id property, const std::string& title, const Place& where,
                                  const std::function<bool(const PropertyCard&)>& fits) {
  const auto [first, last] = building.bulk.properties.equal_range(property);
  const auto card = std::find_if(first, last, [&](const auto& item) { return fits(item.second); });
  if (card != last) {
    for (const auto& [what, consequence] : card->second.changes)
      building.note(card->second.where, what, consequence, DeckNoteKind::changed);
    return &card->second;
  }
  const auto unread = building.bulk.unread_properties.find(property);
  if (unread != building.bulk.unread_properties.end())
    building.files.problem(where, title + " names the " + unread->second + " " + std::to_string(property),
                           "this type of property is not supported", "define the section by another card");
  else if (first != last)
    building.files.problem(where, title + " has a " + first->second.kind + " as its property",
                           "this property belongs to another type of element", "correct the number of the property");
  else
    building.files.problem(where, title + ": property " + std::to_string(property) + " is missing",
                           "the card refers to it", "add the property, or correct the number");
  return nullptr;
}

const MaterialCard* Materials::find(Id id, const std::string& title, const Place& where) {
  const auto card = building_.bulk.materials.find(id);
  if (card != building_.bulk.materials.end()) return &card->second;
  const auto unread = building_.bulk.unread_materials.find(id);
  const bool known = unread != building_.bulk.unread_materials.end();
  building_.files.problem(where,
                          title + (known ? " is of the " + unread->second + " " : ": material ") + std::to_string(id) +
                              (known ? "" : " is missing"),
                          known ? "this type of material is not supported" : "the card refers to it",
                          "give it as MAT1, MAT2, MAT8 or MAT9");
  return nullptr;
}

// Of E, G and NU two determine the third. All three may be given and disagree: then sections keep E and G,
// and shells and solids, which need a Poisson's ratio, E and NU.
IsotropicMaterial Materials::complete(const Material1& law, const Place& where) {
  double e = law.youngs_modulus, nu = law.poissons_ratio;
  const double g = law.shear_modulus;
  if (!given(e) && given(g)) e = 2.0 * g * (1.0 + (given(nu) ? nu : 0.0));
  if (!given(nu)) nu = given(g) && g > 0.0 ? e / (2.0 * g) - 1.0 : 0.0;
  // A shear modulus of its own stays in beams; Poisson's ratio of a material must be one.
  if (!given(law.poissons_ratio) && !(nu > -1.0 && nu < 0.5)) {
    building_.note(where, "MAT1 with E and G that imply a Poisson's ratio outside -1 to 0.5",
                   "shells and solids use 0.3; beams and rods keep E and G", DeckNoteKind::doubtful);
    nu = 0.3;
  } else if (given(g) && given(law.poissons_ratio) && given(law.youngs_modulus) &&
             std::abs(g * 2.0 * (1.0 + nu) - e) > 0.01 * std::abs(e)) {
    building_.note(where, "MAT1 with inconsistent E, G and NU",
                   "shells and solids use E and NU; beams and rods keep E and G", DeckNoteKind::doubtful);
  }
  return {given(e) ? e : 0.0, nu, law.density * building_.bulk.mass_factor};
}

std::string Materials::isotropic(Id id, const std::string& title, const Place& where) {
  const auto name = "mat" + std::to_string(id);
  if (building_.model.materials.contains(name)) return name;
  const MaterialCard* card = find(id, title, where);
  if (card == nullptr) return {};
  const auto* law = std::get_if<Material1>(&card->law);
  if (law == nullptr) {
    building_.files.problem(where, title + ": material " + std::to_string(id) + " is not isotropic",
                            "this element needs a MAT1", "give the material as MAT1");
    return {};
  }
  building_.model.materials[name] = complete(*law, card->where);
  return name;
}

// G over the shear modulus that E and NU of the stored material imply. Beams multiply by it, to keep the G of MAT1.
double Materials::shear_ratio(Id id) const {
  const auto card = building_.bulk.materials.find(id);
  const auto* law = card == building_.bulk.materials.end() ? nullptr : std::get_if<Material1>(&card->second.law);
  const auto named = building_.model.materials.find("mat" + std::to_string(id));
  if (law == nullptr || named == building_.model.materials.end() || !given(law->shear_modulus) ||
      !(law->shear_modulus > 0.0))
    return 1.0;
  const double ratio = law->shear_modulus / named->second.shear_modulus();
  // Digits of the card: within a thousandth the three are one material.
  return std::abs(ratio - 1.0) > 1e-3 && std::isfinite(ratio) ? ratio : 1.0;
}

}  // namespace kalfem::nastran
