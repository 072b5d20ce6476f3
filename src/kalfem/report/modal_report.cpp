// SPDX-License-Identifier: Apache-2.0
#include "kalfem/report/modal_report.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "kalfem/base/atomic_file.hpp"
#include "kalfem/base/units.hpp"
#include "kalfem/base/version.hpp"
#include "kalfem/formats/universal/universal.hpp"
#include "kalfem/modal/real_shape.hpp"
#include "kalfem/page/json_number.hpp"
#include "kalfem/page/words.hpp"
#include "kalfem/pictures/heat_map.hpp"
#include "kalfem/report/stabilisation_diagram.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Json = nlohmann::ordered_json;

bool is_of_responses(const ModalResult& result) { return result.method == ModalMethod::rational_fraction; }

/// A value with so many digits that its deviation has two.
std::string rounded(double value, double deviation) {
  const int decimals = deviation > 0.0 ? std::clamp(1 - static_cast<int>(std::floor(std::log10(deviation))), 0, 12) : 4;
  return fmt::format("{:.{}f}", value, decimals);
}

Table mode_table(const ModalResult& result) {
  Table table{
      .title = "Modes",
      .columns = {"mode", "frequency [Hz]", "std", "damping [%]", "std", "MPC", "variance", "orders", "peak [Hz]"}};
  for (std::size_t i = 0; i < result.modes.size(); ++i) {
    const auto& mode = result.modes[i];
    const double damping = 100.0 * mode.damping, damping_std = 100.0 * mode.damping_std();
    table.rows.push_back({std::to_string(i + 1), rounded(mode.frequency, mode.frequency_std()),
                          rounded(mode.frequency_std(), mode.frequency_std()), rounded(damping, damping_std),
                          rounded(damping_std, damping_std), fmt::format("{:.3f}", mode.phase_collinearity),
                          fmt::format("{:.1f} %", 100.0 * mode.participation), std::to_string(mode.orders),
                          mode.spectral ? rounded(mode.spectral->frequency, mode.frequency_std()) : "-"});
  }
  return table;
}

Json shape_json(const ModalResult& result, const IdentifiedMode& mode) {
  const auto deviation = mode.shape_std();
  Json shape = Json::object();
  for (std::size_t i = 0; i < result.channels.size(); ++i) {
    const auto row = static_cast<Index>(i);
    shape[result.channels[i]] = {{"real", number(mode.shape[row].real())},
                                 {"imaginary", number(mode.shape[row].imag())},
                                 {"real_std", number(deviation[row].real())},
                                 {"imaginary_std", number(deviation[row].imag())}};
  }
  return shape;
}

Json rows_of(const Eigen::MatrixXd& matrix) {
  Json rows = Json::array();
  for (Index i = 0; i < matrix.rows(); ++i) {
    rows.push_back(Json::array());
    for (Index j = 0; j < matrix.cols(); ++j) rows.back().push_back(number(matrix(i, j)));
  }
  return rows;
}

Json mode_json(const ModalResult& result, const IdentifiedMode& mode) {
  const double factor = mode.coverage_factor(), of_frequency = factor * mode.frequency_std(),
               of_damping = factor * mode.damping_std();
  Json json{{"frequency_hz", number(mode.frequency)},
            {"frequency_std_hz", number(mode.frequency_std())},
            {"frequency_interval_hz", {number(mode.frequency - of_frequency), number(mode.frequency + of_frequency)}},
            {"damping", number(mode.damping)},
            {"damping_std", number(mode.damping_std())},
            {"damping_interval", {number(mode.damping - of_damping), number(mode.damping + of_damping)}},
            {"covariance_hz", number(mode.covariance(0, 1))},
            {"degrees_of_freedom", number(mode.degrees_of_freedom)},
            {"phase_collinearity", number(mode.phase_collinearity)},
            {"participation", number(mode.participation)},
            {"order", mode.order},
            {"orders", mode.orders},
            {"spectral_peak", nullptr},
            {"shape", shape_json(result, mode)}};
  if (mode.spectral)
    json["spectral_peak"] = {{"frequency_hz", number(mode.spectral->frequency)}, {"mac", number(mode.spectral->mac)}};
  return json;
}

