#include "kalfem/formats/gmsh/gmsh_types.hpp"

#include <algorithm>
#include <array>

namespace kalfem {

const GmshType* find_gmsh_type(std::int64_t number) {
  static const std::array types{
      GmshType{15, 0, 1, "point", CellShape::point1},
      GmshType{1, 1, 2, "line", CellShape::line2},
      GmshType{2, 2, 3, "triangle", CellShape::triangle3},
      GmshType{3, 2, 4, "quadrilateral", CellShape::quadrilateral4},
      GmshType{4, 3, 4, "tetrahedron", CellShape::tetrahedron4},
      GmshType{5, 3, 8, "hexahedron", CellShape::hexahedron8},
      GmshType{6, 3, 6, "prism", CellShape::wedge6},
      GmshType{7, 3, 5, "pyramid"},
      GmshType{8, 1, 3, "3-node line", CellShape::line3},
      GmshType{9, 2, 6, "6-node triangle", CellShape::triangle6},
      GmshType{10, 2, 9, "9-node quadrilateral"},
      GmshType{11, 3, 10, "10-node tetrahedron", CellShape::tetrahedron10, {0, 1, 2, 3, 4, 5, 6, 7, 9, 8}},
      GmshType{12, 3, 27, "27-node hexahedron"},
      GmshType{13, 3, 18, "18-node prism"},
      GmshType{14, 3, 14, "14-node pyramid"},
      GmshType{16, 2, 8, "8-node quadrilateral", CellShape::quadrilateral8},
      GmshType{17, 3, 20, "20-node hexahedron", CellShape::hexahedron20, {0,  1, 2,  3,  4,  5,  6,  7,  8,  11,
                                                                          13, 9, 16, 18, 19, 17, 10, 12, 14, 15}},
      GmshType{18, 3, 15, "15-node prism", CellShape::wedge15, {0, 1, 2, 3, 4, 5, 6, 9, 7, 12, 14, 13, 8, 10, 11}},
      GmshType{19, 3, 13, "13-node pyramid"},
      GmshType{20, 2, 9, "9-node triangle"},
      GmshType{21, 2, 10, "10-node triangle"},
      GmshType{22, 2, 12, "12-node triangle"},
      GmshType{23, 2, 15, "15-node triangle"},
      GmshType{24, 2, 15, "15-node triangle without inner nodes"},
      GmshType{25, 2, 21, "21-node triangle"},
      GmshType{26, 1, 4, "4-node line"},
      GmshType{27, 1, 5, "5-node line"},
      GmshType{28, 1, 6, "6-node line"},
      GmshType{29, 3, 20, "20-node tetrahedron"},
      GmshType{30, 3, 35, "35-node tetrahedron"},
      GmshType{31, 3, 56, "56-node tetrahedron"},
      GmshType{36, 2, 16, "16-node quadrilateral"},
      GmshType{37, 2, 25, "25-node quadrilateral"},
      GmshType{38, 2, 36, "36-node quadrilateral"},
      GmshType{92, 3, 64, "64-node hexahedron"},
      GmshType{93, 3, 125, "125-node hexahedron"},
  };
  const auto found = std::ranges::find(types, number, &GmshType::number);
  return found == types.end() ? nullptr : &*found;
}

}  // namespace kalfem
