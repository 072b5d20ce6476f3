// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/hdf5/hdf5_file.hpp"

#include <gtest/gtest.h>
#include <filesystem>
#include <fstream>
#include <limits>

#include "base/scratch_folder.hpp"
#include "kalfem/base/invalid_input.hpp"

namespace kalfem {
namespace {

namespace fs = std::filesystem;

class Hdf5FileTest : public testing::Test {
protected:
  template <class Action>
  std::string message(Action action) {
    try {
      action();
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "nothing was thrown";
  }

  const ScratchFolder folder_{"hdf5"};
  const std::string path_ = (folder_ / "record.h5").string();
};

TEST_F(Hdf5FileTest, AxesNameTheDimensionsOfSeveralDatasets) {
  const Eigen::VectorXd rows = Eigen::VectorXd::LinSpaced(6, 1.0, 6.0);
  Hdf5File out = Hdf5File::create(path_);
  out.write_axis("/posterior/chain", 2);
  out.write_axis("/posterior/draw", 3);
  for (const char* name : {"/posterior/a.k", "/posterior/a.c"}) {
    out.write_rows(name, rows, 2);
    out.set_axes(name, {"/posterior/chain", "/posterior/draw"});
  }
  EXPECT_NE(message([&] { out.set_axes("/posterior/a.k", {"/posterior/chain"}); }).find("every dimension"),
            std::string::npos);
  EXPECT_NE(message([&] { out.write_rows("/posterior/b", rows, 4); }).find("equal length"), std::string::npos);
  out.close();

  const Hdf5File file = Hdf5File::open(path_);
  Eigen::MatrixXd expected(2, 3);
  expected << 1.0, 2.0, 3.0, 4.0, 5.0, 6.0;
  EXPECT_EQ(file.read_matrix("/posterior/a.c"), expected);
  EXPECT_EQ(file.read("/posterior/draw"), Eigen::Vector3d(0.0, 1.0, 2.0));
  EXPECT_EQ(file.text_attribute("/posterior/draw", "CLASS"), "DIMENSION_SCALE");
  EXPECT_EQ(file.text_attribute("/posterior/draw", "NAME"), "draw");
  EXPECT_TRUE(file.has_attribute("/posterior/a.k", "DIMENSION_LIST"));
}

TEST_F(Hdf5FileTest, VectorsAndMatricesComeBackBitByBit) {
  // Long enough for several compressed chunks.
  const Eigen::MatrixXd record = Eigen::MatrixXd::Random(30011, 7);
  Eigen::VectorXd odd(5);
  odd << 0.0, -0.0, std::numeric_limits<double>::denorm_min(), std::numeric_limits<double>::infinity(), std::nan("");
  Hdf5File out = Hdf5File::create(path_);
  out.write_matrix("/measurements/record", record);
  out.write("/estimate/frame.p5/displacement", record.col(2));
  out.write("odd", odd);
  out.write("empty", Eigen::VectorXd());
  out.close();

  const Hdf5File in = Hdf5File::open(path_);
  EXPECT_EQ(in.read_matrix("/measurements/record"), record);
  EXPECT_EQ(in.read_columns_as_rows("/measurements/record"), record.transpose());
  EXPECT_EQ(in.read("/estimate/frame.p5/displacement"), record.col(2));
  EXPECT_EQ(in.read_column("/measurements/record", 6), record.col(6));
  EXPECT_EQ(in.read_matrix("/estimate/frame.p5/displacement"), record.col(2));
  EXPECT_EQ(in.read_columns_as_rows("/estimate/frame.p5/displacement"), record.col(2).transpose());
  EXPECT_EQ(in.read("odd").head(4), odd.head(4));
  EXPECT_TRUE(std::isnan(in.read("odd")(4)));
  EXPECT_EQ(in.read("empty").size(), 0);
  EXPECT_EQ(in.shape("/measurements/record"), (std::vector<Eigen::Index>{30011, 7}));
}

TEST_F(Hdf5FileTest, LongSmoothRecordsAreCompressed) {
  Hdf5File out = Hdf5File::create(path_);
  out.write("/step", Eigen::VectorXd::Constant(1'000'000, 9.81));
  out.close();
  EXPECT_LT(fs::file_size(path_), 1'000'000u);  // 8 MB as they are
}

TEST_F(Hdf5FileTest, TextAndAttributes) {
  const std::vector<std::string> names{"p5.z", "", "Aufhängung 2"};
  Hdf5File out = Hdf5File::create(path_);
  out.write_strings("/names", names);
  out.write_strings("/none", {});
  out.write("/group/a", Eigen::VectorXd::Ones(3));
  out.set_attribute("/group/a", "unit", "m/s²");
  out.set_attribute("/group/a", "sample_rate", 1.0);
  out.set_attribute("/group/a", "sample_rate", 2000.0);
  out.set_attribute("/", "title", "");
  out.close();

  const Hdf5File in = Hdf5File::open(path_);
  EXPECT_EQ(in.read_strings("/names"), names);
  EXPECT_TRUE(in.read_strings("/none").empty());
  EXPECT_EQ(in.text_attribute("/group/a", "unit"), "m/s²");
  EXPECT_EQ(in.number_attribute("/group/a", "sample_rate"), 2000.0);
  EXPECT_EQ(in.text_attribute("/", "title"), "");
  EXPECT_TRUE(in.has_attribute("/group/a", "unit"));
  EXPECT_FALSE(in.has_attribute("/group/a", "sensor"));
  EXPECT_FALSE(in.has_attribute("/nowhere", "sensor"));
}

TEST_F(Hdf5FileTest, ListsDatasetsBelowAGroup) {
  Hdf5File out = Hdf5File::create(path_);
  for (const char* name : {"/time", "/estimate/b/x", "/estimate/a/x", "/estimate/a/x_std"}) {
    out.write(name, Eigen::VectorXd::Ones(1));
  }
  EXPECT_EQ(out.datasets(), (std::vector<std::string>{"/estimate/a/x", "/estimate/a/x_std", "/estimate/b/x", "/time"}));
  EXPECT_EQ(out.datasets("/estimate/a"), (std::vector<std::string>{"/estimate/a/x", "/estimate/a/x_std"}));
  EXPECT_TRUE(out.contains("/estimate/b"));
  EXPECT_FALSE(out.contains("/estimate/b/y"));
  EXPECT_FALSE(out.contains("/nowhere/b/y"));
  EXPECT_FALSE(out.contains("/time/below/a/dataset"));
}

TEST_F(Hdf5FileTest, FailuresNameTheFileAndTheReason) {
  const auto contains = [](const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos ? testing::AssertionSuccess() : testing::AssertionFailure() << text;
  };
  EXPECT_TRUE(contains(message([&] { (void)Hdf5File::open(path_); }),
                       path_ + ": the file cannot be read: there is no such file"));
  EXPECT_TRUE(contains(message([] { (void)Hdf5File::create("/no/such/folder/x.h5"); }), "No such file or directory"));
  std::ofstream(path_) << "time,acceleration\n0,1\n";
  EXPECT_TRUE(contains(message([&] { (void)Hdf5File::open(path_); }), "file signature not found"));

  Hdf5File out = Hdf5File::create(path_);
  out.write_matrix("/wide", Eigen::MatrixXd::Ones(3, 2));
  out.write_strings("/text", {"a"});
  EXPECT_TRUE(contains(message([&] { (void)out.read("/missing/x"); }), "there is no '/missing/x'"));
  EXPECT_TRUE(contains(message([&] { (void)out.read("/wide"); }), "not a single column"));
  EXPECT_TRUE(contains(message([&] { (void)out.read_column("/wide", 2); }), "it has 2 columns"));
  EXPECT_TRUE(contains(message([&] { (void)out.read_column("/text", 0); }), "no columns"));
  EXPECT_TRUE(contains(message([&] { (void)out.read("/text"); }), "does not hold numbers"));
  EXPECT_TRUE(contains(message([&] { (void)out.read_strings("/wide"); }), "does not hold text"));
  EXPECT_TRUE(contains(message([&] { (void)out.read("/"); }), "is a group"));
  EXPECT_TRUE(contains(message([&] { (void)out.text_attribute("/wide", "unit"); }), "no attribute 'unit'"));
  EXPECT_TRUE(contains(message([&] { out.write("/wide", Eigen::VectorXd::Ones(1)); }), "exists already"));
  EXPECT_TRUE(contains(message([&] { out.write("/wide/below", Eigen::VectorXd::Ones(1)); }), "cannot create"));
  EXPECT_TRUE(contains(message([&] { out.write("", Eigen::VectorXd::Ones(1)); }), "not a name for a dataset"));
  EXPECT_TRUE(contains(message([&] { out.write_strings("/zero", {std::string("a\0b", 3)}); }), "zero byte"));
  out.close();
  out.close();
  EXPECT_TRUE(contains(message([&] { (void)out.contains("/wide"); }), "was closed"));
  Hdf5File in = Hdf5File::open(path_);
  EXPECT_TRUE(contains(message([&] { in.write("/new", Eigen::VectorXd::Ones(1)); }), "cannot create '/new'"));
}

// /dev/full takes no byte: the failure must come out of close or of a write, never be lost.
TEST_F(Hdf5FileTest, AFullDiskIsReported) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "HDF5 itself loses a kilobyte when it cannot close a file";
#endif
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full on this system";
  EXPECT_THROW(
      {
        Hdf5File out = Hdf5File::create("/dev/full");
        out.write("/a", Eigen::VectorXd::Random(100000));
        out.close();
      },
      InvalidInput);
}

TEST_F(Hdf5FileTest, NothingIsPrintedOnFailure) {
  testing::internal::CaptureStderr();
  EXPECT_THROW((void)Hdf5File::create("/no/such/folder/x.h5"), InvalidInput);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

}  // namespace
}  // namespace kalfem
