// SPDX-License-Identifier: Apache-2.0
#include "majak/filter/landmark_filter.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "majak/core/random.hpp"

namespace majak::filter {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using Filter = LandmarkFilter;
using Motion = RelativeInput<Filter::kExtra>;
constexpr int kBody = Filter::kBody;

VectorXd normals(int n, RandomStream& random) {
  VectorXd v(n);
  for (double& x : v) x = random.normal();
  return v;
}

MatrixXd positive(int n, RandomStream& random, double size) {
  MatrixXd a(n, n);
  for (int i = 0; i < n; ++i) a.col(i) = normals(n, random);
  return size * (a * a.transpose() / n + 0.1 * MatrixXd::Identity(n, n));
}

using Function = std::function<VectorXd(const VectorXd&)>;

// Six points, so that a wide step is as good as exact.
MatrixXd derivative(const Function& f, const VectorXd& at) {
  constexpr double kStep = 2e-3;
  MatrixXd d(f(at).size(), at.size());
  for (Eigen::Index k = 0; k < at.size(); ++k) {
    const auto slope = [&](double h) -> VectorXd {
      VectorXd ahead = at, back = at;
      ahead(k) += h, back(k) -= h;
      return (f(ahead) - f(back)) / (2 * h);
    };
    d.col(k) = 1.5 * slope(kStep) - 0.6 * slope(2 * kStep) + 0.1 * slope(3 * kStep);
  }
  return d;
}

// ---- The slow twin: one vector, one covariance, every derivative by differences --------------

struct Twin {
  VectorXd mean;  // x, y, theta, extra, landmarks
  MatrixXd covariance;
  std::map<int, int> row_of;  // by the filter's number

  void carry(const Function& f) {
    const MatrixXd by_state = derivative(f, mean);
    mean = f(mean);
    covariance = by_state * covariance * by_state.transpose();
  }
  /// `f`: of the state and then of some numbers that are 0, with this covariance.
  void carry(const Function& f, const MatrixXd& noise) {
    const Eigen::Index n = mean.size(), m = noise.rows();
    mean.conservativeResize(n + m);
    mean.tail(m).setZero();
    covariance.conservativeResize(n + m, n + m);
    covariance.rightCols(m).setZero(), covariance.bottomRows(m).setZero();
    covariance.bottomRightCorner(m, m) = noise;
    carry(f);
  }
  static Pose2 pose(const VectorXd& s) { return {s(0), s(1), s(2)}; }
  static void set(VectorXd& s, const Pose2& p, double theta) {
    s(0) = p.x, s(1) = p.y, s(2) = theta;  // not wrapped, so that differences are differences
  }

