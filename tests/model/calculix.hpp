#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
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

/// Whether CalculiX can be called.
inline bool has_calculix() { return std::system("command -v ccx >/dev/null 2>&1") == 0; }

/// Runs a deck of a folder, named without its end: whether CalculiX was content.
inline bool run_calculix(const std::filesystem::path& folder, const std::string& deck) {
  return std::system(("cd '" + folder.string() + "' && ccx " + deck + " > " + deck + ".log 2>&1").c_str()) == 0;
}

}  // namespace kalfem
