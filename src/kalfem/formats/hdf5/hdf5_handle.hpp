// SPDX-License-Identifier: Apache-2.0
#pragma once

// Inside of readers of HDF5 only: everything that needs the C interface of HDF5.

#include <hdf5.h>

#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "kalfem/formats/hdf5/hdf5_file.hpp"

namespace kalfem {

/// Owns one HDF5 identifier of whatever kind.
class Hdf5Id {
public:
  Hdf5Id(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  Hdf5Id(Hdf5Id&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Hdf5Id& operator=(Hdf5Id&&) = delete;
  ~Hdf5Id() {
    if (id_ >= 0) close_(id_);
  }
  operator hid_t() const { return id_; }  // NOLINT(google-explicit-constructor): stands for the identifier in C calls
  [[nodiscard]] bool valid() const { return id_ >= 0; }
  hid_t release() { return std::exchange(id_, -1); }

private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

/// Number of values of an array with these lengths.
hsize_t hdf5_count(const std::vector<hsize_t>& lengths);

/// Whether every chunk of a dataset is in the file. Where one is missing, HDF5 gives fill values without a word.
bool hdf5_is_complete(hid_t dataset);

/// How links are followed: those to another file only where that is a regular file.
hid_t hdf5_link_access();

/// Whether the values of a dataset lie in other files (external storage, a virtual dataset). They are not read: HDF5
/// opens these files by itself, whatever stands there.
bool hdf5_lies_elsewhere(hid_t dataset);

/// Text of any length in UTF-8.
Hdf5Id hdf5_text_type();

/// Throws InvalidInput about a file.
[[noreturn]] void refuse_hdf5(const std::string& path, std::string what, std::string why, std::string fix);

/// An open file and what can be done with it; failures throw InvalidInput with its path.
struct Hdf5File::Handle {
  std::string path;
  Hdf5Id file;
  mutable std::uintmax_t asked = 0;  ///< bytes of numbers that were given to be written, before compression

  [[noreturn]] void fail(std::string what, std::string why, std::string fix = {}) const {
    refuse_hdf5(path, std::move(what), std::move(why), std::move(fix));
  }
  /// Throws what HDF5 holds against `action` when it failed; WriteFailure where the disk takes no more.
  void require(bool done, const std::string& action) const;
  void check_name(const std::string& name) const;
  [[nodiscard]] bool contains(const std::string& object) const;
  [[nodiscard]] Hdf5Id object(const std::string& name) const;
  [[nodiscard]] Hdf5Id dataset(const std::string& name) const;
  void require_numbers(hid_t type, const std::string& name) const;
  [[nodiscard]] std::vector<hsize_t> lengths(hid_t space, const std::string& name) const;
  [[nodiscard]] Hdf5Id create_dataset(const std::string& name, hid_t type, const std::vector<hsize_t>& lengths) const;
  void write_numbers(const std::string& name, const std::vector<hsize_t>& lengths, const double* values) const;
  void write_attribute(const std::string& object_name, const std::string& name, hid_t type, const void* value) const;
  /// An attribute of one value.
  [[nodiscard]] Hdf5Id attribute(const std::string& object_name, const std::string& name) const;
  /// Strings of fixed or variable length; `read(type, buffer)` is H5Dread or H5Aread of the object in hand.
  [[nodiscard]] std::vector<std::string> strings(hid_t stored, hid_t space, const std::string& name,
                                                 const std::function<herr_t(hid_t, void*)>& read) const;
};

}  // namespace kalfem
