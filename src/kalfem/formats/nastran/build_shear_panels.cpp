// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>

#include "kalfem/formats/nastran/model_building.hpp"

// A shear panel CSHEAR carries shear flow along its edges and nothing else.
//
// A parallelogram with the edges a and b at the angle phi, of thickness t, has the shear flow q on all edges. Its
// stress is tau = q / t and, along a, sigma = 2 tau cot phi, so that the energy over the area A = |a x b| is
//     U = q^2 A / (2 G t) (1 + 2 cot^2 phi / (1 + nu)),
// exactly for a uniform field [Gar51]. The flow's resultants at the corners lie along the diagonals d13 and d24, and do
// the work q D of
//     D = 1/2 [d13 . (u3 - u1) - d24 . (u4 - u2)],
// so that the stiffness is the one spring U = 1/2 k D^2, k = G t / (A (1 + 2 cot^2 phi / (1 + nu))).
// Any other quadrilateral counts as the parallelogram of its diagonals, a = (d13 - d24) / 2 and b = (d13 + d24) / 2:
// its corner forces balance too, also where it is warped.
namespace kalfem::nastran {
namespace {

using Corners = std::array<Eigen::Index, 4>;

DofSum along(const Eigen::Vector3d& direction, Eigen::Index from, Eigen::Index to) {
  DofSum terms;
  for (int k = 0; k < 3; ++k)
    if (direction[k] != 0.0) {
      terms.push_back({{to, k}, direction[k]});
      terms.push_back({{from, k}, -direction[k]});
    }
  return terms;
}

class PanelBuilder {
public:
  PanelBuilder(Building& building, Materials& materials) : building_(building), materials_(materials) {}

  void add(const ShearCard& card) {
    const std::string title = "CSHEAR " + std::to_string(card.id);
    const auto* property = find_law<PshearCard>(building_, card.property, title, card.where);
    Corners corners{};
    bool sound = property != nullptr;
    for (std::size_t i = 0; i < 4; ++i) {
      corners[i] = building_.node(card.nodes[i], title, card.where);
      sound = sound && corners[i] >= 0;
    }
    if (!sound) return;
    const MaterialCard* material = materials_.find(property->material, title, card.where);
    if (material == nullptr) return;
    const auto* law = std::get_if<Material1>(&material->law);
    if (law == nullptr)
      return building_.files.problem(card.where, title + ": its material is not isotropic",
                                     "a shear panel needs a MAT1", "give the material as MAT1");
    const IsotropicMaterial isotropic = materials_.complete(*law, material->where);
    add_shear(card, *property, isotropic, corners);
    add_edges(card, *property, isotropic, corners);
    add_mass(*property, isotropic, corners);
  }

private:
  [[nodiscard]] Eigen::Vector3d diagonal(const Corners& corners, std::size_t from) const {
    return building_.place(corners[from + 2]) - building_.place(corners[from]);
  }
  [[nodiscard]] double area(const Corners& corners) const {
    return 0.5 * diagonal(corners, 0).cross(diagonal(corners, 1)).norm();
  }
  [[nodiscard]] double length(const Corners& corners, std::size_t edge) const {
    return (building_.place(corners[(edge + 1) % 4]) - building_.place(corners[edge])).norm();
  }

  /// The deformation is D over the mean length of the diagonals, so that its spring is a force per displacement.
  void add_shear(const ShearCard& card, const PshearCard& property, const IsotropicMaterial& material,
                 const Corners& corners) {
    const Eigen::Vector3d d13 = diagonal(corners, 0), d24 = diagonal(corners, 1);
    const Eigen::Vector3d a = 0.5 * (d13 - d24), b = 0.5 * (d13 + d24);
    const double surface = area(corners), size = 0.5 * (d13.norm() + d24.norm());
    if (!(surface > 1e-6 * size * size))
      return building_.files.problem(card.where, "CSHEAR " + std::to_string(card.id) + " has no area",
                                     "its grid points lie on a line or are not in order around it", "correct them");
    const Eigen::Vector3d middles =
        diagonal(corners, 0) - diagonal(corners, 1) + 2.0 * (building_.place(corners[0]) - building_.place(corners[1]));
    if (middles.norm() > 0.1 * size)
      building_.note(card.where, "CSHEAR that is no parallelogram",
                     "it has the shear stiffness of the parallelogram with its diagonals", DeckNoteKind::doubtful);
    const double cotangent = a.dot(b) / surface;
    const double skew = 1.0 + 2.0 * cotangent * cotangent / (1.0 + material.poissons_ratio);
    DofSum deformation = along(0.5 / size * d13, corners[0], corners[2]);
    const DofSum other = along(-0.5 / size * d24, corners[1], corners[3]);
    deformation.insert(deformation.end(), other.begin(), other.end());
    const double stiffness = material.shear_modulus() * property.thickness / (surface * skew) * size * size;
    building_.model.joints.push_back({"cshear" + std::to_string(card.id), std::move(deformation), stiffness, 0.0});
  }

  /// Rods along opposite edges for the skin that works with them in tension: up to F = 1.01 that share of the panel's
  /// section, above it the area F T^2 / 2 each.
  void add_edges(const ShearCard& card, const PshearCard& property, const IsotropicMaterial& material,
                 const Corners& corners) {
    for (std::size_t pair = 0; pair < 2; ++pair) {
      const double share = property.effectiveness[pair], thickness = property.thickness;
      if (share <= 0.0) continue;
      const double lengths = length(corners, pair) + length(corners, pair + 2);
      const double section =
          share <= 1.01 ? share * thickness * area(corners) / lengths : 0.5 * share * thickness * thickness;
      for (const std::size_t edge : {pair, pair + 2}) {
        const auto from = corners[edge], to = corners[(edge + 1) % 4];
        const Eigen::Vector3d line = building_.place(to) - building_.place(from);
        building_.model.joints.push_back({"cshear" + std::to_string(card.id) + ".e" + std::to_string(edge + 1),
                                          along(line.normalized(), from, to),
                                          material.youngs_modulus * section / line.norm(), 0.0});
      }
    }
  }

  /// A quarter of the panel at each corner.
  void add_mass(const PshearCard& property, const IsotropicMaterial& material, const Corners& corners) {
    const double mass =
        (material.density * property.thickness + property.nonstructural_mass * building_.bulk.mass_factor) *
        area(corners);
    for (const auto node : corners)
      for (int k = 0; k < 3 && mass != 0.0; ++k)
        building_.matrices.add(MatrixGather::mass, {{{node, k}, 1.0}}, {{{node, k}, 1.0}}, 0.25 * mass);
  }

  Building& building_;
  Materials& materials_;
};

}  // namespace

void build_shear_panels(Building& building, Materials& materials) {
  PanelBuilder builder(building, materials);
  for (const auto& card : building.bulk.shear_panels) builder.add(card);
}

}  // namespace kalfem::nastran
