// SPDX-License-Identifier: Apache-2.0
#include "majak/graph/block_cholesky.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <set>
#include <vector>

#include "majak/core/random.hpp"

namespace majak::graph {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A sparse matrix and its dense twin.
struct Both {
  BlockCholesky sparse;
  MatrixXd dense;
  std::vector<BlockCholesky::Pair> pairs;
};

Mat3 random_block(RandomStream& random) {
  Mat3 m;
  for (int k = 0; k < 9; ++k) m(k / 3, k % 3) = random.normal();
  return m;
}

/// Writes values for the pairs, diagonally dominant, through the slots.
void fill(Both& m, RandomStream& random) {
  const int n = m.sparse.size();
  const auto slots = m.sparse.analyze(n, m.pairs);
  m.sparse.set_zero();
  m.dense = MatrixXd::Zero(3 * n, 3 * n);
  for (std::size_t k = 0; k < m.pairs.size(); ++k) {
    const auto [i, j] = m.pairs[k];
    const Mat3 b = random_block(random);
    m.dense.block<3, 3>(3 * i, 3 * j) += b;
    m.dense.block<3, 3>(3 * j, 3 * i) += b.transpose();
    Eigen::Map<Mat3> to(m.sparse.block(slots[k]));
    to += slots[k].transposed ? Mat3(b.transpose()) : b;
  }
  const VectorXd sums = m.dense.cwiseAbs().rowwise().sum();
  for (int i = 0; i < n; ++i) {
    const Mat3 root = random_block(random);
    Mat3 d = root * root.transpose();
    for (int r = 0; r < 3; ++r) d(r, r) += 1 + sums(3 * i + r);
    m.dense.block<3, 3>(3 * i, 3 * i) += d;
    Eigen::Map<Mat3>(m.sparse.diagonal(i)) += Mat3(d.triangularView<Eigen::Lower>());
  }
}

std::vector<BlockCholesky::Pair> random_pairs(RandomStream& random, int n, int count, bool chain) {
  std::vector<BlockCholesky::Pair> pairs;
  for (int i = 1; chain && i < n; ++i) pairs.emplace_back(i - 1, i);
  for (int k = 0; k < count && n > 1; ++k) {
    const int i = static_cast<int>(random.below(n));
    pairs.emplace_back(i, (i + 1 + static_cast<int>(random.below(n - 1))) % n);
  }
  return pairs;
}

Both make(int n, std::vector<BlockCholesky::Pair> pairs, RandomStream& random) {
  Both m;
  m.pairs = std::move(pairs);
  m.sparse.analyze(n, {});
  fill(m, random);
  return m;
}

void expect_solves(const Both& m, RandomStream& random) {
  const int n = static_cast<int>(m.dense.rows());
  VectorXd b(n);
  for (int i = 0; i < n; ++i) b(i) = random.normal();
  std::vector<double> x(b.data(), b.data() + n);
  m.sparse.solve(x);
  const VectorXd expected = m.dense.llt().solve(b);
  EXPECT_LT((Eigen::Map<VectorXd>(x.data(), n) - expected).cwiseAbs().maxCoeff(),
            1e-12 * (1 + expected.cwiseAbs().maxCoeff()));
}

struct Shape {
  int n, pairs;
  bool chain;
};
class BlockCholeskyShapes : public testing::TestWithParam<Shape> {};

TEST_P(BlockCholeskyShapes, SolvesAsTheDenseTwinDoes) {
  const auto [n, pairs, chain] = GetParam();
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    RandomStream random(seed, n, pairs);
    Both m = make(n, random_pairs(random, n, pairs, chain), random);
    ASSERT_TRUE(m.sparse.factor());
    expect_solves(m, random);
  }
}

TEST_P(BlockCholeskyShapes, DiagonalOfTheInverseIsTheDenseOne) {
  const auto [n, pairs, chain] = GetParam();
  RandomStream random(7, n, pairs);
  Both m = make(n, random_pairs(random, n, pairs, chain), random);
  ASSERT_TRUE(m.sparse.factor());
  const auto blocks = m.sparse.inverse_diagonal();
  const MatrixXd inverse = m.dense.inverse();
  ASSERT_EQ(blocks.size(), static_cast<std::size_t>(n));
  for (int i = 0; i < n; ++i)
    EXPECT_LT((blocks[i] - inverse.block<3, 3>(3 * i, 3 * i)).cwiseAbs().maxCoeff(), 1e-12);
}

INSTANTIATE_TEST_SUITE_P(Shapes, BlockCholeskyShapes,
                         testing::Values(Shape{1, 0, false}, Shape{2, 1, false}, Shape{3, 0, true},
                                         Shape{9, 0, false}, Shape{10, 45, false},
                                         Shape{30, 0, true}, Shape{40, 15, true},
                                         Shape{60, 300, true}, Shape{50, 20, false},
                                         Shape{120, 60, true}));

