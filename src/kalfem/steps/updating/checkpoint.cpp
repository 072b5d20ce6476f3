// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/updating/checkpoint.hpp"

#include <bit>
#include <cstdint>
#include <nlohmann/json.hpp>

#include "kalfem/base/atomic_file.hpp"
#include "kalfem/base/regular_file.hpp"
#include "kalfem/base/version.hpp"
#include "kalfem/study/study.hpp"

namespace kalfem {

using Eigen::Index;
using Json = nlohmann::json;

namespace {

/// Thrown if the file is not as it was written.
struct Damaged {};

Json to_json(const Eigen::MatrixXd& matrix) {
  return {{"rows", matrix.rows()}, {"values", std::vector<double>(matrix.data(), matrix.data() + matrix.size())}};
}

Eigen::MatrixXd matrix_from(const Json& json) {
  const auto values = json.at("values").get<std::vector<double>>();
  const auto rows = json.at("rows").get<Index>(), size = static_cast<Index>(values.size());
  if (rows < 0 || (rows == 0 ? size > 0 : size % rows != 0)) throw Damaged();
  return Eigen::Map<const Eigen::MatrixXd>(values.data(), rows, rows > 0 ? size / rows : 0);
}

Json to_json(const GaussNewtonState& state) {
  return {{"parameters", to_json(state.parameters)},
          {"radius", state.radius},
          {"known", static_cast<int>(state.known)},
          {"residual_cost", state.residual_cost},
          {"jacobian_factor", to_json(state.jacobian_factor)},
          {"projected_residual", to_json(state.projected_residual)},
          {"factored_at", to_json(state.factored_at)},
          {"second_order", to_json(state.second_order)},
          {"with_second_order", state.with_second_order},
          {"evaluations", state.evaluations},
          {"iterations", state.iterations},
          {"without_response", state.without_response},
          {"refused", state.refused}};
}

GaussNewtonState state_from(const Json& json) {
  GaussNewtonState state;
  state.parameters = matrix_from(json.at("parameters"));
  state.radius = json.at("radius");
  state.known = static_cast<GaussNewtonState::Known>(json.at("known").get<int>());
  state.residual_cost = json.at("residual_cost");
  state.jacobian_factor = matrix_from(json.at("jacobian_factor"));
  state.projected_residual = matrix_from(json.at("projected_residual"));
  state.factored_at = matrix_from(json.at("factored_at"));
  state.second_order = matrix_from(json.at("second_order"));
  state.with_second_order = json.at("with_second_order");
  state.evaluations = json.at("evaluations");
  state.iterations = json.at("iterations");
  state.without_response = json.at("without_response");
  state.refused = json.at("refused");
  return state;
}

bool is_known(GaussNewtonState::Known known) {
  return known >= GaussNewtonState::Known::nothing && known <= GaussNewtonState::Known::no_derivatives;
}

// A file that parses can still be damaged. The state must have the sizes of this problem, finite numbers, and counters
// and radii that a search can reach; otherwise the search would continue from an invalid state.
void require_whole(const GaussNewtonState& state, Index parameters) {
  const auto is_square = [&](const Eigen::MatrixXd& matrix) {
    return matrix.rows() == parameters && matrix.cols() == parameters;
  };
  const bool has_factor = state.known == GaussNewtonState::Known::derivatives || state.factored_at.size() > 0;
  const bool sized = state.parameters.size() == parameters &&
                     (!has_factor || (is_square(state.jacobian_factor) && state.factored_at.size() == parameters &&
                                      state.projected_residual.size() == parameters)) &&
                     (state.second_order.size() == 0 || is_square(state.second_order));
  const bool counted =
      state.evaluations >= 0 && state.iterations >= 0 && state.without_response >= 0 && state.refused >= 0;
  if (!sized || !counted || !is_known(state.known) || !state.parameters.allFinite() ||
      !state.jacobian_factor.allFinite() || !state.projected_residual.allFinite() || !state.factored_at.allFinite() ||
      !state.second_order.allFinite() || !(state.radius > 0.0) || !(state.residual_cost >= 0.0))
    throw Damaged();
}

void require_whole(const UpdatingStep& step, Index parameters) {
  if (step.tried.size() != parameters || step.parameters.size() != parameters) throw Damaged();
}

Json to_json(const UpdatingStep& step) {
  return {{"accepted", step.accepted},
          {"tried", to_json(step.tried)},
          {"parameters", to_json(step.parameters)},
          {"residual", step.residual},
          {"seconds", step.seconds}};
}

UpdatingStep step_from(const Json& json) {
  return {json.at("accepted"), matrix_from(json.at("tried")), matrix_from(json.at("parameters")), json.at("residual"),
          json.at("seconds")};
}

}  // namespace

UpdatingCheckpoint::UpdatingCheckpoint(const std::filesystem::path& folder, std::string fingerprint, Index parameters)
    : file_(folder.empty() ? folder : folder / checkpoint_name),
      fingerprint_(std::move(fingerprint)),
      parameters_(parameters) {}

std::optional<UpdatingCheckpoint::Content> UpdatingCheckpoint::read() const {
  if (file_.empty() || !std::filesystem::exists(file_)) return std::nullopt;
  try {
    const Json json = Json::parse(bytes_if_readable(file_));
    if (json.at("fingerprint") != fingerprint_) return std::nullopt;
    Content content{state_from(json.at("state")), {}};
    require_whole(content.state, parameters_);
    for (const auto& step : json.at("trace")) {
      content.trace.push_back(step_from(step));
      require_whole(content.trace.back(), parameters_);
    }
    return content;
  } catch (const Json::exception&) {
    return std::nullopt;
  } catch (const Damaged&) {
    return std::nullopt;
  }
}

void UpdatingCheckpoint::write(const Content& content) const {
  if (file_.empty()) return;
  Json trace = Json::array();
  for (const auto& step : content.trace) trace.push_back(to_json(step));
  const Json json{{"fingerprint", fingerprint_}, {"state", to_json(content.state)}, {"trace", trace}};
  write_file_atomically(file_, json.dump(1) + "\n");
}

std::string fingerprint_of(const Study& study, double first_value) {
  return std::string(version) + "-" + std::to_string(std::hash<std::string>{}(study.resolved_case)) + "-" +
         std::to_string(std::bit_cast<std::uint64_t>(first_value));
}

}  // namespace kalfem
