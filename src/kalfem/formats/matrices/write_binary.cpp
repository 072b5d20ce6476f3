#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>

#include "kalfem/formats/hdf5/hdf5_file.hpp"
#include "kalfem/formats/matrices/writers.hpp"

namespace kalfem {
namespace {

using Eigen::Index;

/// Fortran's unformatted records in a given order of bytes.
class RecordWriter {
public:
  explicit RecordWriter(bool big_endian) : swap_(big_endian != (std::endian::native == std::endian::big)) {}

  template <typename T>
  void add(T value) {
    char bytes[sizeof(T)];
    std::memcpy(bytes, &value, sizeof(T));
    if (swap_) std::reverse(bytes, bytes + sizeof(T));
    record_.append(bytes, sizeof(T));
  }
  void add_text(const std::string& text, std::size_t width) {
    record_ += text;
    record_.append(width - text.size(), ' ');
  }
  void end_record() {
    const std::string content = std::move(record_);
    record_.clear();
    add(static_cast<std::int32_t>(content.size()));
    const std::string length = std::move(record_);
    record_.clear();
    file_ += length + content + length;
  }
  [[nodiscard]] const std::string& bytes() const { return file_; }

private:
  bool swap_;
  std::string record_, file_;
};

void add_op4(const ForeignMatrix& matrix, RecordWriter& writer) {
  const SparseMatrix& entries = matrix.matrix;
  for (const Index number : {entries.cols(), -entries.rows(), Index{is_symmetric(entries) ? 6 : 2}, Index{2}})
    writer.add(static_cast<std::int32_t>(number));
  writer.add_text(matrix.name, 8);
  writer.end_record();
  for (Index column = 0; column < entries.outerSize(); ++column) {
    const Index count = entries.col(column).nonZeros();
    if (count == 0) continue;
    // One string an entry: 2 words of header, 2 of number.
    for (const Index number : {column + 1, Index{0}, 4 * count}) writer.add(static_cast<std::int32_t>(number));
    for (SparseMatrix::InnerIterator it(entries, column); it; ++it) {
      writer.add(std::int32_t{3});
      writer.add(static_cast<std::int32_t>(it.row() + 1));
      writer.add(it.value());
    }
    writer.end_record();
  }
  for (const Index number : {entries.cols() + 1, Index{1}, Index{2}}) writer.add(static_cast<std::int32_t>(number));
  writer.add(1.0);
  writer.end_record();
}

Eigen::MatrixXd map_rows(const std::vector<MatrixDof>& dofs) {
  Eigen::MatrixXd rows(static_cast<Index>(dofs.size()), 2);
  for (Index i = 0; i < rows.rows(); ++i) {
    const auto& dof = dofs[static_cast<std::size_t>(i)];
    rows.row(i) << static_cast<double>(dof.node), dof.direction + 1;
  }
  return rows;
}

void add_hdf5(const ForeignMatrix& matrix, Hdf5File& file) {
  SparseMatrix entries = matrix.matrix;
  entries.makeCompressed();
  const std::string group = "/" + matrix.name;
  const Index count = entries.nonZeros();
  using Integers = Eigen::Map<const Eigen::VectorXi>;
  file.write(group + "/data", Eigen::Map<const Eigen::VectorXd>(entries.valuePtr(), count));
  file.write(group + "/indices", Integers(entries.innerIndexPtr(), count).cast<double>());
  file.write(group + "/indptr", Integers(entries.outerIndexPtr(), entries.outerSize() + 1).cast<double>());
  file.write(group + "/shape",
             Eigen::Vector2d(static_cast<double>(entries.rows()), static_cast<double>(entries.cols())));
  file.set_attribute(group, "format", std::string("csc"));
}

}  // namespace

std::string op4_bytes(const std::vector<ForeignMatrix>& matrices, bool big_endian) {
  RecordWriter writer(big_endian);
  for (const auto& matrix : matrices) add_op4(matrix, writer);
  return writer.bytes();
}

std::string hdf5_bytes(const std::vector<ForeignMatrix>& matrices, const Eigen::MatrixXd& basis,
                       const std::vector<std::string>& names) {
  Hdf5File file = Hdf5File::create_in_memory("matrices.h5");
  for (const auto& matrix : matrices) add_hdf5(matrix, file);
  if (!matrices.empty() && !matrices.front().dofs.empty())
    file.write_matrix("/dof_map", map_rows(matrices.front().dofs));
  if (!names.empty()) file.write_strings("/names", names);
  if (basis.size() > 0) file.write_matrix("/basis", basis);
  return file.bytes();
}

}  // namespace kalfem
