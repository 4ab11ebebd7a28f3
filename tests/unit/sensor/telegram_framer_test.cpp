// SPDX-License-Identifier: Apache-2.0
#include "majak/sensor/telegram_framer.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <map>
#include <set>
#include <string>

#include "majak/core/random.hpp"
#include "sick_data.hpp"

namespace majak::sensor {
namespace {

using testing::Bytes;
using testing::bytes;
using ::testing::ElementsAre;
constexpr auto kToHost = TelegramFramer::Direction::device_to_host;
constexpr auto kToDevice = TelegramFramer::Direction::host_to_device;
constexpr Duration kMs = 1'000'000;

Bytes operator+(Bytes a, const Bytes& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

std::string text(const Bytes& b) { return {b.begin(), b.end()}; }

Bytes reply(std::uint8_t code, std::size_t size, std::uint8_t fill = 0x11) {
  Telegram t;
  t.address = 0x80;
  t.code = code;
  t.data.assign(size, fill);
  t.status = kStatusFine;
  return encode(t);
}

std::vector<Frame> all(TelegramFramer& framer) {
  std::vector<Frame> out;
  while (auto frame = framer.next()) out.push_back(*frame);
  return out;
}

std::string kinds(const std::vector<Frame>& frames) {
  std::string out;
  for (const Frame& f : frames) {
    if (f.kind == Frame::Kind::ack) out += '+';
    if (f.kind == Frame::Kind::nak) out += '-';
    if (f.kind == Frame::Kind::telegram) out += 'T';
  }
  return out;
}

/// Everything in one push, then silence.
std::string found(const Bytes& stream, TelegramFramer::Direction direction = kToHost) {
  TelegramFramer framer(direction);
  framer.push(stream, 0);
  std::string out = kinds(all(framer));
  framer.expire(kSecond);
  return out + "|" + kinds(all(framer));
}

TEST(TelegramFramer, HandshakeAndReply) {
  EXPECT_EQ(found(bytes("06") + reply(0xA0, 1)), "+T|");
  EXPECT_EQ(found(bytes("15 06") + reply(0xA0, 1) + reply(0xB0, 20) + bytes("06")), "-+TT+|");
}

TEST(TelegramFramer, ByteByByteIsTheSame) {
  const Bytes stream = bytes("06") + reply(0xA0, 1) + bytes("77 06 02") + reply(0xB0, 300, 0x02) +
                       bytes("02 80 05") + reply(0xB1, 152) + reply(0xB0, 2, 0x06) +
                       Bytes(600, 0x55);
  TelegramFramer at_once(kToHost), slowly(kToHost);
  at_once.push(stream, 0);
  std::vector<Frame> one = all(at_once), other;
  for (const std::uint8_t b : stream) {
    slowly.push({&b, 1}, 0);
    for (const Frame& f : all(slowly)) other.push_back(f);
  }
  EXPECT_EQ(kinds(one), "+TTTT");
  ASSERT_EQ(kinds(one), kinds(other));
  for (std::size_t i = 0; i < one.size(); ++i) EXPECT_EQ(one[i].telegram, other[i].telegram);
}

TEST(TelegramFramer, HandshakeBytesInsideOfTelegramsAndJunkAreNone) {
  EXPECT_EQ(found(reply(0xB0, 100, kAck) + reply(0xB0, 100, kNak)), "TT|");
  EXPECT_EQ(found(bytes("33 06 15 06") + reply(0xA0, 1)), "T|");
  // The rest of a damaged telegram.
  Bytes damaged = reply(0xB0, 20, kAck);
  damaged[10] = 0;
  EXPECT_EQ(found(damaged + reply(0xA0, 1)), "T|");
}

TEST(TelegramFramer, HandshakeAfterJunkAndAPauseCounts) {
  TelegramFramer framer(kToHost);
  framer.push(bytes("33 44"), 0);
  EXPECT_EQ(kinds(all(framer)), "");
  framer.push(bytes("06"), 100 * kMs);
  EXPECT_EQ(kinds(all(framer)), "+");
}

TEST(TelegramFramer, EveryDamagedByteCostsOneTelegramOnly) {
  const Bytes telegram = reply(0xB0, 40, 0x02);
  for (std::size_t at = 0; at < telegram.size(); ++at) {
    Bytes damaged = telegram, shorter = telegram, longer = telegram;
    damaged[at] ^= 0x40;
    shorter.erase(shorter.begin() + static_cast<std::ptrdiff_t>(at));
    longer.insert(longer.begin() + static_cast<std::ptrdiff_t>(at), 0x5A);
    for (const Bytes& middle : {damaged, shorter, longer}) {
      const std::string out = found(telegram + middle + telegram + telegram);
      // A byte before or behind it does no harm.
      EXPECT_GE(std::count(out.begin(), out.end(), 'T'), 3) << at << ' ' << out;
      EXPECT_LE(std::count(out.begin(), out.end(), 'T'), 4) << at << ' ' << out;
    }
  }
}

TEST(TelegramFramer, EveryTruncationIsSurvived) {
  const Bytes telegram = reply(0xB0, 60);
  for (std::size_t n = 0; n < telegram.size(); ++n) {
    const Bytes stump(telegram.begin(), telegram.begin() + static_cast<std::ptrdiff_t>(n));
    std::string out = found(stump + bytes("06") + reply(0xA0, 1) + telegram);
    EXPECT_EQ(std::count(out.begin(), out.end(), 'T'), 2) << n << ' ' << out;
  }
}

TEST(TelegramFramer, SilenceEndsACandidate) {
  TelegramFramer framer(kToHost);
  EXPECT_FALSE(framer.expires_at().has_value());
  framer.push(bytes("02 80 00 04 B0") + reply(0xA0, 1), 10 * kMs);
  EXPECT_EQ(kinds(all(framer)), "");
  EXPECT_EQ(framer.expires_at(), 60 * kMs);
  framer.expire(59 * kMs);
  EXPECT_EQ(kinds(all(framer)), "");
  framer.expire(60 * kMs);
  EXPECT_EQ(kinds(all(framer)), "T");
  EXPECT_FALSE(framer.expires_at().has_value());
  EXPECT_EQ(framer.counts().expired, 1);
  EXPECT_EQ(framer.counts().skipped_bytes, 5);
}

TEST(TelegramFramer, APauseInsideOfATelegramIsAllowed) {
  const Bytes telegram = reply(0xB0, 40);
  TelegramFramer framer(kToHost);
  framer.push(std::span(telegram).first(20), 0);
  framer.expire(49 * kMs);
  framer.push(std::span(telegram).subspan(20), 49 * kMs);
  EXPECT_EQ(kinds(all(framer)), "T");
}

TEST(TelegramFramer, FirstByteHasItsTime) {
  TelegramFramer framer(kToHost);
  framer.set_byte_time(kMs);
  const Bytes a = reply(0xA0, 1), b = reply(0xBA, 21);
  // a begins 5 bytes before the end of the first push and b in the middle of the second.
  framer.push(bytes("77 77 77") + Bytes(a.begin(), a.begin() + 5), 100 * kMs);
  framer.push(Bytes(a.begin() + 5, a.end()) + bytes("77") + Bytes(b.begin(), b.begin() + 3),
              120 * kMs);
  framer.push(Bytes(b.begin() + 3, b.end()), 300 * kMs);
  const auto frames = all(framer);
  ASSERT_EQ(kinds(frames), "TT");
  EXPECT_EQ(frames[0].first_byte, 95 * kMs);
  EXPECT_EQ(frames[1].first_byte, 117 * kMs);
}

TEST(TelegramFramer, TimesGoOnAfterResynchronising) {
  // The good telegram hides in a false one, pushed byte by byte at a millisecond each.
  const Bytes stream = bytes("02 80 40 00 B0 01 02 03") + reply(0xB7, 30) + Bytes(60, 0x55);
  TelegramFramer framer(kToHost);
  std::vector<Frame> frames;
  for (std::size_t i = 0; i < stream.size(); ++i) {
    framer.push({&stream[i], 1}, static_cast<Time>(i) * kMs);
    for (const Frame& f : all(framer)) frames.push_back(f);
  }
  ASSERT_EQ(kinds(frames), "T");
  EXPECT_EQ(frames[0].first_byte, 8 * kMs);
  EXPECT_EQ(framer.counts().crc_errors, 1);
}

TEST(TelegramFramer, ByteTimesNeverReachBackIntoThePush) {
  TelegramFramer framer(kToHost);
  framer.set_byte_time(10 * kMs);
  framer.push(bytes("77"), 100 * kMs);
  framer.push(reply(0xA0, 1), 101 * kMs);  // collected by the adapter
  const auto frames = all(framer);
  ASSERT_EQ(kinds(frames), "T");
  EXPECT_EQ(frames[0].first_byte, 100 * kMs);
}

TEST(TelegramFramer, DirectionsHearTheirOwn) {
  const Bytes question = bytes("02 00 01 00 31 15 12"), answer = reply(0xA0, 1);
  EXPECT_EQ(found(question + answer, kToHost), "T|");
  EXPECT_EQ(found(question + answer + question, kToDevice), "TT|");
  EXPECT_EQ(found(bytes("06 15") + question, kToDevice), "T|");
}

TEST(TelegramFramer, ClearForgets) {
  TelegramFramer framer(kToHost);
  const Bytes telegram = reply(0xB0, 40);
  framer.push(std::span(telegram).first(20), 0);
  framer.clear();
  framer.push(std::span(telegram).subspan(20), 0);
  framer.push(telegram, 0);
  EXPECT_EQ(kinds(all(framer)), "T");
}

// A frame that lost a byte and whose CRC fits all the same: the last byte that it takes belongs
// to the next one. Made by choosing the byte that is lost and two values.
TEST(TelegramFramer, ATelegramThatSwallowsTheNextOneIsRefused) {
  const Bytes next = reply(0xB0, 40);
  RandomStream random(1);
  for (int tries = 0;; ++tries) {
    ASSERT_LT(tries, 1 << 22);
    Bytes wrong = reply(0xB0, 40);
    const std::uint64_t bits = random.bits();
    for (std::size_t i = 0; i < 4; ++i) wrong[10 + i] = static_cast<std::uint8_t>(bits >> 8 * i);
    wrong[wrong.size() - 2] = static_cast<std::uint8_t>(bits >> 32);
    wrong.back() = kStx;  // of the next
    if (!decode(wrong)) continue;
    wrong.pop_back();
    EXPECT_EQ(found(wrong + next + next), "TT|");
    // Alone on the line it waits for what follows, and is believed if nothing does.
    wrong.push_back(kStx);
    EXPECT_EQ(found(wrong), "|T");
    EXPECT_EQ(found(wrong + bytes("06") + next), "T+T|");
    EXPECT_EQ(found(wrong + next), "TT|");
    break;
  }
}

/// Ten million bytes of noise with telegrams inside; the false headers in it are found, too.
struct Noise {
  Bytes stream;
  std::vector<std::size_t> starts;
  Noise(std::size_t size, std::uint64_t seed) {
    RandomStream random(seed);
    std::size_t next = 100;
    while (stream.size() < size) {
      if (stream.size() < next) {
        const std::uint64_t bits = random.bits();
        for (unsigned i = 0; i < 64; i += 8) stream.push_back(static_cast<std::uint8_t>(bits >> i));
        if (random.below(500) == 0) stream = std::move(stream) + bytes("02 80 D6 02 B0");
        continue;
      }
      starts.push_back(stream.size());
      stream = std::move(stream) +
               reply(0xB0, 2 * random.below(362), static_cast<std::uint8_t>(random.below(256)));
      next = stream.size() + random.below(20000);
    }
  }
};

TEST(TelegramFramer, EveryTelegramInTenMillionBytesOfNoise) {
  const Noise noise(10'000'000, 7);
  ASSERT_GT(noise.starts.size(), 800u);
  TelegramFramer framer(kToHost);
  std::map<Time, std::size_t> at;  // where a telegram was found -> how many bytes had been pushed
  framer.set_byte_time(1);         // the time of a byte is its place in the stream
  RandomStream random(8);
  for (std::size_t pushed = 0; pushed < noise.stream.size();) {
    const std::size_t n =
        std::min<std::size_t>(1 + random.below(600), noise.stream.size() - pushed);
    framer.push(std::span(noise.stream).subspan(pushed, n), static_cast<Time>(pushed + n));
    pushed += n;
    while (auto frame = framer.next()) {
      if (frame->kind == Frame::Kind::telegram) at[frame->first_byte] = pushed;
    }
  }
  framer.expire(kSecond);
  for (const Frame& f : all(framer)) at[f.first_byte] = noise.stream.size();
  std::size_t missed = 0, late = 0;
  for (const std::size_t start : noise.starts) {
    const auto it = at.find(static_cast<Time>(start));
    missed += it == at.end() ? 1 : 0;
    // Its own length, the wait for a false header before it, the size of a push.
    if (it != at.end() && it->second > start + 2 * 1030 + 600) ++late;
  }
  EXPECT_EQ(missed, 0u);
  EXPECT_EQ(late, 0u);
  EXPECT_GT(framer.counts().crc_errors, 1000);  // the false ones were there
}

TEST(TelegramFramer, LostBytesCostOnlyTheirTelegrams) {
  RandomStream random(9);
  Bytes stream;
  std::set<std::string> intact;
  int whole = 0;
  for (int i = 0; i < 2000; ++i) {
    Telegram t;
    t.address = 0x80;
    t.code = 0xB0;
    t.status = kStatusFine;
    for (int k = 0; k < 363; ++k) {
      t.data.push_back(static_cast<std::uint8_t>(random.below(256)));
      t.data.push_back(static_cast<std::uint8_t>(random.below(8)));
    }
    const Bytes frame = encode(t);
    const std::size_t before = stream.size();
    for (const std::uint8_t b : frame) {
      if (random.below(1000) != 0) stream.push_back(b);
    }
    if (stream.size() - before == frame.size()) ++whole, intact.insert(text(t.data));
  }
  TelegramFramer framer(kToHost);
  framer.push(stream, 0);
  std::vector<Frame> frames = all(framer);
  framer.expire(kSecond);
  for (const Frame& f : all(framer)) frames.push_back(f);
  int right = 0, wrong = 0;
  for (const Frame& f : frames) {
    if (f.kind != Frame::Kind::telegram || !f.telegram.is(Reply::scan)) continue;
    ++(intact.contains(text(f.telegram.data)) ? right : wrong);
  }
  EXPECT_EQ(right, whole);
  EXPECT_GT(whole, 2000 * 0.45);
  EXPECT_EQ(wrong, 0);
}

TEST(TelegramFramer, RecordedTrafficInOneStream) {
  MAJAK_NEEDS_SICK_DATA();
  Bytes stream;
  for (const Bytes& frame : testing::sick_recorded()) stream = std::move(stream) + frame;
  TelegramFramer framer(kToHost);
  framer.push(stream, 0);
  EXPECT_EQ(all(framer).size(), 34u);
  EXPECT_EQ(framer.counts().skipped_bytes, 0);
}

}  // namespace
}  // namespace majak::sensor
