// SPDX-License-Identifier: Apache-2.0
#include "majak/draw/findings.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace majak::draw {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::Not;

Site with(const OdometryFindings& odometry) {
  Site site;
  site.used_odometry = true;
  site.odometry = odometry;
  return site;
}

OdometryFindings told() {
  OdometryFindings o;
  o.lag_s = {0, 0.001, true};
  o.translation_scale = o.rotation_scale = {1, 0.001, true};
  return o;
}

TEST(OdometryInWords, SaysThatNoneWasUsed) {
  EXPECT_THAT(odometry_in_words({}), testing::ElementsAre(HasSubstr("No odometry was used")));
}

TEST(OdometryInWords, SaysWhatIsWrongWithOdometryThatWasNotUsed) {
  OdometryFindings o = told();
  o.lag_s.value = 0.3;
  o.reversed_records = 308;
  Site site = with(o);
  site.used_odometry = false;
  const auto words = odometry_in_words(site);
  EXPECT_THAT(words, Contains(HasSubstr("The odometry was not used")));
  EXPECT_THAT(words, Contains("The odometry is 0.3 s (±0.001 s) late."));
  EXPECT_THAT(words, Contains(HasSubstr("308 of its records")));
}

TEST(OdometryInWords, SaysLateAndEarly) {
  OdometryFindings o = told();
  o.lag_s = {0.104, 0.01, true};
  EXPECT_THAT(odometry_in_words(with(o)),
              Contains("The odometry is 0.1 s (±0.01 s) late; this is corrected."));
  o.lag_s.value = -0.25;
  EXPECT_THAT(odometry_in_words(with(o)), Contains(HasSubstr("0.25 s (±0.01 s) early")));
}

TEST(OdometryInWords, IsNotExcitedByWhatIsWithinTheNoise) {
  OdometryFindings o = told();
  o.lag_s = {0.02, 0.02, true};
  o.translation_scale = {1.01, 0.02, true};
  EXPECT_THAT(odometry_in_words(with(o)), Contains("Odometry and laser agree in time."));
  EXPECT_THAT(odometry_in_words(with(o)), Contains("Its distances have the right scale."));
}

TEST(OdometryInWords, SaysShortAndLong) {
  OdometryFindings o = told();
  o.translation_scale = {1.25, 0.01, true};  // true = 1.25 odometry: it counts 20 % too little
  o.rotation_scale = {0.8, 0.01, true};
  EXPECT_THAT(odometry_in_words(with(o)),
              Contains(HasSubstr("Its distances come out 20 % (±1 %) too short")));
  EXPECT_THAT(odometry_in_words(with(o)),
              Contains(HasSubstr("Its turns come out 25 % (±1 %) too large")));
}

TEST(OdometryInWords, CountsRecordsThatSayTheWrongDirection) {
  OdometryFindings o = told();
  EXPECT_THAT(odometry_in_words(with(o)), Not(Contains(HasSubstr("wrong direction"))));
  o.reversed_records = 320;
  EXPECT_THAT(odometry_in_words(with(o)),
              Contains(HasSubstr("320 of its records state the wrong direction of travel")));
}

TEST(OdometryInWords, CountsJumps) {
  OdometryFindings o = told();
  EXPECT_THAT(odometry_in_words(with(o)), Not(Contains(HasSubstr("farther than a robot drives"))));
  o.jumps = 1;
  EXPECT_THAT(odometry_in_words(with(o)),
              Contains(HasSubstr("1 of its steps is farther than a robot drives")));
}

TEST(OdometryInWords, SaysWhereTheLaserSits) {
  OdometryFindings o = told();
  o.laser_x_m = {-0.04, 0.002, true};
  o.laser_y_m = {0.5, 0.1, false};
  o.laser_theta_rad = {radians(1.5), radians(0.1), true};
  const auto words = odometry_in_words(with(o));
  EXPECT_THAT(words, Contains("The laser sits 0.04 m (±0.002 m) behind the robot's centre."));
  EXPECT_THAT(words, Contains("The laser looks 1.5 degrees (±0.1 degrees) to the left."));
  EXPECT_THAT(words, Not(Contains(HasSubstr("left of"))));
}

TEST(OdometryInWords, SaysWhatItCannotTell) {
  EXPECT_THAT(odometry_in_words(with({})), testing::ElementsAre(HasSubstr("does not tell")));
  OdometryFindings o = told();
  o.lag_s.used = false;
  EXPECT_THAT(odometry_in_words(with(o)), Contains(HasSubstr("early or late cannot be told")));
}

TEST(VerdictInWords, FollowsTheHealth) {
  io::Figures f;
  EXPECT_THAT(verdict_in_words({}, f), HasSubstr("no scans"));
  f.scans = f.ok = 1;
  EXPECT_THAT(verdict_in_words({}, f), HasSubstr("single scan"));
  f.scans = f.ok = 1000;
  EXPECT_THAT(verdict_in_words({}, f),
              HasSubstr("Every scan fits the map. No place was recognised again"));
  f.degraded = 125;
  f.lost = 10;
  f.closures = 1;
  f.front_end_shift_max_m = 0.25;
  const std::string verdict = verdict_in_words({}, f);
  EXPECT_THAT(verdict, HasSubstr("10 scans (1 %) do not fit"));
  EXPECT_THAT(verdict, HasSubstr("125 scans (12.5 %) saw too little"));
  EXPECT_THAT(verdict, HasSubstr("1 loop closure ties"));
  EXPECT_THAT(verdict, HasSubstr("0.25 m"));
}

TEST(EditsInWords, CountThemByKind) {
  Site site;
  EXPECT_EQ(edits_in_words(site), "");
  site.scans.resize(2);
  site.edits.resize(3);
  site.edits[1].kind = EditKind::turn;
  EXPECT_EQ(edits_in_words(site), "3 edits by hand: 2 erased areas, 1 turn.");
  EXPECT_THAT(verdict_in_words(site, {.scans = 2}), HasSubstr("3 edits by hand"));
  site.edits = {Edit{.kind = EditKind::closure_off}};
  EXPECT_EQ(edits_in_words(site), "1 edit by hand: 1 closure switched off.");
}

}  // namespace
}  // namespace majak::draw
