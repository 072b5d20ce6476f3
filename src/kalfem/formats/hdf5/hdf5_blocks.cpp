// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>

#include "kalfem/formats/hdf5/hdf5_handle.hpp"

// A chunk is unpacked as a whole, however little of it is wanted. So a dataset is read block by block, each of whole
// chunks: every chunk is unpacked once, and what is held beside the wanted values is a block.

namespace kalfem {
namespace {

using Eigen::Index;

constexpr hsize_t block_values = 1 << 17;

/// Rows and columns of a block: those of a chunk, or of several side by side and then one below the other.
std::array<hsize_t, 2> block_lengths(hid_t dataset, int rank, const std::array<hsize_t, 2>& lengths) {
  const Hdf5Id creation(H5Dget_create_plist(dataset), H5Pclose);
  std::array<hsize_t, 2> block{1, 1};
  if (H5Pget_layout(creation) == H5D_CHUNKED && H5Pget_chunk(creation, rank, block.data()) != rank) block = {1, 1};
  for (std::size_t d = 0; d < 2; ++d) block[d] = std::clamp<hsize_t>(block[d], 1, std::max<hsize_t>(1, lengths[d]));
  for (const std::size_t d : {std::size_t{1}, std::size_t{0}}) {
    const hsize_t fitting = std::max<hsize_t>(1, block_values / (block[0] * block[1]));
    block[d] = std::min(lengths[d], block[d] * fitting);
  }
  return block;
}

}  // namespace

void Hdf5File::read_blocks(const std::string& dataset, const BlockVisitor& visit) const {
  const auto shape = this->shape(dataset);
  if (shape.empty() || shape.size() > 2)
    handle().fail("'" + dataset + "' has " + std::to_string(shape.size()) + " dimensions", "a table has one or two");
  const Hdf5Id id = handle().dataset(dataset);
  handle().require_numbers(Hdf5Id(H5Dget_type(id), H5Tclose), dataset);
  const int rank = static_cast<int>(shape.size());
  const std::array<hsize_t, 2> lengths{static_cast<hsize_t>(shape[0]),
                                       rank == 2 ? static_cast<hsize_t>(shape[1]) : hsize_t{1}};
  if (lengths[0] == 0 || lengths[1] == 0) return;
  const auto block = block_lengths(id, rank, lengths);
  const Hdf5Id in_file(H5Dget_space(id), H5Sclose);
  Eigen::MatrixXd values;
  std::array<hsize_t, 2> start{};
  for (start[0] = 0; start[0] < lengths[0]; start[0] += block[0])
    for (start[1] = 0; start[1] < lengths[1]; start[1] += block[1]) {
      const std::array<hsize_t, 2> extent{std::min(block[0], lengths[0] - start[0]),
                                          std::min(block[1], lengths[1] - start[1])};
      const Hdf5Id in_memory(H5Screate_simple(rank, extent.data(), nullptr), H5Sclose);
      H5Sselect_hyperslab(in_file, H5S_SELECT_SET, start.data(), nullptr, extent.data(), nullptr);
      values.resize(static_cast<Index>(extent[1]), static_cast<Index>(extent[0]));  // rows lie side by side in the file
      handle().require(H5Dread(id, H5T_NATIVE_DOUBLE, in_memory, in_file, H5P_DEFAULT, values.data()) >= 0,
                       "read '" + dataset + "'");
      visit(static_cast<Index>(start[0]), static_cast<Index>(start[1]), values);
    }
}

Eigen::MatrixXd Hdf5File::read_columns(const std::string& dataset, const std::vector<Index>& columns) const {
  const auto shape = this->shape(dataset);
  Eigen::MatrixXd values(std::ssize(columns), shape.empty() ? 0 : shape[0]);
  read_blocks(dataset, [&](Index row, Index column, const Eigen::MatrixXd& block) {
    for (Index j = 0; j < values.rows(); ++j) {
      const Index in_block = columns[static_cast<std::size_t>(j)] - column;
      if (in_block >= 0 && in_block < block.rows()) values.row(j).segment(row, block.cols()) = block.row(in_block);
    }
  });
  return values;
}

}  // namespace kalfem
