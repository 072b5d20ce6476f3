// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/hdf5/hdf5_handle.hpp"

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <limits>
#include <optional>
#include <string_view>

#include "kalfem/base/atomic_file.hpp"
#include "kalfem/base/invalid_input.hpp"

namespace kalfem {
namespace {

constexpr hsize_t compressed_from = 1024;  ///< shorter arrays are stored as they are [values]
constexpr hsize_t chunk_values = 65536;    ///< 512 KB: large enough to compress well, below the default chunk cache
constexpr unsigned gzip_level = 4;

/// The innermost entry of HDF5's error stack: the cause rather than its consequences.
std::string last_cause() {
  std::string cause;
  const auto first = [](unsigned, const H5E_error2_t* entry, void* text) -> herr_t {
    if (entry->desc) *static_cast<std::string*>(text) = entry->desc;
    return 1;
  };
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, first, &cause);
  H5Eclear2(H5E_DEFAULT);
  return cause.empty() ? "HDF5 gives no reason" : cause;
}

/// The system's error of writing in "file write failed: ..., errno = 28, error message = ...". A file that is read
/// cannot be opened for other reasons than a full disk.
std::optional<int> write_error(const std::string& cause) {
  constexpr std::string_view mark = "errno = ";
  const std::size_t at = cause.find(mark);
  if (at == std::string::npos) return std::nullopt;
  const int code = std::stoi(cause.substr(at + mark.size()));
  const bool full = code == ENOSPC || code == EDQUOT || code == EFBIG;
  return full || cause.starts_with("file write failed") ? std::optional(code) : std::nullopt;
}

/// Makes the groups on the way to a new object.
Hdf5Id link_creation() {
  Hdf5Id list(H5Pcreate(H5P_LINK_CREATE), H5Pclose);
  H5Pset_create_intermediate_group(list, 1);
  H5Pset_char_encoding(list, H5T_CSET_UTF8);
  return list;
}

/// Chunks of whole rows, compressed, for long arrays; the plain layout for short ones. Without times of creation, so
/// that files of equal content are equal.
Hdf5Id dataset_creation(const std::vector<hsize_t>& lengths) {
  Hdf5Id list(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_obj_track_times(list, false);
  if (hdf5_count(lengths) < compressed_from || H5Zfilter_avail(H5Z_FILTER_DEFLATE) <= 0) return list;
  std::vector<hsize_t> chunk = lengths;
  hsize_t row = 1;
  for (std::size_t d = chunk.size(); d-- > 1;) {
    chunk[d] = std::min(chunk[d], std::max<hsize_t>(1, chunk_values / row));
    row *= chunk[d];
  }
  chunk[0] = std::clamp<hsize_t>(chunk_values / row, 1, chunk[0]);
  H5Pset_chunk(list, static_cast<int>(chunk.size()), chunk.data());
  H5Pset_shuffle(list);
  H5Pset_deflate(list, gzip_level);
  return list;
}

/// Text out of a buffer of fixed-length strings, padded with zeros or blanks.
std::vector<std::string> fixed_strings(const std::vector<char>& bytes, std::size_t width, std::size_t number) {
  std::vector<std::string> strings(number);
  for (std::size_t i = 0; i < number; ++i) {
    std::string& text = strings[i].assign(bytes.data() + i * width, width);
    text.resize(std::min(text.find('\0'), text.size()));
    text.resize(text.find_last_not_of(' ') + 1);
  }
  return strings;
}

}  // namespace

hsize_t hdf5_count(const std::vector<hsize_t>& lengths) {
  hsize_t product = 1;
  for (const hsize_t length : lengths) product *= length;
  return product;
}

namespace {

/// HDF5 looks for the file of a link beside the file of the link, and in the current folder; it opens what it finds.
herr_t refuse_other_than_files(const char* file, const char*, const char* linked, const char*, unsigned*, hid_t,
                               void*) {
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::path name(linked), folder = fs::path(file).parent_path();
  for (const fs::path& place : {name, folder / name, folder / name.filename()})
    if (fs::exists(place, error) && !fs::is_regular_file(place, error)) return -1;
  return 0;
}

}  // namespace

hid_t hdf5_link_access() {
  static const hid_t access = [] {
    const hid_t made = H5Pcreate(H5P_LINK_ACCESS);
    H5Pset_elink_cb(made, refuse_other_than_files, nullptr);
    return made;
  }();
  return access;
}

bool hdf5_lies_elsewhere(hid_t dataset) {
  const Hdf5Id creation(H5Dget_create_plist(dataset), H5Pclose);
  return H5Pget_layout(creation) == H5D_VIRTUAL || H5Pget_external_count(creation) > 0;
}

bool hdf5_is_complete(hid_t dataset) {
  if (hdf5_lies_elsewhere(dataset)) return false;
  const Hdf5Id space(H5Dget_space(dataset), H5Sclose), creation(H5Dget_create_plist(dataset), H5Pclose);
  const auto count = H5Sget_simple_extent_npoints(space);
  if (count <= 0) return true;
  // A damaged length may state more values than any file holds: gzip packs to a thousandth at best.
  const Hdf5Id file(H5Iget_file_id(dataset), H5Fclose);
  hsize_t bytes = 0;
  if (H5Fget_filesize(file, &bytes) < 0 || static_cast<hsize_t>(count) / 1100 > bytes) return false;
  const hsize_t stored = H5Dget_storage_size(dataset);
  if (H5Pget_layout(creation) != H5D_CHUNKED) return stored > 0 && stored <= bytes;
  const int rank = H5Sget_simple_extent_ndims(space);
  std::vector<hsize_t> lengths(static_cast<std::size_t>(rank)), chunk(lengths.size());
  H5Sget_simple_extent_dims(space, lengths.data(), nullptr);
  if (H5Pget_chunk(creation, rank, chunk.data()) != rank) return false;
  hsize_t expected = 1, found = 0;
  for (std::size_t i = 0; i < lengths.size(); ++i)
    expected *= (lengths[i] + chunk[i] - 1) / std::max<hsize_t>(1, chunk[i]);
  return H5Dget_num_chunks(dataset, space, &found) >= 0 && found == expected;
}

Hdf5Id hdf5_text_type() {
  Hdf5Id type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type, H5T_VARIABLE);
  H5Tset_cset(type, H5T_CSET_UTF8);
  return type;
}

