// SPDX-License-Identifier: Apache-2.0
// Writes the stiffness and mass matrix of a deck in PETSc's binary form, for slepc_modes. Usage: petsc_matrices DECK
// STEM writes STEM.K and STEM.M.
#include <bit>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <vector>

#include "kalfem/formats/deck.hpp"
#include "kalfem/identification/finite_element_part.hpp"

namespace {

using namespace kalfem;

template <class Number>
void write_big_endian(std::ofstream& file, const std::vector<Number>& numbers) {
  using Bits = std::conditional_t<sizeof(Number) == 8, std::uint64_t, std::uint32_t>;
  std::vector<Bits> swapped;
  swapped.reserve(numbers.size());
  for (const Number number : numbers) {
    const auto bits = std::bit_cast<Bits>(number);
    if constexpr (sizeof(Bits) == 8)
      swapped.push_back(__builtin_bswap64(bits));
    else
      swapped.push_back(__builtin_bswap32(bits));
  }
  file.write(reinterpret_cast<const char*>(swapped.data()), std::streamsize(swapped.size() * sizeof(Bits)));
}

/// Rows of a symmetric matrix are its columns.
void write(const std::string& path, const SparseMatrix& matrix) {
  constexpr std::int32_t class_of_matrices = 1211216;
  const auto rows = std::int32_t(matrix.rows()), entries = std::int32_t(matrix.nonZeros());
  std::ofstream file(path, std::ios::binary);
  write_big_endian<std::int32_t>(file, {class_of_matrices, rows, rows, entries});
  std::vector<std::int32_t> lengths;
  for (Eigen::Index j = 0; j < matrix.cols(); ++j)
    lengths.push_back(matrix.outerIndexPtr()[j + 1] - matrix.outerIndexPtr()[j]);
  write_big_endian(file, lengths);
  write_big_endian(file, std::vector<std::int32_t>(matrix.innerIndexPtr(), matrix.innerIndexPtr() + entries));
  write_big_endian(file, std::vector<double>(matrix.valuePtr(), matrix.valuePtr() + entries));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: petsc_matrices DECK STEM\n");
    return 2;
  }
  FiniteElementPart part{.name = "deck", .elements = read_deck(argv[1]).model};
  assemble_part(part, {.at_present_values = true});
  write(std::string(argv[2]) + ".K", part.full.stiffness);
  write(std::string(argv[2]) + ".M", part.full.mass);
  std::printf("%ld degrees of freedom\n", long(part.full.size()));
  return 0;
}
