// SPDX-License-Identifier: Apache-2.0
// CoLa, the language of newer SICK devices (LMS1xx, LMS5xx, TiM) over TCP, in its two dialects:
//   A   02 <text> 03                                    fields are words, integers in hexadecimal
//   B   02 02 02 02 <length> <payload> <xor of it>      fields are big-endian numbers without gaps
// A payload is "sRN LMDscandata": a kind, a name and then fields. ColaWriter and ColaCursor write
// and read the same fields in both, so that every telegram is described once.
// Sources: SICK "Telegram Listing Ranging Sensors" 8014631, operating instructions LMS4000.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "majak/core/report.hpp"
#include "majak/core/time.hpp"

namespace majak::sensor {

enum class ColaDialect : std::uint8_t { a, b };
const char* words(ColaDialect dialect);  ///< "CoLa A"

/// A telegram without its frame.
struct ColaTelegram {
  Time time = 0;  ///< arrival of its first byte
  ColaDialect dialect = ColaDialect::a;
  std::string payload;

  std::string_view kind() const;  ///< "sRA", "sSN" ...
  std::string_view name() const;  ///< "LMDscandata"; empty in a refusal (sFA)
  bool is(std::string_view kind_and_name) const;
};

/// The code of a refusal ("sFA"), nothing for other telegrams.
std::optional<unsigned> cola_refusal(const ColaTelegram& telegram);
/// What the code says, for people: "access denied".
const char* cola_refusal_words(unsigned code);

/// The bytes on the wire.
std::vector<std::uint8_t> cola_frame(ColaDialect dialect, std::string_view payload);

/// Writes a payload field by field: a word each in A, a big-endian number each in B.
class ColaWriter {
 public:
  /// `head` is kind and name: "sMN SetAccessMode".
  ColaWriter(ColaDialect dialect, std::string_view head);

  /// `digits`: at least so many in A, where devices print the zeros ("03").
  ColaWriter& u8(std::uint8_t value, int digits = 1);
  ColaWriter& u16(std::uint16_t value);
  ColaWriter& u32(std::uint32_t value);
  ColaWriter& i32(std::int32_t value);
  ColaWriter& f32(float value);
  /// Text with its length (of one byte or two) before it; what is longer than 255 bytes is cut.
  ColaWriter& text(std::string_view value, int length_bytes = 1);
  /// Characters of a width that both sides know; no blanks in them.
  ColaWriter& label(std::string_view value);

  const std::string& payload() const { return payload_; }
  ColaDialect dialect() const { return dialect_; }
  std::vector<std::uint8_t> frame() const { return cola_frame(dialect_, payload_); }

 private:
  ColaWriter& number(std::uint32_t value, int bytes, int digits);

  ColaDialect dialect_;
  std::string payload_;
  bool first_ = true;
};

/// Reads the fields behind the name one after the other. Throws Error, one line with the telegram's
/// name, the byte, what is missing or wrong, when the telegram ends early or a field is no number
/// of its width. In A a number with a sign is decimal, as SICK's own examples write it. The
/// telegram must outlive the cursor.
class ColaCursor {
 public:
  explicit ColaCursor(const ColaTelegram& telegram);

  std::uint8_t u8(const char* what);
  std::uint16_t u16(const char* what);
  std::uint32_t u32(const char* what);
  std::int32_t i32(const char* what);
  float f32(const char* what);
  std::string text(const char* what, int length_bytes = 1);
  std::string label(std::size_t width, const char* what);

  bool at_end() const;
  /// Upper bound for the fields of so many bytes that may still follow.
  std::size_t fields_at_most(std::size_t bytes) const;
  [[noreturn]] void fail(const std::string& why) const;

 private:
  std::int64_t number(int bytes, bool is_signed, const char* what);
  std::string_view word(const char* what);
  std::string_view take(std::size_t bytes, const char* what);

  const ColaTelegram* telegram_;
  std::size_t at_ = 0;
};

/// Finds the telegrams in a byte stream of either dialect, wherever it is cut, with garbage between
/// them. The dialect is seen from each telegram's first bytes. After a damaged telegram the search
/// goes on at its second byte, so that a whole one inside it is found. Holds one telegram at most,
/// besides what was pushed since next() returned nothing.
class ColaFramer {
 public:
  /// What claims to be longer is no telegram: five echoes of 1141 beams in A take 60 kB.
  static constexpr std::size_t kLongestPayload = 128 * 1024;

  /// `now`: when these bytes arrived.
  void push(std::span<const std::uint8_t> bytes, Time now);
  std::optional<ColaTelegram> next();
  /// Forgets what is half there: the connection is a new one.
  void clear();
  /// Telegrams that were damaged, and bytes that belong to none.
  const Report& report() const { return report_; }

 private:
  enum class Look { whole, wait, none };
  Look look(ColaTelegram& found, std::size_t& length);
  Look look_a(ColaTelegram& found, std::size_t& length);
  Look look_b(ColaTelegram& found, std::size_t& length);
  void consume(std::size_t bytes);

  struct Arrival {
    std::uint64_t at;  ///< of the stream's byte
    Time time;
  };

  std::vector<std::uint8_t> buffer_;
  std::size_t begin_ = 0;    ///< in buffer_, of what is not consumed
  std::size_t scanned_ = 0;  ///< so many bytes from begin_ on are known to hold no other beginning
                             ///< or end
  std::uint64_t consumed_ = 0;
  std::deque<Arrival> arrivals_;
  Report report_;
};

}  // namespace majak::sensor
