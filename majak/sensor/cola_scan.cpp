// SPDX-License-Identifier: Apache-2.0
#include "majak/sensor/cola_scan.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "majak/core/error.hpp"

namespace majak::sensor {
namespace {

constexpr std::size_t kNameLength = 5;

ColaChannel read_channel(ColaCursor& in, int bytes) {
  ColaChannel channel;
  channel.name = in.label(kNameLength, "a channel's name");
  channel.scale = in.f32("a channel's scale");
  channel.offset = in.f32("a channel's offset");
  channel.start_angle = in.i32("a channel's start angle");
  channel.angle_step = in.u16("a channel's angular step");
  const std::size_t count = in.u16("a channel's number of values");
  const auto width = static_cast<std::size_t>(bytes);
  channel.raw.reserve(std::min(count, in.fields_at_most(width)));
  while (channel.raw.size() < count) {
    if (in.fields_at_most(width) == 0)
      in.fail("ends after " + std::to_string(channel.raw.size()) + " of " + std::to_string(count) +
              " values of " + channel.name + "; the telegram was cut short");
    channel.raw.push_back(bytes == 1 ? in.u8("a value") : in.u16("a value"));
  }
  return channel;
}

std::vector<ColaChannel> read_channels(ColaCursor& in, int bytes) {
  std::vector<ColaChannel> channels;
  const std::size_t count =
      in.u16(bytes == 1 ? "the number of 8-bit channels" : "the number of 16-bit channels");
  while (channels.size() < count) channels.push_back(read_channel(in, bytes));
  return channels;
}

void write_channels(ColaWriter& out, const std::vector<ColaChannel>& channels, int bytes) {
  out.u16(static_cast<std::uint16_t>(channels.size()));
  for (const ColaChannel& channel : channels) {
    out.label(channel.name).f32(channel.scale).f32(channel.offset);
    out.i32(channel.start_angle).u16(channel.angle_step);
    out.u16(static_cast<std::uint16_t>(channel.raw.size()));
    for (const std::uint16_t raw : channel.raw) {
      if (bytes == 1) {
        out.u8(static_cast<std::uint8_t>(raw));
      } else {
        out.u16(raw);
      }
    }
  }
}

void read_head(ColaCursor& in, ColaScan& scan) {
  scan.version = in.u16("the version");
  scan.device = in.u16("the device's number");
  scan.serial = in.u32("the serial number");
  for (std::uint8_t& s : scan.status) s = in.u8("the status");
  scan.telegram_counter = in.u16("the telegram counter");
  scan.scan_counter = in.u16("the scan counter");
  scan.first_shot = in.u32("the time of the first shot");
  scan.transmission = in.u32("the time of transmission");
  for (std::uint8_t& s : scan.inputs) s = in.u8("the inputs");
  for (std::uint8_t& s : scan.outputs) s = in.u8("the outputs");
  scan.layer = in.u16("the layer");
  scan.mirror_rate = in.u32("the mirror's rate");
  scan.measuring_rate = in.u32("the measuring rate");
  const std::size_t encoders = in.u16("the number of encoders");
  for (std::size_t i = 0; i < encoders; ++i) {
    ColaEncoder& encoder = scan.encoders.emplace_back();
    encoder.position = in.u32("an encoder's position");
    encoder.speed = in.u16("an encoder's speed");
  }
}

void write_head(ColaWriter& out, const ColaScan& scan) {
  out.u16(scan.version).u16(scan.device).u32(scan.serial);
  for (const std::uint8_t s : scan.status) out.u8(s);
  out.u16(scan.telegram_counter).u16(scan.scan_counter);
  out.u32(scan.first_shot).u32(scan.transmission);
  for (const std::uint8_t s : scan.inputs) out.u8(s);
  for (const std::uint8_t s : scan.outputs) out.u8(s);
  out.u16(scan.layer).u32(scan.mirror_rate).u32(scan.measuring_rate);
  out.u16(static_cast<std::uint16_t>(scan.encoders.size()));
  for (const ColaEncoder& encoder : scan.encoders) out.u32(encoder.position).u16(encoder.speed);
}

void read_tail(ColaCursor& in, ColaScan& scan) {
  if (in.u16("the position's flag") != 0) {
    ColaPosition& p = scan.position.emplace();
    for (float& v : p.place) v = in.f32("the position");
    for (float& v : p.rotation) v = in.f32("the rotation");
    p.rotation_type = in.u8("the kind of rotation");
    p.sends_name = in.u8("the position's last field");
  }
  if (in.u16("the name's flag") != 0) scan.name = in.text("the device's name");
  if (in.u16("the comment's flag") != 0) scan.comment = in.text("the comment");
  if (in.u16("the date's flag") != 0) {
    ColaDate& d = scan.date.emplace();
    d.year = in.u16("the date");
    for (std::uint8_t* v : {&d.month, &d.day, &d.hour, &d.minute, &d.second})
      *v = in.u8("the date");
    d.microsecond = in.u32("the date");
  }
  in.u16("the event's flag");
}

void write_tail(ColaWriter& out, const ColaScan& scan) {
  out.u16(scan.position ? 1 : 0);
  if (scan.position) {
    for (const float v : scan.position->place) out.f32(v);
    for (const float v : scan.position->rotation) out.f32(v);
    out.u8(scan.position->rotation_type).u8(scan.position->sends_name);
  }
  out.u16(scan.name ? 1 : 0);
  if (scan.name) out.text(*scan.name);
  out.u16(scan.comment ? 1 : 0);
  if (scan.comment) out.text(*scan.comment);
  out.u16(scan.date ? 1 : 0);
  if (scan.date) {
    const ColaDate& d = *scan.date;
    out.u16(d.year).u8(d.month).u8(d.day).u8(d.hour).u8(d.minute).u8(d.second).u32(d.microsecond);
  }
  out.u16(0);  // no event
}

float range_of(std::uint16_t raw, const ColaChannel& channel, float max_range) {
  if (raw == 0) return kNoReturn;
  if (raw < kFirstColaDistance) return kInvalidRange;
  const double mm = static_cast<double>(raw) * double{channel.scale} + double{channel.offset};
  const auto range = static_cast<float>(mm * 1e-3);
  if (!(range > 0)) return kInvalidRange;
  return range < max_range ? range : kNoReturn;
}

bool same_beams(const ColaChannel& a, const ColaChannel& b) {
  return a.raw.size() == b.raw.size() && a.start_angle == b.start_angle &&
         a.angle_step == b.angle_step;
}

const ColaChannel& distances(const ColaScan& scan, int echo) {
  const std::string name = "DIST" + std::to_string(echo);
  const ColaChannel* channel = scan.channel(name);
  if (channel == nullptr)
    throw Error("LMDscandata: holds no channel " + name +
                "; choose another echo, or have the device send this one");
  if (!std::isfinite(channel->offset) || !std::isfinite(channel->scale) || channel->scale <= 0)
    throw Error("LMDscandata: the scale of " + name + " is no positive number");
  return *channel;
}

}  // namespace

const ColaChannel* ColaScan::channel(std::string_view wanted) const {
  for (const auto* list : {&channels16, &channels8}) {
    for (const ColaChannel& c : *list) {
      if (c.name == wanted) return &c;
    }
  }
  return nullptr;
}

ColaScan decode_scan(const ColaTelegram& telegram) {
  ColaScan scan;
  scan.time = telegram.time;
  scan.asked = telegram.is("sRA LMDscandata");
  ColaCursor in(telegram);
  if (!scan.asked && !telegram.is("sSN LMDscandata"))
    throw Error("a CoLa telegram '" + std::string(telegram.kind()) + " " +
                std::string(telegram.name()) + "' holds no scan; LMDscandata does");
  read_head(in, scan);
  scan.channels16 = read_channels(in, 2);
  scan.channels8 = read_channels(in, 1);
  read_tail(in, scan);
  return scan;
}

std::string encode_scan(const ColaScan& scan, ColaDialect dialect) {
  ColaWriter out(dialect, scan.asked ? "sRA LMDscandata" : "sSN LMDscandata");
  write_head(out, scan);
  write_channels(out, scan.channels16, 2);
  write_channels(out, scan.channels8, 1);
  write_tail(out, scan);
  return out.payload();
}

const char* cola_status_words(const std::array<std::uint8_t, 2>& status) {
  const int code = status[0] * 256 + status[1];
  if (code == 0) return "all is well";
  if (code == 1) return "device error";
  if (code == 2) return "pollution warning";
  if (code == 5) return "pollution error";
  return "a status that has no name";
}

void describe(OptionFields& fields, ColaScanOptions& o) {
  fields.add("cola.max_range", o.max_range,
             {"m", "the device's reach; 0: the longest range a telegram can state", 0, 1000});
  fields.add("cola.ahead", o.ahead, {"rad", "the device's angle that looks ahead", -7, 7});
  fields.add("cola.echo", o.echo, {"1", "which echo of LMS5xx", 1, 5});
}

Scan to_scan(const ColaScan& scan, const ColaScanOptions& options) {
  const ColaChannel& distance = distances(scan, options.echo);
  Scan out;
  const Duration sweep = cola_beam_time(scan, distance.raw.size());
  out.time = scan.time - cola_delay(scan).value_or(sweep);
  out.start_angle = radians(distance.start_angle * 1e-4) - options.ahead;
  out.angle_step = radians(exact_cola_step(distance.angle_step) * 1e-4);
  const double longest = (65535.0 * double{distance.scale} + double{distance.offset}) * 1e-3;
  out.max_range =
      static_cast<float>(options.max_range > 0 ? std::min(options.max_range, longest) : longest);
  out.ranges.reserve(distance.raw.size());
  for (const std::uint16_t raw : distance.raw)
    out.ranges.push_back(range_of(raw, distance, out.max_range));
  const ColaChannel* strength = scan.channel("RSSI" + std::to_string(options.echo));
  if (strength != nullptr && same_beams(*strength, distance)) {
    out.intensities.reserve(strength->raw.size());
    for (const std::uint16_t raw : strength->raw)
      out.intensities.push_back(static_cast<float>(raw) * strength->scale + strength->offset);
  }
  return out;
}

double exact_cola_step(std::uint16_t angle_step) {
  constexpr double kUnit = 1e4 / 24;  // every step that the devices know is a multiple of 1/24 deg
  const double exact = std::round(angle_step / kUnit) * kUnit;
  return std::abs(exact - angle_step) <= 0.5 ? exact : angle_step;
}

std::optional<Duration> cola_delay(const ColaScan& scan) {
  // Unsigned, so that the difference is right across the clock's wrap-around.
  const std::uint32_t microseconds = scan.transmission - scan.first_shot;
  const Duration delay = Duration{microseconds} * 1000;
  if (delay > kLongestColaDelay) return {};
  return delay;
}

Duration cola_beam_time(const ColaScan& scan, std::size_t beam) {
  const ColaChannel* channel = !scan.channels16.empty() ? &scan.channels16.front() : nullptr;
  if (channel == nullptr || scan.mirror_rate == 0) return 0;
  const double turn = 100.0 / scan.mirror_rate;  // s
  const double share = exact_cola_step(channel->angle_step) * static_cast<double>(beam) / 3.6e6;
  return from_seconds(turn * share);
}

}  // namespace majak::sensor
