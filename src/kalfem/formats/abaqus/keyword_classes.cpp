// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/abaqus/deck_reader.hpp"

#include <algorithm>
#include <initializer_list>
#include <map>
#include <vector>

namespace kalfem::abaqus {

namespace {

using Names = std::initializer_list<const char*>;
using Table = std::map<std::string, KeywordClass, std::less<>>;

void enter(Table& table, KeywordUse use, const std::string& consequence, Names names) {
  for (const char* name : names) table.emplace(name, KeywordClass{use, consequence});
}

void enter_used(Table& table) {
  enter(table, KeywordUse::stored, "",
        {"SHELLSECTION",
         "SHELLGENERALSECTION",
         "SOLIDSECTION",
         "MEMBRANESECTION",
         "BEAMSECTION",
         "BEAMGENERALSECTION",
         "ORIENTATION",
         "TRANSFORM",
         "SURFACE",
         "BOUNDARY",
         "EQUATION",
         "MPC",
         "RIGIDBODY",
         "COUPLING",
         "KINEMATICCOUPLING",
         "DISTRIBUTINGCOUPLING",
         "TIE",
         "MASS",
         "ROTARYINERTIA",
         "SPRING",
         "DASHPOT",
         "NONSTRUCTURALMASS",
         "NODALTHICKNESS",
         "MATRIXASSEMBLE",
         "RELEASE",
         "AMPLITUDE"});
  enter(table, KeywordUse::option, "",
        {"KINEMATIC", "DISTRIBUTING", "TRANSVERSESHEARSTIFFNESS", "CENTROID", "SHEARCENTER", "BEAMSECTIONOFFSET"});
  enter(table, KeywordUse::material_option, "", {"ELASTIC", "DENSITY"});
}

void enter_silent(Table& table) {
  enter(table, KeywordUse::silent, "",
        {"HEADING",
         "PREPRINT",
         "OUTPUT",
         "NODEOUTPUT",
         "ELEMENTOUTPUT",
         "CONTACTOUTPUT",
         "ENERGYOUTPUT",
         "MODALOUTPUT",
         "SURFACEOUTPUT",
         "RADIATIONOUTPUT",
         "INTEGRATEDOUTPUT",
         "INCREMENTATIONOUTPUT",
         "NODEPRINT",
         "NODEFILE",
         "ELPRINT",
         "ELFILE",
         "ENERGYPRINT",
         "ENERGYFILE",
         "CONTACTPRINT",
         "CONTACTFILE",
         "SECTIONPRINT",
         "SECTIONFILE",
         "MODALPRINT",
         "MODALFILE",
         "FACEPRINT",
         "FILEFORMAT",
         "FILEOUTPUT",
         "RESTART",
         "MONITOR",
         "PRINT",
         "DIAGNOSTICS",
         "TIMEPOINTS",
         "PHYSICALCONSTANTS",
         "VALUESATINFINITY",
         "ENDASSEMBLY",
         "ENDPART",
         "ENDINSTANCE",
         "ENDSTEP",
         "ELEMENTMATRIXOUTPUT",
         "SURFACEINTERACTION",
         "CONTROLS",
         "SOLVERCONTROLS",
         "SECTIONCONTROLS",
         "HOURGLASSSTIFFNESS",
         "INTEGRATEDOUTPUTSECTION",
         "CLEARANCE",
         "CONTACTINCLUSIONS",
         "CONTACTEXCLUSIONS",
         "CONTACTPROPERTYASSIGNMENT",
         "SURFACEBEHAVIOR",
         "SURFACEPROPERTYASSIGNMENT",
         "CONTACTFORMULATION",
         "CONTACTCONTROLS",
         "CONTACTINITIALIZATIONDATA",
         "CONTACTINITIALIZATIONASSIGNMENT",
         "SECTIONPOINTS",
         "RIGIDSURFACE",
         "DEPVAR",
         "USERDEFINEDFIELD",
         "BASELINECORRECTION",
         "DISPLAYBODY",
         "FILTER",
         "EXTREMEVALUE",
         "TRACERPARTICLE",
         "SUBCYCLING",
         "CONTACTCLEARANCE",
         "CONTACTCLEARANCEASSIGNMENT",
         "CONTACTSTIFFNESS",
         "CHANGESURFACEBEHAVIOR",
         "CHANGECONTACTTYPE",
         "SURFACEPROPERTY",
         "DESIGNVARIABLES",
         "DESIGNRESPONSE",
         "OBJECTIVE",
         "GEOMETRICTOLERANCES",
         "RANDOMFIELD",
         "CORRELATIONLENGTH",
         "CRACKPROPAGATION",
         "REFINEMESH"});
}

void enter_steps(Table& table) {
  enter(table, KeywordUse::procedure, "",
        {"STATIC",
         "FREQUENCY",
         "BUCKLE",
         "COMPLEXFREQUENCY",
         "DYNAMIC",
         "MODALDYNAMIC",
         "STEADYSTATEDYNAMICS",
         "RANDOMRESPONSE",
         "RESPONSESPECTRUM",
         "HEATTRANSFER",
         "COUPLEDTEMPERATURE-DISPLACEMENT",
         "UNCOUPLEDTEMPERATURE-DISPLACEMENT",
         "COUPLEDTHERMAL-ELECTRICAL",
         "DYNAMICTEMPERATURE-DISPLACEMENT",
         "VISCO",
         "GREEN",
         "ELECTROMAGNETICS",
         "SENSITIVITY",
         "NOANALYSIS",
         "SUBSTRUCTUREGENERATE",
         "GEOSTATIC",
         "SOILS",
         "ANNEAL",
         "MASSDIFFUSION",
         "DIRECTCYCLIC",
         "STEADYSTATETRANSPORT",
         "FEASIBLEDIRECTION",
         "ROBUSTDESIGN",
         "MATRIXGENERATE",
         "HCF"});
  enter(table, KeywordUse::load,
        "loads do not change the modes; `static: {deck_cases: true}` reads those of static steps",
        {"CLOAD", "DLOAD", "DSLOAD", "TEMPERATURE", "INERTIARELIEF", "PRE-TENSIONSECTION", "CONNECTORLOAD",
         "CONNECTORMOTION", "FOLLOWER", "LOADCASE", "ENDLOADCASE", "FIELD", "SUBSTRUCTURELOADCASE",
         "INITIALSTRAININCREASE"});
  enter(table, KeywordUse::noted, "the excitation of a step that is not run is not read",
        {"BASEMOTION", "PRIMARYBASEMOTION", "PSDDEFINITION", "SPECTRUM", "CORRELATION"});
  enter(table, KeywordUse::noted, "heat is not modelled",
        {"DSFLUX", "DFLUX", "CFLUX", "FILM", "SFILM", "CFILM", "RADIATE", "SRADIATE", "VIEWFACTOR", "MASSFLOW",
         "DECURRENT", "CECURRENT", "DECHARGE", "CECHARGE"});
  enter(table, KeywordUse::changed, "masses are those of the densities: they are not scaled",
        {"MASSSCALING", "FIXEDMASSSCALING", "VARIABLEMASSSCALING"});
  enter(table, KeywordUse::lacking, "the model is read as it is before the first step",
        {"MODELCHANGE", "CHANGESOLIDSECTION", "CHANGEMATERIAL", "CHANGEPLASTIC", "ADDEDMASS", "CONNECTORFAILURE"});
}

void enter_notes(Table& table) {
  enter(table, KeywordUse::noted, "initial stresses, velocities and fields are no part of the linear model",
        {"INITIALCONDITIONS"});
  enter(table, KeywordUse::lacking, "contact does not join the parts", {"CONTACTPAIR", "CONTACT", "GAP"});
  enter(table, KeywordUse::noted, "contact is not read",
        {"CONTACTINTERFERENCE", "FRICTION", "CONTACTDAMPING", "CONTACTSTABILIZATION", "COHESIVEBEHAVIOR",
         "SURFACESMOOTHING", "CHANGEFRICTION", "GAPCONDUCTANCE", "GAPHEATGENERATION", "INTERACTION", "PAIR"});
  enter(table, KeywordUse::noted, "only the linear elastic behaviour is used",
        {"PLASTIC",
         "HYPERELASTIC",
         "HYPERFOAM",
         "CREEP",
         "VISCOELASTIC",
         "DEFORMATIONPLASTICITY",
         "CYCLICHARDENING",
         "DRUCKERPRAGER",
         "DRUCKERPRAGERHARDENING",
         "CAPPLASTICITY",
         "CAPHARDENING",
         "MOHRCOULOMB",
         "MOHRCOULOMBHARDENING",
         "CONCRETE",
         "CONCRETEDAMAGEDPLASTICITY",
         "CONCRETECOMPRESSIONHARDENING",
         "CONCRETETENSIONSTIFFENING",
         "CONCRETECOMPRESSIONDAMAGE",
         "CONCRETETENSIONDAMAGE",
         "BRITTLECRACKING",
         "CRUSHABLEFOAM",
         "CRUSHABLEFOAMHARDENING",
         "DAMAGEINITIATION",
         "DAMAGEEVOLUTION",
         "DAMAGESTABILIZATION",
         "HYPOELASTIC",
         "MULLINSEFFECT",
         "HYSTERESIS",
         "RATEDEPENDENT",
         "POTENTIAL",
         "ANNEALTEMPERATURE",
         "NOTENSION",
         "NOCOMPRESSION",
         "FAILSTRAIN",
         "FAILSTRESS",
         "SHEARFAILURE",
         "TENSILEFAILURE",
         "EOS",
         "USERMATERIAL",
         "VISCOUS",
         "CASTIRONPLASTICITY",
         "POROUSMETALPLASTICITY",
         "SUPERELASTIC",
         "CYCLICPLASTIC",
         "TRS"});
  enter(table, KeywordUse::noted, "damping of steps is ignored; give damping in the case",
        {"MODALDAMPING", "COMPOSITEMODALDAMPING", "DAMPINGCONTROLS"});
  enter(table, KeywordUse::changed, "damping of materials and of the model is ignored; give damping in the case",
        {"DAMPING", "GLOBALDAMPING", "STRUCTURALDAMPING"});
  enter(table, KeywordUse::noted, "heat, flow and electricity are not modelled",
        {"EXPANSION",
         "CONDUCTIVITY",
         "SPECIFICHEAT",
         "LATENTHEAT",
         "HEATGENERATION",
         "INELASTICHEATFRACTION",
         "PERMEABILITY",
         "SORPTION",
         "ELECTRICALCONDUCTIVITY",
         "DIELECTRIC",
         "PIEZOELECTRIC",
         "JOULEHEATFRACTION",
         "FLUIDCONSTANTS",
         "SPECIFICGASCONSTANT",
         "DIFFUSIVITY",
         "SOLUBILITY",
         "MAGNETICPERMEABILITY",
         "ACOUSTICMEDIUM",
         "SURFACEFLUX",
         "CAVITYDEFINITION"});
  enter(table, KeywordUse::doubtful, "ignored: directions of shells and beams follow from their nodes and sections",
        {"NORMAL"});
  enter(table, KeywordUse::changed, "the geometry is that of the nodes as given", {"IMPERFECTION"});
  enter(table, KeywordUse::noted, "the selection is ignored: the whole model is read",
        {"RETAINEDNODALDOFS", "SUBSTRUCTUREMATRIXOUTPUT", "SELECTEIGENMODES", "SELECTCYCLICSYMMETRYMODES",
         "MATRIXOUTPUT"});
}

void enter_missing(Table& table) {
  enter(table, KeywordUse::missing, "generated nodes and elements are not supported",
        {"NGEN", "NFILL", "ELGEN", "NCOPY", "ELCOPY", "NMAP", "ELEMENTCOPY", "IMPORT", "IMPORTNSET", "IMPORTELSET",
         "SYMMETRICMODELGENERATION", "BEAMSECTIONGENERATE"});
  enter(table, KeywordUse::missing, "user elements, substructures and matrices by reference are not supported",
        {"USERELEMENT", "UELPROPERTY", "SUBSTRUCTUREPATH", "SUBSTRUCTUREPROPERTY", "MATRIXINPUT", "MATRIX",
         "USERSECTION", "FLUIDSECTION", "CONNECTORSECTION", "JOINT", "FRAMESECTION", "GASKETSECTION", "COHESIVESECTION",
         "EULERIANSECTION", "ACOUSTICINFINITE"});
  enter(table, KeywordUse::missing, "this way of joining parts is not supported",
        {"SHELLTOSOLIDCOUPLING", "EMBEDDEDELEMENT", "CYCLICSYMMETRYMODEL", "TIEDCYCLIC", "FASTENER", "FASTENERPROPERTY",
         "MULTIPOINTCONSTRAINT", "SUBMODEL", "RIGIDBODYLINK"});
  enter(table, KeywordUse::missing, "stiffness and mass of the reinforcement would be missing",
        {"REBAR", "REBARLAYER", "PRESTRESSHOLD"});
  enter(table, KeywordUse::missing, "parameters between < and > in the data lines are not substituted",
        {"PARAMETER", "PARAMETERDEPENDENCE"});
}

const Table& table() {
  static const Table entries = [] {
    Table made;
    enter_used(made);
    enter_silent(made);
    enter_steps(made);
    enter_notes(made);
    enter_missing(made);
    return made;
  }();
  return entries;
}

}  // namespace

KeywordClass classify(std::string_view name) {
  if (const auto entry = table().find(name); entry != table().end()) return entry->second;
  return {KeywordUse::lacking, "unknown keyword; the model is read without it"};
}

}  // namespace kalfem::abaqus
