// SPDX-License-Identifier: Apache-2.0
#include "majak/map/objects.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "majak/core/error.hpp"
#include "majak/core/random.hpp"
#include "tests/support/ascii_map.hpp"

namespace majak::map {
namespace {

constexpr double kCell = 0.05;

/// A walled room of 4 x 3 m, free but for what is put there.
class Room {
 public:
  Room() {
    map_.resolution = kCell;
    map_.width = kWide;
    map_.height = kHigh;
    map_.cells.assign(std::size_t{kWide} * kHigh, CellState::free);
    for (int x = 0; x < kWide; ++x) occupy(x, 0), occupy(x, kHigh - 1);
    for (int y = 0; y < kHigh; ++y) occupy(0, y), occupy(kWide - 1, y);
  }
  /// Outline of a polygon at T_map_thing; inside nothing is known.
  Room& put(const std::vector<Vec2>& corners, const Pose2& T) {
    for (int y = 0; y < kHigh; ++y)
      for (int x = 0; x < kWide; ++x)
        if (inside(corners, T.inverse() * map_.centre(x, y)))
          map_.cells[map_.index(x, y)] = CellState::unknown;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Vec2 a = T * corners[i], b = T * corners[(i + 1) % corners.size()];
      for (double t = 0; t <= 1; t += 0.01) {
        const Vec2 p = a + t * (b - a);
        occupy(map_.column(p.x()), map_.row(p.y()));
      }
    }
    return *this;
  }
  const KnownMap& map() const { return map_; }

