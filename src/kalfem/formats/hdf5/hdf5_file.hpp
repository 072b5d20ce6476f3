// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace kalfem {

/// One HDF5 file, open for writing (`create`) or for reading (`open`).
///
/// Objects are named by their path from the root, "/estimate/frame.p5/displacement"; groups on the way are made when
/// they are missing. A matrix is stored row by row, so one row of the file is one row of the matrix; long arrays are
/// chunked and compressed (shuffle + gzip level 4). Numbers are stored as 64-bit floats exactly as they are given,
/// NaN included; text as UTF-8.
///
/// Every failure (no such file, not HDF5, no such dataset, wrong kind, disk full) throws InvalidInput with the name of
/// the file and the reason. HDF5's own messages on stderr are switched off from the first use on.
/// Not for use from several threads at once.
class Hdf5File {
public:
  /// A new, empty file; one of that name is replaced.
  static Hdf5File create(const std::string& path);
  /// An existing file, read only.
  static Hdf5File open(const std::string& path);
  /// The bytes of an existing file, read only; `source` names it in messages.
  static Hdf5File open_bytes(std::string_view bytes, const std::string& source);
  /// A new, empty file in memory; `bytes` gives what would stand on the disk.
  static Hdf5File create_in_memory(const std::string& name);

  Hdf5File(Hdf5File&&) noexcept;
  Hdf5File& operator=(Hdf5File&&) noexcept;
  /// Closes without a word; call `close` to learn whether everything reached the disk.
  ~Hdf5File();

  /// Flushes, and the bytes of the file as they are then.
  [[nodiscard]] std::string bytes() const;

  /// Flushes and closes; using the file afterwards throws. Closing twice does nothing.
  void close();

  /// @name Writing
  /// A name can be written once.
  ///@{
  void write(const std::string& dataset, const Eigen::Ref<const Eigen::VectorXd>& values);
  void write_matrix(const std::string& dataset, const Eigen::Ref<const Eigen::MatrixXd>& values);
  void write_strings(const std::string& dataset, const std::vector<std::string>& values);
  /// A matrix that is stored already row by row, rows x columns.
  void write_rows(const std::string& dataset, const Eigen::Ref<const Eigen::VectorXd>& values, Eigen::Index rows);
  /// Makes a dataset of one dimension an axis: a dimension scale, which netCDF-4 and xarray take for a coordinate. Its
  /// name is the last part of the path.
  void make_axis(const std::string& dataset);
  /// An axis of the integers from 0 to `count` - 1.
  void write_axis(const std::string& dataset, Eigen::Index count);
  /// Names the dimensions of a dataset by axes, one each in their order. Once a dataset.
  void set_axes(const std::string& dataset, const std::vector<std::string>& axes);
  /// Attaches a value to an existing dataset or group ("/" for the file itself); an old value is replaced.
  void set_attribute(const std::string& object, const std::string& name, const std::string& value);
  void set_attribute(const std::string& object, const std::string& name, double value);
  ///@}

  /// @name Reading
  /// Integers and floats of any width are read as double.
  ///@{
  [[nodiscard]] bool contains(const std::string& object) const;
  [[nodiscard]] bool has_attribute(const std::string& object, const std::string& name) const;
  /// Paths of all datasets below a group, sorted.
  [[nodiscard]] std::vector<std::string> datasets(const std::string& group = "/") const;
  /// Whether a dataset holds integers or floats.
  [[nodiscard]] bool holds_numbers(const std::string& dataset) const;
  /// Whether the file holds every value of a dataset; HDF5 reads those that it does not as zeros.
  [[nodiscard]] bool is_complete(const std::string& dataset) const;
  /// Whether a dataset's values lie in other files; reading it then throws.
  [[nodiscard]] bool lies_elsewhere(const std::string& dataset) const;
  /// Names of the numbers in each record of a 1-D dataset of records; empty where it holds none.
  [[nodiscard]] std::vector<std::string> members(const std::string& dataset) const;
  /// One of them, of all records.
  [[nodiscard]] Eigen::VectorXd read_member(const std::string& dataset, const std::string& member) const;
  /// Bytes that the values of a dataset take in the file, compressed as they are; 0 where none were written.
  [[nodiscard]] std::size_t stored_bytes(const std::string& dataset) const;
  /// Lengths along each dimension; empty for a scalar.
  [[nodiscard]] std::vector<Eigen::Index> shape(const std::string& dataset) const;
  /// A scalar, a 1-D dataset, or a 2-D one with a single row or column.
  [[nodiscard]] Eigen::VectorXd read(const std::string& dataset) const;
  /// A 2-D dataset; a 1-D one is one column.
  [[nodiscard]] Eigen::MatrixXd read_matrix(const std::string& dataset) const;
  /// The same with each column of the dataset as a row, samples x channels as channels x samples.
  [[nodiscard]] Eigen::MatrixXd read_columns_as_rows(const std::string& dataset) const;
  /// Each value once, in blocks of a 1-D or 2-D dataset: `visit(first row, first column, block)`, where the block's
  /// rows are columns of the dataset. Holds one block at a time.
  using BlockVisitor = std::function<void(Eigen::Index, Eigen::Index, const Eigen::MatrixXd&)>;
  void read_blocks(const std::string& dataset, const BlockVisitor& visit) const;
  /// Columns of these numbers (0-based), in their order, as rows; the others are not kept.
  [[nodiscard]] Eigen::MatrixXd read_columns(const std::string& dataset,
                                             const std::vector<Eigen::Index>& columns) const;
  /// Column `column` (0-based) of a 2-D dataset, without reading the others.
  [[nodiscard]] Eigen::VectorXd read_column(const std::string& dataset, Eigen::Index column) const;
  [[nodiscard]] std::vector<std::string> read_strings(const std::string& dataset) const;
  [[nodiscard]] std::string text_attribute(const std::string& object, const std::string& name) const;
  /// An attribute of any number of texts.
  [[nodiscard]] std::vector<std::string> texts_attribute(const std::string& object, const std::string& name) const;
  [[nodiscard]] double number_attribute(const std::string& object, const std::string& name) const;
  /// An attribute of any number of values.
  [[nodiscard]] Eigen::VectorXd numbers_attribute(const std::string& object, const std::string& name) const;
  ///@}

private:
  struct Handle;
  explicit Hdf5File(std::unique_ptr<Handle> handle);
  [[nodiscard]] const Handle& handle() const;

  std::unique_ptr<Handle> handle_;
};

}  // namespace kalfem
