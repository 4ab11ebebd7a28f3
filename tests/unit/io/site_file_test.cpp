// SPDX-License-Identifier: Apache-2.0
#include "majak/io/site_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sqlite3.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>

#include "majak/core/error.hpp"
#include "majak/core/random.hpp"

namespace majak::io {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

/// A site that uses every field.
Site rich_site() {
  RandomStream random(21);
  const auto pose = [&] { return Pose2{random.normal(), random.normal(), random.uniform(-3, 3)}; };
  Site site;
  site.source_name = "häuser & <rooms>.clf";
  site.used_odometry = true;
  site.options_toml = "[match]\nmax_range = 30.0\n";
  for (int i = 0; i < 40; ++i) {
    PosedScan p;
    p.scan.time = 976052857337530000 + i * Time{123456789};
    p.scan.start_angle = -kPi / 2;
    p.scan.angle_step = radians(i < 30 ? 1.0 : 0.5);
    p.scan.max_range = 81.83F;
    p.scan.T_robot_laser = {0.1, 0.02, 0.003};
    p.scan.laser = i % 2;
    for (int k = 0; k < 50; ++k) {
      p.scan.ranges.push_back(
          k % 9 == 4   ? kNoReturn
          : i % 4 == 0 ? static_cast<float>(random.uniform(0, 80))
                       : static_cast<float>(std::floor(random.uniform(0, 8000)) / 100.0));
    }
    if (i % 5 == 0) p.scan.intensities.assign(50, 3.0F);
    if (i % 3 == 0) p.scan.T_odom_robot = pose();
    if (i % 4 == 1) p.T_odom_robot = pose();
    p.estimate.time = p.scan.time + (i % 7 == 0 ? 1000 : 0);
    p.estimate.T_map_robot = pose();
    p.T_map_robot_front_end = pose();
    const Mat3 root = Mat3::NullaryExpr([&] { return random.normal(); });
    p.estimate.covariance = root * root.transpose();
    p.estimate.health = static_cast<Health>(i % 3);
    if (i % 3 == 1) p.estimate.weak_direction = {0.6, -0.8};
    p.key = i % 4 == 0;
    p.match_score = static_cast<float>(random.uniform());
    site.scans.push_back(std::move(p));
  }
  for (std::size_t i = 1; i < 40; ++i) {
    Constraint c;
    c.kind = static_cast<ConstraintKind>(i % 3);
    c.from = i - 1;
    c.to = i;
    c.T_from_to = pose();
    c.information = Mat3::Identity() * random.uniform(1, 1e6);
    c.score = random.uniform();
    c.overlap = random.uniform();
    c.chi2 = random.uniform(0, 20);
    c.enabled = i % 5 != 0;
    site.constraints.push_back(c);
  }
  for (const PosedScan& p : site.scans)
    if (p.key)
      site.key_links.push_back(
          {site.key_links.size() / 2, p.scan.laser == 0, Vec3(4, 5, 6).asDiagonal()});
  for (int kind = 0; kind < kEditKinds; ++kind) {
    Edit edit;
    edit.id = 3 * kind + 2;
    edit.kind = static_cast<EditKind>(kind);
    if (edit.kind == EditKind::turn) edit.radians = 0.3;
    if (edit.kind == EditKind::closure_off) edit.from = 4, edit.to = 39;
    for (int i = 0; kind < 4 && i < 3 + kind; ++i)
      edit.points.push_back({random.below(40), {random.normal(), random.normal()}});
    site.edits.push_back(edit);
  }
  for (int i = 0; i < 7; ++i) site.truth.push_back({i * kSecond, pose()});
  site.odometry.lag_s = {0.1, 0.01, true};
  site.odometry.rotation_scale = {1.02, 0.001, false};
  site.odometry.reversed_records = 320;
  site.odometry.jumps = 3;
  site.odometry.translation_noise = 0.03;
  site.odometry.rotation_noise = 0.05;
  site.report.count("carmen: truncated FLASER", 4711);
  site.report.count("carmen: truncated FLASER", 4712);
  site.report.count("scan without beams");
  return site;
}

void expect_equal(const Estimate& a, const Estimate& b) {
  EXPECT_EQ(a.time, b.time);
  EXPECT_EQ(a.T_map_robot, b.T_map_robot);
  EXPECT_EQ(a.covariance, b.covariance);
  EXPECT_EQ(a.health, b.health);
  EXPECT_EQ(a.weak_direction, b.weak_direction);
}

void expect_equal(const PosedScan& a, const PosedScan& b) {
  EXPECT_EQ(a.scan.time, b.scan.time);
  EXPECT_EQ(a.scan.start_angle, b.scan.start_angle);
  EXPECT_EQ(a.scan.angle_step, b.scan.angle_step);
  EXPECT_EQ(a.scan.max_range, b.scan.max_range);
  EXPECT_EQ(a.scan.T_robot_laser, b.scan.T_robot_laser);
  EXPECT_EQ(a.scan.laser, b.scan.laser);
  EXPECT_EQ(a.scan.ranges, b.scan.ranges);
  EXPECT_EQ(a.scan.intensities, b.scan.intensities);
  EXPECT_EQ(a.scan.T_odom_robot, b.scan.T_odom_robot);
  EXPECT_EQ(a.T_odom_robot, b.T_odom_robot);
  EXPECT_EQ(a.T_map_robot_front_end, b.T_map_robot_front_end);
  EXPECT_EQ(a.key, b.key);
  EXPECT_EQ(a.match_score, b.match_score);
  expect_equal(a.estimate, b.estimate);
}

void expect_equal(const Constraint& a, const Constraint& b) {
  EXPECT_EQ(a.kind, b.kind);
  EXPECT_EQ(a.from, b.from);
  EXPECT_EQ(a.to, b.to);
  EXPECT_EQ(a.T_from_to, b.T_from_to);
  EXPECT_EQ(a.information, b.information);
  EXPECT_EQ(a.score, b.score);
  EXPECT_EQ(a.overlap, b.overlap);
  EXPECT_EQ(a.chi2, b.chi2);
  EXPECT_EQ(a.enabled, b.enabled);
}

void expect_equal(const Learnt& a, const Learnt& b) {
  EXPECT_EQ(a.value, b.value);
  EXPECT_EQ(a.sigma, b.sigma);
  EXPECT_EQ(a.used, b.used);
}

void expect_equal(const Site& a, const Site& b) {
  EXPECT_EQ(a.source_name, b.source_name);
  EXPECT_EQ(a.used_odometry, b.used_odometry);
  EXPECT_EQ(a.options_toml, b.options_toml);
  ASSERT_EQ(a.scans.size(), b.scans.size());
  for (std::size_t i = 0; i < a.scans.size(); ++i) expect_equal(a.scans[i], b.scans[i]);
  ASSERT_EQ(a.constraints.size(), b.constraints.size());
  for (std::size_t i = 0; i < a.constraints.size(); ++i)
    expect_equal(a.constraints[i], b.constraints[i]);
  ASSERT_EQ(a.key_links.size(), b.key_links.size());
  for (std::size_t k = 0; k < a.key_links.size(); ++k) {
    EXPECT_EQ(a.key_links[k].local_map, b.key_links[k].local_map);
    EXPECT_EQ(a.key_links[k].weak_step, b.key_links[k].weak_step);
    EXPECT_EQ(a.key_links[k].match_information, b.key_links[k].match_information);
  }
  EXPECT_EQ(a.edits, b.edits);
  ASSERT_EQ(a.truth.size(), b.truth.size());
  for (std::size_t i = 0; i < a.truth.size(); ++i) {
    EXPECT_EQ(a.truth[i].time, b.truth[i].time);
    EXPECT_EQ(a.truth[i].T_world_robot, b.truth[i].T_world_robot);
  }
  expect_equal(a.odometry.lag_s, b.odometry.lag_s);
  expect_equal(a.odometry.rotation_scale, b.odometry.rotation_scale);
  EXPECT_EQ(a.odometry.reversed_records, b.odometry.reversed_records);
  EXPECT_EQ(a.odometry.jumps, b.odometry.jumps);
  EXPECT_EQ(a.odometry.translation_noise, b.odometry.translation_noise);
  EXPECT_EQ(a.odometry.rotation_noise, b.odometry.rotation_noise);
  ASSERT_EQ(a.report.entries().size(), b.report.entries().size());
  for (const auto& [what, entry] : a.report.entries()) {
    const auto other = b.report.entries().find(what);
    ASSERT_NE(other, b.report.entries().end()) << what;
    EXPECT_EQ(other->second.count, entry.count);
    EXPECT_EQ(other->second.first_line, entry.first_line);
  }
}

class SiteFile : public testing::Test {
 protected:
  SiteFile() { fs::create_directories(folder_); }
  ~SiteFile() override { fs::remove_all(folder_); }

