#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <type_traits>

namespace kalfem {

/// The same quantity at `width` neighbouring points, one point per lane of the vector registers.
template <int width>
using Lanes = Eigen::Array<double, width, 1>;

template <int width>
auto load(const double* values) {
  return Eigen::Map<const Lanes<width>>(values);
}

template <int width>
auto store(double* values) {
  return Eigen::Map<Lanes<width>>(values);
}

/// N points in whole blocks of `width`. Where the width does not divide N, the last block begins inside the one before:
/// its points stand in both, so that loops over blocks have no remainder and every lane holds a point.
struct PointBlocks {
  static constexpr Eigen::Index widest = 8;  ///< a register of 64 bytes, or several smaller ones

  explicit PointBlocks(Eigen::Index points_)
      : points(points_),
        width(points >= widest ? widest
              : points >= 4    ? 4
                               : 1),
        rows((points + width - 1) / width * width) {}

  Eigen::Index points;  ///< N
  Eigen::Index width;   ///< 8, 4 or 1
  Eigen::Index rows;    ///< rows of an array in blocks

  /// First rows that are points in their order; the `repeated()` rows after these stand before them, too.
  [[nodiscard]] Eigen::Index whole() const { return points / width * width; }
  [[nodiscard]] Eigen::Index repeated() const { return rows - points; }

  /// Calls work with the width as a constant.
  template <class Work>
  void with_width(const Work& work) const {
    if (width == widest)
      work(std::integral_constant<int, int{widest}>{});
    else if (width == 4)
      work(std::integral_constant<int, 4>{});
    else
      work(std::integral_constant<int, 1>{});
  }

  /// Columns of N rows into columns of blocks.
  void spread(const double* from, double* to, Eigen::Index columns) const {
    with_width([&](auto wide) { copy<wide()>(from, points, points - wide(), to, rows, rows, columns); });
  }
  /// The reverse.
  void collect(const double* from, double* to, Eigen::Index columns) const {
    with_width([&](auto wide) { copy<wide()>(from, rows, rows, to, points, points - wide(), columns); });
  }

private:
  template <int wide>
  void copy(const double* from, Eigen::Index from_stride, Eigen::Index from_last, double* to, Eigen::Index to_stride,
            Eigen::Index to_last, Eigen::Index columns) const {
    for (Eigen::Index column = 0; column < columns; ++column, from += from_stride, to += to_stride)
      for (Eigen::Index row = 0; row < rows; row += wide)
        store<wide>(to + std::min(row, to_last)) = load<wide>(from + std::min(row, from_last));
  }
};

}  // namespace kalfem
