// SPDX-License-Identifier: Apache-2.0
#include "kalfem/pictures/scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>

#include "kalfem/pictures/mesh_picture.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Json = nlohmann::ordered_json;

// ---- numbers as text

std::string base64(std::span<const std::byte> bytes) {
  static constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8U | (k < count ? std::to_integer<std::uint32_t>(bytes[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k) text += k <= count ? digits[group >> (18U - 6U * k) & 63U] : '=';
  }
  return text;
}

static_assert(std::endian::native == std::endian::little, "the page's script reads little-endian numbers");

/// The values as numbers of another type, in the order in which they stand in memory.
template <typename Number, typename Values>
std::string packed(const Values& values) {
  std::vector<Number> numbers;
  numbers.reserve(static_cast<std::size_t>(values.size()));
  for (const auto value : values) numbers.push_back(static_cast<Number>(value));
  return base64(std::as_bytes(std::span(numbers)));
}

constexpr double largest_step = 32767.0;

/// Each value as so many steps of 1 / 32767 of the largest one.
Json shape_json(const VectorXd& shape) {
  const double largest = std::max(shape.cwiseAbs().maxCoeff(), 1e-300);
  return {{"factor", largest / largest_step},
          {"steps", packed<std::int16_t>((shape * (largest_step / largest)).array().round().reshaped())}};
}

// ---- parts of a scene

const char* name(SceneMarkKind kind) {
  switch (kind) {
    case SceneMarkKind::sensor:
      return "sensor";
    case SceneMarkKind::input:
      return "input";
    case SceneMarkKind::boundary:
      return "boundary";
    case SceneMarkKind::connector:
      return "connector";
    case SceneMarkKind::spring:
      return "spring";
    case SceneMarkKind::mass:
      return "mass";
    case SceneMarkKind::measured:
      return "measured";
    case SceneMarkKind::support:
      break;
  }
  return "support";
}

/// Largest displacement of any place at any time.
double peak_of(const SceneField& field) {
  const MatrixXd motion = field.times.empty() ? field.shapes : MatrixXd(field.shapes * field.coordinates);
  double peak = 0.0;
  for (Index k = 0; k < motion.cols(); ++k)
    peak = std::max(peak, motion.col(k).reshaped(3, motion.rows() / 3).colwise().norm().maxCoeff());
  return peak;
}

Json field_json(const SceneField& field) {
  Json shapes = Json::array();
  for (const auto shape : field.shapes.colwise()) shapes.push_back(shape_json(shape));
  Json json{{"name", field.name}, {"peak", peak_of(field)}, {"shapes", std::move(shapes)}};
  if (field.measured) json["measured"] = true;
  if (field.times.empty()) return json;
  json["times"] = packed<float>(field.times);
  json["coordinates"] = packed<float>(field.coordinates.reshaped());
  return json;
}

/// Faces one after the other, each as its region, its number of corners and its corners.
Json faces_json(const std::vector<DrawnFace>& faces) {
  std::vector<Index> numbers;
  for (const auto& face : faces) {
    numbers.insert(numbers.end(), {face.region, face.count});
    numbers.insert(numbers.end(), face.nodes.begin(), face.nodes.begin() + face.count);
  }
  return packed<std::int32_t>(numbers);
}

Json regions_json(const std::vector<std::string>& regions) {
  Json list = Json::array();
  for (std::size_t r = 0; r < regions.size(); ++r) list.push_back({{"name", regions[r]}, {"colour", region_colour(r)}});
  return list;
}

std::string mistake_of(const SceneField& field, Index places) {
  const bool mode = field.times.empty();
  if (field.shapes.rows() != 3 * places)
    return fmt::format("its shapes have {} rows for {} places", field.shapes.rows(), places);
  if (field.shapes.cols() < 1 || (mode && field.shapes.cols() != 1))
    return fmt::format("it has {} shapes", field.shapes.cols());
  if (!mode && (field.coordinates.rows() != field.shapes.cols() ||
                field.coordinates.cols() != static_cast<Index>(field.times.size())))
    return fmt::format("its coordinates are {} x {} for {} shapes at {} times", field.coordinates.rows(),
                       field.coordinates.cols(), field.shapes.cols(), field.times.size());
  if (!field.shapes.allFinite() || !field.coordinates.allFinite()) return "it holds a number that is not finite";
  if (std::ranges::adjacent_find(field.times, std::greater_equal()) != field.times.end())
    return "its times do not increase";
  return "";
}

}  // namespace

// The shapes are the left singular vectors of the displacements, found from their small Gram matrix over time: with
// U^T U = V L V^T the shapes are U V and the coordinates V^T; the eigenvalues left out are the squared error.
SceneField motion_field(const std::string& name, const std::vector<double>& times, const MatrixXd& displacement,
                        Index most_shapes, double tolerance) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> gram(displacement.transpose() * displacement);
  const Index all = gram.eigenvalues().size();
  const double allowed = tolerance * tolerance * gram.eigenvalues().sum();
  Index kept = std::min(most_shapes, all);
  while (kept > 1 && gram.eigenvalues().head(all - kept + 1).cwiseMax(0.0).sum() <= allowed) --kept;
  const MatrixXd principal = gram.eigenvectors().rightCols(kept).rowwise().reverse();
  return {name, displacement * principal, times, principal.transpose()};
}

std::vector<std::string> mistakes_of(const Scene& scene) {
  std::vector<std::string> mistakes;
  const Index places = scene.places.cols();
  const auto outside = [&](Index place) { return place < 0 || place >= places; };
  if (scene.faces.empty()) mistakes.emplace_back("it has no faces");
  if (!scene.places.allFinite()) mistakes.emplace_back("a place is not finite");
  const auto bad_face = [&](const DrawnFace& face) {
    return face.count < 2 || face.count > 4 || face.region < 0 ||
           static_cast<std::size_t>(face.region) >= scene.regions.size() ||
           std::any_of(face.nodes.begin(), face.nodes.begin() + std::clamp(face.count, 0, 4), outside);
  };
  if (std::ranges::any_of(scene.faces, bad_face))
    mistakes.emplace_back("a face names a corner or region that it has not");
  if (std::ranges::any_of(scene.marks, outside, &SceneMark::place)) mistakes.emplace_back("a mark has no place");
  if (std::ranges::any_of(scene.lines, [&](const auto& line) { return outside(line.from) || outside(line.to); }))
    mistakes.emplace_back("a line has no place");
  for (const auto& field : scene.fields)
    if (const auto mistake = mistake_of(field, places); !mistake.empty())
      mistakes.push_back("field '" + field.name + "': " + mistake);
  return mistakes;
}

Json as_json(const Scene& scene) {
  Json marks = Json::array(), lines = Json::array(), fields = Json::array();
  for (const auto& mark : scene.marks)
    marks.push_back({{"kind", name(mark.kind)}, {"place", mark.place}, {"label", mark.label}});
  for (const auto& line : scene.lines) {
    lines.push_back({{"dashed", line.kind == SceneLineKind::connector}, {"places", {line.from, line.to}}});
    if (line.kind == SceneLineKind::measured) lines.back()["measured"] = true;
  }
  for (const auto& field : scene.fields) fields.push_back(field_json(field));
  return {{"places", packed<float>(scene.places.reshaped())},
          {"faces", faces_json(scene.faces)},
          {"regions", regions_json(scene.regions)},
          {"marks", std::move(marks)},
          {"lines", std::move(lines)},
          {"fields", std::move(fields)}};
}

}  // namespace kalfem
