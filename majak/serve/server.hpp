// SPDX-License-Identifier: Apache-2.0
// Server: a page, and what a Hub holds, to browsers; commands back. HTTP and WebSocket on a thread
// of its own.
//
//   Server server({}, assets, hub, [&](Command command, Reply reply) { queue.push(...); });
//   say(server.url());
//
// Who may connect: see docs/ARCHITECTURE.md, "Who may connect". Nothing that a client sends throws,
// blocks or ends the program.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "majak/serve/command.hpp"
#include "majak/serve/hub.hpp"

namespace majak::serve {

/// A file that anyone who reaches the port may have; there are no others. `bytes` outlive the
/// server.
struct Asset {
  std::string
      path;  ///< "/" is the page, "/page.js"; compared byte by byte, without what follows a '?'
  std::string content_type;
  std::string_view bytes;
};

struct ServerOptions {
  std::string address = "127.0.0.1";  ///< of this machine, as a number; "localhost" is 127.0.0.1
  std::uint16_t port = 0;             ///< 0: any that is free
  /// Whoever opens the stream has to know it, if it is not empty. Made by chance when it is empty
  /// and others than this machine can connect. Letters, digits, '-' and '_'.
  std::string token{};
  std::size_t connections = 64;  ///< at once, 1 or more; others are turned away
  double idle_seconds = 10;      ///< without a whole request; 0.25 or more, as are all times here
  double stalled_seconds = 30;   ///< without a byte that a client takes while some wait for it
  double commands_per_second = 50;  ///< and client; more are refused, many more end the connection
  std::size_t pending_commands = 32;  ///< a client may wait for so many replies
  std::size_t send_buffer =
      256 << 10;  ///< bytes that the system holds for a slow client: how old what it sees may be
  std::string content_security_policy =
      "default-src 'self'; style-src-attr 'unsafe-inline'; connect-src 'self'; img-src 'self' "
      "data: blob:; object-src 'none'; "
      "base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
};

/// The answer to one command, from any thread, at any time, also when client or server have gone.
/// The first call counts; if all copies go without one, the client is told that it was not
/// answered.
class Reply {
 public:
  struct State;
  explicit Reply(std::shared_ptr<State> state) : state_(std::move(state)) {}
  void operator()(bool ok, std::string error = {}) const;

 private:
  std::shared_ptr<State> state_;
};

/// Called on the server's thread; returns at once. What it throws is the reply.
using OnCommand = std::function<void(Command, Reply)>;

struct ServerStatistics {
  std::size_t connections = 0, clients = 0;  ///< now; clients are those of the stream
  std::uint64_t accepted = 0;                ///< connections
  std::uint64_t frames = 0, bytes = 0;       ///< sent whole, of the stream
  std::uint64_t skipped = 0;                 ///< values of slots that slow clients did not get
  std::uint64_t stalled = 0;                 ///< clients that were closed because they took nothing
  std::uint64_t commands = 0, refused = 0;   ///< refused: not understood, or too many
  std::uint64_t denied =
      0;  ///< streams: foreign host, foreign origin, wrong token; and connections beyond the limit
  std::uint64_t faults = 0;      ///< exceptions on the server's thread; always 0
  std::size_t most_waiting = 0;  ///< bytes that waited for a single client, at most, so far
};

class Server {
 public:
  /// Listens when it returns. Throws Error if it cannot: port taken, no such address. `hub`
  /// outlives the server.
  Server(ServerOptions options, std::vector<Asset> assets, Hub& hub, OnCommand on_command = {});
  /// Closes all connections.
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  /// What to open in a browser, with the token if there is one.
  const std::string& url() const;
  std::uint16_t port() const;
  ServerStatistics statistics() const;

  struct Impl;

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace majak::serve