  void predict(const Motion& motion) {
    const Eigen::Index n = mean.size();
    carry(
        [&](const VectorXd& s) {
          VectorXd to = s.head(n);
          const Filter::Extra extra = s.segment<Filter::kExtra>(3);
          const Vec3 beside = motion.by_extra * (extra - motion.at);
          set(to, pose(s) * motion.T_from_to * exp(beside),
              s(2) + motion.T_from_to.theta + beside.z());
          to.segment<Filter::kExtra>(3) = motion.keep.cwiseProduct(extra);
          return to;
        },
        MatrixXd(0, 0));
    const double c = std::cos(mean(2)), si = std::sin(mean(2));
    Mat3 turn;
    turn << c, -si, 0, si, c, 0, 0, 0, 1;
    covariance.topLeftCorner<3, 3>() += turn * motion.noise * turn.transpose();
    covariance.block<Filter::kExtra, Filter::kExtra>(3, 3).diagonal() += motion.extra_noise;
    mean(2) = wrap_angle(mean(2));
  }
  double correct(const VectorXd& z, const Function& h, const MatrixXd& noise) {
    const MatrixXd by_state = derivative(h, mean);
    const MatrixXd s = by_state * covariance * by_state.transpose() + noise;
    const MatrixXd gain = covariance * by_state.transpose() * s.inverse();
    const VectorXd innovation = z - h(mean);
    const MatrixXd keep = MatrixXd::Identity(mean.size(), mean.size()) - gain * by_state;
    covariance = keep * covariance * keep.transpose() + gain * noise * gain.transpose();
    mean += gain * innovation;
    mean(2) = wrap_angle(mean(2));
    return innovation.dot(s.inverse() * innovation);
  }
  void add(int id, const Vec2& q, const MatrixXd& noise) {
    const Eigen::Index n = mean.size();
    carry(
        [&](const VectorXd& s) {
          VectorXd to = s;
          to.tail<2>() = pose(s) * Vec2(q + s.tail<2>());
          return to;
        },
        noise);
    row_of[id] = static_cast<int>(n);
  }
  void remove(int id) {
    const int row = row_of.at(id);
    std::vector<int> rest;
    for (int i = 0; i < mean.size(); ++i)
      if (i != row && i != row + 1) rest.push_back(i);
    mean = mean(rest).eval();
    covariance = covariance(rest, rest).eval();
    row_of.erase(id);
    for (auto& [other, r] : row_of) r -= r > row ? 2 : 0;
  }
  void move_map(const Pose2& T, const Mat3& noise) {
    const Eigen::Index n = mean.size();
    carry(
        [&](const VectorXd& s) {
          VectorXd to = s.head(n);
          const Vec3 off = s.tail<3>();
          const Pose2 moved{T.x + off.x(), T.y + off.y(), T.theta + off.z()};
          set(to, moved * pose(s), moved.theta + s(2));
          for (Eigen::Index i = kBody; i < n; i += 2)
            to.segment<2>(i) = moved * Vec2(s.segment<2>(i));
          return to;
        },
        noise);
    mean(2) = wrap_angle(mean(2));
  }
};

/// What the robot sees of some landmarks, and of itself: an antenna as EKF-SLAM has it.
struct Sight {
  std::vector<int> ids;
  bool antenna = false;

  Eigen::Index size() const {
    return 2 * static_cast<Eigen::Index>(ids.size()) + (antenna ? 2 : 0);
  }
  VectorXd operator()(const VectorXd& state, const std::function<int(int)>& row) const {
    VectorXd h(size());
    const Pose2 at{state(0), state(1), state(2)};
    Eigen::Index k = 0;
    for (const int id : ids) {
      h.segment<2>(k) = at.inverse() * Vec2(state.segment<2>(row(id)));
      k += 2;
    }
    if (antenna) h.segment<2>(k) = at * Vec2(state.segment<2>(7)) + state.segment<2>(9);
    return h;
  }
};

/// Both, told the same.
class Pair {
 public:
  explicit Pair(std::uint64_t seed) : random_(seed) {
    const Filter::Extra extra = 0.3 * normals(Filter::kExtra, random_);
    const Pose2 start = from_vector(normals(3, random_));
    const Filter::Body covariance = positive(kBody, random_, 0.01);
    filter.emplace(start, extra, covariance);
    twin.mean.resize(kBody);
    twin.mean << start.vector(), extra;
    twin.covariance = covariance;
  }

