#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "kalfem/base/located.hpp"
#include "kalfem/casefile/description.hpp"
#include "kalfem/study/measured_record.hpp"
#include "kalfem/system/sensors/output_map.hpp"

namespace kalfem {

/// A column of a record file as a case asks for it.
struct WantedChannel {
  std::string column;                    ///< its name, with or without its unit
  std::string owner;                     ///< what it is for, as the case names it: "sensors.a3"
  std::string unit;                      ///< SI unit of the quantity that it holds
  std::string rotational_unit = {};      ///< SI unit of the same quantity of a rotation; empty: there is none
  std::string unit_key = {};             ///< where the case may state its unit: "sensors.a3.unit"; empty: nowhere
  Located<std::string> unit_given = {};  ///< what it states; empty: nothing, so that the file's own holds, else SI
};

/// SI unit of the quantity of a rotation: rad, rad/s and rad/s^2 for motions, nothing for those of connectors.
std::string rotational_unit_of(ObservedQuantity quantity);

/// Factor that turns the column's numbers into SI. The unit is the case's, or that of the file's title; g beside an
/// acceleration is standard gravity. Adds an issue with both values where the two contradict each other, where a unit
/// has another dimension than the quantity, and where the file's unit is not understood and the case states none.
double factor_to_si(const WantedChannel& wanted, const Channel& in_file, const SourceLocation& title,
                    IssueList& issues);

/// What a case says of a record file beside its columns.
struct RecordFileOptions {
  std::optional<double> sample_rate = {};  ///< [Hz], where the file does not say it
  std::string dataset = {};                ///< of an HDF5 file
  bool missing = false;                    ///< samples may be missing: they become NaN
};

/// The wanted columns of a table on disk, in that order and in SI: .csv (also .txt, .dat, .tsv), .lvm, .h5 (also .hdf5;
/// `dataset` is samples x channels with an attribute or a number as channel name "0", "1", ...). Units are those of the
/// case, of the columns' titles, of Y_Unit_Label, or of the dataset's attribute `unit` (one for all columns, or one
/// each). Throws InvalidInput where the file, a channel or the sampling rate is missing and where units do not fit.
TimeSeries read_record_file(const std::filesystem::path& file, const std::vector<WantedChannel>& wanted,
                            const RecordFileOptions& options);

/// Reads the channels of the case's sensors. Throws InvalidInput (missing file or channel, units that do not fit,
/// samples that are not finite unless the case skips them, an empty part, a channel without any number in it or with
/// one value throughout).
MeasuredRecord read_measured_record(const description::Case& given);

}  // namespace kalfem
