// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include "majak/io/byte_codec.hpp"
#include "majak/io/site_file.hpp"
#include "majak/io/site_record.hpp"
#include "majak/io/site_tables.hpp"
#include "majak/io/sqlite.hpp"
#include "majak/map/edits.hpp"

namespace majak::io {

namespace {

/// A row on its way out of a table and into the hash.
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

/// A value that must lie in [0, end).
std::int64_t below(std::int64_t value, std::size_t end, const char* what) {
  if (value < 0 || static_cast<std::uint64_t>(value) >= end)
    throw Error(fmt::format("{} does not exist", what));
  return value;
}

/// Numbers run from 0 without gaps; so a damaged tree that goes round in circles ends at once.
void expect_number(std::int64_t number, std::size_t rows_before) {
  if (number < 0 || static_cast<std::uint64_t>(number) != rows_before)
    throw Error("rows are missing or doubled");
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
  if (scan.ranges.size() != laser.beams)
    throw Error("a scan has another number of beams than its laser");
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
    constraint.from =
        static_cast<std::size_t>(below(c.integer(), site.scans.size(), "a relation's scan"));
    constraint.to =
        static_cast<std::size_t>(below(c.integer(), site.scans.size(), "a relation's scan"));
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
    const auto named =
        std::find_if(kLearnt.begin(), kLearnt.end(), [&](const auto& n) { return name == n.name; });
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

void read_key_links(const Database& db, Site& site, ContentHash& hash) {
  Statement rows(db, "SELECT * FROM key_link ORDER BY id");
  while (rows.step()) {
    Columns c(rows, hash);
    KeyLink& link = site.key_links.emplace_back();
    expect_number(c.integer(), site.key_links.size() - 1);
    link.local_map =
        static_cast<std::size_t>(below(c.integer(), site.key_links.size(), "a local map"));
    link.weak_step = c.flag();
    ByteReader information(c.bytes());
    link.match_information = information.symmetric();
    information.expect_end();
  }
}

/// The scan of an edit; those without one state 0.
std::size_t scan_of(std::int64_t value, const Site& site) {
  return static_cast<std::size_t>(
      below(value, std::max<std::size_t>(site.scans.size(), 1), "an edit's scan"));
}

double finite(double value) {
  if (!std::isfinite(value)) throw Error("an edit holds what is no number");
  return value;
}

std::vector<Edit> read_edits(const Database& db, const Site& site, ContentHash& hash) {
  std::vector<Edit> edits;
  Statement rows(db, "SELECT * FROM edit ORDER BY id");
  while (rows.step()) {
    Columns c(rows, hash);
    Edit edit;
    edit.id = c.integer();
    if (!edits.empty() && edit.id <= edits.back().id) throw Error("rows are missing or doubled");
    edit.kind = static_cast<EditKind>(below(c.integer(), kEditKinds, "an edit's kind"));
    edit.radians = finite(c.real());
    edit.from = scan_of(c.integer(), site);
    edit.to = scan_of(c.integer(), site);
    edits.push_back(edit);
  }
  Statement point_rows(db, "SELECT * FROM edit_point ORDER BY id");
  auto edit = edits.begin();
  for (std::size_t number = 0; point_rows.step(); ++number) {
    Columns c(point_rows, hash);
    expect_number(c.integer(), number);
    const std::int64_t id = c.integer();
    while (edit != edits.end() && edit->id < id) ++edit;
    if (edit == edits.end() || edit->id != id || site.scans.empty())
      throw Error("a point's edit does not exist");
    AnchoredPoint& point = edit->points.emplace_back();
    point.scan = scan_of(c.integer(), site);
    point.p_robot.x() = finite(c.real());
    point.p_robot.y() = finite(c.real());
  }
  return edits;
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
  site.odometry.jumps = find("jumps").integer();
  site.odometry.translation_noise = find("translation_noise").real();
  site.odometry.rotation_noise = find("rotation_noise").real();
  site.options_toml = find("options_toml").bytes();
  const std::uint64_t content = hash.value();
  if (static_cast<std::uint64_t>(find("checksum").integer()) != content)
    throw Error("its checksum does not fit");
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

std::int64_t check_version(const Database& db, std::int64_t application) {
  if (pragma(db, "PRAGMA application_id") != application) {
    throw Error("an SQLite file of another program, not a majak site");
  }
  const std::int64_t version = pragma(db, "PRAGMA user_version");
  if (version > kSiteVersion) {
    throw Error(
        fmt::format("written by a newer majak (format {}, this one reads up to {}); update majak",
                    version, kSiteVersion));
  }
  if (version < 1) throw Error("damaged: it has no version; make it again with majak map");
  return version;
}

/// use(database, its version); errors name the file and what to do.
template <class Use>
void read_database(const std::filesystem::path& path, std::int64_t application,
                   const char* what_to_do, const Use& use) {
  check_kind(path);
  std::optional<Database> db;
  std::int64_t version = 0;
  try {
    db.emplace(Database::read_only(path.string()));
    version = check_version(*db, application);
  } catch (const Error& e) {
    throw Error(fmt::format("{}: {}", path.string(), e.what()));
  }
  try {
    use(*db, version);
  } catch (const Error& e) {
    throw Error(fmt::format("{}: damaged ({}); {}", path.string(), e.what(), what_to_do));
  }
}

std::int64_t checksum_in(const Database& db) {
  Statement row(db, "SELECT value FROM meta WHERE key = 'checksum'");
  if (!row.step()) throw Error("checksum is missing");
  return row.integer();
}

/// The edits beside the site file, if they are of that one.
void read_newer_edits(const std::filesystem::path& path, std::int64_t of_site, Site& site) {
  const std::filesystem::path beside = edits_file(path);
  std::error_code ignored;
  if (!std::filesystem::exists(beside, ignored)) return;
  read_database(beside, kEditsApplication, "without it the edits are those of the last whole run",
                [&](const Database& db, std::int64_t) {
                  Statement row(db, "SELECT value FROM meta WHERE key = 'site'");
                  if (!row.step()) throw Error("its site is missing");
                  if (row.integer() != of_site) return;
                  ContentHash hash;
                  std::vector<Edit> edits = read_edits(db, site, hash);
                  hash.add(std::string_view("site"));
                  hash.add(static_cast<std::uint64_t>(of_site));
                  if (static_cast<std::uint64_t>(checksum_in(db)) != hash.value())
                    throw Error("its checksum does not fit");
                  site.edits = std::move(edits);
                });
}

constexpr const char* kMakeAgain = "make it again with majak map";

}  // namespace

std::filesystem::path edits_file(const std::filesystem::path& site_file) {
  std::filesystem::path beside = site_file;
  beside += ".edits";
  return beside;
}

std::int64_t site_checksum(const std::filesystem::path& path) {
  std::int64_t checksum = 0;
  read_database(path, kSiteApplication, kMakeAgain,
                [&](const Database& db, std::int64_t) { checksum = checksum_in(db); });
  return checksum;
}

Site read_site_to_edit(const std::filesystem::path& path) {
  Site site;
  std::int64_t checksum = 0;
  read_database(path, kSiteApplication, kMakeAgain, [&](const Database& db, std::int64_t version) {
    ContentHash hash;
    read_scans(db, site, hash);
    read_constraints(db, site, hash);
    read_truth(db, site, hash);
    read_findings(db, site, hash);
    if (version > 1) {
      read_key_links(db, site, hash);
      site.edits = read_edits(db, site, hash);
    }
    read_meta(db, site, hash);
    checksum = checksum_in(db);
  });
  read_newer_edits(path, checksum, site);
  return site;
}

Site read_site(const std::filesystem::path& path) {
  return map::with_edits(read_site_to_edit(path));
}

}  // namespace majak::io
