// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "kalfem/formats/abaqus/kinematics.hpp"
#include "kalfem/formats/abaqus/raw_deck.hpp"

namespace kalfem::abaqus {
namespace {

/// The point of a face nearest to a place.
struct Projection {
  Eigen::VectorXd shares;                              ///< shape functions of the face's nodes there
  Eigen::Matrix<double, 3, Eigen::Dynamic> gradients;  ///< of the shape functions, along the surface [1/m]
  Eigen::Vector3d point, normal;
  double distance = 0.0;
};

struct Shape {
  Eigen::VectorXd values;
  Eigen::Matrix<double, Eigen::Dynamic, 2> slopes;
};

/// Triangles over r, s >= 0, r + s <= 1.
Shape triangle(double r, double s, bool quadratic) {
  const double t = 1.0 - r - s;
  Shape shape;
  if (!quadratic) {
    shape.values = Eigen::Vector3d(t, r, s);
    shape.slopes.resize(3, 2);
    shape.slopes << -1, -1, 1, 0, 0, 1;
    return shape;
  }
  shape.values.resize(6);
  shape.values << t * (2 * t - 1), r * (2 * r - 1), s * (2 * s - 1), 4 * t * r, 4 * r * s, 4 * s * t;
  shape.slopes.resize(6, 2);
  shape.slopes << 1 - 4 * t, 1 - 4 * t, 4 * r - 1, 0, 0, 4 * s - 1, 4 * (t - r), -4 * r, 4 * s, 4 * r, -4 * s,
      4 * (t - s);
  return shape;
}

/// Quadrilaterals over -1 <= r, s <= 1, bilinear or of the serendipity family.
Shape quadrilateral(double r, double s, bool quadratic) {
  static constexpr std::array<std::array<double, 2>, 4> corner = {{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}};
  Shape shape;
  shape.values.resize(quadratic ? 8 : 4);
  shape.slopes.resize(quadratic ? 8 : 4, 2);
  for (Index i = 0; i < 4; ++i) {
    const auto [a, b] = corner[static_cast<std::size_t>(i)];
    const double p = 1 + a * r, q = 1 + b * s;
    if (!quadratic) {
      shape.values[i] = p * q / 4;
      shape.slopes.row(i) << a * q / 4, b * p / 4;
    } else {
      const double sum = a * r + b * s;
      shape.values[i] = p * q * (sum - 1) / 4;
      shape.slopes.row(i) << a * q * (sum - 1 + p) / 4, b * p * (sum - 1 + q) / 4;
    }
  }
  if (!quadratic) return shape;
  const double rr = 1 - r * r, ss = 1 - s * s;
  shape.values.tail<4>() << rr * (1 - s) / 2, ss * (1 + r) / 2, rr * (1 + s) / 2, ss * (1 - r) / 2;
  shape.slopes.bottomRows<4>() << -r * (1 - s), -rr / 2, ss / 2, -s * (1 + r), -r * (1 + s), rr / 2, -ss / 2,
      -s * (1 - r);
  return shape;
}

/// Moves the parameters back into the face.
void keep_inside(Eigen::Vector2d& parameters, bool three) {
  if (!three) {
    parameters = parameters.cwiseMax(-1.0).cwiseMin(1.0);
    return;
  }
  parameters = parameters.cwiseMax(0.0);
  if (const double excess = parameters.sum() - 1.0; excess > 0.0) {
    parameters.array() -= excess / 2.0;
    parameters = parameters.cwiseMax(0.0).cwiseMin(1.0);
  }
}

/// Newton's method on the squared distance, kept within the face. Faces with 3, 4, 6 and 8 nodes; nothing for others
/// and for faces without area.
std::optional<Projection> project(const Mesh& mesh, const Face& face, const Eigen::Vector3d& place) {
  const bool three = face.corners == 3;
  const std::size_t count = face.nodes.size();
  if ((!three && face.corners != 4) || (count != face.corners && count != 2 * face.corners)) return {};
  const bool quadratic = count > face.corners;
  Eigen::Matrix3Xd nodes(3, static_cast<Index>(count));
  for (std::size_t i = 0; i < count; ++i) nodes.col(static_cast<Index>(i)) = mesh.nodes.col(face.nodes[i]);
  const auto shape_at = [&](const Eigen::Vector2d& p) {
    return three ? triangle(p.x(), p.y(), quadratic) : quadrilateral(p.x(), p.y(), quadratic);
  };
  Eigen::Vector2d parameters = three ? Eigen::Vector2d(1.0 / 3.0, 1.0 / 3.0) : Eigen::Vector2d(0.0, 0.0);
  Shape shape = shape_at(parameters);
  Eigen::Matrix<double, 3, 2> tangents;
  for (int iteration = 0; iteration < 20; ++iteration) {
    tangents = nodes * shape.slopes;
    const Eigen::Matrix2d metric = tangents.transpose() * tangents;
    if (!(metric.determinant() > 1e-20 * metric.trace() * metric.trace())) return {};
    const Eigen::Vector2d step = metric.inverse() * tangents.transpose() * (place - nodes * shape.values);
    const Eigen::Vector2d before = parameters;
    parameters += step;
    keep_inside(parameters, three);
    shape = shape_at(parameters);
    if ((parameters - before).norm() < 1e-12) break;
  }
  tangents = nodes * shape.slopes;
  const Eigen::Matrix2d metric = tangents.transpose() * tangents;
  if (!(metric.determinant() > 1e-20 * metric.trace() * metric.trace())) return {};
  Projection result;
  result.shares = shape.values;
  result.gradients = tangents * metric.inverse() * shape.slopes.transpose();
  result.point = nodes * shape.values;
  result.normal = tangents.col(0).cross(tangents.col(1)).normalized();
  result.distance = (place - result.point).norm();
  return result;
}

/// Finds the faces near a place by a grid of boxes.
class FaceGrid {
public:
  /// No box is smaller than a face, so that a face lies in a few of them.
  FaceGrid(const Mesh& mesh, const std::vector<Face>& faces, double box) : mesh_(mesh), faces_(faces), box_(box) {
    for (std::size_t i = 0; i < faces.size(); ++i) {
      Eigen::Vector3d low = mesh.nodes.col(faces[i].nodes.front()), high = low;
      for (const Index node : faces[i].nodes) {
        low = low.cwiseMin(mesh.nodes.col(node));
        high = high.cwiseMax(mesh.nodes.col(node));
      }
      const auto first = cell(low), last = cell(high);
      for (auto x = first[0]; x <= last[0]; ++x)
        for (auto y = first[1]; y <= last[1]; ++y)
          for (auto z = first[2]; z <= last[2]; ++z) boxes_[{x, y, z}].push_back(i);
    }
  }

