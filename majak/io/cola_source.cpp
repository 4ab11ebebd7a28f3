// SPDX-License-Identifier: Apache-2.0
#include "majak/io/cola_source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <thread>
#include <utility>

#include "majak/core/error.hpp"

namespace majak::io {

ColaSource::ColaSource(const TcpAddress& address, const ColaSourceOptions& options, LiveHooks hooks)
    : address_(address),
      format_(fmt::format("SICK laser (CoLa) at {}:{}", address.host, address.port)),
      options_(options),
      hooks_(std::move(hooks)),
      connection_(TcpClient(address.host, address.port)),
      session_(options.session) {
  session_.start(hooks_.clock());
}

std::optional<Event> ColaSource::next() {
  while (!hooks_.stopped()) {
    while (const auto delivery = session_.next()) {
      if (hooks_.telegram) {
        const auto& payload = delivery->telegram.payload;
        hooks_.telegram({reinterpret_cast<const std::uint8_t*>(payload.data()), payload.size()},
                        delivery->scan.time);
      }
      if (auto event = scan_of(*delivery)) {
        ++scans_;
        return event;
      }
    }
    if (session_.state() == sensor::ColaSession::State::failed)
      throw Error(fmt::format("{}:{}: {}", address_.host, address_.port, session_.problem()));
    if (connection_) {
      try {
        serve();
      } catch (const Error&) {  // the device was switched off, or its cable pulled out
        own_.count("the connection was lost; it is made again as soon as the device is there");
        connection_.reset();
      }
    } else {
      reopen();
    }
    tell();
  }
  return std::nullopt;
}

void ColaSource::serve() {
  if (const auto bytes = session_.take_output(); !bytes.empty()) connection_->write(bytes);
  const Time now = hooks_.clock();
  const Duration wait = std::clamp<Duration>(
      std::min(session_.wake_at(), now + kLivePatience) - now, 0, kLivePatience);
  std::array<std::uint8_t, 8192> buffer;
  if (connection_->wait_readable(wait) != Descriptor::Ready::no) {
    const std::size_t n = connection_->read(buffer);  // throws where it is gone
    session_.receive({buffer.data(), n}, hooks_.clock());
  }
  session_.advance(hooks_.clock());
  if (session_.wants_connection()) connection_.reset();
}

void ColaSource::reopen() {
  const Time now = hooks_.clock();
  session_.advance(now);
  if (now < next_try_) {
    std::this_thread::sleep_for(std::chrono::nanoseconds(std::min(next_try_ - now, kLivePatience)));
    return;
  }
  next_try_ = now + kReopenEvery;
  try {
    connection_ = TcpClient(address_.host, address_.port, kReopenEvery);
  } catch (const Error&) {
    return;  // not there yet
  }
  session_.start(hooks_.clock());
}

void ColaSource::tell() {
  if (!hooks_.status) return;
  hooks_.status({connection_ ? session_.activity() : fmt::format("waiting for {}", address_.host),
                 scans_, skipped_});
}

std::optional<Event> ColaSource::scan_of(const sensor::ColaDelivery& delivery) {
  skipped_ += delivery.scans_missed;
  sensor::ColaScanOptions options = options_.scan;
  if (const auto& who = session_.identity(); who && options.max_range == 0)
    options.max_range = sensor::cola_reach(who->name).value_or(0);
  try {
    return sensor::to_scan(delivery.scan, options);
  } catch (const Error& e) {
    own_.count(fmt::format("scans left out: {}", e.what()));
    return std::nullopt;
  }
}

const Report& ColaSource::report() const {
  all_ = own_;
  const Report said = session_.report();  // by value: it must outlive the loop
  for (const auto& [what, entry] : said.entries()) all_.add(what, entry);
  if (skipped_ > 0) all_.add("scans that the device sent and that did not arrive", {skipped_, 0});
  return all_;
}

}  // namespace majak::io
