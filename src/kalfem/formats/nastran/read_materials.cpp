#include <array>

#include "kalfem/formats/nastran/card_readers.hpp"

namespace kalfem::nastran {
namespace {

template <typename Law>
void add_material(const Card& card, const Reading& in, const Law& law) {
  if (!in.bulk.materials.try_emplace(card.id(1, "MID"), MaterialCard{law, card.place}).second)
    throw CardError("material " + std::to_string(card.id(1, "MID")) + " is given twice", "",
                    "take one of the cards out");
}

void note_damping(const Card& card, const Reading& in, std::size_t field) {
  if (card.real_or(field, 0.0, "GE") != 0.0)
    in.note(card, "structural damping (GE)", "springs and materials are without it; give modal damping instead");
}

void read_mat1(const Card& card, const Reading& in) {
  Material1 law;
  law.youngs_modulus = card.real_or(2, not_given, "E");
  law.shear_modulus = card.real_or(3, not_given, "G");
  law.poissons_ratio = card.real_or(4, not_given, "NU");
  law.density = card.real_or(5, 0.0, "RHO");
  note_damping(card, in, 8);
  add_material(card, in, law);
}

void read_mat2(const Card& card, const Reading& in) {
  Material2 law;
  std::size_t field = 2;
  for (int row = 0; row < 3; ++row)
    for (int column = row; column < 3; ++column, ++field)
      law.stiffness(row, column) = law.stiffness(column, row) = card.real_or(field, 0.0, "G");
  law.density = card.real_or(8, 0.0, "RHO");
  note_damping(card, in, 13);
  add_material(card, in, law);
}

void read_mat8(const Card& card, const Reading& in) {
  Material8 law;
  law.e1 = card.real(2, "E1");
  law.e2 = card.real(3, "E2");
  law.nu12 = card.real_or(4, 0.0, "NU12");
  law.g12 = card.real_or(5, 0.0, "G12");
  law.g13 = card.real_or(6, 0.0, "G1Z");
  law.g23 = card.real_or(7, 0.0, "G2Z");
  law.density = card.real_or(8, 0.0, "RHO");
  note_damping(card, in, 17);
  add_material(card, in, law);
}

void read_mat9(const Card& card, const Reading& in) {
  Material9 law;
  std::size_t field = 2;
  for (int row = 0; row < 6; ++row)
    for (int column = row; column < 6; ++column, ++field)
      law.stiffness(row, column) = law.stiffness(column, row) = card.real_or(field, 0.0, "G");
  law.density = card.real_or(23, 0.0, "RHO");
  note_damping(card, in, 31);
  add_material(card, in, law);
}

constexpr auto material_readers =
    std::to_array<CardReader>({{"MAT1", read_mat1}, {"MAT2", read_mat2}, {"MAT8", read_mat8}, {"MAT9", read_mat9}});

}  // namespace

std::span<const CardReader> material_cards() { return material_readers; }

}  // namespace kalfem::nastran
