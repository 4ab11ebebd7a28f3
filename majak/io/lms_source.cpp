// SPDX-License-Identifier: Apache-2.0
#include "majak/io/lms_source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <thread>
#include <utility>

#include "majak/core/error.hpp"
#include "majak/sensor/lms_scan.hpp"

namespace majak::io {
namespace {

void limit_range(Scan& scan, float max_range) {
  scan.max_range = std::min(scan.max_range, max_range);
  for (float& range : scan.ranges)
    if (range >= scan.max_range) range = kNoReturn;
}

void sleep_for(Duration d) { std::this_thread::sleep_for(std::chrono::nanoseconds(d)); }

}  // namespace

LmsSource::LmsSource(const std::string& device, const LmsSourceOptions& options, LiveHooks hooks)
    : device_(device),
      format_(fmt::format("SICK LMS-2xx at {}", device)),
      options_(options),
      hooks_(std::move(hooks)),
      port_(device),
      driver_(options.driver, hooks_.clock()) {}

std::optional<Event> LmsSource::next() {
  while (!hooks_.stopped()) {
    while (const auto delivery = driver_.next()) {
      if (hooks_.telegram)
        hooks_.telegram(sensor::encode(delivery->telegram), delivery->first_byte);
      if (auto event = scan_of(*delivery)) {
        ++scans_;
        return event;
      }
    }
    if (port_) {
      try {
        serve();
      } catch (const Error&) {  // the cable was pulled out
        own_.count("the port was lost; it is opened again as soon as it is there");
        port_.reset();
      }
    } else {
      reopen();
    }
    tell();
  }
  return std::nullopt;
}

void LmsSource::serve() {
  if (baud_ != driver_.baud()) port_->set_baud(baud_ = driver_.baud());
  send();
  const Duration wait = std::clamp<Duration>(driver_.wake_at() - hooks_.clock(), 0, kLivePatience);
  std::array<std::uint8_t, 4096> buffer;
  const auto ready = port_->wait_readable(wait);
  if (ready != Descriptor::Ready::no) {
    const std::size_t n = port_->read(buffer);  // throws where it is gone
    driver_.receive({buffer.data(), n}, hooks_.clock());
  }
  driver_.advance(hooks_.clock());
}

void LmsSource::send() {
  const auto bytes = driver_.take_output();
  if (bytes.empty()) return;
  const Duration pause = driver_.byte_pause();
  if (pause == 0) return port_->write(bytes);
  for (const std::uint8_t byte : bytes) {
    port_->write({&byte, 1});
    sleep_for(pause);
  }
}

void LmsSource::reopen() {
  const Time now = hooks_.clock();
  if (now < next_try_) return sleep_for(std::min(next_try_ - now, kLivePatience));
  next_try_ = now + kReopenEvery;
  try {
    port_.emplace(device_);
  } catch (const Error&) {
    return;  // not there yet
  }
  baud_ = 0;
  driver_.reopened(now);
}

void LmsSource::tell() {
  if (!hooks_.status) return;
  hooks_.status(
      {port_ ? driver_.activity() : fmt::format("waiting for {}", device_), scans_, skipped_});
}

std::optional<Event> LmsSource::scan_of(const sensor::LmsDelivery& delivery) {
  const sensor::LmsDevice& device = driver_.device();
  skipped_ += delivery.skipped;
  note(delivery.scan.health());
  const auto configuration = device.configuration.value_or(sensor::LmsConfiguration::factory());
  sensor::Variant variant = device.variant;
  std::optional<sensor::LmsScan> whole = delivery.scan;
  if (options_.merge_turns) {
    whole = merger_.add(delivery.scan, variant, delivery.stamp);
    variant = sensor::merged_variant(variant);
  }
  if (!whole) return std::nullopt;
  try {
    Scan scan = sensor::to_scan(*whole, configuration, variant, delivery.stamp);
    if (options_.max_range > 0) limit_range(scan, static_cast<float>(options_.max_range));
    return scan;
  } catch (const Error& e) {
    own_.count(fmt::format("scans left out: {}", e.what()));
    return std::nullopt;
  }
}

void LmsSource::note(const sensor::LmsHealth& health) {
  if (health.pollution) own_.count("scans with which the device said: the front window is dirty");
  if (health.implausible) own_.count("scans with which the device said: values are implausible");
  if (health.severity >= sensor::LmsHealth::Severity::error)
    own_.count("scans with which the device said: it has a fault");
}

const Report& LmsSource::report() const {
  all_ = own_;
  for (const auto& [what, entry] : driver_.report().entries()) all_.add(what, entry);
  if (skipped_ > 0) all_.add("scans for which the line had no room", {skipped_, 0});
  if (merger_.incomplete() > 0)
    all_.add("scans of which a turn was lost; left out", {merger_.incomplete(), 0});
  const auto& counts = driver_.framer();
  if (counts.crc_errors > 0)
    all_.add("telegrams that arrived damaged; left out", {counts.crc_errors, 0});
  return all_;
}

}  // namespace majak::io