  std::string bytes() const {
    std::ifstream in(path_, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  void put(std::string_view bytes) const {
    std::ofstream(path_, std::ios::binary)
        .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  }
  std::string error() const {
    try {
      read_site_to_edit(path_);
    } catch (const Error& e) {
      EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos);
      return e.what();
    }
    return "no error";
  }
  void sql(const char* statement) const {
    sqlite3* db = nullptr;
    ASSERT_EQ(sqlite3_open(path_.c_str(), &db), SQLITE_OK);
    EXPECT_EQ(sqlite3_exec(db, statement, nullptr, nullptr, nullptr), SQLITE_OK)
        << sqlite3_errmsg(db);
    sqlite3_close(db);
  }

  fs::path folder_ =
      fs::path(testing::TempDir()) /
      ("majak_site_" + std::to_string(::testing::UnitTest::GetInstance()->random_seed()) +
       testing::UnitTest::GetInstance()->current_test_info()->name());
  fs::path path_ = folder_ / "a?strange#name%20 site.majak";
};

TEST_F(SiteFile, ReadsBackAllThatWasWritten) {
  const Site site = rich_site();
  write_site(path_, site);
  expect_equal(read_site_to_edit(path_), site);
}

TEST_F(SiteFile, HoldsAnEmptySite) {
  write_site(path_, {});
  expect_equal(read_site_to_edit(path_), {});
}

TEST_F(SiteFile, HoldsNumbersThatAreNone) {
  Site site;
  site.scans.resize(1);
  site.scans[0].estimate.T_map_robot.x = std::numeric_limits<double>::quiet_NaN();
  site.scans[0].estimate.T_map_robot.y = -std::numeric_limits<double>::infinity();
  site.scans[0].estimate.covariance(0, 0) = std::numeric_limits<double>::infinity();
  write_site(path_, site);
  const Site back = read_site_to_edit(path_);
  EXPECT_TRUE(std::isnan(back.scans[0].estimate.T_map_robot.x));
  EXPECT_EQ(back.scans[0].estimate.T_map_robot.y, -std::numeric_limits<double>::infinity());
  EXPECT_EQ(back.scans[0].estimate.covariance, site.scans[0].estimate.covariance);
}

TEST_F(SiteFile, GivesTheSameBytesEachTime) {
  const Site site = rich_site();
  write_site(path_, site);
  const std::string first = bytes();
  write_site(path_, site);
  EXPECT_EQ(bytes(), first);
  write_site(path_, read_site_to_edit(path_));
  EXPECT_EQ(bytes(), first);
}

TEST_F(SiteFile, LeavesNothingElseInTheFolder) {
  write_site(path_, rich_site());
  read_site_to_edit(path_);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()), 1);
}