TEST(BlockCholesky, EmptyMatrixFactorsAndSolves) {
  BlockCholesky a;
  a.analyze(0, {});
  EXPECT_TRUE(a.factor());
  a.solve({});
  EXPECT_TRUE(a.inverse_diagonal().empty());
}

TEST(BlockCholesky, PairsEitherWayRoundShareOneBlock) {
  BlockCholesky a;
  const std::vector<BlockCholesky::Pair> pairs{{0, 2}, {2, 0}, {0, 2}, {1, 2}};
  const auto slots = a.analyze(3, pairs);
  EXPECT_EQ(slots[0].block, slots[1].block);
  EXPECT_NE(slots[0].transposed, slots[1].transposed);
  EXPECT_EQ(slots[0].block, slots[2].block);
  EXPECT_EQ(slots[0].transposed, slots[2].transposed);
  EXPECT_NE(slots[0].block, slots[3].block);
}

TEST(BlockCholesky, VariablePastTheLastIsWrittenButNotRead) {
  RandomStream random(3);
  BlockCholesky a;
  const std::vector<BlockCholesky::Pair> pairs{{0, 2}, {1, 0}, {2, 1}};
  const auto slots = a.analyze(2, pairs);
  a.set_zero();
  for (int i = 0; i < 3; ++i)
    for (int r = 0; r < 3; ++r) a.diagonal(i)[4 * r] = i < 2 ? 4 : -1;
  for (const int k : {0, 2}) Eigen::Map<Mat3>(a.block(slots[k])) = 100 * random_block(random);
  ASSERT_TRUE(a.factor());
  std::vector<double> x(6, 8.0);
  a.solve(x);
  EXPECT_EQ(x, std::vector<double>(6, 2.0));
}

TEST(BlockCholesky, SaysWhenItIsNotPositiveDefinite) {
  for (const double bad : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN(),
                           std::numeric_limits<double>::infinity()}) {
    RandomStream random(5);
    Both m = make(12, random_pairs(random, 12, 10, true), random);
    ASSERT_TRUE(m.sparse.factor());
    m.sparse.diagonal(6)[4] = bad;
    EXPECT_FALSE(m.sparse.factor()) << bad;
  }
}

TEST(BlockCholesky, DampingScalesTheDiagonal) {
  RandomStream random(6);
  Both m = make(15, random_pairs(random, 15, 10, true), random);
  ASSERT_TRUE(m.sparse.factor(0.5));
  m.dense.diagonal() *= 1.5;
  expect_solves(m, random);
}

TEST(BlockCholesky, DampingMakesASingularMatrixSolvable) {
  BlockCholesky a;
  a.analyze(2, {});
  a.set_zero();
  a.diagonal(0)[0] = 10;
  EXPECT_FALSE(a.factor(0));
  EXPECT_TRUE(a.factor(1e-4));
}

TEST(BlockCholesky, GrowingStructureStaysRightWhateverOrderItKeeps) {
  RandomStream random(8);
  Both m;
  m.sparse.analyze(20, {});
  for (int n = 20; n <= 90; n += 1 + static_cast<int>(random.below(6))) {
    if (n > m.sparse.size())
      for (int i = std::max(1, m.sparse.size()); i < n; ++i) m.pairs.emplace_back(i, i - 1);
    m.pairs.push_back({static_cast<int>(random.below(n / 2)), n - 1});
    m.sparse.analyze(n, m.pairs);
    fill(m, random);
    ASSERT_TRUE(m.sparse.factor());
    expect_solves(m, random);
  }
}

TEST(BlockCholesky, KeptOrderCostsLittleMoreThanAFreshOne) {
  RandomStream random(9);
  BlockCholesky kept;
  std::vector<BlockCholesky::Pair> pairs;
  for (int n = 2; n <= 600; ++n) {
    pairs.emplace_back(n - 2, n - 1);
    if (n % 5 == 0) pairs.emplace_back(static_cast<int>(random.below(n - 1)), n - 1);
    kept.analyze(n, pairs);
  }
  BlockCholesky fresh;
  fresh.analyze(600, pairs);
  EXPECT_LT(kept.factor_operations(), 2.5 * fresh.factor_operations());
  // and a fresh one is near the best: a chain with loops fills far less than a dense matrix
  EXPECT_LT(fresh.factor_blocks(), 600u * 60u);
}

TEST(BlockCholesky, ChainFactorsWithoutFill) {
  BlockCholesky a;
  std::vector<BlockCholesky::Pair> pairs;
  for (int i = 1; i < 1000; ++i) pairs.emplace_back(i - 1, i);
  a.analyze(1000, pairs);
  EXPECT_LT(a.factor_blocks(), 3500u);  // 1999, and the zeros of joined supernodes
}

}  // namespace
}  // namespace majak::graph
