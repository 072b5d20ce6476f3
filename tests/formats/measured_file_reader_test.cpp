// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/measured_file_reader.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "base/scratch_folder.hpp"
#include "kalfem/base/invalid_input.hpp"

// The format of a measured file is told by its content first and by its ending second.
namespace kalfem {
namespace {

namespace fs = std::filesystem;

class MeasuredFiles : public testing::Test {
protected:
  fs::path file(const std::string& name, const std::string& content) const {
    std::ofstream(folder_ / name, std::ios::binary) << content;
    return folder_ / name;
  }

  std::string format_of(const std::string& name, const std::string& content) const {
    const auto* format = measured_format(file(name, content));
    return format == nullptr ? "" : std::string(format->name);
  }

  std::string refusal(const std::string& name, const std::string& content) const {
    try {
      read_measured_file(file(name, content));
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "";
  }

  ScratchFolder folder_{"measured_files"};
};

constexpr const char* universal_start = "    -1\r\n    99\r\n    -1\r\n";

TEST_F(MeasuredFiles, AreToldByTheirContentBeforeTheirEnding) {
  EXPECT_EQ(format_of("a.unv", universal_start), "universal file");
  EXPECT_EQ(format_of("a.txt", universal_start), "universal file");
  EXPECT_EQ(format_of("a.csv", "LabVIEW Measurement\t\n"), "LabVIEW measurement file");
  EXPECT_EQ(format_of("a.UFF", "something else\n"), "universal file");
  EXPECT_EQ(format_of("a.csv", "t,a\n0,1\n1,2\n"), "");
  EXPECT_EQ(format_of("numbers.txt", "-1\n2\n"), "") << "a table whose first number is -1 is no universal file";
}

TEST_F(MeasuredFiles, OfAnotherKindAreRefusedWithTheFormatsThatAreRead) {
  const std::string binary("\x01\0\0\0\x07", 5);
  for (const std::string& content :
       {std::string("PK\x03\x04 and more"), std::string("\x89PNG\r\n"), std::string("%PDF-1.4"), std::string("<html>"),
        std::string("MDF     4.10"), binary}) {
    const std::string text = refusal("a.csv", content);
    EXPECT_NE(text.find("universal file (.unv"), std::string::npos) << text;
    EXPECT_NE(text.find(".lvm"), std::string::npos) << text;
    EXPECT_NE(text.find("HDF5"), std::string::npos) << text;
  }
  EXPECT_NE(refusal("a.uff", "no dataset here").find("not a universal file"), std::string::npos);
  EXPECT_THROW(measured_format(folder_ / "absent.unv"), InvalidInput);
}

TEST_F(MeasuredFiles, KeepTheChannelsOfTablesInTheirUnits) {
  const auto measured = read_measured_file(file("a.csv", "t,a [g],F [kN]\n0,1,2\n0.5,3,4\n1,5,6\n"));
  ASSERT_EQ(measured.channels.size(), 2u);
  EXPECT_EQ(measured.channels[1].name, "F");
  EXPECT_EQ(measured.channels[1].unit, "kN");
  EXPECT_EQ(measured.channels[0].interval, 0.5);
  EXPECT_EQ(measured.channels[0].values, Eigen::VectorXd(Eigen::Vector3d(1, 3, 5)));
}

TEST_F(MeasuredFiles, WithRepeatedNamesAreNumbered) {
  const auto measured = read_measured_file(
      file("a.lvm",
           "LabVIEW Measurement\t\nSeparator\tTab\nX_Columns\tOne\n***End_of_Header***\t\nChannels\t2\n"
           "Samples\t2\t2\nY_Unit_Label\tVolts\tNewtons\nX0\t0\t0\nDelta_X\t1\t1\n***End_of_Header***\n"
           "X_Value\tUntitled\tUntitled\n0\t1\t2\n1\t3\t4\n"));
  ASSERT_EQ(measured.channels.size(), 2u);
  EXPECT_EQ(measured.channels[1].name, "Untitled #2");
  EXPECT_EQ(measured.channels[0].other_names, std::vector<std::string>{"Untitled"});
  EXPECT_EQ(measured.channels[0].unit, "V");
  EXPECT_EQ(measured.channels[1].unit, "N");
}

}  // namespace
}  // namespace kalfem
