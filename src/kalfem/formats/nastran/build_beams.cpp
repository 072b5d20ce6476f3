// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <numbers>

#include "kalfem/formats/nastran/model_building.hpp"
#include "kalfem/model/elements/tapered_beam.hpp"

namespace kalfem::nastran {
namespace {

/// Nastran's element axes are kalfem's: x from end A to end B, y in the plane of x and the orientation vector, z = x y.
/// Bending in plane 1 is that in x-y, so I1 is inertia_z and I2 inertia_y.
BeamSection section_of(const SectionCard& card, double shear_ratio) {
  BeamSection section;
  section.area = card.area;
  section.inertia_z = card.i1;
  section.inertia_y = card.i2;
  section.product_yz = card.i12;
  section.torsion = card.torsion * shear_ratio;
  section.shear_factor_y = card.k1 * shear_ratio;
  section.shear_factor_z = card.k2 * shear_ratio;
  section.centroid = card.neutral_axis;
  section.outline = card.outline;
  return section;
}

class BeamBuilder {
public:
  BeamBuilder(Building& building, Materials& materials) : building_(building), materials_(materials) {}
  void add(BeamCard card);
  void add(const RodCard& card);

private:
  std::optional<BeamStation> station(double at, const SectionCard& card, const std::string& region,
                                     const std::string& title, const Place& where);
  bool make_region(const std::string& region, const SectionCard& section, const std::string& title, const Place& where);
  bool make_region(const std::string& region, const RodSection& section, const std::string& title, const Place& where);
  std::optional<std::array<Eigen::Index, 2>> ends(const std::array<Id, 2>& nodes, const std::string& title,
                                                  const Place& where);
  void fill_defaults(BeamCard& card) const;
  std::optional<Eigen::Vector3d> orientation(const BeamCard& card, Eigen::Index first, const std::string& title);
  std::optional<BeamPlacement> placement(const BeamCard& card, const std::array<Eigen::Index, 2>& nodes,
                                         const std::string& title);
  void add_cell(Id id, const std::array<Eigen::Index, 2>& nodes, const BeamPlacement& placement,
                const std::string& region);
  void no_stiffness(double& value, double instead, const char* what, const std::string& region);
  const PropertyCard* property_of(Id number, std::string_view kind, const std::string& title, const Place& where);

