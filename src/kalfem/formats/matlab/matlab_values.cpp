// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/matlab/matlab_values.hpp"

#include <matio.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <set>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/regular_file.hpp"
#include "kalfem/base/text.hpp"
#include "kalfem/formats/matlab/matlab_file.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr std::size_t deepest = 16;  ///< structures within structures

struct CloseFile {
  void operator()(mat_t* file) const { Mat_Close(file); }
};
struct FreeVariable {
  void operator()(matvar_t* variable) const { Mat_VarFree(variable); }
};
using Variable = std::unique_ptr<matvar_t, FreeVariable>;

void keep_quiet(int, char*) {}

template <class Stored>
MatrixXd as_doubles(const void* data, Index rows, Index columns) {
  return Eigen::Map<const Eigen::Matrix<Stored, Eigen::Dynamic, Eigen::Dynamic>>(static_cast<const Stored*>(data), rows,
                                                                                 columns)
      .template cast<double>();
}

/// By the class of the array: libmatio turns what is stored in narrower types into it.
MatrixXd numbers_of(matio_classes kind, const void* data, Index rows, Index columns) {
  switch (kind) {
    case MAT_C_DOUBLE:
      return as_doubles<double>(data, rows, columns);
    case MAT_C_SINGLE:
      return as_doubles<float>(data, rows, columns);
    case MAT_C_INT8:
      return as_doubles<std::int8_t>(data, rows, columns);
    case MAT_C_UINT8:
      return as_doubles<std::uint8_t>(data, rows, columns);
    case MAT_C_INT16:
      return as_doubles<std::int16_t>(data, rows, columns);
    case MAT_C_UINT16:
      return as_doubles<std::uint16_t>(data, rows, columns);
    case MAT_C_INT32:
      return as_doubles<std::int32_t>(data, rows, columns);
    case MAT_C_UINT32:
      return as_doubles<std::uint32_t>(data, rows, columns);
    case MAT_C_INT64:
      return as_doubles<std::int64_t>(data, rows, columns);
    case MAT_C_UINT64:
      return as_doubles<std::uint64_t>(data, rows, columns);
    default:
      return {};
  }
}

std::size_t width_of(matio_classes kind) {
  switch (kind) {
    case MAT_C_DOUBLE:
    case MAT_C_INT64:
    case MAT_C_UINT64:
      return 8;
    case MAT_C_SINGLE:
    case MAT_C_INT32:
    case MAT_C_UINT32:
      return 4;
    case MAT_C_INT16:
    case MAT_C_UINT16:
      return 2;
    case MAT_C_INT8:
    case MAT_C_UINT8:
      return 1;
    default:
      return 0;
  }
}

MatlabValue other(std::string what) {
  MatlabValue value;
  value.what = std::move(what);
  return value;
}

MatlabValue of_kind(MatlabValue::Kind kind) {
  MatlabValue value;
  value.kind = kind;
  return value;
}

/// Number of elements; nothing where it is more than any file holds.
std::optional<std::size_t> size_of(const matvar_t& variable) {
  std::size_t size = 1;
  for (int i = 0; i < variable.rank; ++i)
    if (__builtin_mul_overflow(size, variable.dims[i], &size)) return std::nullopt;
  return size;
}

MatlabValue value_of(matvar_t& variable, std::size_t depth);

MatlabValue numbers_of(const matvar_t& variable, std::size_t size) {
  const auto lengths = matlab_lengths({variable.dims, variable.dims + std::max(0, variable.rank)});
  if (lengths.size() > 2 && !variable.isComplex)
    return other("an array of " + std::to_string(lengths.size()) + " dimensions");
  auto value = of_kind(MatlabValue::Kind::numbers);
  if (lengths.size() > 2) value.lengths = lengths;
  if (size == 0) return value;
  const Index rows = lengths.front(), columns = static_cast<Index>(size) / rows;
  const std::size_t bytes = size * width_of(variable.class_type);
  if (variable.data == nullptr || variable.nbytes < bytes) return other("damaged");
  if (!variable.isComplex) {
    value.real = numbers_of(variable.class_type, variable.data, rows, columns);
    return value;
  }
  const auto* parts = static_cast<const mat_complex_split_t*>(variable.data);
  if (parts->Re == nullptr || parts->Im == nullptr) return other("damaged");
  value.real = numbers_of(variable.class_type, parts->Re, rows, columns);
  value.imaginary = numbers_of(variable.class_type, parts->Im, rows, columns);
  return value;
}

}  // namespace

