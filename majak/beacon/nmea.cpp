// SPDX-License-Identifier: Apache-2.0
#include "majak/beacon/nmea.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <span>
#include <utility>

namespace majak::beacon {
namespace {

constexpr std::size_t kMostFields = 32;
constexpr std::size_t kLongestSentence = 256;  // the standard says 82; some receivers say more
constexpr std::int64_t kMostDays = 50'000;     // what an int64 of ns holds, with a margin
constexpr std::size_t kLongestWait = 4096;     // fixes that wait for a date

const char* const kNoSentence = "lines that are no sentence ($...*hh); left out";
const char* const kChecksum = "sentences with a wrong checksum; left out";
const char* const kField = "sentences with a missing or unreadable number; left out";
const char* const kOther = "sentences of other kinds; left out";
const char* const kNoFix = "times without a fix; left out";

using Words = std::span<const std::string_view>;

std::optional<double> number(std::string_view word) {
  double value = 0;
  const char* const end = word.data() + word.size();
  const auto [stop, error] = std::from_chars(word.data(), end, value);
  if (error != std::errc{} || stop != end || !std::isfinite(value)) return std::nullopt;
  return value;
}

/// A field that may be empty; false when it is there and is none.
bool read(std::string_view word, std::optional<double>& value) {
  if (word.empty()) return true;
  value = number(word);
  return value.has_value();
}

bool digits(std::string_view text) {
  for (const char c : text)
    if (c < '0' || c > '9') return false;
  return true;
}

int two(std::string_view text, std::size_t at) {
  return 10 * (text[at] - '0') + (text[at + 1] - '0');
}

/// hhmmss.sss, from the digits themselves.
bool read_time(std::string_view word, std::optional<Duration>& time) {
  if (word.empty()) return true;
  if (word.size() < 6 || !digits(word.substr(0, 6))) return false;
  const int h = two(word, 0), m = two(word, 2), s = two(word, 4);
  if (h > 23 || m > 59 || s > 60) return false;  // 60: a leap second
  Duration fraction = 0;
  if (word.size() > 6) {
    const std::string_view decimals = word.substr(7);
    if (word[6] != '.' || decimals.size() > 9 || !digits(decimals)) return false;
    Duration unit = kSecond;
    for (const char c : decimals) fraction += (unit /= 10) * (c - '0');
  }
  time = ((h * 60 + m) * 60 + s) * kSecond + fraction;
  return true;
}

/// Days since 1970 (Howard Hinnant, "chrono-compatible low-level date algorithms").
std::int64_t days_from_civil(int year, int month, int day) {
  year -= month <= 2;
  const int era = year / 400, of_era = year - era * 400;
  const int of_year = (153 * (month + (month > 2 ? -3 : 9)) + 2) / 5 + day - 1;
  return std::int64_t{era} * 146097 + of_era * 365 + of_era / 4 - of_era / 100 + of_year - 719468;
}

/// ddmmyy; 80 ... 99 are of the last century, there is no GPS before.
bool read_date(std::string_view word, std::optional<std::int64_t>& day) {
  if (word.empty()) return true;
  if (word.size() != 6 || !digits(word)) return false;
  const int d = two(word, 0), m = two(word, 2), y = two(word, 4);
  if (d < 1 || d > 31 || m < 1 || m > 12) return false;
  day = days_from_civil(y >= 80 ? 1900 + y : 2000 + y, m, d);
  return true;
}

/// ddmm.mm,N or dddmm.mm,E: four words. Empty is no place; half of it is damage.
bool read_place(Words words, std::optional<Geodetic>& place) {
  if (words[0].empty() && words[2].empty()) return true;
  const auto lat = number(words[0]), lon = number(words[2]);
  if (!lat || !lon) return false;
  const auto latitude = degrees_of_dm(*lat), longitude = degrees_of_dm(*lon);
  const bool sound = latitude && longitude && *latitude <= 90 && *longitude <= 180 &&
                     (words[1] == "N" || words[1] == "S") && (words[3] == "E" || words[3] == "W");
  if (!sound) return false;
  place = Geodetic{words[1] == "S" ? -*latitude : *latitude,
                   words[3] == "W" ? -*longitude : *longitude, 0};
  return true;
}

/// time lat N lon E quality satellites hdop altitude M geoid M ...
bool read_gga(Words w, NmeaSentence& s) {
  if (w.size() < 11) return false;
  std::optional<double> quality, altitude, geoid;
  if (!read_time(w[0], s.time_of_day) || !read_place(w.subspan(1, 4), s.place) ||
      !read(w[5], quality) || !read(w[7], s.hdop) || !read(w[8], altitude) || !read(w[10], geoid))
    return false;
  if (!quality || !(*quality >= 0 && *quality <= 9)) return false;
  s.quality = static_cast<int>(*quality);
  if (s.place) s.place->altitude = altitude.value_or(0) + geoid.value_or(0);
  return true;
}

/// time status lat N lon E speed course date ...
bool read_rmc(Words w, NmeaSentence& s) {
  if (w.size() < 9 || (w[1] != "A" && w[1] != "V")) return false;
  if (w[1] == "V") s.quality = 0;
  return read_time(w[0], s.time_of_day) && read_place(w.subspan(2, 4), s.place) &&
         read_date(w[8], s.day);
}

/// time rms major minor orientation sigma-lat sigma-lon sigma-alt
bool read_gst(Words w, NmeaSentence& s) {
  return w.size() >= 7 && read_time(w[0], s.time_of_day) && read(w[5], s.sigma_north) &&
         read(w[6], s.sigma_east);
}

/// mode fix satellite x 12 pdop hdop vdop
bool read_gsa(Words w, NmeaSentence& s) { return w.size() >= 17 && read(w[15], s.hdop); }

/// The text between '$' and '*', if the two digits behind it are its exclusive or.
const char* unwrap(std::string_view line, std::string_view& text) {
  const std::size_t star = line.rfind('*');
  if (line.size() > kLongestSentence || line.front() != '$' || star == std::string_view::npos ||
      line.size() < star + 3)
    return kNoSentence;
  text = line.substr(1, star - 1);
  unsigned sum = 0, stated = 0;
  for (const char c : text) sum ^= static_cast<unsigned char>(c);
  const char* const end = line.data() + star + 3;
  const auto [stop, error] = std::from_chars(line.data() + star + 1, end, stated, 16);
  if (error != std::errc{} || stop != end) return kNoSentence;
  return stated == sum ? nullptr : kChecksum;
}

NmeaSentence damaged(const char* problem) {
  return {.kind = NmeaKind::damaged, .problem = problem};
}

}  // namespace

std::optional<double> degrees_of_dm(double dm) {
  const double whole = std::floor(dm / 100.0), minutes = dm - 100.0 * whole;
  if (!(dm >= 0 && dm < 1e5 && minutes < 60)) return std::nullopt;
  return whole + minutes / 60.0;
}

double fix_sigma(int quality, double hdop) {
  // The range error of a receiver on its own: 7.8 m in 95 % (GPS Standard Positioning Service
  // Performance Standard, 4th edition, 2008, section 3.4), 4 m one sigma. With corrections, by
  // their kind, orders of size. HDOP is of both axes together; that it is taken for each is for
  // multipath.
  double range_error = 4;
  if (quality == 2) range_error = 2;     // differential
  if (quality == 5) range_error = 0.5;   // carrier phase, ambiguities not yet whole
  if (quality == 4) range_error = 0.02;  // carrier phase
  return hdop > 0 && hdop < 100 ? hdop * range_error : 0;
}

NmeaSentence parse_nmea(std::string_view line) {
  while (!line.empty() && static_cast<unsigned char>(line.back()) <= ' ') line.remove_suffix(1);
  if (line.empty()) return {};
  std::string_view text;
  if (const char* problem = unwrap(line, text)) return damaged(problem);
  std::array<std::string_view, kMostFields> words;
  std::size_t count = 0;
  for (std::size_t from = 0; from <= text.size();) {
    const std::size_t comma = std::min(text.find(',', from), text.size());
    if (count == kMostFields) return {.kind = NmeaKind::other};
    words[count++] = text.substr(from, comma - from);
    from = comma + 1;
  }
  // Two letters of the talker (GP, GN, GL, GA, GB ...), three of the sentence; P is a maker's own.
  const std::string_view name = words[0];
  if (name.size() != 5 || name[0] == 'P') return {.kind = NmeaKind::other};
  const Words fields(words.data() + 1, count - 1);
  using Read = bool (*)(Words, NmeaSentence&);
  struct Row {
    std::string_view name;
    NmeaKind kind;
    Read read;
  };
  static constexpr std::array<Row, 4> kRows{{{"GGA", NmeaKind::gga, read_gga},
                                             {"RMC", NmeaKind::rmc, read_rmc},
                                             {"GST", NmeaKind::gst, read_gst},
                                             {"GSA", NmeaKind::gsa, read_gsa}}};
  for (const Row& row : kRows) {
    if (name.substr(2) != row.name) continue;
    NmeaSentence s{.kind = row.kind};
    return row.read(fields, s) ? s : damaged(kField);
  }
  return {.kind = NmeaKind::other};
}

void NmeaFixes::add(std::string_view line, std::int64_t line_number, Report& report) {
  const NmeaSentence s = parse_nmea(line);
  if (s.kind == NmeaKind::none) return;
  if (s.kind == NmeaKind::damaged) return report.count(s.problem, line_number);
  if (s.kind == NmeaKind::other) return report.count(kOther, line_number);
  // GSA has no time: it belongs to what stands before it.
  if (!s.time_of_day && s.kind != NmeaKind::gsa) return report.count(kNoFix, line_number);
  if (s.time_of_day && (!epoch_ || epoch_->time_of_day != *s.time_of_day)) {
    close(report);
    epoch_ = Epoch{.time_of_day = *s.time_of_day, .line = line_number};
  }
  if (epoch_) merge(s);
}

void NmeaFixes::merge(const NmeaSentence& s) {
  Epoch& e = *epoch_;
  if (s.quality == 0) e.refused = true;
  if (s.day) e.day = s.day;
  if (s.place) (s.kind == NmeaKind::gga ? e.from_gga : e.from_rmc) = s.place;
  if (s.kind == NmeaKind::gga) e.quality = s.quality;
  if (s.hdop && (s.kind == NmeaKind::gga || !e.hdop)) e.hdop = s.hdop;
  if (s.sigma_north && s.sigma_east)
    e.sigma = std::hypot(*s.sigma_north, *s.sigma_east) / std::sqrt(2);
}

/// All its sentences are in: it becomes a fix.
void NmeaFixes::close(Report& report) {
  if (!epoch_) return;
  const Epoch e = *std::exchange(epoch_, std::nullopt);
  const std::int64_t day = day_of(e);
  last_ = {day, e.time_of_day};
  const std::optional<Geodetic> place = e.from_gga ? e.from_gga : e.from_rmc;
  if (!place || e.refused) return report.count(kNoFix, e.line);
  SatelliteFix fix{
      .time = day * kDay + e.time_of_day, .dated = dated_, .place = *place, .line = e.line};
  fix.quality = e.quality.value_or(1);
  fix.sigma = e.sigma && *e.sigma > 0 ? *e.sigma : fix_sigma(fix.quality, e.hdop.value_or(0));
  waiting_.push_back(fix);
  if (!dated_ && waiting_.size() > kLongestWait) given_up_ = true;
}

/// The date of an epoch: stated, or that of the one before; half a day back or ahead is midnight.
std::int64_t NmeaFixes::day_of(const Epoch& e) {
  std::int64_t day = last_ ? last_->first : 0;
  if (last_ && e.time_of_day < last_->second - kDay / 2) ++day;
  if (last_ && e.time_of_day > last_->second + kDay / 2) --day;
  day = std::clamp(day, -kMostDays, kMostDays);
  if (!e.day || given_up_) return day;
  if (!dated_) date_waiting(*e.day - day);
  dated_ = true;
  return *e.day;
}

void NmeaFixes::date_waiting(std::int64_t days) {
  for (SatelliteFix& fix : waiting_) {
    fix.time += days * kDay;
    fix.dated = true;
  }
}

void NmeaFixes::finish(Report& report) {
  close(report);
  finished_ = true;
}

std::optional<SatelliteFix> NmeaFixes::take() {
  if (waiting_.empty() || !(dated_ || given_up_ || finished_)) return std::nullopt;
  const SatelliteFix fix = waiting_.front();
  waiting_.pop_front();
  return fix;
}

}  // namespace majak::beacon
