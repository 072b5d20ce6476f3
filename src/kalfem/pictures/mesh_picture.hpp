// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <string>
#include <vector>

#include "kalfem/model/finite_element_model.hpp"
#include "kalfem/model/mesh/mesh.hpp"
#include "kalfem/pictures/drawn_surface.hpp"

namespace kalfem {

/// A polygon on the screen: x and y [pixel] and the depth of its corners, larger farther away.
struct ScreenPolygon {
  Eigen::Matrix3Xd corners;
};

/// What is seen of polygons on a raster of width x height pixels.
struct ScreenDepth {
  std::vector<bool> visible;    ///< per polygon: it is the nearest one at any pixel
  std::vector<double> nearest;  ///< per pixel, row by row: depth of the nearest polygon, infinite where there is none
  int width = 0, height = 0;

  /// Depth of what is nearest at a place, infinite outside.
  [[nodiscard]] double at(double x, double y) const;
};
ScreenDepth screen_depth(const std::vector<ScreenPolygon>& polygons, int width, int height);

/// The visible polygons in the order in which they are to be painted so that nearer ones cover farther ones: per pixel
/// they are sorted by depth, and of each two that follow one another the farther is painted first. Where polygons cover
/// one another in a ring the farthest goes first.
std::vector<std::size_t> painters_order(const std::vector<ScreenPolygon>& polygons, const ScreenDepth& depth);

/// "#rrggbb" of a region by its place in the list of regions.
std::string region_colour(std::size_t region);

/// Regions of a model that have a property: those that pictures show.
std::vector<std::string> drawn_regions(const FiniteElementModel& model);

/// What a symbol at a node stands for.
enum class MarkKind {
  mass,       ///< a disc
  support,    ///< a triangle
  spring,     ///< a diamond
  point,      ///< a ring with its label: a sensor or an interface
  finding,    ///< a cross: where something is wrong
  candidate,  ///< a disc in a colour of its own: where a sensor could stand
  chosen      ///< a larger one with a rim, above all others: where it should stand
};

/// A symbol at a node of the mesh.
struct PictureMark {
  MarkKind kind = MarkKind::point;
  Eigen::Index node = 0;
  std::string label = {};   ///< written beside it
  std::string colour = {};  ///< of a candidate or a chosen one, "#rrggbb"
};

struct MeshPictureOptions {
  int width = 960, height = 640;          ///< [pixel]
  double azimuth = -58.0;                 ///< of the eye about z, from x towards y [deg]
  double elevation = 26.0;                ///< of the eye above the x-y plane [deg]
  std::vector<std::string> regions = {};  ///< to draw, in the order of their colours; empty: all with lines, surfaces
                                          ///< or solids
  std::vector<std::string> region_colours = {};  ///< of these regions, "#rrggbb"; empty: colours of the picture's own
  std::vector<PictureMark> marks = {};  ///< faint behind the surface; thinned out where many of a kind stand together
  std::vector<std::pair<Eigen::Index, Eigen::Index>> links = {};  ///< dashed lines between nodes
  bool plain = false;  ///< the mesh in one pale colour and without a legend of regions, so that marks stand out
  /// Colours of candidates from the best to the worst, for the legend; empty: none.
  std::vector<std::string> candidate_colours = {};
  std::size_t most_faces = 12000;  ///< of what is drawn; finer surfaces are coarsened
};

/// A mesh as a picture: parallel projection, outer faces alone, shaded by their direction and painted from back to
/// front, a colour for each region, lines for beams; with a legend, axes and a scale. One self-contained SVG element
/// that sets itself to light and dark surroundings, below about 2 MB. A mesh without anything to draw gives a picture
/// that says so.
std::string mesh_picture_svg(const Mesh& mesh, const MeshPictureOptions& options = {});

/// The same of a model: its regions with a property, masses, supports, springs and links beside what the options ask.
std::string mesh_picture_svg(const FiniteElementModel& model, MeshPictureOptions options = {});

}  // namespace kalfem