/// Columns of numbers, as `update` and other programs read them.
std::string modes_csv(const ModalResult& result) {
  std::string text =
      "mode,frequency [Hz],frequency_std [Hz],damping,damping_std,degrees_of_freedom,"
      "phase_collinearity,participation,orders\n";
  for (std::size_t i = 0; i < result.modes.size(); ++i) {
    const auto& mode = result.modes[i];
    text += fmt::format("{},{},{},{},{},{},{},{},{}\n", i + 1, shortest(mode.frequency), shortest(mode.frequency_std()),
                        shortest(mode.damping), shortest(mode.damping_std()), shortest(mode.degrees_of_freedom),
                        shortest(mode.phase_collinearity), shortest(mode.participation), mode.orders);
  }
  return text;
}

std::string shapes_csv(const ModalResult& result) {
  const Eigen::MatrixXd shapes = real_shapes(result);
  std::string text = fmt::format("# rows: {}\n", fmt::join(result.channels, ", "));
  for (Index mode = 0; mode < shapes.cols(); ++mode) text += fmt::format("{}mode_{}", mode > 0 ? "," : "", mode + 1);
  text += "\n";
  for (Index row = 0; row < shapes.rows(); ++row) {
    for (Index mode = 0; mode < shapes.cols(); ++mode) text += (mode > 0 ? "," : "") + shortest(shapes(row, mode));
    text += "\n";
  }
  return text;
}

/// Node and translation of each channel; those without a place get nodes behind all others.
std::vector<MeasuredPlace> full_places(std::vector<MeasuredPlace> places) {
  long last = 0;
  for (const auto& place : places) last = std::max(last, place.node.value_or(0));
  for (auto& place : places) {
    if (!place.node) place = {.node = ++last, .direction = 1};
    if (place.direction == 0) place.direction = 1;
  }
  return places;
}

MeasuredFile universal_modes(const ModalResult& result, const std::vector<MeasuredPlace>& given) {
  MeasuredFile file{.format = "universal file", .description = "modes identified by kalfem"};
  const auto places = full_places(given);
  std::map<long, Index> row_of;
  bool rotations = false;
  for (const auto& place : places) {
    row_of.emplace(*place.node, 0);
    rotations = rotations || std::abs(place.direction) > 3;
  }
  Index next = 0;
  for (auto& [node, row] : row_of) row = next++;
  for (std::size_t i = 0; i < result.modes.size(); ++i) {
    const auto& mode = result.modes[i];
    MeasuredShape shape{.name = fmt::format("mode {}", i + 1), .frequency = mode.frequency, .damping = mode.damping};
    for (const auto& [node, row] : row_of) shape.nodes.push_back(node);
    shape.values = Eigen::MatrixXcd::Zero(next, rotations ? 6 : 3);
    for (std::size_t channel = 0; channel < places.size(); ++channel) {
      const auto& place = places[channel];
      const double sign = place.direction < 0 ? -1.0 : 1.0;
      shape.values(row_of.at(*place.node), std::abs(place.direction) - 1) =
          sign * mode.shape[static_cast<Index>(channel)];
    }
    file.shapes.push_back(std::move(shape));
  }
  return file;
}

}  // namespace

Eigen::MatrixXd real_shapes(const ModalResult& result) {
  Eigen::MatrixXd shapes(std::ssize(result.channels), std::ssize(result.modes));
  for (Index i = 0; i < shapes.cols(); ++i) {
    const Eigen::VectorXd real = real_shape(result.modes[static_cast<std::size_t>(i)].shape).values;
    Index top = 0;
    real.cwiseAbs().maxCoeff(&top);
    shapes.col(i) = real / real[top];
  }
  return shapes;
}

