// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <fstream>
#include <map>
#include <string>

#include "base/places.hpp"
#include "kalfem/formats/gmsh/gmsh.hpp"
#include "kalfem/model/finite_element_model.hpp"

// The vehicle's frame, and the same as a CalculiX input deck.

namespace kalfem {

inline const std::map<std::string, double> thicknesses = {
    {"rails", 3e-3}, {"cross_members", 2e-3}, {"brackets", 5e-3}, {"upper", 1.5e-3}};
inline constexpr double guidance = 1e4;  ///< stiffness of the lateral springs [N/m]
inline constexpr double lift = 100.0;    ///< of soft vertical ones, so that nothing is free [N/m]

/// The vehicle's frame on springs at its four suspension points.
inline FiniteElementModel frame(const std::string& mesh = "frame.msh") {
  FiniteElementModel model;
  model.mesh = read_gmsh(test::source_folder() + "/examples/vehicle/" + mesh);
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

}  // namespace kalfem
