#include "kalfem/linalg/block_diagonal_form.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <vector>

#include "kalfem/base/invalid_input.hpp"

namespace kalfem {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

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

  /// A group is complete: it is all that was entered since its first node.
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

/// Strongly connected groups of the graph with an edge j -> i for every A_ij that is not zero: the irreducible diagonal
/// blocks of A. In topological order, a group behind all that act on it, so that A with its rows and columns in this
/// order is block lower triangular. A: n x n.
std::vector<std::vector<Index>> strong_components(const Eigen::Ref<const MatrixXd>& A) {
  const Graph sources = edges_into(A);
  return Search(sources).run();
}

}  // namespace

using Eigen::VectorXcd;

namespace {

using Groups = std::vector<std::vector<Index>>;

/// Eigenvalues this close, relative to the larger one, count as meeting: decoupling would magnify errors by the
/// inverse.
constexpr double closeness = 1e-3;

/// Below this share of the largest eigenvalue two of them count as zero both.
constexpr double zero_share = 1e-12;

bool meet(const VectorXcd& a, const VectorXcd& b, double largest) {
  for (const auto& x : a)
    for (const auto& y : b)
      if (std::abs(x - y) <= closeness * std::max(std::abs(x), std::abs(y)) ||
          std::max(std::abs(x), std::abs(y)) <= zero_share * largest)
        return true;
  return false;
}

/// reach(i, j): group j acts on group i, directly or through others. Groups in topological order.
Eigen::Matrix<bool, -1, -1> reachability(const MatrixXd& A, const Groups& groups) {
  const auto count = static_cast<Index>(groups.size());
  Eigen::VectorXi group_of(A.rows());
  for (Index g = 0; g < count; ++g)
    for (const Index state : groups[static_cast<std::size_t>(g)]) group_of[state] = static_cast<int>(g);
  Eigen::Matrix<bool, -1, -1> reach = Eigen::Matrix<bool, -1, -1>::Constant(count, count, false);
  for (Index i = 0; i < count; ++i)
    for (const Index row : groups[static_cast<std::size_t>(i)])
      for (Index column = 0; column < A.cols(); ++column) {
        const Index j = group_of[column];
        if (A(row, column) == 0.0 || j == i || reach(i, j)) continue;
        reach.row(i) = reach.row(i).array() || reach.row(j).array();
        reach(i, j) = true;
      }
  return reach;
}

/// The irreducible groups, those together of which one acts on the other and whose eigenvalues meet.
Groups separable_groups(const MatrixXd& A) {
  MatrixXd pattern = A;
  for (;;) {
    const Groups groups = strong_components(pattern);
    const auto reach = reachability(pattern, groups);
    std::vector<VectorXcd> eigenvalues;
    double largest = 0.0;
    for (const auto& group : groups) {
      eigenvalues.push_back(MatrixXd(A(group, group)).eigenvalues());
      largest = std::max(largest, eigenvalues.back().cwiseAbs().maxCoeff());
    }
    bool joined = false;
    for (std::size_t i = 0; i < groups.size(); ++i)
      for (std::size_t j = 0; j < i; ++j)
        if (reach(Index(i), Index(j)) && meet(eigenvalues[i], eigenvalues[j], largest)) {
          pattern(groups[j].front(), groups[i].front()) = 1.0;  // an edge back: one group from now on
          joined = true;
        }
    if (!joined) return groups;
  }
}

/// X with A X - X B = R for small A and B, by its linear equations.
MatrixXd solve_sylvester(const MatrixXd& a, const MatrixXd& b, const MatrixXd& r) {
  const Index m = a.rows(), n = b.rows();
  MatrixXd equations = MatrixXd::Zero(m * n, m * n);
  for (Index j = 0; j < n; ++j) {
    equations.block(j * m, j * m, m, m) += a;
    for (Index k = 0; k < n; ++k) equations.block(j * m, k * m, m, m).diagonal().array() -= b(k, j);
  }
  const Eigen::VectorXd right = Eigen::Map<const Eigen::VectorXd>(r.data(), r.size());
  const Eigen::VectorXd x = equations.partialPivLu().solve(right);
  return Eigen::Map<const MatrixXd>(x.data(), m, n);
}

/// Each group split into invariant subspaces; the columns of `basis` are its own.
void split_groups(const MatrixXd& A, const Groups& groups, BlockDiagonalForm& form) {
  Index begin = 0;
  for (const auto& group : groups) {
    const auto size = static_cast<Index>(group.size());
    const MatrixXd own = A(group, group);
    InvariantSubspaces parts{MatrixXd::Identity(size, size), own, {0, size}};
    if (size > 2) parts = invariant_subspaces(own);
    form.basis(group, Eigen::seqN(begin, size)) = parts.basis;
    form.blocks.block(begin, begin, size, size) = parts.blocks;
    for (std::size_t part = 0; part + 1 < parts.starts.size(); ++part)
      form.starts.push_back(begin + parts.starts[part]);
    begin += size;
  }
  form.starts.push_back(begin);
}

/// How the groups act on each other in their new coordinates, V_i^-1 A_ij V_j for i > j; exact zeros where they do not.
MatrixXd actions_between(const MatrixXd& A, const Groups& groups, const MatrixXd& basis) {
  MatrixXd actions = MatrixXd::Zero(A.rows(), A.cols());
  Index row = 0;
  for (const auto& group : groups) {
    const auto height = static_cast<Index>(group.size());
    const Eigen::PartialPivLU<MatrixXd> own(basis(group, Eigen::seqN(row, height)));
    Index column = 0;
    for (std::size_t j = 0; column < row; ++j) {
      const auto width = static_cast<Index>(groups[j].size());
      const MatrixXd action = A(group, groups[j]);
      if (!action.isZero(0.0))
        actions.block(row, column, height, width) = own.solve(action * basis(groups[j], Eigen::seqN(column, width)));
      column += width;
    }
    row += height;
  }
  return actions;
}

/// X with (B + actions) X = X B, unit lower triangular by blocks.
MatrixXd decouple(const MatrixXd& actions, const BlockDiagonalForm& form) {
  const auto& starts = form.starts;
  MatrixXd x = MatrixXd::Identity(actions.rows(), actions.cols());
  for (std::size_t j = 0; j + 1 < starts.size(); ++j) {
    const Index column = starts[j], width = starts[j + 1] - column;
    for (std::size_t i = j + 1; i + 1 < starts.size(); ++i) {
      const Index row = starts[i], height = starts[i + 1] - row;
      const MatrixXd drive =
          actions.block(row, column, height, row - column) * x.block(column, column, row - column, width);
      if (drive.isZero(0.0)) continue;
      x.block(row, column, height, width) = solve_sylvester(form.blocks.block(row, row, height, height),
                                                            form.blocks.block(column, column, width, width), -drive);
    }
  }
  return x;
}

}  // namespace

Index BlockDiagonalForm::largest_block() const {
  Index largest = 0;
  for (std::size_t i = 0; i + 1 < starts.size(); ++i) largest = std::max(largest, starts[i + 1] - starts[i]);
  return largest;
}

BlockDiagonalForm block_diagonal_form(const MatrixXd& A) {
  if (!A.allFinite()) throw InvalidInput("a matrix of dynamics is not finite", "all its entries must be finite", "");
  const Index n = A.rows();
  BlockDiagonalForm form{MatrixXd::Zero(n, n), {}, MatrixXd::Zero(n, n), {}};
  const Groups groups = separable_groups(A);
  split_groups(A, groups, form);
  form.basis = form.basis * decouple(actions_between(A, groups, form.basis), form);
  form.inverse = form.basis.inverse();
  return form;
}

}  // namespace kalfem