  Building& building_;
  Materials& materials_;
  RegionNames names_;
  std::map<std::string, bool> sound_;
  std::map<std::string, std::vector<const char*>> without_stiffness_;  ///< of regions: what was 0
};

/// A section of no stiffness in one of its motions is given a millionth of a plump one's.
void BeamBuilder::no_stiffness(double& value, double instead, const char* what, const std::string& region) {
  if (value > 0.0 || !(instead > 0.0)) return;
  value = 1e-6 * instead;
  auto& noted = without_stiffness_[region];
  if (std::ranges::find(noted, what) == noted.end()) noted.push_back(what);
}

// Second moments and torsion of zero are legal in Nastran and leave a motion without stiffness; the solid circle of
// area A has I = A^2 / (4 pi) and J = 2 I.
std::optional<BeamStation> BeamBuilder::station(double at, const SectionCard& card, const std::string& region,
                                                const std::string& title, const Place& where) {
  BeamStation station{.place = at, .section = section_of(card, materials_.shear_ratio(card.material))};
  auto& section = station.section;
  if (!(section.area > 0.0) || section.inertia_y < 0.0 || section.inertia_z < 0.0 || section.torsion < 0.0) {
    building_.files.problem(where, title + ": its section has no positive area, or a negative I1, I2 or J",
                            "stiffness and mass depend on them", "correct A, I1, I2 and J");
    return std::nullopt;
  }
  const double round = section.area * section.area / (4.0 * std::numbers::pi);
  no_stiffness(section.inertia_z, round, "I1", region);
  no_stiffness(section.inertia_y, round, "I2", region);
  no_stiffness(section.torsion, 2.0 * round, "J", region);
  station.nonstructural_mass = card.nonstructural_mass * building_.bulk.mass_factor;
  station.nonstructural_inertia = card.nonstructural_inertia * building_.bulk.mass_factor;
  station.nonstructural_centre = card.nonstructural_centre;
  return station;
}

/// One region for each property, made when its first element comes.
bool BeamBuilder::make_region(const std::string& region, const SectionCard& card, const std::string& title,
                              const Place& where) {
  BeamProperty property;
  property.material = materials_.isotropic(card.material, title, where);
  if (property.material.empty()) return false;
  for (const auto& [at, given] : card.stations) {
    SectionCard own = given;
    own.material = card.material;
    const auto made = station(at, own, region, title, where);
    if (!made) return false;
    property.stations.push_back(*made);
  }
  const auto whole = property.stations.empty() ? station(0.0, card, region, title, where)
                                               : std::optional(mean_station(property.stations));
  if (!whole) return false;
  property.section = whole->section;
  property.lumped_inertia =
      title.starts_with("CBEAM ") ? LumpedInertia::twist : LumpedInertia::none;  // of PBEAM, and of PBAR and the rods
  property.nonstructural_mass = whole->nonstructural_mass;
  property.nonstructural_centre = whole->nonstructural_centre;
  property.placements.clear();
  building_.model.properties[region] = std::move(property);
  return true;
}

/// A rod is a beam with hinges at both ends; the moments of inertia count for nothing then.
bool BeamBuilder::make_region(const std::string& region, const RodSection& rod, const std::string& title,
                              const Place& where) {
  SectionCard card;
  card.material = rod.material;
  card.area = rod.area;
  card.i1 = card.i2 = rod.area * rod.area / (4.0 * std::numbers::pi);
  card.torsion = rod.torsion > 0.0 ? rod.torsion : card.i1;
  card.nonstructural_mass = rod.nonstructural_mass;
  return make_region(region, card, title, where);
}

std::optional<std::array<Eigen::Index, 2>> BeamBuilder::ends(const std::array<Id, 2>& nodes, const std::string& title,
                                                             const Place& where) {
  const std::array indices = {building_.node(nodes[0], title, where), building_.node(nodes[1], title, where)};
  if (indices[0] < 0 || indices[1] < 0) return std::nullopt;
  return indices;
}

/// The orientation vector in basic axes.
std::optional<Eigen::Vector3d> BeamBuilder::orientation(const BeamCard& card, Eigen::Index first,
                                                        const std::string& title) {
  if (card.orientation_node > 0) {
    const auto node = building_.node(card.orientation_node, title, card.where);
    if (node < 0) return std::nullopt;
    return building_.place(node) - building_.place(first);
  }
  if (card.axes[0] == 'B') return card.orientation;
  return building_.motion_axes(first) * card.orientation;
}

// Fills the blank fields of a CBAR from BAROR and those of a CBEAM from BEAMOR; a property that is blank there too
// has the element's number.
void BeamBuilder::fill_defaults(BeamCard& card) const {
  const auto& defaults = card.is_bar ? building_.bulk.bar_defaults : building_.bulk.beam_defaults;
  if (card.property == 0) card.property = defaults.property > 0 ? defaults.property : card.id;
  if (card.orientation_node == 0 && card.orientation.isZero(0.0)) {
    card.orientation_node = defaults.orientation_node;
    card.orientation = defaults.orientation.value_or(Eigen::Vector3d::Zero());
  }
  if (card.axes[0] == '?')
    for (std::size_t i = 0; i < 3; ++i) card.axes[i] = defaults.axes[i];
}

// `up` is the local z axis, x cross v: v lies in plane 1, the x-y plane of the element. It refers to the axis between
// the ends after the offsets. The pins PA and PB release motions 1 ... 6 in these axes.
/// Offsets are in the displacement axes of their node, in basic axes, or in element axes: x along the nodes, z of it
/// and the orientation vector.
std::optional<BeamPlacement> BeamBuilder::placement(const BeamCard& card, const std::array<Eigen::Index, 2>& nodes,
                                                    const std::string& title) {
  const auto v = orientation(card, nodes[0], title);
  if (!v) return std::nullopt;
  const auto axes_along = [&](const Eigen::Vector3d& along) {
    const Eigen::Vector3d x = along.normalized(), z = x.cross(*v).normalized();
    Eigen::Matrix3d axes;
    axes << x, z.cross(x), z;
    return axes;
  };
  const Eigen::Vector3d between = building_.place(nodes[1]) - building_.place(nodes[0]);
  BeamPlacement placement;
  for (int end = 0; end < 2; ++end) {
    const Eigen::Vector3d offset = card.offsets.col(end);
    if (offset.isZero(0.0)) continue;
    const char kind = card.axes[static_cast<std::size_t>(end + 1)];
    placement.offsets.col(end) =
        kind == 'B'   ? offset
        : kind == 'G' ? Eigen::Vector3d(building_.motion_axes(nodes[static_cast<std::size_t>(end)]) * offset)
                      : Eigen::Vector3d(axes_along(between) * offset);
  }
  const Eigen::Vector3d along = between + placement.offsets.col(1) - placement.offsets.col(0);
  if (!(along.norm() > 0.0)) {
    building_.files.problem(card.where, title + " has no length", "its ends coincide, offsets included",
                            "correct the nodes");
    return std::nullopt;
  }
  placement.up = along.normalized().cross(*v);
  if (!(placement.up.norm() > 1e-6 * v->norm())) {
    building_.files.problem(card.where, title + ": its orientation vector is zero or parallel to its axis",
                            "this vector defines plane 1 of bending", "give X1, X2, X3 or G0 not parallel to the axis");
    return std::nullopt;
  }
  placement.up.normalize();
  for (std::size_t end = 0; end < 2; ++end)
    for (std::size_t i = 0; i < 6; ++i) placement.released[6 * end + i] = ((card.pins[end] >> i) & 1u) != 0;
  return placement;
}

// CBAR and CBEAM, CROD and CTUBE may each have a property of the same number.
/// The property of the element's own kind, "PBAR" of a CBAR, or one that makes a section too.
const PropertyCard* BeamBuilder::property_of(Id number, std::string_view kind, const std::string& title,
                                             const Place& where) {
  const auto is_own = [&](const PropertyCard& card) { return card.kind.starts_with(kind); };
  const auto [first, last] = building_.bulk.properties.equal_range(number);
  const bool has_own = std::any_of(first, last, [&](const auto& item) { return is_own(item.second); });
  const bool is_rod = kind == "PROD" || kind == "PTUBE";
  return find_property(building_, number, title, where, [&](const PropertyCard& card) {
    return has_own  ? is_own(card)
           : is_rod ? std::holds_alternative<RodSection>(card.law)
                    : std::holds_alternative<SectionCard>(card.law);
  });
}

void BeamBuilder::add(BeamCard card) {
  fill_defaults(card);
  const auto title = std::string(card.is_bar ? "CBAR " : "CBEAM ") + std::to_string(card.id);
  const auto* property = property_of(card.property, card.is_bar ? "PBAR" : "PBEAM", title, card.where);
  const auto nodes = ends(card.nodes, title, card.where);
  if (property == nullptr || !nodes) return;
  std::string region = property->kind;
  for (char& c : region) c = static_cast<char>(c - 'A' + 'a');
  region += std::to_string(card.property);
  const auto [sound, is_new] = sound_.try_emplace(region, false);
  if (is_new) sound->second = make_region(region, std::get<SectionCard>(property->law), title, property->where);
  if (!sound->second) return;
  for (const auto* what : without_stiffness_[region])
    building_.note(property->where, std::string("beam sections with ") + what + " of 0",
                   "it is set to a millionth of that of a solid circle of this area", DeckNoteKind::changed);
  if (const auto place = placement(card, *nodes, title)) add_cell(card.id, *nodes, *place, region);
}

// A rod is released in its two bending rotations at both ends, and in torsion at one end if it has no J. Its
// transverse axis is arbitrary: the basis vector farthest from the rod is taken.
void BeamBuilder::add(const RodCard& card) {
  const auto title = std::string(card.kind) + " " + std::to_string(card.id);
  const auto own = building_.bulk.conrods.find(card.id);
  const bool has_own = card.property == 0 && own != building_.bulk.conrods.end();
  const auto* property =
      has_own ? &own->second : property_of(card.property, "P" + std::string(card.kind).substr(1), title, card.where);
  const auto nodes = ends(card.nodes, title, card.where);
  if (property == nullptr || !nodes) return;
  const auto* rod = &std::get<RodSection>(property->law);
  const auto base = has_own ? std::string("conrod") : "prod" + std::to_string(card.property);
  const auto [region, is_new] =
      names_.name(base, {static_cast<double>(rod->material), rod->area, rod->torsion, rod->nonstructural_mass});
  if (is_new) sound_[region] = make_region(region, *rod, title, card.where);
  if (!sound_[region]) return;
  BeamPlacement placement;
  const Eigen::Vector3d along = building_.place((*nodes)[1]) - building_.place((*nodes)[0]);
  int across = 0;
  along.cwiseAbs().minCoeff(&across);
  placement.up = Eigen::Vector3d::Unit(across);
  for (const std::size_t i : {4, 5, 10, 11}) placement.released[i] = true;
  placement.released[9] = !(rod->torsion > 0.0);
  add_cell(card.id, *nodes, placement, region);
}

void BeamBuilder::add_cell(Id id, const std::array<Eigen::Index, 2>& nodes, const BeamPlacement& placement,
                           const std::string& region) {
  auto& mesh = building_.model.mesh;
  mesh.regions[region].push_back(mesh.add_cell(CellShape::line2, id, nodes));
  std::get<BeamProperty>(building_.model.properties[region]).placements.push_back(placement);
}

}  // namespace

void build_beams(Building& building, Materials& materials) {
  BeamBuilder builder(building, materials);
  for (const auto& card : building.bulk.beams) builder.add(card);
}

// Without inertia the turn of a straight bar about its own line would have neither stiffness nor mass, and no modes
// could be computed. In a straight line the twist is not coupled with bending: other modes stay those of Nastran.
void keep_free_twist(Building& building) {
  auto& model = building.model;
  const auto& nodes = model.mesh.nodes;
  if (nodes.cols() < 2 || model.mass_kind != MassKind::lumped || model.mesh.node_sets.contains(scalar_points)) return;
  Eigen::Index farthest = 0;
  (nodes.colwise() - nodes.col(0)).colwise().norm().maxCoeff(&farthest);
  const Eigen::Vector3d span = nodes.col(farthest) - nodes.col(0);
  if (!(span.norm() > 0.0)) return;
  const Eigen::Vector3d axis = span.normalized();
  for (const auto node : nodes.colwise())
    if ((node - nodes.col(0)).cross(axis).norm() > 1e-9 * span.norm()) return;
  if (!model.constraints.empty() || !model.masses.empty() || !model.matrices.empty() || !model.springs.empty()) return;
  for (const auto& support : model.fixed)
    for (int i = 0; i < 3; ++i)
      if (support.directions[static_cast<std::size_t>(3 + i)] && std::abs(axis[i]) > 1e-9) return;
  bool any = false;
  for (auto& [region, property] : model.properties)
    if (auto* beam = std::get_if<BeamProperty>(&property); beam && beam->lumped_inertia == LumpedInertia::none) {
      beam->lumped_inertia = LumpedInertia::twist;
      any = true;
    }
  if (any)
    building.note({}, "bars in one line that nothing holds against turning about it",
                  "their lumped mass keeps the inertia of this turn, which CBAR of Nastran has not: modes of twist are "
                  "added, and all others stay",
                  DeckNoteKind::changed);
}

void build_rods(Building& building, Materials& materials) {
  BeamBuilder builder(building, materials);
  for (const auto& card : building.bulk.rods) builder.add(card);
}

}  // namespace kalfem::nastran
