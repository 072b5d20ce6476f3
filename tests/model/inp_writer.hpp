#pragma once

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "kalfem/formats/gmsh.hpp"
#include "kalfem/model/finite_element_model.hpp"

// The vehicle's frame as a CalculiX input deck, and what CalculiX answers.

namespace kalfem {

inline const std::map<std::string, double> thicknesses = {
    {"rails", 3e-3}, {"cross_members", 2e-3}, {"brackets", 5e-3}, {"upper", 1.5e-3}};
inline constexpr double guidance = 1e4;  ///< stiffness of the lateral springs [N/m]
inline constexpr double lift = 100.0;    ///< of soft vertical ones, so that nothing is free [N/m]

/// The vehicle's frame on springs at its four suspension points.
inline FiniteElementModel frame(const std::string& mesh = "frame.msh") {
  FiniteElementModel model;
  model.mesh = read_gmsh(std::string(KALFEM_SOURCE_DIR) + "/examples/vehicle/" + mesh);
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

/// The same as an input deck; `solver` follows the keyword of the frequency step.
inline void write_deck(const FiniteElementModel& model, const std::filesystem::path& file, int modes = 18,
                       const std::string& solver = "") {
  std::ofstream deck(file);
  deck << "*NODE\n";
  deck.precision(12);
  for (Eigen::Index i = 0; i < model.mesh.node_count(); ++i) {
    deck << i + 1;
    for (int a = 0; a < 3; ++a) deck << ", " << model.mesh.nodes(a, i);
    deck << "\n";
  }
  Eigen::Index element = 0;
  for (const auto& [region, thickness] : thicknesses) {
    deck << "*ELEMENT, TYPE=S4, ELSET=" << region << "\n";
    for (const Eigen::Index cell : model.mesh.regions.at(region)) {
      deck << ++element;
      for (const Eigen::Index node : model.mesh.nodes_of(model.mesh.cells[static_cast<std::size_t>(cell)]))
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
  deck << "*STEP\n*FREQUENCY" << (solver.empty() ? "" : ", SOLVER=" + solver) << "\n" << modes << "\n*END STEP\n";
}

/// Frequencies [Hz] of CalculiX's table of eigenvalues.
inline std::vector<double> frequencies_in(const std::filesystem::path& file) {
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

/// Whether CalculiX can be called.
inline bool has_calculix() { return std::system("command -v ccx >/dev/null 2>&1") == 0; }

/// A folder of its own that is removed in the end.
class CalculixFolder {
public:
  explicit CalculixFolder(const std::string& name)
      : path(std::filesystem::temp_directory_path() / ("kalfem-" + name + "-" + std::to_string(getpid()))) {
    std::filesystem::create_directories(path);
  }
  CalculixFolder(const CalculixFolder&) = delete;
  CalculixFolder& operator=(const CalculixFolder&) = delete;
  ~CalculixFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path, ignored);
  }
  /// Runs a deck of this folder, named without its end.
  [[nodiscard]] bool run(const std::string& deck) const {
    return std::system(("cd " + path.string() + " && ccx " + deck + " > " + deck + ".log 2>&1").c_str()) == 0;
  }

  const std::filesystem::path path;
};

}  // namespace kalfem
