// SPDX-License-Identifier: Apache-2.0
#include "majak/slam/joint_compatibility.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <set>

#include "majak/core/chi_square.hpp"
#include "majak/core/random.hpp"

namespace majak::slam {
namespace {

using Candidates = std::vector<std::vector<Pairing>>;

/// Landmarks about a robot, of which it sees some from where it truly is.
struct Problem {
  Eigen::VectorXd mean;  // x, y, theta, landmarks
  Eigen::MatrixXd covariance;
  std::vector<Vec2> seen;  // robot frame
  Eigen::Matrix2d noise = 0.01 * Eigen::Matrix2d::Identity();

  Vec2 landmark(int i) const { return mean.segment<2>(3 + 2 * i); }
  int landmarks() const { return static_cast<int>(mean.size() - 3) / 2; }

  Pairing pair(const Vec2& q_seen, int i) const {
    const Pose2 at{mean(0), mean(1), mean(2)};
    const Vec2 q = at.inverse() * landmark(i);
    Eigen::Matrix2d back;
    back << std::cos(at.theta), std::sin(at.theta), -std::sin(at.theta), std::cos(at.theta);
    Pairing p;
    p.landmark = i;
    p.column = 3 + 2 * i;
    p.innovation = q_seen - q;
    p.by_state << -back, Vec2(q.y(), -q.x()), back;
    p.spread = shared_spread(p, p, covariance) + noise;
    p.nis = p.innovation.dot(p.spread.inverse() * p.innovation);
    return p;
  }
  Candidates candidates(double gate = 0.99) const {
    Candidates all;
    for (const Vec2& q : seen) {
      all.emplace_back();
      for (int i = 0; i < landmarks(); ++i)
        if (const Pairing p = pair(q, i); p.nis < chi_square_quantile(gate, 2))
          all.back().push_back(p);
      std::stable_sort(all.back().begin(), all.back().end(),
                       [](const Pairing& a, const Pairing& b) { return a.nis < b.nis; });
    }
    return all;
  }
};

Problem random_problem(std::uint64_t seed) {
  RandomStream random(seed);
  Problem p;
  const int n = 2 + static_cast<int>(random.below(4));
  const Eigen::Index size = 3 + 2 * n;
  p.mean.resize(size);
  for (double& v : p.mean) v = 1.2 * random.normal();
  Eigen::MatrixXd a(size, size);
  for (Eigen::Index i = 0; i < a.size(); ++i) a(i) = random.normal();
  p.covariance = 0.04 * a * a.transpose() / static_cast<double>(size) +
                 0.02 * Eigen::MatrixXd::Identity(size, size);
  const Eigen::VectorXd true_state =
      p.mean + 1.2 * Eigen::MatrixXd(p.covariance.llt().matrixL()) *
                   Eigen::VectorXd::NullaryExpr(size, [&] { return random.normal(); });
  const Pose2 at{true_state(0), true_state(1), true_state(2)};
  for (int i = 0; i < n; ++i)
    if (random.uniform() < 0.8)
      p.seen.push_back(at.inverse() * Vec2(true_state.segment<2>(3 + 2 * i)) +
                       0.1 * Vec2(random.normal(), random.normal()));
  if (random.uniform() < 0.5) p.seen.emplace_back(2 * random.normal(), 2 * random.normal());
  return p;
}

/// The normalised square of all pairings together, by the inverse of one big matrix.
double joint_nis(const std::vector<const Pairing*>& pairs, const Eigen::MatrixXd& covariance) {
  const auto n = 2 * static_cast<Eigen::Index>(pairs.size());
  Eigen::MatrixXd h = Eigen::MatrixXd::Zero(n, covariance.cols()), r = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd innovation(n);
  for (Eigen::Index k = 0; k < n; k += 2) {
    const Pairing& p = *pairs[static_cast<std::size_t>(k / 2)];
    h.block<2, 3>(k, 0) = p.by_state.leftCols<3>();
    h.block<2, 2>(k, p.column) = p.by_state.rightCols<2>();
    innovation.segment<2>(k) = p.innovation;
  }
  const Eigen::MatrixXd shared = h * covariance * h.transpose();
  for (Eigen::Index k = 0; k < n; k += 2)
    r.block<2, 2>(k, k) = pairs[static_cast<std::size_t>(k / 2)]->spread - shared.block<2, 2>(k, k);
  return n == 0 ? 0 : innovation.dot((shared + r).inverse() * innovation);
}

std::vector<const Pairing*> chosen(const Candidates& candidates, const std::vector<int>& choice) {
  std::vector<const Pairing*> pairs;
  for (std::size_t s = 0; s < choice.size(); ++s)
    if (choice[s] >= 0) pairs.push_back(&candidates[s][static_cast<std::size_t>(choice[s])]);
  return pairs;
}
bool one_each(const std::vector<const Pairing*>& pairs) {
  std::set<int> landmarks;
  for (const Pairing* p : pairs) landmarks.insert(p->landmark);
  return landmarks.size() == pairs.size();
}

struct Best {
  std::size_t count = 0;
  double nis = 0;
};
/// All assignments there are; each pairing must be compatible with those of the sightings before.
void try_all(const Candidates& candidates, const Eigen::MatrixXd& covariance, double gate,
             std::vector<int>& choice, Best& best) {
  const auto pairs = chosen(candidates, choice);
  const double nis = joint_nis(pairs, covariance);
  if (!one_each(pairs)) return;
  if (!pairs.empty() && nis >= chi_square_quantile(gate, 2.0 * static_cast<double>(pairs.size())))
    return;
  if (choice.size() == candidates.size()) {
    if (pairs.size() > best.count || (pairs.size() == best.count && nis < best.nis))
      best = {pairs.size(), nis};
    return;
  }
  const int options = static_cast<int>(candidates[choice.size()].size());
  for (int c = -1; c < options; ++c) {
    choice.push_back(c);
    try_all(candidates, covariance, gate, choice, best);
    choice.pop_back();
  }
}

/// Those with the fewest candidates first, then the nearest; without any last.
Candidates in_order(Candidates candidates) {
  std::stable_sort(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) {
    const auto key = [](const std::vector<Pairing>& c) {
      return c.empty() ? std::pair(std::size_t{1000}, 0.0) : std::pair(c.size(), c[0].nis);
    };
    return key(a) < key(b);
  });
  return candidates;
}

TEST(JointCompatibility, IsTheBestOfAllAssignments) {
  int crowded = 0, contested = 0;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    const Problem p = random_problem(seed);
    const Candidates candidates = p.candidates();
    for (const double gate : {0.99, 0.5}) {
      const std::vector<int> choice =
          associate_jointly(candidates, p.covariance, {.gate = gate, .most_nodes = 1 << 20});
      const auto pairs = chosen(candidates, choice);
      std::vector<int> empty;
      Best best{0, 1e9};
      try_all(in_order(candidates), p.covariance, gate, empty, best);
      ASSERT_EQ(choice.size(), candidates.size());
      EXPECT_TRUE(one_each(pairs));
      EXPECT_EQ(pairs.size(), best.count) << seed;
      EXPECT_NEAR(joint_nis(pairs, p.covariance), best.nis, 1e-9 * (1 + best.nis)) << seed;
      crowded += pairs.size() >= 3;
      // Where each sighting taken alone would have chosen otherwise.
      contested += std::any_of(choice.begin(), choice.end(), [](int c) { return c > 0; });
    }
  }
  EXPECT_GT(crowded, 200);
  EXPECT_GT(contested, 40);
}