std::vector<Index> matlab_lengths(const std::vector<std::size_t>& lengths) {
  std::vector<Index> kept(lengths.begin(), lengths.end());
  while (kept.size() < 2) kept.push_back(1);
  for (auto place = kept.begin(); kept.size() > 2 && place != kept.end();)
    place = *place == 1 ? kept.erase(place) : place + 1;
  return kept;
}

namespace {

/// Rows of characters run together; only those of one row are names and units.
MatlabValue text_of(const matvar_t& variable, std::size_t size) {
  auto value = of_kind(MatlabValue::Kind::text);
  if (variable.data == nullptr || variable.rank != 2 || variable.dims[0] != 1) return value;
  const bool wide = variable.data_type == MAT_T_UINT16 || variable.data_type == MAT_T_UTF16;
  if (wide)
    value.text =
        utf8_of({static_cast<const char16_t*>(variable.data), std::min(size, variable.nbytes / sizeof(char16_t))});
  else
    value.text.assign(static_cast<const char*>(variable.data), std::min(size, variable.nbytes));
  value.text = to_utf8(value.text);
  return value;
}

MatlabValue structure_of(matvar_t& variable, std::size_t size, std::size_t depth) {
  auto value = of_kind(MatlabValue::Kind::structure);
  const unsigned fields = Mat_VarGetNumberOfFields(&variable);
  char* const* names = Mat_VarGetStructFieldnames(&variable);
  if (variable.data == nullptr || fields == 0 || names == nullptr) return value;
  if (variable.nbytes / sizeof(matvar_t*) < size) return other("damaged");
  for (std::size_t i = 0; i < size; ++i) {
    auto& element = value.elements.emplace_back();
    for (unsigned j = 0; j < fields; ++j) {
      matvar_t* field = Mat_VarGetStructFieldByIndex(&variable, j, i);
      if (field != nullptr && names[j] != nullptr) element.push_back({names[j], value_of(*field, depth + 1)});
    }
  }
  return value;
}

MatlabValue cells_of(matvar_t& variable, std::size_t size, std::size_t depth) {
  auto value = of_kind(MatlabValue::Kind::cells);
  if (variable.data == nullptr || variable.nbytes / sizeof(matvar_t*) < size) return value;
  for (std::size_t i = 0; i < size; ++i) {
    matvar_t* cell = Mat_VarGetCell(&variable, static_cast<int>(i));
    auto& element = value.elements.emplace_back();
    if (cell != nullptr) element.push_back({"", value_of(*cell, depth + 1)});
  }
  return value;
}

MatlabValue value_of(matvar_t& variable, std::size_t depth) {
  const auto size = size_of(variable);
  if (!size || depth > deepest) return other("damaged");
  switch (variable.class_type) {
    case MAT_C_EMPTY:
      return of_kind(MatlabValue::Kind::numbers);
    case MAT_C_STRUCT:
      return structure_of(variable, *size, depth);
    case MAT_C_CELL:
      return cells_of(variable, *size, depth);
    case MAT_C_CHAR:
      return text_of(variable, *size);
    case MAT_C_SPARSE:
      return other("a sparse matrix");
    case MAT_C_OBJECT:
    case MAT_C_OPAQUE:
      return other("an object");
    case MAT_C_FUNCTION:
      return other("a function");
    default:
      return numbers_of(variable, *size);
  }
}

std::string first_bytes(const std::filesystem::path& path) {
  constexpr std::uintmax_t mark_length = 19;
  return read_bytes(path, mark_length);
}

class MatlabReader {
public:
  MatlabReader(const std::filesystem::path& path, UnpackedBudget& budget) : path_(path.string()), budget_(budget) {
    static const bool quiet = Mat_LogInitFunc("kalfem", keep_quiet) == 0;
    static_cast<void>(quiet);
    if (begins_matlab(first_bytes(path)) || is_matlab_4(path)) file_.reset(Mat_Open(path.c_str(), MAT_ACC_RDONLY));
    if (!file_)
      throw InvalidInput(
          Issue{{path_, 0}, "the MATLAB file cannot be read", "it is damaged or no MATLAB file", "save it again"});
  }

