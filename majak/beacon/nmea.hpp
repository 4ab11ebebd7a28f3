// SPDX-License-Identifier: Apache-2.0
// NMEA 0183: what satellite receivers say, a sentence a line. GGA, RMC, GST and GSA of all talkers
// become fixes with a standard deviation. docs/FORMATS.md.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string_view>
#include <utility>

#include "majak/beacon/local_frame.hpp"
#include "majak/core/report.hpp"
#include "majak/core/time.hpp"

namespace majak::beacon {

inline constexpr Duration kDay = 86400 * kSecond;

enum class NmeaKind : std::uint8_t { gga, rmc, gst, gsa, other, none, damaged };

/// What one line says; what it leaves empty is absent.
struct NmeaSentence {
  NmeaKind kind = NmeaKind::none;  ///< none: a blank line; other: a sentence of no use here
  const char* problem = nullptr;   ///< of a damaged one
  std::optional<Duration> time_of_day{};
  std::optional<std::int64_t> day{};  ///< since 1970
  std::optional<Geodetic> place{};    ///< RMC knows no altitude
  std::optional<int> quality{};       ///< 0 none, 1 alone, 2 differential, 4 and 5 by carrier phase
  std::optional<double> hdop{};
  std::optional<double> sigma_north{}, sigma_east{};  ///< m
};

/// Any bytes: what is no sentence is `damaged`, with the reason.
NmeaSentence parse_nmea(std::string_view line);

/// ddmm.mmmm as degrees; not finite, negative or 60 minutes and more: nothing.
std::optional<double> degrees_of_dm(double dm);

/// Standard deviation of each axis (m) of a fix that says only its quality and dilution; 0 where it
/// does not say that either.
double fix_sigma(int quality, double hdop);

struct SatelliteFix {
  Time time = 0;       ///< UTC since 1970; without any date in the log, since its first midnight
  bool dated = false;  ///< the log has told a date
  Geodetic place;
  double sigma = 0;  ///< m, of each axis; 0 where the receiver does not say
  int quality = 1;
  std::int64_t line = 0;
};

/// Sentences to fixes: those with one time of day are one fix. The date comes from RMC; where it is
/// silent a leap back by half a day and more is midnight. Fixes before the first date wait for it.
class NmeaFixes {
 public:
  /// The next line of the log; damage, unknown sentences and records without a fix are counted.
  void add(std::string_view line, std::int64_t number, Report& report);
  /// No more lines will come.
  void finish(Report& report);
  /// The next fix whose date is known, or never will be.
  std::optional<SatelliteFix> take();

 private:
  struct Epoch {
    Duration time_of_day = 0;
    std::int64_t line = 0;
    std::optional<std::int64_t> day{};
    std::optional<Geodetic> from_gga{}, from_rmc{};
    std::optional<int> quality{};
    std::optional<double> hdop{}, sigma{};
    bool refused = false;  ///< a sentence of it said that there is no fix
  };
  void merge(const NmeaSentence& s);
  void close(Report& report);
  std::int64_t day_of(const Epoch& epoch);
  void date_waiting(std::int64_t days);

  std::optional<Epoch> epoch_;
  std::optional<std::pair<std::int64_t, Duration>> last_;  ///< day and time of the last epoch
  bool dated_ = false;
  bool given_up_ = false;  ///< on a date
  bool finished_ = false;
  std::deque<SatelliteFix> waiting_;
};

}  // namespace majak::beacon
