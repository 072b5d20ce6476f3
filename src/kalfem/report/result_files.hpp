#pragma once

#include <filesystem>
#include <string>

#include "kalfem/pipeline/run_study.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

/// Writes every time series with names, units and sampling rate into an HDF5 file:
/// /time, /measurements/<sensor>, /truth/<point>/<quantity>, /estimate/<point>/<quantity>{,_std},
/// /estimate/parameters/<name>{,_std}, /innovation/{value,deviation,nis}, /prediction/<point>/<quantity>.
/// No file where there are none. Throws InvalidInput where the file cannot be written, WriteFailure where the disk is
/// full.
/// `run`: the identity that the file carries as the attribute `run` of its root, see run_identity().
void write_results(const std::string& path, const Study& study, const StudyResults& results, const std::string& run);

/// Writes the augmented model's superelements for other codes, in the formats that the case asks for:
/// <substructure>_reduced with the ending of the format (.mtx, .dmig, .op4, .h5), see write_superelement().
void write_superelements(const std::filesystem::path& folder, const Study& study);

}  // namespace kalfem
