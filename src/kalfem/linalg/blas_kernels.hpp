#pragma once

#include <optional>
#include <string>

namespace kalfem {

/// A sentence where the BLAS library runs kernels for an old processor although this one has wider vector units;
/// nothing otherwise, and where the library is not OpenBLAS.
std::optional<std::string> blas_warning();

/// The same decision from the name of the kernels ("Prescott") and what the processor can do.
std::optional<std::string> blas_warning(const std::string& kernels, bool has_avx2, bool has_avx512);

/// Name of the kernels that OpenBLAS chose; empty where the library is another one.
std::string blas_kernels();

}  // namespace kalfem
