// SPDX-License-Identifier: Apache-2.0
#include <numbers>

#include "kalfem/formats/nastran/model_building.hpp"
#include "kalfem/model/mesh/laminate_theory.hpp"
#include "kalfem/model/mesh/split_quadratic_shells.hpp"

namespace kalfem::nastran {
namespace {

/// Stiffness of a sheet of a material: plane stress and transverse shear.
struct SheetStiffness {
  Eigen::Matrix3d plane = Eigen::Matrix3d::Zero();
  Eigen::Matrix2d shear = Eigen::Matrix2d::Zero();
  double density = 0.0;
  bool is_isotropic = false;
};

// Plane stress of an orthotropic sheet in its own axes, with nu21 = nu12 E2 / E1 by symmetry.
Eigen::Matrix3d orthotropic_plane(double e1, double e2, double nu12, double g12) {
  const double nu21 = nu12 * e2 / e1, factor = 1.0 / (1.0 - nu12 * nu21);
  return Eigen::Matrix3d{
      {e1 * factor, nu21 * e1 * factor, 0.0}, {nu21 * e1 * factor, e2 * factor, 0.0}, {0.0, 0.0, g12}};
}

// One region for each property and each thickness and offset of its elements. The first element that needs a region
// makes its property: a plain isotropic shell where every material of the PSHELL is the same MAT1, so that its
// thickness can be a parameter; otherwise the general stiffness A, B, D, S of a section. Directions are kept for
// sections that need them.
class ShellBuilder {
public:
  ShellBuilder(Building& building, Materials& materials) : building_(building), materials_(materials) {}
  void add(const ShellCard& card);
  void finish();

private:
  void add_cell(const ShellCard& card, const std::string& title, const std::string& region);
  void note_missing_materials(const PshellCard& shell, const Place& where);
  CellShape shape_of(const ShellCard& card);
  double thickness_of(const ShellCard& card, double property);
  std::optional<RegionProperty> plate(const PshellCard& shell, double thickness, double offset,
                                      const std::string& title, const Place& where);
  std::optional<RegionProperty> stack(const PcompCard& laminate, double offset, const std::string& title,
                                      const Place& where);
  std::optional<SheetStiffness> sheet(Id material, const std::string& title, const Place& where);
  std::optional<OrthotropicSheet> ply_material(Id material, const std::string& title, const Place& where);
  Eigen::Vector3d direction(const ShellCard& card);