  void predict() {
    Motion m;
    m.T_from_to =
        from_vector(Vec3(random_.uniform(0, 2), 0.1 * random_.normal(), 0.5 * random_.normal()));
    m.at = 0.3 * normals(Filter::kExtra, random_);
    for (int k = 0; k < Filter::kExtra; ++k) m.by_extra.col(k) = 0.2 * normals(3, random_);
    m.noise = positive(3, random_, 1e-3);
    for (double& k : m.keep) k = random_.uniform(0.8, 1);
    for (double& v : m.extra_noise) v = random_.uniform(0, 1e-3);
    filter->predict(m);
    twin.predict(m);
  }
  void add() {
    const Vec2 q = 4 * normals(2, random_);
    const Eigen::Matrix2d noise = positive(2, random_, 0.01);
    twin.add(filter->add(q, noise), q, noise);
  }
  void correct() {
    Sight sight;
    for (const int id : filter->near())
      if (sight.ids.size() < 3 && random_.uniform() < 0.4) sight.ids.push_back(id);
    sight.antenna = random_.uniform() < 0.3 || sight.ids.empty();
    const auto column = [&](int id) { return filter->column(id); };
    const Function mine = [&](const VectorXd& s) { return sight(s, column); };
    const Function its = [&](const VectorXd& s) {
      return sight(s, [&](int id) { return twin.row_of.at(id); });
    };
    const VectorXd z = its(twin.mean) + 0.1 * normals(static_cast<int>(sight.size()), random_);
    const MatrixXd noise = positive(static_cast<int>(sight.size()), random_, 0.02);
    const VectorXd near = near_mean();
    const double nis = filter->correct(z - mine(near), derivative(mine, near), noise);
    EXPECT_NEAR(nis, twin.correct(z, its, noise), 1e-8 * (1 + nis));
  }
  void remove() {
    if (filter->near().empty()) return;
    const int id = filter->near()[random_.below(filter->near().size())];
    filter->remove(id);
    twin.remove(id);
  }
  void look_around() {
    filter->look_around(filter->T_map_robot().translation() + normals(2, random_),
                        random_.uniform(0, 6));
  }
  void move_map() {
    const Pose2 T = from_vector(normals(3, random_));
    const Mat3 noise = positive(3, random_, 0.01);
    filter->move_map(T, noise);
    twin.move_map(T, noise);
  }

  VectorXd near_mean() const {
    VectorXd s(filter->covariance().rows());
    s << filter->T_map_robot().vector(), filter->extra(), VectorXd::Zero(s.size() - kBody);
    for (const int id : filter->near()) s.segment<2>(filter->column(id)) = filter->landmark(id);
    return s;
  }
  /// What is near now is as the twin has it.
  void expect_same(double tolerance) const {
    std::vector<int> rows(kBody);
    for (int i = 0; i < kBody; ++i) rows[static_cast<std::size_t>(i)] = i;
    int column = kBody;
    for (const int id : filter->near()) {
      EXPECT_EQ(filter->column(id), column);
      rows.push_back(twin.row_of.at(id)), rows.push_back(twin.row_of.at(id) + 1);
      column += 2;
    }
    ASSERT_EQ(filter->covariance().rows(), column);
    EXPECT_LT((near_mean() - twin.mean(rows)).cwiseAbs().maxCoeff(), tolerance);
    EXPECT_LT((filter->covariance() - twin.covariance(rows, rows)).cwiseAbs().maxCoeff(),
              tolerance);
  }

  std::optional<Filter> filter;
  Twin twin;

 private:
  RandomStream random_;
};

void random_step(Pair& pair, RandomStream& random) {
  const double what = random.uniform();
  if (what < 0.3) return pair.predict();
  if (what < 0.45) return pair.add();
  if (what < 0.75) return pair.correct();
  if (what < 0.8) return pair.remove();
  if (what < 0.95) return pair.look_around();
  if (what < 0.98) return pair.move_map();
  pair.filter->settle();
}

// ---- Fast against slow ------------------------------------------------------------------------

// At each step what is near is right, and at the end all of it, wherever the robot looked around.
TEST(LandmarkFilter, LocalUpdatesAreThoseOfTheWholeCovariance) {
  std::size_t most = 0, far = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    Pair pair(seed);
    RandomStream random(seed, 1);
    for (int step = 0; step < 120; ++step) {
      random_step(pair, random);
      pair.expect_same(1e-9);
      far += pair.filter->size() > pair.filter->near().size();
      if (::testing::Test::HasFailure()) FAIL() << "seed " << seed << " step " << step;
    }
    pair.filter->settle();
    EXPECT_EQ(pair.filter->near().size(), pair.twin.row_of.size());
    pair.expect_same(1e-9);
    most = std::max(most, pair.twin.row_of.size());
  }
  EXPECT_GT(most, 8u);
  EXPECT_GT(far, 12u * 120 / 3);  // in most steps something was put off
}

