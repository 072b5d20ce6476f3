#include "kalfem/report/superelement_files.hpp"

#include "kalfem/formats/matrices/write.hpp"

namespace kalfem {
namespace {

const char* ending(MatrixFormat format) {
  switch (format) {
    case MatrixFormat::dmig:
      return ".dmig";
    case MatrixFormat::op4:
      return ".op4";
    case MatrixFormat::hdf5:
      return ".h5";
    default:
      return ".mtx";
  }
}

}  // namespace

void write_superelements(const std::filesystem::path& folder, const Study& study) {
  for (const auto& elements : study.structure->finite_elements)
    for (const auto format : study.report.superelements)
      if (elements.reduced)
        write_superelement(folder / (elements.part->name + "_reduced" + ending(format)), elements.reduced->model,
                           format, elements.reduced->basis);
}

}  // namespace kalfem
