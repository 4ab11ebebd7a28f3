// SPDX-License-Identifier: Apache-2.0
// LmsDriver: the host's side of a SICK LMS-2xx, as a state machine over bytes and time. It has no
// port and no clock: whoever owns these sets the port to baud(), sends take_output(), hands over
// what comes in, and wakes it at wake_at().
//
// It never follows a script. After each answer it asks itself what is still missing until scans
// flow (what_next()), so that a device which restarts, forgets its settings or is swapped for
// another one needs no case of its own: what is known of it is forgotten, and the same question is
// asked again.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "majak/core/report.hpp"
#include "majak/core/time.hpp"
#include "majak/sensor/lms291.hpp"
#include "majak/sensor/lms_scan.hpp"
#include "majak/sensor/lms_telegrams.hpp"
#include "majak/sensor/scan_clock.hpp"
#include "majak/sensor/telegram_framer.hpp"

namespace majak::sensor {

/// What the device is to be set to. Nothing: it stays as it is.
struct LmsDriverOptions {
  /// Bd, to stream at. Nothing: 38400 where the device was found slower, which every cable does.
  std::optional<int> baud;
  std::optional<Variant> variant;
  bool interlaced = false;  ///< every turn of the mirror by itself
  // These live in the EEPROM, which wears out: written only where they differ.
  std::optional<Unit> unit;
  std::optional<int> measuring_mode;      ///< of the telegram listing, 0 ... 6
  std::optional<bool> real_time_indices;  ///< the device counts turns and telegrams for us
  std::string password{kFactoryPassword};
};

/// What is known of the device; it is asked again after every restart.
struct LmsDevice {
  std::optional<LmsIdentity> identity;
  std::optional<LmsStatus> status;
  std::optional<LmsConfiguration> configuration;
  std::uint8_t address = 0;  ///< of the first whole telegram; 0: none yet
  Variant variant{180, 50};  ///< in force
};

/// A telegram with measured values.
struct LmsDelivery {
  LmsScan scan;
  Telegram telegram;    ///< that it came in
  Time first_byte = 0;  ///< as seen
  Time stamp = 0;       ///< the same without what held it up (ScanClock)
  /// Scans that the device measured since the one before, for which the line had no room; negative
  /// where too many had been counted.
  std::int64_t skipped = 0;
};

class LmsDriver {
 public:
  enum class State { searching, asking, streaming };

  LmsDriver(const LmsDriverOptions& options, Time now);

  int baud() const { return baud_; }
  /// To be sent as soon as the port is at baud(); empty if there is nothing.
  std::vector<std::uint8_t> take_output();
  /// To be left between two bytes: at 500 kBd the device needs 55 us.
  Duration byte_pause() const { return baud_ > 100000 ? 60'000 : 0; }

  void receive(std::span<const std::uint8_t> bytes, Time now);
  void advance(Time now);
  Time wake_at() const;
  /// The port was closed and opened anew: another device may be at its end.
  void reopened(Time now);

  std::optional<LmsDelivery> next();

  State state() const { return state_; }
  /// For people: "looking for the device at 38400 baud", "asking what it is" ...
  std::string activity() const;
  const LmsDevice& device() const { return device_; }
  /// Restarts, losses, refusals; the framer's counts are in framer().
  const Report& report() const { return report_; }
  const TelegramFramer::Counts& framer() const { return framer_.counts(); }

 private:
  struct Request {
    Telegram command;
    Reply reply;
    Duration patience;  ///< for the whole reply
    int tries;
  };

  Request what_next() const;
  std::optional<LmsConfiguration> wanted_configuration() const;
  int wanted_baud() const;
  void ask_next(Time now, Duration pause = 0);
  void send(Time now);
  void again(Time now, Duration pause);
  void give_up(Time now);
  void take_frames(Time now);
  void take(const Frame& frame, Time now);
  void understand(const Telegram& reply, Time now);
  void refused(Time now);
  void deliver(const Frame& frame, Time now);
  void search(Time now);
  void try_baud(int baud, Time now);
  void forget();
  void restarted(Time now);
  void found(const Telegram& telegram);
  Duration silence() const;

  LmsDriverOptions options_;
  TelegramFramer framer_{TelegramFramer::Direction::device_to_host};
  State state_ = State::searching;
  LmsDevice device_;
  // What was asked, or cannot be had, since the device was found.
  bool stopped_ = false, asked_identity_ = false, asked_status_ = false,
       asked_configuration_ = false, installed_ = false, baud_refused_ = false,
       variant_refused_ = false, configuration_refused_ = false;

  std::optional<Request> request_;
  bool sent_ = false, acknowledged_ = false, heard_ = false;
  int tries_ = 0;
  Time send_at_ = 0, deadline_ = 0, last_scan_ = 0;
  std::vector<std::uint8_t> output_;

  int baud_ = 38400, good_baud_ = 38400;
  std::size_t candidate_ = 0;  ///< of the bauds looked through

  ScanClock clock_{{.period = 1}};
  Duration period_ = 0;  ///< between scans of the stream; 0 before the first stream
  std::deque<LmsDelivery> deliveries_;
  Report report_;
};

}  // namespace majak::sensor