TEST_F(SiteFile, IsOpenToSql) {
  write_site(path_, rich_site());
  sqlite3* db = nullptr;
  ASSERT_EQ(sqlite3_open(path_.c_str(), &db), SQLITE_OK);
  sqlite3_stmt* row = nullptr;
  ASSERT_EQ(
      sqlite3_prepare_v2(
          db,
          "SELECT count(*), min(time_ns), (SELECT count(*) FROM relation WHERE enabled) FROM scan",
          -1, &row, nullptr),
      SQLITE_OK);
  ASSERT_EQ(sqlite3_step(row), SQLITE_ROW);
  EXPECT_EQ(sqlite3_column_int(row, 0), 40);
  EXPECT_EQ(sqlite3_column_int64(row, 1), 976052857337530000);
  EXPECT_EQ(sqlite3_column_int(row, 2), 32);
  sqlite3_finalize(row);
  sqlite3_close(db);
}

TEST_F(SiteFile, SaysWhatAForeignFileIs) {
  EXPECT_THAT(error(), AllOf(StartsWith(path_.string()), HasSubstr("cannot be read")));
  for (const std::string_view text : {"", "FLASER 180 1.0", "SQLite format 2", "\x89PNG"}) {
    put(text);
    EXPECT_THAT(error(), HasSubstr("not a majak site")) << text;
  }
  fs::remove(path_);
  sql("CREATE TABLE scan(id)");
  EXPECT_THAT(error(), HasSubstr("another program"));
}

TEST_F(SiteFile, SaysThatAFolderIsNone) {
  fs::create_directories(path_);
  EXPECT_THAT(error(), StartsWith(path_.string()));
  EXPECT_THROW(write_site(path_, {}), Error);
}

TEST_F(SiteFile, RefusesANewerFormat) {
  write_site(path_, rich_site());
  sql("PRAGMA user_version=3");
  EXPECT_THAT(error(), AllOf(HasSubstr("newer"), HasSubstr("format 3"), HasSubstr("update")));
}

