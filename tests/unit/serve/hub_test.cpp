// SPDX-License-Identifier: Apache-2.0
#include "majak/serve/hub.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>
#include <thread>

namespace majak::serve {
namespace {

std::string text(const Frame& frame) {
  std::string bytes;
  for (const Bytes& piece : frame.pieces) bytes += *piece;
  EXPECT_EQ(bytes.size(), frame.bytes);
  return bytes;
}

std::string all(Hub& hub, Cursor& cursor, std::size_t limit = 1 << 16) {
  std::string bytes;
  for (;;) {
    const Frame frame = hub.next(cursor, limit);
    if (frame.empty()) return bytes;
    bytes += text(frame);
  }
}

Backlog letters(std::size_t size) {
  return {size, [](std::size_t i) { return std::string(1, static_cast<char>('a' + i)); }};
}

TEST(Hub, GivesTheHeadOnceThenSlotsThenRecords) {
  Hub hub("<head>");
  hub.reset(letters(3), {{"run", "R"}, {"map", "M"}});
  Cursor cursor;
  EXPECT_EQ(all(hub, cursor), "<head>RMabc");
  EXPECT_EQ(all(hub, cursor), "");
  hub.append("d");
  hub.set("map", "N");
  EXPECT_EQ(all(hub, cursor), "Nd");
  Cursor late;
  EXPECT_EQ(all(hub, late), "<head>RNabcd");
}

TEST(Hub, EmptyHasNothingButItsHead) {
  Hub hub("<head>");
  Cursor cursor;
  EXPECT_EQ(all(hub, cursor), "<head>");
  Hub silent("");
  Cursor other;
  EXPECT_TRUE(silent.next(other).empty());
  silent.append("a");
  EXPECT_EQ(all(silent, other), "a");
}

TEST(Hub, TheOrderIsTheSameForEveryLimit) {
  Hub hub("");
  hub.reset(letters(26), {{"run", "R"},
                          {"graph", "G", 5},
                          {"closures", "C", 5},
                          {"end", "E", 26},
                          {"never", "X", 27}});
  for (const std::size_t limit : {1U, 2U, 3U, 7U, 100U}) {
    Cursor cursor;
    EXPECT_EQ(all(hub, cursor, limit), "RabcdeGCfghijklmnopqrstuvwxyzE") << limit;
  }
}

TEST(Hub, AFrameHoldsAboutTheLimitOfEachKind) {
  Hub hub("");
  hub.reset(
      {1000, [](std::size_t) { return std::string(10, 'r'); }},
      {{"a", std::string(60, 'a')}, {"b", std::string(60, 'b')}, {"c", std::string(60, 'c')}});
  Cursor cursor;
  EXPECT_EQ(text(hub.next(cursor, 100)),
            std::string(60, 'a') + std::string(60, 'b') + std::string(100, 'r'));
  EXPECT_EQ(text(hub.next(cursor, 100)), std::string(60, 'c') + std::string(100, 'r'));
  EXPECT_EQ(text(hub.next(cursor, 100)), std::string(100, 'r'));
}

TEST(Hub, OnlyTheNewestValueOfASlotIsSent) {
  Hub hub("");
  Cursor cursor;
  hub.set("grid", "1");
  EXPECT_EQ(all(hub, cursor), "1");
  for (const char* value : {"2", "3", "4"}) hub.set("grid", value);
  const Frame frame = hub.next(cursor);
  EXPECT_EQ(text(frame), "4");
  EXPECT_EQ(frame.skipped, 2U);
  Cursor late;
  EXPECT_EQ(hub.next(late).skipped, 0U);  // what was before it came, it did not miss
}

TEST(Hub, TheSlotThatWaitsLongestGoesFirst) {
  Hub hub("");
  for (const char* name : {"a", "b", "c"}) hub.set(name, name);
  Cursor cursor;
  EXPECT_EQ(all(hub, cursor), "abc");
  for (const char* name : {"c", "a", "b", "c"}) hub.set(name, name);
  EXPECT_EQ(all(hub, cursor, 1), "abc");
}

TEST(Hub, SlotsThatChangeAllTheTimeHoldUpNobody) {
  Hub hub("");
  hub.reset(letters(5), {{"big", std::string(50, 'B')}, {"other", "O"}});
  Cursor cursor;
  std::string bytes;
  for (int i = 0; i < 7; ++i) {
    bytes += text(hub.next(cursor, 1));
    hub.set("big", std::string(50, 'B'));
  }
  bytes.erase(std::remove(bytes.begin(), bytes.end(), 'B'), bytes.end());
  EXPECT_EQ(bytes, "aObcde");
}

TEST(Hub, AnOrderedSlotStandsBetweenTheRecordsOfItsTime) {
  Hub hub("");
  Cursor quick, slow;
  std::string seen;
  for (const char* record : {"a", "b", "c"}) {
    hub.append(record);
    hub.set("poses", std::string("(after ") + record + ")", kInOrder);
    seen += all(hub, quick);
  }
  hub.append("d");
  EXPECT_EQ(seen, "a(after a)b(after b)c(after c)");
  EXPECT_EQ(all(hub, quick), "d");
  EXPECT_EQ(all(hub, slow, 1), "abc(after c)d");
}

TEST(Hub, AnOrderedSlotIsNotPassedWhenTheFrameIsFull) {
  Hub hub("");
  hub.reset(letters(4), {{"first", std::string(9, 'F'), 2}, {"second", std::string(9, 'S'), 2}});
  Cursor cursor;
  EXPECT_EQ(text(hub.next(cursor, 5)), "abFFFFFFFFF");
  EXPECT_EQ(text(hub.next(cursor, 5)), "SSSSSSSSScd");
}

TEST(Hub, ResetForgetsAndGivesAllAnew) {
  Hub hub("<head>");
  Cursor cursor;
  hub.append("old");
  hub.set("gone", "G");
  hub.set("run", "1");
  EXPECT_EQ(all(hub, cursor), "<head>G1old");
  hub.reset(letters(2), {{"run", "2"}});
  EXPECT_EQ(all(hub, cursor), "2ab");
  hub.reset(letters(2), {{"run", "2"}});
  EXPECT_EQ(all(hub, cursor), "2ab");
  hub.reset();
  EXPECT_EQ(all(hub, cursor), "");
}

TEST(Hub, ResetInTheMiddleOfTheBacklog) {
  Hub hub("");
  hub.reset(letters(5), {{"run", "1"}});
  Cursor cursor;
  EXPECT_EQ(text(hub.next(cursor, 1)), "1a");
  EXPECT_EQ(text(hub.next(cursor, 1)), "b");
  hub.reset(letters(3), {{"run", "2"}});
  EXPECT_EQ(all(hub, cursor, 1), "2abc");
}

TEST(Hub, GrowsByFunctionAndByBytes) {
  Hub hub("");
  hub.reset(letters(1));
  Cursor cursor;
  EXPECT_EQ(all(hub, cursor), "a");
  hub.grow(3);
  hub.grow(2);  // never fewer
  EXPECT_EQ(all(hub, cursor), "bc");
  hub.append("+");
  EXPECT_EQ(all(hub, cursor), "+");
  EXPECT_EQ(hub.statistics().records, 4U);
  EXPECT_EQ(hub.statistics().kept, 1U);
}

TEST(Hub, ARecordThatCannotBeMadeIsPassedOver) {
  Hub hub("");
  hub.reset({4, [](std::size_t i) -> std::string {
               if (i == 1) throw std::runtime_error("no");
               return i == 2 ? "" : std::to_string(i);
             }});
  Cursor cursor;
  EXPECT_EQ(all(hub, cursor), "03");
  EXPECT_EQ(hub.statistics().failed, 1U);
  hub.reset({2, {}});
  EXPECT_EQ(all(hub, cursor), "");
  EXPECT_EQ(hub.statistics().failed, 3U);
}

TEST(Hub, LargeValuesAreSharedSmallOnesCopiedTogether) {
  Hub hub("head");
  hub.reset(letters(3), {{"run", "R"}, {"map", std::string(100000, 'M')}, {"graph", "G"}});
  Cursor one, two;
  const Frame a = hub.next(one, 1 << 20), b = hub.next(two, 1 << 20);
  ASSERT_EQ(a.pieces.size(), 3U);
  EXPECT_EQ(*a.pieces[0], "headR");
  EXPECT_EQ(*a.pieces[2], "Gabc");
  EXPECT_EQ(a.pieces[1], b.pieces[1]);
}

TEST(Hub, TellsWatchersOfEveryChange) {
  Hub hub("");
  int calls = 0;
  const auto number = hub.watch([&] { ++calls; });
  hub.append("a");
  hub.set("s", "1");
  hub.reset(letters(1));
  hub.grow(2);
  hub.grow(2);  // no change
  EXPECT_EQ(calls, 4);
  hub.unwatch(number);
  hub.append("b");
  EXPECT_EQ(calls, 4);
}

TEST(Hub, ManyThreadsAtOnce) {
  Hub hub("");
  constexpr int kRecords = 2000;
  std::thread writer([&] {
    for (int i = 0; i < kRecords; ++i) {
      hub.append("r");
      hub.set("slot", "s");
    }
    hub.set("end", "e", kInOrder);
  });
  std::vector<std::thread> readers;
  for (int r = 0; r < 2; ++r)
    readers.emplace_back([&] {
      Cursor cursor;
      std::string bytes;
      while (bytes.find('e') == bytes.npos) bytes += text(hub.next(cursor, 64));
      EXPECT_EQ(std::count(bytes.begin(), bytes.end(), 'r'), kRecords);
    });
  writer.join();
  for (std::thread& reader : readers) reader.join();
}

}  // namespace
}  // namespace majak::serve