void refuse_hdf5(const std::string& path, std::string what, std::string why, std::string fix) {
  Issue issue{{path, 0}, std::move(what), std::move(why), std::move(fix)};
  throw InvalidInput(std::move(issue));
}

void Hdf5File::Handle::require(bool done, const std::string& action) const {
  if (done) return;
  const std::string cause = last_cause();
  if (const auto code = write_error(cause)) fail_to_write(path, *code, NeededSpace{asked, true});
  fail("cannot " + action, cause);
}

void Hdf5File::Handle::check_name(const std::string& name) const {
  if (name.empty() || name.back() == '/' || name.find('\0') != std::string::npos) {
    fail("'" + name + "' is not a name for a dataset", "a dataset needs a path such as /group/name");
  }
}

bool Hdf5File::Handle::contains(const std::string& object) const {
  // H5Lexists asks for one link at a time: every group on the way must be there.
  for (std::size_t slash = object.find('/', 1); slash != std::string::npos; slash = object.find('/', slash + 1)) {
    if (H5Lexists(file, object.substr(0, slash).c_str(), hdf5_link_access()) <= 0) return false;
  }
  return object == "/" || (H5Lexists(file, object.c_str(), hdf5_link_access()) > 0 &&
                           H5Oexists_by_name(file, object.c_str(), hdf5_link_access()) > 0);
}

Hdf5Id Hdf5File::Handle::object(const std::string& name) const {
  if (!contains(name)) fail("there is no '" + name + "'", "a dataset or group of that name is required");
  Hdf5Id id(H5Oopen(file, name.c_str(), hdf5_link_access()), H5Oclose);
  require(id.valid(), "open '" + name + "'");
  return id;
}

Hdf5Id Hdf5File::Handle::dataset(const std::string& name) const {
  Hdf5Id id = object(name);
  if (H5Iget_type(id) != H5I_DATASET) fail("'" + name + "' is a group", "a dataset is required");
  if (hdf5_lies_elsewhere(id))
    fail("the values of '" + name + "' lie in another file", "only what the file itself holds is read",
         "copy the dataset into this file (h5repack)");
  return id;
}

void Hdf5File::Handle::require_numbers(hid_t type, const std::string& name) const {
  const H5T_class_t kind = H5Tget_class(type);
  if (kind != H5T_FLOAT && kind != H5T_INTEGER) fail("'" + name + "' does not hold numbers", "numbers are required");
}

