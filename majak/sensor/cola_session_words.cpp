// SPDX-License-Identifier: Apache-2.0
// The session's vocabulary: what it says to the device, and to people.
#include <algorithm>
#include <iterator>

#include "majak/sensor/cola_session.hpp"

namespace majak::sensor {

void describe(OptionFields& fields, ColaSessionOptions& o) {
  fields.add("cola.ask_intensities", o.ask_intensities,
             {"", "the device is told to send the strength of each echo"});
  fields.add("cola.reply_time", o.reply_time, {"s", "for an answer", 0.05, 60});
  fields.add("cola.start_time", o.start_time, {"s", "for the device to start measuring", 0.1, 600});
  fields.add("cola.silence", o.silence, {"s", "without a scan, then all is asked anew", 0.1, 600});
  fields.add("cola.reconnect_time", o.reconnect_time,
             {"s", "without a word, then a new connection is opened", 0.5, 600});
  fields.add("cola.patience", o.patience, {"s", "without a scan until it gives up", 0, 1e6});
}

const char* words(ColaSession::State state) {
  switch (state) {
    case ColaSession::State::off:
      return "off";
    case ColaSession::State::searching:
      return "looking for the device";
    case ColaSession::State::preparing:
      return "starting the measurement";
    case ColaSession::State::waiting:
      return "waiting until the device measures";
    case ColaSession::State::subscribing:
      return "asking for scans";
    case ColaSession::State::streaming:
      return "receiving scans";
    case ColaSession::State::failed:
      return "given up";
  }
  return "";
}

const char* cola_state_words(bool is_scdevicestate, unsigned state) {
  static constexpr const char* kLms[] = {"undefined", "initialising",   "being configured",
                                         "idle",      "mirror turning", "in preparation",
                                         "ready",     "measuring"};
  static constexpr const char* kDevice[] = {"busy", "ready", "error", "standby"};
  const bool has_name = state < (is_scdevicestate ? std::size(kDevice) : std::size(kLms));
  if (!has_name) return "a state that has no name";
  return is_scdevicestate ? kDevice[state] : kLms[state];
}

std::string ColaSession::activity() const {
  std::string text = words(state_);
  if (state_ == State::searching) text += std::string(" in ") + words(candidate_);
  if (state_ == State::waiting && !known_.device_state.empty())
    text += " (it says: " + known_.device_state + ")";
  return text;
}

void ColaSession::give_up() {
  const std::string seconds = std::to_string(static_cast<long>(options_.patience)) + " s";
  if (!known_.dialect) {
    problem_ = "no answer in " + seconds +
               (options_.dialect ? std::string(" in ") + words(*options_.dialect)
                                 : ", neither in CoLa A nor in CoLa B") +
               "; is this port 2111 or 2112 of an LMS1xx, LMS5xx or TiM?";
  } else {
    problem_ = "the device answers in " + std::string(words(*known_.dialect)) +
               " but sent no scan for " + seconds + " (last while " + activity() + ")";
    problem_ += "; " + (trouble_.empty() ? "is another program connected to it?" : trouble_);
  }
  state_ = State::failed;
  step_ = Step::none;
  wants_connection_ = false;
}

ColaSession::Step ColaSession::what_next() const {
  if (!known_.dialect) return Step::probe;
  if (!known_.identified) return Step::identify;
  if (known_.subscribed) return Step::none;
  if (!known_.logged_in) return Step::log_in;
  if (options_.ask_intensities && !known_.configured) return Step::configure;
  if (!known_.started) return Step::start;
  if (!known_.logged_out) return Step::log_out;
  if (!known_.measures) return Step::ask_state;
  return Step::subscribe;
}

ColaWriter ColaSession::command(Step step) const {
  const ColaDialect dialect = known_.dialect.value_or(candidate_);
  switch (step) {
    case Step::identify:
      return ColaWriter(dialect, "sRN DeviceIdent");
    case Step::log_in:
      return ColaWriter(dialect, "sMN SetAccessMode").u8(3, 2).u32(options_.password);
    case Step::configure:  // echo 1, RSSI, 16 bits, no unit, no encoder, no place, name, each scan
      return ColaWriter(dialect, "sWN LMDscandatacfg")
          .u8(1, 2)
          .u8(0, 2)
          .u8(1)
          .u8(1)
          .u8(0)
          .u8(0, 2)
          .u8(0, 2)
          .u8(0)
          .u8(1)
          .u8(0)
          .u8(0)
          .u16(1);
    case Step::start:
      return ColaWriter(dialect, "sMN LMCstartmeas");
    case Step::log_out:
      return ColaWriter(dialect, "sMN Run");
    case Step::ask_state:
      return ColaWriter(dialect, known_.no_stlms ? "sRN SCdevicestate" : "sRN STlms");
    case Step::subscribe:
      return ColaWriter(dialect, "sEN LMDscandata").u8(1);
    case Step::probe:
    case Step::none:
      break;
  }
  return ColaWriter(dialect, "sRN SCdevicestate");
}

const char* ColaSession::answer(Step step) const {
  switch (step) {
    case Step::identify:
      return "sRA DeviceIdent";
    case Step::log_in:
      return "sAN SetAccessMode";
    case Step::configure:
      return "sWA LMDscandatacfg";
    case Step::start:
      return "sAN LMCstartmeas";
    case Step::log_out:
      return "sAN Run";
    case Step::ask_state:
      return known_.no_stlms ? "sRA SCdevicestate" : "sRA STlms";
    case Step::subscribe:
      return "sEA LMDscandata";
    case Step::probe:
    case Step::none:
      break;
  }
  return "sRA SCdevicestate";
}

// Starting the motor may take the device seconds, in which it answers nothing.
Duration ColaSession::reply_time(Step step) const {
  const bool slow = step == Step::start || step == Step::log_out;
  return from_seconds(slow ? std::max(options_.reply_time, options_.start_time / 2)
                           : options_.reply_time);
}

}  // namespace majak::sensor
