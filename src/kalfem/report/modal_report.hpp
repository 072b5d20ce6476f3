// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "kalfem/modal/modal_result.hpp"
#include "kalfem/page/page.hpp"
#include "kalfem/records/measured_file.hpp"

namespace kalfem {

/// The modes as a table, with what is to be said of the record. `source`: the file's name.
std::string modal_text(const std::string& source, const ModalResult& result);

/// The same for programs, with shapes, covariances and the stabilisation diagram.
nlohmann::ordered_json modal_json(const std::string& source, const ModalResult& result);

/// The same as a page, with the stabilisation diagram and the shapes.
Page modal_page(const std::string& source, const ModalResult& result);

/// Real shapes, channels x modes: each is turned to the phase at which its real part is largest; the largest entry
/// is 1.
Eigen::MatrixXd real_shapes(const ModalResult& result);

/// Writes into a folder
///     modes.json    modal_json()
///     modes.csv     one row a mode: frequency, damping, their standard deviations, ...
///     shapes.csv    real_shapes(): one row a channel, one column a mode, as `update` reads them
///     modes.unv     complex shapes as a universal file (dataset 55)
/// A channel whose node is not known stands there at a node of its own, along x. Throws as write_file_atomically().
void write_modal_files(const std::filesystem::path& folder, const std::string& source, const ModalResult& result,
                       const std::vector<MeasuredPlace>& places);

}  // namespace kalfem
