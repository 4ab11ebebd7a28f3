// SPDX-License-Identifier: Apache-2.0
#include "majak/io/victoria_park.hpp"

#include <cmath>
#include <utility>

#include "majak/io/number.hpp"

namespace majak::io {

namespace {

constexpr std::size_t kBeams = 361;
constexpr float kLaserLimit = 79.9f;  // m; 81.91 and its like say that nothing came back
constexpr double kLongestGap = 60.0;  // s; more than this ahead is no time of the next record
constexpr double kLongestRange = 82.0;

const char* const kBadDrive = "DRS.txt: rows with a missing or unreadable number; left out";
const char* const kBadFix = "GPS.txt: rows with a missing or unreadable number; left out";
const char* const kBadOrder = "Sensors_manager.txt: rows that name no sensor; left out";
const char* const kBadRange = "LASER.txt: values that are no positive number; marked invalid";
const char* const kLostStep = "LASER.txt: scans that do not begin with a time; left out";
const char* const kCutOff = "LASER.txt: the last scan is cut off; left out";

template <class Reader>
std::unique_ptr<Reader> reader_of(std::unique_ptr<ByteStream> bytes) {
  return bytes ? std::make_unique<Reader>(std::move(bytes)) : nullptr;
}

}  // namespace

VictoriaPark::VictoriaPark(Files files, const VictoriaParkCar& car)
    : car_(car),
      laser_(reader_of<WordReader>(std::move(files.laser))),
      gps_(reader_of<LineReader>(std::move(files.gps))),
      drive_(reader_of<LineReader>(std::move(files.drive))),
      order_(reader_of<LineReader>(std::move(files.order))) {}

/// The next row of three numbers; any other is counted.
bool VictoriaPark::read_row(Table& table, Row& row, const char* problem) {
  if (!table) return false;
  while (const auto line = table->next()) {
    Fields f(*line);
    if (f.at_end()) continue;
    const bool sound = f.number(row[0]) && f.number(row[1]) && f.number(row[2]) &&
                       std::isfinite(row[0] + row[1] + row[2]) && std::abs(row[0]) < 1e9;
    if (sound) return true;
    report_.count(problem, table->line());
  }
  return false;
}

/// Between scans stands nothing but a tab, so a lost value shifts all that follow. A time runs on
/// by less than a minute and, when looking for one, is longer than any range.
bool VictoriaPark::find_next_scan(WordReader& words, double& time) {
  const std::optional<double>& last = last_scan_time_;
  bool searching = false;
  for (;;) {
    const bool is_number = words.number(time);
    if (words.at_end()) return false;
    const bool runs_on = is_number && std::isfinite(time) && time >= 0 && time < 1e9 &&
                         (!last || (time > *last && time < *last + kLongestGap));
    if (runs_on && (!searching || time > kLongestRange)) return true;
    if (!searching) report_.count(kLostStep, scans_ + 1);
    searching = true;
  }
}

std::optional<Scan> VictoriaPark::read_scan() {
  if (!laser_) return std::nullopt;
  WordReader& words = *laser_;
  double time = 0;
  if (!find_next_scan(words, time)) return std::nullopt;
  ++scans_;
  last_scan_time_ = time;
  Scan scan;
  scan.time = from_seconds(time);
  scan.start_angle = -kPi / 2;
  scan.angle_step = radians(0.5);
  scan.max_range = kLaserLimit;
  scan.T_robot_laser = car_.T_robot_laser;
  scan.ranges.reserve(kBeams);
  for (std::size_t i = 0; i < kBeams; ++i) {
    double range = 0;
    const bool is_number = words.number(range);
    if (words.at_end()) {
      report_.count(kCutOff, scans_);
      return std::nullopt;
    }
    const bool usable = is_number && range > 0 && std::isfinite(range);
    if (!usable && !(is_number && range == 0)) report_.count(kBadRange, scans_);
    scan.ranges.push_back(!usable                ? kInvalidRange
                          : range >= kLaserLimit ? kNoReturn
                                                 : static_cast<float>(range));
  }
  return scan;
}

std::optional<WheelMotion> VictoriaPark::read_drive() {
  WheelMotion motion;
  Row row{};
  if (!read_row(drive_, row, kBadDrive)) return std::nullopt;
  motion.time = from_seconds(row[0]);
  motion.steering = row[2];
  // The encoder sits on the rear left wheel, which in a left turn drives the shorter arc.
  motion.speed = row[1] / (1.0 - std::tan(motion.steering) * car_.half_track / car_.wheelbase);
  return motion;
}

std::optional<GpsFix> VictoriaPark::read_fix() {
  Row row{};
  if (!read_row(gps_, row, kBadFix)) return std::nullopt;
  return GpsFix{.time = from_seconds(row[0]), .east = row[2], .north = row[1]};
}

void VictoriaPark::load(Sensor sensor) {
  waiting_[sensor].reset();
  if (sensor == Sensor::gps) {
    if (const auto fix = read_fix()) waiting_[sensor] = *fix;
  } else if (sensor == Sensor::drive) {
    if (const auto motion = read_drive()) waiting_[sensor] = *motion;
  } else if (auto scan = read_scan()) {
    waiting_[sensor] = std::move(*scan);
  }
}

std::optional<VictoriaPark::Sensor> VictoriaPark::earliest() const {
  std::optional<Sensor> best;
  for (const Sensor sensor : {Sensor::gps, Sensor::drive, Sensor::laser}) {
    if (!waiting_[sensor]) continue;
    if (!best || time_of(*waiting_[sensor]) < time_of(*waiting_[*best])) best = sensor;
  }
  return best;
}

/// The next row `time sensor index` that names a sensor with a record left; else by time.
std::optional<VictoriaPark::Sensor> VictoriaPark::next_in_order() {
  Row row{};
  while (read_row(order_, row, kBadOrder)) {
    const double sensor = row[1];
    if (sensor != 1 && sensor != 2 && sensor != 3) {
      report_.count(kBadOrder, order_->line());
    } else if (const auto named = static_cast<Sensor>(static_cast<int>(sensor) - 1);
               waiting_[named]) {
      return named;
    }
  }
  return earliest();
}

void VictoriaPark::finish() {
  if (finished_) return;
  finished_ = true;
  const auto take = [this](const Report& below) {
    for (const auto& [what, entry] : below.entries()) report_.add(what, entry);
  };
  if (laser_) take(laser_->report());
  for (const Table* table : {&gps_, &drive_, &order_}) {
    if (*table) take((*table)->report());
  }
}

std::optional<Event> VictoriaPark::next() {
  if (!loaded_) {
    for (const Sensor sensor : {Sensor::gps, Sensor::drive, Sensor::laser}) load(sensor);
    loaded_ = true;
  }
  const std::optional<Sensor> sensor = next_in_order();
  if (!sensor) {
    finish();
    return std::nullopt;
  }
  std::optional<Event> event = std::move(waiting_[*sensor]);
  load(*sensor);
  return event;
}

std::unique_ptr<Source> open_victoria_park(const std::filesystem::path& folder) {
  const auto open = [&](const char* name) -> std::unique_ptr<ByteStream> {
    for (const char* suffix : {"", ".gz", ".bz2"}) {
      const std::filesystem::path path = folder / (std::string(name) + suffix);
      std::error_code ignored;
      if (std::filesystem::exists(path, ignored)) return open_bytes(path).bytes;
    }
    return nullptr;
  };
  VictoriaPark::Files files;
  files.laser = open("LASER.txt");
  files.drive = open("DRS.txt");
  if (!files.laser || !files.drive) return nullptr;
  files.gps = open("GPS.txt");
  files.order = open("Sensors_manager.txt");
  return std::make_unique<VictoriaPark>(std::move(files));
}

}  // namespace majak::io
