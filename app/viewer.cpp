// SPDX-License-Identifier: Apache-2.0
#include "app/viewer.hpp"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <vector>

#include "app/live.hpp"
#include "majak/core/error.hpp"
#include "majak/draw/viewer_page.hpp"
#include "majak/io/view_records.hpp"

namespace majak::app {
namespace {

std::vector<serve::Asset> page_assets() {
  const draw::ViewerPage page = draw::viewer_page();
  if (page.script.empty())
    throw Error(
        "this majak was built without its viewer: install nodejs and npm and build it again");
  return {{"/", "text/html; charset=utf-8", page.html},
          {"/viewer.js", "text/javascript; charset=utf-8", page.script},
          {"/viewer.css", "text/css; charset=utf-8", page.style}};
}

serve::ServerOptions server_options(const ViewerOptions& options) {
  serve::ServerOptions server;
  server.address = options.address;
  server.port = static_cast<std::uint16_t>(options.port);
  server.token = options.token;
  return server;
}

}  // namespace

void add_viewer_options(CLI::App& command, ViewerOptions& options) {
  command.add_option("--address", options.address,
                     "page: where to listen (default: 127.0.0.1, this machine alone)");
  command.add_option("--port", options.port, "page: port (default: one that is free)")
      ->check(CLI::Range(0, 65535));
  command.add_option(
      "--token", options.token,
      "page: what others have to know (default: made by chance if others can connect)");
}

Viewer::Viewer(const ViewerOptions& options)
    : hub_(io::view_head()),
      worker_([this] { work(); }),
      server_(server_options(options), page_assets(), hub_,
              [this](serve::Command command, serve::Reply reply) {
                const std::lock_guard lock(queue_mutex_);
                queue_.emplace_back(std::move(command), std::move(reply));
                arrived_.notify_one();
              }) {
  fmt::print("view:    {}\n", server_.url());
  std::fflush(stdout);
}

Viewer::~Viewer() {
  {
    const std::lock_guard lock(queue_mutex_);
    ended_ = true;
    queue_.clear();
  }
  arrived_.notify_one();
  worker_.join();
}

void Viewer::set_doer(Doer doer) {
  const std::lock_guard lock(doing_);
  doer_ = std::move(doer);
}

void Viewer::work() {
  while (true) {
    std::unique_lock lock(queue_mutex_);
    arrived_.wait(lock, [&] { return ended_ || !queue_.empty(); });
    if (ended_) return;
    const auto [command, reply] = std::move(queue_.front());
    queue_.pop_front();
    lock.unlock();
    answer(command, reply);
  }
}

void Viewer::answer(const serve::Command& command, const serve::Reply& reply) {
  const std::lock_guard lock(doing_);
  if (!doer_) return reply(false, "nothing can be changed now");
  try {
    doer_(command);
    reply(true);
  } catch (const std::exception& e) {
    reply(false, e.what());
  }
}

void Viewer::wait() {
  const RunEnd end(0);
  fmt::print("Ctrl-C ends it\n");
  std::fflush(stdout);
  while (!end.reached()) std::this_thread::sleep_for(std::chrono::milliseconds(100));
}

}  // namespace majak::app
