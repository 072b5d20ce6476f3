// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <zlib.h>

#include "formats/matrices_files.hpp"
#include "kalfem/formats/hdf5/hdf5_file.hpp"

namespace kalfem {
namespace {

TEST(MatrixBinary, Outputs4InEveryKind) {
  for (const auto& kind : kinds)
    for (const auto columns : {Columns::dense, Columns::short_strings, Columns::long_strings}) {
      const auto matrices = parse_matrices(op4(kind, columns) + op4(kind, Columns::dense), "x");
      ASSERT_EQ(matrices.size(), 2u);
      EXPECT_EQ(dense(matrices[0]), common_matrix);
      EXPECT_EQ(dense(matrices[1]), common_matrix);
      EXPECT_EQ(matrices[0].name, "KAA");
      if (kind.big_endian == kind.long_words) expect_no_crash(op4(kind, columns), "x.op4");
    }
  EXPECT_NE(refusal(op4(kinds[0], Columns::dense, 4), "x").find("matrix 'KAA' is complex"), std::string::npos);
  const std::string whole = op4(kinds[0], Columns::dense);
  EXPECT_NE(refusal(whole.substr(0, whole.size() - 30), "x").find("the file ends, but"), std::string::npos);
}

TEST(MatrixBinary, Outputs2InEveryKind) {
  for (const auto& kind : kinds)
    for (const bool with_label : {true, false}) {
      const auto matrices = parse_matrices(op2(kind, with_label), "x");
      ASSERT_EQ(matrices.size(), 1u);
      EXPECT_EQ(dense(matrices[0]), common_matrix);
      EXPECT_EQ(matrices[0].name, "KAA");
      if (kind.big_endian == kind.long_words) expect_no_crash(op2(kind, with_label), "x.op2");
    }
}

TEST(MatrixBinary, MatlabFilesPlainAndCompressed) {
  for (const bool big : {false, true}) {
    const std::string plain = matlab(big);
    const auto matrices = parse_matrices(plain, "x");
    ASSERT_EQ(matrices.size(), 2u);
    EXPECT_EQ(dense(matrices[0]), common_matrix);
    EXPECT_EQ(dense(matrices[1]), common_matrix);
    EXPECT_EQ(matrices[1].name.substr(0, 1), "F");
    expect_no_crash(plain, "x.mat");

    const std::string content = plain.substr(128);
    std::string packed(compressBound(content.size()), '\0');
    uLongf size = packed.size();
    ASSERT_EQ(compress(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(content.data()),
                       content.size()),
              Z_OK);
    packed.resize(size);
    Bytes file(big);
    file.add(plain.substr(0, 128)).add(std::uint32_t{15}).add(static_cast<std::uint32_t>(size)).add(packed);
    EXPECT_EQ(dense(parse_matrices(file.text, "x")[0]), common_matrix);
    expect_no_crash(file.text, "x.mat");
  }
  EXPECT_NE(refusal(matlab(false, true), "x").find("is complex"), std::string::npos);
}

TEST(MatrixBinary, NetcdfSuperelements) {
  for (const int version : {1, 2, 5}) {
    const auto matrices = parse_matrices(netcdf(version), "x");
    ASSERT_EQ(matrices.size(), 1u);
    EXPECT_EQ(dense(matrices[0]), common_matrix);
    EXPECT_EQ(matrices[0].dofs, (std::vector<MatrixDof>{{1, -1}, {7, 0}, {7, 5}}));
    EXPECT_EQ(parse_dof_map(netcdf(version), "x"), matrices[0].dofs);
    expect_no_crash(netcdf(version), "x.nc");
  }
}

TEST(MatrixBinary, Hdf5GroupsAndDatasets) {
  const Eigen::SparseMatrix<double> sparse = common_matrix.sparseView();
  auto file = Hdf5File::create_in_memory("x");
  const Eigen::Index count = sparse.nonZeros();
  const Eigen::VectorXd values = Eigen::Map<const Eigen::VectorXd>(sparse.valuePtr(), count);
  const Eigen::VectorXd inner = Eigen::Map<const Eigen::VectorXi>(sparse.innerIndexPtr(), count).cast<double>();
  const Eigen::VectorXd outer = Eigen::Map<const Eigen::VectorXi>(sparse.outerIndexPtr(), 4).cast<double>();
  file.write_matrix("/a_full", common_matrix);
  for (const std::string group : {"/b", "/c", "/d"}) {
    file.write(group + "/data", values);
    file.write(group + (group == "/c" ? "/ir" : "/indices"), inner);
    file.write(group + (group == "/c" ? "/jc" : "/indptr"), outer);
  }
  file.set_attribute("/c", "MATLAB_sparse", 3.0);
  file.set_attribute("/d", "format", std::string("csr"));
  file.write("/e/values", values);
  file.write("/e/rows", (Eigen::VectorXd(7) << 1, 2, 1, 2, 3, 2, 3).finished());
  file.write("/e/cols", (Eigen::VectorXd(7) << 1, 1, 2, 2, 2, 3, 3).finished());
  const auto matrices = parse_matrices(file.bytes(), "x");
  ASSERT_EQ(matrices.size(), 5u);
  for (const auto& matrix : matrices) EXPECT_EQ(dense(matrix), common_matrix) << matrix.name;
}

TEST(MatrixBinary, CompressedFilesAndWhatIsWrongWithThem) {
  const std::string market = "%%MatrixMarket matrix coordinate real general\n1 1 1\n1 1 5\n";
  z_stream stream{};
  ASSERT_EQ(deflateInit2(&stream, 9, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY), Z_OK);
  std::string packed(1000, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(market.data()));
  stream.avail_in = static_cast<uInt>(market.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  ASSERT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
  packed.resize(stream.total_out);
  deflateEnd(&stream);
  EXPECT_EQ(parse_matrices(packed, "K.mtx.gz")[0].matrix.coeff(0, 0), 5.0);
  EXPECT_EQ(parse_matrices(packed, "K.mtx.gz")[0].name, "K");
  EXPECT_NE(refusal(packed.substr(0, 30), "K.mtx.gz").find("truncated"), std::string::npos);
  packed[20] = static_cast<char>(packed[20] ^ 0x55);
  EXPECT_NE(refusal(packed, "K.mtx.gz").find("K.mtx.gz: "), std::string::npos);
}

}  // namespace
}  // namespace kalfem
