#pragma once

namespace kalfem {

/// Node set of a model whose nodes are no places: scalar points and generalised coordinates, each with one motion x
/// that is a number and not a displacement. They take no part in rigid-body motions.
inline constexpr const char* scalar_points = "scalar points";

}  // namespace kalfem
