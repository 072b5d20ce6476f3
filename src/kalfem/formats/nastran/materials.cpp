#include "kalfem/formats/nastran/model_building.hpp"

namespace kalfem::nastran {

const MaterialCard* Materials::find(Id id, const std::string& title, const Place& where) {
  const auto card = building_.bulk.materials.find(id);
  if (card != building_.bulk.materials.end()) return &card->second;
  const auto unread = building_.bulk.unread_materials.find(id);
  const bool known = unread != building_.bulk.unread_materials.end();
  building_.files.problem(where,
                          title + (known ? " is of the " + unread->second + " " : ": material ") + std::to_string(id) +
                              (known ? "" : " is missing"),
                          known ? "this kind of material is not read" : "the card names it",
                          "give it as MAT1, MAT2, MAT8 or MAT9");
  return nullptr;
}

IsotropicMaterial Materials::complete(const Material1& law, const Place& where) {
  double e = law.youngs_modulus, nu = law.poissons_ratio;
  const double g = law.shear_modulus;
  if (!given(e) && given(g)) e = 2.0 * g * (1.0 + (given(nu) ? nu : 0.0));
  if (!given(nu)) nu = given(g) && g > 0.0 ? e / (2.0 * g) - 1.0 : 0.0;
  // A shear modulus of its own stays in beams; Poisson's ratio of a material must be one.
  if (!given(law.poissons_ratio) && !(nu > -1.0 && nu < 0.5)) {
    building_.note(where, "MAT1 whose E and G give no Poisson's ratio between -1 and 0.5",
                   "shells and solids are read with 0.3; beams and rods keep E and G");
    nu = 0.3;
  } else if (given(g) && given(law.poissons_ratio) && given(law.youngs_modulus) &&
             std::abs(g * 2.0 * (1.0 + nu) - e) > 0.01 * std::abs(e)) {
    building_.note(where, "MAT1 with E, G and NU that do not fit together",
                   "shells and solids are read with E and NU; beams and rods keep E and G");
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
                            "this element takes a MAT1", "give the material as MAT1");
    return {};
  }
  building_.model.materials[name] = complete(*law, card->where);
  return name;
}

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
