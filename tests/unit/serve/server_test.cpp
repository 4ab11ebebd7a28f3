// SPDX-License-Identifier: Apache-2.0
#include "majak/serve/server.hpp"

#include <dirent.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <mutex>
#include <random>
#include <thread>

#include "majak/core/error.hpp"
#include "tests/unit/serve/client.hpp"

namespace majak::serve {
namespace {

using test::Client;
using testing::HasSubstr;

const std::vector<Asset> kAssets = {
    {"/", "text/html; charset=utf-8", "<title>majak</title>"},
    {"/page.js", "text/javascript; charset=utf-8", "let a = 1;"},
    {"/fonts/a b.woff2", "font/woff2", std::string_view("\0\1\2\r\n\r\n", 7)}};

struct Served {
  explicit Served(ServerOptions options = {}, OnCommand on_command = {})
      : server(std::move(options), kAssets, hub, std::move(on_command)) {}
  Client client() const { return Client(server.port()); }
  Client stream() const {
    Client c(server.port());
    EXPECT_EQ(c.open(), 101);
    return c;
  }
  /// Waits until it is so, or five seconds.
  template <typename Condition>
  bool soon(Condition condition) const {
    for (int i = 0; i < 5000; ++i) {
      if (condition(server.statistics())) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return false;
  }
  bool alive() const { return Client(server.port()).get("/").status == 200; }
  bool unharmed() const {
    return alive() && server.statistics().faults == 0 &&
           soon([](const ServerStatistics& s) { return s.connections == 0; });
  }

  Hub hub{"<head>"};
  Server server;
};

int open_files() {
  int count = 0;
  DIR* folder = ::opendir("/proc/self/fd");
  while (::readdir(folder)) ++count;
  ::closedir(folder);
  return count;
}

std::string everything(Client& client, std::size_t size) {
  std::string bytes;
  while (bytes.size() < size) {
    const auto m = client.message();
    if (m.opcode != 2) break;
    bytes += m.bytes;
  }
  return bytes;
}

// ---- HTTP ---------------------------------------------------------------------------------------

TEST(Server, ServesItsAssetsOnOneConnection) {
  const Served served;
  Client client = served.client();
  for (const Asset& asset : kAssets) {
    if (asset.path.find(' ') != std::string::npos) continue;  // nobody can ask for it
    const auto got = client.get(asset.path);
    EXPECT_EQ(got.status, 200) << asset.path;
    EXPECT_EQ(got.body, asset.bytes);
    EXPECT_THAT(got.head, HasSubstr("Content-Type: " + asset.content_type + "\r\n"));
    const auto head = client.get(asset.path, "HEAD");
    EXPECT_EQ(head.status, 200);
    EXPECT_THAT(head.head,
                HasSubstr("Content-Length: " + std::to_string(asset.bytes.size()) + "\r\n"));
  }
  EXPECT_EQ(client.get("/?theme=dark&token=x").body, kAssets[0].bytes);
  EXPECT_EQ(client.get("/nothing").status, 404);
  EXPECT_EQ(client.get("/page.js").status, 200);  // and goes on
}

TEST(Server, SaysWhatThePageMayDo) {
  const Served served;
  const std::string head = served.client().get("/").head;
  for (const char* line :
       {"Content-Security-Policy: default-src 'self';", "frame-ancestors 'none'",
        "X-Content-Type-Options: nosniff\r\n", "Cache-Control: no-store\r\n",
        "Referrer-Policy: no-referrer\r\n", "Cross-Origin-Resource-Policy: same-origin\r\n"})
    EXPECT_THAT(head, HasSubstr(line));
  EXPECT_EQ(head.find("Access-Control"), head.npos);
  EXPECT_EQ(head.find("script-src"), head.npos);  // from here only, none inline
  EXPECT_EQ(head.find("unsafe-eval"), head.npos);
}

TEST(Server, NothingElseIsServed) {
  const Served served;
  for (const char* target : {"/../",
                             "/..",
                             "/%2e%2e/etc/passwd",
                             "/..%2fetc/passwd",
                             "/%2E%2E%5cetc",
                             "//",
                             "//page.js",
                             "/./page.js",
                             "/page.js/",
                             "/PAGE.JS",
                             "/page%2ejs",
                             "/page.js%00",
                             "/page.js%00.html",
                             "/%c0%ae%c0%ae/",
                             "/\\..\\",
                             "/etc/passwd",
                             "/page.js;x",
                             "/fonts/a%20b.woff2",
                             "/fonts",
                             "http://127.0.0.1/page.js",
                             "http://evil.example/",
                             "*",
                             "page.js",
                             "/stream/",
                             "/streams"})
    EXPECT_EQ(served.client().get(target).status, 404) << target;
  // Not HTTP any more.
  const std::string host = "Host: 127.0.0.1:" + std::to_string(served.server.port()) + "\r\n\r\n";
  for (const std::string& request :
       {std::string("GET /page.js\0 HTTP/1.1\r\n", 24) + host, "GET  / HTTP/1.1\r\n" + host,
        "GET / HTTP/9.9\r\n" + host, "GET / HTTP/1.1\r\nHost : x\r\n\r\n" + host,
        "GET /\x7f HTTP/1.1\r\n" + host,
        std::string("\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03\r\n\r\n", 15)}) {
    Client client = served.client();
    client.send(request);
    EXPECT_EQ(client.response().status, 400) << request;
    EXPECT_TRUE(client.wait_closed());
  }
  EXPECT_TRUE(served.unharmed());
}

TEST(Server, OnlyGetAndHead) {
  const Served served;
  for (const char* method :
       {"POST", "PUT", "DELETE", "OPTIONS", "TRACE", "CONNECT", "PATCH", "get"}) {
    const auto got = served.client().get("/", method);
    EXPECT_EQ(got.status, 405) << method;
    EXPECT_THAT(got.head, HasSubstr("Allow: GET, HEAD\r\n"));
  }
  EXPECT_EQ(served.client().get("/stream", "POST").status, 405);
  EXPECT_TRUE(served.unharmed());
}

TEST(Server, RequestsHaveLimits) {
  const Served served;
  EXPECT_EQ(served.client().get("/" + std::string(2047, 'a')).status, 404);
  EXPECT_EQ(served.client().get("/" + std::string(2048, 'a')).status, 414);
  EXPECT_EQ(served.client().get("/", "GET", "X: " + std::string(7000, 'a') + "\r\n").status, 200);
  EXPECT_EQ(served.client().get("/", "GET", "X: " + std::string(9000, 'a') + "\r\n").status, 431);
  EXPECT_EQ(served.client().get("/" + std::string(100000, 'a')).status, 431);
  EXPECT_EQ(served.client().get("/", "GET", "Content-Length: 0\r\n").status, 200);
  EXPECT_EQ(served.client().get("/", "GET", "Content-Length: 1\r\n").status, 413);
  EXPECT_EQ(served.client().get("/", "GET", "Content-Length: 99999999999999999999999\r\n").status,
            400);
  EXPECT_EQ(served.client().get("/", "GET", "Transfer-Encoding: chunked\r\n").status, 413);
  EXPECT_TRUE(served.unharmed());
}

TEST(Server, TwoRequestsInOnePacket) {
  const Served served;
  Client client = served.client();
  const std::string host = " HTTP/1.1\r\nHost: " + client.host() + "\r\n\r\n";
  client.send("GET /page.js" + host + "GET /" + host);
  EXPECT_EQ(client.response().body, kAssets[1].bytes);
  EXPECT_EQ(client.response().body, kAssets[0].bytes);
}

TEST(Server, WhoSaysNothingIsClosed) {
  ServerOptions options;
  options.idle_seconds = 0.25;
  const Served served(options);
  Client silent = served.client(), slow = served.client(), between = served.client();
  EXPECT_EQ(between.get("/").status, 200);
  slow.send("GET / HT");
  EXPECT_TRUE(silent.wait_closed());
  EXPECT_TRUE(slow.wait_closed());
  EXPECT_TRUE(between.wait_closed());
  EXPECT_TRUE(served.unharmed());
}

TEST(Server, ClosesWhenAskedTo) {
  const Served served;
  Client client = served.client();
  EXPECT_EQ(client.get("/", "GET", "Connection: close\r\n").body, kAssets[0].bytes);
  EXPECT_TRUE(client.wait_closed());
  Client old = served.client();
  old.send("GET / HTTP/1.0\r\nHost: localhost\r\n\r\n");
  EXPECT_EQ(old.response().status, 200);
  EXPECT_TRUE(old.wait_closed());
}

// ---- who may ------------------------------------------------------------------------------------

TEST(Server, OnlyUnderItsOwnNames) {
  const Served served;
  const std::string port = std::to_string(served.server.port());
  const auto status = [&](const std::string& hosts) {
    Client client = served.client();
    client.send("GET / HTTP/1.1\r\n" + hosts + "\r\n");
    return client.response().status;
  };
  for (const std::string& host : {"127.0.0.1:" + port, "localhost:" + port, "[::1]:" + port,
                                  std::string("localhost"), std::string("localhost:9")})
    EXPECT_EQ(status("Host: " + host + "\r\n"), 200) << host;
  for (const char* host :
       {"evil.example", "evil.example:80", "localhost.evil.example", "127.0.0.1.evil.example",
        "evil.example:80@localhost", "localhost@evil.example", "127.0.0.2", "0.0.0.0", "[::]",
        "[::1", "::1", "", "localhost:", "localhost:x", "localhost:80:80", "localhost:123456",
        "127.0.0.1:80#", "localhost."})
    EXPECT_EQ(status("Host: " + std::string(host) + "\r\n"), 403) << host;
  EXPECT_EQ(status(""), 400);
  EXPECT_EQ(status("Host: localhost\r\nHost: localhost\r\n"), 400);
}

TEST(Server, OnlyItsOwnPageOpensTheStream) {
  const Served served;
  const std::string port = std::to_string(served.server.port()), host = "127.0.0.1:" + port;
  const auto open = [&](const std::string& headers) {
    return served.client().open("/stream", headers);
  };
  EXPECT_EQ(open("Host: " + host + "\r\nOrigin: http://" + host + "\r\n"), 101);
  EXPECT_EQ(open("Host: localhost:9999\r\nOrigin: http://localhost:9999\r\n"),
            101);  // through a tunnel
  for (const std::string& headers :
       {"Host: " + host + "\r\n", "Host: " + host + "\r\nOrigin: null\r\n",
        "Host: " + host + "\r\nOrigin: http://evil.example\r\n",
        "Host: " + host + "\r\nOrigin: http://127.0.0.1\r\n",
        "Host: " + host + "\r\nOrigin: https://" + host + "\r\n",
        "Host: " + host + "\r\nOrigin: http://localhost:" + port + "\r\n",
        "Host: " + host + "\r\nOrigin: http://" + host + ".evil.example\r\n",
        "Host: " + host + "\r\nOrigin: http://" + host + "\r\nOrigin: http://" + host + "\r\n",
        std::string("Host: evil.example\r\nOrigin: http://evil.example\r\n")})
    EXPECT_EQ(open(headers), 403) << headers;
  EXPECT_EQ(served.server.statistics().denied, 8U);
  EXPECT_TRUE(served.unharmed());
}

TEST(Server, WithATokenTheStreamNeedsIt) {
  ServerOptions options;
  options.token = "Ab-9_c";
  const Served served(options);
  EXPECT_THAT(served.server.url(), testing::EndsWith("/?token=Ab-9_c"));
  for (const char* target :
       {"/stream", "/stream?", "/stream?token=", "/stream?token", "/stream?token=Ab-9_",
        "/stream?token=Ab-9_cc", "/stream?token=ab-9_c", "/stream?xtoken=Ab-9_c",
        "/stream?token=x&token=Ab-9_c", "/stream?token=Ab%2d9_c", "/stream?Token=Ab-9_c"})
    EXPECT_EQ(served.client().open(target), 403) << target;
  EXPECT_EQ(served.client().open("/stream?token=Ab-9_c"), 101);
  EXPECT_EQ(served.client().open("/stream?a=b&token=Ab-9_c&c"), 101);
  EXPECT_EQ(served.client().get("/").status, 200);  // assets hold no data
}

TEST(Server, BeyondThisMachineThereIsAlwaysAToken) {
  ServerOptions options;
  options.address = "0.0.0.0";
  const Served one(options), two(options);
  const std::string a = one.server.url(), b = two.server.url();
  const std::string token = a.substr(a.find("?token=") + 7);
  EXPECT_EQ(token.size(), 32U);
  EXPECT_NE(token, b.substr(b.find("?token=") + 7));
  EXPECT_EQ(one.client().open(), 403);
  EXPECT_EQ(one.client().open("/stream?token=" + token), 101);
  // Others know it by other names.
  EXPECT_EQ(one.client().open("/stream?token=" + token,
                              "Host: robot.local:80\r\nOrigin: http://robot.local:80\r\n"),
            101);
  EXPECT_EQ(one.client().open("/stream?token=" + token,
                              "Host: robot.local:80\r\nOrigin: http://evil.example\r\n"),
            403);
}

// ---- options ------------------------------------------------------------------------------------

std::string error_of(const ServerOptions& options) {
  Hub hub("");
  try {
    const Server server(options, {}, hub);
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

TEST(Server, SaysWhyItCannotListen) {
  const Served served;
  ServerOptions options;
  options.port = served.server.port();
  EXPECT_EQ(error_of(options),
            "port " + std::to_string(options.port) +
                " of 127.0.0.1 is taken; choose another, or 0 for any that is free");
  EXPECT_THAT(error_of({.address = "robot"}), HasSubstr("\"robot\" is no address"));
  EXPECT_THAT(error_of({.address = "192.0.2.1"}), HasSubstr("cannot be opened"));
  EXPECT_THAT(error_of({.token = "a b"}), HasSubstr("a token has"));
  EXPECT_EQ(error_of({.address = "localhost"}), "");
}

TEST(Server, PortIsFreeAgainAtOnce) {
  Hub hub("");
  ServerOptions options;
  for (int i = 0; i < 3; ++i) {
    const Server server(options, kAssets, hub);
    Client client(server.port());
    EXPECT_EQ(client.get("/").status, 200);
    options.port = server.port();
  }
}

// ---- the stream ---------------------------------------------------------------------------------

TEST(Server, StreamsWhatTheHubHolds) {
  Served served;
  served.hub.reset({1000, [](std::size_t i) { return std::to_string(i) + " "; }},
                   {{"/run", "run "}});
  std::string expected = "<head>run ";
  for (int i = 0; i < 1000; ++i) expected += std::to_string(i) + " ";
  Client client = served.stream(), other = served.stream();
  EXPECT_EQ(everything(client, expected.size()), expected);
  EXPECT_EQ(everything(other, expected.size()), expected);
  served.hub.append("live");
  EXPECT_EQ(client.message().bytes, "live");
  EXPECT_EQ(other.message().bytes, "live");
  served.hub.reset({}, {{"/run", "again"}});
  EXPECT_EQ(client.message().bytes, "again");
  EXPECT_TRUE(
      served.soon([](const ServerStatistics& s) { return s.clients == 2 && s.frames >= 5; }));
}

TEST(Server, LargeValuesArriveWhole) {
  Served served;
  std::string map(5000000, '\0');
  for (std::size_t i = 0; i < map.size(); ++i) map[i] = static_cast<char>(i * 2654435761U >> 13);
  Client client = served.stream();
  EXPECT_EQ(client.message().bytes, "<head>");
  served.hub.set("/map", map);
  EXPECT_TRUE(client.message().bytes == map);
  EXPECT_EQ(served.server.statistics().most_waiting, map.size());
}

TEST(Server, ASlowClientCostsNothingAndHoldsUpNobody) {
  Served served;
  Client slow = served.stream(), quick = served.stream();
  EXPECT_EQ(quick.message().bytes, "<head>");
  const std::string value(100000, 'v');
  for (int i = 0; i < 100; ++i) {  // 10 MB
    served.hub.set("/live", value + std::to_string(i));
    served.hub.append("r");
    while (quick.message().bytes.find("v" + std::to_string(i)) == std::string::npos) {
    }
  }
  EXPECT_LT(served.server.statistics().most_waiting, 2 * value.size());
  EXPECT_EQ(served.server.statistics().clients, 2U);
  // It reads again: what it was sent, then the newest value and every record.
  std::string bytes;
  while (std::count(bytes.begin(), bytes.end(), 'r') < 100) {
    const auto m = slow.message();
    ASSERT_EQ(m.opcode, 2);
    bytes += m.bytes;
  }
  EXPECT_NE(bytes.find("v99"), bytes.npos);
  EXPECT_LT(bytes.size(), 20 * value.size());
  EXPECT_GT(served.server.statistics().skipped, 80U);
}

TEST(Server, AClientThatTakesNothingIsClosed) {
  ServerOptions options;
  options.stalled_seconds = 1;
  Served served(options);
  Client stalled(served.server.port(), 4096), idle = served.stream();
  ASSERT_EQ(stalled.open(), 101);
  EXPECT_EQ(idle.message().bytes, "<head>");
  EXPECT_TRUE(served.soon([](const ServerStatistics& s) { return s.frames == 2; }));
  served.hub.set("/map", std::string(10000000, 'm'));
  EXPECT_EQ(idle.message().bytes.size(), 10000000U);
  EXPECT_TRUE(
      served.soon([](const ServerStatistics& s) { return s.stalled == 1 && s.clients == 1; }));
  served.hub.append("r");  // one that has nothing to take is no such client
  EXPECT_EQ(idle.message().bytes, "r");
}

TEST(Server, WithoutUpgradeThereIsNoStream) {
  const Served served;
  Client client = served.client();
  EXPECT_EQ(client.get("/stream", "GET", "Origin: http://" + client.host() + "\r\n").status, 426);
  client.close();
  for (const char* headers :
       {"Sec-WebSocket-Version: 12\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n",
        "Sec-WebSocket-Version: 13\r\n"}) {
    Client wrong = served.client();
    const int status = wrong
                           .get("/stream", "GET",
                                "Origin: http://" + wrong.host() +
                                    "\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n" + headers)
                           .status;
    EXPECT_THAT(status, testing::AnyOf(400, 426)) << headers;
    EXPECT_TRUE(wrong.wait_closed());
  }
  EXPECT_TRUE(served.unharmed());
}

/// What the server says to a frame: the code of its close, after the head.
int close_code(const Served& served, const std::string& bytes) {
  Client client = served.stream();
  EXPECT_EQ(client.message().bytes, "<head>");
  client.send(bytes);
  const auto m = client.message();
  client.send(Client::frame(0x88, m.bytes));
  EXPECT_TRUE(client.wait_closed());
  return m.opcode == 8 ? m.code() : -m.opcode;
}

TEST(Server, MalformedFramesEndTheirConnection) {
  const Served served;
  const auto frame = [](int first, std::string_view payload) {
    return Client::frame(first, payload);
  };
  EXPECT_EQ(close_code(served, Client::frame(0x81, "{}", false)), 1002);  // not masked
  for (const int reserved : {0x40, 0x20, 0x10, 0x70})
    EXPECT_EQ(close_code(served, frame(0x81 | reserved, "{}")), 1002);
  for (const int opcode : {3, 4, 5, 6, 7, 11, 12, 13, 14, 15})
    EXPECT_EQ(close_code(served, frame(0x80 | opcode, "x")), 1002) << opcode;
  EXPECT_EQ(close_code(served, frame(0x80, "x")), 1002);  // continues nothing
  EXPECT_EQ(close_code(served, frame(0x01, "x") + frame(0x81, "x")),
            1002);                                        // another begins before the end
  EXPECT_EQ(close_code(served, frame(0x09, "x")), 1002);  // a ping in pieces
  EXPECT_EQ(close_code(served, frame(0x89, std::string(126, 'x'))), 1002);  // a long ping
  EXPECT_EQ(close_code(served, frame(0x81, "\xc0\xaf")), 1007);             // no UTF-8
  EXPECT_EQ(close_code(served, frame(0x81, "\xed\xa0\x80")), 1007);
  EXPECT_EQ(close_code(served, frame(0x82, "{}")), 1003);  // binary
  EXPECT_EQ(close_code(served, frame(0x81, std::string(65537, ' '))), 1009);
  EXPECT_EQ(
      close_code(served, frame(0x01, std::string(65000, ' ')) + frame(0x80, std::string(600, ' '))),
      1009);
  EXPECT_EQ(close_code(served, std::string("\x81\xff\x7f\xff\xff\xff\xff\xff\xff\xff\1\2\3\4", 14)),
            1009);
  EXPECT_THAT(
      close_code(served, std::string("\x81\xff\xff\xff\xff\xff\xff\xff\xff\xff\1\2\3\4", 14)),
      testing::AnyOf(1002, 1009));
  EXPECT_EQ(close_code(served, std::string("\x81\xfe\x00\x01\1\2\3\4x", 9)),
            1002);  // a length that is too long for what it says
  EXPECT_EQ(close_code(served, frame(0x88, "\x03\xe8")), 1000);
  EXPECT_EQ(close_code(served, frame(0x88, "\x03")), 1002);
  EXPECT_TRUE(served.unharmed());
}

TEST(Server, PingsAreAnswered) {
  const Served served;
  Client client = served.stream();
  EXPECT_EQ(client.message().bytes, "<head>");
  client.send(Client::frame(0x89, "are you there"));
  const auto pong = client.message();
  EXPECT_EQ(pong.opcode, 10);
  EXPECT_EQ(pong.bytes, "are you there");
}

TEST(Server, RandomBytesDoNoHarm) {
  const Served served;
  std::mt19937 random(1);
  for (int i = 0; i < 2000; ++i) {
    Client client = served.client();
    if (i % 4) {
      ASSERT_EQ(client.open(), 101);
    }
    std::string bytes;
    for (int frames = static_cast<int>(random() % 3); frames >= 0; --frames) {
      std::string payload(random() % 200, '\0');
      for (char& c : payload) c = static_cast<char>(random());
      bytes += random() % 4 ? Client::frame(static_cast<int>(random() % 256), payload, random() % 8)
                            : payload;
    }
    client.send(bytes);
    if (i % 16 == 0) client.some(10);
  }
  EXPECT_TRUE(served.unharmed());
}

// ---- commands -----------------------------------------------------------------------------------

TEST(Server, CommandsAndReplies) {
  std::vector<Command> commands;
  Served served({}, [&](Command command, const Reply& reply) {
    commands.push_back(command);
    if (std::holds_alternative<Undo>(command)) throw Error("nothing to undo");
    reply(true);
    reply(false, "only the first counts");
  });
  Client client = served.stream();
  EXPECT_EQ(client.message().bytes, "<head>");
  client.say(R"({"id":1,"do":"redo"})");
  EXPECT_EQ(client.message().bytes, R"({"id":1,"ok":true})");
  client.say(R"({"id":2,"do":"undo"})");
  EXPECT_EQ(client.message().bytes, R"({"error":"nothing to undo","id":2,"ok":false})");
  client.say("nonsense");
  const auto m = client.message();
  EXPECT_EQ(m.opcode, 1);
  EXPECT_THAT(m.bytes, HasSubstr("the command is not JSON"));
  client.say(R"({"id":3,"do":"fly"})");
  EXPECT_EQ(client.message().bytes, R"({"error":"there is no command \"fly\"","id":3,"ok":false})");
  const std::string longest = R"({"id":4,"do":"redo"})" + std::string(65536 - 20, ' ');
  client.send(Client::frame(0x01, longest.substr(0, 9)) + Client::frame(0x89, "") +
              Client::frame(0x80, longest.substr(9)));
  EXPECT_EQ(client.message().opcode, 10);
  EXPECT_EQ(client.message().bytes, R"({"id":4,"ok":true})");
  EXPECT_EQ(commands.size(), 3U);
  EXPECT_TRUE(
      served.soon([](const ServerStatistics& s) { return s.commands == 3 && s.refused == 2; }));
}

TEST(Server, WithoutAHandlerCommandsAreRefused) {
  const Served served;
  Client client = served.stream();
  EXPECT_EQ(client.message().bytes, "<head>");
  client.say(R"({"id":1,"do":"undo"})");
  EXPECT_EQ(client.message().bytes,
            R"({"error":"this server takes no commands","id":1,"ok":false})");
}

/// Keeps what it was asked for a later answer.
struct Later {
  std::mutex mutex;
  std::vector<Reply> replies;
  OnCommand keep() {
    return [this](const Command&, const Reply& reply) {
      const std::lock_guard lock(mutex);
      replies.push_back(reply);
    };
  }
  std::vector<Reply> take(std::size_t size) {
    for (int i = 0; i < 5000; ++i) {
      {
        const std::lock_guard lock(mutex);
        if (replies.size() >= size) return std::exchange(replies, {});
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return {};
  }
};

TEST(Server, RepliesComeLaterAndFromAnyThread) {
  Later later;
  Served served({}, later.keep());
  Client client = served.stream();
  EXPECT_EQ(client.message().bytes, "<head>");
  client.say(R"({"id":1,"do":"undo"})");
  client.say(R"({"id":2,"do":"undo"})");
  client.say(R"({"id":3,"do":"undo"})");
  auto replies = later.take(3);
  ASSERT_EQ(replies.size(), 3U);
  std::thread([&] { replies[1](true); }).join();
  EXPECT_EQ(client.message().bytes, R"({"id":2,"ok":true})");
  replies[0](false, "the disk is full");
  EXPECT_EQ(client.message().bytes, R"({"error":"the disk is full","id":1,"ok":false})");
  replies.clear();
  EXPECT_EQ(client.message().bytes, R"({"error":"the program did not answer","id":3,"ok":false})");
}

TEST(Server, RepliesToOneThatHasGoneAreDropped) {
  Later later;
  std::vector<Reply> replies;
  {
    Served served({}, later.keep());
    {
      Client client = served.stream();
      client.say(R"({"id":1,"do":"undo"})");
      replies = later.take(1);
      ASSERT_EQ(replies.size(), 1U);
    }
    EXPECT_TRUE(served.soon([](const ServerStatistics& s) { return s.clients == 0; }));
    replies[0](true);
    Client client = served.stream();
    client.say(R"({"id":2,"do":"undo"})");
    replies = later.take(1);
    ASSERT_EQ(replies.size(), 1U);
    EXPECT_TRUE(served.alive());
  }
  replies[0](true);  // after the server
}

TEST(Server, TooManyCommandsAreRefusedThenTheConnectionEnds) {
  ServerOptions options;
  options.commands_per_second = 10;
  int taken = 0;
  Served served(options, [&](const Command&, const Reply& reply) { ++taken, reply(true); });
  Client client = served.stream();
  EXPECT_EQ(client.message().bytes, "<head>");
  std::string burst;
  for (int i = 0; i < 100; ++i)
    burst += Client::frame(0x81, R"({"id":)" + std::to_string(i) + R"(,"do":"undo"})");
  client.send(burst);
  int good = 0, refused = 0;
  Client::Message m;
  while ((m = client.message()).opcode == 1)
    ++(m.bytes.find("too many commands a second") == std::string::npos ? good : refused);
  EXPECT_EQ(m.opcode, 8);
  EXPECT_EQ(m.code(), 1008);
  EXPECT_GE(good, 10);
  EXPECT_LT(good, 50);
  client.close();
  EXPECT_GT(refused, 0);  // those still on their way at the end are lost
  EXPECT_TRUE(served.unharmed());
}

TEST(Server, OnlySoManyCommandsWait) {
  ServerOptions options;
  options.pending_commands = 2;
  Later later;
  Served served(options, later.keep());
  Client client = served.stream();
  EXPECT_EQ(client.message().bytes, "<head>");
  for (int i = 1; i <= 3; ++i) client.say(R"({"id":)" + std::to_string(i) + R"(,"do":"undo"})");
  EXPECT_EQ(client.message().bytes,
            R"({"error":"too many commands wait for their replies","id":3,"ok":false})");
  later.take(2);  // and answers none
  EXPECT_THAT(client.message().bytes, HasSubstr("did not answer"));
  EXPECT_THAT(client.message().bytes, HasSubstr("did not answer"));
  client.say(R"({"id":4,"do":"undo"})");
  EXPECT_EQ(later.take(1).size(), 1U);
}

// ---- many ---------------------------------------------------------------------------------------

TEST(Server, TenThousandConnectionsInTurn) {
  const Served served;
  EXPECT_TRUE(served.unharmed());
  const int before = open_files();
  for (int i = 0; i < 10000; ++i) {
    Client client = served.client();
    ASSERT_TRUE(client.connected()) << i;
    if (i % 10 == 0) client.send("GET / HTTP/1.1\r\n");
    if (i % 100 == 0) {
      EXPECT_THAT(client.open(), testing::AnyOf(400, 403, 101));
    }
    while (served.server.statistics().connections > 32) std::this_thread::yield();
  }
  EXPECT_TRUE(served.unharmed());
  EXPECT_EQ(open_files(), before);
  EXPECT_GE(served.server.statistics().accepted, 10000U - served.server.statistics().denied);
}

TEST(Server, BeyondTheLimitOthersAreTurnedAway) {
  const Served served;
  const int before = open_files();
  {
    std::vector<Client> clients;
    for (int i = 0; i < 64; ++i) clients.push_back(served.client());
    EXPECT_TRUE(served.soon([](const ServerStatistics& s) { return s.connections == 64; }));
    for (int i = 0; i < 40; ++i) {
      Client late = served.client();
      EXPECT_EQ(late.response().status, 503);
      EXPECT_TRUE(late.wait_closed());
    }
    EXPECT_EQ(clients[0].open(), 101);
    EXPECT_EQ(clients[0].message().bytes, "<head>");
    EXPECT_EQ(served.server.statistics().denied, 40U);
  }
  EXPECT_TRUE(served.unharmed());
  EXPECT_EQ(open_files(), before);
}

TEST(Server, GoesWithClientsConnected) {
  const int before = open_files();
  std::vector<Client> clients;
  {
    Served served;
    for (int i = 0; i < 8; ++i) clients.push_back(i % 2 ? served.stream() : served.client());
    served.hub.set("/map", std::string(20000000, 'm'));  // under way
    clients[0].send("GET / HT");
  }
  for (Client& client : clients) EXPECT_TRUE(client.wait_closed());
  clients.clear();
  EXPECT_EQ(open_files(), before);
}

TEST(Server, TwoServersOfOneHub) {
  Hub hub("<head>");
  auto first = std::make_unique<Server>(ServerOptions{}, kAssets, hub);
  const Server second({}, kAssets, hub);
  EXPECT_NE(first->port(), second.port());
  Client a(first->port()), b(second.port());
  EXPECT_EQ(a.open(), 101);
  EXPECT_EQ(b.open(), 101);
  EXPECT_EQ(a.message().bytes, "<head>");
  EXPECT_EQ(b.message().bytes, "<head>");
  hub.append("x");
  EXPECT_EQ(a.message().bytes, "x");
  EXPECT_EQ(b.message().bytes, "x");
  first.reset();
  hub.append("y");
  EXPECT_EQ(b.message().bytes, "y");
  EXPECT_TRUE(a.wait_closed());
}

}  // namespace
}  // namespace majak::serve