// One long stretch with all but one landmark far: the errors of what is put off do not add up.
TEST(LandmarkFilter, MuchMayBePutOff) {
  Pair pair(77);
  for (int i = 0; i < 12; ++i) pair.add();
  pair.filter->look_around(pair.filter->landmark(3), 0.1);
  ASSERT_LT(pair.filter->near().size(), 3u);
  for (int step = 0; step < 300; ++step) {
    pair.predict();
    pair.correct();
  }
  pair.filter->settle();
  pair.expect_same(1e-9);
}

TEST(LandmarkFilter, TheCovarianceIsSymmetricAndPositive) {
  for (std::uint64_t seed = 21; seed <= 24; ++seed) {
    Pair pair(seed);
    RandomStream random(seed, 1);
    for (int step = 0; step < 200; ++step) {
      random_step(pair, random);
      const MatrixXd& p = pair.filter->covariance();
      EXPECT_LT((p - p.transpose()).cwiseAbs().maxCoeff(), 2e-11);
      EXPECT_GT(Eigen::SelfAdjointEigenSolver<MatrixXd>(p).eigenvalues().minCoeff(), 0);
    }
    pair.filter->settle();
    const MatrixXd& all = pair.filter->covariance();
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<MatrixXd>(all).eigenvalues().minCoeff(), 0);
  }
}

// ---- Laws -------------------------------------------------------------------------------------

Pair furnished(std::uint64_t seed, int landmarks = 6) {
  Pair pair(seed);
  for (int i = 0; i < landmarks; ++i) pair.add();
  for (int i = 0; i < 10; ++i) pair.predict(), pair.correct();
  return pair;
}

TEST(LandmarkFilter, NothingHappensWithoutNews) {
  Pair pair = furnished(3);
  const VectorXd mean = pair.near_mean();
  const MatrixXd covariance = pair.filter->covariance();
  Motion still;
  still.at = pair.filter->extra();
  pair.filter->predict(still);
  pair.filter->settle();
  EXPECT_LT((pair.near_mean() - mean).cwiseAbs().maxCoeff(), 1e-15);
  EXPECT_LT((pair.filter->covariance() - covariance).cwiseAbs().maxCoeff(), 1e-15);
}

TEST(LandmarkFilter, ARemovedLandmarkLeavesTheOthersAsTheyAre) {
  for (const double radius : {3.0, 100.0}) {
    Pair with = furnished(4), without = furnished(4);
    for (Pair* p : {&with, &without}) {
      p->filter->look_around(p->filter->landmark(2), radius);
      p->filter->predict({.T_from_to = {1, 0, 0.2}, .at = p->filter->extra()});
    }
    without.filter->remove(2);
    EXPECT_EQ(without.filter->column(2), -1);
    EXPECT_EQ(without.filter->size(), 5u);
    for (Pair* p : {&with, &without}) p->filter->settle();
    for (const int a : without.filter->near()) {
      EXPECT_EQ(without.filter->landmark(a), with.filter->landmark(a));
      for (const int b : without.filter->near()) {
        const Eigen::Matrix2d here = without.filter->covariance().block<2, 2>(
            without.filter->column(a), without.filter->column(b));
        const Eigen::Matrix2d there =
            with.filter->covariance().block<2, 2>(with.filter->column(a), with.filter->column(b));
        EXPECT_LT((here - there).cwiseAbs().maxCoeff(), 1e-15);
      }
    }
  }
}

TEST(LandmarkFilter, ANewLandmarkTellsNothingOfThePose) {
  Pair pair = furnished(5);
  const MatrixXd before = pair.filter->covariance();
  pair.add();
  EXPECT_EQ(pair.filter->covariance().topLeftCorner(before.rows(), before.cols()), before);
}

// Relative poses, and how well they are known: of each landmark in the robot's frame.
struct Relative {
  VectorXd q;
  MatrixXd covariance;
};
Relative relative(const Pair& pair) {
  Sight all{pair.filter->near(), false};
  const Function h = [&](const VectorXd& s) {
    return all(s, [&](int id) { return pair.filter->column(id); });
  };
  const VectorXd at = pair.near_mean();
  const MatrixXd d = derivative(h, at);
  return {h(at), d * pair.filter->covariance() * d.transpose()};
}

