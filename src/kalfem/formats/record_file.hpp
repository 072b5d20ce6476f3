// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/records/record.hpp"

namespace kalfem {

/// A column of a record file as its reader wants it.
struct WantedChannel {
  std::string column;                    ///< its name, with or without its unit
  std::string owner;                     ///< what it is for, for the messages: "sensors.a3"
  std::string unit;                      ///< SI unit of the quantity that it holds
  std::string rotational_unit = {};      ///< SI unit of the same quantity of a rotation; empty: there is none
  std::string unit_key = {};             ///< where its unit may be stated: "sensors.a3.unit"; empty: nowhere
  Located<std::string> unit_given = {};  ///< what is stated; empty: nothing, so that the file's own holds, else SI
};

/// Factor that turns the column's numbers into SI. The unit is the one that is stated, or that of the file's title; g
/// beside an acceleration is standard gravity. Adds an issue with both values where the two contradict each other,
/// where a unit has another dimension than the quantity, and where the file's unit is not understood and none is
/// stated.
double factor_to_si(const WantedChannel& wanted, const Channel& in_file, const SourceLocation& title,
                    IssueList& issues);

/// What is known of a record file beside its columns.
struct RecordFileOptions {
  std::optional<double> sample_rate = {};  ///< [Hz], where the file does not say it
  std::string dataset = {};                ///< of an HDF5 file
  bool missing = false;                    ///< samples may be missing: they become NaN
  bool interpolate = false;                ///< a single channel of uneven times is given at even ones (spline)
  bool* spread = nullptr;  ///< set where the channels lack samples because of their sampling rates; null: not asked
  std::vector<std::string>* notes = nullptr;  ///< where contradictions of the file are added; null: nowhere
};

/// The wanted columns of a file as a record, in that order and in SI: .csv (also .txt, .dat, .tsv), .lvm, .h5 (also
/// .hdf5; `dataset` is samples x channels with an attribute or a number as channel name "0", "1", ...), and the formats
/// of measured_formats(), from which select_record() chooses the channels. Here, and only here, the columns of a file
/// become the rows of a record. Units are those that are stated, of the columns' titles, of Y_Unit_Label, or of the
/// dataset's attribute `unit` (one for all columns, or one each). Throws InvalidInput where the file, a channel or the
/// sampling rate is missing and where units do not fit.
Record read_record_file(const std::filesystem::path& file, const std::vector<WantedChannel>& wanted,
                        const RecordFileOptions& options);

}  // namespace kalfem
