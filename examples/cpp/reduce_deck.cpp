// SPDX-License-Identifier: Apache-2.0
// Reads a deck, reduces it to two nodes by Craig and Bampton's method, and writes the superelement for other codes.
// Usage: reduce_deck frame.bdf superelement.h5
#include <cmath>
#include <filesystem>
#include <iostream>

#include "kalfem/formats/deck.hpp"
#include "kalfem/formats/matrices/write.hpp"
#include "kalfem/kalfem.hpp"

using namespace kalfem;

int main(int, char** argv) try {
  const Deck deck = read_deck(argv[1]);
  for (const auto& note : deck.notes) std::cout << note.what << ": " << note.consequence << '\n';

  FiniteElements frame("frame", deck.model);
  frame.node("corner", 5).node("middle", Eigen::Vector3d(1.0, 0.0, 1.0));
  frame.reduce({.modes = {.cutoff = 200.0}}, {"corner", "middle"});
  const Superelement reduced = reduce(frame);

  for (const auto& file : write_superelement(argv[2], reduced.model, MatrixFormat::hdf5, reduced.basis))
    std::cout << "wrote " << file << " with " << reduced.model.size() << " of " << reduced.basis.rows()
              << " degrees of freedom\n";

  // The reduced model has the full model's lowest frequencies.
  const auto full = natural_frequencies(frame, 5);
  const auto few = normal_modes(reduced.model.mass, reduced.model.stiffness).frequencies;
  for (Eigen::Index i = 0; i < full.size(); ++i) {
    std::cout << "mode " << i + 1 << ": " << full[i] << " Hz, reduced " << few[i] << " Hz\n";
    if (std::abs(few[i] - full[i]) > 1e-3 * full[i]) return 1;
  }
  return reduced.model.size() < reduced.basis.rows() / 3 && std::filesystem::file_size(argv[2]) > 0 ? 0 : 1;
} catch (const InvalidInput& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
