// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/pipeline/likelihood_checkpoint.hpp"

namespace kalfem {

/// Computes the posterior and the evidence of each law of infer.compare_laws on the same record, and tries its
/// posterior on the part of the record that `validate` holds back, if there is one.
LawRanking rank_laws(const Study& study, const Record& record, LikelihoodCheckpoint& checkpoint,
                     const Progress& progress);

}  // namespace kalfem
