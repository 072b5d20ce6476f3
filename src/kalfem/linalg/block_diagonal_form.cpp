// SPDX-License-Identifier: Apache-2.0
#include "kalfem/linalg/block_diagonal_form.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <complex>
#include <vector>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/linalg/blas.hpp"
#include "kalfem/linalg/scaling.hpp"

extern "C" {
void dgees_(const char* jobvs, const char* sort, void* select, const int* n, double* a, const int* lda, int* sdim,
            double* wr, double* wi, double* vs, const int* ldvs, double* work, const int* lwork, int* bwork, int* info);
void dtrexc_(const char* compq, const int* n, double* t, const int* ldt, double* q, const int* ldq, int* ifst,
             int* ilst, double* work, int* info);
void dtrsyl_(const char* trana, const char* tranb, const int* isgn, const int* m, const int* n, const double* a,
             const int* lda, const double* b, const int* ldb, double* c, const int* ldc, double* scale, int* info);
}

namespace kalfem {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

// After balancing: real Schur form, then from the top a block [BS79] at a time. Decouple the block from the rest by a
// Sylvester equation. Where its solution is too large the basis would be ill conditioned: exchange the nearest
// eigenvalue of the rest to directly behind the block, take it in and try again.
/// A = U S U^T, S quasi upper triangular, made block diagonal from the top.
class SchurSplit {
public:
  SchurSplit(const MatrixXd& A, double magnification)
      : n_(static_cast<int>(A.rows())), magnification_(magnification), s_(A), u_(A.rows(), A.rows()) {
    VectorXd real(n_), imaginary(n_), work(1);
    keep_blas_to_one_thread();
    int selected = 0, query = -1, info = 0;
    dgees_("V", "N", nullptr, &n_, s_.data(), &n_, &selected, real.data(), imaginary.data(), u_.data(), &n_,
           work.data(), &query, nullptr, &info);
    int size = static_cast<int>(work[0]);
    work.resize(size);
    dgees_("V", "N", nullptr, &n_, s_.data(), &n_, &selected, real.data(), imaginary.data(), u_.data(), &n_,
           work.data(), &size, nullptr, &info);
    if (info != 0)
      throw InvalidInput("the eigenvalues of a matrix of " + std::to_string(n_) + " states did not converge",
                         "its entries must be finite and reasonably scaled", "check the model's masses and dampers");
  }

  InvariantSubspaces run() {
    InvariantSubspaces result{{}, MatrixXd::Zero(n_, n_), {}};
    for (Index begin = 0, size = 0; begin < n_; begin += size) {
      size = width_at(begin);
      while (!decouple(begin, size)) size += bring_nearest(begin, size);
      result.starts.push_back(begin);
      result.blocks.block(begin, begin, size, size) = s_.block(begin, begin, size, size);
    }
    result.starts.push_back(n_);
    result.basis = std::move(u_);
    return result;
  }

private:
  [[nodiscard]] Index width_at(Index i) const { return i + 1 < n_ && s_(i + 1, i) != 0.0 ? 2 : 1; }

  [[nodiscard]] std::complex<double> eigenvalue_at(Index i) const {
    if (width_at(i) == 1) return s_(i, i);
    const double mean = 0.5 * (s_(i, i) + s_(i + 1, i + 1)), half = 0.5 * (s_(i, i) - s_(i + 1, i + 1));
    return {mean, std::sqrt(std::max(0.0, -half * half - s_(i, i + 1) * s_(i + 1, i)))};
  }

  /// X with S_11 X - X S_22 = -S_12; the basis of the rest then has no part in the block. False where X is too large.
  bool decouple(Index begin, Index size) {
    const Index rest = n_ - begin - size;
    if (rest == 0) return true;
    MatrixXd x = -s_.block(begin, begin + size, size, rest);
    const int rows = static_cast<int>(size), columns = static_cast<int>(rest), sign = -1;
    double scale = 1.0;
    int info = 0;
    dtrsyl_("N", "N", &sign, &rows, &columns, &s_(begin, begin), &n_, &s_(begin + size, begin + size), &n_, x.data(),
            &rows, &scale, &info);
    if (!(scale > 0.0) || !(x.cwiseAbs().maxCoeff() <= magnification_ * scale)) return false;
    u_.rightCols(rest) += u_.middleCols(begin, size) * (x / scale);
    s_.block(begin, begin + size, size, rest).setZero();
    return true;
  }

  /// Moves the eigenvalue of the rest that is nearest to the block's directly behind it; its width.
  Index bring_nearest(Index begin, Index size) {
    Index nearest = begin + size;
    double distance = std::numeric_limits<double>::infinity();
    for (Index i = begin + size; i < n_; i += width_at(i))
      for (Index k = begin; k < begin + size; k += width_at(k))
        if (const double away = std::abs(eigenvalue_at(i) - eigenvalue_at(k)); away < distance)
          distance = away, nearest = i;
    const Index width = width_at(nearest);
    int from = static_cast<int>(nearest) + 1, to = static_cast<int>(begin + size) + 1, info = 0;
    VectorXd work(n_);
    // Columns of earlier blocks are decoupled from these rows, so the exchange leaves them alone.
    dtrexc_("V", &n_, s_.data(), &n_, u_.data(), &n_, &from, &to, work.data(), &info);
    return width;
  }

  int n_;
  double magnification_;
  MatrixXd s_, u_;
};

}  // namespace

InvariantSubspaces invariant_subspaces(const MatrixXd& A, double magnification) {
  if (!A.allFinite()) throw InvalidInput("a matrix of dynamics is not finite", "all its entries must be finite", "");
  const VectorXd scale = balancing_scale(A);
  const VectorXd inverse = scale.cwiseInverse();
  InvariantSubspaces result = SchurSplit(inverse.asDiagonal() * A * scale.asDiagonal(), magnification).run();
  result.basis = scale.asDiagonal() * result.basis;
  return result;
}

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
    Groups groups = strong_components(pattern);
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

/// X^-1 V^-1, factor by factor. Its zeros are exact, as those of a general inverse are not: a state that does not act
/// on another has no part in the other's coordinates, however large it is.
MatrixXd inverse_of(const MatrixXd& basis, const Groups& groups, const MatrixXd& decoupling) {
  MatrixXd inverse = MatrixXd::Zero(basis.rows(), basis.cols());
  Index begin = 0;
  for (const auto& group : groups) {
    const auto own = Eigen::seqN(begin, static_cast<Index>(group.size()));
    const MatrixXd of_group = MatrixXd(basis(group, own)).inverse();
    inverse(own, group) = of_group;
    begin += static_cast<Index>(group.size());
  }
  return decoupling.triangularView<Eigen::UnitLower>().solve(inverse);
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
  const MatrixXd decoupling = decouple(actions_between(A, groups, form.basis), form);
  form.inverse = inverse_of(form.basis, groups, decoupling);
  form.basis = form.basis * decoupling;
  return form;
}

}  // namespace kalfem
