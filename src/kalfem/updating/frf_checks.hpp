#pragma once

#include <vector>

#include "kalfem/updating/frf_residual.hpp"

namespace kalfem {

/// Measured FRFs that cannot be compared with any model: sizes, values that are not finite, frequencies that do not
/// ascend, phases that are not there, options out of range. Throws InvalidInput with all of them.
void check_measured(const std::vector<MeasuredFrf>& measured, const FrfResidualOptions& options);

/// Throws InvalidInput where no lines of an FRF are left in the bands, or some value there is exactly zero.
void check_lines(const std::vector<MeasuredFrf>& measured, const std::vector<FrequencyResponse>& compared,
                 const FrfResidualOptions& options);

/// Throws InvalidInput where lines lie beyond three times the highest frequency of a model all of whose modes are
/// known: there it has its mass only.
void check_range(const std::vector<MeasuredFrf>& measured, const std::vector<FrequencyResponse>& compared,
                 const ResponseBasis& basis, const ResponseBasisOptions& options);

/// Measured against model FRFs of a start that is not far off: throws InvalidInput where the median of |H| / |H_model|
/// over lines and outputs is like a unit (9.81 or above 100, or their inverses), or goes like a power of omega.
void check_size(const std::vector<MeasuredFrf>& measured, const std::vector<FrequencyResponse>& compared,
                const std::vector<Eigen::MatrixXcd>& model, const FrfResidualOptions& options);

}  // namespace kalfem
