// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/matlab/matlab_file.hpp"

#include <gtest/gtest.h>
#include <matio.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>

#include "base/scratch_folder.hpp"
#include "kalfem/base/invalid_input.hpp"
#include "tdms_file.hpp"

namespace kalfem {
namespace {

using test::raw;
using Numbers = std::vector<double>;

matvar_t* numbers(const char* name, std::size_t rows, std::size_t columns, const Numbers& values) {
  std::size_t lengths[] = {rows, columns};
  return Mat_VarCreate(name, MAT_C_DOUBLE, MAT_T_DOUBLE, 2, lengths, const_cast<double*>(values.data()), 0);
}

matvar_t* column(const char* name, const Numbers& values) { return numbers(name, values.size(), 1, values); }
matvar_t* scalar(const char* name, double value) { return numbers(name, 1, 1, {value}); }

matvar_t* text(const char* name, const std::string& value) {
  std::size_t lengths[] = {1, value.size()};
  return Mat_VarCreate(name, MAT_C_CHAR, MAT_T_UINT8, 2, lengths, const_cast<char*>(value.data()), 0);
}

matvar_t* structure(const char* name, std::size_t elements, const std::vector<matvar_t*>& fields) {
  std::vector<const char*> names;
  for (const auto* field : fields)
    if (std::ranges::find(names, std::string(field->name), [](const char* n) { return std::string(n); }) == names.end())
      names.push_back(field->name);
  std::size_t lengths[] = {elements, 1};
  matvar_t* whole = Mat_VarCreateStruct(name, 2, lengths, names.data(), static_cast<unsigned>(names.size()));
  for (std::size_t i = 0; i < fields.size(); ++i)
    Mat_VarSetStructFieldByName(whole, fields[i]->name, i / names.size(), fields[i]);
  return whole;
}

/// Files of version 7.3 list their variables by name.
const MeasuredChannel& named(const MeasuredFile& file, const std::string& name) {
  return *std::ranges::find(file.channels, name, &MeasuredChannel::name);
}

Numbers values(const MeasuredChannel& channel) { return {channel.values.begin(), channel.values.end()}; }

class MatlabFiles : public testing::TestWithParam<mat_ft> {
protected:
  std::filesystem::path write(const std::vector<matvar_t*>& variables) const {
    const auto path = folder_ / "run.mat";
    std::filesystem::remove(path);
    mat_t* file = Mat_CreateVer(path.c_str(), nullptr, GetParam());
    for (auto* each : variables) {
      Mat_VarWrite(file, each, MAT_COMPRESSION_ZLIB);
      Mat_VarFree(each);
    }
    Mat_Close(file);
    return path;
  }
  MeasuredFile read(const std::vector<matvar_t*>& variables) const { return read_matlab_file(write(variables)); }