 private:
  static constexpr int kWide = 80, kHigh = 60;
  void occupy(int x, int y) { map_.cells[map_.index(x, y)] = CellState::occupied; }
  static bool inside(const std::vector<Vec2>& corners, const Vec2& p) {
    bool in = false;
    for (std::size_t i = 0, j = corners.size() - 1; i < corners.size(); j = i++)
      if ((corners[i].y() > p.y()) != (corners[j].y() > p.y()) &&
          p.x() < (corners[j].x() - corners[i].x()) * (p.y() - corners[i].y()) /
                          (corners[j].y() - corners[i].y()) +
                      corners[i].x())
        in = !in;
    return in;
  }
  KnownMap map_;
};

const std::vector<Vec2> kBox = {{-0.4, -0.25}, {0.4, -0.25}, {0.4, 0.25}, {-0.4, 0.25}};
const std::vector<Vec2> kWedge = {{-0.3, -0.4}, {0.5, -0.4}, {-0.3, 0.5}};

std::vector<KnownMap> four_visits() {
  return {Room().put(kBox, {1.0, 1.0, 0}).put(kWedge, {2.8, 1.9, 0.3}).map(),
          Room().put(kBox, {2.9, 0.8, 0.7}).put(kWedge, {1.0, 2.0, 2.0}).map(),
          Room().put(kBox, {1.1, 2.1, -0.4}).put(kWedge, {2.7, 0.9, -1.0}).map(),
          Room().put(kBox, {2.9, 2.2, 1.2}).put(kWedge, {1.0, 0.9, 1.1}).map()};
}

TEST(Pieces, WhatStaysIsNoPiece) {
  const std::vector<KnownMap> rooms(3, Room().put(kBox, {2, 1.5, 0.2}).map());
  const KnownMap still = still_map(rooms);
  EXPECT_EQ(still.all(CellState::occupied), rooms.front().all(CellState::occupied));
  EXPECT_TRUE(pieces_of(still, rooms.front(), 0).empty());
}

TEST(Pieces, AThingThatStandsElsewhereIsOnePieceEachTime) {
  const auto rooms = four_visits();
  const KnownMap still = still_map(rooms);
  EXPECT_EQ(still.all(CellState::occupied), Room().map().all(CellState::occupied));
  for (std::size_t t = 0; t < rooms.size(); ++t) {
    const auto pieces = pieces_of(still, rooms[t], t);
    ASSERT_EQ(pieces.size(), 2U);
    std::size_t points = 0;
    for (const Piece& p : pieces) {
      EXPECT_EQ(p.snapshot, t);
      points += p.points.size();
      for (const Vec2& q : p.points) EXPECT_EQ(rooms[t].at(q), CellState::occupied);
    }
    // All of both outlines: 2.6 m and 2.9 m.
    EXPECT_NEAR(static_cast<double>(points), 5.5 / kCell * 1.15, 20);
  }
}

TEST(Pieces, OtherLatticesAreRefused) {
  std::vector<KnownMap> rooms = four_visits();
  rooms[1].x0 += 0.4 * kCell;
  EXPECT_THROW(still_map(rooms), Error);
  rooms[1].x0 = 3 * kCell;
  EXPECT_NO_THROW(still_map(rooms));
}

/// A shape learnt from one piece fits that piece where it is, and wherever it is carried.
TEST(ObjectShape, IsFoundAgainWhereItWasCarried) {
  const ShapeOptions options;
  const auto learn = Room().put(kWedge, {1.5, 1.5, 0}).map();
  const std::vector<KnownMap> empty(2, Room().map());
  const KnownMap still = still_map(empty);
  const auto pieces = pieces_of(still, learn, 0);
  ASSERT_EQ(pieces.size(), 1U);
  const KnownMap clear = clear_floor(learn);
  const ObjectShape::Sighting sighting{{&pieces[0], &clear}, {1.5, 1.5, 0}, 1};
  const ObjectShape shape({&sighting, 1}, kCell, options);
  EXPECT_NEAR(refined_fit(shape, sighting.seen, sighting.T_map_object, options).T_map_object.x, 1.5,
              0.03);
  RandomStream random(3);
  for (int i = 0; i < 10; ++i) {
    const Pose2 T{random.uniform(0.9, 3.1), random.uniform(0.9, 2.1), random.uniform(-kPi, kPi)};
    const KnownMap seen = Room().put(kWedge, T).map();
    const auto found = pieces_of(still, seen, 0);
    ASSERT_EQ(found.size(), 1U);
    const KnownMap around = clear_floor(seen);
    const ShapeFit fit = best_fit(shape, {&found[0], &around}, options);
    EXPECT_LT((fit.T_map_object.translation() - T.translation()).norm(), 0.04);
    EXPECT_LT(std::abs(angle_diff(fit.T_map_object.theta, T.theta)), radians(4));
  }
}

/// Cells hold the share of sightings that saw them occupied; those never seen the prior.
TEST(ObjectShape, ChancesAreShares) {
  const ShapeOptions options;
  const KnownMap map =
      fixture::ascii_map({".......", ".......", "..###..", ".......", "......."}, 1);
  const Piece piece{0, {{2.5, 2.5}, {3.5, 2.5}, {4.5, 2.5}}};
  ShapeOptions coarse = options;
  coarse.reach = 4;
  const KnownMap clear = clear_floor(map);
  const ObjectShape::Sighting s{{&piece, &clear}, {3.5, 2.5, 0}, 2};
  const ObjectShape shape({&s, 1}, 1, coarse);
  const double prior = options.unseen * options.unseen_weight;
  EXPECT_NEAR(shape.chance(0, 0), (2 + prior) / (2 + options.unseen_weight), 1e-6);
  EXPECT_NEAR(shape.chance(0, 2), prior / (2 + options.unseen_weight), 1e-6);  // clear floor
  EXPECT_NEAR(shape.chance(0, 1), options.unseen, 1e-6);                       // beside it: no vote
  EXPECT_NEAR(shape.chance(0, 4), options.unseen, 1e-6);                       // off the map
  EXPECT_EQ(shape.surface().size(), 3U);
  EXPECT_NEAR((shape.middle() - Vec2(0, 0)).norm(), 0, 1e-12);
  EXPECT_NEAR(shape.log_chance({0.5, 0}), std::log(shape.chance(0, 0)), 1e-6);  // both the same
}

TEST(Objects, TwoThingsInFourVisits) {
  const ObjectMap found = find_objects(four_visits());
  ASSERT_EQ(found.objects.size(), 2U);
  ASSERT_EQ(found.sightings.size(), 8U);
  for (const ObjectSighting& s : found.sightings) EXPECT_GT(s.probability, 0.95);
  const auto of = [&](std::size_t snapshot) {
    std::vector<std::size_t> objects;
    for (const ObjectSighting& s : found.sightings)
      if (found.pieces[s.piece].snapshot == snapshot) objects.push_back(s.object);
    std::sort(objects.begin(), objects.end());
    return objects;
  };
  for (std::size_t t = 0; t < 4; ++t) EXPECT_EQ(of(t), (std::vector<std::size_t>{0, 1}));
  // One object is the box all through.
  const Vec2 boxes[] = {{1.0, 1.0}, {2.9, 0.8}, {1.1, 2.1}, {2.9, 2.2}};
  std::vector<std::size_t> box;
  for (const ObjectSighting& s : found.sightings)
    if ((s.T_map_object * found.objects[s.object].middle() - boxes[found.pieces[s.piece].snapshot])
            .norm() < 0.1)
      box.push_back(s.object);
  EXPECT_EQ(box, std::vector<std::size_t>(4, box.at(0)));
}

TEST(Objects, AMovedBoxIsRecognizedWhereItStands) {
  const ObjectMap found = find_objects(four_visits());
  const Pose2 T{2.0, 1.4, 0.5};
  const Recognition seen = recognize(found, Room().put(kBox, T).map());
  ASSERT_EQ(seen.pieces.size(), 1U);
  ASSERT_EQ(seen.sightings.size(), 1U);
  EXPECT_GT(seen.sightings[0].probability, 0.95);
  const Vec2 middle =
      seen.sightings[0].T_map_object * found.objects[seen.sightings[0].object].middle();
  EXPECT_LT((middle - T.translation()).norm(), 0.06);
  EXPECT_TRUE(recognize(found, Room().map()).pieces.empty());
}

TEST(Objects, SameBytesForAnyNumberOfThreads) {
  const auto rooms = four_visits();
  const ObjectMap one = find_objects(rooms, {}, {1});
  for (const int threads : {2, 8}) {
    const ObjectMap many = find_objects(rooms, {}, {threads});
    EXPECT_EQ(many.score, one.score);
    ASSERT_EQ(many.sightings.size(), one.sightings.size());
    for (std::size_t i = 0; i < one.sightings.size(); ++i)
      EXPECT_EQ(many.sightings[i].T_map_object, one.sightings[i].T_map_object);
  }
}

TEST(Objects, TheLargestPiecesAreKept) {
  ObjectOptions options;
  options.most_pieces = 4;
  const ObjectMap few = find_objects(four_visits(), options);
  EXPECT_LE(few.pieces.size(), 4U);
  EXPECT_EQ(few.pieces.size() + few.left_out, 8U);
}

TEST(Objects, NothingMovedIsSaidPlainly) {
  EXPECT_TRUE(find_objects({}).objects.empty());
  const std::vector<KnownMap> rooms(4, Room().put(kBox, {2, 1.5, 0}).map());
  EXPECT_TRUE(find_objects(rooms).objects.empty());
  ObjectOptions bad;
  bad.most_objects = 0;
  EXPECT_THROW(find_objects(rooms, bad), Error);
}

}  // namespace
}  // namespace majak::map