/// What version 1 did not know is empty.
TEST_F(SiteFile, ReadsTheFirstFormat) {
  Site site = rich_site();
  site.key_links.clear(), site.edits.clear();
  write_site(path_, site);
  sql("DROP TABLE key_link; DROP TABLE edit; DROP TABLE edit_point; PRAGMA user_version=1");
  expect_equal(read_site_to_edit(path_), site);
  site.edits = rich_site().edits;
  write_edits(path_, site);
  expect_equal(read_site_to_edit(path_), site);
}

TEST_F(SiteFile, IsReadWithItsEditsAppliedAndNotKeptSo) {
  const Site site = rich_site();
  write_site(path_, site);
  const Site shown = read_site(path_);
  EXPECT_TRUE(shown.edits_applied);
  const Pose2 turned = Pose2{0, 0, 0.3} * site.scans[5].estimate.T_map_robot;
  EXPECT_EQ(shown.scans[5].estimate.T_map_robot, turned);
  const std::string before = bytes();
  EXPECT_THROW(write_site(path_, shown), Error);
  EXPECT_EQ(bytes(), before);
}

// ---- Edits that are newer than the file ---------------------------------------------------------

TEST_F(SiteFile, TakesTheEditsBesideIt) {
  Site site = rich_site();
  write_site(path_, site);
  const std::string whole = bytes();
  for (int undone = 0; undone < 7; ++undone) {
    write_edits(path_, site);
    EXPECT_EQ(bytes(), whole);
    expect_equal(read_site_to_edit(path_), site);
    if (!site.edits.empty()) site.edits.pop_back();
  }
  write_site(path_, site);
  EXPECT_FALSE(fs::exists(edits_file(path_)));
  expect_equal(read_site_to_edit(path_), site);
}

TEST_F(SiteFile, TakesNoEditsOfAnotherSite) {
  Site site = rich_site();
  write_site(path_, site);
  write_edits(path_, site);
  const fs::path kept = folder_ / "kept";
  fs::copy_file(edits_file(path_), kept);
  site.edits.clear();
  site.source_name = "another";
  write_site(path_, site);
  fs::copy_file(kept, edits_file(path_));
  expect_equal(read_site_to_edit(path_), site);
}

TEST_F(SiteFile, NoticesDamagedEditsBesideIt) {
  Site site = rich_site();
  write_site(path_, site);
  write_edits(path_, site);
  std::ifstream in(edits_file(path_), std::ios::binary);
  const std::string whole{std::istreambuf_iterator<char>(in), {}};
  RandomStream random(32);
  int detected = 0;
  constexpr int kTries = 400;
  for (int i = 0; i < kTries; ++i) {
    std::string damaged = whole;
    std::size_t place = random.below(whole.size());
    while (i % 10 && whole[place] == '\0') place = random.below(whole.size());
    damaged[place] = static_cast<char>(damaged[place] ^ (1 << random.below(8)));
    std::ofstream(edits_file(path_), std::ios::binary) << damaged;
    try {
      expect_equal(read_site_to_edit(path_), site);
      if (HasFailure()) FAIL() << "wrong data from byte " << place;
    } catch (const Error& e) {
      EXPECT_THAT(e.what(), StartsWith(edits_file(path_).string()));
      ++detected;
    }
  }
  EXPECT_GT(detected, kTries / 2);
}

/// A child tells through a pipe how many edits it has been told are kept; killed at any moment it
/// leaves so many, or one more that it was about to tell of.
TEST_F(SiteFile, KeepsEveryEditThatItAcknowledged) {
  Site site = rich_site();
  site.edits.clear();
  write_site(path_, site);
  RandomStream random(33);
  for (int round = 0; round < 12; ++round) {
    int ends[2];
    ASSERT_EQ(pipe(ends), 0);
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      for (unsigned char n = static_cast<unsigned char>(site.edits.size()); n < 250;) {
        Edit edit;
        edit.id = ++n;
        site.edits.push_back(edit);
        n % 16 == 15 ? write_site(path_, site) : write_edits(path_, site);
        if (write(ends[1], &n, 1) != 1) _exit(1);
      }
      _exit(0);
    }
    close(ends[1]);
    unsigned char told = static_cast<unsigned char>(site.edits.size()), n = 0;
    while (told < 18 * (round + 1) && read(ends[0], &n, 1) == 1) told = n;
    usleep(static_cast<useconds_t>(random.below(3000)));
    kill(child, SIGKILL);
    while (read(ends[0], &n, 1) == 1) told = n;
    close(ends[0]);
    waitpid(child, nullptr, 0);
    const Site kept = read_site_to_edit(path_);
    EXPECT_GE(kept.edits.size(), told);
    EXPECT_LE(kept.edits.size(), told + 1U);
    site.edits = kept.edits;
  }
  EXPECT_GT(site.edits.size(), 200U);
}