  /// The nearest face within one box; a face that holds the node itself has the distance 0.
  std::optional<std::pair<std::size_t, Projection>> nearest(Index node) const {
    const Eigen::Vector3d place = mesh_.nodes.col(node);
    const auto centre = cell(place);
    std::vector<std::size_t> near;
    for (long x = -1; x <= 1; ++x)
      for (long y = -1; y <= 1; ++y)
        for (long z = -1; z <= 1; ++z)
          if (const auto box = boxes_.find({centre[0] + x, centre[1] + y, centre[2] + z}); box != boxes_.end())
            near.insert(near.end(), box->second.begin(), box->second.end());
    std::ranges::sort(near);
    near.erase(std::unique(near.begin(), near.end()), near.end());
    std::optional<std::pair<std::size_t, Projection>> best;
    for (const std::size_t i : near)
      if (auto projection = project(mesh_, faces_[i], place))
        if (!best || projection->distance < best->second.distance) best.emplace(i, std::move(*projection));
    return best;
  }

private:
  using Key = std::array<long, 3>;
  [[nodiscard]] Key cell(const Eigen::Vector3d& place) const {
    const auto along = [&](double x) { return std::lround(std::clamp(std::floor(x / box_), -1e15, 1e15)); };
    return {along(place.x()), along(place.y()), along(place.z())};
  }

