// SPDX-License-Identifier: Apache-2.0
// MATLAB files of version 7.3 are HDF5 files: variables are datasets, structures are groups, and cells and arrays of
// structures hold references to datasets of the group #refs#. Attributes tell the classes.

#include <algorithm>
#include <array>
#include <functional>
#include <numeric>

#include "kalfem/base/text.hpp"
#include "kalfem/formats/hdf5/hdf5_handle.hpp"
#include "kalfem/formats/matlab/matlab_values.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Kind = MatlabValue::Kind;

constexpr int deepest = 16;                   ///< structures within structures
constexpr std::size_t most_values = 200'000;  ///< cells and fields of a file, which may refer to one another

MatlabValue of_kind(Kind kind) {
  MatlabValue value;
  value.kind = kind;
  return value;
}

MatlabValue other(std::string what) {
  MatlabValue value;
  value.what = std::move(what);
  return value;
}

bool has_attribute(hid_t object, const char* name) { return H5Aexists(object, name) > 0; }

/// A text of fixed length, with or without a zero at its end, or of variable length. Empty where there is none.
std::string text_attribute(hid_t object, const char* name) {
  if (!has_attribute(object, name)) return {};
  const Hdf5Id attribute(H5Aopen(object, name, H5P_DEFAULT), H5Aclose);
  if (!attribute.valid()) return {};
  const Hdf5Id type(H5Aget_type(attribute), H5Tclose), space(H5Aget_space(attribute), H5Sclose);
  if (!type.valid() || H5Tget_class(type) != H5T_STRING || H5Sget_simple_extent_npoints(space) != 1) return {};
  if (H5Tis_variable_str(type) > 0) {
    char* text = nullptr;
    if (H5Aread(attribute, type, &text) < 0 || text == nullptr) return {};
    std::string copy(text);
    H5Dvlen_reclaim(type, space, H5P_DEFAULT, &text);
    return copy;
  }
  std::string text(H5Tget_size(type), '\0');
  if (H5Aread(attribute, type, text.data()) < 0) return {};
  text.resize(std::min(text.find('\0'), text.size()));
  return text;
}

std::vector<std::string> names_in(hid_t group) {
  std::vector<std::string> names;
  const auto collect = [](hid_t, const char* name, const H5L_info_t*, void* all) -> herr_t {
    static_cast<std::vector<std::string>*>(all)->emplace_back(name);
    return 0;
  };
  H5Literate(group, H5_INDEX_NAME, H5_ITER_INC, nullptr, collect, &names);
  return names;
}

/// MATLAB's lengths: HDF5 counts the other way round. A single length is that of a column.
std::vector<Index> lengths_of(hid_t space) {
  const int rank = std::max(0, H5Sget_simple_extent_ndims(space));
  std::vector<hsize_t> lengths(static_cast<std::size_t>(rank));
  H5Sget_simple_extent_dims(space, lengths.data(), nullptr);
  return matlab_lengths({lengths.rbegin(), lengths.rend()});
}

/// The type of complex numbers, of which one part is taken.
Hdf5Id part_type(const char* part) {
  Hdf5Id type(H5Tcreate(H5T_COMPOUND, sizeof(double)), H5Tclose);
  H5Tinsert(type, part, 0, H5T_NATIVE_DOUBLE);
  return type;
}

bool is_complex(hid_t type) {
  return H5Tget_class(type) == H5T_COMPOUND && H5Tget_nmembers(type) == 2 && H5Tget_member_index(type, "real") >= 0 &&
         H5Tget_member_index(type, "imag") >= 0;
}