std::vector<hsize_t> Hdf5File::Handle::lengths(hid_t space, const std::string& name) const {
  const int rank = H5Sget_simple_extent_ndims(space);
  require(rank >= 0, "read the size of '" + name + "'");
  std::vector<hsize_t> result(static_cast<std::size_t>(rank));
  H5Sget_simple_extent_dims(space, result.data(), nullptr);
  hsize_t room = std::numeric_limits<Eigen::Index>::max() / sizeof(double);
  for (const hsize_t length : result) {
    if (length > room) fail("'" + name + "' is too large", "it must fit into memory");
    if (length > 0) room /= length;
  }
  return result;
}

Hdf5Id Hdf5File::Handle::create_dataset(const std::string& name, hid_t type,
                                        const std::vector<hsize_t>& lengths) const {
  check_name(name);
  if (contains(name)) fail("'" + name + "' exists already", "a dataset can be written only once");
  const Hdf5Id space(H5Screate_simple(static_cast<int>(lengths.size()), lengths.data(), nullptr), H5Sclose);
  const Hdf5Id created(
      H5Dcreate2(file, name.c_str(), type, space, link_creation(), dataset_creation(lengths), H5P_DEFAULT), H5Dclose);
  require(created.valid(), "create '" + name + "'");
  return Hdf5Id(H5Dopen2(file, name.c_str(), H5P_DEFAULT), H5Dclose);
}

void Hdf5File::Handle::write_numbers(const std::string& name, const std::vector<hsize_t>& lengths,
                                     const double* values) const {
  const Hdf5Id id = create_dataset(name, H5T_NATIVE_DOUBLE, lengths);
  asked += hdf5_count(lengths) * sizeof(double);
  require(hdf5_count(lengths) == 0 || H5Dwrite(id, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) >= 0,
          "write '" + name + "'");
}

void Hdf5File::Handle::write_attribute(const std::string& object_name, const std::string& name, hid_t type,
                                       const void* value) const {
  const Hdf5Id owner = object(object_name);
  if (H5Aexists(owner, name.c_str()) > 0) H5Adelete(owner, name.c_str());
  const Hdf5Id space(H5Screate(H5S_SCALAR), H5Sclose);
  const Hdf5Id attribute(H5Acreate2(owner, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  require(attribute.valid() && H5Awrite(attribute, type, value) >= 0,
          "write attribute '" + name + "' of '" + object_name + "'");
}

Hdf5Id Hdf5File::Handle::attribute(const std::string& object_name, const std::string& name) const {
  const Hdf5Id owner = object(object_name);
  if (H5Aexists(owner, name.c_str()) <= 0)
    fail("'" + object_name + "' has no attribute '" + name + "'", "it is required");
  Hdf5Id id(H5Aopen(owner, name.c_str(), H5P_DEFAULT), H5Aclose);
  require(id.valid(), "open attribute '" + name + "' of '" + object_name + "'");
  const Hdf5Id space(H5Aget_space(id), H5Sclose);
  if (H5Sget_simple_extent_npoints(space) != 1)
    fail("attribute '" + name + "' is a list of values", "one value is required");
  return id;
}

// Strings of variable length come as pointers that HDF5 allocates and must take back; those of fixed length as one
// block of bytes.
std::vector<std::string> Hdf5File::Handle::strings(hid_t stored, hid_t space, const std::string& name,
                                                   const std::function<herr_t(hid_t, void*)>& read) const {
  if (H5Tget_class(stored) != H5T_STRING) fail("'" + name + "' does not hold text", "text is required");
  const std::size_t number = hdf5_count(lengths(space, name));
  if (number == 0) return {};
  const Hdf5Id type(H5Tcopy(stored), H5Tclose);
  if (H5Tis_variable_str(type) <= 0) {
    std::vector<char> bytes(number * H5Tget_size(type));
    require(read(type, bytes.data()) >= 0, "read '" + name + "'");
    return fixed_strings(bytes, H5Tget_size(type), number);
  }
  std::vector<char*> texts(number, nullptr);
  require(read(type, texts.data()) >= 0, "read '" + name + "'");
  std::vector<std::string> result;
  for (const char* text : texts) result.emplace_back(text ? text : "");
  H5Dvlen_reclaim(type, space, H5P_DEFAULT, texts.data());
  return result;
}

}  // namespace kalfem
