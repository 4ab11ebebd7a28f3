// SPDX-License-Identifier: Apache-2.0
#include "majak/serve/command.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace majak::serve {
namespace {

using testing::HasSubstr;

void reads(const std::string& text, const Command& command) {
  const Request request = parse_request(text);
  EXPECT_EQ(request.error, "") << text;
  ASSERT_TRUE(request.command) << text;
  EXPECT_TRUE(*request.command == command) << text;
}

void refuses(const std::string& text, const std::string& why) {
  const Request request = parse_request(text);
  EXPECT_FALSE(request.command) << text.substr(0, 200);
  EXPECT_THAT(request.error, HasSubstr(why)) << text.substr(0, 200);
  EXPECT_EQ(request.error.find('\n'), std::string::npos);
}

std::string points(int count, const std::string& point = "[1,2]") {
  std::string list = "[";
  for (int i = 0; i < count; ++i) list += (i ? "," : "") + point;
  return list + "]";
}

std::string edit(const std::string& fields) {
  return R"({"id":1,"do":"edit","edit":{)" + fields + "}}";
}

TEST(Command, EveryOneIsRead) {
  reads(R"({"id":1,"do":"switch_closure","from":12,"to":945,"on":false})",
        SwitchClosure{12, 945, false});
  reads(R"({"id":1,"do":"switch_closure","from":0,"to":4294967295,"on":true})",
        SwitchClosure{0, 4294967295U, true});
  reads(edit(R"("kind":"erase","points":[[0,0],[1.5,-2e-1],[3,4]])"),
        Edit{EditKind::erase, {{0, 0}, {1.5, -0.2}, {3, 4}}, 0});
  reads(edit(R"("kind":"forbidden","points":[[0,0],[1,0],[1,1]])"),
        Edit{EditKind::forbidden, {{0, 0}, {1, 0}, {1, 1}}, 0});
  reads(edit(R"("kind":"crop","points":[[0,0],[1,0],[1,1]])"),
        Edit{EditKind::crop, {{0, 0}, {1, 0}, {1, 1}}, 0});
  reads(edit(R"("kind":"wall","points":[[0,0],[1,0]])"), Edit{EditKind::wall, {{0, 0}, {1, 0}}, 0});
  reads(edit(R"("kind":"turn","radians":-0.25)"), Edit{EditKind::turn, {}, -0.25});
  reads(edit(R"("kind":"upright")"), Edit{EditKind::upright, {}, 0});
  reads(R"({"do":"undo"})", Undo{});
  reads(R"({"do":"redo"})", Redo{});
  reads(R"({"do":"write_files"})", WriteFiles{});
  reads(R"({"do":"localize","method":"monte-carlo"})", Localize{"monte-carlo"});
  reads(R"({"do":"stop_localizing"})", StopLocalizing{});
  reads(R"( {"do":"start_pose","pose":[1,-2.5,3]} )", StartPose{{1, -2.5, 3}});
  reads(R"({"do":"kidnap","pose":[1,2,-0.5]})", Kidnap{{1, 2, -0.5}});
}

TEST(Command, AngleIsWrapped) {
  const Request request = parse_request(R"({"do":"kidnap","pose":[0,0,6]})");
  EXPECT_NEAR(std::get<Kidnap>(*request.command).pose.theta, 6 - 2 * M_PI, 1e-15);
}

TEST(Command, NotJson) {
  for (const char* text :
       {"", " ", "{", "}", "undo", "{\"do\":}", "{'do':'undo'}", "{\"do\":\"undo\"}x",
        "{\"do\":\"undo\",}", "{\"do\":\"undo\"/**/}", "{\"do\":\"un\xff\"}", "\xef\xbb", "nul",
        "[1,2", "{\"id\":NaN,\"do\":\"undo\"}"})
    refuses(text, "the command is not JSON: byte ");
  refuses(std::string("{\"do\":\"undo\"}\0", 14), "the command is not JSON");
  refuses(R"({"do":"start_pose","pose":[1e999,0,0]})", "too large");
  refuses(std::string(kMaxCommandBytes, ' ') + "1", "longer than 64 kB");
}

TEST(Command, NotACommand) {
  for (const char* text : {"1", "null", "[]", "\"undo\"", "true"})
    refuses(text, "the command is not an object");
  refuses("{}", "no field \"do\"");
  refuses(R"({"do":1})", "is not a text");
  refuses(R"({"do":""})", "is not a word");
  refuses(R"({"do":"Undo"})", "is not a word");
  refuses(R"({"do":"fly"})", "there is no command \"fly\"");
  refuses(R"({"do":"undo","now":true})", "a field \"now\", which does not belong there");
  refuses(R"({"do":"undo","do":"redo"})", "\"do\" twice");
  refuses(R"({"do":"undo","d\u006f":"redo"})", "\"do\" twice");
  refuses("{\"do\":\"undo\",\"\\n\x7f\\u00fc\":1}", "a field \"????\"");
}

TEST(Command, DeepNestingIsRefusedEarly) {
  refuses(std::string(60000, '['), "nested too deep");
  std::string objects;
  for (int i = 0; i < 10000; ++i) objects += "{\"a\":";
  refuses(objects, "nested too deep");
}

TEST(Command, Ids) {
  EXPECT_EQ(parse_request(R"({"do":"undo"})").id, std::nullopt);
  EXPECT_EQ(parse_request(R"({"id":-7,"do":"undo"})").id, -7);
  EXPECT_EQ(parse_request(R"({"id":9007199254740992,"do":"undo"})").id, std::int64_t{1} << 53);
  EXPECT_EQ(parse_request(R"({"id":5,"do":"fly"})").id, 5);  // so that the error finds its command
  for (const char* id : {"9007199254740993", "-9007199254740993", "18446744073709551615",
                         "18446744073709551616", "1.0", "1e3", "\"1\"", "null", "[1]", "true"})
    refuses(std::string("{\"id\":") + id + R"(,"do":"undo"})",
            "\"id\" of the command is not an integer");
}

TEST(Command, ScansAreNumbersOfScans) {
  for (const char* scan : {"-1", "4294967296", "1.5", "1.0", "\"1\"", "null", "true", "[]"})
    refuses(std::string(R"({"do":"switch_closure","from":)") + scan + R"(,"to":2,"on":true})",
            "\"from\" of the command is not the number of a scan");
  refuses(R"({"do":"switch_closure","from":1,"to":2,"on":1})", "neither true nor false");
  refuses(R"({"do":"switch_closure","from":1,"to":2})", "no field \"on\"");
}

TEST(Command, PointsHaveLimits) {
  const auto with = [](const std::string& kind, const std::string& list) {
    return edit("\"kind\":\"" + kind + "\",\"points\":" + list);
  };
  for (const char* kind : {"erase", "forbidden", "crop"}) {
    refuses(with(kind, points(2)), "is not a list of 3 to 1000 points");
    EXPECT_TRUE(parse_request(with(kind, points(3))).command);
  }
  refuses(with("wall", points(1)), "is not a list of 2 to 1000 points");
  EXPECT_TRUE(parse_request(with("wall", points(1000))).command);
  refuses(with("wall", points(1001)), "is not a list of 2 to 1000 points");
  refuses(with("wall", "{}"), "is not a list");
  refuses(with("wall", "[[1,2],3]"), "has not 2 numbers");
  refuses(with("wall", "[[1,2],[1,2,3]]"), "has not 2 numbers");
  refuses(with("wall", "[[1,2],[1,null]]"), "is not a number");
  refuses(with("wall", "[[1,2],[1,1000001]]"), "is too large");
  EXPECT_TRUE(parse_request(with("wall", "[[1,2],[-1000000,1000000]]")).command);
  refuses(with("wall", "[[1,2],[1,[[[]]]]]"), "nested too deep");
}

TEST(Command, EditsHaveTheirFieldsAndNoOthers) {
  refuses(R"({"do":"edit"})", "no field \"edit\"");
  refuses(R"({"do":"edit","edit":[]})", "the edit is not an object");
  refuses(edit(""), "the edit has no field \"kind\"");
  refuses(edit(R"("kind":"paint","points":[])"), "there is no edit \"paint\"");
  refuses(edit(R"("kind":"turn")"), "no field \"radians\"");
  refuses(edit(R"("kind":"turn","radians":7)"), "is too large");
  refuses(edit(R"("kind":"turn","radians":"1")"), "is not a number");
  refuses(edit(R"("kind":"turn","radians":1,"points":[])"), "does not belong there");
  refuses(edit(R"("kind":"upright","radians":1)"), "does not belong there");
  refuses(edit(R"("kind":"wall","kind":"wall","points":[[1,2],[3,4]])"), "twice");
}

TEST(Command, PosesAreThreeNumbers) {
  for (const char* command : {"start_pose", "kidnap"}) {
    const std::string begin = std::string(R"({"do":")") + command + R"(","pose":)";
    refuses(begin + "[1,2]}", "has not 3 numbers");
    refuses(begin + "[1,2,3,4]}", "has not 3 numbers");
    refuses(begin + "[1,2,6.3]}", "is too large");
    refuses(begin + "[-1000001,2,0]}", "is too large");
    refuses(begin + "null}", "has not 3 numbers");
  }
}

TEST(Command, MethodsAreWords) {
  for (const char* method : {"", "../x", "a b", "A", "\\u0000",
                             "aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa"})
    refuses(std::string(R"({"do":"localize","method":")") + method + "\"}", "is not a word");
}

TEST(Command, Replies) {
  EXPECT_EQ(reply_text(1, true, ""), R"({"id":1,"ok":true})");
  EXPECT_EQ(reply_text({}, true, "ignored"), R"({"ok":true})");
  EXPECT_EQ(reply_text(-3, false, "no \"such\"\nthing"),
            R"({"error":"no \"such\"\nthing","id":-3,"ok":false})");
  EXPECT_EQ(reply_text({}, false, "\xff"), "{\"error\":\"\xef\xbf\xbd\",\"ok\":false}");
}

}  // namespace
}  // namespace majak::serve
