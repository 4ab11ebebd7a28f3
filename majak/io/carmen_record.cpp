// SPDX-License-Identifier: Apache-2.0
#include "majak/io/carmen_record.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "majak/beacon/nmea.hpp"
#include "majak/io/number.hpp"

namespace majak::io {

namespace {

using Kind = CarmenRecord::Kind;
/// A parser returns nullptr, or what is wrong with the line.
using Problem = const char*;

constexpr std::size_t kMostBeams = 32768;
constexpr double kFarthest = 2e7;      // m: half around the Earth; no map projection counts further
constexpr float kOldMaxRange = 80.0f;  // m: what CARMEN assumes where a message does not say
constexpr Problem kCutOff = "records cut off before their time stamp; left out";
constexpr Problem kNoNumber = "records with a missing, impossible or unreadable number; left out";
constexpr Problem kBeamCount = "scans whose number of beams does not fit the line; left out";
constexpr Problem kSurplus = "records with more words than the message has; left out";
constexpr Problem kNoBeams = "scans without beams; left out";
constexpr Problem kNoAngle = "scans that begin more than a turn away from ahead; left out";
constexpr Problem kTooManyBeams = "scans with more than 32768 beams, as no laser has; left out";
constexpr Problem kNoFix = "GPS records without a fix; left out";

bool read_pose(Fields& f, Pose2& pose) {
  double theta = 0;
  const bool x = f.number(pose.x), y = f.number(pose.y), t = f.number(theta);
  if (!x || !y || !t || !std::isfinite(pose.x + pose.y + theta)) return false;
  if (std::abs(pose.x) > kFarthest || std::abs(pose.y) > kFarthest) return false;
  pose.theta = wrap_angle(theta);
  return true;
}

/// `n` ranges. A word that is no number becomes an invalid range; false when words are missing.
bool read_ranges(Fields& f, std::size_t n, CarmenRecord& record, std::vector<float>& out) {
  out.resize(n);
  for (float& range : out) {
    double value = 0;
    const bool is_number = f.number(value);
    if (is_number && value > 0 && std::isfinite(value)) {
      range = static_cast<float>(value);
    } else {
      if (!is_number || value != 0) ++record.bad_ranges;
      range = kInvalidRange;
    }
  }
  return !f.at_end();
}

bool read_intensities(Fields& f, std::size_t n, std::size_t beams, std::vector<float>& out) {
  std::vector<float> values(n);
  for (float& value : values) {
    double v = 0;
    if (!f.number(v)) return false;
    value = static_cast<float>(v);
  }
  if (n == beams) out = std::move(values);
  return true;
}

/// `ipc_timestamp ipc_hostname logger_timestamp`; the last two may be missing, and one word of junk
/// may follow. More means that the count of beams was wrong and the numbers above are others.
Problem read_trailer(Fields& f, bool cut_off, CarmenRecord& record, Time& time) {
  if (!f.time(time)) return kCutOff;
  f.word();
  Time logger = 0;
  if (f.time(logger)) {
    record.logger_time = logger;
    f.word();
  } else if (cut_off) {
    return kCutOff;  // the stamp itself may have lost digits
  }
  return f.at_end() ? nullptr : kSurplus;
}

Problem read_odometry(Fields& f, bool cut_off, CarmenRecord& record) {
  Odometry odometry;
  double speed = 0, turn_rate = 0, acceleration = 0;
  if (!read_pose(f, odometry.T_odom_robot)) return kNoNumber;
  if (!f.number(speed) || !f.number(turn_rate) || !f.number(acceleration)) return kNoNumber;
  if (std::isfinite(speed)) odometry.speed = speed;
  if (std::isfinite(turn_rate)) odometry.turn_rate = turn_rate;
  const Problem problem = read_trailer(f, cut_off, record, odometry.time);
  record.event = odometry;
  return problem;
}

Problem read_truth(Fields& f, bool cut_off, CarmenRecord& record) {
  Truth truth;
  Pose2 ignored;
  if (!read_pose(f, truth.T_world_robot) || !read_pose(f, ignored)) return kNoNumber;
  const Problem problem = read_trailer(f, cut_off, record, truth.time);
  record.event = truth;
  return problem;
}

Problem read_beam_count(Fields& f, std::size_t& n) {
  if (!f.count(n)) return kBeamCount;
  if (n > kMostBeams) return kTooManyBeams;
  return n == 0 ? kNoBeams : nullptr;
}

/// FLASER, RLASER (located) and LASER3 ... LASER5 (raw): no geometry in the message.
Problem read_old_laser(Fields& f, bool cut_off, int laser, CarmenRecord& record) {
  Scan scan;
  scan.laser = laser;
  scan.max_range = kOldMaxRange;
  std::size_t n = 0;
  if (const Problem problem = read_beam_count(f, n)) return problem;
  if (!read_ranges(f, n, record, scan.ranges)) return kBeamCount;
  if (record.laser == CarmenLaser::located) {
    Pose2 T_odom_laser, T_odom_robot;
    if (!read_pose(f, T_odom_laser) || !read_pose(f, T_odom_robot)) return kNoNumber;
    record.T_odom_laser = T_odom_laser;
    scan.T_odom_robot = T_odom_robot;
  }
  const BeamGeometry geometry = geometry_by_count(n);
  scan.start_angle = geometry.start_angle;
  scan.angle_step = geometry.angle_step;
  const Problem problem = read_trailer(f, cut_off, record, scan.time);
  record.event = std::move(scan);
  return problem;
}

/// An angle that was printed with six decimals, as it was meant: a multiple of 1/24 of a degree or
/// of 1/1024 of a turn when it is that to within the rounding.
double unround(double angle) {
  constexpr double kRounding = 6e-7;
  for (const double unit : {radians(1.0 / 24.0), 2.0 * kPi / 1024.0}) {
    const double meant = std::round(angle / unit) * unit;
    if (meant != 0 && std::abs(meant - angle) <= kRounding) return meant;
  }
  return angle;
}

/// laser_type start_angle fov angular_resolution maximum_range accuracy remission_mode
Problem read_laser_config(Fields& f, double& fov, Scan& scan) {
  double type = 0, start = 0, step = 0, max_range = 0, accuracy = 0, remission = 0;
  const bool ok = f.number(type) && f.number(start) && f.number(fov) && f.number(step) &&
                  f.number(max_range) && f.number(accuracy) && f.number(remission);
  if (!ok || !std::isfinite(start + fov + step + max_range)) return kNoNumber;
  if (std::abs(start) > 2.0 * kPi) return kNoAngle;
  scan.start_angle = unround(start);
  scan.angle_step = unround(step);
  scan.max_range = max_range > 0 ? static_cast<float>(max_range) : kOldMaxRange;
  return nullptr;
}

/// The stated step, unless it contradicts the field of view and the number of beams.
void settle_step(double fov, Scan& scan) {
  const auto beams = static_cast<double>(scan.ranges.size());
  const double spread = scan.angle_step * (beams - 1);
  const bool fits = scan.angle_step > 0 && std::abs(spread - fov) < 1.5 * scan.angle_step + 1e-4;
  if (fits || beams < 2) return;
  if (fov > 0 && fov <= 2.0 * kPi + 1e-3) {
    scan.angle_step = unround(fov / (beams - 1));
  } else if (!(scan.angle_step > 0 && spread <= 2.0 * kPi)) {
    scan.angle_step = geometry_by_count(scan.ranges.size()).angle_step;
  }
}

/// RAWLASERn (raw) and ROBOTLASERn (located).
Problem read_laser(Fields& f, bool cut_off, int laser, CarmenRecord& record) {
  Scan scan;
  scan.laser = laser;
  double fov = 0;
  std::size_t n = 0, remissions = 0;
  if (const Problem problem = read_laser_config(f, fov, scan)) return problem;
  if (const Problem problem = read_beam_count(f, n)) return problem;
  if (!read_ranges(f, n, record, scan.ranges)) return kBeamCount;
  if (!f.count(remissions)) return kBeamCount;
  if (!read_intensities(f, remissions, n, scan.intensities)) return kBeamCount;
  if (record.laser == CarmenLaser::located) {
    Pose2 T_odom_laser, T_odom_robot;
    if (!read_pose(f, T_odom_laser) || !read_pose(f, T_odom_robot)) return kNoNumber;
    record.T_odom_laser = T_odom_laser;
    scan.T_odom_robot = T_odom_robot;
    double ignored = 0;  // laser_tv laser_rv forward_safety_dist side_safety_dist turn_axis
    for (int i = 0; i < 5; ++i) {
      if (!f.number(ignored)) return kNoNumber;
    }
  }
  settle_step(fov, scan);
  record.geometry_stated = true;
  const Problem problem = read_trailer(f, cut_off, record, scan.time);
  record.event = std::move(scan);
  return problem;
}

/// ddmm.mmmm and a letter -> degrees. False when it is no angle on Earth.
bool read_degrees(Fields& f, char negative, double most, double& angle) {
  double dm = 0;
  if (!f.number(dm)) return false;
  const std::string_view side = f.word();
  const auto degrees = beacon::degrees_of_dm(dm);
  if (!degrees || *degrees > most || side.empty()) return false;
  angle = *degrees;
  if (side[0] == negative) angle = -angle;
  return true;
}

/// nr utc lat_dm N/S lon_dm E/W quality nsat hdop sea_level altitude geo_sea_level geo_sep data_age
Problem read_gga(Fields& f, bool cut_off, CarmenRecord& record) {
  double number = 0, utc = 0, quality = 0, satellites = 0, hdop = 0, sea_level = 0, altitude = 0;
  if (!f.number(number) || !f.number(utc)) return kNoNumber;
  const bool place =
      read_degrees(f, 'S', 90, record.latitude) && read_degrees(f, 'W', 180, record.longitude);
  if (!place || !f.number(quality)) return kNoNumber;
  if (quality == 0) return kNoFix;
  if (!f.number(satellites) || !f.number(hdop) || !f.number(sea_level) || !f.number(altitude))
    return kNoNumber;
  record.altitude = std::isfinite(altitude) ? altitude : 0;
  for (int i = 0; i < 3; ++i) f.word();  // geo_sea_level geo_sep data_age
  GpsFix fix;
  fix.sigma = beacon::fix_sigma(static_cast<int>(std::clamp(quality, 0.0, 9.0)), hdop);
  const Problem problem = read_trailer(f, cut_off, record, fix.time);
  record.fix = CarmenFix::gga;
  record.event = fix;
  return problem;
}

/// nr validity utc lat_dm N/S lon_dm E/W speed course variation var_dir date
Problem read_rmc(Fields& f, bool cut_off, CarmenRecord& record) {
  double number = 0, utc = 0;
  if (!f.number(number)) return kNoNumber;
  const std::string_view validity = f.word();
  if (!f.number(utc)) return kNoNumber;
  if (!read_degrees(f, 'S', 90, record.latitude) || !read_degrees(f, 'W', 180, record.longitude))
    return kNoNumber;
  if (validity != "A" && validity != "1" && validity != "65") return kNoFix;
  for (int i = 0; i < 5; ++i) f.word();  // speed course variation var_dir date
  GpsFix fix;
  const Problem problem = read_trailer(f, cut_off, record, fix.time);
  record.fix = CarmenFix::rmc;
  record.event = fix;
  return problem;
}

/// The number n of "NAMEn", or 0.
int numbered(std::string_view name, std::string_view stem) {
  if (name.size() != stem.size() + 1 || !name.starts_with(stem)) return 0;
  const char last = name.back();
  return last >= '1' && last <= '5' ? last - '0' : 0;
}

constexpr std::array<std::string_view, 19> kOfNoUse = {"SYNC",
                                                       "COMMENT",
                                                       "GLOBALPOS",
                                                       "REMISSIONFLASER",
                                                       "REMISSIONRLASER",
                                                       "REMISSIONLASER3",
                                                       "REMISSIONLASER4",
                                                       "REMISSIONLASER5",
                                                       "POSITIONLASER",
                                                       "PANTILT",
                                                       "IMU",
                                                       "SONAR",
                                                       "BUMPER",
                                                       "ARM",
                                                       "SCANMARK",
                                                       "VECTORMOVE",
                                                       "ROBOTVELOCITY",
                                                       "FOLLOWTRAJECTORY",
                                                       "BASEVELOCITY"};

Problem read_message(std::string_view name, Fields& f, bool cut_off, CarmenRecord& record) {
  record.kind = Kind::event;
  if (name == "ODOM") return read_odometry(f, cut_off, record);
  if (name == "FLASER" || name == "RLASER") {
    record.laser = CarmenLaser::located;
    return read_old_laser(f, cut_off, name == "RLASER" ? 1 : 0, record);
  }
  if (const int n = numbered(name, "ROBOTLASER"); n == 1 || n == 2) {
    record.laser = CarmenLaser::located;
    return read_laser(f, cut_off, n - 1, record);
  }
  if (const int n = numbered(name, "RAWLASER"); n > 0) {
    record.laser = CarmenLaser::raw;
    return read_laser(f, cut_off, n - 1, record);
  }
  if (const int n = numbered(name, "LASER"); n > 0) {
    record.laser = CarmenLaser::raw;
    return read_old_laser(f, cut_off, n - 1, record);
  }
  if (name == "TRUEPOS") return read_truth(f, cut_off, record);
  if (name == "NMEAGGA") return read_gga(f, cut_off, record);
  if (name == "NMEARMC") return read_rmc(f, cut_off, record);
  const bool known = std::find(kOfNoUse.begin(), kOfNoUse.end(), name) != kOfNoUse.end();
  record.kind = known ? Kind::nothing : Kind::unknown;
  return nullptr;
}

}  // namespace

BeamGeometry geometry_by_count(std::size_t beams) {
  switch (beams) {
    case 180:
    case 181:
      return {-kPi / 2, radians(1.0)};
    case 360:
    case 361:
      return {-kPi / 2, radians(0.5)};
    case 400:
    case 401:
      return {radians(-50), radians(0.25)};
    case 201:
      return {radians(-50), radians(0.5)};
    case 101:
      return {radians(-50), radians(1.0)};
    case 541:
      return {radians(-135), radians(0.5)};
    case 1081:
      return {radians(-135), radians(0.25)};
    default:
      break;
  }
  return {-kPi / 2, beams > 1 ? kPi / static_cast<double>(beams - 1) : 0.0};
}

BeamGeometry geometry_by_step(std::size_t beams, double step) {
  const std::size_t even = beams % 2 == 0 ? beams : beams - 1;
  return {-0.5 * step * static_cast<double>(even), step};
}

void parse_carmen_line(std::string_view line, bool cut_off, CarmenRecord& record) {
  record = CarmenRecord{};
  Fields f(line);
  const std::string_view name = f.word();
  if (name.empty() || name[0] == '#') return;
  if (name == "PARAM") {
    record.kind = Kind::param;
    record.name = f.word();
    record.value = f.word();
    return;
  }
  record.problem = read_message(name, f, cut_off, record);
  if (record.problem != nullptr) record.kind = Kind::damaged;
}

bool looks_like_carmen(std::string_view text) {
  while (!text.empty()) {
    const std::size_t stop = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, stop);
    text.remove_prefix(std::min(stop + 1, text.size()));
    if (line.starts_with("# CARMEN")) return true;
    Fields f(line);
    const std::string_view name = f.word();
    if (name == "PARAM" && !f.word().empty()) return true;
    const bool message = name == "ODOM" || name == "FLASER" || name == "RLASER" ||
                         name == "TRUEPOS" || name == "NMEAGGA" || name == "NMEARMC" ||
                         numbered(name, "ROBOTLASER") > 0 || numbered(name, "RAWLASER") > 0 ||
                         numbered(name, "LASER") > 0;
    double value = 0;
    if (message && f.number(value)) return true;
  }
  return false;
}

}  // namespace majak::io
