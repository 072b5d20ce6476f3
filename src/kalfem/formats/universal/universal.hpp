// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "kalfem/model/mesh/mesh.hpp"
#include "kalfem/records/measured_file.hpp"

namespace kalfem {

/// Whether a file that begins with these bytes is a universal file: a line "    -1" and a line with the number of a
/// dataset.
bool begins_universal(std::string_view head);

/// Reads a universal file (UFF, UNV): datasets between lines "    -1", the first of whose lines holds their number.
///
///   15, 781, 2411   nodes                              -> nodes [m]
///   780, 2412, 82   elements, trace lines              -> lines
///   55, 2414        normal and complex modes, static   -> shapes
///   58, 58b         functions at degrees of freedom    -> channels (time responses), functions (of frequency)
///   151, 164        header, units                      -> description, units of what follows
///
/// A channel is named by its node and direction, "12:+Z"; the name of its component, the first line of its text and, of
/// a channel without a node, the label of its ordinate are other names. Its unit is its label; without a label SI, into
/// which the numbers are converted by dataset 164. Texts are UTF-8, otherwise read as Latin-1.
///
/// As programs write them: numbers in columns or between blanks, that touch, with D or no exponent letter; records
/// whose columns are shifted; a missing end mark before the next dataset or at the end of the file; bytes (58b) found
/// by the count of the identifier, with or without a line break behind them, and by the end mark where the count is
/// wrong.
///
/// Other datasets, kinds of functions and of shapes are listed in `skipped`. Throws InvalidInput with all problems,
/// their lines and both counts where a dataset is incomplete: a header that declares more samples than there are.
MeasuredFile read_universal(const std::filesystem::path& file);

/// The same from a file's content; `source` names it in messages.
MeasuredFile parse_universal(std::string content, const std::string& source);

struct UniversalWriteOptions {
  bool binary = true;  ///< functions as bytes (58b), which keep all digits; otherwise as text
};

/// Writes a measured file as a universal file in SI: 151, 164, then nodes (2411), elements (2412), lines to draw (82),
/// shapes (55) and functions at degrees of freedom (58b, or 58).
///
/// Samples and uneven times keep all digits as bytes. As text they have those of the format: 13 of a sample, 6 of an
/// uneven time, and 6 of shapes in any case. A step that its column cannot hold is written as uneven times in 58b.
/// Throws InvalidInput for what the format cannot hold: infinite values, labels of units of more than 20 bytes, arrays
/// of other lengths than their times, lines or nodes. Throws as write_file_atomically() does.
void write_universal(const std::filesystem::path& path, const MeasuredFile& file,
                     const UniversalWriteOptions& options = {});

/// Nodes and elements of a mesh, for a universal file. Nodes are ordered as the elements of dataset 2412 order them:
/// the middle of a side between its corners.
MeasuredFile geometry_of(const Mesh& mesh);

}  // namespace kalfem
