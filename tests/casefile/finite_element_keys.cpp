// SPDX-License-Identifier: Apache-2.0
#include <numbers>

#include "casefile/probes.hpp"
#include "kalfem/identification/parameterised_structure.hpp"
#include "kalfem/reduction/free_interface.hpp"

/// Keys of finite-element substructures and their reduction.
namespace kalfem::wiring {
namespace {

const std::string at = "substructures.*.finite_elements.";

/// A case whose substructure `b` is this; nothing attached unless `more` does so.
Study with_part(const std::string& text, const Sections& more = {}) {
  Sections sections{{"substructures", "{b: {" + text + "}}"}, {"excitation", ""}, {"sensors", ""}, {"simulate", ""}};
  for (const auto& [key, value] : more) sections[key] = value;
  return study_of(beam_case(sections));
}

Study with_elements(const std::string& text) { return with_part("finite_elements: {" + text + "}"); }
Study with_beam(const std::string& more) { return with_elements(beam_elements(more)); }

const FiniteElementPart& part_of(const Study& study) { return *study.structure->finite_elements.at(0).part; }
const FiniteElementModel& elements_of(const Study& study) { return part_of(study).elements; }

const double diameter = 0.02, area = std::numbers::pi * diameter * diameter / 4,
             inertia = std::numbers::pi * std::pow(diameter, 4) / 64;

// --- where the elements come from ------------------------------------------------------------------------------------

/// A square plate of one quadrilateral, 1 by 1 in the file's units, with a group of lines at an edge.
std::string plate_mesh(bool with_edge) {
  return std::string("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n1 2 \"edge\"\n2 1 \"plate\"\n") +
         "$EndPhysicalNames\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n$EndNodes\n$Elements\n" +
         (with_edge ? "2\n1 1 2 2 1 1 2\n" : "1\n") + "2 3 2 1 1 1 2 3 4\n$EndElements\n";
}

/// A unit cube of one hexahedron.
const std::string block_mesh =
    "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n3 3 \"block\"\n$EndPhysicalNames\n$Nodes\n8\n1 0 0 0\n2 "
    "1 0 "
    "0\n3 1 1 0\n4 0 1 0\n5 0 0 1\n6 1 0 1\n7 1 1 1\n8 0 1 1\n$EndNodes\n$Elements\n1\n3 5 2 3 1 1 2 3 4 5 6 7 "
    "8\n$EndElements\n";

Study with_mesh(const std::string& more, const std::string& source = "mesh: plate.msh",
                const std::string& regions = "plate: {material: steel, shell: {thickness: 10 mm}}") {
  write_file("plate.msh", plate_mesh(more.find("edge") != std::string::npos));
  write_file("block.msh", block_mesh);
  return with_elements(source + ", materials: {steel: {youngs_modulus: 210 GPa, density: 8000}}, regions: {" + regions +
                       "}" + (more.empty() ? "" : ", " + more));
}

void meshes() {
  near(part_of(with_mesh("")).mass.mass, 80.0, many_roundings);
  near(part_of(with_mesh("", "mesh: plate.msh, scale: 0.1")).mass.mass, 0.8, many_roundings);
  near(elements_of(with_mesh("", "mesh: plate.msh, scale: 0.1")).mesh.nodes(0, 1), 0.1);
}

void tables() {
  const auto beam = with_beam("");
  EXPECT_EQ(elements_of(beam).mesh.cells.size(), 2u);
  near(elements_of(beam).mesh.nodes(0, 2), 1.0);
  write_file("grid.csv", "node,x,y,z\n1,0,0,0\n2,500,0,0\n3,1000,0,0\n4,1500,0,0\n");
  write_file("sticks.csv", "element,node1,node2,region\n1,1,2,bar\n2,2,3,bar\n3,3,4,bar\n");
  auto text = beam_elements();
  text.replace(text.find("nodes.csv"), 9, "grid.csv");
  text.replace(text.find("elements.csv"), 12, "sticks.csv, scale: 0.001");
  const auto scaled = with_elements(text);
  EXPECT_EQ(elements_of(scaled).mesh.cells.size(), 3u);
  near(elements_of(scaled).mesh.nodes(0, 3), 1.5);
}

/// A bar of two nodes along x in millimetres, tonnes and seconds.
const std::string abaqus_text = R"(*NODE, NSET=ALL
1, 0., 0., 0.
2, 500., 0., 0.
*ELEMENT, TYPE=B31, ELSET=BAR
1, 1, 2
*MATERIAL, NAME=STEEL
*ELASTIC
210000., 0.3
*DENSITY
7.85e-9
*BEAM SECTION, ELSET=BAR, MATERIAL=STEEL, SECTION=CIRC
10.
0., 1., 0.
*BOUNDARY
1, 1, 6
)";

void decks() {
  write_file("bar.inp", abaqus_text);
  write_file("bar.txt", abaqus_text);
  const auto check = [](const std::string& source) {
    const auto study = with_elements(source + ", units: {length: 1 mm, mass: 1 t, time: 1 s}, nodes: {tip: 2}");
    near(elements_of(study).mesh.nodes(0, 1), 0.5);
    near(elements_of(study).materials.begin()->second.youngs_modulus, 210e9);
    near(elements_of(study).materials.begin()->second.density, 7850.0);
  };
  check("deck: bar.inp");
  check("deck: bar.inp, format: automatic");
  check("deck: bar.txt, format: abaqus");
  EXPECT_THROW(with_elements("deck: bar.inp, format: nastran"), InvalidInput);
  // Other units of time and mass: the modulus has mass / (length time^2).
  const auto study = with_elements("deck: bar.inp, units: {length: 1 m, mass: 2 kg, time: 10 ms}");
  near(elements_of(study).materials.begin()->second.youngs_modulus, 210000.0 * 2 / 1e-4);
  near(elements_of(study).materials.begin()->second.density, 7.85e-9 * 2);
  near(elements_of(study).mesh.nodes(0, 1), 500.0);
  near(elements_of(with_elements("deck: bar.inp")).mesh.nodes(0, 1), 500.0);
}

/// Young's modulus of a deck by its temperature, between rows and beyond them.
void temperatures_of_decks() {
  auto text = abaqus_text;
  const std::string row = "210000., 0.3\n";
  text.replace(text.find(row), row.size(), "210000., 0.3, 20.\n190000., 0.3, 220.\n");
  write_file("hot.inp", text);
  const auto modulus = [](const std::string& more) {
    return elements_of(with_elements("deck: hot.inp" + more)).materials.begin()->second.youngs_modulus;
  };
  near(modulus(", temperature: 120"), 200000.0, many_roundings);
  near(modulus(", temperature: 500"), 190000.0);
  near(modulus(""), 210000.0);  // at 0, as the deck states none
  write_file("bar.inp", abaqus_text);
  const auto idle = with_elements("deck: bar.inp, temperature: 120");
  EXPECT_TRUE(std::ranges::any_of(idle.warnings, [](const auto& warning) {
    return warning.find("no material of the deck depends on it") != std::string::npos;
  }));
}

/// The subcase whose supports the model has; steps of Abaqus are none.
void subcases_of_decks() {
  write_file("subcases.bdf",
             "SOL 103\nCEND\nMETHOD = 1\nSUBCASE 1\nSPC = 1\nSUBCASE 2\nSPC = 2\nBEGIN BULK\nGRID,1,,0.,0.,0.\n"
             "GRID,2,,1.,0.,0.\nCBAR,1,1,1,2,0.,1.,0.\nPBAR,1,1,1.,1.,1.,1.\nMAT1,1,1.,,.3,1.\nSPC1,1,123456,1\n"
             "SPC1,2,123456,2\nENDDATA\n");
  for (const int number : {1, 2}) {
    const auto text = std::to_string(number);
    EXPECT_EQ(elements_of(with_elements("deck: subcases.bdf, subcase: " + text)).fixed.front().name, "spc" + text);
  }
  EXPECT_THROW(with_elements("deck: subcases.bdf"), InvalidInput);
  write_file("bar.inp", abaqus_text);
  EXPECT_THROW(with_elements("deck: bar.inp, subcase: 1"), InvalidInput);
}

/// The same file at another place.
void translated_nodes() {
  const auto here = with_mesh(""), there = with_mesh("translate: [1 m, -2 m, 50 cm]");
  for (const int node : {0, 3})
    near(Eigen::VectorXd(elements_of(there).mesh.nodes.col(node) - elements_of(here).mesh.nodes.col(node)),
         vector({1.0, -2.0, 0.5}));
  EXPECT_EQ(part_of(with_mesh("translate: [1, 0, 0], nodes: {m: [2, 1, 0]}")).nodes.at(0).node, 2);
}

/// A quarter turn of the plate about a line through [1, 0, 0] along z: its first corner comes to [1, -1, 0]. A beam's
/// orientation turns with its file.
void rotated_nodes() {
  const auto corner = [](const std::string& turn, const std::string& more = "") {
    return Eigen::VectorXd(elements_of(with_mesh("rotate: {" + turn + "}" + more)).mesh.nodes.col(0));
  };
  near(corner("axis: [0, 0, 2], angle: 90 deg, about: [1 m, 0 m, 5 m]"), vector({1.0, -1.0, 0.0}));
  near(corner("axis: [0, 0, 2], angle: 90 deg, about: [1 m, 0 m, 5 m]", ", translate: [0, 0, 3]"),
       vector({1.0, -1.0, 3.0}));
  near(corner("axis: [0, 1, 0], angle: 0.5, about: [1, 0, 0]"), vector({1.0 - std::cos(0.5), 0.0, std::sin(0.5)}),
       many_roundings);
  near(Eigen::VectorXd(elements_of(with_mesh("rotate: {axis: [0, 0, 1], angle: -180 deg}")).mesh.nodes.col(2)),
       vector({-1.0, -1.0, 0.0}));
  const auto beam = with_beam("rotate: {axis: [1, 0, 0], angle: 90 deg}");
  near(Eigen::VectorXd(std::get<BeamProperty>(elements_of(beam).properties.at("bar")).placements[0].up),
       vector({0.0, -1.0, 0.0}));
  EXPECT_THROW(with_mesh("rotate: {axis: [0, 0, 0], angle: 90 deg}"), InvalidInput);
  EXPECT_THROW(with_mesh("rotate: {axis: [0, 0, 1], angle: 0}"), InvalidInput);
  EXPECT_THROW(with_mesh("rotate: {axis: [0, 0, 1], angle: 90}"), InvalidInput);  // radians
}

/// What a deck lacks is refused but for what the case accepts, which is noted and left out.
void missing_parts_of_decks() {
  write_file("bar.inp", abaqus_text);
  write_file("lacking.inp", abaqus_text + "*CONTACT PAIR, INTERACTION=DRY\nTOP, BOTTOM\n*NOVELTY\n");
  const auto with = [](const std::string& accepted) { return with_elements("deck: lacking.inp" + accepted); };
  EXPECT_THROW(with(""), InvalidInput);
  EXPECT_THROW(with(", accept_missing: NOVELTY"), InvalidInput);
  EXPECT_THROW(with(", accept_missing: [NOVELTY, CONTACT PAIR, GAP]"), InvalidInput);  // the deck has no gap
  const auto study = with(", accept_missing: [NOVELTY, CONTACT PAIR]"), whole = with_elements("deck: bar.inp");
  std::vector<std::string> doubtful;
  for (const auto& note : study.element_notes.at(0).notes) {
    EXPECT_NE(note.kind, DeckNoteKind::missing) << note.what;
    if (note.kind == DeckNoteKind::doubtful) doubtful.push_back(note.what);
  }
  EXPECT_EQ(doubtful, (std::vector<std::string>{"*CONTACT PAIR", "*NOVELTY"}));
  EXPECT_EQ(relative_difference(part_of(study).full.stiffness, part_of(whole).full.stiffness), 0.0);
}

/// Two degrees of freedom, 1.z and 2.rx, from Matrix Market files.
void matrices() {
  const auto symmetric = [](const std::string& entries) {
    return "%%MatrixMarket matrix coordinate real symmetric\n2 2 3\n" + entries;
  };
  write_file("stiff.mtx", symmetric("1 1 40\n2 1 -10\n2 2 30\n"));
  write_file("heavy.mtx", symmetric("1 1 2\n2 1 0\n2 2 3\n"));
  write_file("lossy.mtx", symmetric("1 1 5\n2 1 -1\n2 2 4\n"));
  write_file("rows.txt", "1.z\n2.rx\n");
  write_file("places.csv", "node,x,y,z\n1,100,0,0\n2,200,50,0\n");
  const std::string files = "files: [stiff.mtx, heavy.mtx, lossy.mtx], stiffness: stiff, mass: heavy, damping: lossy",
                    rows = ", dofs: rows.txt";
  const auto nodal = [](const Study& study, std::size_t set = 0) { return elements_of(study).matrices.at(set); };
  const auto plain = nodal(with_elements("matrices: {" + files + rows + "}"));
  near(plain.stiffness.coeff(0, 1), -10.0);
  near(plain.mass.coeff(1, 1), 3.0);
  near(plain.damping.coeff(0, 0), 5.0);
  EXPECT_EQ(plain.dofs[0].direction, 2);
  EXPECT_EQ(plain.dofs[1].direction, 3);
  // Other names are other matrices.
  near(nodal(
           with_elements("matrices: {files: [stiff.mtx, heavy.mtx, lossy.mtx], stiffness: lossy, mass: heavy, damping: "
                         "stiff" +
                         rows + "}"))
           .stiffness.coeff(0, 0),
       5.0);
  // Several sets, joined at equal degrees of freedom.
  const auto two = with_elements("matrices: [{" + files + rows +
                                 "}, {files: [stiff.mtx, heavy.mtx], stiffness: stiff, mass: "
                                 "heavy" +
                                 rows + "}]");
  near(part_of(two).full.stiffness.coeff(0, 0), 80.0);
  // Nodes alone with a number of directions each.
  write_file("three.mtx", "%%MatrixMarket matrix coordinate real symmetric\n3 3 3\n1 1 1\n2 2 2\n3 3 3\n");
  write_file("nodes.txt", "7\n");
  const auto listed =
      nodal(with_elements("matrices: {files: [three.mtx], stiffness: three, mass: three, dofs: nodes.txt, "
                          "directions: 3}"));
  EXPECT_EQ(listed.dofs.size(), 3u);
  EXPECT_EQ(listed.dofs[2].direction, 2);
  // Places in the units of the matrices.
  const auto placed = with_elements("matrices: {" + files + rows +
                                    "}, coordinates: places.csv, units: {length: 1 mm, mass: 1 "
                                    "t, time: 1 s}");
  near(Eigen::VectorXd(elements_of(placed).mesh.nodes.col(1)), vector({0.2, 0.05, 0.0}));
  near(nodal(placed).stiffness.coeff(0, 0), 40e3);         // t / s^2
  near(nodal(placed).stiffness.coeff(1, 1), 30e3 * 1e-6);  // a rotation: times mm^2
  near(nodal(placed).mass.coeff(0, 0), 2e3);
  const auto slow =
      nodal(with_elements("matrices: {" + files + rows + "}, units: {length: 1 m, mass: 3 kg, time: 2 s}"));
  near(slow.stiffness.coeff(0, 0), 40.0 * 3 / 4);
  near(slow.damping.coeff(0, 0), 5.0 * 3 / 2);
  near(slow.mass.coeff(0, 0), 2.0 * 3);
}

/// A factor of the same two degrees of freedom, and of elements.
void factors() {
  matrices();  // writes the files
  const std::string whole = "matrices: {files: [stiff.mtx, heavy.mtx], stiffness: stiff, mass: heavy, dofs: rows.txt}";
  const auto with_factor = [&](const std::string& factor) {
    return with_elements(whole + ", factors: {a: {" + factor + "}}");
  };
  const auto full = [](const Study& study) { return part_of(study).full; };
  near(full(with_factor("matrices: {stiffness: lossy.mtx}")).stiffness.coeff(0, 1), -11.0);
  near(full(with_factor("matrices: {stiffness: lossy.mtx}, value: 3")).stiffness.coeff(0, 1), -13.0);
  near(full(with_factor("matrices: {mass: lossy.mtx}, value: 2")).mass.coeff(0, 0), 12.0);
  near(full(with_factor("matrices: {damping: lossy.mtx}, value: 2")).damping.coeff(0, 0), 10.0);
  near(full(with_factor("matrices: {stiffness: {file: lossy.mtx, name: lossy}}")).stiffness.coeff(1, 1), 34.0);
  for (const std::string kind : {"stiffness", "mass", "damping"})
    EXPECT_THROW(with_factor("matrices: {" + kind + ": {file: lossy.mtx, name: other}}"), InvalidInput);
  write_file("turned.txt", "2.rx\n1.z\n");
  near(full(with_factor("matrices: {stiffness: lossy.mtx, dofs: turned.txt}")).stiffness.coeff(0, 0), 44.0);
  write_file("two_nodes.txt", "1\n");
  EXPECT_THROW(with_factor("matrices: {stiffness: lossy.mtx, dofs: two_nodes.txt, directions: 3}"), InvalidInput);

  const auto of_elements = [&](const std::string& factor) { return full(with_mesh("factors: {a: {" + factor + "}}")); };
  const auto plain = full(with_mesh(""));
  const auto ratio = [](const SparseMatrix& one, const SparseMatrix& other) { return one.norm() / other.norm(); };
  near(ratio(of_elements("elements: plate, value: 2").stiffness, plain.stiffness), 2.0, many_roundings);
  near(ratio(of_elements("elements: steel, value: 2").mass, plain.mass), 1.0, many_roundings);
  near(ratio(of_elements("elements: [plate], of: mass, value: 2").mass, plain.mass), 2.0, many_roundings);
  near(ratio(of_elements("elements: [plate], of: mass, value: 2").stiffness, plain.stiffness), 1.0, many_roundings);
  near(ratio(of_elements("elements: [1-9], of: both, value: 3").mass, plain.mass), 3.0, many_roundings);
}

// --- materials, regions, sections ------------------------------------------------------------------------------------

void materials() {
  const auto study = with_mesh("", "mesh: plate.msh", "plate: {material: steel, shell: {thickness: 10 mm}}");
  near(elements_of(study).materials.at("steel").youngs_modulus, 210e9);
  near(elements_of(study).materials.at("steel").poissons_ratio, 0.3);
  near(elements_of(study).materials.at("steel").density, 8000.0);
  auto text = beam_elements();
  text.replace(text.find("youngs_modulus: 210 GPa"), 23, "youngs_modulus: 70 GPa, poissons_ratio: 0.2");
  near(elements_of(with_elements(text)).materials.at("steel").youngs_modulus, 70e9);
  near(elements_of(with_elements(text)).materials.at("steel").poissons_ratio, 0.2);
  // Static deflection of the cantilever's tip, f L^3 / (3 E I).
  const auto beam = part_of(with_beam("")).full;
  const auto z = std::ranges::find(beam.dofs, "n3.z") - beam.dofs.begin();
  const Eigen::VectorXd bent = Eigen::MatrixXd(beam.stiffness).ldlt().solve(Eigen::VectorXd::Unit(beam.size(), z));
  near(bent[z], 1.0 / (3 * 210e9 * inertia), 3e-4);  // shear takes 0.022 %
}

void shell_regions() {
  const auto property = [](const std::string& text) {
    return std::get<ShellProperty>(
        elements_of(with_mesh("", "mesh: plate.msh", "plate: {material: steel, shell: " + text + "}"))
            .properties.at("plate"));
  };
  near(property("{thickness: 7 mm}").thickness, 7e-3);
  EXPECT_EQ(property("{thickness: 7 mm}").offset, 0.0);
  near(property("{thickness: 7 mm, offset: -2 mm}").offset, -2e-3);
  EXPECT_EQ(property("{thickness: 7 mm}").material, "steel");
}

void solid_regions() {
  const auto kind = [](const std::string& text) {
    return std::get<SolidProperty>(
               elements_of(with_mesh("", "mesh: block.msh", "block: {material: steel, solid: {" + text + "}}"))
                   .properties.at("block"))
        .kind;
  };
  EXPECT_EQ(kind(""), SolidKind::standard);
  EXPECT_EQ(kind("integration: standard"), SolidKind::standard);
  EXPECT_EQ(kind("integration: full"), SolidKind::full);
  EXPECT_EQ(kind("integration: mean_dilatation"), SolidKind::mean_dilatation);
  EXPECT_EQ(kind("integration: reduced"), SolidKind::reduced);
}

BeamProperty beam_property(const std::string& section, const std::string& more = "") {
  return std::get<BeamProperty>(elements_of(with_elements(beam_elements("", section, more))).properties.at("bar"));
}

void beam_sections() {
  const auto same = [](const std::string& text, const BeamSection& expected) {
    const auto found = beam_property(text).section;
    near(vector(
             {found.area, found.inertia_y, found.inertia_z, found.torsion, found.shear_factor_y, found.shear_factor_z}),
         vector({expected.area, expected.inertia_y, expected.inertia_z, expected.torsion, expected.shear_factor_y,
                 expected.shear_factor_z}));
    near(found.inertia_y, expected.inertia_y);  // small beside the area and the shear factors
    near(found.inertia_z, expected.inertia_z);
    near(found.torsion, expected.torsion);
  };
  same("rectangle: {width: 20 mm, height: 30 mm}", rectangular_section(0.02, 0.03));
  near(beam_property("rectangle: {width: 20 mm, height: 30 mm}").section.inertia_y, 0.02 * std::pow(0.03, 3) / 12);
  same("circle: {diameter: 20 mm}", circular_section(0.02));
  near(beam_property("circle: {diameter: 20 mm}").section.area, area);
  same("circular_tube: {diameter: 20 mm, wall: 3 mm}", circular_tube_section(0.02, 0.003));
  same("rectangular_tube: {width: 20 mm, height: 30 mm, wall: 2 mm}", rectangular_tube_section(0.02, 0.03, 0.002));
  same(
      "general: {area: 3e-4 m^2, inertia_y: 2e-8 m^4, inertia_z: 1e-8 m^4, torsion: 5e-9 m^4, shear_factor_y: 0.8, "
      "shear_factor_z: 0.7}",
      {3e-4, 2e-8, 1e-8, 5e-9, 0.8, 0.7});
  same("general: {area: 3e-4, inertia_y: 2e-8, inertia_z: 1e-8, torsion: 5e-9}", {3e-4, 2e-8, 1e-8, 5e-9, 0.0, 0.0});
}

void beam_placements() {
  const auto usual = beam_property("circle: {diameter: 20 mm}").placements.at(0);
  near(Eigen::VectorXd(usual.up), vector({0, 0, 1}));
  EXPECT_EQ(usual.offsets.norm(), 0.0);
  const auto placed =
      beam_property("circle: {diameter: 20 mm}", ", up: [0, 1, 0.5], offset: [0, 10 mm, 20 mm]").placements.at(0);
  near(Eigen::VectorXd(placed.up), vector({0, 1, 0.5}));
  for (const int end : {0, 1}) near(Eigen::VectorXd(placed.offsets.col(end)), vector({0, 0.01, 0.02}));
}

// --- nodes, bodies, links, supports ----------------------------------------------------------------------------------

void named_nodes() {
  const auto study = with_mesh("nodes: {number: 3, place: [0.9, 0.1, 0]}");
  const auto& nodes = part_of(study).nodes;
  EXPECT_EQ(elements_of(study).mesh.node_ids[std::size_t(nodes.at(0).node)], 3);
  EXPECT_EQ(nodes.at(0).name, "number");
  EXPECT_EQ(elements_of(study).mesh.node_ids[std::size_t(nodes.at(1).node)], 2);
  near(study.model->motion("b.place.y").dofs.sum(), 1.0);
}

/// Weighted sums of motions of named nodes, as forces and sensors see them.
void weighted_points() {
  const auto study = with_part("finite_elements: {" + beam_elements() + "}, points: {p: {tip.z: 2, mid.z: -0.5}}");
  const auto dofs = study.model->motion("b.p").dofs;
  near(dofs.dot(study.model->motion("b.tip.z").dofs), 2.0);
  near(dofs.dot(study.model->motion("b.mid.z").dofs), -0.5);
  near(dofs.squaredNorm(), 4.25);
}

/// Coefficients of the strain at the gauge `g` of the cantilever, over a motion of its tip.
double strain_per_tip(const std::string& gauge, const std::string& motion) {
  const auto study = with_beam("gauges: {g: {" + gauge + "}}");
  return study.model->strain("b.g").dot(study.model->motion("b.tip." + motion).dofs);
}

/// Each beam is 0.5 m long: the curvature at its middle is the difference of the rotations over the length.
void gauges() {
  near(strain_per_tip("element: 2", "x"), 2.0, many_roundings);
  near(strain_per_tip("at: [0.8, 0, 0]", "x"), 2.0, many_roundings);
  EXPECT_EQ(strain_per_tip("element: 1", "x"), 0.0);
  near(strain_per_tip("at: 3", "x"), 2.0, many_roundings);
  near(strain_per_tip("at: [0.5, 0, 0], region: bar, direction: [2, 0, 0]", "x"), 0.0);
  near(strain_per_tip("element: 2, fibre: [0, 4 mm]", "ry"), 2.0 * 4e-3, many_roundings);
  near(strain_per_tip("element: 2, fibre: [4 mm, 0]", "rz"), -2.0 * 4e-3, many_roundings);
}

/// A square plate that is held at one edge and bends about it.
void gauges_on_shells() {
  const auto study = with_mesh(
      "gauges: {top: {at: [0.5, 0.5, 0], direction: [1, 0, 0], surface: top}, "
      "middle: {at: [0.5, 0.5, 0], direction: [1, 0, 0], surface: middle}, "
      "bottom: {at: [0.5, 0.5, 0], direction: [1, 0, 0], surface: bottom}}, nodes: {a: 2, b: 3}");
  const auto bent = [&](const std::string& gauge) {
    const Eigen::VectorXd turn = study.model->motion("b.a.ry").dofs + study.model->motion("b.b.ry").dofs;
    return study.model->strain("b." + gauge).dot(turn);
  };
  near(bent("top"), 5e-3, many_roundings);  // u = z theta_y: half the thickness over the length of 1 m
  near(bent("bottom"), -5e-3, many_roundings);
  EXPECT_NEAR(bent("middle"), 0.0, 1e-15);
}

void placed_bodies() {
  const auto study = with_beam(
      "masses: {motor: {at: tip, mass: 3 kg, inertia: [0.1, 0.2, 0.3], offset: [0, 40 mm, 50 mm]}, "
      "other: {at: mid, mass: 500 g}}");
  const auto& bodies = elements_of(study).masses;
  ASSERT_EQ(bodies.size(), 2u);
  EXPECT_EQ(bodies[0].node, 2);
  EXPECT_EQ(bodies[1].node, 1);
  near(bodies[0].mass, 3.0);
  near(Eigen::VectorXd(bodies[0].inertia.diagonal()), vector({0.1, 0.2, 0.3}));
  near(Eigen::VectorXd(bodies[0].offset), vector({0, 0.04, 0.05}));
  near(bodies[1].mass, 0.5);
  EXPECT_EQ(bodies[1].offset.norm(), 0.0);
  // What it adds to the mass matrix at the tip: m, m times the arm, and the inertia with its parallel-axis part.
  const auto plain = part_of(with_beam("")).full, loaded = part_of(study).full;
  const auto added = [&](const std::string& a, const std::string& b) {
    const auto i = std::ranges::find(plain.dofs, "n3." + a) - plain.dofs.begin(),
               j = std::ranges::find(plain.dofs, "n3." + b) - plain.dofs.begin();
    return loaded.mass.coeff(i, j) - plain.mass.coeff(i, j);
  };
  near(added("x", "x"), 3.0, many_roundings);
  near(added("x", "ry"), 3 * 0.05, many_roundings);
  near(added("x", "rz"), -3 * 0.04, many_roundings);
  near(added("rx", "rx"), 0.1 + 3 * (0.04 * 0.04 + 0.05 * 0.05), many_roundings);
  near(added("ry", "rz"), -3 * 0.04 * 0.05, many_roundings);
}

void rigid_links() {
  const auto link = [](const std::string& more) {
    return elements_of(with_mesh("nodes: {m: 4}, links: {rbe: {master: m, nodes: edge" + more + "}}")).links.at(0);
  };
  EXPECT_EQ(link("").master, 3);
  EXPECT_EQ(link("").slaves, (std::vector<Eigen::Index>{0, 1}));
  EXPECT_EQ(link("").tied, (std::array<bool, 6>{true, true, true, true, true, true}));
  EXPECT_EQ(link(", directions: [x, rz]").tied, (std::array<bool, 6>{true, false, false, false, false, true}));
}

void supports() {
  const auto fixed = [](const std::string& more) {
    return elements_of(with_mesh("nodes: {m: 4}, fixed: {clamp: {nodes: " + more + "}}")).fixed.at(0);
  };
  EXPECT_EQ(fixed("edge").nodes, (std::vector<Eigen::Index>{0, 1}));
  EXPECT_EQ(fixed("m").nodes, (std::vector<Eigen::Index>{3}));
  EXPECT_EQ(fixed("edge").directions, (std::array<bool, 6>{true, true, true, true, true, true}));
  EXPECT_EQ(fixed("edge, directions: [y, ry]").directions,
            (std::array<bool, 6>{false, true, false, false, true, false}));
}

void mass_matrices() {
  EXPECT_EQ(elements_of(with_beam("")).mass_kind, MassKind::consistent);
  EXPECT_EQ(elements_of(with_beam("mass_matrix: consistent")).mass_kind, MassKind::consistent);
  const auto lumped = with_beam("mass_matrix: lumped");
  EXPECT_EQ(elements_of(lumped).mass_kind, MassKind::lumped);
  const Eigen::MatrixXd mass = part_of(lumped).full.mass;
  // a lumped mass has exact zeros beside its diagonal
  EXPECT_LT((mass - Eigen::MatrixXd(mass.diagonal().asDiagonal())).norm(), 1e-12);
}

/// Springs and grounds of finite elements, and damping: keys that lumped substructures have too.
void springs_and_grounds() {
  const auto study = with_part("finite_elements: {" + beam_elements() +
                                   "}, grounds: [wall], springs: [{name: k, from: wall, to: "
                                   "tip.z, stiffness: 5 N/mm, damping: 7}, {from: mid.y, to: tip.y, stiffness: 11}]",
                               {{"excitation", "{w: {base_displacement: b.wall, constant: 1}}"}});
  const auto plain = part_of(with_beam("")).full;
  const auto index = [&](const std::string& name) { return std::ranges::find(plain.dofs, name) - plain.dofs.begin(); };
  const auto& full = part_of(study).full;
  const auto change = [&](const std::string& a, const std::string& b) {
    return full.stiffness.coeff(index(a), index(b)) - plain.stiffness.coeff(index(a), index(b));
  };
  near(change("n3.z", "n3.z"), 5000.0, 1e-9);  // small differences of large stiffnesses
  near(change("n2.y", "n3.y"), -11.0, 1e-7);
  near(full.damping.coeff(index("n3.z"), index("n3.z")), 7.0);
  near(system_of(study).inputs[0].value.lpNorm<1>(), 5000.0);
  near(system_of(study).inputs[0].rate.lpNorm<1>(), 7.0);
}

/// C of the whole, modal damping included.
Eigen::MatrixXd whole_damping(const LinearModel& model) {
  const auto identity = Eigen::MatrixXd::Identity(model.size(), model.size());
  return Eigen::MatrixXd(model.damping) + damping_force(model.modal_damping, model.mass, identity);
}

/// At the first guesses of an updating the damping is that of the case, also of the modes above the limit.
void damping_at_parameters() {
  const auto study = with_part(
      "finite_elements: {" + beam_elements() + "}, damping: {modal: [1 %, 2 %], modal_up_to: 50 Hz}",
      {{"update", "{parameters: {b.steel.youngs_modulus: {}}, compare: {f: {modes: b, frequencies: [14]}}}"}});
  const auto refined = study.updating_plan->structure->at(initial_values(study.updating->parameters));
  const Eigen::MatrixXd given = whole_damping(part_of(study).full);
  EXPECT_LT((whole_damping(*refined.parts.finite_elements[0].model) - given).norm(),
            1e-13 * given.norm());  // rounding of the modes
}

void damping_of_elements() {
  const auto damped = [](const std::string& text) {
    return part_of(with_part("finite_elements: {" + beam_elements() + "}, damping: {" + text + "}")).full;
  };
  const auto plain = part_of(with_beam("")).full;
  EXPECT_LT((Eigen::MatrixXd(damped("mass_factor: 3").damping) - 3 * Eigen::MatrixXd(plain.mass)).norm(),
            // one multiplication
            1e-15 * plain.mass.norm());
  EXPECT_LT(
      (Eigen::MatrixXd(damped("stiffness_factor: 1e-4").damping) - 1e-4 * Eigen::MatrixXd(plain.stiffness)).norm(),
      1e-15 * 1e-4 * plain.stiffness.norm());
  // Modes up to the frequency have their own ratio; two pairs of bending modes, at 14 and 89 Hz.
  const auto modes = [&](const std::string& text) { return damped("modal: [1 %, 2 %]" + text).modal_damping; };
  EXPECT_EQ(modes(", modal_up_to: 50 Hz").rates.size(), 2);
  EXPECT_EQ(modes(", modal_up_to: 200 Hz").rates.size(), 4);
  EXPECT_EQ(modes("").rates.size(), modes(", modal_up_to: 500 Hz").rates.size());
  const auto model = damped("modal: [1 %, 2 %], modal_up_to: 200 Hz");
  const auto& [kept, rates] = model.modal_damping;
  const Eigen::MatrixXd full = whole_damping(model);
  const Eigen::VectorXd found = (kept.shapes.transpose() * full * kept.shapes).diagonal();
  for (int i = 0; i < 4; ++i)
    near(found[i], 2 * (i == 0 ? 0.01 : 0.02) * 2 * std::numbers::pi * kept.frequencies[i], many_roundings);
  damping_at_parameters();
}

// --- reduction -------------------------------------------------------------------------------------------------------

std::shared_ptr<const Superelement> reduced(const std::string& text, const std::string& more = "") {
  return with_part(
             "finite_elements: {" + beam_elements() + "}" + (text.empty() ? "" : ", reduction: {" + text + "}") + more,
             {{"excitation", "{f: {force: b.tip.z, constant: 1 N}}"}})
      .structure->finite_elements.at(0)
      .reduced;
}

void reduction_methods() {
  const auto lowest = [](const std::string& text) {
    const auto model = reduced(text)->model;
    return normal_modes(model.mass, model.stiffness).frequencies;
  };
  const auto exact = normal_modes(part_of(with_beam("")).full.mass, part_of(with_beam("")).full.stiffness).frequencies;
  const auto part = with_part("finite_elements: {" + beam_elements() + "}");
  const std::vector<std::string> boundary{"n3.x", "n3.y", "n3.z"};
  const auto same = [&](const std::string& text, const Superelement& expected) {
    const auto found = reduced("modes: 4, truncation_vectors: false" + text);
    // the same reduction
    EXPECT_LT(relative_difference(found->model.stiffness, expected.model.stiffness), 1e-14) << text;
    EXPECT_LT(relative_difference(found->model.mass, expected.model.mass), 1e-14) << text;
  };
  const ReductionOptions four{.modes = {.count = 4}};
  const auto& full = part_of(part).full;
  same("", craig_bampton(full, boundary, four));
  same(", method: craig_bampton", craig_bampton(full, boundary, four));
  same(", method: guyan", guyan(full, boundary, four));
  same(", method: rubin", free_interface(full, boundary, {.kind = FreeInterfaceKind::rubin, .modes = {.count = 4}}));
  same(", method: macneal",
       free_interface(full, boundary, {.kind = FreeInterfaceKind::macneal, .modes = {.count = 4}}));
  EXPECT_GE(lowest("modes: 4")[0], exact[0] * (1 - 1e-9));
}

void reduction_sizes() {
  const auto size = [](const std::string& text, const std::string& more = "") {
    return reduced(text, more)->model.size();
  };
  EXPECT_EQ(size("modes: 2, truncation_vectors: false"), 5);
  EXPECT_EQ(size("modes: 4, truncation_vectors: false"), 7);
  EXPECT_GT(size("modes: 2"), 5);
  EXPECT_EQ(size("modes: 2"), size("modes: 2, truncation_vectors: true"));
  const auto highest = [](const std::string& text) { return reduced(text)->error_indicators.highest_kept; };
  // what was asked for
  EXPECT_LE(highest("up_to: 100 Hz"), 100.0);
  EXPECT_GT(reduced("up_to: 100 Hz")->error_indicators.next_left_out, 100.0);
  EXPECT_GT(highest("up_to: 2 kHz"), 100.0);
  // Of vertical motion alone: the lowest mode of bending carries most of it.
  const std::string vertical = ", boundary: [tip.z], truncation_vectors: false";
  EXPECT_LT(size("effective_mass: 30 %" + vertical), size("effective_mass: 99.99 %" + vertical));
  // Where the case does not say: three times the default bandwidth of 100 Hz, or that of its sensors.
  near(highest(""), highest("up_to: 300 Hz"));
  const auto with_sensor = [](const std::string& chain, const std::string& simulate) {
    const auto study = with_part("finite_elements: {" + beam_elements() + "}",
                                 {{"excitation", "{f: {force: b.tip.z, constant: 1 N}}"},
                                  {"sensors", "{y: {acceleration: b.tip.z, noise: 1" + chain + "}}"},
                                  {"simulate", simulate}});
    return study.structure->finite_elements.at(0).reduced->error_indicators.highest_kept;
  };
  const std::string filter = ", chain: [{butterworth: {low_pass: 400 Hz}}]";
  near(with_sensor(filter, ""), highest("up_to: 1200 Hz"));
  near(with_sensor("", "{duration: 1, sample_rate: 500}"), highest("up_to: 750 Hz"));
  near(with_sensor(filter, "{duration: 1, sample_rate: 10000}"), highest("up_to: 1200 Hz"));
  EXPECT_NE(highest("up_to: 1200 Hz"), highest("up_to: 750 Hz"));
  EXPECT_NE(highest("up_to: 750 Hz"), highest("up_to: 300 Hz"));
}

void reduction_boundaries() {
  const auto boundary = [](const std::string& text) {
    std::vector<std::string> names;
    const auto superelement = reduced(text);
    const auto full = part_of(with_beam("")).full;
    for (const auto index : superelement->boundary) names.push_back(full.dofs[std::size_t(index)]);
    return names;
  };
  using Names = std::vector<std::string>;
  EXPECT_EQ(boundary("modes: 1"), (Names{"n3.x", "n3.y", "n3.z"}));
  EXPECT_EQ(boundary("modes: 1, boundary: [mid]"), (Names{"n2.x", "n2.y", "n2.z"}));
  EXPECT_EQ(boundary("modes: 1, boundary: [tip.z, mid.ry]"), (Names{"n3.z", "n2.ry"}));
}

}  // namespace