TEST(JointCompatibility, SharedSpreadIsHPHt) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    const Problem p = random_problem(seed);
    Eigen::MatrixXd h = Eigen::MatrixXd::Zero(4, p.covariance.cols());
    const Pairing a = p.pair({1, 2}, 0), b = p.pair({-1, 0.5}, 1);
    h.topLeftCorner<2, 3>() = a.by_state.leftCols<3>();
    h.block<2, 2>(0, a.column) = a.by_state.rightCols<2>();
    h.bottomLeftCorner<2, 3>() = b.by_state.leftCols<3>();
    h.block<2, 2>(2, b.column) = b.by_state.rightCols<2>();
    const Eigen::Matrix4d all = h * p.covariance * h.transpose();
    const Eigen::Matrix2d ab = shared_spread(a, b, p.covariance);
    EXPECT_LT((ab - all.topRightCorner<2, 2>()).cwiseAbs().maxCoeff(), 1e-14);
    EXPECT_LT((shared_spread(a, a, p.covariance) - all.topLeftCorner<2, 2>()).norm(), 1e-14);
    EXPECT_LT((shared_spread(b, a, p.covariance) - ab.transpose()).norm(), 1e-14);
  }
}

// Two trunks 20 m off, seen by a robot that is turned by so much that one looks like the other:
// alone it is nearest, a third one close by tells.
Problem rotated(double turn) {
  Problem p;
  p.mean = Eigen::VectorXd::Zero(3 + 6);
  p.mean.tail<6>() << 20, 0, 20 * std::cos(0.1), 20 * std::sin(0.1), 3, -4;
  p.covariance = 1e-4 * Eigen::MatrixXd::Identity(9, 9);
  p.covariance(2, 2) = 0.06 * 0.06;
  p.noise = 0.0025 * Eigen::Matrix2d::Identity();
  for (int i = 0; i < 3; ++i) p.seen.push_back(Pose2{0, 0, turn}.inverse() * p.landmark(i));
  return p;
}

TEST(JointCompatibility, TheNearestIsWrongWhereThePoseIsTurned) {
  const Problem p = rotated(-0.075);
  const Candidates candidates = p.candidates();
  ASSERT_EQ(candidates[0].size(), 2u);
  EXPECT_EQ(candidates[0][0].landmark, 1);  // the nearest, and not the one
  const std::vector<int> choice = associate_jointly(candidates, p.covariance);
  const auto pairs = chosen(candidates, choice);
  ASSERT_EQ(pairs.size(), 3u);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(pairs[static_cast<std::size_t>(i)]->landmark, i);
}

