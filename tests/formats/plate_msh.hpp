// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace kalfem::test {

/// A plate of two by one quadrilaterals, MSH 2.2, with two corners and an edge by name.
inline constexpr const char* plate_msh = R"($MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
4
2 1 "plate"
0 2 "corner"
0 3 "far"
1 4 "edge"
$EndPhysicalNames
$Nodes
6
1 0 0 0
2 0.5 0 0
3 1 0 0
4 0 0.4 0
5 0.5 0.4 0
6 1 0.4 0
$EndNodes
$Elements
5
1 3 2 1 1 1 2 5 4
2 3 2 1 1 2 3 6 5
3 15 2 2 1 1
4 15 2 3 1 6
5 1 2 4 1 1 4
$EndElements
)";

}  // namespace kalfem::test
