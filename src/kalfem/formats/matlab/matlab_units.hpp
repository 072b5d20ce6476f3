// SPDX-License-Identifier: Apache-2.0
// Inside of the reader of MATLAB files only.

#pragma once

#include <Eigen/Dense>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/formats/matlab/matlab_scope.hpp"

namespace kalfem {

/// The units that one structure states for its series: a text, a list (cells, or "g, N"), or a structure with a field
/// for each. A single unit is that of a single series: of several it says nothing.
class SeriesUnits {
public:
  SeriesUnits(const Scope& scope, const std::string& path);

  /// Number of series of the structure: its longest numeric fields.
  [[nodiscard]] std::size_t series() const { return series_.size(); }
  /// Number of units in the list; 0 where there is none.
  [[nodiscard]] std::size_t listed() const { return list_.size(); }
  /// Unit of column `column` of `columns` of a series; empty: not stated.
  [[nodiscard]] std::string unit_of(const std::string& series, Eigen::Index column, Eigen::Index columns) const;
  /// What is stated and cannot be used, or holds for several channels alike. Empty: nothing.
  [[nodiscard]] std::string note(const std::string& series, Eigen::Index columns) const;

private:
  std::string path_, key_;                  ///< of the structure; name of the field
  std::optional<std::string> single_ = {};  ///< one text
  std::vector<std::string> list_ = {};      ///< one a channel, or one a series
  std::vector<NamedValue> by_name_ = {};    ///< of each series
  std::vector<std::string> series_ = {};
};

}  // namespace kalfem
