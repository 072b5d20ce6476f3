// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/vtu.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "base/scratch_folder.hpp"
#include "kalfem/base/invalid_input.hpp"

namespace kalfem {
namespace {

namespace fs = std::filesystem;

class VtuFiles : public testing::Test {
protected:
  static std::string content(const fs::path& path) {
    std::ifstream stream(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }

  ScratchFolder folder_{"vtu"};
};

/// A quadrilateral, a triangle, a line and a point on five nodes; the line belongs to two regions, the point to none.
Mesh small_mesh() {
  Mesh mesh;
  mesh.node_ids = {10, 20, 30, 40, 1LL << 40};
  mesh.nodes = Eigen::Matrix3Xd::Random(3, 5);
  mesh.add_cell(CellShape::quadrilateral4, 1, std::vector<Eigen::Index>{0, 1, 2, 3});
  mesh.add_cell(CellShape::triangle3, 2, std::vector<Eigen::Index>{1, 4, 2});
  mesh.add_cell(CellShape::line2, 3, std::vector<Eigen::Index>{0, 4});
  mesh.add_cell(CellShape::point1, 4, std::vector<Eigen::Index>{3});
  mesh.regions = {{"beam", {2}}, {"plate", {0, 1}}, {"upper", {2}}};
  return mesh;
}

/// What stands between the quotation marks of an attribute of an XML tag.
std::string attribute(const std::string& tag, const std::string& name) {
  const auto begin = tag.find(" " + name + "=\"");
  if (begin == std::string::npos) return "";
  const auto from = begin + name.size() + 3;
  return tag.substr(from, tag.find('"', from) - from);
}

/// Reads the appended arrays of a file as the format describes them.
class AppendedArrays {
public:
  explicit AppendedArrays(const std::string& text) : text_(text) {
    data_ = text.find('_', text.find("<AppendedData encoding=\"raw\">")) + 1;
  }

  std::string tag(const std::string& name) const {
    for (std::size_t at = 0; (at = text_.find("<DataArray", at)) < data_; ++at) {
      const std::string found = text_.substr(at, text_.find('>', at) - at + 1);
      if (attribute(found, "Name") == name) return found;
    }
    return "";
  }

  template <typename Number>
  std::vector<Number> values(const std::string& name, const std::string& type) const {
    EXPECT_EQ(attribute(tag(name), "type"), type) << name;
    const std::size_t at = data_ + std::stoul(attribute(tag(name), "offset"));
    std::uint64_t size = 0;
    std::memcpy(&size, text_.data() + at, sizeof size);
    EXPECT_LE(at + sizeof size + size, text_.find("\n</AppendedData>", at));
    std::vector<Number> result(size / sizeof(Number));
    if (size > 0) std::memcpy(result.data(), text_.data() + at + sizeof size, size);
    return result;
  }

private:
  const std::string& text_;
  std::size_t data_ = 0;
};

std::vector<double> numbers_of(const Eigen::MatrixXd& matrix) { return {matrix.data(), matrix.data() + matrix.size()}; }

TEST_F(VtuFiles, TheArraysReadBackAsTheMesh) {
  const Mesh mesh = small_mesh();
  const Eigen::MatrixXd displacement = Eigen::MatrixXd::Random(3, 5), temperature = Eigen::MatrixXd::Random(1, 5);
  write_vtu(folder_ / "new" / "a.vtu", mesh, {{"displacement", displacement}, {"temperature <\"K\">", temperature}});
  const std::string text = content(folder_ / "new" / "a.vtu");
  EXPECT_NE(text.find("header_type=\"UInt64\""), std::string::npos);
  EXPECT_NE(text.find("<Piece NumberOfPoints=\"5\" NumberOfCells=\"4\">"), std::string::npos);
  const AppendedArrays arrays(text);
  EXPECT_EQ(arrays.values<double>("points", "Float64"), numbers_of(mesh.nodes));
  EXPECT_EQ(arrays.values<double>("displacement", "Float64"), numbers_of(displacement));
  EXPECT_EQ(attribute(arrays.tag("displacement"), "NumberOfComponents"), "3");
  EXPECT_EQ(arrays.values<double>("temperature &lt;&quot;K&quot;&gt;", "Float64"), numbers_of(temperature));
  EXPECT_EQ(arrays.values<std::int64_t>("node", "Int64"), mesh.node_ids);
  EXPECT_EQ(arrays.values<std::int64_t>("connectivity", "Int64"),
            (std::vector<std::int64_t>{0, 1, 2, 3, 1, 4, 2, 0, 4, 3}));
  EXPECT_EQ(arrays.values<std::int64_t>("offsets", "Int64"), (std::vector<std::int64_t>{4, 7, 9, 10}));
  EXPECT_EQ(arrays.values<std::uint8_t>("types", "UInt8"), (std::vector<std::uint8_t>{9, 5, 3, 1}));
  EXPECT_EQ(arrays.values<std::int64_t>("cell", "Int64"), (std::vector<std::int64_t>{1, 2, 3, 4}));
  EXPECT_EQ(arrays.values<std::int32_t>("region", "Int32"), (std::vector<std::int32_t>{1, 1, 0, -1}));
  EXPECT_NE(text.find("NumberOfTuples=\"3\" format=\"ascii\">\n98 101 97 109 0\n"), std::string::npos);  // "beam"
}

TEST_F(VtuFiles, AMeshWithoutCellsOrRegionsCanBeWritten) {
  write_vtu(folder_ / "empty.vtu", Mesh{}, {});
  const std::string text = content(folder_ / "empty.vtu");
  EXPECT_EQ(AppendedArrays(text).values<double>("points", "Float64").size(), 0u);
  EXPECT_EQ(text.find("FieldData"), std::string::npos);
}

TEST_F(VtuFiles, RefusesFieldsThatDoNotFit) {
  const Eigen::MatrixXd good = Eigen::MatrixXd::Zero(3, 5);
  try {
    write_vtu(folder_ / "a.vtu", small_mesh(),
              {{"a", Eigen::MatrixXd::Zero(3, 4)}, {"", good}, {"b", good}, {"b", good}});
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_EQ(error.issues().size(), 3u);
  }
  EXPECT_FALSE(fs::exists(folder_ / "a.vtu"));
}

TEST_F(VtuFiles, ACollectionNamesItsFilesWithTheirTimes) {
  write_pvd(folder_ / "run.pvd", {{0.1, "a.vtu"}, {2.5e-5, "b & c.vtu"}});
  const std::string text = content(folder_ / "run.pvd");
  EXPECT_NE(text.find("<VTKFile type=\"Collection\""), std::string::npos);
  EXPECT_NE(text.find("<DataSet timestep=\"0.1\" part=\"0\" file=\"a.vtu\"/>"), std::string::npos);
  EXPECT_NE(text.find("<DataSet timestep=\"2.5e-05\" part=\"0\" file=\"b &amp; c.vtu\"/>"), std::string::npos);
  EXPECT_THROW(write_pvd(folder_ / "run.pvd", {{std::nan(""), "a.vtu"}}), InvalidInput);
}

}  // namespace
}  // namespace kalfem
