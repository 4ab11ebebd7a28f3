// SPDX-License-Identifier: Apache-2.0
#include "majak/io/site_record.hpp"

#include "majak/io/byte_codec.hpp"

namespace majak::io {

namespace {

enum ScanField : std::uint8_t {
  kHasEstimateTime = 1,  ///< the estimate's time is not the scan's
  kHasWeakDirection = 2,
  kHasOdometry = 4,
  kHasLoggedOdometry = 8,
  kHasIntensities = 16,
};

std::uint8_t fields_of(const PosedScan& posed) {
  int fields = 0;
  if (posed.estimate.time != posed.scan.time) fields |= kHasEstimateTime;
  if (posed.estimate.weak_direction != Vec2::Zero()) fields |= kHasWeakDirection;
  if (posed.T_odom_robot) fields |= kHasOdometry;
  if (posed.scan.T_odom_robot) fields |= kHasLoggedOdometry;
  if (!posed.scan.intensities.empty()) fields |= kHasIntensities;
  return static_cast<std::uint8_t>(fields);
}

}  // namespace

void pack_scan(const PosedScan& posed, std::string& out) {
  ByteWriter writer(out);
  const std::uint8_t fields = fields_of(posed);
  writer.u8(fields);
  writer.pose(posed.T_map_robot_front_end);
  writer.symmetric(posed.estimate.covariance);
  if (fields & kHasEstimateTime) writer.u64(static_cast<std::uint64_t>(posed.estimate.time));
  if (fields & kHasWeakDirection) {
    writer.f64(posed.estimate.weak_direction.x());
    writer.f64(posed.estimate.weak_direction.y());
  }
  if (fields & kHasOdometry) writer.pose(*posed.T_odom_robot);
  if (fields & kHasLoggedOdometry) writer.pose(*posed.scan.T_odom_robot);
  write_ranges(writer, posed.scan.ranges);
  if (fields & kHasIntensities) write_ranges(writer, posed.scan.intensities);
}

void unpack_scan(std::string_view bytes, PosedScan& posed) {
  ByteReader reader(bytes);
  const std::uint8_t fields = reader.u8();
  posed.T_map_robot_front_end = reader.pose();
  posed.estimate.covariance = reader.symmetric();
  posed.estimate.time =
      fields & kHasEstimateTime ? static_cast<Time>(reader.u64()) : posed.scan.time;
  if (fields & kHasWeakDirection) {
    const double x = reader.f64();
    posed.estimate.weak_direction = {x, reader.f64()};
  }
  if (fields & kHasOdometry) posed.T_odom_robot = reader.pose();
  if (fields & kHasLoggedOdometry) posed.scan.T_odom_robot = reader.pose();
  posed.scan.ranges = read_ranges(reader);
  if (fields & kHasIntensities) posed.scan.intensities = read_ranges(reader);
  reader.expect_end();
}

}  // namespace majak::io
