// SPDX-License-Identifier: Apache-2.0
#include "majak/io/site_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <vector>

#include "majak/io/atomic_file.hpp"
#include "majak/io/byte_codec.hpp"
#include "majak/io/site_record.hpp"
#include "majak/io/sqlite.hpp"

namespace majak::io {

namespace {

constexpr std::int64_t kApplication = 0x6d616a6b;  // "majk"
constexpr std::int64_t kVersion = 1;

constexpr const char* kSchema = R"(
PRAGMA page_size=8192;
PRAGMA journal_mode=OFF;
PRAGMA application_id=1835100779;
PRAGMA user_version=1;
CREATE TABLE meta(key TEXT PRIMARY KEY, value) WITHOUT ROWID;
CREATE TABLE laser(id INTEGER PRIMARY KEY, number INT, beams INT, start_angle REAL, angle_step REAL,
  max_range REAL, robot_x REAL, robot_y REAL, robot_theta REAL);
CREATE TABLE scan(id INTEGER PRIMARY KEY, time_ns INT, x REAL, y REAL, theta REAL, health INT, is_key INT,
  match_score REAL, laser INT, data BLOB);
CREATE TABLE relation(id INTEGER PRIMARY KEY, kind INT, from_scan INT, to_scan INT, enabled INT, x REAL, y REAL,
  theta REAL, score REAL, overlap REAL, chi2 REAL, information BLOB);
CREATE TABLE truth(id INTEGER PRIMARY KEY, time_ns INT, x REAL, y REAL, theta REAL);
CREATE TABLE learnt(name TEXT PRIMARY KEY, value REAL, sigma REAL, used INT) WITHOUT ROWID;
CREATE TABLE skipped(what TEXT PRIMARY KEY, count INT, first_line INT) WITHOUT ROWID;
)";

struct NamedLearnt {
  const char* name;
  Learnt OdometryFindings::*field;
};
constexpr std::array<NamedLearnt, 6> kLearnt = {{{"lag_s", &OdometryFindings::lag_s},
                                                 {"laser_theta_rad", &OdometryFindings::laser_theta_rad},
                                                 {"laser_x_m", &OdometryFindings::laser_x_m},
                                                 {"laser_y_m", &OdometryFindings::laser_y_m},
                                                 {"rotation_scale", &OdometryFindings::rotation_scale},
                                                 {"translation_scale", &OdometryFindings::translation_scale}}};

/// What most scans of a log share.
struct Laser {
  int number;
  std::size_t beams;
  double start_angle, angle_step;
  float max_range;
  Pose2 T_robot_laser;
  bool operator==(const Laser&) const = default;
};

Laser laser_of(const Scan& scan) {
  return {scan.laser, scan.ranges.size(), scan.start_angle, scan.angle_step, scan.max_range, scan.T_robot_laser};
}

/// A row on its way into a table and into the hash.
class Row {
 public:
  Row(Statement& statement, ContentHash& hash) : statement_(statement), hash_(hash) {}
  Row& integer(std::int64_t value) {
    statement_.bind(value);
    hash_.add(static_cast<std::uint64_t>(value));
    return *this;
  }
  Row& real(double value) {
    statement_.bind(value);
    hash_.add(value);
    return *this;
  }
  Row& pose(const Pose2& p) { return real(p.x).real(p.y).real(p.theta); }
  Row& text(std::string_view value) {
    statement_.bind_text(value);
    hash_.add(value);
    return *this;
  }
  Row& blob(std::string_view value) {
    statement_.bind_blob(value);
    hash_.add(value);
    return *this;
  }
  void done() { statement_.run(); }

 private:
  Statement& statement_;
  ContentHash& hash_;
};

/// The same of a row on its way out.
class Columns {
 public:
  Columns(Statement& statement, ContentHash& hash) : statement_(statement), hash_(hash) {}
  std::int64_t integer() {
    const std::int64_t value = statement_.integer();
    hash_.add(static_cast<std::uint64_t>(value));
    return value;
  }
  double real() {
    const double value = statement_.real();
    hash_.add(value);
    return value;
  }
  Pose2 pose() {
    Pose2 p;
    p.x = real();
    p.y = real();
    p.theta = real();
    return p;
  }
  std::string_view bytes() {
    const std::string_view value = statement_.bytes();
    hash_.add(value);
    return value;
  }
  bool flag() { return integer() != 0; }

