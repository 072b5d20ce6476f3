// SPDX-License-Identifier: Apache-2.0
#include <numbers>

#include "kalfem/casefile/case_schema.hpp"
#include "kalfem/casefile/plausible.hpp"
#include "kalfem/yaml/map_schema.hpp"

namespace kalfem::description {

using namespace schema;

namespace {

Schema<double> length() { return number("m", plausible::length()); }
Schema<double> factor() { return number("-", Bounds::nonnegative()); }
Schema<std::vector<std::string>> directions() { return list(word({"x", "y", "z", "rx", "ry", "rz"})); }

Schema<Material> material() {
  return mapping(
      Fields<Material>()
          .required("youngs_modulus", &Material::youngs_modulus, number("Pa", plausible::modulus()), "E")
          .optional("poissons_ratio", &Material::poissons_ratio, number("-", Bounds::between(-0.99, 0.499)), "nu")
          .required("density", &Material::density, number("kg/m^3", plausible::density()),
                    "rho; 0 for a material without mass"));
}

// One key per shape of section. A shape is its dimensions; its constants (A, I, J and shear factors) are computed
// later.
Schema<SectionHolder> section() {
  const auto rectangle = Fields<RectangleSection>()
                             .required("width", &RectangleSection::width, length(), "width along local y")
                             .required("height", &RectangleSection::height, length(), "height along local z");
  const auto circle = Fields<CircleSection>().required("diameter", &CircleSection::diameter, length(), "outer");
  const auto tube = Fields<CircularTubeSection>()
                        .required("diameter", &CircularTubeSection::diameter, length(), "outer")
                        .required("wall", &CircularTubeSection::wall, length(), "thickness");
  const auto box = Fields<RectangularTubeSection>()
                       .required("width", &RectangularTubeSection::width, length(), "outer width along local y")
                       .required("height", &RectangularTubeSection::height, length(), "outer height along local z")
                       .required("wall", &RectangularTubeSection::wall, length(), "thickness");
  const auto general =
      Fields<GeneralSection>()
          .required("area", &GeneralSection::area, number("m^2", Bounds::positive()), "A")
          .required("inertia_y", &GeneralSection::inertia_y, number("m^4", Bounds::positive()),
                    "second moment of area for bending in x-z")
          .required("inertia_z", &GeneralSection::inertia_z, number("m^4", Bounds::positive()),
                    "second moment of area for bending in x-y")
          .required("torsion", &GeneralSection::torsion, number("m^4", Bounds::positive()),
                    "torsion constant J (St Venant)")
          .optional("shear_factor_y", &GeneralSection::shear_factor_y, factor(), "shear area / A; 0 for rigid in shear")
          .optional("shear_factor_z", &GeneralSection::shear_factor_z, factor(),
                    "shear area / A; 0 for rigid in shear");
  return mapping(Fields<SectionHolder>().one_of(
      &SectionHolder::section, when("rectangle", mapping(rectangle), "solid rectangle"),
      when("circle", mapping(circle), "solid circle"), when("circular_tube", mapping(tube), "circular tube"),
      when("rectangular_tube", mapping(box), "thin-walled rectangular tube"),
      when("general", mapping(general), "any section, given by its constants")));
}

Schema<Region> region() {
  const auto shell = Fields<ShellRegion>()
                         .required("thickness", &ShellRegion::thickness, length(), "thickness of the shell")
                         .optional("offset", &ShellRegion::offset, number("m", plausible::position()),
                                   "distance of the mid-surface above the nodes");
  const auto solid = Fields<SolidRegion>().optional(
      "integration", &SolidRegion::kind,
      choice<SolidKind>({{"standard", SolidKind::standard, "incompatible modes: no shear locking"},
                         {"full", SolidKind::full, "standard displacement element"},
                         {"mean_dilatation", SolidKind::mean_dilatation, "B-bar (8-node hexahedra)"},
                         {"reduced", SolidKind::reduced, "fewer points"}}),
      "treatment of the strains");
  const auto beam =
      Fields<BeamRegion>()
          .required("section", &BeamRegion::section, section(), "cross-section")
          .optional("up", &BeamRegion::up, tuple<3>(number("-")),
                    "orientation vector: local z lies in the plane of the axis and this vector; any for round sections")
          .optional("offset", &BeamRegion::offset, tuple<3>(number("m", plausible::position())),
                    "offset of the centroid from the node, in global axes");
  return mapping(Fields<Region>()
                     .required("material", &Region::material, name(), "name of one of `materials`")
                     .one_of(&Region::property, when("shell", mapping(shell), "triangles and quadrilaterals"),
                             when("beam", mapping(beam), "lines"),
                             when("solid", mapping(solid), "tetrahedra, wedges and hexahedra")));
}

/// A group or node number, or the coordinates of a place.
Schema<NodePlace> node_place() {
  const auto group = written_as("group | number", text());
  const auto place = tuple<3>(number("m", plausible::position()));
  const auto read = [=](const CaseNode& node, NodePlace& given) {
    given = {};
    return node.yaml().kind == YamlNode::Kind::scalar ? group.read(node, given.group) : place.read(node, given.at);
  };
  const auto write = [=](const NodePlace& given) {
    return given.group.empty() ? place.write(given.at) : group.write(given.group);
  };
  return make_schema<NodePlace>(read, write, either_schema(group.json_schema(), place.json_schema()));
}

Schema<Gauge> gauge() {
  const auto element = convert<GaugeElement>(
      integer(1, std::numeric_limits<int>::max()), [](int number) { return GaugeElement{number}; },
      [](const GaugeElement& given) { return static_cast<int>(given.number); });
  return mapping(
      Fields<Gauge>()
          .one_of(&Gauge::place,
                  when("at", located(node_place()),
                       "where it is bonded: coordinates [x, y, z] (the nearest element), or a group or node"),
                  when("element", element, "element of the mesh or deck by its number; the gauge is at its centre"))
          .optional("direction", &Gauge::direction, tuple<3>(number("-")),
                    "direction that it measures along, in global axes, laid into the surface of a shell; not needed "
                    "on a beam")
          .optional("surface", &Gauge::surface,
                    choice<Layer>({{"top", Layer::top, "on the side of the element's normal"},
                                   {"middle", Layer::middle, "strain of the mid-surface, without bending"},
                                   {"bottom", Layer::bottom, "on the other side"}}),
                    "side of a shell; required there")
          .optional("fibre", &Gauge::fibre, tuple<2>(number("m", plausible::position())),
                    "place in a beam's section, local y and z from its centroid; default: the centroid")
          .optional("region", &Gauge::region, name(), "only elements of this region count; default: all"));
}

Schema<NodeMass> node_mass() {
  return mapping(Fields<NodeMass>()
                     .required("at", &NodeMass::at, name(), "name of one of `nodes`")
                     .required("mass", &NodeMass::mass, number("kg", Bounds::between(0, plausible::mass().high)),
                               "mass of the body; 0 for a place where a modification adds mass")
                     .optional("inertia", &NodeMass::inertia, tuple<3>(number("kg m^2", Bounds::nonnegative())),
                               "moments of inertia about its own centre, axes x, y, z")
                     .optional("offset", &NodeMass::offset, tuple<3>(number("m", plausible::position())),
                               "offset of its centre from the node"));
}

Schema<Link> link() {
  return mapping(
      Fields<Link>()
          .required("master", &Link::master, name(), "name of one of `nodes`")
          .required("nodes", &Link::nodes, located(text()), "group of nodes that follow this node as one rigid body")
          .optional("directions", &Link::directions, directions(), "directions that follow; default: all"));
}

Schema<Fixed> fixed() {
  return mapping(
      Fields<Fixed>()
          .required("nodes", &Fixed::nodes, located(text()), "group of the mesh, or name of one of `nodes`")
          .optional("directions", &Fixed::directions, directions(), "directions that are fixed; default: all"));
}

Schema<UnitSystem> units() {
  return mapping(
      Fields<UnitSystem>()
          .optional("length", &UnitSystem::length, number("m", Bounds::positive()), "unit of length, such as 1 mm")
          .optional("mass", &UnitSystem::mass, number("kg", Bounds::positive()), "unit of mass, such as 1 t")
          .optional("time", &UnitSystem::time, number("s", Bounds::positive()), "unit of time, such as 1 s"));
}

Schema<Turn> turn() {
  constexpr double full_turn = 2.0 * std::numbers::pi * (1.0 + 1e-12);
  return mapping(
      Fields<Turn>()
          .required("axis", &Turn::axis, tuple<3>(number("-")), "direction of the axis")
          .required("angle", &Turn::angle, number("rad", Bounds::between(-full_turn, full_turn)),
                    "by the right-hand rule: 90 deg, 0.5 rad")
          .optional("about", &Turn::about, tuple<3>(number("m", plausible::position())),
                    "a point of the axis; default: the origin")
          .check([](const Turn& given) -> std::vector<Issue> {
            if (given.axis != std::array<double, 3>{} && given.angle != 0.0) return {};
            return {{{}, "the turn has no axis or no angle", "it has no effect", "give both, or leave it out"}};
          }));
}

Schema<MatrixSet> matrix_set() {
  return mapping(
      Fields<MatrixSet>()
          .required(
              "files", &MatrixSet::files, one_or_list(located(path())),
              "Matrix Market (.mtx, .mtx.gz), CalculiX .sti and .mas, node-direction lists, DMIG, OP4, OP2, HDF5, "
              "netCDF or MATLAB")
          .optional("stiffness", &MatrixSet::stiffness, text(),
                    "name of the stiffness matrix in the files; default: K, KAA, Kr, ...")
          .optional("mass", &MatrixSet::mass, text(), "name of the mass matrix in the files; default: M, MAA, Mr, ...")
          .optional("damping", &MatrixSet::damping, text(), "likewise")
          .optional("dofs", &MatrixSet::dofs, located(path()),
                    "degrees of freedom of the rows, if the files do not state them: node.direction or \"node "
                    "direction\", one per line")
          .optional("directions", &MatrixSet::directions, integer(0, 6),
                    "directions per node, if `dofs` lists nodes only: 3 for x, y, z; 6 with rotations")
          .check([](const MatrixSet& set) {
            std::vector<Issue> issues;
            if (set.files.empty()) issues.push_back({{}, "no file is given", "stiffness and mass are required", ""});
            return issues;
          }));
}

}  // namespace

Schema<FiniteElements> finite_elements() {
  const auto mesh = Fields<MeshFile>()
                        .required("mesh", &MeshFile::file, located(path()), "Gmsh mesh (.msh, version 2.2 or 4.1)")
                        .optional("scale", &MeshFile::scale, number("-", Bounds::positive()),
                                  "factor from the mesh's coordinates to metres: 0.001 for millimetres");
  const auto tables =
      Fields<TableFiles>()
          .required("nodes", &TableFiles::nodes, located(path()), "table (CSV) with columns node, x, y, z")
          .required("elements", &TableFiles::elements, located(path()),
                    "table (CSV) with columns element, node1, node2, region; a region is a name or a number")
          .optional("scale", &TableFiles::scale, number("-", Bounds::positive()),
                    "factor from the coordinates to metres, if their titles state no unit (x_mm or x [mm])");
  const auto deck =
      Fields<DeckFile>()
          .required("deck", &DeckFile::file, located(path()),
                    "input file of Abaqus or CalculiX (.inp) or Nastran (.bdf, .dat, .nas)")
          .optional("format", &DeckFile::format,
                    choice<DeckFormat>({{"automatic", DeckFormat::automatic, "decided by the file's name"},
                                        {"abaqus", DeckFormat::abaqus, "Abaqus or CalculiX"},
                                        {"nastran", DeckFormat::nastran, "Nastran bulk data"}}),
                    "format of the deck")
          .optional("units", &DeckFile::units, units(), "consistent units of its numbers; default: SI")
          .optional("temperature", &DeckFile::temperature, number("-"),
                    "temperature at which materials that depend on it are taken, in the deck's unit of temperature; "
                    "default: the initial temperature in the deck")
          .optional("subcase", &DeckFile::subcase, integer(1, 99999999),
                    "SUBCASE of a Nastran deck whose supports, MPC, direct matrices, temperature and preload the model "
                    "has, and whose load case `deck_cases` reads; default: the first one with METHOD, or the first one")
          .optional("accept_missing", &DeckFile::accept_missing, one_or_list(name()),
                    "cards or keywords with stiffness, mass or connections that kalfem cannot read and that may be "
                    "left out of the model, such as CBEND");
  const auto matrices =
      Fields<MatrixFiles>()
          .required("matrices", &MatrixFiles::sets, one_or_list(matrix_set()),
                    "stiffness and mass matrices of another code; several sets are joined at equal degrees of freedom")
          .check([](const MatrixFiles& files) {
            std::vector<Issue> issues;
            if (files.sets.empty())
              issues.push_back({{}, "no matrices are given", "stiffness and mass are required", ""});
            return issues;
          })
          .optional("coordinates", &MatrixFiles::coordinates, located(path()),
                    "table (CSV) with node, x, y, z: for places, rigid links and the centre of gravity")
          .optional("units", &MatrixFiles::units, units(), "consistent units of their numbers; default: SI");
  return mapping(
      Fields<FiniteElements>()
          .one_of(&FiniteElements::source, when(mesh),
                  when("tables", mapping(tables), "tables of nodes and beam elements (stick model)"), when(deck),
                  when(matrices))
          .optional("rotate", &FiniteElements::rotate, turn(),
                    "turn of all that the file holds, with its local axes, supports, springs, loads and the beams of "
                    "`regions`, before anything else refers to it: one file at several places")
          .optional("translate", &FiniteElements::translate, tuple<3>(number("m", plausible::position())),
                    "displacement of all nodes, after the turn, before anything else refers to their places")
          .optional("materials", &FiniteElements::materials, named(material()),
                    "materials by name; for a deck: those to replace")
          .optional("regions", &FiniteElements::regions, named(region()),
                    "properties by physical group of the mesh or region of the tables; for a deck: those to replace")
          .optional("nodes", &FiniteElements::nodes, named(located(node_place())),
                    "named nodes, whose motion is substructure.name.x ... rz: a group or set of one node, a node "
                    "number, or coordinates [x, y, z] (the nearest node)")
          .optional("gauges", &FiniteElements::gauges, named(located(gauge())),
                    "strain gauges, whose strain is substructure.name: of sensors, and to be predicted")
          .optional("masses", &FiniteElements::masses, named(node_mass()), "rigid bodies (point masses) at nodes")
          .optional("links", &FiniteElements::links, named(link()), "rigid links (RBE2)")
          .optional("fixed", &FiniteElements::fixed, named(fixed()), "supports: nodes that do not move")
          .optional("factors", &FiniteElements::factors, named(located(part_factor())),
                    "dimensionless factors of parts, K = K_0 + sum a_i K_i, M and C likewise; each is the parameter "
                    "substructure.name.factor, to be updated or estimated")
          .optional("mass_matrix", &FiniteElements::mass_matrix,
                    choice<MassKind>({{"consistent", MassKind::consistent, "consistent mass matrix"},
                                      {"lumped", MassKind::lumped, "lumped (diagonal) mass matrix"}}),
                    "mass matrix of the elements; default: consistent, or as the deck says"));
}

const SourceLocation& FiniteElements::location() const {
  if (const auto* mesh = std::get_if<MeshFile>(&source)) return mesh->file.location;
  if (const auto* tables = std::get_if<TableFiles>(&source)) return tables->nodes.location;
  if (const auto* deck = std::get_if<DeckFile>(&source)) return deck->file.location;
  return std::get<MatrixFiles>(source).sets.front().files.front().location;
}

Schema<Reduction> reduction() {
  return mapping(
      Fields<Reduction>()
          .optional(
              "method", &Reduction::method,
              choice<ReductionMethod>(
                  {{"craig_bampton", ReductionMethod::craig_bampton, "constraint modes and fixed-interface modes"},
                   {"rubin", ReductionMethod::rubin,
                    "free-interface modes and residual flexibility, with residual mass"},
                   {"macneal", ReductionMethod::macneal, "free-interface modes and residual flexibility"},
                   {"guyan", ReductionMethod::guyan, "static condensation to the boundary"}}),
              "")
          .optional("modes", &Reduction::modes, integer(0, 100000), "keep at least this number of modes")
          .optional("up_to", &Reduction::up_to, number("Hz", plausible::frequency()), "keep modes up to this frequency")
          .optional("effective_mass", &Reduction::effective_mass, number("-", Bounds::between(0, 1)),
                    "keep modes until they carry this fraction of the mass that boundary motion accelerates")
          .optional("truncation_vectors", &Reduction::augmentation_vectors, boolean(),
                    "modal truncation augmentation vectors: static shapes under boundary acceleration that correct for "
                    "the modes left out, one per boundary degree of freedom")
          .optional("boundary", &Reduction::boundary, list(name()),
                    "boundary: nodes (their translations), node.direction, also on rigid and weighted links, or groups "
                    "of nodes (all their motions); default: the nodes that connectors and forces touch. Groups that "
                    "`joints` name always belong to it"));
}

}  // namespace kalfem::description
