// SPDX-License-Identifier: Apache-2.0
// ColaSource: an LMS1xx, LMS5xx or TiM at the network as a Source of scans.
#pragma once

#include <optional>
#include <string>

#include "majak/io/live_hooks.hpp"
#include "majak/io/source.hpp"
#include "majak/io/tcp.hpp"
#include "majak/sensor/cola_session.hpp"

namespace majak::io {

struct ColaSourceOptions {
  sensor::ColaSessionOptions session;
  sensor::ColaScanOptions scan;  ///< max_range 0: the reach of the device that it says to be
};

class ColaSource : public Source {
 public:
  /// Throws Error when nobody listens there now; what happens later is waited out.
  ColaSource(const TcpAddress& address, const ColaSourceOptions& options, LiveHooks hooks);

  /// Throws Error where the session gives up, with what to do.
  std::optional<Event> next() override;
  const Report& report() const override;
  const std::string& format() const override { return format_; }

 private:
  void serve();
  void reopen();
  void tell();
  std::optional<Event> scan_of(const sensor::ColaDelivery& delivery);

  TcpAddress address_;
  std::string format_;
  ColaSourceOptions options_;
  LiveHooks hooks_;
  std::optional<TcpConnection> connection_;
  sensor::ColaSession session_;
  Time next_try_ = 0;
  std::int64_t scans_ = 0, skipped_ = 0;
  Report own_;
  mutable Report all_;
};

}  // namespace majak::io
