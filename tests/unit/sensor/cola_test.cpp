// SPDX-License-Identifier: Apache-2.0
#include "majak/sensor/cola.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <set>
#include <sstream>

#include "majak/core/error.hpp"
#include "majak/core/random.hpp"

namespace majak::sensor {
namespace {

using testing::HasSubstr;
using Bytes = std::vector<std::uint8_t>;

constexpr std::array kDialects = {ColaDialect::a, ColaDialect::b};

Bytes hex(const std::string& text) {
  std::istringstream in(text);
  Bytes bytes;
  for (unsigned value = 0; in >> std::hex >> value;)
    bytes.push_back(static_cast<std::uint8_t>(value));
  return bytes;
}

Bytes bytes_of(const std::string& text) { return {text.begin(), text.end()}; }

Bytes operator+(Bytes a, const Bytes& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

std::vector<ColaTelegram> telegrams_in(const Bytes& bytes, std::size_t chunk = 1 << 20) {
  ColaFramer framer;
  std::vector<ColaTelegram> found;
  for (std::size_t i = 0; i < bytes.size(); i += chunk) {
    framer.push(std::span(bytes).subspan(i, std::min(chunk, bytes.size() - i)), 1);
    while (auto telegram = framer.next()) found.push_back(std::move(*telegram));
  }
  return found;
}

std::vector<std::string> payloads_in(const Bytes& bytes, std::size_t chunk = 1 << 20) {
  std::vector<std::string> payloads;
  for (const ColaTelegram& t : telegrams_in(bytes, chunk)) payloads.push_back(t.payload);
  return payloads;
}

// ---- writing and reading --------------------------------------------------------------------

TEST(Cola, WritesTheVectorsOfTheManuals) {
  using W = ColaWriter;
  constexpr ColaDialect kB = ColaDialect::b;
  EXPECT_EQ(W(kB, "sRN LMDscandata").frame(),
            hex("02 02 02 02 00 00 00 0f 73 52 4e 20 4c 4d 44 73 63 61 6e 64 61 74 61 05"));
  EXPECT_EQ(W(kB, "sEN LMDscandata").u8(1).frame(),
            hex("02 02 02 02 00 00 00 11 73 45 4e 20 4c 4d 44 73 63 61 6e 64 61 74 61 20 01 33"));
  EXPECT_EQ(W(kB, "sMN SetAccessMode").u8(3, 2).u32(0xF4724744).frame(),
            hex("02 02 02 02 00 00 00 17 73 4d 4e 20 53 65 74 41 63 63 65 73 73 4d 6f 64 65 20 03 "
                "f4 72 47 44 b3"));
  EXPECT_EQ(W(kB, "sWN EIHstCola").u8(1).frame(),
            hex("02 02 02 02 00 00 00 0f 73 57 4e 20 45 49 48 73 74 43 6f 6c 61 20 01 09"));
  EXPECT_EQ(W(kB, "sRN SCdevicestate").frame(),
            hex("02 02 02 02 00 00 00 11 73 52 4e 20 53 43 64 65 76 69 63 65 73 74 61 74 65 30"));
  const auto contents = W(kB, "sWN LMDscandatacfg").u8(1).u8(0).u8(1).u8(1).u8(1).u8(1).u8(0).u8(0);
  EXPECT_EQ(
      bytes_of(W(contents).u8(0).u8(0).u8(0).u16(10).payload()),
      hex("73 57 4e 20 4c 4d 44 73 63 61 6e 64 61 74 61 63 66 67 20 01 00 01 01 01 01 00 00 00 "
          "00 00 00 0a"));
  EXPECT_EQ(W(ColaDialect::a, "sEN LMDscandata").u8(1).frame(),
            hex("02 73 45 4e 20 4c 4d 44 73 63 61 6e 64 61 74 61 20 31 03"));
  EXPECT_EQ(W(ColaDialect::a, "sMN SetAccessMode").u8(3, 2).u32(0xF4724744).payload(),
            "sMN SetAccessMode 03 F4724744");
}

TEST(Cola, WritesEveryKindOfField) {
  const auto write = [](ColaDialect dialect) {
    return ColaWriter(dialect, "sRA X")
        .u8(10)
        .u16(0)
        .u32(0x3D611E4A)
        .i32(-450000)
        .f32(0.1F)
        .label("DIST1")
        .text("not defined")
        .payload();
  };
  EXPECT_EQ(write(ColaDialect::a), "sRA X A 0 3D611E4A FFF92230 3DCCCCCD DIST1 B not defined");
  EXPECT_EQ(
      bytes_of(write(ColaDialect::b)),
      hex("73 52 41 20 58 20 0a 00 00 3d 61 1e 4a ff f9 22 30 3d cc cc cd 44 49 53 54 31 0b 6e "
          "6f 74 20 64 65 66 69 6e 65 64"));
}

TEST(Cola, ReadsWhatItWrote) {
  RandomStream random(1);
  for (int round = 0; round < 300; ++round) {
    const auto pick = [&](std::uint32_t top) -> std::uint32_t {
      const std::uint32_t edges[] = {0, 1, top / 2, top / 2 + 1, top - 1, top, 0x20, 0x2020};
      const auto k = random.below(16);
      return (k < 8 ? edges[k] : static_cast<std::uint32_t>(random.bits())) & top;
    };
    const auto a = static_cast<std::uint8_t>(pick(0xff));
    const auto b = static_cast<std::uint16_t>(pick(0xffff));
    const std::uint32_t c = pick(0xffffffff);
    const auto d = static_cast<std::int32_t>(pick(0xffffffff));
    const auto e = static_cast<float>(random.normal());
    const std::string f(random.below(4), ' ');
    for (const ColaDialect dialect : kDialects) {
      const ColaWriter out =
          ColaWriter(dialect, "sAN Y").u8(a).u16(b).text(f).u32(c).i32(d).label("L").f32(e);
      const auto found = telegrams_in(out.frame());
      ASSERT_EQ(found.size(), 1U);
      ColaCursor in(found[0]);
      EXPECT_EQ(in.u8("a"), a);
      EXPECT_EQ(in.u16("b"), b);
      EXPECT_EQ(in.text("f"), f);
      EXPECT_EQ(in.u32("c"), c);
      EXPECT_EQ(in.i32("d"), d);
      EXPECT_FALSE(in.at_end());
      EXPECT_EQ(in.label(1, "l"), "L");
      EXPECT_EQ(in.f32("e"), e);
      EXPECT_TRUE(in.at_end());
    }
  }
}

ColaTelegram text_telegram(const std::string& payload) { return {0, ColaDialect::a, payload}; }

TEST(Cola, ANumberWithASignIsDecimal) {
  const ColaTelegram telegram =
      text_telegram("sMN mLMPsetscancfg +5000 +1 -450000 FFF92230 -2147483648 ff");
  ColaCursor in(telegram);
  EXPECT_EQ(in.u32("rate"), 5000U);
  EXPECT_EQ(in.u16("sectors"), 1U);
  EXPECT_EQ(in.i32("start"), -450000);
  EXPECT_EQ(in.i32("start"), -450000);
  EXPECT_EQ(in.i32("least"), std::numeric_limits<std::int32_t>::min());
  EXPECT_EQ(in.u8("small letters"), 255U);
}

TEST(Cola, RefusesWhatIsNoNumberOfItsWidth) {
  for (const char* word : {"100", "G", "-1", "+256", "1x", "+", "-", "FFFFFFFFFFFFFFFFFF"}) {
    const ColaTelegram telegram = text_telegram(std::string("sRA X ") + word);
    ColaCursor in(telegram);
    EXPECT_THROW(in.u8("it"), Error) << word;
  }
  for (const char* word : {"100000000", "-2147483649", "+2147483648", "1.5"}) {
    const ColaTelegram telegram = text_telegram(std::string("sRA X ") + word);
    ColaCursor in(telegram);
    EXPECT_THROW(in.i32("it"), Error) << word;
  }
}

TEST(Cola, AnErrorSaysWhereAndWhat) {
  const ColaTelegram telegram = text_telegram("sRA STlms 7 xyz");
  ColaCursor in(telegram);
  in.u16("the state");
  try {
    in.u8("the temperature");
    FAIL();
  } catch (const Error& e) {
    EXPECT_STREQ(e.what(),
                 "STlms in CoLa A, byte 15: 'xyz' is no number of 8 bits, as the temperature is");
  }
  try {
    in.u8("the lamp");
    FAIL();
  } catch (const Error& e) {
    EXPECT_THAT(e.what(), HasSubstr("ends before the lamp; the telegram was cut short"));
  }
}

TEST(Cola, RefusalsInBothDialects) {
  EXPECT_EQ(cola_refusal(text_telegram("sFA A")), 10U);
  EXPECT_EQ(cola_refusal(text_telegram("sFA")), 0U);
  EXPECT_EQ(cola_refusal(text_telegram("sRA SCdevicestate 1")), std::nullopt);
  const auto binary = [](std::string payload) {
    return cola_refusal(ColaTelegram{0, ColaDialect::b, std::move(payload)});
  };
  using namespace std::string_literals;
  EXPECT_EQ(binary("sFA\x00\x08"s), 8U);
  EXPECT_EQ(binary("sFA \x00\x08"s), 8U);
  EXPECT_EQ(binary("sFA\x03"s), 3U);
  EXPECT_STREQ(cola_refusal_words(1), "access denied");
  EXPECT_STREQ(cola_refusal_words(0x14), "internal error");
  EXPECT_STREQ(cola_refusal_words(999), "a reason that has no name");
  std::set<std::string> all;
  for (unsigned code = 0; code <= 0x14; ++code) all.insert(cola_refusal_words(code));
  EXPECT_EQ(all.size(), 0x15U);
}

TEST(Cola, KindAndName) {
  const ColaTelegram telegram = text_telegram("sRA LMDscandata 1 1");
  EXPECT_EQ(telegram.kind(), "sRA");
  EXPECT_EQ(telegram.name(), "LMDscandata");
  EXPECT_TRUE(telegram.is("sRA LMDscandata"));
  EXPECT_FALSE(telegram.is("sRA LMDscandatacfg"));
  EXPECT_FALSE(telegram.is("sSN LMDscandata"));
  EXPECT_EQ(text_telegram("sFA 3").name(), "");
  EXPECT_EQ(text_telegram("sRI0").name(), "");
}

// ---- framing --------------------------------------------------------------------------------

const std::string kShort = "sAN Run 1", kLong = "sRA STlms 7 0 8 00:00:00 8 01.0 1.06 0 0 0";

TEST(ColaFramer, FindsTelegramsHoweverTheyAreCut) {
  Bytes stream;
  for (const ColaDialect d : kDialects)
    stream = stream + cola_frame(d, kShort) + cola_frame(d, kLong) + cola_frame(d, kShort);
  const std::vector<std::string> want = {kShort, kLong, kShort, kShort, kLong, kShort};
  for (std::size_t chunk = 1; chunk <= stream.size(); ++chunk)
    EXPECT_EQ(payloads_in(stream, chunk), want) << chunk;
  const auto found = telegrams_in(stream);
  EXPECT_EQ(found[2].dialect, ColaDialect::a);
  EXPECT_EQ(found[3].dialect, ColaDialect::b);
}

TEST(ColaFramer, BinaryPayloadsMayHoldAnything) {
  std::string payload = "sRA X ";
  for (int i = 0; i < 256; ++i) payload += static_cast<char>(i);
  payload += std::string(8, '\x02');
  const auto stream = cola_frame(ColaDialect::b, payload) + cola_frame(ColaDialect::b, kShort);
  for (const std::size_t chunk : {1UL, 7UL, 1000UL})
    EXPECT_EQ(payloads_in(stream, chunk), (std::vector{payload, kShort}));
}

TEST(ColaFramer, ATelegramThatWasCutCostsNoOtherOne) {
  for (const ColaDialect first : kDialects) {
    for (const ColaDialect second : kDialects) {
      const Bytes whole = cola_frame(first, kLong);
      for (std::size_t cut = 0; cut < whole.size(); ++cut) {
        Bytes stream(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(cut));
        // A binary telegram claims its length: it is given up when so many bytes have come.
        for (int i = 0; i < 4; ++i) stream = stream + cola_frame(second, kLong);
        const auto found = payloads_in(stream);
        EXPECT_EQ(found, std::vector(4, kLong)) << cut;
      }
    }
  }
}

TEST(ColaFramer, EveryFlippedBitIsNoticed) {
  const Bytes whole = cola_frame(ColaDialect::b, kLong);
  for (std::size_t bit = 0; bit < whole.size() * 8; ++bit) {
    Bytes stream = whole;
    stream[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
    EXPECT_THAT(payloads_in(stream), testing::IsEmpty()) << bit;
  }
}

TEST(ColaFramer, WhatIsTooLongIsGivenUp) {
  const std::string endless(ColaFramer::kLongestPayload + 1, 'x');
  const Bytes text = bytes_of("\x02sRA " + endless);
  EXPECT_EQ(payloads_in(text + cola_frame(ColaDialect::a, kShort), 4096), std::vector{kShort});
  const Bytes claim = hex("02 02 02 02 00 02 00 01 73 52 41 20");
  EXPECT_EQ(payloads_in(claim + cola_frame(ColaDialect::a, kShort)), std::vector{kShort});
  const std::string longest = "sRA X " + std::string(ColaFramer::kLongestPayload - 6, 'x');
  for (const ColaDialect d : kDialects)
    EXPECT_EQ(payloads_in(cola_frame(d, longest), 5000), std::vector{longest});
}

TEST(ColaFramer, CountsWhatItSkips) {
  ColaFramer framer;
  Bytes bad = cola_frame(ColaDialect::b, kShort);
  bad.back() ^= 1;
  framer.push(bytes_of("noise") + bad + cola_frame(ColaDialect::a, kShort), 0);
  ASSERT_TRUE(framer.next());
  EXPECT_EQ(framer.report().entries().at("CoLa: telegram whose checksum is wrong").count, 1);
  EXPECT_EQ(framer.report().entries().at("CoLa: bytes that belong to no telegram").count,
            static_cast<std::int64_t>(5 + bad.size()));
}

TEST(ColaFramer, TheTimeIsThatOfTheFirstByte) {
  for (const ColaDialect dialect : kDialects) {
    const Bytes stream = bytes_of("##") + cola_frame(dialect, kShort) + cola_frame(dialect, kLong);
    ColaFramer framer;
    std::vector<Time> times;
    for (std::size_t i = 0; i < stream.size(); ++i) {
      framer.push(std::span(stream).subspan(i, 1), static_cast<Time>(100 + i));
      while (const auto telegram = framer.next()) times.push_back(telegram->time);
    }
    const auto second = static_cast<Time>(2 + cola_frame(dialect, kShort).size());
    EXPECT_EQ(times, (std::vector<Time>{102, 100 + second}));
  }
}

TEST(ColaFramer, ForgetsWhatIsHalfThere) {
  ColaFramer framer;
  const Bytes whole = cola_frame(ColaDialect::b, kLong);
  framer.push(std::span(whole).first(20), 1);
  EXPECT_FALSE(framer.next());
  framer.clear();
  framer.push(whole, 2);
  const auto found = framer.next();
  ASSERT_TRUE(found);
  EXPECT_EQ(found->time, 2);
  EXPECT_TRUE(framer.report().empty());
}

// The slow twin: the length of the telegram that is whole at the stream's first byte, or 0.
bool kind_at(std::string_view s, std::size_t i) {
  return s.size() >= i + 3 && s[i] == 's' &&
         std::string_view("RWMAESF").find(s[i + 1]) != std::string_view::npos &&
         std::string_view("NAI").find(s[i + 2]) != std::string_view::npos;
}
std::size_t binary_size_at(std::string_view s, std::size_t i) {
  if (s.substr(i, 4) != "\x02\x02\x02\x02" || !kind_at(s, i + 8)) return 0;
  std::size_t n = 0;
  for (std::size_t k = i + 4; k < i + 8; ++k) n = n << 8 | static_cast<std::uint8_t>(s[k]);
  return n >= 3 && n <= ColaFramer::kLongestPayload ? n : 0;
}
std::size_t whole_at_begin(std::string_view s) {
  if (const std::size_t n = binary_size_at(s, 0)) {
    if (s.size() < 9 + n) return 0;
    char sum = 0;
    for (std::size_t k = 8; k < 9 + n; ++k) sum ^= s[k];
    for (std::size_t k = 8; k + 11 <= 8 + n; ++k) {
      if (binary_size_at(s, k)) return 0;
    }
    return sum == 0 ? 9 + n : 0;
  }
  if (s[0] != '\x02' || !kind_at(s, 1)) return 0;
  const auto is_control = [](char c) { return static_cast<unsigned char>(c) < ' '; };
  const auto* const end = std::find_if(s.begin() + 4, s.end(), is_control);
  return end != s.end() && *end == '\x03' ? static_cast<std::size_t>(end - s.begin()) + 1 : 0;
}

TEST(ColaFramer, FindsWhatItsSlowTwinFindsInDamagedStreams) {
  RandomStream random(3);
  std::size_t found_in_all = 0;
  for (int round = 0; round < 200; ++round) {
    Bytes stream;
    for (int i = 0; i < 12; ++i) {
      for (auto n = random.below(6); n > 0; --n)
        stream.push_back(static_cast<std::uint8_t>(random.below(4)));
      stream = stream + cola_frame(kDialects[random.below(2)], random.below(2) ? kShort : kLong);
    }
    for (auto n = random.below(8); n > 0; --n)
      stream[random.below(stream.size())] = static_cast<std::uint8_t>(random.below(8));
    const std::size_t interesting = stream.size();
    // Enough behind it for a length that was made longer.
    stream = stream + Bytes(ColaFramer::kLongestPayload + 20, 'z');
    const std::string_view text(reinterpret_cast<const char*>(stream.data()), stream.size());
    std::vector<std::string> want;
    for (std::size_t i = 0; i < interesting;) {
      const std::size_t length = whole_at_begin(text.substr(i));
      const std::size_t head = text[i + 1] == '\x02' ? 8 : 1;
      if (length > 0) want.emplace_back(text.substr(i + head, length - head - 1));
      i += std::max<std::size_t>(length, 1);
    }
    EXPECT_EQ(payloads_in(stream, 1 + random.below(5000)), want);
    found_in_all += want.size();
  }
  EXPECT_GT(found_in_all, 200 * 8U);
}

TEST(ColaFramer, AWrongLengthDoesNotHoldUpWhatFollows) {
  Bytes stream = cola_frame(ColaDialect::b, kLong);
  stream[5] = 1;  // 64 kB more
  EXPECT_EQ(payloads_in(stream + cola_frame(ColaDialect::b, kShort)), std::vector{kShort});
}

TEST(ColaFramer, FindsEveryTelegramInNoise) {
  RandomStream random(9);
  Bytes stream;
  constexpr int kTelegrams = 300;
  for (int i = 0; i < kTelegrams; ++i) {
    for (int n = 0; n < 3000; ++n) stream.push_back(static_cast<std::uint8_t>(random.bits()));
    stream = stream + cola_frame(kDialects[random.below(2)], kLong);
  }
  const auto found = payloads_in(stream, 1460);
  EXPECT_EQ(std::count(found.begin(), found.end(), kLong), kTelegrams);
}

}  // namespace
}  // namespace majak::sensor
