// SPDX-License-Identifier: Apache-2.0
#include "majak/sensor/cola_identity.hpp"

#include <gtest/gtest.h>

#include <string>

#include "majak/core/error.hpp"
#include "tests/unit/sensor/cola_wire.hpp"

namespace majak::sensor {
namespace {

ColaTelegram telegram(ColaDialect dialect, std::string payload) {
  return {.dialect = dialect, .payload = std::move(payload)};
}

// Both were heard from devices.
TEST(ColaIdentity, OfDevices) {
  const auto lms =
      telegram(ColaDialect::a, "sRA DeviceIdent 10 LMS10x_FieldEval 10 V1.36-21.10.2010");
  EXPECT_EQ(decode_identity(lms), (ColaIdentity{"LMS10x_FieldEval", "V1.36-21.10.2010"}));
  using namespace std::string_literals;
  const auto mrs = telegram(ColaDialect::b, "sRA DeviceIdent \0\x08MRS6124R\0\x0a"s + "1.1.0.565C");
  EXPECT_EQ(decode_identity(mrs), (ColaIdentity{"MRS6124R", "1.1.0.565C"}));
}

TEST(ColaIdentity, WhatIsToldIsRead) {
  for (const ColaDialect dialect : kDialects)
    for (const ColaIdentity& who :
         {ColaIdentity{"TiM561", "V2"}, ColaIdentity{"", ""}, ColaIdentity{"a name", "1 2"},
          ColaIdentity{std::string(255, 'x'), ""}})
      EXPECT_EQ(decode_identity(telegram(dialect, tell_identity(who, dialect).payload())), who);
}

TEST(ColaIdentity, CutShortIsAnError) {
  for (const ColaDialect dialect : kDialects) {
    const std::string whole = tell_identity({"TiM561", "V2.50"}, dialect).payload();
    for (std::size_t n = std::string("sRA DeviceIdent").size(); n < whole.size(); ++n)
      EXPECT_THROW(decode_identity(telegram(dialect, whole.substr(0, n))), Error) << n;
  }
}

TEST(ColaReach, OfTheDataSheets) {
  EXPECT_EQ(cola_reach("LMS10x_FieldEval"), 20);
  EXPECT_EQ(cola_reach("LMS111"), 20);
  EXPECT_EQ(cola_reach("LMS151"), 50);
  EXPECT_EQ(cola_reach("LMS1000"), 64);
  EXPECT_EQ(cola_reach("LMS511"), 80);
  EXPECT_EQ(cola_reach("TiM320"), 4);
  EXPECT_EQ(cola_reach("TiM551"), 10);
  EXPECT_EQ(cola_reach("TiM561"), 10);
  EXPECT_EQ(cola_reach("TiM571"), 25);
  EXPECT_EQ(cola_reach("TiM781S"), 25);
}

// A family's name stands for the one that sees farthest.
TEST(ColaReach, OfAFamily) {
  EXPECT_EQ(cola_reach("LMS1xx"), 50);
  EXPECT_EQ(cola_reach("LMS1xxx"), 64);
  EXPECT_EQ(cola_reach("LMS5xx"), 80);
  EXPECT_EQ(cola_reach("TiM3xx"), 10);
  EXPECT_EQ(cola_reach("TiM5xx"), 25);
  for (const char* name : {"", "LMS", "MRS6124R", "tim561", "XTiM561"})
    EXPECT_FALSE(cola_reach(name).has_value()) << name;
}

TEST(ColaIdentity, TheSessionAsks) {
  for (const ColaDialect dialect : kDialects) {
    ColaWire wire({}, {.dialect = dialect, .identity = {"LMS511", "V1.80"}});
    wire.run(10 * kSecond, [&] { return !wire.scans.empty(); });
    ASSERT_TRUE(wire.session.identity().has_value());
    EXPECT_EQ(*wire.session.identity(), (ColaIdentity{"LMS511", "V1.80"}));
    EXPECT_FALSE(wire.scans.empty());
  }
}

TEST(ColaIdentity, ADeviceThatDoesNotTellIsTakenAllTheSame) {
  for (const ColaDialect dialect : kDialects) {
    ColaWire refuses({}, {.dialect = dialect, .identity = {"", ""}});
    refuses.run(10 * kSecond, [&] { return refuses.scans.size() > 3; });
    EXPECT_GT(refuses.scans.size(), 3U);
    EXPECT_FALSE(refuses.session.identity().has_value());
  }
}

// Neither an answer that cannot be read nor none at all holds the scans up for long.
TEST(ColaIdentity, ABadAnswerOrNoneIsDoneWithout) {
  for (const bool silent : {false, true}) {
    ColaWire wire({.dialect = ColaDialect::a},
                  {.dialect = ColaDialect::a, .identity = {"TiM561", ""}});
    wire.change = [&](std::vector<std::uint8_t>& said) {
      const std::string text(said.begin(), said.end());
      if (text.find("DeviceIdent") == std::string::npos) return;
      said = silent ? std::vector<std::uint8_t>{}
                    : cola_frame(ColaDialect::a, "sRA DeviceIdent TiM561");
    };
    wire.run(5 * kSecond, [&] { return wire.scans.size() > 3; });
    EXPECT_GT(wire.scans.size(), 3U) << silent << wire.session.activity();
    EXPECT_FALSE(wire.session.identity().has_value());
  }
}

}  // namespace
}  // namespace majak::sensor
