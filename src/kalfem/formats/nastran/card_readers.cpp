#include "kalfem/formats/nastran/card_readers.hpp"

#include <algorithm>
#include <unordered_map>

#include "kalfem/formats/gmsh_scanner.hpp"

namespace kalfem::nastran {
namespace {

using Read = void (*)(const Card&, const Reading&);

const std::unordered_map<std::string_view, Read>& all_readers() {
  static const auto readers = [] {
    std::unordered_map<std::string_view, Read> all;
    for (const auto list : {node_cards(), shell_cards(), beam_cards(), scalar_cards(), material_cards(),
                            property_cards(), section_cards(), constraint_cards(), matrix_cards()})
      for (const auto& reader : list) all.emplace(reader.name, reader.read);
    return all;
  }();
  return readers;
}

struct UnusedClass {
  std::string_view consequence;  ///< empty: no effect on stiffness, mass and damping, passed over
  std::vector<std::string_view> prefixes;
};

/// Tried from the first on; a name belongs to the first class with a prefix of it.
const std::vector<UnusedClass>& unused_classes() {
  static const std::vector<UnusedClass> classes = {
      {"", {"EIG",     "SUPORT",  "PLOTEL", "SET1",   "SET2",   "SET3",    "USET",   "CSET",   "BSET",   "QSET",
            "SPCD",    "SPCOFF",  "SPCR",   "DVGRID", "FREQ",   "TSTEP",   "TABLE",  "TABDMP", "DLOAD",  "LOADT",
            "DSCREEN", "DOPTPRM", "DELAY",  "DPHASE", "MDLPRM", "NLPARM",  "NLPCI",  "NLSTEP", "PSET",   "RANDPS",
            "RANDT",   "PLOTG",   "DTI",    "DMI",    "ECHOON", "ECHOOFF", "TEMPD",  "SESET",  "RADSET", "BDYOR",
            "VIEW",    "CHBDY",   "PHBDY",  "CONV",   "PCONV",  "MAT4",    "MAT5",   "ACMODL", "OUTPUT", "OUTRCV",
            "RGYRO",   "ROTOR",   "DYNRED", "NSMADD", "MONPNT", "MONDSP",  "MAT1F",  "ENDT",   "TIC",    "MKAERO",
            "TRIM",    "AEROS",   "AERO",   "AELIST", "AESURF", "AESTAT",  "AEPARM", "AEFACT", "AELINK", "AECOMP",
            "FLUTTER", "FLFACT",  "GUST",   "DIVERG", "SPLINE", "CAERO",   "PAERO",  "CSSCHD", "SEQGP",  "PARAMR",
            "DYPARM",  "SWLDPRM", "BCPARA", "SPBLND"}},
      {"loads are not read; only the structure itself is",
       {"FORCE", "MOMENT", "PLOAD", "GRAV",   "LOAD", "RLOAD", "TLOAD",  "ACSRCE", "DAREA", "TEMP",   "RFORCE",
        "ACCEL", "LSEQ",   "SLOAD", "PRESAX", "QBDY", "QVOL",  "DEFORM", "NOLIN",  "BOLT",  "SLOADN", "LOADCYN"}},
      {"optimisation is not read; the design is that of the properties as they stand",
       {"DESVAR", "DVPREL", "DVCREL", "DVMREL", "DRESP", "DCONSTR", "DCONADD", "DEQATN", "DLINK", "DDVAL", "DTABLE",
        "DVSHAP", "DVBSHAP", "TOPVAR", "DOBJ", "DOPT", "BEADVAR", "TOMVAR"}},
      {"no reduction is made of the deck; it reads as the full model", {"ASET", "OMIT"}},
      {"superelements of the deck are not formed; their bulk data parts are not read",
       {"SEBULK", "SECON", "SEEXCLD", "SELABEL", "SELOC", "SEMPLN", "SEELT", "SEB", "SEC", "SEQ", "SES", "SETREE",
        "RELEASE", "EXTRN", "CSUPER", "CSUPEXT"}},
      {"this nonstructural mass is missing; give it as NSM of a property or as CONM2", {"NSM"}},
      {"gaps and contact are not read: the parts are not joined there",
       {"CGAP", "PGAP", "BCTABLE", "BCBODY", "BCONTACT", "BSURF", "BCONP", "BLSEG", "BFRIC", "BCT", "BGSET", "BCB",
        "BGADD"}},
      {"the tie is left out of the model: the parts are not joined there",
       {"CWELD", "CFAST", "CSEAM", "RSPLINE", "RSSCON", "RTRPLT", "RJOINT", "CINTC", "PWELD", "PFAST", "PSEAM"}},
      {"the cards of this material law beside the linear one are not read",
       {"MATS1", "MATT", "MATF", "MATEP", "MATHE", "MATVE", "CREEP", "MATTVE"}},
      {"these matrices are not read", {"GENEL", "DMIJ", "DMIK", "DMIAX", "TF"}},
  };
  return classes;
}

/// Elements that are known and have no counterpart here.
bool is_left_out_element(std::string_view name) {
  for (const std::string_view known : {"CSHEAR",  "CBEND",  "CBEAM3", "CQUADX", "CTRIAX", "CQUAD",  "CRAC",   "CCONE",
                                       "CHACAB",  "CHACBR", "CDUM",   "CAXIF",  "CSLOT",  "CFLUID", "CELAS",  "CDAMP5",
                                       "CBUSH2D", "CHEX",   "CIHEX",  "CTWIST", "CWEDGE", "CTRI",   "CQDMEM", "CTRMEM"})
    if (name.starts_with(known)) return true;
  return false;
}

bool is_plain_word(std::string_view name) {
  return !name.empty() && name.size() <= 8 && name[0] >= 'A' && name[0] <= 'Z' &&
         std::ranges::all_of(name, [](char c) { return (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_'; });
}

}  // namespace

void read_card(const Card& card, const Reading& reading) {
  const auto& readers = all_readers();
  const auto reader = readers.find(card.name);
  try {
    if (reader == readers.end())
      unused_card(card, reading);
    else
      reader->second(card, reading);
  } catch (const CardError& error) {
    reading.files.problem(card.place, error);
  }
}

void unused_card(const Card& card, const Reading& reading) {
  const std::string& name = card.name;
  if (!is_plain_word(name))
    throw CardError("a line begins with '" + printable(name) + "'", "a card begins with its name",
                    "mend the line; comments begin with $");
  // Elements that name such a property or material tell that it is not read.
  if ((name.starts_with("P") || name.starts_with("MAT")) && card.is_integer(1)) {
    auto& unread = name.starts_with("MAT") ? reading.bulk.unread_materials : reading.bulk.unread_properties;
    if (const auto id = card.integer(1, "ID"); id > 0 && id <= 2'147'483'647)
      unread.try_emplace(static_cast<Id>(id), name);
  }
  if (is_left_out_element(name))
    return reading.note(card, name, "the element is left out of the structure: its stiffness and mass are missing");
  for (const auto& [consequence, prefixes] : unused_classes())
    for (const auto prefix : prefixes)
      if (name.starts_with(prefix)) {
        if (!consequence.empty()) reading.note(card, name, std::string(consequence));
        return;
      }
  if (name.starts_with("P") || name.starts_with("MAT"))
    return reading.note(card, name, "the card is not read; elements that name it cannot be formed");
  if (name.starts_with("C"))
    return reading.note(card, name, "the card is not known; if it is an element, its stiffness and mass are missing");
  reading.note(card, name, "the card is not known and not used; if it is part of the structure, that part is missing");
}

}  // namespace kalfem::nastran
