// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "majak/io/atomic_file.hpp"
#include "majak/io/byte_codec.hpp"
#include "majak/io/site_file.hpp"
#include "majak/io/site_record.hpp"
#include "majak/io/site_tables.hpp"
#include "majak/io/sqlite.hpp"

namespace majak::io {

namespace {

constexpr const char* kSchema = R"(
PRAGMA page_size=8192;
PRAGMA journal_mode=OFF;
PRAGMA application_id=1835100779;
PRAGMA user_version=2;
CREATE TABLE meta(key TEXT PRIMARY KEY, value) WITHOUT ROWID;
CREATE TABLE laser(id INTEGER PRIMARY KEY, number INT, beams INT, start_angle REAL, angle_step REAL,
  max_range REAL, robot_x REAL, robot_y REAL, robot_theta REAL);
CREATE TABLE scan(id INTEGER PRIMARY KEY, time_ns INT, x REAL, y REAL, theta REAL, health INT,
  is_key INT, match_score REAL, laser INT, data BLOB);
CREATE TABLE relation(id INTEGER PRIMARY KEY, kind INT, from_scan INT, to_scan INT, enabled INT,
  x REAL, y REAL, theta REAL, score REAL, overlap REAL, chi2 REAL, information BLOB);
CREATE TABLE key_link(id INTEGER PRIMARY KEY, local_map INT, weak_step INT, information BLOB);
CREATE TABLE truth(id INTEGER PRIMARY KEY, time_ns INT, x REAL, y REAL, theta REAL);
CREATE TABLE learnt(name TEXT PRIMARY KEY, value REAL, sigma REAL, used INT) WITHOUT ROWID;
CREATE TABLE skipped(what TEXT PRIMARY KEY, count INT, first_line INT) WITHOUT ROWID;
)";

Laser laser_of(const Scan& scan) {
  return {scan.laser,      scan.ranges.size(), scan.start_angle,
          scan.angle_step, scan.max_range,     scan.T_robot_laser};
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

constexpr std::size_t kLasersLookedAt =
    16;  // a log whose geometry changes all the time stays linear

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
    Row(row, hash)
        .integer(std::int64_t(i))
        .integer(posed.scan.time)
        .pose(posed.estimate.T_map_robot)
        .integer(static_cast<int>(posed.estimate.health))
        .integer(posed.key)
        .real(posed.match_score)
        .integer(std::int64_t(find_or_add(lasers, laser_of(posed.scan))))
        .blob(data)
        .done();
  }
  Statement laser_row(db, "INSERT INTO laser VALUES(?,?,?,?,?,?,?,?,?)");
  for (std::size_t i = 0; i < lasers.size(); ++i) {
    const Laser& l = lasers[i];
    Row(laser_row, hash)
        .integer(std::int64_t(i))
        .integer(l.number)
        .integer(std::int64_t(l.beams))
        .real(l.start_angle)
        .real(l.angle_step)
        .real(l.max_range)
        .pose(l.T_robot_laser)
        .done();
  }
}

void write_constraints(const Database& db, const Site& site, ContentHash& hash) {
  Statement row(db, "INSERT INTO relation VALUES(?,?,?,?,?,?,?,?,?,?,?,?)");
  std::string information;
  for (std::size_t i = 0; i < site.constraints.size(); ++i) {
    const Constraint& c = site.constraints[i];
    information.clear();
    ByteWriter(information).symmetric(c.information);
    Row(row, hash)
        .integer(std::int64_t(i))
        .integer(static_cast<int>(c.kind))
        .integer(std::int64_t(c.from))
        .integer(std::int64_t(c.to))
        .integer(c.enabled)
        .pose(c.T_from_to)
        .real(c.score)
        .real(c.overlap)
        .real(c.chi2)
        .blob(information)
        .done();
  }
}

void write_truth(const Database& db, const Site& site, ContentHash& hash) {
  Statement row(db, "INSERT INTO truth VALUES(?,?,?,?,?)");
  for (std::size_t i = 0; i < site.truth.size(); ++i) {
    Row(row, hash)
        .integer(std::int64_t(i))
        .integer(site.truth[i].time)
        .pose(site.truth[i].T_world_robot)
        .done();
  }
}

void write_findings(const Database& db, const Site& site, ContentHash& hash) {
  Statement learnt_row(db, "INSERT INTO learnt VALUES(?,?,?,?)");
  for (const NamedLearnt& named : kLearnt) {
    const Learnt& learnt = site.odometry.*named.field;
    Row(learnt_row, hash)
        .text(named.name)
        .real(learnt.value)
        .real(learnt.sigma)
        .integer(learnt.used)
        .done();
  }
  Statement skipped_row(db, "INSERT INTO skipped VALUES(?,?,?)");
  for (const auto& [what, entry] : site.report.entries()) {
    Row(skipped_row, hash).text(what).integer(entry.count).integer(entry.first_line).done();
  }
}

