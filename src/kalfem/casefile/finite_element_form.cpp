#include "kalfem/casefile/description_form.hpp"
#include "kalfem/casefile/fields.hpp"

namespace kalfem::description {

using namespace form;

namespace {

Form<double> length() { return number("m", Bounds::positive()); }
Form<double> factor() { return number("-", Bounds::nonnegative()); }
Form<std::vector<std::string>> directions() { return list(word({"x", "y", "z", "rx", "ry", "rz"})); }

Form<Material> material() {
  return mapping(
      Fields<Material>()
          .required("youngs_modulus", &Material::youngs_modulus, number("Pa", Bounds::positive()), "E")
          .optional("poissons_ratio", &Material::poissons_ratio, number("-", Bounds::between(-0.99, 0.499)), "nu")
          .required("density", &Material::density, number("kg/m^3", Bounds::positive()), "rho"));
}

Form<SectionHolder> section() {
  const auto rectangle = Fields<RectangleSection>()
                             .required("width", &RectangleSection::width, length(), "along local y")
                             .required("height", &RectangleSection::height, length(), "along local z");
  const auto circle = Fields<CircleSection>().required("diameter", &CircleSection::diameter, length(), "outer");
  const auto tube = Fields<CircularTubeSection>()
                        .required("diameter", &CircularTubeSection::diameter, length(), "outer")
                        .required("wall", &CircularTubeSection::wall, length(), "thickness");
  const auto box = Fields<RectangularTubeSection>()
                       .required("width", &RectangularTubeSection::width, length(), "outer, along local y")
                       .required("height", &RectangularTubeSection::height, length(), "outer, along local z")
                       .required("wall", &RectangularTubeSection::wall, length(), "thickness");
  const auto general =
      Fields<GeneralSection>()
          .required("area", &GeneralSection::area, number("m^2", Bounds::positive()), "A")
          .required("inertia_y", &GeneralSection::inertia_y, number("m^4", Bounds::positive()), "bending in x-z")
          .required("inertia_z", &GeneralSection::inertia_z, number("m^4", Bounds::positive()), "bending in x-y")
          .required("torsion", &GeneralSection::torsion, number("m^4", Bounds::positive()), "St Venant constant J")
          .optional("shear_factor_y", &GeneralSection::shear_factor_y, factor(), "shear area / A; 0: shear rigid")
          .optional("shear_factor_z", &GeneralSection::shear_factor_z, factor(), "shear area / A; 0: shear rigid");
  return mapping(Fields<SectionHolder>().one_of(
      &SectionHolder::section, when("rectangle", mapping(rectangle), "solid rectangle"),
      when("circle", mapping(circle), "solid circle"), when("circular_tube", mapping(tube), "circular tube"),
      when("rectangular_tube", mapping(box), "thin-walled rectangular tube"),
      when("general", mapping(general), "any section by its constants")));
}

Form<Region> region() {
  const auto shell = Fields<ShellRegion>().required("thickness", &ShellRegion::thickness, length(), "of the shell");
  const auto beam =
      Fields<BeamRegion>()
          .required("section", &BeamRegion::section, section(), "cross-section")
          .optional("up", &BeamRegion::up, tuple<3>(number("-")),
                    "direction; local z lies in the plane of the axis and this")
          .optional("offset", &BeamRegion::offset, tuple<3>(number("m")), "centroid minus node, global axes");
  return mapping(Fields<Region>()
                     .required("material", &Region::material, name(), "one of `materials`")
                     .one_of(&Region::property, when("shell", mapping(shell), "triangles and quadrilaterals"),
                             when("beam", mapping(beam), "lines")));
}

/// A group or node number, or the coordinates of a place.
Form<NodePlace> node_place() {
  auto group = convert<NodePlace, std::string>(
      text(),
      [](const std::string& word) {
        return NodePlace{word, {}};
      },
      [](const NodePlace& place) { return place.group; });
  group.schema["x-written"] = "group | number";
  const auto place = convert<NodePlace, std::array<double, 3>>(
      tuple<3>(number("m")),
      [](const std::array<double, 3>& at) {
        return NodePlace{"", at};
      },
      [](const NodePlace& given) { return given.at; });
  auto both = either(group, place);
  both.write = [=](const NodePlace& given) { return given.group.empty() ? place.write(given) : group.write(given); };
  return both;
}

Form<NodeMass> node_mass() {
  return mapping(Fields<NodeMass>()
                     .required("at", &NodeMass::at, name(), "one of `nodes`")
                     .required("mass", &NodeMass::mass, number("kg", Bounds::positive()), "of the body")
                     .optional("inertia", &NodeMass::inertia, tuple<3>(number("kg m^2", Bounds::nonnegative())),
                               "about its own centre, axes x, y, z")
                     .optional("offset", &NodeMass::offset, tuple<3>(number("m")), "its centre minus the node"));
}

Form<Link> link() {
  return mapping(Fields<Link>()
                     .required("master", &Link::master, name(), "one of `nodes`")
                     .required("nodes", &Link::nodes, located(text()), "group of nodes that follow it as a rigid body")
                     .optional("directions", &Link::directions, directions(), "that follow; default: all"));
}

Form<Fixed> fixed() {
  return mapping(Fields<Fixed>()
                     .required("nodes", &Fixed::nodes, located(text()), "group of the mesh, or one of `nodes`")
                     .optional("directions", &Fixed::directions, directions(), "that are held; default: all"));
}

}  // namespace

Form<FiniteElements> finite_elements() {
  return mapping(
      Fields<FiniteElements>()
          .required("mesh", &FiniteElements::mesh, located(path()), "Gmsh mesh (.msh 2.2 or 4.1)")
          .optional("scale", &FiniteElements::scale, number("-", Bounds::positive()),
                    "of the mesh's coordinates to metres: 0.001 for millimetres")
          .required("materials", &FiniteElements::materials, named(material()), "by name")
          .required("regions", &FiniteElements::regions, named(region()), "properties by physical group of the mesh")
          .optional("nodes", &FiniteElements::nodes, named(located(node_place())),
                    "places with a name, whose motion is known as substructure.name.x ... rz: a physical group of one "
                    "node, a node number, or coordinates [x, y, z] (the nearest node)")
          .optional("masses", &FiniteElements::masses, named(node_mass()), "bodies at nodes")
          .optional("links", &FiniteElements::links, named(link()), "rigid links (RBE2)")
          .optional("fixed", &FiniteElements::fixed, named(fixed()), "nodes that do not move")
          .optional("mass_matrix", &FiniteElements::mass_matrix,
                    choice<MassKind>({{"consistent", MassKind::consistent, "as the stiffness is integrated"},
                                      {"lumped", MassKind::lumped, "diagonal by element"}}),
                    "kind of the elements' mass"));
}

Form<Reduction> reduction() {
  return mapping(
      Fields<Reduction>()
          .optional("method", &Reduction::method,
                    choice<ReductionMethod>(
                        {{"craig_bampton", ReductionMethod::craig_bampton, "boundary and fixed-interface modes"},
                         {"guyan", ReductionMethod::guyan, "boundary alone, static"}}),
                    "")
          .optional("modes", &Reduction::modes, integer(0, 100000), "fixed-interface modes, at least so many")
          .optional("up_to", &Reduction::up_to, number("Hz", Bounds::positive()), "fixed-interface modes up to here")
          .optional("effective_mass", &Reduction::effective_mass, number("-", Bounds::between(0, 1)),
                    "modes until they carry this part of the mass that boundary motion accelerates")
          .optional("truncation_vectors", &Reduction::truncation_vectors, boolean(),
                    "shapes under boundary acceleration that make up for the modes left out, one a boundary degree of "
                    "freedom")
          .optional("boundary", &Reduction::boundary, list(name()),
                    "nodes (their translations) or node.direction; default: the nodes that connectors, forces and "
                    "springs touch"));
}

}  // namespace kalfem::description
