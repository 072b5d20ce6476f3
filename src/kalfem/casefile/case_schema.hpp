// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kalfem/casefile/description.hpp"

namespace kalfem::description {

/// Schemas of the parts, each in a file of its own beside case_schema.cpp.
Schema<Name> name();
Schema<Value> value();
/// A point by its name, or a map of points and weights.
Schema<Points> points(const std::string& short_name);
Schema<ChannelPreparation> channel_preparation();

Schema<FiniteElements> finite_elements();
/// A factor of a part of a finite-element substructure.
Schema<Factor> part_factor();
Schema<Reduction> reduction();
Schema<Substructure> substructure();
Schema<Excitation> excitation();
/// In the place of the file of an excitation whose samples come with the stream of `live`.
inline constexpr const char* from_stream = "live";
Schema<Estimation> estimation();
Schema<Updating> updating();
Schema<Modification> modification();
Schema<Inference> inference();
Schema<LawComparison> law_comparison();
Schema<Live> live();
Schema<Placement> placement();
Schema<Statics> statics();
Schema<FrequencyResponses> frequency_responses();

}  // namespace kalfem::description