void write_key_links(const Database& db, const Site& site, ContentHash& hash) {
  Statement row(db, "INSERT INTO key_link VALUES(?,?,?,?)");
  std::string information;
  for (std::size_t k = 0; k < site.key_links.size(); ++k) {
    const KeyLink& link = site.key_links[k];
    information.clear();
    ByteWriter(information).symmetric(link.match_information);
    Row(row, hash)
        .integer(std::int64_t(k))
        .integer(std::int64_t(link.local_map))
        .integer(link.weak_step)
        .blob(information)
        .done();
  }
}

void write_edits(const Database& db, const std::vector<Edit>& edits, ContentHash& hash) {
  Statement row(db, "INSERT INTO edit VALUES(?,?,?,?,?)");
  for (const Edit& edit : edits)
    Row(row, hash)
        .integer(edit.id)
        .integer(static_cast<int>(edit.kind))
        .real(edit.radians)
        .integer(std::int64_t(edit.from))
        .integer(std::int64_t(edit.to))
        .done();
  Statement point_row(db, "INSERT INTO edit_point VALUES(?,?,?,?,?)");
  std::int64_t number = 0;
  for (const Edit& edit : edits)
    for (const AnchoredPoint& point : edit.points)
      Row(point_row, hash)
          .integer(number++)
          .integer(edit.id)
          .integer(std::int64_t(point.scan))
          .real(point.p_robot.x())
          .real(point.p_robot.y())
          .done();
}

void write_meta(const Database& db, const Site& site, ContentHash& hash) {
  Statement statement(db, "INSERT INTO meta VALUES(?,?)");
  Row row(statement, hash);
  row.text("source_name").text(site.source_name).done();
  row.text("used_odometry").integer(site.used_odometry).done();
  row.text("reversed_records").integer(site.odometry.reversed_records).done();
  row.text("jumps").integer(site.odometry.jumps).done();
  row.text("translation_noise").real(site.odometry.translation_noise).done();
  row.text("rotation_noise").real(site.odometry.rotation_noise).done();
  row.text("options_toml").text(site.options_toml).done();
  const auto checksum = static_cast<std::int64_t>(hash.value());
  statement.bind_text("checksum").bind(checksum).run();
}

void fill(const Database& db, const Site& site) {
  db.run(kSchema);
  db.run(kEditSchema);
  db.run("BEGIN");
  ContentHash hash;
  write_scans(db, site, hash);
  write_constraints(db, site, hash);
  write_truth(db, site, hash);
  write_findings(db, site, hash);
  write_key_links(db, site, hash);
  write_edits(db, site.edits, hash);
  write_meta(db, site, hash);
  db.run("COMMIT");
}

/// The database as a file: the whole of it or nothing.
template <class Fill>
void write_database(const std::filesystem::path& path, const Fill& fill) {
  AtomicFile file(path);  // first, so that a folder that cannot be written to is told at once
  const Database db = Database::in_memory();
  try {
    fill(db);
  } catch (const Error& e) {
    throw Error(fmt::format("{}: cannot be written: {}", path.string(), e.what()));
  }
  db.serialize([&](std::string_view bytes) { file.write(bytes); });
  file.commit();
}

}  // namespace

void write_site(const std::filesystem::path& path, const Site& site) {
  if (site.edits_applied)
    throw Error(path.string() + ": a site whose edits are applied is not to be kept");
  write_database(path, [&](const Database& db) { fill(db, site); });
  std::error_code ignored;  // what stays is of another site and is not believed
  std::filesystem::remove(edits_file(path), ignored);
}

void write_edits(const std::filesystem::path& path, const Site& site) {
  const std::int64_t of_site = site_checksum(path);
  write_database(edits_file(path), [&](const Database& db) {
    db.run(
        "PRAGMA page_size=4096; PRAGMA journal_mode=OFF; PRAGMA application_id=1835100773; "
        "PRAGMA user_version=2; CREATE TABLE meta(key TEXT PRIMARY KEY, value) WITHOUT ROWID;");
    db.run(kEditSchema);
    db.run("BEGIN");
    ContentHash hash;
    write_edits(db, site.edits, hash);
    Statement statement(db, "INSERT INTO meta VALUES(?,?)");
    Row(statement, hash).text("site").integer(of_site).done();
    statement.bind_text("checksum").bind(static_cast<std::int64_t>(hash.value())).run();
    db.run("COMMIT");
  });
}

}  // namespace majak::io