  Building& building_;
  Materials& materials_;
  RegionNames names_;
  std::map<std::string, bool> refused_;
  std::map<std::string, std::vector<Eigen::Vector3d>> directions_;  ///< of cells, by region
  std::map<std::string, bool> is_turned_;                           ///< whether a direction is not the first side
};

/// Thickness of the element: that of the property, or the mean of the corners.
double ShellBuilder::thickness_of(const ShellCard& card, double property) {
  if (card.thickness < 0) return property;
  const auto& corners = building_.bulk.corner_thickness[static_cast<std::size_t>(card.thickness)];
  const std::size_t count = card.triangle ? 3 : 4;
  double sum = 0.0;
  bool differ = false;
  double first = not_given;
  for (std::size_t i = 0; i < count; ++i) {
    const double value = given(corners.values[i]) ? corners.values[i] * (corners.relative ? property : 1.0) : property;
    if (i == 0) first = value;
    differ = differ || std::abs(value - first) > 1e-9 * std::abs(first);
    sum += value;
  }
  if (differ)
    building_.note(card.where, "shells with different thicknesses at their corners", "each takes the mean thickness",
                   DeckNoteKind::changed);
  return differ ? sum / static_cast<double>(count) : first;
}

void ShellBuilder::add(const ShellCard& card) {
  const auto title = std::string(card.triangle ? "triangle " : "quadrilateral ") + std::to_string(card.id);
  const auto is_of_shells = [](const PropertyCard& property) {
    return std::holds_alternative<PshellCard>(property.law) || std::holds_alternative<PcompCard>(property.law);
  };
  const PropertyCard* property = find_property(building_, card.property, title, card.where, is_of_shells);
  if (property == nullptr) return;
  const auto* shell = std::get_if<PshellCard>(&property->law);
  const auto* laminate = std::get_if<PcompCard>(&property->law);
  if (laminate != nullptr && card.thickness >= 0)
    building_.note(card.where, "thicknesses at the corners of shells with PCOMP", "the plies have theirs",
                   DeckNoteKind::unused);
  if (card.material_system > 0 && building_.frames.find(card.material_system, card.where) == nullptr) return;
  const double thickness = shell != nullptr ? thickness_of(card, shell->thickness) : 0.0;
  std::string base = property->kind == "PSHELL" ? "pshell" : "pcomp";
  base += std::to_string(card.property);
  const auto [region, is_new] = names_.name(base, {card.offset, given(thickness) ? thickness : -1.0});
  if (is_new) {
    const auto law = shell != nullptr ? plate(*shell, thickness, card.offset, title, property->where)
                                      : stack(*laminate, card.offset, title, property->where);
    refused_[region] = !law;
    if (law) building_.model.properties[region] = *law;
  }
  if (refused_[region]) return;
  if (shell != nullptr) note_missing_materials(*shell, property->where);
  add_cell(card, title, region);
}

/// Of each element: what its PSHELL leaves out and kalfem fills in.
void ShellBuilder::note_missing_materials(const PshellCard& shell, const Place& where) {
  const auto note = [&](const char* what, const std::string& consequence) {
    building_.note(where, what, consequence, DeckNoteKind::changed);
  };
  const auto millionth = [](const char* motion) {
    return std::string("the shell gets a millionth of the stiffness in ") + motion +
           " that the other material would give it";
  };
  if (shell.membrane == 0) return note("PSHELL without MID1", millionth("its plane"));
  if (shell.bending == 0) return note("PSHELL without MID2", millionth("bending"));
  if (shell.shear == 0) note("PSHELL without MID3", "Nastran makes it rigid in transverse shear; kalfem uses 5/6 of G");
}

CellShape ShellBuilder::shape_of(const ShellCard& card) {
  const std::size_t corners = card.triangle ? 3 : 4;
  std::size_t middles = 0;
  for (std::size_t i = corners; i < 2 * corners; ++i) middles += card.nodes[i] != 0 ? 1 : 0;
  if (middles == corners)
    building_.note(card.where, "8- and 6-node shells", "each is replaced by four linear ones", DeckNoteKind::changed);
  if (middles == corners) return card.triangle ? CellShape::triangle6 : CellShape::quadrilateral8;
  if (middles > 0)
    building_.note(card.where, "shells with some of their midside nodes",
                   "they are read by their corners only; the midside nodes are not connected to them",
                   DeckNoteKind::changed);
  return card.triangle ? CellShape::triangle3 : CellShape::quadrilateral4;
}

void ShellBuilder::add_cell(const ShellCard& card, const std::string& title, const std::string& region) {
  const auto shape = shape_of(card);
  std::array<Eigen::Index, 8> nodes{};
  const auto count = static_cast<std::size_t>(node_count(shape));
  for (std::size_t i = 0; i < count; ++i)
    if ((nodes[i] = building_.node(card.nodes[i], title, card.where)) < 0) return;
  auto& mesh = building_.model.mesh;
  mesh.regions[region].push_back(mesh.add_cell(shape, card.id, {nodes.data(), count}));
  if (std::holds_alternative<LaminateProperty>(building_.model.properties[region])) {
    directions_[region].push_back(direction(card));
    is_turned_[region] = is_turned_[region] || card.angle != 0.0 || card.material_system >= 0;
  }
}

/// x axis of the material: of the system MCID at the element's middle, or the first side turned by THETA.
Eigen::Vector3d ShellBuilder::direction(const ShellCard& card) {
  const auto place = [&](std::size_t i) { return building_.place(building_.nodes.find(card.nodes[i])); };
  const std::size_t corners = card.triangle ? 3 : 4;
  const Eigen::Vector3d side = place(1) - place(0);
  const Eigen::Vector3d normal = card.triangle ? side.cross(place(2) - place(0))
                                               : Eigen::Vector3d((place(2) - place(0)).cross(place(3) - place(1)));
  if (card.material_system >= 0) {
    const Frame* frame = building_.frames.find(card.material_system, card.where);
    if (frame == nullptr) return side;
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < corners; ++i) middle += place(i) / static_cast<double>(corners);
    const Eigen::Matrix3d axes = frame->directions(middle);
    const Eigen::Vector3d laid = axes.col(0) - axes.col(0).dot(normal) / normal.squaredNorm() * normal;
    return laid.norm() > 1e-3 ? laid : axes.col(1);
  }
  const double angle = card.angle * std::numbers::pi / 180.0;
  return std::cos(angle) * side + std::sin(angle) * normal.normalized().cross(side);
}

// MAT1, MAT2 and MAT8 as a sheet. A MAT1 keeps the G of its card in transverse shear. Of a MAT2 the upper left 2 x 2
// block serves transverse shear, as the card means it on MID3.
std::optional<SheetStiffness> ShellBuilder::sheet(Id material, const std::string& title, const Place& where) {
  const MaterialCard* card = materials_.find(material, title, where);
  if (card == nullptr) return std::nullopt;
  SheetStiffness sheet;
  if (const auto* law = std::get_if<Material1>(&card->law)) {
    const auto isotropic = materials_.complete(*law, card->where);
    const double g =
        given(law->shear_modulus) && law->shear_modulus > 0.0 ? law->shear_modulus : isotropic.shear_modulus();
    sheet = {orthotropic_plane(isotropic.youngs_modulus, isotropic.youngs_modulus, isotropic.poissons_ratio,
                               isotropic.shear_modulus()),
             g * Eigen::Matrix2d::Identity(), isotropic.density, true};
    if (isotropic.youngs_modulus == 0.0) sheet.plane.setZero();
  } else if (const auto* anisotropic = std::get_if<Material2>(&card->law)) {
    sheet.plane = anisotropic->stiffness;
    sheet.shear = anisotropic->stiffness.topLeftCorner<2, 2>();
    sheet.density = anisotropic->density * building_.bulk.mass_factor;
  } else if (const auto* ply = std::get_if<Material8>(&card->law)) {
    sheet.plane = orthotropic_plane(ply->e1, ply->e2, ply->nu12, ply->g12);
    const double rigid = 1e3 * std::max(ply->e1, ply->e2);  // blank moduli mean no shear deformation
    sheet.shear.diagonal() << (ply->g13 > 0.0 ? ply->g13 : rigid), (ply->g23 > 0.0 ? ply->g23 : rigid);
    sheet.density = ply->density * building_.bulk.mass_factor;
  } else {
    building_.files.problem(where, title + ": material " + std::to_string(material) + " is a MAT9",
                            "shells need MAT1, MAT2 or MAT8", "give the material as one of these");
    return std::nullopt;
  }
  return sheet;
}

// A = t Q_1, D = (12 I / t^3) t^3 / 12 Q_2, S = (ts / t) t G_3 with the materials MID1, MID2, MID3. A missing one
// leaves the section singular; a millionth of the other's stiffness keeps it solvable without being felt.
std::optional<RegionProperty> ShellBuilder::plate(const PshellCard& shell, double thickness, double offset,
                                                  const std::string& title, const Place& where) {
  if (!(thickness > 0.0)) {
    building_.files.problem(where, title + ": its PSHELL has no positive thickness", "stiffness and mass depend on it",
                            "give T on the PSHELL or T1 to T4 on the element");
    return std::nullopt;
  }
  const double added = shell.nonstructural_mass * building_.bulk.mass_factor;
  const auto membrane_card = building_.bulk.materials.find(shell.membrane);
  const bool is_plain =
      shell.membrane > 0 && shell.bending == shell.membrane && shell.bending_ratio == 1.0 &&
      (shell.shear == 0 || (shell.shear == shell.membrane && std::abs(shell.shear_ratio - 5.0 / 6.0) < 1e-3)) &&
      membrane_card != building_.bulk.materials.end() && std::holds_alternative<Material1>(membrane_card->second.law);
  if (is_plain) {
    const auto name = materials_.isotropic(shell.membrane, title, where);
    if (name.empty()) return std::nullopt;
    return ShellProperty{name, thickness, offset, added};
  }
  if (shell.membrane == 0 && shell.bending == 0) {
    building_.files.problem(where, title + ": its PSHELL has neither MID1 nor MID2", "it has no stiffness",
                            "give a material");
    return std::nullopt;
  }
  const auto of = [&](Id material) {
    return material > 0 ? sheet(material, title, where) : std::optional<SheetStiffness>();
  };
  const auto membrane = of(shell.membrane), bending = of(shell.bending), shear = of(shell.shear);
  if ((shell.membrane > 0 && !membrane) || (shell.bending > 0 && !bending) || (shell.shear > 0 && !shear))
    return std::nullopt;
  LaminateProperty property;
  auto& stiffness = property.stiffness;
  const double cubed = thickness * thickness * thickness / 12.0;
  stiffness.membrane =
      membrane ? Eigen::Matrix3d(thickness * membrane->plane) : Eigen::Matrix3d(1e-6 * thickness * bending->plane);
  stiffness.bending = bending ? Eigen::Matrix3d(shell.bending_ratio * cubed * bending->plane)
                              : Eigen::Matrix3d(1e-6 * cubed * membrane->plane);
  const auto& other = bending ? *bending : *membrane;
  stiffness.shear = shear ? Eigen::Matrix2d(shell.shear_ratio * thickness * shear->shear)
                          : Eigen::Matrix2d(5.0 / 6.0 * thickness * other.shear);
  property.mass = (membrane ? membrane : bending)->density * thickness + added;
  property.rotary_inertia = property.mass * thickness * thickness / 12.0;
  property.offset = offset;
  return property;
}

// A ply needs engineering constants. They follow from a MAT2 without shear coupling by nu12 = G12 / G22 and E1 = G11
// - G12^2 / G22.
std::optional<OrthotropicSheet> ShellBuilder::ply_material(Id material, const std::string& title, const Place& where) {
  const MaterialCard* card = materials_.find(material, title, where);
  if (card == nullptr) return std::nullopt;
  const double factor = building_.bulk.mass_factor;
  if (const auto* law = std::get_if<Material1>(&card->law)) return sheet_of(materials_.complete(*law, card->where));
  if (const auto* ply = std::get_if<Material8>(&card->law))
    return OrthotropicSheet{ply->e1, ply->e2, ply->nu12, ply->g12, ply->g13, ply->g23, ply->density * factor};
  if (const auto* sheet = std::get_if<Material2>(&card->law)) {
    const auto& g = sheet->stiffness;
    if (g(0, 2) == 0.0 && g(1, 2) == 0.0 && g(0, 0) > 0.0 && g(1, 1) > 0.0)
      return OrthotropicSheet{g(0, 0) - g(0, 1) * g(0, 1) / g(1, 1),
                              g(1, 1) - g(0, 1) * g(0, 1) / g(0, 0),
                              g(0, 1) / g(1, 1),
                              g(2, 2),
                              0.0,
                              0.0,
                              sheet->density * factor};
  }
  building_.files.problem(where, title + ": material " + std::to_string(material) + " is not allowed for a ply",
                          "plies need MAT1, MAT8, or MAT2 without G13 and G23", "give the material as one of these");
  return std::nullopt;
}

// Z0 is the bottom of the stack, by default half its thickness below the reference surface; ZOFFS of the element
// moves all. Nonstructural mass takes part in the rotary inertia as if spread over the thickness.
std::optional<RegionProperty> ShellBuilder::stack(const PcompCard& laminate, double offset, const std::string& title,
                                                  const Place& where) {
  std::vector<Ply> plies;
  double thickness = 0.0;
  for (const auto& layer : laminate.plies) {
    const auto material = ply_material(layer.material, title, where);
    if (!material) return std::nullopt;
    plies.push_back({*material, layer.thickness, layer.angle * std::numbers::pi / 180.0});
    thickness += layer.thickness;
  }
  try {
    auto property = laminated(plies, (given(laminate.bottom) ? laminate.bottom : -0.5 * thickness) + offset);
    const double added = laminate.nonstructural_mass * building_.bulk.mass_factor;
    property.mass += added;
    property.rotary_inertia += added * thickness * thickness / 12.0;
    return property;
  } catch (const InvalidInput& error) {
    for (const auto& issue : error.issues())
      building_.files.problem(where, "PCOMP: " + issue.what, issue.why, issue.fix);
    return std::nullopt;
  }
}

void ShellBuilder::finish() {
  for (auto& [region, directions] : directions_)
    if (is_turned_[region])
      std::get<LaminateProperty>(building_.model.properties[region]).directions = std::move(directions);
}

}  // namespace

void build_shells(Building& building, Materials& materials) {
  ShellBuilder builder(building, materials);
  for (const auto& card : building.bulk.shells) builder.add(card);
  builder.finish();
}

}  // namespace kalfem::nastran
