// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/unpacked_size.hpp"

#include <gtest/gtest.h>
#include <hdf5.h>
#include <sys/stat.h>
#include <zlib.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "base/scratch_folder.hpp"
#include "formats/matrices_refusal.hpp"
#include "kalfem/base/invalid_input.hpp"
#include "kalfem/formats/hdf5/hdf5_file.hpp"
#include "kalfem/formats/measured_file_reader.hpp"
#include "kalfem/formats/record_file.hpp"
#include "kalfem/formats/tables/text_table.hpp"
#include "tdms_file.hpp"

// Files that hold a hundred times what their size says, beside series of the usual size.
namespace kalfem {
namespace {

namespace fs = std::filesystem;
using test::raw;

constexpr hsize_t too_many = 12'000'000;  ///< values, 96 MB

class UnpackedSizes : public testing::Test {
protected:
  /// "/big" of zeros, compressed, and "/a" of three values.
  [[nodiscard]] fs::path hdf5() const {
    const fs::path path = folder_ / "zeros.h5";
    auto file = Hdf5File::create(path.string());
    file.write("/a", Eigen::Vector3d(1, 2, 4));
    file.close();
    const hid_t id = H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
    const hsize_t length = too_many, chunk = 1 << 16;
    const hid_t space = H5Screate_simple(1, &length, nullptr), creation = H5Pcreate(H5P_DATASET_CREATE);
    H5Pset_chunk(creation, 1, &chunk);
    H5Pset_deflate(creation, 9);
    H5Pset_alloc_time(creation, H5D_ALLOC_TIME_EARLY);
    H5Pset_fill_time(creation, H5D_FILL_TIME_ALLOC);
    H5Dclose(H5Dcreate2(id, "big", H5T_IEEE_F64LE, space, H5P_DEFAULT, creation, H5P_DEFAULT));
    H5Pclose(creation);
    H5Sclose(space);
    H5Fclose(id);
    return path;
  }

  static std::string element(std::uint32_t type, std::string data) {
    const auto size = double(data.size());
    data.resize((data.size() + 7) / 8 * 8);
    return raw<std::uint32_t>({double(type), size}) + data;
  }

  static std::string vector(const std::string& name, const std::string& numbers) {
    return element(14, element(6, raw<std::uint32_t>({6, 0})) +
                           element(5, raw<std::int32_t>({double(numbers.size() / 8), 1})) + element(1, name) +
                           element(9, numbers));
  }

  /// The same as a MATLAB file of version 5.
  [[nodiscard]] fs::path matlab() const {
    std::string header("MATLAB 5.0 MAT-file");
    header.resize(124, ' ');
    const std::string big = vector("big", std::string(too_many * 8, '\0'));
    std::string packed(compressBound(big.size()), '\0');
    uLongf size = packed.size();
    compress2(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(big.data()), big.size(),
              9);
    packed.resize(size);
    const std::string compressed = raw<std::uint32_t>({15, double(size)}) + packed;
    const fs::path path = folder_ / "zeros.mat";
    std::ofstream(path, std::ios::binary)
        << header << std::string("\x00\x01IM", 4) << compressed << vector("a", raw<double>({1, 2, 4}));
    return path;
  }

