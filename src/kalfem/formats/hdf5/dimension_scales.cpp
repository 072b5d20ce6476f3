// SPDX-License-Identifier: Apache-2.0
#include <cstdint>
#include <numeric>

#include "kalfem/formats/hdf5/hdf5_handle.hpp"

// Dimension scales (The HDF Group: HDF5 Dimension Scale Specification): a scale says so by its attribute CLASS, and a
// dataset refers to the scales of its dimensions by DIMENSION_LIST. The references back, REFERENCE_LIST, are left out:
// readers do not need them, and those of a time that thousands of series share would not fit into an attribute.

namespace kalfem {
namespace {

/// Scales are known by texts of fixed length.
Hdf5Id fixed_text_type(const std::string& text) {
  Hdf5Id type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type, text.size() + 1);
  return type;
}

}  // namespace

void Hdf5File::write_axis(const std::string& dataset, Eigen::Index count) {
  std::vector<std::int64_t> values(static_cast<std::size_t>(count));
  std::iota(values.begin(), values.end(), 0);
  const Hdf5Id id = handle().create_dataset(dataset, H5T_STD_I64LE, {values.size()});
  handle().require(values.empty() || H5Dwrite(id, H5T_NATIVE_INT64, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) >= 0,
                   "write '" + dataset + "'");
  make_axis(dataset);
}

void Hdf5File::make_axis(const std::string& dataset) {
  const std::string kind = "DIMENSION_SCALE", name = dataset.substr(dataset.rfind('/') + 1);
  handle().write_attribute(dataset, "CLASS", fixed_text_type(kind), kind.c_str());
  handle().write_attribute(dataset, "NAME", fixed_text_type(name), name.c_str());
}

void Hdf5File::set_axes(const std::string& dataset, const std::vector<std::string>& axes) {
  const Hdf5Id id = handle().dataset(dataset);
  if (axes.size() != shape(dataset).size())
    handle().fail(std::to_string(axes.size()) + " axes for '" + dataset + "'", "every dimension needs one");
  std::vector<hobj_ref_t> scales(axes.size());
  std::vector<hvl_t> lists(axes.size());
  bool done = true;
  for (std::size_t d = 0; d < axes.size(); ++d) {
    done = done && H5Rcreate(&scales[d], handle().dataset(axes[d]), ".", H5R_OBJECT, -1) >= 0;
    lists[d] = {1, &scales[d]};
  }
  const hsize_t count = lists.size();
  const Hdf5Id type(H5Tvlen_create(H5T_STD_REF_OBJ), H5Tclose), space(H5Screate_simple(1, &count, nullptr), H5Sclose);
  const Hdf5Id attribute(H5Acreate2(id, "DIMENSION_LIST", type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  handle().require(done && attribute.valid() && H5Awrite(attribute, type, lists.data()) >= 0,
                   "name the dimensions of '" + dataset + "'");
}

}  // namespace kalfem