 private:
  Statement& statement_;
  ContentHash& hash_;
};

constexpr std::size_t kLasersLookedAt = 16;  // a log whose geometry changes all the time stays linear

/// The number of the scan's laser, a new one if need be.
std::size_t find_or_add(std::vector<Laser>& lasers, const Laser& wanted) {
  for (std::size_t back = 1; back <= std::min(kLasersLookedAt, lasers.size()); ++back) {
    if (lasers[lasers.size() - back] == wanted) return lasers.size() - back;
  }
  lasers.push_back(wanted);
  return lasers.size() - 1;
}

void write_scans(const Database& db, const Site& site, ContentHash& hash) {
  Statement row(db, "INSERT INTO scan VALUES(?,?,?,?,?,?,?,?,?,?)");
  std::vector<Laser> lasers;
  std::string data;
  for (std::size_t i = 0; i < site.scans.size(); ++i) {
    const PosedScan& posed = site.scans[i];
    data.clear();
    pack_scan(posed, data);
    Row(row, hash).integer(std::int64_t(i)).integer(posed.scan.time).pose(posed.estimate.T_map_robot)
        .integer(static_cast<int>(posed.estimate.health)).integer(posed.key).real(posed.match_score)
        .integer(std::int64_t(find_or_add(lasers, laser_of(posed.scan)))).blob(data).done();
  }
  Statement laser_row(db, "INSERT INTO laser VALUES(?,?,?,?,?,?,?,?,?)");
  for (std::size_t i = 0; i < lasers.size(); ++i) {
    const Laser& l = lasers[i];
    Row(laser_row, hash).integer(std::int64_t(i)).integer(l.number).integer(std::int64_t(l.beams))
        .real(l.start_angle).real(l.angle_step).real(l.max_range).pose(l.T_robot_laser).done();
  }
}

void write_constraints(const Database& db, const Site& site, ContentHash& hash) {
  Statement row(db, "INSERT INTO relation VALUES(?,?,?,?,?,?,?,?,?,?,?,?)");
  std::string information;
  for (std::size_t i = 0; i < site.constraints.size(); ++i) {
    const Constraint& c = site.constraints[i];
    information.clear();
    ByteWriter(information).symmetric(c.information);
    Row(row, hash).integer(std::int64_t(i)).integer(static_cast<int>(c.kind)).integer(std::int64_t(c.from))
        .integer(std::int64_t(c.to)).integer(c.enabled).pose(c.T_from_to).real(c.score).real(c.overlap)
        .real(c.chi2).blob(information).done();
  }
}

void write_truth(const Database& db, const Site& site, ContentHash& hash) {
  Statement row(db, "INSERT INTO truth VALUES(?,?,?,?,?)");
  for (std::size_t i = 0; i < site.truth.size(); ++i) {
    Row(row, hash).integer(std::int64_t(i)).integer(site.truth[i].time).pose(site.truth[i].T_world_robot).done();
  }
}

void write_findings(const Database& db, const Site& site, ContentHash& hash) {
  Statement learnt_row(db, "INSERT INTO learnt VALUES(?,?,?,?)");
  for (const NamedLearnt& named : kLearnt) {
    const Learnt& learnt = site.odometry.*named.field;
    Row(learnt_row, hash).text(named.name).real(learnt.value).real(learnt.sigma).integer(learnt.used).done();
  }
  Statement skipped_row(db, "INSERT INTO skipped VALUES(?,?,?)");
  for (const auto& [what, entry] : site.report.entries()) {
    Row(skipped_row, hash).text(what).integer(entry.count).integer(entry.first_line).done();
  }
}

void write_meta(const Database& db, const Site& site, ContentHash& hash) {
  Statement statement(db, "INSERT INTO meta VALUES(?,?)");
  Row row(statement, hash);
  row.text("source_name").text(site.source_name).done();
  row.text("used_odometry").integer(site.used_odometry).done();
  row.text("reversed_records").integer(site.odometry.reversed_records).done();
  row.text("translation_noise").real(site.odometry.translation_noise).done();
  row.text("rotation_noise").real(site.odometry.rotation_noise).done();
  row.text("options_toml").text(site.options_toml).done();
  const auto checksum = static_cast<std::int64_t>(hash.value());
  statement.bind_text("checksum").bind(checksum).run();
}

void fill(const Database& db, const Site& site) {
  db.run(kSchema);
  db.run("BEGIN");
  ContentHash hash;
  write_scans(db, site, hash);
  write_constraints(db, site, hash);
  write_truth(db, site, hash);
  write_findings(db, site, hash);
  write_meta(db, site, hash);
  db.run("COMMIT");
}

/// A value that must lie in [0, end).
std::int64_t below(std::int64_t value, std::size_t end, const char* what) {
  if (value < 0 || static_cast<std::uint64_t>(value) >= end) throw Error(fmt::format("{} does not exist", what));
  return value;
}

/// Numbers run from 0 without gaps; so a damaged tree that goes round in circles ends at once.
void expect_number(std::int64_t number, std::size_t rows_before) {
  if (number < 0 || static_cast<std::uint64_t>(number) != rows_before) throw Error("rows are missing or doubled");
}

std::vector<Laser> read_lasers(const Database& db, ContentHash& hash) {
  std::vector<Laser> lasers;
  Statement rows(db, "SELECT * FROM laser ORDER BY id");
  while (rows.step()) {
    Columns c(rows, hash);
    expect_number(c.integer(), lasers.size());
    Laser laser{};
    laser.number = static_cast<int>(c.integer());
    laser.beams = static_cast<std::size_t>(c.integer());
    laser.start_angle = c.real();
    laser.angle_step = c.real();
    laser.max_range = static_cast<float>(c.real());
    laser.T_robot_laser = c.pose();
    lasers.push_back(laser);
  }
  return lasers;
}

void set_laser(Scan& scan, const Laser& laser) {
  if (scan.ranges.size() != laser.beams) throw Error("a scan has another number of beams than its laser");
  scan.laser = laser.number;
  scan.start_angle = laser.start_angle;
  scan.angle_step = laser.angle_step;
  scan.max_range = laser.max_range;
  scan.T_robot_laser = laser.T_robot_laser;
}

void read_scans(const Database& db, Site& site, ContentHash& hash) {
  ContentHash unused;  // the lasers come after the scans in the checksum, and before them here
  const std::vector<Laser> lasers = read_lasers(db, unused);
  Statement rows(db, "SELECT * FROM scan ORDER BY id");
  while (rows.step()) {
    Columns c(rows, hash);
    PosedScan& posed = site.scans.emplace_back();
    expect_number(c.integer(), site.scans.size() - 1);
    posed.scan.time = c.integer();
    posed.estimate.T_map_robot = c.pose();
    posed.estimate.health = static_cast<Health>(below(c.integer(), 3, "a scan's health"));
    posed.key = c.flag();
    posed.match_score = static_cast<float>(c.real());
    const std::int64_t laser = below(c.integer(), lasers.size(), "a scan's laser");
    unpack_scan(c.bytes(), posed);
    set_laser(posed.scan, lasers[static_cast<std::size_t>(laser)]);
  }
  read_lasers(db, hash);
}

void read_constraints(const Database& db, Site& site, ContentHash& hash) {
  Statement rows(db, "SELECT * FROM relation ORDER BY id");
  while (rows.step()) {
    Columns c(rows, hash);
    Constraint& constraint = site.constraints.emplace_back();
    expect_number(c.integer(), site.constraints.size() - 1);
    constraint.kind = static_cast<ConstraintKind>(below(c.integer(), 3, "a relation's kind"));
    constraint.from = static_cast<std::size_t>(below(c.integer(), site.scans.size(), "a relation's scan"));
    constraint.to = static_cast<std::size_t>(below(c.integer(), site.scans.size(), "a relation's scan"));
    constraint.enabled = c.flag();
    constraint.T_from_to = c.pose();
    constraint.score = c.real();
    constraint.overlap = c.real();
    constraint.chi2 = c.real();
    ByteReader information(c.bytes());
    constraint.information = information.symmetric();
    information.expect_end();
  }
}

void read_truth(const Database& db, Site& site, ContentHash& hash) {
  Statement rows(db, "SELECT * FROM truth ORDER BY id");
  while (rows.step()) {
    Columns c(rows, hash);
    expect_number(c.integer(), site.truth.size());
    const Time time = c.integer();
    site.truth.push_back({time, c.pose()});
  }
}

void read_findings(const Database& db, Site& site, ContentHash& hash) {
  Statement learnt_rows(db, "SELECT * FROM learnt ORDER BY name");
  for (std::size_t rows = 0; learnt_rows.step(); ++rows) {
    if (rows == kLearnt.size()) throw Error("rows are missing or doubled");
    Columns c(learnt_rows, hash);
    const std::string name(c.bytes());
    const auto named = std::find_if(kLearnt.begin(), kLearnt.end(), [&](const auto& n) { return name == n.name; });
    if (named == kLearnt.end()) throw Error("an unknown value was learnt");
    Learnt& learnt = site.odometry.*named->field;
    learnt.value = c.real();
    learnt.sigma = c.real();
    learnt.used = c.flag();
  }
  Statement skipped_rows(db, "SELECT * FROM skipped ORDER BY what");
  while (skipped_rows.step()) {
    Columns c(skipped_rows, hash);
    const std::string what(c.bytes());
    if (site.report.entries().contains(what)) throw Error("rows are missing or doubled");
    const std::int64_t count = c.integer();
    site.report.add(what, {count, c.integer()});
  }
}

void read_meta(const Database& db, Site& site, ContentHash& hash) {
  Statement row(db, "SELECT key, value FROM meta WHERE key = ?");
  const auto find = [&](const char* key) {
    row.rewind();
    row.bind_text(key);
    if (!row.step()) throw Error(fmt::format("{} is missing", key));
    Columns columns(row, hash);
    columns.bytes();
    return columns;
  };
  site.source_name = find("source_name").bytes();
  site.used_odometry = find("used_odometry").flag();
  site.odometry.reversed_records = find("reversed_records").integer();
  site.odometry.translation_noise = find("translation_noise").real();
  site.odometry.rotation_noise = find("rotation_noise").real();
  site.options_toml = find("options_toml").bytes();
  const std::uint64_t content = hash.value();
  if (static_cast<std::uint64_t>(find("checksum").integer()) != content) throw Error("its checksum does not fit");
}

std::int64_t pragma(const Database& db, const char* sql) {
  Statement row(db, sql);
  return row.step() ? row.integer() : 0;
}

void check_kind(const std::filesystem::path& path) {
  constexpr std::string_view kMagic("SQLite format 3\0", 16);
  std::ifstream in(path, std::ios::binary);
  if (!in) throw Error(fmt::format("{}: cannot be read: {}", path.string(), std::strerror(errno)));
  std::array<char, 16> head{};
  in.read(head.data(), head.size());
  if (std::string_view(head.data(), head.size()) != kMagic) {
    throw Error(path.string() + ": not a majak site; give the site.majak of a result folder");
  }
}

void check_version(const Database& db) {
  if (pragma(db, "PRAGMA application_id") != kApplication) {
    throw Error("an SQLite file of another program, not a majak site");
  }
  const std::int64_t version = pragma(db, "PRAGMA user_version");
  if (version > kVersion) {
    throw Error(fmt::format("written by a newer majak (format {}, this one reads up to {}); update majak", version,
                            kVersion));
  }
  if (version < 1) throw Error("damaged: it has no version; make it again with majak map");
}

}  // namespace

void write_site(const std::filesystem::path& path, const Site& site) {
  AtomicFile file(path);  // first, so that a folder that cannot be written to is told at once
  const Database db = Database::in_memory();
  try {
    fill(db, site);
  } catch (const Error& e) {
    throw Error(fmt::format("{}: cannot be written: {}", path.string(), e.what()));
  }
  db.serialize([&](std::string_view bytes) { file.write(bytes); });
  file.commit();
}

Site read_site(const std::filesystem::path& path) {
  check_kind(path);
  std::optional<Database> db;
  try {
    db.emplace(Database::read_only(path.string()));
    check_version(*db);
  } catch (const Error& e) {
    throw Error(fmt::format("{}: {}", path.string(), e.what()));
  }
  try {
    Site site;
    ContentHash hash;
    read_scans(*db, site, hash);
    read_constraints(*db, site, hash);
    read_truth(*db, site, hash);
    read_findings(*db, site, hash);
    read_meta(*db, site, hash);
    return site;
  } catch (const Error& e) {
    throw Error(fmt::format("{}: damaged ({}); make it again with majak map", path.string(), e.what()));
  }
}

}  // namespace majak::io