  const Mesh& mesh_;
  const std::vector<Face>& faces_;
  double box_;
  std::map<Key, std::vector<std::size_t>> boxes_;
};

double half_thickness(const RegionProperty& property) {
  const auto* shell = std::get_if<ShellProperty>(&property);
  return shell ? 0.5 * shell->thickness : 0.0;
}

/// Ties the nodes of one surface to the faces of another.
class TieMaker {
public:
  TieMaker(PlacedDeck& deck, const FiniteElementModel& model, Kinematics& motions)
      : deck_(deck),
        motions_(motions),
        thickness_at_(static_cast<std::size_t>(deck.mesh.node_count()), 0.0),
        turns_(static_cast<std::size_t>(deck.mesh.node_count()), false) {
    for (const auto& [region, property] : model.properties)
      for (const Index cell : model.mesh.regions.at(region))
        for (const Index node : model.mesh.nodes_of(model.mesh.cells[static_cast<std::size_t>(cell)])) {
          auto& most = thickness_at_[static_cast<std::size_t>(node)];
          most = std::max(most, half_thickness(property));
          if (motions_per_node(property) == 6) turns_[static_cast<std::size_t>(node)] = true;
        }
  }

  void read(const PlacedBlock& at);

private:
  void tie(const PlacedBlock& at, const DataLine& line);
  void tie_node(const std::string& name, Index node, const Face& face, const Projection& projection,
                const Keyword& keyword);

