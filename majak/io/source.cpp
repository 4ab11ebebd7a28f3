// SPDX-License-Identifier: Apache-2.0
#include "majak/io/source.hpp"

#include <string>
#include <system_error>
#include <utility>

#include "majak/core/error.hpp"
#include "majak/io/byte_stream.hpp"
#include "majak/io/carmen_reader.hpp"
#include "majak/io/gps_beside.hpp"
#include "majak/io/nmea_log.hpp"
#include "majak/io/player_log.hpp"
#include "majak/io/ros_source.hpp"
#include "majak/io/victoria_park.hpp"

namespace majak::io {

Source::~Source() = default;

void check_angle_step(const SourceOptions& options) {
  if (options.angle_step == 0) return;
  if (!(options.angle_step > 0 && options.angle_step <= 30))
    throw Error("--angle-step is a number of degrees between beams, more than 0, 30 at most");
}

namespace {

constexpr std::size_t kHead = std::size_t{1} << 16;  // bytes in which a log must show what it is

std::string read_head(ByteStream& bytes) {
  std::string head(kHead, '\0');
  std::size_t have = 0;
  while (have < head.size()) {
    const std::size_t n = bytes.read(head.data() + have, head.size() - have);
    if (n == 0) break;
    have += n;
  }
  head.resize(have);
  return head;
}

[[noreturn]] void refuse(const std::string& name, const std::string& head,
                         const Report& unpacking) {
  if (!unpacking.empty())
    throw Error(name + ": no log could be unpacked; the file is damaged or cut off");
  if (head.empty()) throw Error(name + ": the file is empty");
  throw Error(
      name +
      ": no log that majak knows; looked for a ROS bag, an MCAP file, a Player log, NMEA sentences "
      "and the "
      "messages "
      "of a CARMEN log (FLASER, ROBOTLASER1, RAWLASER1, ODOM, PARAM ...), plain, gzip or bzip2");
}

/// For the formats in which a laser has no topic and a step that is known.
void expect_no_options(const std::filesystem::path& path, const SourceOptions& options) {
  if (!options.topic.empty()) throw Error(path.string() + ": --topic is for ROS recordings");
  if (options.angle_step != 0)
    throw Error(path.string() + ": --angle-step is for ROS recordings and Player logs");
  if (options.T_robot_laser)
    throw Error(path.string() + ": --mounting is for ROS recordings and Player logs");
}

std::unique_ptr<Source> open_folder(const std::filesystem::path& path,
                                    const SourceOptions& options) {
  std::error_code error;
  std::filesystem::directory_iterator readable(path, error);
  if (error) throw Error(path.string() + ": the folder cannot be read: " + error.message());
  if (auto source = open_ros(path, {}, options)) return source;
  expect_no_options(path, options);
  if (auto source = open_victoria_park(path)) return source;
  throw Error(
      path.string() +
      ": a folder without a log; looked for the metadata.yaml of a ROS 2 bag and for the Victoria "
      "Park files LASER.txt (or LASER.txt.gz) and DRS.txt, GPS.txt, Sensors_manager.txt");
}

std::unique_ptr<Source> open_one(const std::filesystem::path& path, const SourceOptions& options) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) return open_folder(path, options);
  auto [bytes, packing] = open_bytes(path);
  std::string head = read_head(*bytes);
  if (auto source = open_ros(path, head, options)) return source;
  if (!looks_like_carmen(head)) {
    if (looks_like_nmea(head)) {
      expect_no_options(path, options);
      return std::make_unique<NmeaLog>(prepend(std::move(head), std::move(bytes)),
                                       std::string("NMEA log") + packing_suffix(packing));
    }
    if (!looks_like_player(head)) refuse(path.string(), head, bytes->report());
    return std::make_unique<PlayerLog>(prepend(std::move(head), std::move(bytes)),
                                       std::string("Player log") + packing_suffix(packing),
                                       options);
  }
  expect_no_options(path, options);
  return std::make_unique<CarmenReader>(prepend(std::move(head), std::move(bytes)),
                                        std::string("CARMEN log") + packing_suffix(packing));
}

}  // namespace

std::unique_ptr<Source> open_log(const std::filesystem::path& path, const SourceOptions& options) {
  auto log = open_one(path, options);
  if (options.gps.empty()) return log;
  return std::make_unique<GpsBeside>(std::move(log), open_one(options.gps, {}));
}

}  // namespace majak::io
