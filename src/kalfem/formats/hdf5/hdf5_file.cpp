// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/hdf5/hdf5_file.hpp"

#include <algorithm>
#include <array>
#include <atomic>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/regular_file.hpp"
#include "kalfem/formats/hdf5/hdf5_handle.hpp"

namespace kalfem {
namespace {

using RowMajorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// HDF5 prints nothing, and does nothing at the end of the process: there it would write again what the disk did not
/// take when a file was closed, and crash. Every file is closed by its owner.
void silence_hdf5() {
  static const herr_t first = H5dont_atexit();  // before all else, since it is of no use later
  static_cast<void>(first);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

/// Files that live in memory alone and grow by steps of 1 MB.
Hdf5Id memory_access() {
  Hdf5Id access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_fapl_core(access, std::size_t{1} << 20, 0);
  return access;
}

/// HDF5 knows a file in memory by a name, which must not be that of a file on the disk.
std::string memory_name() {
  static std::atomic<unsigned> count{0};
  return "/in memory/" + std::to_string(count++);
}

}  // namespace

Hdf5File::Hdf5File(std::unique_ptr<Handle> handle) : handle_(std::move(handle)) {}
Hdf5File::Hdf5File(Hdf5File&&) noexcept = default;
Hdf5File& Hdf5File::operator=(Hdf5File&&) noexcept = default;
Hdf5File::~Hdf5File() = default;

Hdf5File Hdf5File::create(const std::string& path) {
  silence_hdf5();
  auto handle = std::make_unique<Handle>(
      Handle{path, Hdf5Id(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), H5Fclose), 0});
  handle->require(handle->file.valid(), "create this file");
  return Hdf5File(std::move(handle));
}

Hdf5File Hdf5File::open(const std::string& path) {
  silence_hdf5();
  require_regular_file(path);
  auto handle =
      std::make_unique<Handle>(Handle{path, Hdf5Id(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose), 0});
  handle->require(handle->file.valid(), "open this file as HDF5");
  return Hdf5File(std::move(handle));
}

// The bytes become the image of a file in memory, so that compressed and piped input is read without a file on disk.
Hdf5File Hdf5File::open_bytes(std::string_view bytes, const std::string& source) {
  silence_hdf5();
  const Hdf5Id access = memory_access();
  // HDF5 copies the image; it is not written to.
  H5Pset_file_image(access, const_cast<char*>(bytes.data()), bytes.size());
  auto handle = std::make_unique<Handle>(
      Handle{source, Hdf5Id(H5Fopen(memory_name().c_str(), H5F_ACC_RDONLY, access), H5Fclose), 0});
  handle->require(handle->file.valid(), "open this file as HDF5");
  return Hdf5File(std::move(handle));
}

Hdf5File Hdf5File::create_in_memory(const std::string& name) {
  silence_hdf5();
  auto handle = std::make_unique<Handle>(
      Handle{name, Hdf5Id(H5Fcreate(memory_name().c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, memory_access()), H5Fclose), 0});
  handle->require(handle->file.valid(), "create a file in memory");
  return Hdf5File(std::move(handle));
}

std::string Hdf5File::bytes() const {
  H5Fflush(handle().file, H5F_SCOPE_GLOBAL);
  const ssize_t size = H5Fget_file_image(handle().file, nullptr, 0);
  handle().require(size >= 0, "take the bytes of this file");
  std::string image(static_cast<std::size_t>(size), '\0');
  handle().require(H5Fget_file_image(handle().file, image.data(), image.size()) >= 0, "take the bytes of this file");
  return image;
}

const Hdf5File::Handle& Hdf5File::handle() const {
  if (!handle_) throw InvalidInput("the HDF5 file was closed", "it cannot be used after closing", {});
  return *handle_;
}

// Closes in two steps, to report a full disk here: a destructor could not throw.
void Hdf5File::close() {
  if (!handle_) return;
  const auto closing = std::move(handle_);
  const bool flushed = H5Fflush(closing->file, H5F_SCOPE_GLOBAL) >= 0;
  closing->require(flushed && H5Fclose(closing->file.release()) >= 0, "finish writing this file");
}

void Hdf5File::write(const std::string& dataset, const Eigen::Ref<const Eigen::VectorXd>& values) {
  handle().write_numbers(dataset, {static_cast<hsize_t>(values.size())}, values.data());
}

void Hdf5File::write_matrix(const std::string& dataset, const Eigen::Ref<const Eigen::MatrixXd>& values) {
  const RowMajorMatrix by_rows = values;
  handle().write_numbers(dataset, {static_cast<hsize_t>(values.rows()), static_cast<hsize_t>(values.cols())},
                         by_rows.data());
}

void Hdf5File::write_rows(const std::string& dataset, const Eigen::Ref<const Eigen::VectorXd>& values,
                          Eigen::Index rows) {
  if (rows < 1 || values.size() % rows != 0)
    handle().fail(std::to_string(values.size()) + " values of '" + dataset + "' in " + std::to_string(rows) + " rows",
                  "rows must be of equal length");
  handle().write_numbers(dataset, {static_cast<hsize_t>(rows), static_cast<hsize_t>(values.size() / rows)},
                         values.data());
}

void Hdf5File::write_strings(const std::string& dataset, const std::vector<std::string>& values) {
  std::vector<const char*> texts;
  for (const auto& value : values) {
    if (value.find('\0') != std::string::npos)
      handle().fail("a text of '" + dataset + "' contains a zero byte", "HDF5 would end the text there");
    texts.push_back(value.c_str());
  }
  const Hdf5Id type = hdf5_text_type();
  const Hdf5Id id = handle().create_dataset(dataset, type, {values.size()});
  handle().require(values.empty() || H5Dwrite(id, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, texts.data()) >= 0,
                   "write '" + dataset + "'");
}

void Hdf5File::set_attribute(const std::string& object, const std::string& name, const std::string& value) {
  const char* text = value.c_str();
  handle().write_attribute(object, name, hdf5_text_type(), &text);
}

void Hdf5File::set_attribute(const std::string& object, const std::string& name, double value) {
  handle().write_attribute(object, name, H5T_NATIVE_DOUBLE, &value);
}

bool Hdf5File::contains(const std::string& object) const { return handle().contains(object); }

bool Hdf5File::has_attribute(const std::string& object, const std::string& name) const {
  return handle().contains(object) && H5Aexists(handle().object(object), name.c_str()) > 0;
}

// Visits all groups below the given one. The names come relative to it and get its path; sorting makes the order
// independent of the file.
std::vector<std::string> Hdf5File::datasets(const std::string& group) const {
  const Hdf5Id top = handle().object(group);
  std::vector<std::string> names;
  const auto collect = [](hid_t, const char* name, const H5O_info_t* info, void* found) -> herr_t {
    if (info->type == H5O_TYPE_DATASET) static_cast<std::vector<std::string>*>(found)->emplace_back(name);
    return 0;
  };
  const herr_t visited = H5Ovisit2(top, H5_INDEX_NAME, H5_ITER_INC, collect, &names, H5O_INFO_BASIC);
  handle().require(visited >= 0, "list '" + group + "'");
  for (auto& name : names) name.insert(0, group.ends_with('/') ? group : group + "/");
  std::sort(names.begin(), names.end());
  return names;
}

bool Hdf5File::holds_numbers(const std::string& dataset) const {
  const Hdf5Id id = handle().dataset(dataset);
  const H5T_class_t kind = H5Tget_class(Hdf5Id(H5Dget_type(id), H5Tclose));
  return kind == H5T_FLOAT || kind == H5T_INTEGER;
}

std::size_t Hdf5File::stored_bytes(const std::string& dataset) const {
  return H5Dget_storage_size(handle().dataset(dataset));
}

std::vector<Eigen::Index> Hdf5File::shape(const std::string& dataset) const {
  const Hdf5Id id = handle().dataset(dataset);
  const auto lengths = handle().lengths(Hdf5Id(H5Dget_space(id), H5Sclose), dataset);
  return {lengths.begin(), lengths.end()};
}

Eigen::VectorXd Hdf5File::read(const std::string& dataset) const {
  const auto lengths = shape(dataset);
  const bool one_line = lengths.size() < 2 || (lengths.size() == 2 && std::min(lengths[0], lengths[1]) == 1);
  if (!one_line)
    handle().fail("'" + dataset + "' is not a single column of numbers", "it has several rows and columns",
                  "name a column");
  const Hdf5Id id = handle().dataset(dataset);
  handle().require_numbers(Hdf5Id(H5Dget_type(id), H5Tclose), dataset);
  Eigen::VectorXd values(hdf5_count({lengths.begin(), lengths.end()}));
  handle().require(
      values.size() == 0 || H5Dread(id, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) >= 0,
      "read '" + dataset + "'");
  return values;
}

// HDF5 stores row by row, Eigen column by column. So a dataset is read as the transpose of its matrix and turned once
// in memory.
Eigen::MatrixXd Hdf5File::read_matrix(const std::string& dataset) const {
  return read_columns_as_rows(dataset).transpose();
}

Eigen::MatrixXd Hdf5File::read_columns_as_rows(const std::string& dataset) const {
  const auto lengths = shape(dataset);
  if (lengths.size() < 2) return read(dataset).transpose();
  if (lengths.size() > 2) {
    handle().fail("'" + dataset + "' has " + std::to_string(lengths.size()) + " dimensions",
                  "a matrix has two dimensions");
  }
  const Hdf5Id id = handle().dataset(dataset);
  handle().require_numbers(Hdf5Id(H5Dget_type(id), H5Tclose), dataset);
  Eigen::MatrixXd values(lengths[1], lengths[0]);  // rows lie side by side in the file
  handle().require(
      values.size() == 0 || H5Dread(id, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) >= 0,
      "read '" + dataset + "'");
  return values;
}

// Selects one column as a hyperslab: only its values are read, which matters in long records of many channels.
Eigen::VectorXd Hdf5File::read_column(const std::string& dataset, Eigen::Index column) const {
  const auto lengths = shape(dataset);
  if (lengths.size() != 2 || column < 0 || column >= lengths[1]) {
    const std::string columns = lengths.size() == 2 ? std::to_string(lengths[1]) + " columns" : "no columns";
    handle().fail("there is no column " + std::to_string(column) + " in '" + dataset + "'",
                  "it has " + columns + ", counted from 0");
  }
  const Hdf5Id id = handle().dataset(dataset);
  handle().require_numbers(Hdf5Id(H5Dget_type(id), H5Tclose), dataset);
  Eigen::VectorXd values(lengths[0]);
  if (values.size() == 0) return values;
  const std::array<hsize_t, 2> start{0, static_cast<hsize_t>(column)};
  const std::array<hsize_t, 2> extent{static_cast<hsize_t>(lengths[0]), 1};
  const Hdf5Id in_file(H5Dget_space(id), H5Sclose);
  const Hdf5Id in_memory(H5Screate_simple(1, extent.data(), nullptr), H5Sclose);
  H5Sselect_hyperslab(in_file, H5S_SELECT_SET, start.data(), nullptr, extent.data(), nullptr);
  handle().require(H5Dread(id, H5T_NATIVE_DOUBLE, in_memory, in_file, H5P_DEFAULT, values.data()) >= 0,
                   "read '" + dataset + "'");
  return values;
}

bool Hdf5File::is_complete(const std::string& dataset) const { return hdf5_is_complete(handle().dataset(dataset)); }

bool Hdf5File::lies_elsewhere(const std::string& dataset) const {
  return hdf5_lies_elsewhere(handle().object(dataset));
}

std::vector<std::string> Hdf5File::members(const std::string& dataset) const {
  const Hdf5Id id = handle().dataset(dataset), type(H5Dget_type(id), H5Tclose);
  if (H5Tget_class(type) != H5T_COMPOUND || shape(dataset).size() != 1) return {};
  std::vector<std::string> names;
  for (int i = 0; i < H5Tget_nmembers(type); ++i) {
    const auto kind = H5Tget_member_class(type, static_cast<unsigned>(i));
    if (kind != H5T_FLOAT && kind != H5T_INTEGER) continue;
    char* name = H5Tget_member_name(type, static_cast<unsigned>(i));
    if (name != nullptr) names.emplace_back(name);
    H5free_memory(name);
  }
  return names;
}

Eigen::VectorXd Hdf5File::read_member(const std::string& dataset, const std::string& member) const {
  const Hdf5Id id = handle().dataset(dataset), type(H5Tcreate(H5T_COMPOUND, sizeof(double)), H5Tclose);
  handle().require(H5Tinsert(type, member.c_str(), 0, H5T_NATIVE_DOUBLE) >= 0, "read '" + member + "'");
  Eigen::VectorXd values(shape(dataset).at(0));
  handle().require(values.size() == 0 || H5Dread(id, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) >= 0,
                   "read '" + member + "' of '" + dataset + "'");
  return values;
}

std::vector<std::string> Hdf5File::read_strings(const std::string& dataset) const {
  const Hdf5Id id = handle().dataset(dataset);
  return handle().strings(Hdf5Id(H5Dget_type(id), H5Tclose), Hdf5Id(H5Dget_space(id), H5Sclose), dataset,
                          [&](hid_t type, void* to) { return H5Dread(id, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, to); });
}

std::string Hdf5File::text_attribute(const std::string& object, const std::string& name) const {
  static_cast<void>(handle().attribute(object, name));  // one value
  return texts_attribute(object, name).front();
}

std::vector<std::string> Hdf5File::texts_attribute(const std::string& object, const std::string& name) const {
  const Hdf5Id owner = handle().object(object);
  const Hdf5Id id(H5Aopen(owner, name.c_str(), H5P_DEFAULT), H5Aclose);
  handle().require(id.valid(), "open attribute '" + name + "' of '" + object + "'");
  return handle().strings(Hdf5Id(H5Aget_type(id), H5Tclose), Hdf5Id(H5Aget_space(id), H5Sclose), name,
                          [&](hid_t type, void* to) { return H5Aread(id, type, to); });
}

double Hdf5File::number_attribute(const std::string& object, const std::string& name) const {
  const Hdf5Id id = handle().attribute(object, name);
  handle().require_numbers(Hdf5Id(H5Aget_type(id), H5Tclose), name);
  double value = 0.0;
  handle().require(H5Aread(id, H5T_NATIVE_DOUBLE, &value) >= 0, "read attribute '" + name + "'");
  return value;
}

Eigen::VectorXd Hdf5File::numbers_attribute(const std::string& object, const std::string& name) const {
  const Hdf5Id owner = handle().object(object);
  const Hdf5Id id(H5Aopen(owner, name.c_str(), H5P_DEFAULT), H5Aclose);
  handle().require(id.valid(), "open attribute '" + name + "' of '" + object + "'");
  handle().require_numbers(Hdf5Id(H5Aget_type(id), H5Tclose), name);
  Eigen::VectorXd values(hdf5_count(handle().lengths(Hdf5Id(H5Aget_space(id), H5Sclose), name)));
  handle().require(values.size() == 0 || H5Aread(id, H5T_NATIVE_DOUBLE, values.data()) >= 0,
                   "read attribute '" + name + "'");
  return values;
}

}  // namespace kalfem