TEST_F(SiteFile, RefusesWhatIsCutShort) {
  write_site(path_, rich_site());
  const std::string whole = bytes();
  for (std::size_t n = 0; n < whole.size(); n += n < 200 ? 7 : 1777) {
    put(std::string_view(whole).substr(0, n));
    EXPECT_THAT(error(), StartsWith(path_.string() + ": ")) << n;
  }
}

TEST_F(SiteFile, NoticesWhatAnotherProgramChanged) {
  for (const char* change : {"UPDATE scan SET x = x + 1e-9 WHERE id = 7",
                             "UPDATE relation SET enabled = 1 - enabled WHERE id = 3",
                             "DELETE FROM scan WHERE id = 39",
                             "DELETE FROM truth",
                             "UPDATE meta SET value = 'x' WHERE key = 'options_toml'",
                             "UPDATE skipped SET count = 5",
                             "UPDATE laser SET max_range = 1",
                             "UPDATE scan SET data = x'00' WHERE id = 1",
                             "UPDATE scan SET laser = 99",
                             "UPDATE scan SET id = id + 1000",
                             "UPDATE relation SET from_scan = -1",
                             "UPDATE scan SET health = 77",
                             "DELETE FROM meta WHERE key = 'checksum'",
                             "DROP TABLE learnt",
                             "UPDATE learnt SET name = 'x' WHERE name = 'lag_s'",
                             "UPDATE scan SET data = NULL",
                             "UPDATE key_link SET weak_step = 1 - weak_step",
                             "DELETE FROM key_link WHERE id = 3",
                             "UPDATE key_link SET local_map = 10 WHERE id = 3",
                             "DELETE FROM edit WHERE kind = 4",
                             "UPDATE edit SET kind = 6 WHERE kind = 5",
                             "UPDATE edit SET radians = NULL",
                             "UPDATE edit SET from_scan = 40",
                             "UPDATE edit_point SET x = x + 1e-9 WHERE id = 2",
                             "UPDATE edit_point SET edit = 9999",
                             "DELETE FROM edit_point WHERE id = 0",
                             "UPDATE edit_point SET scan = -1"}) {
    write_site(path_, rich_site());
    sql(change);
    EXPECT_THAT(error(), HasSubstr("damaged")) << change;
  }
}

/// Every byte position counts: what is read is right, or it is an Error.
TEST_F(SiteFile, NeverReadsWrongDataFromDamagedBytes) {
  const Site site = rich_site();
  write_site(path_, site);
  const std::string whole = bytes();
  RandomStream random(31);
  int detected = 0;
  constexpr int kTries = 600;
  for (int i = 0; i < kTries; ++i) {
    std::string damaged = whole;
    // A third in the header and the schema, where SQLite itself is most easily misled; pages end in
    // free space.
    const std::size_t end = i % 3 ? whole.size() : 8192;
    std::size_t place = random.below(end);
    while (i % 10 && whole[place] == '\0') place = random.below(end);
    damaged[place] = static_cast<char>(damaged[place] ^ (1 << random.below(8)));
    put(damaged);
    try {
      expect_equal(read_site_to_edit(path_), site);
      if (HasFailure()) FAIL() << "wrong data from byte " << place;
    } catch (const Error& e) {
      ++detected;
    }
  }
  EXPECT_GT(detected, kTries / 2);
}

TEST_F(SiteFile, NoticesAPageOfZerosOrNoise) {
  const Site site = rich_site();
  write_site(path_, site);
  const std::string whole = bytes();
  RandomStream random(32);
  for (std::size_t begin = 0; begin < whole.size(); begin += 4096) {
    for (const bool noise : {false, true}) {
      std::string damaged = whole;
      for (std::size_t k = begin; k < std::min(begin + 4096, whole.size()); ++k) {
        damaged[k] = noise ? static_cast<char>(random.below(256)) : '\0';
      }
      put(damaged);
      try {
        expect_equal(read_site_to_edit(path_), site);
        if (HasFailure()) FAIL() << "wrong data from page at " << begin;
      } catch (const Error&) {
      }
    }
  }
}

TEST_F(SiteFile, LeavesTheOldFileWhenTheFolderIsGone) {
  EXPECT_THROW(write_site(folder_ / "none" / "site.majak", rich_site()), Error);
}

}  // namespace
}  // namespace majak::io
