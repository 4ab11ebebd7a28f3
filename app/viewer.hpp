// SPDX-License-Identifier: Apache-2.0
// The page that shows a run or live work: what `majak view`, `map --view` and `record --view`
// share.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <utility>

#include "majak/serve/hub.hpp"
#include "majak/serve/server.hpp"

namespace CLI {
class App;
}

namespace majak::app {

struct ViewerOptions {
  std::string address = "127.0.0.1", token{};
  int port = 0;
};
void add_viewer_options(CLI::App& command, ViewerOptions& options);

/// Serves the page and tells people where it is. Commands from it are worked off one after another
/// on a thread of their own.
class Viewer {
 public:
  /// Throws Error where the port is taken, or the program was built without the page.
  explicit Viewer(const ViewerOptions& options);
  ~Viewer();
  Viewer(const Viewer&) = delete;
  Viewer& operator=(const Viewer&) = delete;

  serve::Hub& hub() { return hub_; }
  const std::string& url() const { return server_.url(); }
  serve::ServerStatistics statistics() const { return server_.statistics(); }

  /// A number for content that has nothing to do with what was shown before.
  std::uint32_t next_generation() { return ++generation_; }

  /// What does a command; throws Error with the sentence for the page. Once it returns, the page is
  /// told that what it asked for is done and kept.
  using Doer = std::function<void(const serve::Command&)>;
  /// From now on; waits for the command that is being worked off. An empty one refuses all.
  void set_doer(Doer doer);

  /// Until Ctrl-C.
  void wait();

 private:
  void work();
  void answer(const serve::Command& command, const serve::Reply& reply);

  serve::Hub hub_;
  std::atomic<std::uint32_t> generation_ = 0;
  std::mutex doing_, queue_mutex_;
  Doer doer_;
  std::deque<std::pair<serve::Command, serve::Reply>> queue_;
  std::condition_variable arrived_;
  bool ended_ = false;
  std::thread worker_;
  serve::Server server_;
};

}  // namespace majak::app
