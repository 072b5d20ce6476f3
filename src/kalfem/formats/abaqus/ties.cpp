#include <algorithm>
#include <cmath>

#include "kalfem/formats/abaqus/face_projection.hpp"
#include "kalfem/formats/abaqus/fields.hpp"
#include "kalfem/formats/abaqus/numbers.hpp"
#include "kalfem/formats/abaqus/supports.hpp"

namespace kalfem::abaqus {

namespace {

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

  /// The nearest face that does not hold the node itself, within one box.
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
  void tie_node(const std::string& name, Index node, const Face& face, const Projection& projection, bool rotations);

  PlacedDeck& deck_;
  Kinematics& motions_;
  std::vector<double> thickness_at_;
  std::vector<bool> turns_;  ///< whether a node has rotations
};

void TieMaker::read(const PlacedBlock& at) {
  const Keyword& keyword = at.block->keyword;
  if (keyword.has("CYCLICSYMMETRY") || keyword.has("MULTISTAGE"))
    deck_.problems.add(keyword.where, "*TIE, CYCLIC SYMMETRY is not read", "sectors are not turned into wholes",
                       "model the whole structure");
  else
    for (const auto& line : at.block->lines) tie(at, line);
}

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
    deck_.problems.add(line.where, "the second surface of *TIE, '" + shown(line.field(1)) + "', has no faces",
                       "the nodes of the first surface follow faces of the second",
                       "give it by elements and their faces");
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
      tie_node(name, node, faces[nearest->first], nearest->second, !keyword.has("NOROTATION"));
  }
  if (tied == 0)
    deck_.problems.add(
        line.where,
        "*TIE '" + shown(name) + "' ties no node: all lie farther from the second surface than its tolerance",
        "the parts would not be joined", "mend the surfaces, or give POSITION TOLERANCE");
  else if (far > 0)
    deck_.notes.add(
        deck_.problems.location(line.where), "*TIE '" + name + "'",
        std::to_string(far) + " of " + std::to_string(far + tied) + " nodes lie beyond its tolerance and are not tied");
}

/// u = sum N_i u_i and the motion by the turning of the face over the gap d: of faces with rotations sum N_i theta_i x
/// d, of others -(d . n) sum grad N_i (n . u_i), which is exact for rigid motion.
void TieMaker::tie_node(const std::string& name, Index node, const Face& face, const Projection& projection,
                        bool rotations) {
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
  if (!rotations || !masters_turn || !turns_[static_cast<std::size_t>(node)]) return;
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
