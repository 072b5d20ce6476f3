#pragma once

#include <string>
#include <vector>

#include "kalfem/model/finite_element_model.hpp"

namespace kalfem {

/// What a symbol at a node stands for.
enum class MarkKind {
  mass,     ///< a disc
  support,  ///< a triangle
  spring,   ///< a diamond
  point,    ///< a ring with its label: a sensor or an interface
  finding   ///< a cross: where something is wrong
};

/// A symbol at a node of the mesh.
struct PictureMark {
  MarkKind kind = MarkKind::point;
  Eigen::Index node = 0;
  std::string label = {};  ///< written beside it
};

struct MeshPictureOptions {
  int width = 960, height = 640;          ///< [pixel]
  double azimuth = -58.0;                 ///< of the eye about z, from x towards y [deg]
  double elevation = 26.0;                ///< of the eye above the x-y plane [deg]
  std::vector<std::string> regions = {};  ///< to draw, in the order of their colours; empty: all with lines, surfaces
                                          ///< or solids
  std::vector<PictureMark> marks = {};    ///< faint behind the surface; thinned out where many of a kind stand together
  std::vector<std::pair<Eigen::Index, Eigen::Index>> links = {};  ///< dashed lines between nodes
  std::size_t most_faces = 12000;                                 ///< of what is drawn; finer surfaces are coarsened
};

/// A mesh as a picture: parallel projection, outer faces alone, shaded by their direction and painted from back to
/// front, a colour for each region, lines for beams; with a legend, axes and a scale. One self-contained SVG element
/// that sets itself to light and dark surroundings, below about 2 MB. A mesh without anything to draw gives a picture
/// that says so.
std::string mesh_picture_svg(const Mesh& mesh, const MeshPictureOptions& options = {});

/// The same of a model: its regions with a property, masses, supports, springs and links beside what the options ask.
std::string mesh_picture_svg(const FiniteElementModel& model, MeshPictureOptions options = {});

}  // namespace kalfem
