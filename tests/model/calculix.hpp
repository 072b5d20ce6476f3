// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

// CalculiX as an independent code: whether it is here, a deck that it solves, what it answers.

namespace kalfem {

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

/// Tables of displacements in a .dat file, one a step; each ends at the next title.
inline std::vector<std::map<std::int64_t, Eigen::Vector3d>> displacements_in(const std::filesystem::path& file) {
  std::vector<std::map<std::int64_t, Eigen::Vector3d>> tables;
  std::ifstream stream(file);
  bool is_table = false;
  for (std::string line; std::getline(stream, line);) {
    std::istringstream numbers(line);
    std::int64_t node = 0;
    Eigen::Vector3d moved;
    if (line.find("displacements") != std::string::npos) {
      tables.emplace_back();
      is_table = true;
    } else if (is_table && numbers >> node >> moved[0] >> moved[1] >> moved[2]) {
      tables.back()[node] = moved;
    } else if (line.find_first_not_of(" \r") != std::string::npos) {
      is_table = false;
    }
  }
  return tables;
}

/// Whether CalculiX can be called.
inline bool has_calculix() { return std::system("command -v ccx >/dev/null 2>&1") == 0; }

/// Runs a deck of a folder, named without its end: whether CalculiX was content.
inline bool run_calculix(const std::filesystem::path& folder, const std::string& deck) {
  return std::system(("cd '" + folder.string() + "' && ccx " + deck + " > " + deck + ".log 2>&1").c_str()) == 0;
}

}  // namespace kalfem