  ScratchFolder folder_{"unpacked"};
};

Eigen::Index samples_of(const MeasuredFile& file, const std::string& name) {
  for (const auto& channel : file.channels)
    if (channel.name == name || channel.name == "/" + name) return channel.values.size();
  return -1;
}

TEST_F(UnpackedSizes, PartsFarLargerThanTheFileAreReadWhereTheyAreAskedFor) {
  for (const auto& path : {hdf5(), matlab()}) {
    ASSERT_LT(fs::file_size(path), 1'000'000u);
    const auto file = read_measured_file(path);
    EXPECT_EQ(samples_of(file, "a"), 3) << path;
    EXPECT_EQ(samples_of(file, "big"), -1) << path;
    ASSERT_EQ(file.skipped.size(), 1u) << path;
    EXPECT_NE(file.skipped[0].find("big' is not read: it unpacks to 96 MB"), std::string::npos) << file.skipped[0];
    EXPECT_EQ(samples_of(read_measured_file(path, {.large = true}), "big"), Eigen::Index(too_many)) << path;
    EXPECT_EQ(samples_of(read_measured_file(path, {.channels = {"big"}}), "big"), Eigen::Index(too_many)) << path;
  }
}

// What a case does not name is known, with its name, and holds no memory.
TEST_F(UnpackedSizes, OnlyChannelsThatAreAskedForAreReadOfHdf5) {
  auto file = Hdf5File::create((folder_ / "two.h5").string());
  file.write("/a", Eigen::Vector3d(1, 2, 4));
  file.write("/b", Eigen::Vector3d(5, 6, 8));
  file.close();
  const auto measured = read_measured_file(folder_ / "two.h5", {.channels = {"b"}});
  EXPECT_EQ(samples_of(measured, "a"), 0);
  EXPECT_EQ(samples_of(measured, "b"), 3);
}

// Blocks of whole chunks, in either direction: every value once, at its place.
TEST_F(UnpackedSizes, Hdf5IsReadByBlocks) {
  const Eigen::Index rows = 3000, columns = 130;
  Eigen::MatrixXd values(rows, columns);
  for (Eigen::Index i = 0; i < values.size(); ++i) values.data()[i] = double(i % 9973);
  for (const bool tall : {true, false}) {
    const Eigen::MatrixXd stored = tall ? values : Eigen::MatrixXd(values.transpose());
    const std::string name = tall ? "tall.h5" : "wide.h5";
    auto file = Hdf5File::create((folder_ / name).string());
    file.write_matrix("/run", stored);
    file.close();
    const auto open = Hdf5File::open((folder_ / name).string());
    EXPECT_EQ(open.read_columns("/run", {5, 0, 5}).row(0), stored.col(5).transpose());
    EXPECT_EQ(open.read_columns("/run", {5, 0}).row(1), stored.col(0).transpose());
    const auto measured = read_measured_file(folder_ / name);
    ASSERT_EQ(std::ssize(measured.channels), columns);
    for (Eigen::Index j = 0; j < columns; ++j)
      ASSERT_EQ(measured.channels[std::size_t(j)].values, values.col(j)) << name << " " << j;
    EXPECT_EQ(measured.notes.size(), tall ? 0u : 1u) << name;
  }
}

TEST_F(UnpackedSizes, AShortDatasetOfManyChannelsSaysThatItIsTurned) {
  auto file = Hdf5File::create((folder_ / "short.h5").string());
  file.write_matrix("/run", Eigen::MatrixXd::Random(10, 16));
  file.close();
  const auto measured = read_measured_file(folder_ / "short.h5");
  EXPECT_EQ(measured.channels.size(), 10u);
  ASSERT_EQ(measured.notes.size(), 1u);
  EXPECT_NE(measured.notes[0].find("'/run' has 10 rows and 16 columns: each row is taken as a channel of 16 samples"),
            std::string::npos)
      << measured.notes[0];
  auto timed = Hdf5File::create((folder_ / "timed.h5").string());
  timed.write_matrix("/run", Eigen::MatrixXd::Random(10, 16));
  timed.write("/t", Eigen::VectorXd::LinSpaced(10, 0.0, 0.9));
  timed.close();
  const auto by_times = read_measured_file(folder_ / "timed.h5");
  EXPECT_EQ(by_times.channels.size(), 16u);
  EXPECT_TRUE(by_times.notes.empty());
}

// HDF5 opens other files by itself: /dev/zero as the store of a dataset, a pipe behind a link.
TEST_F(UnpackedSizes, Hdf5DoesNotOpenWhatIsNoFile) {
  const fs::path path = folder_ / "external.h5", pipe = folder_ / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  auto file = Hdf5File::create(path.string());
  file.write("/a", Eigen::Vector3d(1, 2, 4));
  file.close();
  const hid_t id = H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  const hsize_t length = 1000;
  const hid_t space = H5Screate_simple(1, &length, nullptr), creation = H5Pcreate(H5P_DATASET_CREATE);
  H5Pset_external(creation, pipe.c_str(), 0, 8000);
  H5Dclose(H5Dcreate2(id, "store", H5T_IEEE_F64LE, space, H5P_DEFAULT, creation, H5P_DEFAULT));
  H5Lcreate_external(pipe.c_str(), "/x", id, "link", H5P_DEFAULT, H5P_DEFAULT);
  H5Pclose(creation);
  H5Sclose(space);
  H5Fclose(id);
  const auto measured = read_measured_file(path);
  EXPECT_EQ(measured.channels.size(), 1u);
  ASSERT_EQ(measured.skipped.size(), 1u);
  EXPECT_EQ(measured.skipped[0], "dataset '/store' lies in another file");
  EXPECT_FALSE(Hdf5File::open(path.string()).contains("/link"));
  EXPECT_THROW((void)Hdf5File::open(path.string()).read("/store"), InvalidInput);
}

TEST_F(UnpackedSizes, CompressedMatricesHaveALimitToo) {
  const std::string blanks(100 << 20, ' ');
  const fs::path path = folder_ / "K.mtx.gz";
  gzFile file = gzopen(path.c_str(), "wb");
  gzwrite(file, blanks.data(), static_cast<unsigned>(blanks.size()));
  gzclose(file);
  std::ifstream stream(path, std::ios::binary);
  const std::string bytes(std::istreambuf_iterator<char>(stream), {});
  EXPECT_NE(refusal(bytes, "K.mtx.gz").find("unpacks to more than"), std::string::npos) << refusal(bytes, "K.mtx.gz");
}

TEST_F(UnpackedSizes, MatricesAreUnpackedOnce) {
  const auto packed = [&](const std::string& content) {
    const fs::path path = folder_ / "twice.gz";
    gzFile file = gzopen(path.c_str(), "wb");
    gzwrite(file, content.data(), static_cast<unsigned>(content.size()));
    gzclose(file);
    std::ifstream stream(path, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(stream), {});
  };
  const std::string text = "%%MatrixMarket matrix coordinate real general\n1 1 1\n1 1 4\n";
  EXPECT_EQ(refusal(packed(text), "K.mtx.gz"), "");
  EXPECT_NE(refusal(packed(packed(text)), "K.mtx.gz").find("compressed twice"), std::string::npos);
  EXPECT_THROW((void)parse_dof_map(packed(packed("7.1\n")), "K.dof.gz"), InvalidInput);
}

TEST_F(UnpackedSizes, ALineThatIsNoLineIsRefusedBeforeTheFileIsRead) {
  const auto said = [&](const std::string& content) -> std::string {
    std::ofstream(folder_ / "long.csv", std::ios::binary) << content;
    try {
      (void)read_text(folder_ / "long.csv");
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(said(std::string(longest_line, 'a') + "\nb\n"), "");
  EXPECT_NE(
      said("a\nb\n" + std::string(longest_line + 1, 'c') + "\n").find("long.csv:3: the line is longer than 4 MiB"),
      std::string::npos);
  EXPECT_EQ(said("a\rb\r" + std::string(longest_line, 'c') + "\r"), "");
  std::ofstream(folder_ / "sparse.csv").close();
  fs::resize_file(folder_ / "sparse.csv", std::uintmax_t{1} << 36);  // 64 GB of zeros, which take no place
  EXPECT_THROW((void)read_text(folder_ / "sparse.csv"), InvalidInput);
  EXPECT_THROW(read_measured_file(folder_ / "sparse.csv"), InvalidInput);
}

// Cells of one byte each: a million names would take a hundred times the file.
TEST_F(UnpackedSizes, ATableOfAMillionColumnsIsRefused) {
  for (const char* ending : {"csv", "dat"}) {
    const fs::path path = folder_ / ("wide." + std::string(ending));
    std::string row;
    for (int i = 0; i < 1'000'000; ++i) row += "1,";
    std::ofstream(path) << row << "\n" << row << "\n" << row << "\n";
    try {
      read_measured_file(path);
      FAIL() << "it was read";
    } catch (const InvalidInput& error) {
      EXPECT_NE(std::string(error.what()).find("columns: at most 50000 channels are read"), std::string::npos)
          << error.what();
    }
  }
}

}  // namespace
}  // namespace kalfem
