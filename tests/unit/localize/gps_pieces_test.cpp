// SPDX-License-Identifier: Apache-2.0
#include "majak/localize/gps_pieces.hpp"

#include <gtest/gtest.h>

#include <string>

namespace majak::localize {
namespace {

struct Row {
  double seconds, east, way, sigma = 0;
};

// "0 0 1": the piece of each fix; "." after those that are not trusted.
std::string told(const std::vector<FixVerdict>& verdicts) {
  std::string text;
  for (const FixVerdict& v : verdicts) {
    if (!text.empty()) text += ' ';
    text += std::to_string(v.piece);
    if (!v.trusted) text += '.';
  }
  return text;
}

struct Told {
  std::string at_once, at_the_end;
};

Told pieces_of(const std::vector<Row>& rows, const GpsPiecesOptions& options = {}) {
  GpsPieces pieces(options);
  std::vector<FixVerdict> at_once;
  for (const Row& r : rows)
    at_once.push_back(pieces.add({from_seconds(r.seconds), r.east, 0, r.sigma}, r.way));
  return {told(at_once), told(pieces.verdicts())};
}

TEST(GpsPieces, OnePieceIsTrustedFromItsThirdFixOn) {
  const Told t = pieces_of({{0, 10, 0}, {1, 11, 1}, {2, 12, 2}, {3, 13, 3}});
  EXPECT_EQ(t.at_once, "0. 0. 0 0");
  EXPECT_EQ(t.at_the_end, "0 0 0 0");
}

TEST(GpsPieces, AJumpBeginsAPiece) {
  const Told t =
      pieces_of({{0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {3, 4, 3}, {4, 5, 4}, {5, 6, 5}, {6, 7, 6}});
  EXPECT_EQ(t.at_once, "0. 0. 0 1. 1. 1 1");
  EXPECT_EQ(t.at_the_end, "0 0 0 1 1 1 1");
}

TEST(GpsPieces, StandingStillWhileTheWheelsRollIsAJumpToo) {
  const Told t = pieces_of({{0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {3, 2, 3}, {4, 3, 4}, {5, 4, 5}});
  EXPECT_EQ(t.at_the_end, "0 0 0 1 1 1");
}

TEST(GpsPieces, WhatTheWayAllowsIsNoJump) {
  // A step may differ from the way by 0.35 m; the direction and the sense of the way do not matter.
  EXPECT_EQ(pieces_of({{0, 0, 0}, {1, -1.34, 1}, {2, 0, 2}, {3, 0.66, 3}}).at_the_end, "0 0 0 0");
  EXPECT_EQ(pieces_of({{0, 0, 0}, {1, -1.36, 1}, {2, 0, 2}, {3, 0.64, 3}}).at_the_end,
            "0. 1. 2. 3.");
}

TEST(GpsPieces, StepsAreOfBothAxes) {
  GpsPieces pieces;
  EXPECT_EQ(pieces.add({0, 0, 0, 0}, 0).piece, 0U);
  EXPECT_EQ(pieces.add({kSecond, 3, 4, 0}, 5).piece, 0U);
  EXPECT_EQ(pieces.add({2 * kSecond, 3, 8, 0}, 5).piece, 1U);
}

TEST(GpsPieces, AnOutageBeginsAPieceAndItsLastFixIsNotTrusted) {
  // At the moment of the fourth fix nobody knows yet that the satellites are about to go.
  const Told t = pieces_of({{0, 0, 0},
                            {1, 1, 1},
                            {2, 2, 2},
                            {3, 3, 3},  //
                            {9, 9, 9},
                            {10, 10, 10},
                            {11, 11, 11}});
  EXPECT_EQ(t.at_once, "0. 0. 0 0 1. 1. 1");
  EXPECT_EQ(t.at_the_end, "0 0 0 0. 1 1 1");
}

TEST(GpsPieces, FiveSecondsAreNoOutageYet) {
  EXPECT_EQ(pieces_of({{0, 0, 0}, {5, 1, 1}, {10, 2, 2}}).at_the_end, "0 0 0");
  EXPECT_EQ(pieces_of({{0, 0, 0}, {5, 1, 1}, {10.001, 2, 2}}).at_the_end, "0. 0. 1.");
  EXPECT_EQ(pieces_of({{0, 0, 0}, {2, 1, 1}, {4, 2, 2}}, {.outage = 1.5}).at_the_end, "0. 1. 2.");
}

TEST(GpsPieces, PiecesOfAFewFixesAreNoWitness) {
  const std::vector<Row> rows = {{0, 0, 0},  {1, 1, 1},  {2, 2, 2},  //
                                 {3, 50, 3}, {4, 51, 4},             //
                                 {5, 5, 5},  {6, 6, 6},  {7, 7, 7}};
  EXPECT_EQ(pieces_of(rows).at_the_end, "0 0 0 1. 1. 2 2 2");
  EXPECT_EQ(pieces_of(rows, {.least = 2}).at_the_end, "0 0 0 1 1 2 2 2");
  EXPECT_EQ(pieces_of(rows, {.least = 4}).at_the_end, "0. 0. 0. 1. 1. 2. 2. 2.");
}

TEST(GpsPieces, AStatedSigmaWidensTheAllowedJump) {
  EXPECT_EQ(pieces_of({{0, 0, 0, 4}, {1, 4, 1, 4}, {2, 5, 2, 4}}).at_the_end, "0 0 0");
  EXPECT_EQ(pieces_of({{0, 0, 0, 2}, {1, 4, 1, 2}, {2, 5, 2, 2}}).at_the_end, "0. 1. 1.");
  // A receiver that is better than `jump` does not narrow it.
  EXPECT_EQ(pieces_of({{0, 0, 0, 0.01}, {1, 1.3, 1, 0.01}, {2, 2, 2, 0.01}}).at_the_end, "0 0 0");
}

TEST(GpsPieces, NoFixesNoVerdicts) { EXPECT_EQ(pieces_of({}).at_the_end, ""); }

}  // namespace
}  // namespace majak::localize