TEST(LandmarkFilter, AMovedMapIsARigidMotion) {
  for (const double doubt : {0.0, 0.3}) {
    Pair pair = furnished(6);
    const Relative before = relative(pair);
    const Pose2 was = pair.filter->T_map_robot(), T{3, -40, 2.9};
    const MatrixXd covariance = pair.filter->covariance();
    pair.filter->move_map(T, doubt * Mat3::Identity());
    const Relative after = relative(pair);
    EXPECT_LT((after.q - before.q).cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_LT((after.covariance - before.covariance).cwiseAbs().maxCoeff(), 1e-9);
    EXPECT_LT(log(between(T * was, pair.filter->T_map_robot())).norm(), 1e-12);
    const double wider = pair.filter->covariance()(2, 2) - covariance(2, 2);
    EXPECT_NEAR(wider, doubt, 1e-12);
    // Numbers in the robot's axes are as they were.
    EXPECT_LT((pair.filter->covariance().block<8, 8>(3, 3) - covariance.block<8, 8>(3, 3))
                  .cwiseAbs()
                  .maxCoeff(),
              1e-15);
  }
}

TEST(LandmarkFilter, ThereAndBackIsTheSameMap) {
  Pair pair = furnished(7);
  const VectorXd mean = pair.near_mean();
  const MatrixXd covariance = pair.filter->covariance();
  const Pose2 T{1, 2, -1.3};
  pair.filter->move_map(T, Mat3::Zero());
  pair.filter->move_map(T.inverse(), Mat3::Zero());
  EXPECT_LT((pair.near_mean() - mean).cwiseAbs().maxCoeff(), 1e-13);
  EXPECT_LT((pair.filter->covariance() - covariance).cwiseAbs().maxCoeff(), 1e-13);
}

// Corrections of a straight measurement of independent things may come in any order, or together.
TEST(LandmarkFilter, TogetherIsOneAfterTheOther) {
  Pair one = furnished(8), other = furnished(8);
  const Eigen::Index n = one.filter->covariance().rows();
  RandomStream random(8, 2);
  MatrixXd by_state(4, n);
  for (Eigen::Index i = 0; i < n; ++i) by_state.col(i) = normals(4, random);
  const VectorXd residual = 0.1 * normals(4, random);
  MatrixXd noise = MatrixXd::Zero(4, 4);
  noise.topLeftCorner<2, 2>() = positive(2, random, 0.1);
  noise.bottomRightCorner<2, 2>() = positive(2, random, 0.1);
  const double together = one.filter->correct(residual, by_state, noise);
  const VectorXd before = other.near_mean();
  double apart =
      other.filter->correct(residual.head(2), by_state.topRows(2), noise.topLeftCorner<2, 2>());
  const VectorXd moved = other.near_mean() - before;
  apart += other.filter->correct(residual.tail(2) - by_state.bottomRows(2) * moved,
                                 by_state.bottomRows(2), noise.bottomRightCorner<2, 2>());
  EXPECT_NEAR(together, apart, 1e-10);
  EXPECT_LT((one.near_mean() - other.near_mean()).cwiseAbs().maxCoeff(), 1e-11);
  EXPECT_LT((one.filter->covariance() - other.filter->covariance()).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(LandmarkFilter, WhatIsFarIsAsItWasUntilAllIsSettled) {
  Pair pair = furnished(9);
  const Vec2 here = pair.filter->landmark(0);
  pair.filter->look_around(here, 1e-6);
  ASSERT_EQ(pair.filter->near(), std::vector<int>{0});
  EXPECT_EQ(pair.filter->column(1), -1);
  const Vec2 far = pair.filter->landmark(1);
  pair.correct();
  EXPECT_EQ(pair.filter->landmark(1), far);
  pair.filter->settle();
  EXPECT_GT((pair.filter->landmark(1) - far).norm(), 1e-6);
}

}  // namespace
}  // namespace majak::filter
