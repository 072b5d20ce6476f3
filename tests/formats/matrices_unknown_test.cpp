// SPDX-License-Identifier: Apache-2.0
// Every format of matrices with a record, variable or dataset that no reader knows: it is told or refused, by its name
// where it has one.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "base/scratch_folder.hpp"
#include "formats/matrices_files.hpp"
#include "kalfem/formats/hdf5/hdf5_file.hpp"

namespace kalfem {
namespace {

/// What is said about the file beside its matrices: all notes, or the refusal.
std::string said(const std::string& bytes, const std::string& source, const std::vector<std::string>& names = {}) {
  std::string text;
  try {
    const auto format = source.ends_with(".sti") ? MatrixFormat::triplets : MatrixFormat::automatic;
    for (const auto& matrix : parse_matrices(bytes, source, {.format = format, .names = names}))
      for (const auto& note : matrix.notes) text += note + "\n";
  } catch (const InvalidInput& error) {
    text = error.what();
  }
  return text;
}

/// A file without and with the unknown thing, and a part of what must be said of it.
struct Unknown {
  std::string plain, with_more, source, told;
};

std::string hdf5(const std::string& more) {
  auto file = Hdf5File::create_in_memory("m.h5");
  file.write_matrix("/K", common_matrix);
  file.write("/M/values", Eigen::Vector3d(1, 2, 3));
  file.write("/M/rows", Eigen::Vector3d(1, 2, 3));
  file.write("/M/cols", Eigen::Vector3d(1, 2, 3));
  if (more == "map")
    file.write_matrix("/dof_map", Eigen::MatrixXd{{1, 1}, {1, 2}});
  else if (!more.empty())
    file.write(more, Eigen::Vector3d(1, 2, 3));
  return file.bytes();
}

std::vector<Unknown> unknowns() {
  std::vector<Unknown> all = {
      {hdf5(""), hdf5("/extra"), "m.h5", "extra"},
      {hdf5(""), hdf5("/M/units"), "m.h5", "M/units"},
      {hdf5(""), hdf5("/other/deep/extra"), "m.h5", "other/deep/extra"},
      {hdf5(""), hdf5("map"), "m.h5", "dof_map"},
      {"1 1 4.\n2 2 3.\n", "1 1 4. 7.\n2 2 3.\n", "K.sti", "is not an entry"},
      {"1 1 4.\n2 2 3.\n", "extra\n1 1 4.\n2 2 3.\n", "K.sti", "K.sti:1: the line is not an entry"},
  };
  for (const bool big : {false, true}) {
    for (const char* told : {"'T'", "'E'", "element of type 9"})
      all.push_back({matlab(big), matlab(big, false, true), "m.mat", told});
    all.push_back({matlab(big), matlab(big) + std::string(64, '\0'), "m.mat", "bytes that are no element"});
  }
  for (const int version : {1, 2, 5}) all.push_back({netcdf(version), netcdf(version, true), "m.nc", "names"});
  for (const auto& kind : kinds) {
    all.push_back({op2(kind, true, false), op2(kind, true), "m.op2", "GEOM1"});
    all.push_back({op2(kind, true, false), op2(kind, true, false) + "more", "m.op2", "4 bytes behind the end"});
    for (const auto columns : {Columns::dense, Columns::short_strings, Columns::long_strings})
      all.push_back({op4(kind, columns), op4(kind, columns, 0, true), "m.op4", "bytes behind the numbers"});
  }
  const std::string text =
      "       2       2       6       2KAA     1P,3E16.9\n       1       1       2\n 4.000000000E+00-1.000000000E+00\n"
      "       2       2       1\n 3.000000000E+00\n       3       1       1\n 1.000000000E+00\n";
  all.push_back({text, with(text, "-1.000000000E+00\n", "-1.000000000E+00 7.000000000E+00\n"), "m.op4",
                 "'7.000000000E+00' stands behind the last number"});
  return all;
}

TEST(MatrixRecords, UnknownRecordsAreToldOrRefused) {
  for (const auto& [plain, with_more, source, told] : unknowns()) {
    EXPECT_EQ(said(plain, source), "") << source;
    EXPECT_NE(said(with_more, source).find(told), std::string::npos) << source << ": " << said(with_more, source);
  }
}

/// What is told stands at the first matrix of the file, and goes along if that is not wanted.
TEST(MatrixRecords, NotesStayWhereOneMatrixIsWanted) {
  EXPECT_NE(said(hdf5("/extra"), "m.h5", {"K"}).find("extra"), std::string::npos);
  EXPECT_NE(said(hdf5("/extra"), "m.h5", {"M"}).find("extra"), std::string::npos);
}

/// CalculiX writes the degrees of freedom of the rows beside the matrix: one line too few, and the list is of no use.
TEST(MatrixRecords, AListOfRowsThatFitsNoMatrixIsTold) {
  const ScratchFolder folder("matrix_rows");
  std::ofstream(folder / "m.sti") << "1 1 4.\n2 2 3.\n3 3 1.\n";
  for (const auto& [rows, fits] : {std::pair{"1.1\n1.2\n1.3\n", true}, {"1.1\n1.2\n", false}}) {
    std::ofstream(folder / "m.dof") << rows;
    const auto matrices = read_matrices(folder / "m.sti");
    EXPECT_EQ(matrices.at(0).dofs.empty(), !fits);
    ASSERT_EQ(matrices[0].notes.size(), fits ? 0u : 1u);
    if (!fits) {
      EXPECT_NE(matrices[0].notes[0].find("'m.dof' beside the file lists 2 degrees of freedom and is not used"),
                std::string::npos);
    }
  }
}

}  // namespace
}  // namespace kalfem
