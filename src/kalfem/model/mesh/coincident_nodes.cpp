#include "kalfem/model/mesh/coincident_nodes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_map>

#include "kalfem/model/model_items.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Box = std::array<std::int64_t, 3>;

struct BoxHash {
  std::size_t operator()(const Box& box) const {
    std::uint64_t hash = 0;
    for (const auto number : box) {  // the finaliser of a 64-bit mixing hash, so that neighbours spread
      hash ^= static_cast<std::uint64_t>(number) + 0x9e3779b97f4a7c15ULL + (hash << 6U) + (hash >> 2U);
      hash = (hash ^ (hash >> 30U)) * 0xbf58476d1ce4e5b9ULL;
      hash ^= hash >> 27U;
    }
    return static_cast<std::size_t>(hash);
  }
};

/// Boxes are four tolerances wide, so that most places lie near none of their sides.
constexpr double box_widths = 4.0;

}  // namespace

std::vector<std::pair<Index, Index>> coincident_nodes(const Eigen::Matrix3Xd& places, const std::vector<bool>& marked,
                                                      double tolerance, int most_partners) {
  std::vector<std::pair<Index, Index>> pairs;
  if (places.cols() == 0 || !(tolerance > 0.0)) return pairs;
  const Eigen::Vector3d origin = places.rowwise().minCoeff();
  const double width = box_widths * tolerance;
  std::unordered_map<Box, Index, BoxHash> newest;  // in a box; each leads to the one before it
  newest.reserve(static_cast<std::size_t>(places.cols()));
  std::vector<Index> before(static_cast<std::size_t>(places.cols()), -1);
  const auto box_of = [&](const Eigen::Vector3d& place) {
    const Eigen::Vector3d scaled = (place - origin) / width;
    return Box{static_cast<std::int64_t>(std::floor(scaled[0])), static_cast<std::int64_t>(std::floor(scaled[1])),
               static_cast<std::int64_t>(std::floor(scaled[2]))};
  };
  for (Index node = 0; node < places.cols(); ++node) {
    if (!marked[static_cast<std::size_t>(node)]) continue;
    const Eigen::Vector3d place = places.col(node), reach = Eigen::Vector3d::Constant(tolerance);
    const Box low = box_of(place - reach), high = box_of(place + reach);
    int partners = 0;
    for (auto x = low[0]; x <= high[0]; ++x)
      for (auto y = low[1]; y <= high[1]; ++y)
        for (auto z = low[2]; z <= high[2]; ++z) {
          const auto found = newest.find({x, y, z});
          if (found == newest.end()) continue;
          for (Index other = found->second; other >= 0 && partners < most_partners;
               other = before[static_cast<std::size_t>(other)])
            if ((places.col(other) - place).norm() <= tolerance) {
              pairs.emplace_back(other, node);
              ++partners;
            }
        }
    const auto [entry, is_new] = newest.try_emplace(box_of(place), node);
    if (!is_new) before[static_cast<std::size_t>(node)] = std::exchange(entry->second, node);
  }
  std::ranges::sort(pairs);
  return pairs;
}

std::vector<bool> directly_joined(const FiniteElementModel& model, const std::vector<std::pair<Index, Index>>& pairs) {
  std::unordered_map<Index, std::vector<std::size_t>> items_at;  // of the nodes in question only
  for (const auto& [one, other] : pairs) items_at[one], items_at[other];
  std::size_t item = 0;
  visit_items(model, [&](std::span<const Index> nodes) {
    for (const auto node : nodes)
      if (const auto place = items_at.find(node); place != items_at.end()) place->second.push_back(item);
    ++item;
  });
  std::vector<bool> joined;
  for (const auto& [one, other] : pairs) {
    const auto &first = items_at[one], &second = items_at[other];  // ascending
    auto a = first.begin(), b = second.begin();
    while (a != first.end() && b != second.end() && *a != *b) ++(*a < *b ? a : b);
    joined.push_back(a != first.end() && b != second.end());
  }
  return joined;
}

}  // namespace kalfem
