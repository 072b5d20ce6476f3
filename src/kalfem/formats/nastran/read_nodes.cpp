#include <array>

#include "kalfem/formats/nastran/card_readers.hpp"

namespace kalfem::nastran {
namespace {

/// More scalar points than this are a mistake.
constexpr std::size_t most_scalar_points = 2'000'000;

void read_grid(const Card& card, const Reading& in) {
  Grid grid;
  grid.id = card.id(1, "ID");
  // Blank fields wait for GRDSET, which may stand behind.
  grid.position_system = card.id_or(2, -2, "CP");
  for (int i = 0; i < 3; ++i) grid.place[i] = card.real_or(static_cast<std::size_t>(3 + i), 0.0, "X");
  grid.motion_system = card.id_or(6, -2, "CD");
  if (grid.motion_system == -1)
    throw CardError(title(card) + ": CD is -1, a fluid point", "fluids are not read", "take the fluid out of the deck");
  grid.held = card.blank(7) ? ~0u : card.components(7, "PS");
  grid.where = card.place;
  in.bulk.grids.push_back(grid);
}

void read_grdset(const Card& card, const Reading& in) {
  in.bulk.grid_defaults = {card.id_or(2, 0, "CP"), card.id_or(6, 0, "CD"), card.components(7, "PS")};
}

void read_spoint(const Card& card, const Reading& in) {
  for (const auto& range : card.id_list(1, "ID")) {
    if (static_cast<std::size_t>(range.last - range.first) > most_scalar_points)
      throw CardError(title(card) + ": more than 2 million points", "", "mend the range");
    for (std::int64_t id = range.first; id <= range.last; id += range.step)
      in.bulk.grids.push_back({static_cast<Id>(id), 0, scalar_point, 0, Eigen::Vector3d::Zero(), card.place});
  }
}

void add_system(Id id, SystemCard system, const Card& card, const Reading& in) {
  system.where = card.place;
  if (!in.bulk.systems.try_emplace(id, system).second)
    throw CardError("coordinate system " + std::to_string(id) + " is given twice", "", "take one of them out");
}

template <SystemKind kind>
void read_cord2(const Card& card, const Reading& in) {
  SystemCard system;
  system.kind = kind;
  system.reference = card.id_or(2, 0, "RID");
  for (int i = 0; i < 9; ++i)
    system.points(i % 3, i / 3) = card.real_or(static_cast<std::size_t>(3 + i), 0.0, "a coordinate of A, B or C");
  add_system(card.id(1, "CID"), system, card, in);
}

template <SystemKind kind>
void read_cord1(const Card& card, const Reading& in) {
  for (const std::size_t first : {1, 5}) {
    if (card.blank(first)) continue;
    SystemCard system;
    system.kind = kind;
    system.nodes = {card.id(first + 1, "G1"), card.id(first + 2, "G2"), card.id(first + 3, "G3")};
    add_system(card.id(first, "CID"), system, card, in);
  }
}

constexpr auto node_readers = std::to_array<CardReader>({{"GRID", read_grid},
                                                         {"GRDSET", read_grdset},
                                                         {"SPOINT", read_spoint},
                                                         {"CORD1R", read_cord1<SystemKind::rectangular>},
                                                         {"CORD1C", read_cord1<SystemKind::cylindrical>},
                                                         {"CORD1S", read_cord1<SystemKind::spherical>},
                                                         {"CORD2R", read_cord2<SystemKind::rectangular>},
                                                         {"CORD2C", read_cord2<SystemKind::cylindrical>},
                                                         {"CORD2S", read_cord2<SystemKind::spherical>}});

}  // namespace

std::span<const CardReader> node_cards() { return node_readers; }

}  // namespace kalfem::nastran
