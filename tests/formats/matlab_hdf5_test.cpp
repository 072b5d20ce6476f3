// SPDX-License-Identifier: Apache-2.0
// MATLAB files of version 7.3 as programs other than MATLAB write them, through HDF5 alone.
#include <gtest/gtest.h>
#include <hdf5.h>

#include <array>
#include <fstream>
#include <vector>

#include "base/scratch_folder.hpp"
#include "kalfem/base/invalid_input.hpp"
#include "kalfem/formats/matlab/matlab_file.hpp"

namespace kalfem {
namespace {

using Numbers = std::vector<double>;

class MatlabHdf5Files : public testing::Test {
protected:
  MatlabHdf5Files() {
    const hid_t creation = H5Pcreate(H5P_FILE_CREATE);
    H5Pset_userblock(creation, 512);
    file_ = H5Fcreate(path_.c_str(), H5F_ACC_TRUNC, creation, H5P_DEFAULT);
    H5Pclose(creation);
  }

  /// The name of the class fills its text, with or without room for a zero.
  static void set_class(hid_t object, const std::string& name, H5T_str_t padding = H5T_STR_NULLPAD) {
    const hid_t type = H5Tcopy(H5T_C_S1), space = H5Screate(H5S_SCALAR);
    H5Tset_size(type, name.size());
    H5Tset_strpad(type, padding);
    const hid_t attribute = H5Acreate2(object, "MATLAB_class", type, space, H5P_DEFAULT, H5P_DEFAULT);
    H5Awrite(attribute, type, name.data());
    H5Aclose(attribute);
    H5Sclose(space);
    H5Tclose(type);
  }

  static void set_number(hid_t object, const char* name, int value) {
    const hid_t space = H5Screate(H5S_SCALAR);
    const hid_t attribute = H5Acreate2(object, name, H5T_NATIVE_INT, space, H5P_DEFAULT, H5P_DEFAULT);
    H5Awrite(attribute, H5T_NATIVE_INT, &value);
    H5Aclose(attribute);
    H5Sclose(space);
  }

