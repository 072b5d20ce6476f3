// SPDX-License-Identifier: Apache-2.0
#include "kalfem/formats/measured_file_reader.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <map>
#include <new>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/base/regular_file.hpp"
#include "kalfem/base/text.hpp"
#include "kalfem/formats/hdf5/measured_hdf5.hpp"
#include "kalfem/formats/matlab/matlab_file.hpp"
#include "kalfem/formats/tables/lvm.hpp"
#include "kalfem/formats/tables/measured_table.hpp"
#include "kalfem/formats/tables/text_table.hpp"
#include "kalfem/formats/tdms/tdms.hpp"
#include "kalfem/formats/unit_labels.hpp"
#include "kalfem/formats/universal/universal.hpp"
#include "kalfem/formats/wav/wav.hpp"

namespace kalfem {
namespace {

constexpr std::size_t head_length = 4096;  ///< bytes of a file that tell its format

/// A kind of file that programs write and that holds no measured data in a form that is read.
struct ForeignKind {
  std::string_view first_bytes;
  std::string_view name;
};

// The archive of a .docx begins like that of a .xlsx: the ending says which one it is.
constexpr std::array foreign_kinds = {
    ForeignKind{"PK\x03\x04", "a ZIP archive, as .xlsx, .docx and .ods files are"},
    ForeignKind{"\xD0\xCF\x11\xE0", "a document of an older Office program (.xls, .doc)"},
    ForeignKind{"\x89PNG", "a PNG picture"},
    ForeignKind{"\xFF\xD8\xFF", "a JPEG picture"},
    ForeignKind{"GIF8", "a GIF picture"},
    ForeignKind{"%PDF", "a PDF document"},
    ForeignKind{"\x1f\x8b", "compressed by gzip"},
    ForeignKind{"7z\xBC\xAF", "a 7-Zip archive"},
    ForeignKind{"Rar!", "a RAR archive"},
    ForeignKind{"BZh", "compressed by bzip2"},
    ForeignKind{"SQLite format 3", "an SQLite database"},
    ForeignKind{"{\\rtf", "an RTF document"},
    ForeignKind{"\x93NUMPY", "a NumPy array (.npy)"},
    ForeignKind{"MDF     ", "a measurement data file of ASAM (.mdf, .mf4)"},
    ForeignKind{"|CF,", "an imc FAMOS file"},
    ForeignKind{"OggS", "compressed sound"},
    ForeignKind{"fLaC", "compressed sound"},
    ForeignKind{"ID3", "compressed sound"},
    ForeignKind{"PAR1", "a Parquet table"},
    ForeignKind{"<!DOCTYPE", "a web page"},
    ForeignKind{"<html", "a web page"},
};

std::string formats_in_words() {
  std::string text;
  for (const auto& format : measured_formats()) {
    text += std::string(format.name) + " (";
    for (std::size_t i = 0; i < format.endings.size(); ++i)
      text += (i > 0 ? ", " : "") + std::string(format.endings[i]);
    text += "), ";
  }
  return text + "table of text (.csv, .tsv, .txt, .dat), HDF5 (.h5, .hdf5)";
}

[[noreturn]] void refuse(const std::filesystem::path& file, const std::string& what) {
  throw InvalidInput(Issue{{file.string(), 0},
                           what,
                           "measured data are read from: " + formats_in_words(),
                           "export the data to one of these formats"});
}

void refuse_foreign(const std::filesystem::path& file, std::string_view head) {
  const auto kind =
      std::ranges::find_if(foreign_kinds, [&](const auto& each) { return head.starts_with(each.first_bytes); });
  if (kind != foreign_kinds.end()) refuse(file, "the file is " + std::string(kind->name));
}

/// A first line with zero bytes is none of a text.
bool is_binary(std::string_view head) { return head.substr(0, head.find('\n')).find('\0') != std::string_view::npos; }

/// Without a mark of UTF-8, and in UTF-8 where it is in UTF-16.
std::string as_text(std::string head) {
  if (head.starts_with("\xEF\xBB\xBF")) head.erase(0, 3);
  if (auto converted = utf16_as_utf8(head)) return *std::move(converted);
  return head;
}

}  // namespace

namespace {

/// Readers of formats that are not compressed read all.
template <MeasuredFile (*read)(const std::filesystem::path&)>
MeasuredFile whole(const std::filesystem::path& file, const MeasuredFileOptions&) {
  return read(file);
}

}  // namespace

const std::vector<MeasuredFormat>& measured_formats() {
  static const std::vector<MeasuredFormat> formats = {
      {"universal file", {".unv", ".uff", ".uf", ".uf58", ".58", ".bunv"}, begins_universal, whole<read_universal>},
      {"LabVIEW measurement file", {".lvm"}, begins_lvm, whole<read_lvm>},
      {"TDMS file", {".tdms"}, begins_tdms, whole<read_tdms>},
      {"WAV file", {".wav", ".w64"}, begins_wav, whole<read_wav>},
      {"MATLAB file", {".mat"}, begins_matlab, read_matlab_file},
  };
  return formats;
}

// Content decides, because files are renamed; a file without the usual beginning still says by its ending what it was
// meant to be, and then its reader names what is wrong.
const MeasuredFormat* measured_format(const std::filesystem::path& file) {
  const std::string head = as_text(read_bytes(file, head_length)), ending = lower_case(file.extension().string());
  for (const auto& format : measured_formats())
    if (format.begins != nullptr && format.begins(head)) return &format;
  refuse_foreign(file, head);
  for (const auto& format : measured_formats())
    if (std::ranges::find(format.endings, ending) != format.endings.end()) return &format;
  return nullptr;
}

namespace {

MeasuredFile read_by_format(const std::filesystem::path& file, const MeasuredFileOptions& options) {
  if (const MeasuredFormat* format = measured_format(file)) return format->read(file, options);
  const std::string ending = lower_case(file.extension().string());
  const std::string head = as_text(read_bytes(file, head_length));
  if (ending == ".h5" || ending == ".hdf5" || head.starts_with("\x89HDF")) return read_measured_hdf5(file, options);
  if (is_binary(head)) refuse(file, "the file is binary, of a kind that is not known");
  return read_measured_table(file);
}

/// Repeated names get numbers, "Untitled #1", "Untitled #2", so that the name alone chooses none of them.
void make_unique(std::vector<MeasuredChannel>& channels) {
  std::map<std::string, int> total, used;
  for (const auto& channel : channels) ++total[channel.name];
  for (auto& channel : channels) {
    if (total[channel.name] == 1) continue;
    channel.other_names.insert(channel.other_names.begin(), channel.name);
    channel.name += " #" + std::to_string(++used[channel.name]);
  }
}

}  // namespace

MeasuredFile read_measured_file(const std::filesystem::path& file, const MeasuredFileOptions& options) try {
  MeasuredFile measured = read_by_format(file, options);
  for (auto& channel : measured.channels) channel.unit = understood_unit(channel.unit);
  make_unique(measured.channels);
  return measured;
} catch (const std::bad_alloc&) {
  throw InvalidInput(Issue{{file.string(), 0},
                           "the file holds, or claims, more values than fit into memory",
                           "it is damaged, or too large for the memory that is available (ulimit -v)",
                           "export it again, or a part of it"});
}

}  // namespace kalfem