class Reader {
public:
  Reader(const std::filesystem::path& path, UnpackedBudget& budget)
      : path_(path.string()),
        budget_(budget),
        checked_(Hdf5File::open(path_)),
        file_(H5Fopen(path_.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose) {
    std::error_code ignored;
    bytes_ = std::filesystem::file_size(path, ignored);
  }

  MatlabContents read() {
    const auto names = names_in(file_);
    if (names.empty()) note("its list of variables is empty or damaged");
    for (const auto& name : names) {
      if (name.starts_with('#')) continue;  // what the variables refer to
      variable_ = name;
      contents_.variables.push_back({valid_utf8(name), member(file_, name, 0)});
    }
    return std::move(contents_);
  }

private:
  void note(const std::string& words) { contents_.skipped.push_back(path_ + ": " + words); }

  MatlabValue member(hid_t group, const std::string& name, int depth) {
    const Hdf5Id object(H5Oopen(group, name.c_str(), hdf5_link_access()), H5Oclose);
    return object.valid() ? value_of(object, depth) : other("damaged");
  }

  MatlabValue value_of(hid_t object, int depth) {
    if (depth > deepest || ++values_ > most_values) return other("nested too deeply, or one of too many");
    const std::string kind = text_attribute(object, "MATLAB_class");
    if (has_attribute(object, "MATLAB_object_decode"))
      return other("a MATLAB object of class " + (kind.empty() ? "unknown" : valid_utf8(kind)) +
                   ": save it as an array");
    if (has_attribute(object, "MATLAB_sparse")) return other("a sparse matrix");
    if (kind == "function_handle") return other("a function");
    switch (H5Iget_type(object)) {
      case H5I_GROUP:
        return structure(object, depth);
      case H5I_DATASET:
        return array(object, kind, depth);
      default:
        return other("neither a dataset nor a group");
    }
  }

  /// A dataset of references without a class holds a field of an array of structures, one reference an element.
  MatlabValue structure(hid_t group, int depth) {
    auto value = of_kind(Kind::structure);
    value.elements.resize(1);
    for (const auto& name : names_in(group)) {
      const Hdf5Id object(H5Oopen(group, name.c_str(), hdf5_link_access()), H5Oclose);
      if (object.valid() && is_field_of_array(object)) {
        std::size_t i = 0;
        for (auto& each : referred(object, depth)) {
          if (i == value.elements.size()) value.elements.emplace_back();
          value.elements[i++].push_back({valid_utf8(name), std::move(each)});
        }
      } else {
        value.elements.front().push_back(
            {valid_utf8(name), object.valid() ? value_of(object, depth + 1) : other("damaged")});
      }
    }
    return value;
  }

  static bool is_field_of_array(hid_t object) {
    if (H5Iget_type(object) != H5I_DATASET || has_attribute(object, "MATLAB_class")) return false;
    const Hdf5Id type(H5Dget_type(object), H5Tclose);
    return type.valid() && H5Tget_class(type) == H5T_REFERENCE;
  }

  std::vector<MatlabValue> referred(hid_t dataset, int depth) {
    if (hdf5_lies_elsewhere(dataset)) return {1, other("stored in another file")};
    const Hdf5Id space(H5Dget_space(dataset), H5Sclose);
    const auto count = H5Sget_simple_extent_npoints(space);
    if (count <= 0) return {};
    if (static_cast<std::size_t>(count) > most_values || !is_plausible(count)) return {1, other("damaged")};
    std::vector<hobj_ref_t> references(static_cast<std::size_t>(count));
    if (H5Dread(dataset, H5T_STD_REF_OBJ, H5S_ALL, H5S_ALL, H5P_DEFAULT, references.data()) < 0)
      return {1, other("damaged")};
    std::vector<MatlabValue> all;
    for (const auto& reference : references) {
      const Hdf5Id object(H5Rdereference2(dataset, H5P_DEFAULT, H5R_OBJECT, &reference), H5Oclose);
      all.push_back(object.valid() ? value_of(object, depth + 1) : other("damaged"));
    }
    return all;
  }

  MatlabValue array(hid_t dataset, const std::string& kind, int depth) {
    if (has_attribute(dataset, "MATLAB_empty"))
      return of_kind(kind == "char"     ? Kind::text
                     : kind == "cell"   ? Kind::cells
                     : kind == "struct" ? Kind::structure
                                        : Kind::numbers);
    if (hdf5_lies_elsewhere(dataset)) return other("stored in another file");
    const Hdf5Id type(H5Dget_type(dataset), H5Tclose);
    if (!type.valid()) return other("damaged");
    const auto stored = H5Tget_class(type);
    if (stored == H5T_REFERENCE) {
      auto value = of_kind(Kind::cells);
      for (auto& each : referred(dataset, depth)) {
        auto& element = value.elements.emplace_back();
        element.push_back({"", std::move(each)});
      }
      return value;
    }
    const bool complex = is_complex(type);
    if (stored == H5T_STRING) return of_kind(Kind::text);
    if (stored != H5T_INTEGER && stored != H5T_FLOAT && !complex) return other("of a type that is not read");
    const Hdf5Id space(H5Dget_space(dataset), H5Sclose);
    const auto lengths = lengths_of(space);
    if (lengths.size() > 2 && !complex) return other("an array of " + std::to_string(lengths.size()) + " dimensions");
    if (!is_plausible(H5Sget_simple_extent_npoints(space)))
      return other("damaged: it states more values than the file can hold");
    const auto unpacked =
        static_cast<std::uintmax_t>(H5Sget_simple_extent_npoints(space)) * sizeof(double) * (complex ? 2U : 1U);
    if (!budget_.take(variable_, unpacked)) return too_large(unpacked);
    if (kind == "char") return characters(dataset, lengths);
    return numbers(dataset, lengths, complex);
  }

  /// What gzip packs to a thousandth at best, and the file's size, bound the numbers.
  [[nodiscard]] bool is_plausible(hssize_t count) const {
    return count >= 0 && static_cast<std::uintmax_t>(count) <= 1100 * bytes_;
  }

  [[nodiscard]] MatlabValue too_large(std::uintmax_t bytes) {
    note("a part of '" + valid_utf8(variable_) + "' " + budget_.refusal(bytes));
    return other("too large");
  }

  MatlabValue numbers(hid_t dataset, const std::vector<Index>& lengths, bool complex) {
    auto value = of_kind(Kind::numbers);
    if (lengths.size() > 2) value.lengths = lengths;
    const auto read = [&](MatrixXd& values, hid_t type) {
      values.resize(lengths.front(),
                    std::accumulate(lengths.begin() + 1, lengths.end(), Index{1}, std::multiplies<>()));
      return values.size() == 0 || H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) >= 0;
    };
    const bool done = complex ? read(value.real, part_type("real")) && read(value.imaginary, part_type("imag"))
                              : read(value.real, H5T_NATIVE_DOUBLE);
    if (!done) return other("damaged: its values cannot be read");
    if (!hdf5_is_complete(dataset)) return other("damaged: a part of its values is not in the file");
    return value;
  }

  /// Characters of one row.
  MatlabValue characters(hid_t dataset, const std::vector<Index>& lengths) {
    auto value = of_kind(Kind::text);
    if (lengths.size() > 2 || lengths.front() != 1) return value;
    std::u16string text(static_cast<std::size_t>(lengths.back()), u'\0');
    if (!text.empty() && H5Dread(dataset, H5T_NATIVE_UINT16, H5S_ALL, H5S_ALL, H5P_DEFAULT, text.data()) < 0)
      return other("damaged: its text cannot be read");
    value.text = utf8_of(text);
    return value;
  }

  std::string path_;
  UnpackedBudget& budget_;
  std::string variable_;  ///< that is read now
  Hdf5File checked_;      ///< tells why a file cannot be opened, and silences HDF5
  Hdf5Id file_;
  std::uintmax_t bytes_ = 0;
  std::size_t values_ = 0;
  MatlabContents contents_;
};

}  // namespace

MatlabContents read_matlab_hdf5(const std::filesystem::path& path, UnpackedBudget& budget) {
  return Reader(path, budget).read();
}

}  // namespace kalfem
