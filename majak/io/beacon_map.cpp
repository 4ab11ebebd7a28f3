// SPDX-License-Identifier: Apache-2.0
#include "majak/io/beacon_map.hpp"

#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <utility>

#include "majak/core/error.hpp"
#include "majak/io/byte_stream.hpp"
#include "majak/io/line_reader.hpp"
#include "majak/io/number.hpp"

namespace majak::io {
namespace {

constexpr double kSamePlace = 1e-3;  // m
constexpr double kLargestNumber = 1e9;
constexpr double kFarthest = 2e7;  // m
constexpr std::size_t kMostBeacons = 10'000;

beacon::Beacon read_line(std::string_view line, const std::string& where) {
  Fields fields(line);
  double number = 0;
  beacon::Beacon b;
  if (!fields.number(number) || !fields.number(b.p_map.x()) || !fields.number(b.p_map.y()))
    throw Error(where + "a beacon is `number x y [name]`, metres");
  if (!(number >= 0 && number <= kLargestNumber) || number != std::floor(number))
    throw Error(where + "a beacon's number is a whole number, 0 ... 1000000000");
  if (!(b.p_map.norm() < kFarthest)) throw Error(where + "a beacon's place is too far off");
  b.number = static_cast<int>(number);
  b.name = fields.word();
  if (!fields.at_end()) throw Error(where + "more than `number x y [name]`; a name is one word");
  return b;
}

void check_new(const beacon::BeaconMap& map, const beacon::Beacon& b, const std::string& where) {
  for (const beacon::Beacon& other : map.beacons) {
    if (other.number == b.number)
      throw Error(fmt::format("{}number {} is there twice", where, b.number));
    if ((other.p_map - b.p_map).norm() < kSamePlace)
      throw Error(
          fmt::format("{}beacon {} stands where beacon {} does", where, b.number, other.number));
  }
}

beacon::BeaconMap read_lines(std::unique_ptr<ByteStream> bytes, const std::string& name) {
  LineReader lines(std::move(bytes));
  beacon::BeaconMap map;
  while (const auto line = lines.next()) {
    const std::string text(line->substr(0, line->find('#')));
    if (Fields(text).at_end()) continue;
    const std::string where = fmt::format("{}:{}: ", name, lines.line());
    if (map.beacons.size() == kMostBeacons) throw Error(where + "more than 10000 beacons");
    beacon::Beacon b = read_line(text, where);
    check_new(map, b, where);
    map.beacons.push_back(std::move(b));
  }
  // A map with a hole is another map.
  const Report damage = lines.report();
  if (!damage.empty()) throw Error(name + ": " + damage.entries().begin()->first);
  if (map.beacons.empty()) throw Error(name + ": no beacon; a line is `number x y [name]`");
  return map;
}

}  // namespace

beacon::BeaconMap parse_beacon_map(std::string_view text, const std::string& name) {
  return read_lines(open_bytes_in_memory(std::string(text)).bytes, name);
}

beacon::BeaconMap read_beacon_map(const std::filesystem::path& path) {
  return read_lines(open_bytes(path).bytes, path.string());
}

}  // namespace majak::io
