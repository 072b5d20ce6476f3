#pragma once

#include <string>

#include "kalfem/casefile/stages.hpp"

namespace kalfem {

/// Writes every time series with names, units and sampling rate into an HDF5 file:
/// /time, /measurements/<sensor>, /truth/<point>/<quantity>, /estimate/<point>/<quantity>{,_std},
/// /estimate/parameters/<name>{,_std}, /innovation/{value,deviation,nis}, /prediction/<point>/<quantity>.
/// Throws InvalidInput where the file cannot be written.
void write_results(const std::string& path, const Study& study, const StudyResults& results);

}  // namespace kalfem
