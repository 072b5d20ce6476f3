#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "kalfem/formats/gmsh.hpp"
#include "kalfem/linalg/lowest_modes.hpp"
#include "kalfem/model/assembly.hpp"

namespace kalfem {
namespace {

using Eigen::Index;

const std::map<std::string, double> thicknesses = {
    {"rails", 3e-3}, {"cross_members", 2e-3}, {"brackets", 5e-3}, {"upper", 1.5e-3}};
constexpr double guidance = 1e4;  ///< stiffness of the lateral springs [N/m]
constexpr double lift = 100.0;    ///< of soft vertical ones, so that nothing is free [N/m]

/// The vehicle's frame on springs at its four suspension points.
FiniteElementModel frame() {
  FiniteElementModel model;
  model.mesh = read_gmsh(std::string(KALFEM_SOURCE_DIR) + "/examples/vehicle/frame.msh");
  model.materials["steel"] = {2.1e11, 0.3, 7850.0};
  for (const auto& [region, thickness] : thicknesses) model.properties[region] = ShellProperty{"steel", thickness};
  for (const std::string point : {"p1", "p2", "p3", "p4"})
    for (int direction = 0; direction < 3; ++direction)
      model.springs.push_back({point + direction_names[static_cast<std::size_t>(direction)],
                               {model.mesh.node_sets.at(point).front(), direction},
                               {},
                               "ground",
                               direction < 2 ? guidance : lift,
                               0.0});
  return model;
}

/// The same as an input deck.
void write_deck(const FiniteElementModel& model, const std::filesystem::path& file) {
  std::ofstream deck(file);
  deck << "*NODE\n";
  deck.precision(12);
  for (Index i = 0; i < model.mesh.node_count(); ++i) {
    deck << i + 1;
    for (int a = 0; a < 3; ++a) deck << ", " << model.mesh.nodes(a, i);
    deck << "\n";
  }
  Index element = 0;
  for (const auto& [region, thickness] : thicknesses) {
    deck << "*ELEMENT, TYPE=S4, ELSET=" << region << "\n";
    for (const Index cell : model.mesh.regions.at(region)) {
      deck << ++element;
      for (const Index node : model.mesh.nodes_of(model.mesh.cells[static_cast<std::size_t>(cell)]))
        deck << ", " << node + 1;
      deck << "\n";
    }
  }
  deck << "*MATERIAL, NAME=steel\n*ELASTIC\n2.1e11, 0.3\n*DENSITY\n7850.\n";
  for (const auto& [region, thickness] : thicknesses)
    deck << "*SHELL SECTION, ELSET=" << region << ", MATERIAL=steel\n" << thickness << "\n";
  for (const auto& spring : model.springs)
    deck << "*ELEMENT, TYPE=SPRING1, ELSET=" << spring.name << "\n"
         << ++element << ", " << spring.from.node + 1 << "\n*SPRING, ELSET=" << spring.name << "\n"
         << spring.from.direction + 1 << ",\n"
         << std::scientific << spring.stiffness << std::defaultfloat << ",\n";
  deck << "*STEP\n*FREQUENCY\n18\n*END STEP\n";
}

/// Frequencies [Hz] of CalculiX's table of eigenvalues.
std::vector<double> frequencies_in(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::vector<double> frequencies;
  std::string line;
  while (std::getline(stream, line) && line.find("P A R T I C I P A T I O N") == std::string::npos) {
    std::istringstream words(line);
    int mode = 0;
    double value = 0.0, circular = 0.0, frequency = 0.0;
    if (words >> mode >> value >> circular >> frequency && mode == static_cast<int>(frequencies.size()) + 1)
      frequencies.push_back(frequency);
  }
  return frequencies;
}

TEST(CalculiX, VehicleFrameHasTheSameFirstTenElasticFrequencies) {
  if (std::system("command -v ccx >/dev/null 2>&1") != 0) GTEST_SKIP() << "CalculiX (ccx) is not installed";
  const auto model = frame();
  const auto assembled = assemble(model);
  const auto folder = std::filesystem::temp_directory_path() / ("kalfem-calculix-" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  write_deck(model, folder / "frame.inp");
  ASSERT_EQ(std::system(("cd " + folder.string() + " && ccx frame > frame.log 2>&1").c_str()), 0);
  const auto theirs = frequencies_in(folder / "frame.dat");
  std::filesystem::remove_all(folder);
  ASSERT_EQ(theirs.size(), 18u);
  const auto modes = lowest_modes(evaluate(assembled.stiffness, assembled.parameters),
                                  evaluate(assembled.mass, assembled.parameters), {.count = 16});
  // Six modes on the springs, then ten of the frame: two shell formulations on one mesh.
  for (Index i = 0; i < 16; ++i) {
    const double ours = std::sqrt(modes.values[i]) / (2.0 * std::numbers::pi);
    EXPECT_NEAR(ours, theirs[static_cast<std::size_t>(i)], 0.02 * ours) << i + 1;
  }
  EXPECT_GT(std::sqrt(modes.values[6]) / (2.0 * std::numbers::pi), 40.0);
}

}  // namespace
}  // namespace kalfem
