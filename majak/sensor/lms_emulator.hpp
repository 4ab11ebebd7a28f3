// SPDX-License-Identifier: Apache-2.0
// LmsEmulator: a SICK LMS-2xx made of bytes and times, for drivers - ours and other people's - to
// be tried on. It boots, listens, refuses, changes its baud, turns its mirror, sends what the line
// has room for, and fails on demand. The same seed and the same calls give the same bytes.
//
// Not there: the modes and telegrams for the nearest value in a segment (20 20 ... 20 23), for
// fields (40 ... 42, 46) and cartesian values (76): they are refused (92).
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "majak/core/options.hpp"
#include "majak/core/random.hpp"
#include "majak/core/time.hpp"
#include "majak/sensor/lms291.hpp"
#include "majak/sensor/lms_configuration.hpp"
#include "majak/sensor/lms_scan.hpp"
#include "majak/sensor/lms_telegrams.hpp"
#include "majak/sensor/lms_uart.hpp"
#include "majak/sensor/telegram_framer.hpp"

namespace majak::sensor {

/// What goes wrong. Rates are shares of all bytes, telegrams or scans; times count in seconds from
/// the start of the emulator, and never if negative.
struct LmsFaults {
  double drop = 0;           ///< bytes
  double duplicate = 0;      ///< bytes
  double flip = 0;           ///< bytes, one bit
  double truncate = 0;       ///< telegrams of scans, cut off somewhere
  double noise = 0;          ///< telegrams of scans with noise before them, false headers in it
  double handshakes = 0;     ///< telegrams of scans with bytes 06 and 15 before them
  double wrong_length = 0;   ///< telegrams of scans that say to be longer than they are
  double odd_count = 0;      ///< telegrams of scans with a right CRC and a value too few
  double dazzle = 0;         ///< scans with a dazzled part
  int swallow_every = 0;     ///< every k-th command is not heard
  int nak_first = 0;         ///< so many commands are answered by NAK
  bool pollution = false;    ///< status: the front window is dirty
  bool implausible = false;  ///< status: values cannot be trusted
  bool fatal = false;        ///< status: out of order
  double reset_at = -1;      ///< s, a restart as after a dip in the supply
  double hang_at = -1;       ///< s, neither hears nor speaks
  double hang_for = 5;       ///< s
  double unplug_at = -1;     ///< s, the cable is pulled out
  double unplug_for = 2;     ///< s
};
void describe(OptionFields& fields, LmsFaults& faults);

struct LmsEmulatorOptions {
  std::string identity = "LMS291;S05;V02.19    ";  ///< what 3A and the boot tell
  LmsStatus status;                                ///< what 31 tells and nothing here knows better
  LmsConfiguration configuration = LmsConfiguration::factory();  ///< EEPROM; 34 or 32 bytes
  std::vector<LmsErrorEntry> errors;
  LmsCounters counters{1234, 56};
  std::string password{kFactoryPassword};
  std::uint8_t address = 0;            ///< 0 ... 7F; answers to it and to 0, with it + 80
  Variant variant{180, 50};            ///< at power-on
  int baud = 9600;                     ///< at the start
  bool permanent_baud = false;         ///< the baud of the moment stays over a restart
  bool booted = false;                 ///< at the start, otherwise it begins to boot
  Mode mode = Mode::on_request;        ///< at the start, if booted; streams without parameters
  Duration boot = 2 * kSecond;         ///< real ones take up to 60 s
  Duration mirror_turn = 13'320'000;   ///< ns, as real ones say (148 us for 1/90 turn)
  int bytes_per_turn = 508;            ///< that the device sends at most
  Duration ack_delay = 3'000'000;      ///< ns, up to 60 ms is allowed
  Duration reply_delay = 5'000'000;    ///< ns, after the ACK
  Duration mode_delay = 40'000'000;    ///< ns, the same when the mode or the variant changes
  Duration write_delay = 100'000'000;  ///< ns, the same when the EEPROM is written; up to 7 s
  Duration gap = 50'000'000;           ///< ns of silence that end a command; real ones have 6 ms
  std::uint64_t seed = 1;
};

/// A fresh LMS-291 (type S05, centimetres), and an LMS-200 in millimetres as one was recorded.
LmsEmulatorOptions lms291_s05();
LmsEmulatorOptions lms200_recorded();

class LmsEmulator {
 public:
  /// True ranges in metres, one a beam of the variant: beam i is fired at first_beam +
  /// beam_time(variant, i). Infinite: no echo; not a number: too weak. A variant of 180 degrees and
  /// quarter degrees is asked for, too: single turns of the mirror have 180 degrees always.
  using Source = std::function<std::vector<double>(Time first_beam, const Variant&)>;

