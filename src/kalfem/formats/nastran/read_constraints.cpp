// SPDX-License-Identifier: Apache-2.0
#include <array>

#include "kalfem/formats/nastran/card_readers.hpp"

namespace kalfem::nastran {
namespace {

// SPC holds two nodes on one card. Enforced displacements act in load cases only.
void read_spc(const Card& card, const Reading& in) {
  for (const std::size_t first : {2, 5}) {
    if (card.blank(first)) continue;
    const Id node = card.id(first, "G");
    const double value = card.real_or(first + 2, 0.0, "D");
    in.bulk.spcs.push_back(
        {card.id(1, "SID"), card.components(first + 1, "C"), {{node, node, 1, true}}, card.place, value});
    if (value != 0.0 && !in.bulk.with_loads)
      in.tell(card, first + 2, "enforced displacement (D of SPC)",
              "the node is fixed at zero; `static: {deck_cases: true}` imposes it", DeckNoteKind::unused);
  }
}

void read_spc1(const Card& card, const Reading& in) {
  in.bulk.spcs.push_back({card.id(1, "SID"), card.components(2, "C"), card.id_list(3, "G"), card.place});
}

void read_sum(std::map<Id, std::vector<Id>>& sums, const Card& card) {
  auto& sets = sums[card.id(1, "SID")];
  for (std::size_t i = 2; i <= card.size(); ++i)
    if (!card.blank(i)) sets.push_back(card.id(i, "S"));
}
void read_spcadd(const Card& card, const Reading& in) { read_sum(in.bulk.spc_sums, card); }
void read_mpcadd(const Card& card, const Reading& in) { read_sum(in.bulk.mpc_sums, card); }

/// Two terms a line, the first of which depends.
void read_mpc(const Card& card, const Reading& in) {
  MpcCard mpc;
  mpc.set = card.id(1, "SID");
  for (std::size_t line = 1; line <= card.size(); line += 8)
    for (const std::size_t first : {line + 1, line + 4}) {
      if (card.blank(first)) continue;
      const double coefficient = card.real_or(first + 2, 0.0, "A");
      if (coefficient == 0.0)
        in.tell(card, first, "terms of MPC whose coefficient is 0", "they have no effect", DeckNoteKind::unused);
      mpc.terms.push_back({card.id(first, "G"), card.component(first + 1, "C"), coefficient});
    }
  if (mpc.terms.empty() || mpc.terms.front().coefficient == 0.0)
    throw CardError(card.name + " " + std::string(card.raw(1)) + ": the first coefficient is zero or missing",
                    "the first component depends on the others and needs a coefficient", "give it a coefficient");
  mpc.where = card.place;
  in.bulk.mpcs.push_back(std::move(mpc));
}

constexpr unsigned all_six = 63;

unsigned needed_components(const Card& card, std::size_t field, const char* what) {
  const unsigned components = card.components(field, what);
  if (components == 0)
    throw CardError(title(card) + ": " + what + " (" + place_on_card(field) + ") names no components",
                    "the card would connect nothing there", "name components, such as 123456");
  return components;
}

void tell_expansion(const Card& card, const Reading& in, std::size_t field) {
  in.tell(card, field, "ALPHA, TREF of " + card.name, "thermal expansion is not used", DeckNoteKind::unused);
}

/// RBE2 EID GN CM GM1 GM2 ... (ALPHA).
void read_rbe2(const Card& card, const Reading& in) {
  RigidBodyCard body{.kind = "RBE2", .id = card.id(1, "EID")};
  body.independent.emplace_back(card.id(2, "GN"), all_six);
  const unsigned components = needed_components(card, 3, "CM");
  std::size_t last = card.size();
  // The last field may be the thermal expansion, a real number, with its temperature behind it.
  for (int i = 0; i < 2 && last >= 5 && !card.is_integer(last) && card.is_number(last); ++i)
    tell_expansion(card, in, last--);
  for (std::size_t i = 4; i <= last; ++i) {
    if (card.blank(i)) continue;
    if (card.says(i, "THRU"))
      throw CardError(title(card) + ": THRU in the list of GM", "THRU is not supported here", "list the grid points");
    body.dependent.emplace_back(card.id(i, "GM"), components);
  }
  body.where = card.place;
  in.bulk.add_element(ElementKind::rigid, body.id, card.place);
  in.bulk.rigid.push_back(std::move(body));
}

/// Dependent components that are blank are all that do not lead.
void read_rbar(const Card& card, const Reading& in) {
  RigidBodyCard body{.kind = "RBAR", .id = card.id(1, "EID")};
  const Id a = card.id(2, "GA"), b = card.id(3, "GB");
  const unsigned lead_a = card.components(4, "CNA"), lead_b = card.components(5, "CNB");
  unsigned follow_a = card.components(6, "CMA"), follow_b = card.components(7, "CMB");
  if (card.blank(6) && card.blank(7)) follow_a = all_six & ~lead_a, follow_b = all_six & ~lead_b;
  body.independent = {{a, lead_a}, {b, lead_b}};
  body.dependent = {{a, follow_a}, {b, follow_b}};
  body.where = card.place;
  in.bulk.add_element(ElementKind::rigid, body.id, card.place);
  in.bulk.rigid.push_back(std::move(body));
}

/// RROD: the distance of two nodes stays; the component CMA or CMB depends.
void read_rrod(const Card& card, const Reading& in) {
  RigidBodyCard body{.kind = "RROD", .id = card.id(1, "EID")};
  body.independent = {{card.id(2, "GA"), 0u}, {card.id(3, "GB"), 0u}};
  body.dependent = {{card.id(2, "GA"), card.components(4, "CMA")}, {card.id(3, "GB"), card.components(5, "CMB")}};
  body.where = card.place;
  in.bulk.add_element(ElementKind::rigid, body.id, card.place);
  in.bulk.rigid.push_back(std::move(body));
}

/// Pairs of node and components, three to a line behind its first field, up to "UM"; dependent ones behind it.
void read_rbe1(const Card& card, const Reading& in) {
  RigidBodyCard body{.kind = "RBE1", .id = card.id(1, "EID")};
  bool dependent = false;
  for (std::size_t line = 1; line <= card.size(); line += 8) {
    dependent = card.says(line, "UM") || dependent;
    for (const std::size_t i : {line + 1, line + 3, line + 5})
      if (card.is_integer(i))
        (dependent ? body.dependent : body.independent)
            .emplace_back(card.id(i, "G"), needed_components(card, i + 1, "C"));
      else if (card.is_number(i))
        tell_expansion(card, in, i);
  }
  body.where = card.place;
  in.bulk.add_element(ElementKind::rigid, body.id, card.place);
  in.bulk.rigid.push_back(std::move(body));
}

/// RBE3 EID - REFGRID REFC (WT C G1 G2 ...)... (UM G C G C ...) (ALPHA a). A real number begins a group.
void read_rbe3(const Card& card, const Reading& in) {
  WeightedCard link;
  link.id = card.id(1, "EID");
  link.reference = card.id(3, "REFGRID");
  link.components = needed_components(card, 4, "REFC");
  std::size_t i = 5;
  for (; i <= card.size(); ++i) {
    if (card.blank(i)) continue;
    if (card.says(i, "UM") || card.says(i, "ALPHA")) break;
    if (!card.is_integer(i)) {
      link.groups.push_back({card.real(i, "WT"), card.components(i + 1, "C"), {}});
      if (link.groups.back().components == 0)
        throw CardError(title(card) + ": the weight in " + place_on_card(i) + " has no components",
                        "a group is a weight, its components and its grid points", "complete or remove the group");
      ++i;
    } else if (link.groups.empty()) {
      throw CardError(title(card) + ": the first weight is '" + std::string(card.raw(i)) + "'",
                      "weights must be real numbers", "write it with a decimal point");
    } else {
      link.groups.back().nodes.push_back(card.id(i, "G"));
    }
  }
  if (card.says(i, "UM"))
    for (++i; i <= card.size() && !card.says(i, "ALPHA"); ++i)
      if (!card.blank(i)) {
        link.moved.emplace_back(card.id(i, "GM"), card.components(i + 1, "CM"));
        ++i;
      }
  for (++i; i <= card.size(); ++i)  // behind ALPHA
    if (card.is_number(i)) tell_expansion(card, in, i);
  for (const auto& group : link.groups)
    if (group.nodes.empty())
      throw CardError(title(card) + " has a weight without grid points",
                      "a group is a weight, its components and its grid points", "complete or remove the group");
  link.where = card.place;
  in.bulk.add_element(ElementKind::rigid, link.id, card.place);
  in.bulk.weighted.push_back(std::move(link));
}

constexpr auto constraint_readers = std::to_array<CardReader>({{"SPC", read_spc},
                                                               {"SPC1", read_spc1},
                                                               {"SPCADD", read_spcadd},
                                                               {"MPC", read_mpc},
                                                               {"MPCADD", read_mpcadd},
                                                               {"RBE2", read_rbe2},
                                                               {"RBAR", read_rbar},
                                                               {"RROD", read_rrod},
                                                               {"RBE1", read_rbe1},
                                                               {"RBE3", read_rbe3}});

}  // namespace

std::span<const CardReader> constraint_cards() { return constraint_readers; }

}  // namespace kalfem::nastran
