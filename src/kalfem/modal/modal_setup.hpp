// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <string>
#include <vector>

#include "kalfem/modal/modal_options.hpp"
#include "kalfem/records/record.hpp"

namespace kalfem {

/// The record as it is identified, and every choice that the options leave open.
struct ModalSetup {
  Record record;                         ///< outputs alone, in the wanted band, each without its mean
  Eigen::VectorXd scale;                 ///< root mean square of each channel
  std::vector<Eigen::Index> references;  ///< rows of the record
  Eigen::Index block_rows = 0, max_order = 0, blocks = 0;
  std::vector<std::string> remarks;
};

/// Throws InvalidInput as identify_modes() does.
ModalSetup make_modal_setup(const Record& record, const ModalOptions& options);

}  // namespace kalfem