  struct Counts {
    std::int64_t commands = 0;  ///< heard, with a right CRC and address
    std::int64_t naks = 0;
    std::int64_t refused = 0;   ///< answered by 92
    std::int64_t cut_off = 0;   ///< scans that a command interrupted
    std::int64_t scans = 0;     ///< begun to be sent
    std::int64_t writes = 0;    ///< of the EEPROM
    std::int64_t restarts = 0;  ///< commanded or suffered
  };

  LmsEmulator(const LmsEmulatorOptions& options, Source source, Time start);

  void set_faults(const LmsFaults& faults);

  /// Bytes from the host, whose port is set to this baud. Another baud than the device's own
  /// gives it garbage to hear.
  void receive(std::span<const std::uint8_t> bytes, int host_baud, Time now);

  /// Everything that happens until now.
  void advance(Time now);

  /// advance(), and the bytes that have left since the last call; garbage for a host with another
  /// baud. Nothing while the cable is out.
  std::vector<Chunk> transmit(Time now, int host_baud);

  /// When the next byte will have left or something else happens.
  Time next_event() const;

  /// The supply fails for a moment.
  void reset(Time now);
  bool unplugged(Time now) const;

  bool ready() const { return power_ == Power::ready; }
  int baud() const { return baud_; }
  Mode mode() const { return mode_; }
  const Variant& variant() const { return variant_; }
  /// The EEPROM, to be kept by whoever wants it to outlast the emulator.
  const LmsConfiguration& configuration() const { return options_.configuration; }
  bool permanent_baud() const { return options_.permanent_baud; }
  const Counts& counts() const { return counts_; }

 private:
  enum class Power { booting, ready };
  /// Scans asked for: one, or a stream of them.
  struct Wish {
    Reply code = Reply::scan;
    bool one_turn = false;  ///< of the mirror
    bool stream = false;    ///< again and again; means do not overlap
    ScanRequest request;
    std::int64_t turn = 0;  ///< not before this one has ended
  };

  // Time (lms_emulator.cpp).
  Time turn_begin(std::int64_t turn) const { return start_ + turn * options_.mirror_turn; }
  bool hung(Time now) const;
  Time next_change() const;
  void change(Time now);
  void finish(const LmsUart::Done& done);
  void begin_boot(Time now);
  void end_boot(Time now);
  void end_turn(Time now);

  // Commands (lms_emulator_commands.cpp).
  void hear(Time now);
  void obey(const Telegram& command, Time now);
  void handshake(std::uint8_t byte, Time now);
  void answer(const Telegram& reply, Duration delay, LmsUart::After after = LmsUart::After::nothing,
              int baud = 0);
  void refuse();
  void change_mode(const Telegram& command);
  void set_variant(const Telegram& command);
  void write_configuration(const Telegram& command);
  void one_scan(const Telegram& command);
  bool start_stream(const Telegram& command);
  Sender sender() const;
  LmsStatus status() const;

  // Scans (lms_emulator_scans.cpp).
  bool begins_with(const Wish& wish, std::int64_t turn) const;
  void send_scan(const Wish& wish, Time now);
  LmsScan measure(const Wish& wish, Time now);
  std::vector<double> ranges(const Wish& wish, Time now) const;
  void dazzle(LmsScan& scan);
  std::vector<std::uint8_t> damage(LmsScan scan);
  std::vector<std::uint8_t> noise();

  LmsEmulatorOptions options_;
  Source source_;
  Time start_;
  LmsFaults faults_;
  RandomStream random_;
  TelegramFramer ear_;
  LmsUart mouth_;
  Counts counts_;

  Power power_ = Power::booting;
  Time boot_end_ = 0;
  Time answered_ = 0;  ///< when the ACK of the command in hand leaves
  int baud_ = 9600;
  Mode mode_ = Mode::on_request;
  Variant variant_;
  std::vector<std::uint8_t> configuration_2_;
  std::optional<Wish> stream_, once_;
  bool streaming_ = false;       ///< what is leaving now is a scan of the stream
  std::int64_t turn_ = 0;        ///< of the mirror, the one that goes on
  std::int64_t ready_turn_ = 0;  ///< first whole one since the boot
  std::uint8_t telegrams_ = 0;
  std::int64_t commands_ = 0;
  int naks_left_ = 0;
  bool reset_done_ = false, hang_done_ = false;
};

}  // namespace majak::sensor