// Two sightings that each alone are allowed, but not both: as a pair they contradict.
TEST(JointCompatibility, APairThatContradictsIsRefused) {
  Problem p;
  p.mean = Eigen::VectorXd::Zero(7);
  p.mean.tail<4>() << 10, 3, 10, -3;
  p.covariance = 1e-6 * Eigen::MatrixXd::Identity(7, 7);
  p.covariance(1, 1) = 1;  // only y of the robot is not known
  p.seen = {{10, 3 + 2}, {10, -3 - 2}};
  const Candidates candidates = p.candidates();
  ASSERT_EQ(candidates[0].size(), 1u);
  ASSERT_EQ(candidates[1].size(), 1u);
  EXPECT_EQ(chosen(candidates, associate_jointly(candidates, p.covariance)).size(), 1u);
  p.seen[1] = {10, -3 + 2};
  EXPECT_EQ(chosen(p.candidates(), associate_jointly(p.candidates(), p.covariance)).size(), 2u);
}

TEST(JointCompatibility, NoLandmarkTwice) {
  Problem p = rotated(0);
  p.seen = {p.seen[0], p.seen[0] + Vec2(0.01, 0), p.seen[0] - Vec2(0.02, 0)};
  const Candidates candidates = p.candidates();
  const std::vector<int> choice = associate_jointly(candidates, p.covariance);
  const auto pairs = chosen(candidates, choice);
  EXPECT_TRUE(one_each(pairs));
  ASSERT_GE(pairs.size(), 1u);
  EXPECT_EQ(choice[0], 0);  // the nearest of the three
}

TEST(JointCompatibility, TheOrderOfTheSightingsDoesNotMatter) {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const Problem p = random_problem(seed);
    const Candidates candidates = p.candidates();
    const auto choice = associate_jointly(candidates, p.covariance, {.gate = 0.5});
    std::vector<std::size_t> order(candidates.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    while (std::next_permutation(order.begin(), order.end())) {
      Candidates moved;
      for (const std::size_t s : order) moved.push_back(candidates[s]);
      const auto found = associate_jointly(moved, p.covariance, {.gate = 0.5});
      for (std::size_t i = 0; i < order.size(); ++i) ASSERT_EQ(found[i], choice[order[i]]) << seed;
    }
  }
}

TEST(JointCompatibility, NothingToChooseFrom) {
  const Eigen::MatrixXd covariance = Eigen::MatrixXd::Identity(3, 3);
  EXPECT_TRUE(associate_jointly({}, covariance).empty());
  EXPECT_EQ(associate_jointly(Candidates(3), covariance), std::vector<int>({-1, -1, -1}));
}

// Out of nodes: what was found so far, as good or less, never a contradiction.
TEST(JointCompatibility, AShortSearchIsConsistentAndALongerOneNoWorse) {
  int less = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    const Problem p = random_problem(seed);
    const Candidates candidates = p.candidates();
    std::size_t count = 0;
    double nis = 1e9;
    for (const int nodes : {0, 1, 3, 10, 30, 3000}) {
      const auto choice = associate_jointly(candidates, p.covariance, {.most_nodes = nodes});
      ASSERT_EQ(choice.size(), candidates.size());
      const auto pairs = chosen(candidates, choice);
      const double now = joint_nis(pairs, p.covariance);
      EXPECT_TRUE(one_each(pairs));
      EXPECT_TRUE(pairs.empty() ||
                  now < chi_square_quantile(0.99, 2.0 * static_cast<double>(pairs.size())));
      EXPECT_TRUE(pairs.size() > count || (pairs.size() == count && now <= nis + 1e-9) ||
                  count == 0);
      less += nodes == 1 && pairs.empty() && !candidates.empty();
      count = pairs.size(), nis = now;
    }
  }
  EXPECT_GT(less, 50);
}

// More sightings than are looked at together: the nearest count.
TEST(JointCompatibility, ManySightings) {
  Problem p;
  const int n = 40;
  p.mean = Eigen::VectorXd::Zero(3 + 2 * n);
  for (int i = 0; i < n; ++i) p.mean.segment<2>(3 + 2 * i) << 5 + 3 * (i % 8), 3 * (i / 8);
  p.covariance = 1e-3 * Eigen::MatrixXd::Identity(p.mean.size(), p.mean.size());
  p.noise = 0.01 * Eigen::Matrix2d::Identity();
  for (int i = 0; i < n; ++i) p.seen.push_back(p.landmark(i));
  const Candidates candidates = p.candidates();
  const auto pairs = chosen(candidates, associate_jointly(candidates, p.covariance));
  EXPECT_EQ(pairs.size(), 32u);
  for (const Pairing* pair : pairs) EXPECT_LT(pair->innovation.norm(), 1e-12);
}

}  // namespace
}  // namespace majak::slam
