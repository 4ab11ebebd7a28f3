// SPDX-License-Identifier: Apache-2.0
// ColaSession: the host's side of an LMS1xx, LMS5xx or TiM, as a state machine over bytes and time.
// It has no socket and no clock: whoever owns these calls start() for each new connection, sends
// take_output(), hands over what comes in, and wakes it at wake_at().
//
// After each answer it asks itself what is still missing until scans flow (what_next()): which
// dialect the device speaks, who it is, the login, the measurement started, logged out, the device
// measuring, the scans asked for. Scans are the truth: what a device refuses on the way is counted
// and does not stop it, and when scans stay away everything is asked anew.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "majak/core/options.hpp"
#include "majak/core/report.hpp"
#include "majak/sensor/cola.hpp"
#include "majak/sensor/cola_identity.hpp"
#include "majak/sensor/cola_scan.hpp"

namespace majak::sensor {

struct ColaSessionOptions {
  std::optional<ColaDialect> dialect = {};  ///< nothing: both are tried
  std::uint32_t password = 0xF4724744;      ///< of an authorized client, hashed; SICK's own
  /// The telegrams' contents are set: first echo, RSSI with 16 bits, name. Not kept by the device.
  bool ask_intensities = false;
  double reply_time = 1.0;      ///< s, for an answer
  double start_time = 10.0;     ///< s, for the mirror and the laser to start
  double silence = 3.0;         ///< s without a scan, then everything is asked anew
  double reconnect_time = 5.0;  ///< s without a word on this connection, then a new one is wanted
  double patience = 60.0;       ///< s without a scan until it gives up; 0: never
};
void describe(OptionFields& fields, ColaSessionOptions& options);

struct ColaDelivery {
  ColaTelegram telegram;  ///< as it came, for recordings
  ColaScan scan;
  std::int64_t scans_missed = 0;  ///< that the device sent since the one before and we did not get
};

class ColaSession {
 public:
  enum class State { off, searching, preparing, waiting, subscribing, streaming, failed };
  struct Counts {
    std::int64_t scans = 0;
    std::int64_t missed = 0;      ///< by the gaps of the telegram counter, pauses aside
    std::int64_t doubled = 0;     ///< came twice, delivered once
    std::int64_t unreadable = 0;  ///< scan telegrams that make no sense
    std::int64_t unfetched = 0;   ///< thrown away because nobody called next()
    std::int64_t pauses = 0;      ///< times that scans stayed away
    std::int64_t logins = 0;
  };

  explicit ColaSession(const ColaSessionOptions& options = {});

  /// There is a (new) connection.
  void start(Time now);
  /// Asks the device to send no more; what comes in from now on is ignored.
  void stop();
  void receive(std::span<const std::uint8_t> bytes, Time now);
  void advance(Time now);
  /// When advance() is to be called at the latest; kNever if it is off or has failed.
  Time wake_at() const;
  static constexpr Time kNever = INT64_MAX;

  /// To be sent; empty if there is nothing.
  std::vector<std::uint8_t> take_output();
  std::optional<ColaDelivery> next();
  /// Nothing came for so long that the connection is probably dead: close it, open another one,
  /// call start().
  bool wants_connection() const { return wants_connection_; }

  State state() const { return state_; }
  /// For people: "asking for scans", "waiting until the device measures (it says: idle)".
  std::string activity() const;
  /// One line with what to do, when it has failed.
  const std::string& problem() const { return problem_; }
  std::optional<ColaDialect> dialect() const { return known_.dialect; }
  /// Nothing while it has not said who it is, and where it does not.
  const std::optional<ColaIdentity>& identity() const { return known_.identity; }
  const Counts& counts() const { return counts_; }
  /// Refusals and oddities of the session, damages of the stream.
  Report report() const;

 private:
  enum class Step {
    probe,
    identify,
    log_in,
    configure,
    start,
    log_out,
    ask_state,
    subscribe,
    none
  };
  /// What is known of the device; forgotten when everything is asked anew.
  struct Known {
    std::optional<ColaDialect> dialect;
    std::optional<ColaIdentity> identity;
    bool identified = false, logged_in = false, configured = false, started = false,
         logged_out = false, asked_again = false, measures = false, subscribed = false,
         no_stlms = false;
    std::string device_state;  ///< in its own words
  };

  Step what_next() const;
  ColaWriter command(Step step) const;
  const char* answer(Step step) const;
  Duration reply_time(Step step) const;
  void ask_next(Time now, Duration pause = 0);
  void send(Time now);
  void no_answer(Time now);
  void search(Time now);
  void give_up();
  void take(ColaTelegram telegram, Time now);
  void answered(const ColaTelegram& telegram, Time now);
  void understand(const ColaTelegram& telegram, Time now);
  void state_told(const ColaTelegram& telegram, Time now);
  void refused(unsigned code, Time now);
  void done(Step step);
  void deliver(ColaTelegram telegram, Time now);
  std::int64_t count_missed(const ColaScan& scan);
  void name_state();

  ColaSessionOptions options_;
  ColaFramer framer_;
  State state_ = State::off;
  Known known_;
  ColaDialect candidate_ = ColaDialect::b;  ///< tried next

  Step step_ = Step::none;
  bool sent_ = false;
  int tries_ = 0;
  Time send_at_ = 0, deadline_ = 0;
  Time alive_ = 0;       ///< last scan, or the first start()
  Time heard_ = 0;       ///< last telegram on this connection, or its start
  Time started_at_ = 0;  ///< the measurement was asked for
  Time scan_at_ = 0;     ///< last scan, or the subscription
  bool wants_connection_ = false;

  std::optional<ColaScan> last_;  ///< without its values
  std::deque<ColaDelivery> deliveries_;
  std::vector<std::uint8_t> output_;
  std::string problem_, trouble_;
  Counts counts_;
  Report report_;
};

/// "off", "looking for the device" ...
const char* words(ColaSession::State state);
/// What the device calls its state in the answer to STlms or SCdevicestate.
const char* cola_state_words(bool is_scdevicestate, unsigned state);

}  // namespace majak::sensor