/// What the modes were identified from, and how.
static std::string heading(const std::string& source, const ModalResult& result) {
  const std::string channels = counted(std::ssize(result.channels), "channel");
  if (is_of_responses(result))
    return fmt::format(
        "{}: frequency responses of {} to {} at {}\nFractions of orders up to {}, then one modal model\n\n", source,
        channels, counted(std::ssize(result.references), "input"), counted(result.samples, "line"), result.max_order);
  return fmt::format(
      "{}: {}, {} at {} Hz ({} s)\nModels of orders 2 to {} from correlations over {}, deviations from {} blocks\n\n",
      source, channels, counted(result.samples, "sample"), four_digits(result.sample_rate),
      four_digits(static_cast<double>(result.samples) / result.sample_rate), result.max_order,
      counted(2 * result.block_rows - 1, "lag"), result.blocks);
}

std::string modal_text(const std::string& source, const ModalResult& result) {
  std::string text = heading(source, result);
  if (result.modes.empty())
    text += "No mode holds over the orders.\n";
  else
    text += to_text(mode_table(result));
  for (const auto& remark : result.remarks) text += "\n" + remark + "\n";
  return text;
}

Page modal_page(const std::string& source, const ModalResult& result) {
  Page page{.title = source,
            .subtitle = is_of_responses(result) ? "Modes identified from frequency responses"
                                                : "Modes identified from responses alone",
            .summary = counted(std::ssize(result.modes), "mode") + " of " +
                       counted(std::ssize(result.channels), "channel") + ".",
            .warnings = result.remarks};
  Section modes{.heading = "Modes",
                .text = is_of_responses(result)
                            ? "Standard deviations come from the scatter of the responses about the fitted modal model."
                            : "Standard deviations are of the record's finite length."};
  modes.items.emplace_back(mode_table(result));
  modes.items.emplace_back(Picture{.title = "Stabilisation diagram",
                                   .caption = is_of_responses(result)
                                                  ? "Blue: poles that hold over the orders; grey: other poles."
                                                  : "Blue: poles of modes, with two standard deviations to each side; "
                                                    "grey: other poles of the models.",
                                   .svg = stabilisation_svg(result)});
  if (!result.modes.empty()) {
    HeatMap shapes{.name = "Mode shapes",
                   .values = real_shapes(result),
                   .rows = result.channels,
                   .column_title = "mode",
                   .diverging = true};
    for (std::size_t i = 1; i <= result.modes.size(); ++i) shapes.columns.push_back(std::to_string(i));
    modes.items.emplace_back(Picture{.title = "Shapes",
                                     .caption = "Real parts in the units of the channels; the largest entry is 1.",
                                     .svg = heat_map_svg(shapes)});
  }
  page.sections.push_back(std::move(modes));
  return page;
}

Json modal_json(const std::string& source, const ModalResult& result) {
  Json json{{"kalfem", version},
            {"record", source},
            {"method", is_of_responses(result) ? "p-LSCF" : "subspace"},
            {"sample_rate_hz", number(result.sample_rate)},
            {"samples", result.samples},
            {"block_rows", result.block_rows},
            {"max_order", result.max_order},
            {"blocks", result.blocks},
            {"channels", result.channels},
            {"units", result.units},
            {"references", result.references},
            {"modes", Json::array()},
            {"diagram", Json::array()},
            {"remarks", result.remarks}};
  for (const auto& mode : result.modes) json["modes"].push_back(mode_json(result, mode));
  for (const auto& pole : result.diagram)
    json["diagram"].push_back({{"order", pole.order},
                               {"frequency_hz", number(pole.frequency)},
                               {"frequency_std_hz", number(pole.frequency_std)},
                               {"damping", number(pole.damping)},
                               {"stable", pole.stable}});
  return json;
}

void write_modal_files(const std::filesystem::path& folder, const std::string& source, const ModalResult& result,
                       const std::vector<MeasuredPlace>& places) {
  Json json = modal_json(source, result);
  for (std::size_t i = 0; i < result.modes.size(); ++i)
    json["modes"][i]["shape_covariance"] = rows_of(result.modes[i].shape_covariance);
  write_file_atomically(folder / "modes.json", json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
  write_file_atomically(folder / "modes.csv", modes_csv(result));
  write_file_atomically(folder / "shapes.csv", shapes_csv(result));
  write_universal(folder / "modes.unv", universal_modes(result, places));
}

}  // namespace kalfem
