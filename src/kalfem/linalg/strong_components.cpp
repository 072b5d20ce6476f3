#include "kalfem/linalg/strong_components.hpp"

#include <algorithm>

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

/// Edges in one direction as adjacency lists.
using Graph = std::vector<std::vector<Index>>;

Graph edges_into(const Eigen::Ref<const MatrixXd>& A) {
  Graph sources(static_cast<std::size_t>(A.rows()));
  for (Index j = 0; j < A.cols(); ++j)
    for (Index i = 0; i < A.rows(); ++i)
      if (i != j && A(i, j) != 0.0) sources[static_cast<std::size_t>(i)].push_back(j);
  return sources;
}

/// Tarjan's algorithm without recursion over the edges from a node to those that act on it: a group is complete only
/// after all that act on it, which is the order wanted. SIAM J. Comput. 1 (1972) 146-160.
class Search {
public:
  explicit Search(const Graph& sources)
      : sources_(sources), order_(sources.size(), unseen), lowest_(sources.size()), open_(sources.size(), false) {}

  std::vector<std::vector<Index>> run() {
    for (std::size_t node = 0; node < sources_.size(); ++node)
      if (order_[node] == unseen) visit(node);
    return std::move(groups_);
  }

private:
  static constexpr std::size_t unseen = static_cast<std::size_t>(-1);
  struct Visit {
    std::size_t node, next_edge;
  };

  void visit(std::size_t root) {
    std::vector<Visit> path{enter(root)};
    while (!path.empty()) {
      auto& [node, next_edge] = path.back();
      if (next_edge < sources_[node].size()) {
        const auto target = static_cast<std::size_t>(sources_[node][next_edge++]);
        if (order_[target] == unseen)
          path.push_back(enter(target));
        else if (open_[target])
          lowest_[node] = std::min(lowest_[node], order_[target]);
        continue;
      }
      const std::size_t done = node;
      path.pop_back();
      if (!path.empty()) lowest_[path.back().node] = std::min(lowest_[path.back().node], lowest_[done]);
      if (lowest_[done] == order_[done]) close(done);
    }
  }

  Visit enter(std::size_t node) {
    order_[node] = lowest_[node] = count_++;
    open_[node] = true;
    stack_.push_back(node);
    return {node, 0};
  }

  void close(std::size_t first) {
    auto& group = groups_.emplace_back();
    std::size_t node = unseen;
    do {
      node = stack_.back();
      stack_.pop_back();
      open_[node] = false;
      group.push_back(static_cast<Index>(node));
    } while (node != first);
    std::ranges::sort(group);
  }

  const Graph& sources_;
  std::vector<std::size_t> order_, lowest_, stack_;
  std::vector<bool> open_;
  std::size_t count_ = 0;
  std::vector<std::vector<Index>> groups_;
};

}  // namespace

std::vector<std::vector<Index>> strong_components(const Eigen::Ref<const MatrixXd>& A) {
  const Graph sources = edges_into(A);
  return Search(sources).run();
}

}  // namespace kalfem