  ScratchFolder folder_{"matlab"};
};

INSTANTIATE_TEST_SUITE_P(Versions, MatlabFiles, testing::Values(MAT_FT_MAT5, MAT_FT_MAT73));

TEST_P(MatlabFiles, VectorsShareTheTimeOfTheirLength) {
  const auto file = read({column("time", {1.0, 1.5, 2.0}), column("acc", {1, 2, 3}), numbers("force", 1, 3, {4, 5, 6}),
                          column("other", {1, 2})});
  ASSERT_EQ(file.channels.size(), 3u);
  EXPECT_EQ(file.channels[0].name, "acc");
  EXPECT_DOUBLE_EQ(file.channels[0].start, 1.0);
  EXPECT_DOUBLE_EQ(file.channels[1].interval, 0.5);
  EXPECT_EQ(values(file.channels[1]), (Numbers{4, 5, 6}));
  EXPECT_EQ(file.channels[2].interval, 0.0);
}

TEST_P(MatlabFiles, UnevenTimesAreKept) {
  const auto file = read({column("t", {0, 1, 3}), column("a", {1, 2, 3})});
  EXPECT_EQ(file.channels[0].times, Eigen::Vector3d(0, 1, 3));
}

TEST_P(MatlabFiles, MatricesAreColumnsOrRows) {
  const auto tall = read({scalar("fs", 200.0), numbers("y", 3, 2, {1, 2, 3, 4, 5, 6})});
  ASSERT_EQ(tall.channels.size(), 2u);
  EXPECT_EQ(tall.channels[1].name, "y_2");
  EXPECT_EQ(values(tall.channels[1]), (Numbers{4, 5, 6}));
  EXPECT_DOUBLE_EQ(tall.channels[1].interval, 0.005);
  const auto wide = read({scalar("dt", 0.1), numbers("y", 2, 3, {1, 4, 2, 5, 3, 6})});
  ASSERT_EQ(wide.channels.size(), 2u);
  EXPECT_EQ(values(wide.channels[1]), (Numbers{4, 5, 6}));
  EXPECT_DOUBLE_EQ(wide.channels[1].interval, 0.1);
}

TEST_P(MatlabFiles, AnEvenFirstColumnIsTimeWhereThereIsNoOther) {
  const auto file = read({numbers("run", 3, 2, {0, 0.1, 0.2, 7, 9, 8})});
  ASSERT_EQ(file.channels.size(), 1u);
  EXPECT_EQ(values(file.channels[0]), (Numbers{7, 9, 8}));
  EXPECT_DOUBLE_EQ(file.channels[0].interval, 0.1);
  EXPECT_EQ(file.notes.size(), 1u);
}

TEST_P(MatlabFiles, StructuresNameTheirSeriesAndHaveTheirOwnTimes) {
  const auto file =
      read({scalar("fs", 10.0),
            structure("run", 2,
                      {scalar("fs", 50.0), column("data", {1, 2}), text("unit", "g"), text("name", "top"),
                       scalar("fs", 25.0), column("data", {3, 4}), text("unit", "N"), text("name", "force (kN)")}),
            column("plain", {5, 6})});
  ASSERT_EQ(file.channels.size(), 3u);
  EXPECT_EQ(named(file, "top").unit, "g");
  EXPECT_EQ(named(file, "top").description, "run(1).data");
  EXPECT_DOUBLE_EQ(named(file, "top").interval, 0.02);
  EXPECT_EQ(named(file, "force").unit, "N");
  EXPECT_DOUBLE_EQ(named(file, "force").interval, 0.04);
  EXPECT_DOUBLE_EQ(named(file, "plain").interval, 0.1);
}

TEST_P(MatlabFiles, AxesMayStandInAStructureBeside) {
  const auto file = read({structure("Signal", 1,
                                    {structure("x_values", 1, {scalar("start_value", 2.0), scalar("increment", 0.5)}),
                                     structure("y_values", 1, {column("values", {1, 2, 3})})})});
  ASSERT_EQ(file.channels.size(), 1u);
  EXPECT_EQ(file.channels[0].name, "Signal.y_values.values");
  EXPECT_DOUBLE_EQ(file.channels[0].start, 2.0);
  EXPECT_DOUBLE_EQ(file.channels[0].interval, 0.5);
}

TEST_P(MatlabFiles, WholeNumbersAndComplexFunctions) {
  std::int16_t counts[] = {-5, 300};
  std::size_t lengths[] = {2, 1};
  Numbers re{1, 2}, im{3, 4};
  mat_complex_split_t parts{re.data(), im.data()};
  const auto file =
      read({Mat_VarCreate("counts", MAT_C_INT16, MAT_T_INT16, 2, lengths, counts, 0), column("f", {10, 20}),
            Mat_VarCreate("H", MAT_C_DOUBLE, MAT_T_DOUBLE, 2, lengths, &parts, MAT_F_COMPLEX)});
  ASSERT_EQ(file.channels.size(), 1u);
  EXPECT_EQ(values(file.channels[0]), (Numbers{-5, 300}));
  ASSERT_EQ(file.functions.size(), 1u);
  EXPECT_EQ(file.functions[0].lines, Eigen::Vector2d(10, 20));
  EXPECT_EQ(file.functions[0].values[1], std::complex<double>(2, 4));
}

matvar_t* complex_array(const char* name, std::vector<std::size_t> lengths, const Numbers& real) {
  Numbers re = real, im(real.size());
  for (std::size_t i = 0; i < re.size(); ++i) im[i] = -re[i];
  mat_complex_split_t parts{re.data(), im.data()};
  return Mat_VarCreate(name, MAT_C_DOUBLE, MAT_T_DOUBLE, static_cast<int>(lengths.size()), lengths.data(), &parts,
                       MAT_F_COMPLEX);
}

Numbers counted(std::size_t count, double step = 1.0) {
  Numbers values(count);
  for (std::size_t i = 0; i < count; ++i) values[i] = step * double(i);
  return values;
}

// Of frequencies nobody uses the same name; a step in place of the vector is as good.
TEST_P(MatlabFiles, FrequenciesStandBesideComplexArraysUnderManyNames) {
  const Numbers lines = counted(5, 2.5);
  for (const char* name : {"f", "freqs", "Frequency_Hz", "fvec", "frequenz", "xdata", "abscissa_of_it"}) {
    const auto file = read({complex_array("H", {5, 1}, counted(5)), column(name, lines), column("a", {3, 1, 2})});
    ASSERT_EQ(file.functions.size(), 1u) << name;
    EXPECT_EQ(Numbers(file.functions[0].lines.begin(), file.functions[0].lines.end()), lines) << name;
    EXPECT_EQ(file.functions[0].values[2], std::complex<double>(2, -2)) << name;
    ASSERT_EQ(file.channels.size(), 1u) << name << ": frequencies are no channel";
    EXPECT_EQ(file.channels[0].name, "a");
  }
  const auto angular = read({complex_array("H", {1, 5}, counted(5)), column("omega", lines)});
  ASSERT_EQ(angular.functions.size(), 1u);
  EXPECT_NEAR(angular.functions[0].lines[4], 10.0 / (2.0 * 3.14159265358979), 1e-12);
  EXPECT_EQ(angular.notes.size(), 1u);
  const auto stepped = read({complex_array("H", {5, 1}, counted(5)), scalar("df", 2.5)});
  ASSERT_EQ(stepped.functions.size(), 1u);
  EXPECT_EQ(stepped.functions[0].lines[4], 10.0);
  const auto axis = read({structure("FRF", 1,
                                    {structure("x_values", 1, {scalar("start_value", 5.0), scalar("increment", 0.5)}),
                                     structure("y_values", 1, {complex_array("values", {5, 1}, counted(5))})})});
  ASSERT_EQ(axis.functions.size(), 1u);
  EXPECT_EQ(axis.functions[0].lines[4], 7.0);
}

// Response x reference x line, as objects of the Control System Toolbox have it, and line first.
TEST_P(MatlabFiles, ComplexArraysMayHaveMoreDimensions) {
  const auto last = read({complex_array("H", {2, 3, 5}, counted(30)), column("f", counted(5))});
  ASSERT_EQ(last.functions.size(), 6u);
  EXPECT_EQ(last.functions[3].name, "H_2_2");
  EXPECT_EQ(last.functions[3].values[4].real(), 1 + 2 * 1 + 6 * 4);
  const auto first = read({complex_array("H", {5, 2, 3}, counted(30)), column("f", counted(5))});
  ASSERT_EQ(first.functions.size(), 6u);
  EXPECT_EQ(first.functions[3].name, "H_2_2");
  EXPECT_EQ(first.functions[3].values[4].real(), 4 + 5 * 1 + 10 * 1);
  const auto single = read({complex_array("H", {1, 1, 5}, counted(5)), column("f", counted(5))});
  ASSERT_EQ(single.functions.size(), 1u);
  EXPECT_EQ(single.functions[0].name, "H");
  const auto without = read({complex_array("H", {2, 3, 5}, counted(30)), column("a", {1, 2})});
  ASSERT_EQ(without.skipped.size(), 1u);
  EXPECT_EQ(without.skipped[0], "'H' is complex (2 x 3 x 5), without a vector of frequencies of one of its lengths");
}

matvar_t* cells(const char* name, const std::vector<matvar_t*>& elements) {
  std::size_t lengths[] = {1, elements.size()};
  return Mat_VarCreate(name, MAT_C_CELL, MAT_T_CELL, 2, lengths, const_cast<matvar_t**>(elements.data()), 0);
}

TEST_P(MatlabFiles, OneUnitIsNotThatOfSeveralSeries) {
  const Numbers t = {0, 1, 2}, a = {5, 3, 4}, f = {1, 7, 2};
  const auto units_of = [&](std::vector<matvar_t*> more) {
    more.insert(more.begin(), {column("t", t), column("acc", a), column("force", f)});
    const auto file = read({structure("run", 1, more)});
    EXPECT_TRUE(file.skipped.empty()) << file.skipped.front();
    return std::pair(named(file, "run.acc").unit + "|" + named(file, "run.force").unit, file.notes);
  };
  const auto [single, notes] = units_of({text("units", "m/s^2")});
  EXPECT_EQ(single, "|");
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_NE(notes[0].find("'run.units' states one unit, 'm/s^2', beside 2 series (acc, force): it is not used"),
            std::string::npos)
      << notes[0];
  EXPECT_EQ(units_of({text("units", "m/s^2, N")}).first, "m/s^2|N");
  EXPECT_EQ(units_of({text("acc_unit", "g"), text("unit_force", "kN")}).first, "g|kN");
  EXPECT_EQ(units_of({structure("units", 1, {text("force", "N"), text("acc", "g")})}).first, "g|N");
  if (GetParam() == MAT_FT_MAT5) {
    EXPECT_EQ(units_of({cells("units", {text("", "g"), text("", "N")})}).first, "g|N");
  }
  const auto [three, told] = units_of({text("units", "g, N, V")});
  EXPECT_EQ(three, "|");
  ASSERT_EQ(told.size(), 1u);
  EXPECT_NE(told[0].find("'run.units' lists 3 units"), std::string::npos) << told[0];
}

TEST_P(MatlabFiles, UnitsOfAMatrixAreOneAColumnOrOneForAll) {
  const auto unit = [&](const std::string& units) {
    return read(
        {structure("run", 1, {scalar("fs", 10.0), numbers("y", 3, 2, {1, 9, 3, 4, 2, 6}), text("units", units)})});
  };
  const auto each = unit("g; N");
  EXPECT_EQ(each.channels[0].unit + each.channels[1].unit, "gN");
  EXPECT_TRUE(each.notes.empty());
  const auto all = unit("g");
  EXPECT_EQ(all.channels[0].unit + all.channels[1].unit, "gg");
  ASSERT_EQ(all.notes.size(), 1u);
  EXPECT_NE(all.notes[0].find("it is taken for all 2 channels of 'y'"), std::string::npos) << all.notes[0];
}

TEST_P(MatlabFiles, SayThatAWideMatrixIsTurned) {
  const auto turned = read({scalar("fs", 10.0), numbers("y", 2, 3, {1, 4, 2, 5, 3, 6})});
  ASSERT_EQ(turned.notes.size(), 1u);
  EXPECT_NE(turned.notes[0].find("'y' has 2 rows and 3 columns: each row is taken as a channel"), std::string::npos);
  const auto timed = read({column("t", {0, 1, 2}), numbers("y", 2, 3, {1, 4, 2, 5, 3, 6})});
  EXPECT_TRUE(timed.notes.empty());
  const auto by_units = read(
      {structure("run", 1, {scalar("fs", 10.0), numbers("y", 2, 3, {1, 4, 2, 5, 3, 6}), text("units", "g, N, V")})});
  ASSERT_EQ(by_units.channels.size(), 3u) << "three units name three columns";
  EXPECT_EQ(by_units.channels[2].unit, "V");
  EXPECT_TRUE(by_units.notes.empty());
}

TEST_P(MatlabFiles, WhatIsNoSeriesIsListed) {
  std::size_t lengths[] = {2, 2, 2};
  Numbers eight(8, 1.0);
  const auto file = read({text("remark", "hello"), column("a", {1, 2}),
                          Mat_VarCreate("cube", MAT_C_DOUBLE, MAT_T_DOUBLE, 3, lengths, eight.data(), 0)});
  ASSERT_EQ(file.skipped.size(), 2u);
  EXPECT_TRUE(std::ranges::count(file.skipped, "'remark' is text"));
  EXPECT_TRUE(std::ranges::count(file.skipped, "'cube' is an array of 3 dimensions"));
  EXPECT_THROW(read({text("remark", "hello")}), InvalidInput);
}

TEST_P(MatlabFiles, DamagedOnesAreReadInPartOrRefused) {
  if (GetParam() != MAT_FT_MAT5) GTEST_SKIP() << "HDF5 1.10 itself fails on some damaged files";
  const auto path = write({column("time", Numbers(40, 1.0)), column("acc", {1, 2, 3}),
                           structure("run", 1, {scalar("fs", 50.0), column("data", {1, 2}), text("unit", "g")})});
  std::ifstream stream(path, std::ios::binary);
  const std::string sound(std::istreambuf_iterator<char>(stream), {});
  std::mt19937 random(1);
  int read_ones = 0;
  for (int i = 0; i < 100; ++i) {
    auto bytes = sound;
    for (auto changes = 1 + random() % 3; changes > 0; --changes) bytes[random() % bytes.size()] = char(random());
    if (i % 3 == 0) bytes.resize(random() % bytes.size());
    std::ofstream(path, std::ios::binary) << bytes;
    try {
      read_matlab_file(path);
      ++read_ones;
    } catch (const InvalidInput&) {
    }
  }
  EXPECT_GT(read_ones, 5);
}

// --- what is only in the file's bytes ---

std::string element(std::uint32_t type, std::string data) {
  const auto size = double(data.size());
  data.resize((data.size() + 7) / 8 * 8);
  return raw<std::uint32_t>({double(type), size}) + data;
}

std::string version_5(const std::string& elements) {
  std::string header("MATLAB 5.0 MAT-file");
  header.resize(124, ' ');
  return header + std::string("\x00\x01IM", 4) + elements;
}

std::string vector_5(const std::string& name, const Numbers& numbers) {
  return element(14, element(6, raw<std::uint32_t>({6, 0})) +
                         element(5, raw<std::int32_t>({double(numbers.size()), 1})) + element(1, name) +
                         element(9, raw<double>(numbers)));
}

MeasuredFile read_bytes(const std::string& bytes) {
  const ScratchFolder folder("matlab_bytes");
  std::ofstream(folder / "run.mat", std::ios::binary) << bytes;
  return read_matlab_file(folder / "run.mat");
}

TEST(MatlabObjects, AreNamedWithTheirClass) {
  const auto object = [](const std::string& name, const std::string& kind) {
    const auto references =
        element(14, element(6, raw<std::uint32_t>({13, 0})) + element(5, raw<std::int32_t>({6, 1})) + element(1, "") +
                        element(6, raw<std::uint32_t>({1, 2, 3, 4, 5, 6})));
    return element(14, element(6, raw<std::uint32_t>({17, 0})) + element(1, name) + element(1, "MCOS") +
                           element(1, kind) + references);
  };
  const auto file = read_bytes(
      version_5(object("label", "string") + vector_5("a", {1, 2}) + object("T", "table") + vector_5("b", {3, 4})));
  ASSERT_EQ(file.channels.size(), 2u);
  EXPECT_EQ(file.channels[1].name, "b");
  ASSERT_GE(file.skipped.size(), 2u);
  EXPECT_EQ(file.skipped[0], "'label' is a MATLAB object of class string: save it as an array");
  EXPECT_EQ(file.skipped[1], "'T' is a MATLAB object of class table: save it as an array");
}

// A text of five characters whose data state to take a gigabyte: room is made for what is in the file only.
TEST(MatlabFileCut, DoesNotBelieveTheLengthOfATag) {
  const auto characters = [](std::uint32_t stated) {
    return element(14, element(6, raw<std::uint32_t>({4, 0})) + element(5, raw<std::int32_t>({1, 5})) +
                           element(1, "txt") + raw<std::uint32_t>({16, double(stated)}) +
                           std::string("hello\0\0\0", 8));
  };
  const auto sound = read_bytes(version_5(vector_5("a", {1, 2}) + characters(5)));
  EXPECT_EQ(sound.skipped, std::vector<std::string>{"'txt' is text"});
  const auto damaged = read_bytes(version_5(vector_5("a", {1, 2}) + characters(1 << 30)));
  EXPECT_EQ(damaged.channels.size(), 1u);
  ASSERT_EQ(damaged.skipped.size(), 1u);
  EXPECT_NE(damaged.skipped[0].find("is damaged: it and what follows are left out"), std::string::npos)
      << damaged.skipped[0];
}

TEST(MatlabFileCut, KeepsWhatIsBeforeAndSaysSo) {
  const auto whole = version_5(vector_5("a", {1, 2}) + vector_5("b", {3, 4, 5, 6}));
  const auto file = read_bytes(whole.substr(0, whole.size() - 20));
  EXPECT_EQ(file.channels[0].name, "a");
  ASSERT_FALSE(file.skipped.empty());
  EXPECT_NE(file.skipped.back().find("the file is cut off"), std::string::npos) << file.skipped.back();
}

}  // namespace
}  // namespace kalfem
