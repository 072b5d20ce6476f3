// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "kalfem/page/words.hpp"
#include "kalfem/pictures/mesh_picture.hpp"
#include "kalfem/steps/statics/outcome.hpp"
#include "kalfem/steps/statics/report.hpp"

namespace kalfem {
namespace {

using Eigen::Index;

/// Bands of equal width from the smallest to the largest stress.
const std::vector<std::string> band_colours = {"#3b4cc0", "#6788ee", "#9abbff", "#c9d7f0",
                                               "#edd1c2", "#f7a889", "#e26952", "#b40426"};

/// Largest stress of each cell: von Mises at the centre, of beams the axial one; NaN where there is none.
Eigen::VectorXd cell_stresses(const Mesh& mesh, const SolvedLoadCase& each) {
  Eigen::VectorXd values = Eigen::VectorXd::Constant(static_cast<Index>(mesh.cells.size()), NAN);
  const auto offer = [&](Index cell, double value) {
    if (!(values[cell] >= std::abs(value))) values[cell] = std::abs(value);
  };
  for (const auto& region : each.stresses) {
    for (const auto& cell : region.cells)
      for (const auto& layer : cell.layers) offer(cell.cell, von_mises(layer.centre));
    for (const auto& beam : region.beams)
      for (std::size_t end = 0; end < 2; ++end) {
        offer(beam.cell, beam.axial[end]);
        if (beam.fibres[end]) offer(beam.cell, std::max(beam.fibres[end]->highest, -beam.fibres[end]->lowest));
      }
  }
  return values;
}

/// The deformed mesh with the cells of each band of stress as a region.
class StressPicture {
public:
  StressPicture(const Mesh& mesh, const SolvedLoadCase& each) : mesh_(mesh), stresses_(cell_stresses(mesh, each)) {
    if (!each.peaks.empty()) take_peak(each.peaks.front());
    deform(each.solution.displacements);
    divide_into_bands();
    if (!each.peaks.empty()) options_.marks.push_back({MarkKind::point, each.peaks.front().node, "largest stress"});
  }

  [[nodiscard]] std::string svg() const { return mesh_picture_svg(mesh_, options_); }
  [[nodiscard]] double magnification() const { return magnification_; }
  [[nodiscard]] bool has_stresses() const { return !mesh_.regions.empty(); }

private:
  /// The largest displacement is drawn as 6 % of the model's size, to a round factor.
  void deform(const Eigen::VectorXd& displacements) {
    const Eigen::Matrix3Xd moved = displacements.reshaped(6, mesh_.node_count()).topRows(3);
    const double size = (mesh_.nodes.rowwise().maxCoeff() - mesh_.nodes.rowwise().minCoeff()).norm();
    const double largest = moved.colwise().norm().maxCoeff();
    if (!(largest > 0.0)) return;
    magnification_ = 0.06 * size / largest;
    const double decade = std::pow(10.0, std::floor(std::log10(magnification_)));
    magnification_ = std::floor(magnification_ / decade) * decade;
    mesh_.nodes += magnification_ * moved;
  }

  /// The elements at the node of the largest stress have its band, so that the key ends at the largest stress.
  void take_peak(const StressPeak& peak) {
    highest_at_node_ = std::abs(peak.value);
    stresses_[peak.cell] = std::fmax(stresses_[peak.cell], highest_at_node_);
  }

  void divide_into_bands() {
    mesh_.regions.clear();
    double lowest = INFINITY, highest = 0.0;
    for (const double value : stresses_)
      if (!std::isnan(value)) lowest = std::min(lowest, value), highest = std::max(highest, value);
    highest = std::max(highest, highest_at_node_);
    const auto count = static_cast<int>(band_colours.size());
    const double width = (highest - lowest) / count;
    for (int band = count; band-- > 0;) {
      const double from = lowest + band * width;
      const std::string name =
          fmt::format("{} to {} MPa", four_digits(1e-6 * from), four_digits(1e-6 * (from + width)));
      std::vector<Index> cells;
      for (Index cell = 0; cell < stresses_.size(); ++cell)
        if (!std::isnan(stresses_[cell]) && band_of(stresses_[cell], lowest, width) == band) cells.push_back(cell);
      if (cells.empty()) continue;
      mesh_.regions[name] = std::move(cells);
      options_.regions.push_back(name);
      options_.region_colours.push_back(band_colours[static_cast<std::size_t>(band)]);
    }
  }

  static int band_of(double value, double lowest, double width) {
    const auto last = static_cast<int>(band_colours.size()) - 1;
    return width > 0.0 ? std::min(last, static_cast<int>((value - lowest) / width)) : 0;
  }

  Mesh mesh_;
  Eigen::VectorXd stresses_;
  double magnification_ = 0.0, highest_at_node_ = 0.0;
  MeshPictureOptions options_;
};

}  // namespace

Section statics_section(const StaticsPlan& plan, const StaticsOutcome& outcome) {
  Section section{"Statics of '" + outcome.substructure + "'", statics_answer(outcome), {}};
  for (const auto& table : {static_points_table(outcome), reactions_table(outcome), stresses_table(plan, outcome)})
    if (!table.rows.empty()) section.items.emplace_back(table);
  for (const auto& each : outcome.cases) {
    const StressPicture picture(plan.part->elements.mesh, each);
    if (!picture.has_stresses()) continue;
    section.items.emplace_back(Picture{
        .title = "Load case " + each.solution.load_case,
        .caption = fmt::format("Von Mises stress at the centre of each element, of the one with the largest stress "
                               "that at its node; of beams the axial stress; displacements drawn {:g} times as large.",
                               picture.magnification()),
        .svg = picture.svg()});
  }
  return section;
}

}  // namespace kalfem
