// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/nastran/card_readers.hpp"

#include <algorithm>
#include <unordered_map>

#include "kalfem/formats/gmsh/gmsh_scanner.hpp"
#include "kalfem/formats/nastran/card_ledger.hpp"

namespace kalfem::nastran {
namespace {

using Read = void (*)(const Card&, const Reading&);

const std::unordered_map<std::string_view, Read>& all_readers() {
  static const auto readers = [] {
    std::unordered_map<std::string_view, Read> all;
    for (const auto list :
         {node_cards(), shell_cards(), beam_cards(), scalar_cards(), material_cards(), temperature_cards(),
          property_cards(), section_cards(), constraint_cards(), load_cards(), matrix_cards()})
      for (const auto& reader : list) all.emplace(reader.name, reader.read);
    return all;
  }();
  return readers;
}

struct UnusedClass {
  DeckNoteKind kind;
  std::string_view consequence;  ///< empty: no effect on stiffness, mass and damping, passed over
  std::vector<std::string_view> prefixes;
};

constexpr auto unused = DeckNoteKind::unused;
constexpr auto doubtful = DeckNoteKind::doubtful;
constexpr auto missing = DeckNoteKind::missing;

/// Tried from the first on; a name belongs to the first class with a prefix of it.
const std::vector<UnusedClass>& unused_classes() {
  static const std::vector<UnusedClass> classes = {
      {unused, "", {"EIG",     "SUPORT", "PLOTEL",  "SET1",    "SET2",    "SET3",    "USET",   "CSET",    "BSET",
                    "QSET",    "SPCD",   "SPCOFF",  "SPCR",    "DVGRID",  "FREQ",    "TSTEP",  "TABLE",   "TABDMP",
                    "DLOAD",   "LOADT",  "DSCREEN", "DOPTPRM", "DELAY",   "DPHASE",  "MDLPRM", "NLPARM",  "NLPCI",
                    "NLSTEP",  "PSET",   "RANDPS",  "RANDT",   "PLOTG",   "DTI",     "DMI",    "ECHOON",  "ECHOOFF",
                    "TEMPD",   "SESET",  "RAD",     "BDYOR",   "VIEW",    "CHBDY",   "PHBDY",  "CONV",    "PCONV",
                    "MAT4",    "MAT5",   "ACMODL",  "OUTPUT",  "OUTRCV",  "RGYRO",   "ROTOR",  "DYNRED",  "NSMADD",
                    "MONPNT",  "MONDSP", "MAT1F",   "ENDT",    "TIC",     "MKAERO",  "TRIM",   "AEROS",   "AERO",
                    "AELIST",  "AESURF", "AESTAT",  "AEPARM",  "AEFACT",  "AELINK",  "AECOMP", "FLUTTER", "FLFACT",
                    "GUST",    "DIVERG", "SPLINE",  "CAERO",   "PAERO",   "CSSCHD",  "SEQGP",  "PARAMR",  "DYPARM",
                    "SWLDPRM", "BCPARA", "SPBLND",  "CBARAO",  "CAMPBLL", "CONTRLT", "RCROSS", "BNDF",    "SEUSET",
                    "SEQSET",  "SECSET", "SEBSET",  "SESUP"}},
      {unused,
       "loads are ignored; only the structure is read",
       {"FORCE", "MOMENT", "PLOAD",  "GRAV", "LOAD", "RLOAD",  "TLOAD", "ACSRCE", "DAREA",  "TEMP",  "RFORCE", "ACCEL",
        "LSEQ",  "SLOAD",  "PRESAX", "QBDY", "QVOL", "DEFORM", "NOLIN", "BOLT",   "SLOADN", "CLOAD", "LOADCYN"}},
      {unused,
       "optimisation is ignored; the properties are used as they are",
       {"DESVAR", "DVPREL", "DVCREL", "DVMREL", "DRESP", "DCONSTR", "DCONADD", "DEQATN", "DLINK", "DDVAL", "DTABLE",
        "DVSHAP", "DVBSHAP", "TOPVAR", "DOBJ", "DOPT", "BEADVAR", "TOMVAR"}},
      {unused, "reductions in the deck are ignored; the full model is read", {"ASET", "OMIT"}},
      {missing,
       "superelements are not supported: their stiffness and mass are missing",
       {"CSUPER", "SEBULK", "SECON", "SEEXCLD", "SELOC", "SEMPLN", "EXTRN"}},
      {unused,
       "the division into superelements is ignored; the deck is read as one structure",
       {"SELABEL", "SEELT", "SEB", "SEC", "SEQ", "SES", "SETREE", "RELEASE"}},
      {missing, "this nonstructural mass is missing; give it as NSM of a property or as CONM2", {"NSM"}},
      {missing,
       "gaps and contact are not supported: the parts are not connected there",
       {"CGAP", "BCTABL", "BCONTACT", "BGSET", "BGADD", "BCTSET", "BCTADD"}},
      {unused,
       "gaps and contact are not supported",
       {"PGAP", "BCBODY", "BSURF", "BCONP", "BLSEG", "BFRIC", "BCT", "BCB", "BGPARM", "BCPROP", "BCGRID"}},
      {missing,
       "the parts are not connected there",
       {"CWELD", "CFAST", "CSEAM", "RSPLINE", "RSSCON", "RTRPLT", "RJOINT", "CINTC", "RBAR1", "RBJOINT", "RBJSTIF"}},
      {missing, "the cyclic symmetry that connects its faces is missing", {"CYJOIN", "CYAX", "CYSYM", "CYSUP"}},
      {unused, "its elements are not supported", {"PWELD", "PFAST", "PSEAM", "PBEND", "PBEAM3", "PRAC", "PCONEAX"}},
      {unused,
       "only the linear part of this material is read",
       {"MATS1", "MATT", "MATF", "MATEP", "MATHE", "MATVE", "CREEP", "MATTVE"}},
      {doubtful,
       "the dependence on frequency or deflection is ignored; the nominal values are used",
       {"PBUSHT", "PELAST", "PDAMPT"}},
      {unused, "matrices of aerodynamics and fluids are not supported", {"DMIJ", "DMIK", "DMIAX"}},
      {doubtful, "this coordinate system is not supported", {"CORD"}},
      {missing, "this stiffness is missing", {"GENEL"}},
      {missing, "the terms of this transfer function are missing in stiffness, damping and mass", {"TF"}},
      {DeckNoteKind::changed, "this damping is ignored", {"HYBDAMP", "DAMPING"}},
  };
  return classes;
}

/// Elements that are known and have no counterpart here.
bool is_left_out_element(std::string_view name) {
  if (name == "CBARAO") return false;
  for (const std::string_view known :
       {"CBEND",  "CBEAM3", "CQUADX", "CTRIAX", "CQUAD",  "CRAC",   "CCONE",   "CHACAB", "CHACBR",
        "CDUM",   "CAXIF",  "CSLOT",  "CFLUID", "CELAS",  "CDAMP5", "CBUSH2D", "CHEX",   "CIHEX",
        "CTWIST", "CWEDGE", "CTRI",   "CQDMEM", "CTRMEM", "CTETR",  "CPENT",   "CPYRA",  "CROD",
        "CBAR",   "CBEAM",  "CBUSH",  "CMASS",  "CDAMP",  "CONM",   "CONROD",  "CTUBE"})
    if (name.starts_with(known)) return true;
  return false;
}

bool is_plain_word(std::string_view name) {
  return !name.empty() && name.size() <= 8 && name[0] >= 'A' && name[0] <= 'Z' &&
         std::ranges::all_of(name, [](char c) { return (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_'; });
}

}  // namespace

// A card is found by its full name in the tables of its readers. Problems of one card do not stop the others.
void read_card(const Card& card, const Reading& reading) {
  const auto& readers = all_readers();
  const auto reader = readers.find(card.name);
  try {
    if (reader == readers.end())
      unused_card(card, reading);
    else
      reader->second(card, reading);
    // Words of an included file, which may be no deck, are not shown.
    const bool is_hidden = reader == readers.end() && card.place.file > 0;
    account_for_fields(card, reading, is_hidden ? "a card that is not read" : card.name);
  } catch (const CardError& error) {
    reading.files.problem(card.place, error);
  }
}

// A card without a reader passes, in this order: names of elements, whose stiffness is missing; classes by prefix;
// first letters that tell properties, materials and elements; all others.
void unused_card(const Card& card, const Reading& reading) {
  const std::string& name = card.name;
  if (!is_plain_word(name))
    throw CardError("a line begins with '" + printable(name) + "'", "a card must begin with its name",
                    "correct the line; comments begin with $");
  for (std::size_t i = 1; i <= card.size(); ++i) card.mark(i, FieldUse::told);
  // Elements that name such a property or material tell that it is not read.
  if ((name.starts_with("P") || name.starts_with("MAT")) && card.is_integer(1)) {
    auto& unread = name.starts_with("MAT") ? reading.bulk.unread_materials : reading.bulk.unread_properties;
    if (const auto id = card.integer(1, "ID"); id > 0 && id <= 2'147'483'647)
      unread.try_emplace(static_cast<Id>(id), card.place.file > 0 ? "a card" : name);
  }
  // A word at the start of a line makes no card, and a file that is included may be no deck: its words are not shown.
  const std::string unknown = card.place.file > 0 ? "an unknown card of an included file" : name;
  if (name.starts_with("NSM") && !reading.chooses_nsm)
    return reading.note(card, name, "no NSM of the case control chooses it, so it adds no mass", unused);
  if (is_left_out_element(name))
    return reading.note(card, name, "unsupported element: its stiffness and mass are missing", missing);
  for (const auto& [kind, consequence, prefixes] : unused_classes())
    for (const auto prefix : prefixes)
      if (name.starts_with(prefix)) {
        const std::string shown = card.place.file > 0 ? std::string(prefix) : name;
        if (!consequence.empty()) reading.note(card, shown, std::string(consequence), kind);
        return;
      }
  if (name.starts_with("P") || name.starts_with("MAT"))
    return reading.note(card, unknown, "unsupported card: elements that refer to it cannot be built", unused);
  if (name.starts_with("C"))
    return reading.note(card, unknown, "unknown card; by its name it is an element: its stiffness and mass are missing",
                        missing);
  reading.note(card, unknown, "unknown card, ignored; if it belongs to the structure, that part is missing", doubtful);
}

}  // namespace kalfem::nastran