KeyChecks finite_element_keys() {
  KeyChecks keys;
  const auto add = [&](const std::string& prefix, const std::vector<std::string>& names, void (*check)()) {
    for (const auto& name : names) keys[prefix + name] = check;
  };
  add(at, {"mesh"}, meshes);
  add(at, {"scale"}, meshes);
  add(at + "tables.", {"nodes", "elements", "scale"}, tables);
  add(at, {"deck", "format"}, decks);
  add(at, {"temperature"}, temperatures_of_decks);
  add(at, {"subcase"}, subcases_of_decks);
  add(at, {"translate"}, translated_nodes);
  add(at + "rotate.", {"axis", "angle", "about"}, rotated_nodes);
  add(at, {"accept_missing"}, missing_parts_of_decks);
  add(at + "units.", {"length", "mass", "time"}, [] {
    decks();
    matrices();
  });
  for (const std::string set : {"matrices.", "matrices[]."})
    add(at + set, {"files", "stiffness", "mass", "damping", "dofs", "directions"}, matrices);
  add(at, {"coordinates"}, matrices);
  add(at + "factors.*.", {"value", "elements", "of"}, factors);
  for (const std::string matrix : {"stiffness", "mass", "damping"})
    add(at + "factors.*.matrices.", {matrix + ".file", matrix + ".name"}, factors);
  add(at + "factors.*.matrices.", {"dofs", "directions"}, factors);
  add(at + "materials.*.", {"youngs_modulus", "poissons_ratio", "density"}, materials);
  add(at + "regions.*.", {"material", "shell.thickness", "shell.offset"}, shell_regions);
  add(at + "regions.*.", {"solid.integration"}, solid_regions);
  add(at + "regions.*.beam.section.",
      {"rectangle.width", "rectangle.height", "circle.diameter", "circular_tube.diameter", "circular_tube.wall",
       "rectangular_tube.width", "rectangular_tube.height", "rectangular_tube.wall", "general.area",
       "general.inertia_y", "general.inertia_z", "general.torsion", "general.shear_factor_y", "general.shear_factor_z"},
      beam_sections);
  add(at + "regions.*.beam.", {"up", "offset"}, beam_placements);
  add(at, {"nodes"}, named_nodes);
  add(at + "gauges.*.", {"at", "element", "direction", "fibre", "region"}, gauges);
  add(at + "gauges.*.", {"surface"}, gauges_on_shells);
  add(at + "masses.*.", {"at", "mass", "inertia", "offset"}, placed_bodies);
  add(at + "links.*.", {"master", "nodes", "directions"}, rigid_links);
  add(at + "fixed.*.", {"nodes", "directions"}, supports);
  add(at, {"mass_matrix"}, mass_matrices);
  add("substructures.*.damping.", {"modal_up_to"}, [] {
    damping_of_elements();
    springs_and_grounds();
    weighted_points();
  });
  add("substructures.*.reduction.", {"method"}, reduction_methods);
  add("substructures.*.reduction.", {"modes", "up_to", "effective_mass", "truncation_vectors"}, reduction_sizes);
  add("substructures.*.reduction.", {"boundary"}, reduction_boundaries);
  return keys;
}

}  // namespace kalfem::wiring