  PlacedDeck& deck_;
  Kinematics& motions_;
  std::vector<double> thickness_at_;
  std::vector<bool> turns_;  ///< whether a node has rotations
};

void TieMaker::read(const PlacedBlock& at) {
  const Keyword& keyword = at.block->keyword;
  if (keyword.has("CYCLICSYMMETRY") || keyword.has("MULTISTAGE"))
    deck_.problems.add(keyword.where, "*TIE, CYCLIC SYMMETRY is not read", "cyclic sectors are not expanded",
                       "model the whole structure");
  else
    for (const auto& line : at.block->lines) tie(at, line);
}

// Each slave node follows the nearest master face within the tolerance: POSITION TOLERANCE, or 5 % of a typical side
// plus half the thickness of shells on either surface, since their nodes lie on mid-surfaces. A node that belongs to
// the face is tied by sharing it. A tie that catches no node at all is a problem, a partial one a note.
void TieMaker::tie(const PlacedBlock& at, const DataLine& line) {
  const Keyword& keyword = at.block->keyword;
  const Surface slaves = find_surface(deck_, line.field(0), at.place, line.where);
  const Surface masters = find_surface(deck_, line.field(1), at.place, line.where);
  if (slaves.nodes.empty() || masters.nodes.empty()) return;
  std::vector<Face> faces;
  double size = 0.0, largest = 0.0;
  for (const auto& face : masters.faces) {
    if (face.corners < 3) continue;
    faces.push_back(face);
    size += (deck_.mesh.nodes.col(face.nodes[0]) - deck_.mesh.nodes.col(face.nodes[1])).norm();
    for (const Index node : face.nodes)
      largest = std::max(largest, (deck_.mesh.nodes.col(node) - deck_.mesh.nodes.col(face.nodes[0])).norm());
  }
  if (faces.empty()) {
    deck_.problems.add(line.where, "the second surface of *TIE, '" + to_string(line.field(1)) + "', has no faces",
                       "the nodes of the first surface must follow faces of the second",
                       "define it by elements and their faces");
    return;
  }
  size /= static_cast<double>(faces.size());
  std::string name = keyword.get("NAME");
  name = deck_.place(at.place).full_name(name.empty() ? "tie." + std::to_string(keyword.where.line) : name);
  const auto given = number_parameter(keyword, "POSITIONTOLERANCE", deck_.problems);
  double thickest = 0.0;
  for (const Index node : masters.nodes) thickest = std::max(thickest, thickness_at_[static_cast<std::size_t>(node)]);
  double reach = 0.0;
  for (const Index node : slaves.nodes)
    reach = std::max(reach, given.value_or(0.05 * size + thickest + thickness_at_[static_cast<std::size_t>(node)]));
  const FaceGrid grid(deck_.mesh, faces, std::max({largest, std::min(reach, 100.0 * size), 1e-300}));
  std::size_t tied = 0, far = 0;
  for (const Index node : slaves.nodes) {
    const auto nearest = grid.nearest(node);
    const double tolerance = given.value_or(0.05 * size + thickest + thickness_at_[static_cast<std::size_t>(node)]);
    if (!nearest || nearest->second.distance > tolerance * (1.0 + 1e-9)) {
      ++far;
      continue;
    }
    ++tied;
    if (std::ranges::find(faces[nearest->first].nodes, node) == faces[nearest->first].nodes.end())
      tie_node(name, node, faces[nearest->first], nearest->second, keyword);
  }
  if (tied == 0)
    deck_.problems.add(
        line.where,
        "*TIE '" + to_string(name) + "' ties no node: all are farther from the second surface than the tolerance",
        "the parts would not be connected", "correct the surfaces or give POSITION TOLERANCE");
  else if (far > 0)
    deck_.notes.add(deck_.problems.location(line.where), "*TIE '" + name + "'",
                    std::to_string(far) + " of " + std::to_string(far + tied) +
                        " nodes are farther away than the tolerance and are not tied",
                    DeckNoteKind::changed);
}

/// u = sum N_i u_i and the motion by the turning of the face over the gap d: of faces with rotations sum N_i theta_i x
/// d, of others -(d . n) sum grad N_i (n . u_i), which is exact for rigid motion.
void TieMaker::tie_node(const std::string& name, Index node, const Face& face, const Projection& projection,
                        const Keyword& keyword) {
  const Eigen::Vector3d gap = deck_.mesh.nodes.col(node) - projection.point;
  const bool masters_turn =
      std::ranges::all_of(face.nodes, [&](Index master) { return turns_[static_cast<std::size_t>(master)]; });
  const double height = gap.dot(projection.normal);
  for (int d = 0; d < 3; ++d) {
    DofSum terms = {{{node, d}, -1.0}};
    for (std::size_t i = 0; i < face.nodes.size(); ++i) {
      const auto column = static_cast<Index>(i);
      const double share = projection.shares[column];
      if (masters_turn) {
        for (const auto& [dof, factor] : slave_motion(face.nodes[i], d, gap)) terms.push_back({dof, share * factor});
        continue;
      }
      terms.push_back({{face.nodes[i], d}, share});
      for (int a = 0; a < 3; ++a)
        terms.push_back({{face.nodes[i], a}, -height * projection.gradients(d, column) * projection.normal[a]});
    }
    motions_.add_equation(name, std::move(terms), NodalDof{node, d});
  }
  if (!masters_turn || !turns_[static_cast<std::size_t>(node)] || keyword.has("NOROTATION")) return;
  for (int d = 3; d < 6; ++d) {
    DofSum terms = {{{node, d}, -1.0}};
    for (std::size_t i = 0; i < face.nodes.size(); ++i)
      terms.push_back({{face.nodes[i], d}, projection.shares[static_cast<Index>(i)]});
    motions_.add_equation(name, std::move(terms), NodalDof{node, d});
  }
}

}  // namespace

void read_ties(PlacedDeck& deck, const FiniteElementModel& model, Kinematics& motions) {
  const auto ties = deck.blocks("TIE");
  if (ties.empty()) return;
  TieMaker maker(deck, model, motions);
  for (const auto& at : ties) maker.read(at);
}

}  // namespace kalfem::abaqus