  /// Rows x columns of MATLAB stand turned in the file.
  static hid_t write(hid_t where, const char* name, hid_t type, hsize_t rows, hsize_t columns, const void* values,
                     const std::string& kind) {
    const std::array<hsize_t, 2> lengths{columns, rows};
    const hid_t space = H5Screate_simple(2, lengths.data(), nullptr);
    const hid_t dataset = H5Dcreate2(where, name, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    H5Dwrite(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values);
    if (!kind.empty()) set_class(dataset, kind);
    H5Sclose(space);
    return dataset;
  }
  static void numbers(hid_t where, const char* name, hsize_t rows, hsize_t columns, const Numbers& values) {
    H5Dclose(write(where, name, H5T_NATIVE_DOUBLE, rows, columns, values.data(), "double"));
  }
  static void text(hid_t where, const char* name, const std::u16string& value) {
    H5Dclose(write(where, name, H5T_NATIVE_UINT16, 1, value.size(), value.data(), "char"));
  }

  MeasuredFile read() {
    H5Fclose(file_);
    std::fstream stream(path_, std::ios::in | std::ios::out | std::ios::binary);
    stream << "MATLAB 7.3 MAT-file, HDF5 schema 1.00";
    stream.close();
    return read_matlab_file(path_);
  }
  static Numbers values(const MeasuredChannel& channel) { return {channel.values.begin(), channel.values.end()}; }

  ScratchFolder folder_{"matlab_hdf5"};
  std::filesystem::path path_ = folder_ / "run.mat";
  hid_t file_ = -1;
};

TEST_F(MatlabHdf5Files, NamesOfClassesNeedNoZeroAtTheirEnd) {
  numbers(file_, "t", 3, 1, {0, 0.5, 1});
  numbers(file_, "acc", 3, 2, {1, 2, 3, 4, 5, 6});
  const std::array<std::int16_t, 3> counts{7, 8, 9};
  H5Dclose(write(file_, "n", H5T_NATIVE_INT16, 3, 1, counts.data(), "int16"));
  const auto file = read();
  ASSERT_EQ(file.channels.size(), 3u);
  EXPECT_EQ(file.channels[1].name, "acc_2");
  EXPECT_EQ(values(file.channels[1]), (Numbers{4, 5, 6}));
  EXPECT_EQ(values(file.channels[2]), (Numbers{7, 8, 9}));
  EXPECT_DOUBLE_EQ(file.channels[0].interval, 0.5);
  EXPECT_TRUE(file.skipped.empty());
}

TEST_F(MatlabHdf5Files, StructuresCellsAndReferencesAreFollowed) {
  const hid_t run = H5Gcreate2(file_, "run", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  set_class(run, "struct");
  numbers(run, "acc", 3, 1, {1, 2, 3});
  numbers(run, "fs", 1, 1, {50});
  text(run, "unit", u"m/s²");
  const hid_t group = H5Gcreate2(file_, "#refs#", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  numbers(group, "a", 2, 1, {4, 5});
  numbers(group, "b", 2, 1, {6, 7});
  std::array<hobj_ref_t, 2> references{};
  H5Rcreate(&references[0], file_, "/#refs#/a", H5R_OBJECT, -1);
  H5Rcreate(&references[1], file_, "/#refs#/b", H5R_OBJECT, -1);
  H5Dclose(write(file_, "cells", H5T_STD_REF_OBJ, 1, 2, references.data(), "cell"));
  const hid_t many = H5Gcreate2(file_, "many", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  set_class(many, "struct");
  H5Dclose(write(many, "data", H5T_STD_REF_OBJ, 1, 2, references.data(), ""));
  for (const hid_t each : {run, group, many}) H5Gclose(each);
  const auto file = read();
  std::vector<std::string> names;
  for (const auto& channel : file.channels) names.push_back(channel.name);
  EXPECT_EQ(names, (std::vector<std::string>{"cells{1}", "cells{2}", "many(1).data", "many(2).data", "run.acc"}));
  EXPECT_EQ(values(file.channels[3]), (Numbers{6, 7}));
  EXPECT_EQ(file.channels[4].unit, "m/s²");
  EXPECT_DOUBLE_EQ(file.channels[4].interval, 0.02);
}

TEST_F(MatlabHdf5Files, ObjectsAndMissingPartsAreNamed) {
  numbers(file_, "a", 3, 1, {1, 2, 3});
  const std::array<std::uint32_t, 6> reference{0xdd000000U, 2, 1, 1, 1, 1};
  const hid_t object = write(file_, "notes", H5T_NATIVE_UINT32, 1, 6, reference.data(), "string");
  set_number(object, "MATLAB_object_decode", 3);
  H5Dclose(object);
  const std::array<hsize_t, 2> lengths{1, 100}, chunk{1, 10};
  const hid_t space = H5Screate_simple(2, lengths.data(), nullptr), creation = H5Pcreate(H5P_DATASET_CREATE);
  H5Pset_chunk(creation, 2, chunk.data());
  const hid_t empty = H5Dcreate2(file_, "lost", H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, creation, H5P_DEFAULT);
  set_class(empty, "double");
  H5Dclose(empty);
  H5Pclose(creation);
  H5Sclose(space);
  const auto file = read();
  ASSERT_EQ(file.channels.size(), 1u);
  ASSERT_EQ(file.skipped.size(), 2u);
  EXPECT_NE(file.skipped[0].find("'lost' is damaged: a part of its values is not in the file"), std::string::npos);
  EXPECT_NE(file.skipped[1].find("'notes' is a MATLAB object of class string"), std::string::npos);
}

TEST_F(MatlabHdf5Files, ReferencesThatGoRoundEnd) {
  const hid_t dataset =
      H5Dcreate2(file_, "loop", H5T_STD_REF_OBJ, H5Screate(H5S_SCALAR), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  set_class(dataset, "cell");
  hobj_ref_t reference{};
  H5Rcreate(&reference, file_, "/loop", H5R_OBJECT, -1);
  H5Dwrite(dataset, H5T_STD_REF_OBJ, H5S_ALL, H5S_ALL, H5P_DEFAULT, &reference);
  H5Dclose(dataset);
  EXPECT_THROW(read(), InvalidInput);
}

}  // namespace
}  // namespace kalfem