  MatlabContents read() {
    const auto version = Mat_GetVersion(file_.get());
    const auto elements = version == MAT_FT_MAT5 ? scan_matlab_elements(path_, budget_) : MatlabElements{};
    for (const auto& [name, kind] : elements.objects) add_object(name, kind);
    const std::size_t most = version == MAT_FT_MAT5 ? elements.arrays : most_variables;
    std::size_t arrays = 0;
    for (; arrays < most; ++arrays) {
      const Variable variable{Mat_VarReadNextInfo(file_.get())};
      if (!variable) break;
      take(*variable, arrays < elements.unpacked.size() ? elements.unpacked[arrays] : 0);
    }
    if (elements.cut_off) note("the file is cut off: what follows is missing");
    if (elements.damaged_at > 0)
      note("the variable at byte " + std::to_string(elements.damaged_at) +
           " is damaged: it and what follows are left out");
    if (elements.too_large > 0)
      note("the variable behind the first " + std::to_string(elements.arrays) + " " +
           budget_.refusal(elements.too_large) + "; what follows it is left out too");
    if (arrays < elements.arrays) note(std::to_string(elements.arrays - arrays) + " of its variables cannot be read");
    return std::move(contents_);
  }

private:
  static constexpr std::size_t most_variables = 100'000;

  void note(const std::string& words) { contents_.skipped.push_back(path_ + ": " + words); }

  void add_object(const std::string& name, const std::string& kind) {
    objects_.insert(name);
    if (!name.empty())
      contents_.skipped.push_back("'" + valid_utf8(name) + "' is a MATLAB object of class " + valid_utf8(kind) +
                                  ": save it as an array");
  }

  void take(matvar_t& variable, std::uintmax_t unpacked) {
    const std::string name = variable.name == nullptr ? "" : variable.name;
    if (name.empty() || objects_.contains(name)) return;  // data of objects have no name
    if (!is_plausible(variable))
      return note("variable '" + valid_utf8(name) + "' states more values than the file can hold");
    if (!budget_.take(name, unpacked)) return note("variable '" + valid_utf8(name) + "' " + budget_.refusal(unpacked));
    if (Mat_VarReadDataAll(file_.get(), &variable) != 0)
      return note("variable '" + valid_utf8(name) + "' cannot be read");
    contents_.variables.push_back({valid_utf8(name), value_of(variable, 0)});
  }

  /// What zlib packs to a thousandth at best, and the file's size, bound the numbers.
  [[nodiscard]] bool is_plausible(const matvar_t& variable) const {
    std::error_code ignored;
    const auto bytes = std::filesystem::file_size(path_, ignored);
    const auto size = size_of(variable);
    return size && *size <= 1100 * bytes;
  }

  std::string path_;
  UnpackedBudget& budget_;
  std::unique_ptr<mat_t, CloseFile> file_;
  MatlabContents contents_;
  std::set<std::string> objects_;
};

}  // namespace

// libmatio takes classes of version 7.3 for unknown whose names do not end in a zero, as HDF5's other writers leave
// them.
MatlabContents read_matlab_values(const std::filesystem::path& path, UnpackedBudget& budget) {
  return first_bytes(path).starts_with("MATLAB 7.3") ? read_matlab_hdf5(path, budget)
                                                     : MatlabReader(path, budget).read();
}

}  // namespace kalfem
