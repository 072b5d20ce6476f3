// SPDX-License-Identifier: Apache-2.0
#include "kalfem/steps/correlation/agreement_report.hpp"

#include <fmt/format.h>

#include <numbers>

#include "kalfem/page/json_number.hpp"

namespace kalfem {
namespace {

double degrees(double angle) { return angle * 180.0 / std::numbers::pi; }

}  // namespace

Table agreement_table(const CorrelatedResponses& compared) {
  Table table{"Responses of '" + compared.name + "'", {"response", "FRAC", "model / measured", "phase [deg]"}, {}, {}};
  for (const auto& each : compared.responses)
    table.rows.push_back({each.name, fmt::format("{:.3f}", each.frac), fmt::format("{:.3g}", each.size),
                          each.phase ? fmt::format("{:.0f}", degrees(*each.phase)) : "-"});
  return table;
}

nlohmann::ordered_json json_of(const std::vector<ResponseAgreement>& responses) {
  auto all = nlohmann::ordered_json::array();
  for (const auto& each : responses)
    all.push_back({{"response", each.name},
                   {"frac", number(each.frac)},
                   {"model_to_measured", number(each.size)},
                   {"phase_deg", each.phase ? number(degrees(*each.phase)) : nlohmann::ordered_json()}});
  return all;
}

}  // namespace kalfem
