// SPDX-License-Identifier: Apache-2.0
// The only file that sees Boost. Everything here but the constructor, statistics() and replies runs
// on the server's thread, so nothing but them is locked.
#include "majak/serve/server.hpp"

#include <signal.h>
#include <sys/random.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <deque>
#include <limits>
#include <mutex>
#include <optional>
#include <thread>
#include <unordered_set>
#include <utility>

#define BOOST_BEAST_USE_STD_STRING_VIEW
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/host_name.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <boost/beast/websocket/stream.hpp>

#include "majak/core/error.hpp"

namespace majak::serve {

namespace net = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using boost::system::error_code;
using net::ip::tcp;

namespace {

constexpr int kTicksPerSecond = 4;
constexpr std::size_t kMaxHeader = 8192, kMaxTarget = 2048;  // bytes
constexpr std::size_t kFragment = 65536 - 10;  // what one call sends, less the frame's head
constexpr std::size_t kMaxReplies = 1024;      // that wait for one client

int ticks(double seconds) {
  return std::max(1, static_cast<int>(std::min(seconds, 1e6) * kTicksPerSecond));
}

// ---- who may ------------------------------------------------------------------------------------

bool plain_token(std::string_view token) {
  return token.size() <= 256 && std::all_of(token.begin(), token.end(), [](char c) {
           return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                  c == '-' || c == '_';
         });
}

std::string random_token() {
  std::array<unsigned char, 16> bytes{};
  if (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
    throw Error("the system has no random numbers for a token; say one");
  std::string token;
  for (const unsigned char b : bytes) {
    token += "0123456789abcdef"[b >> 4];
    token += "0123456789abcdef"[b & 15];
  }
  return token;
}

/// In a time that does not tell where they differ.
bool equal(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  volatile unsigned char difference = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    difference = static_cast<unsigned char>(difference | (a[i] ^ b[i]));
  return difference == 0;
}

/// Whether a Host header names this machine by itself. A page of a foreign name that was made to
/// point here (DNS rebinding) still says its own. The port may be another one: that of a tunnel.
bool names_loopback(std::string_view host, const std::string& bound) {
  const std::size_t end = host.rfind(']');
  const std::size_t colon = host.find(':', end == std::string_view::npos ? 0 : end);
  const std::string_view name = host.substr(0, colon);
  if (colon != std::string_view::npos) {
    const std::string_view port = host.substr(colon + 1);
    if (port.empty() || port.size() > 5 || port.find_first_not_of("0123456789") != port.npos)
      return false;
  }
  return name == "127.0.0.1" || name == "localhost" || name == "[::1]" || name == bound;
}

std::string_view query_value(std::string_view query, std::string_view name) {
  while (!query.empty()) {
    const std::string_view pair = query.substr(0, query.find('&'));
    query.remove_prefix(std::min(query.size(), pair.size() + 1));
    if (pair.size() > name.size() && pair.substr(0, name.size()) == name &&
        pair[name.size()] == '=')
      return pair.substr(name.size() + 1);
  }
  return {};
}

std::string_view reason(int status) {
  switch (status) {
    case 200:
      return "OK";
    case 400:
      return "Bad Request";
    case 403:
      return "Forbidden";
    case 404:
      return "Not Found";
    case 405:
      return "Method Not Allowed";
    case 413:
      return "Content Too Large";
    case 414:
      return "URI Too Long";
    case 426:
      return "Upgrade Required";
    case 431:
      return "Request Header Fields Too Large";
    default:
      return "Service Unavailable";
  }
}

std::string bracketed(const net::ip::address& address) {
  return address.is_v6() ? "[" + address.to_string() + "]" : address.to_string();
}

/// Through which other threads reach the server's, as long as there is one.
struct Link {
  std::mutex mutex;
  net::io_context* io = nullptr;
};

class Connection;

}  // namespace

// ---- replies ------------------------------------------------------------------------------------

struct Reply::State {
  explicit State(std::function<void(bool, std::string)> to) : send(std::move(to)) {}
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  ~State() {
    try {
      answer(false, "the program did not answer");
    } catch (const std::exception&) {  // out of memory: the client will not hear of it
    }
  }
  void answer(bool ok, std::string error) {
    if (!done.test_and_set()) send(ok, std::move(error));
  }

  std::function<void(bool, std::string)> send;
  std::atomic_flag done{};
};

void Reply::operator()(bool ok, std::string error) const { state_->answer(ok, std::move(error)); }

// ---- the server's state -------------------------------------------------------------------------

struct Server::Impl {
  Impl(ServerOptions o, std::vector<Asset> a, Hub& h, OnCommand c)
      : options(std::move(o)), assets(std::move(a)), hub(h), on_command(std::move(c)) {}

  void listen();
  void start();
  void stop();
  void run();
  void accept();
  void accepted(tcp::socket socket);
  void arm();
  void tick();
  void wake();
  void pump_all();
  template <typename Change>
  void count(Change change) {
    const std::lock_guard lock(statistics_mutex);
    change(statistics);
  }

  ServerOptions options;
  const std::vector<Asset> assets;
  Hub& hub;
  const OnCommand on_command;
  bool loopback = true;
  std::string bound, url;
  std::uint16_t port = 0;

  std::mutex statistics_mutex;
  ServerStatistics statistics;
  std::shared_ptr<Link> link = std::make_shared<Link>();
  std::unordered_set<Connection*> connections;
  bool armed = false, accept_failed = false;
  std::atomic<bool> woken{false};
  net::io_context io{1};  // after what its handlers use
  tcp::acceptor acceptor{io};
  net::steady_timer timer{io};
  std::uint64_t watch = 0;
  std::thread thread;
};

// ---- one connection -----------------------------------------------------------------------------

namespace {

/// First HTTP, then, if it is asked to, the stream. Lives as long as something is under way on its
/// socket.
class Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(Server::Impl& server, tcp::socket socket) : server_(server), ws_(std::move(socket)) {
    server_.connections.insert(this);
    server_.count([](ServerStatistics& s) { ++s.connections, ++s.accepted; });
  }
  ~Connection() {
    server_.connections.erase(this);
    server_.count([this](ServerStatistics& s) { --s.connections, s.clients -= counted_; });
  }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  void read_request();
  void pump();
  void tick();

 private:
  using Request = http::request<http::empty_body>;
  tcp::socket& socket() { return ws_.next_layer(); }

  void on_request(error_code ec);
  int permitted(const Request& request) const;
  void serve_asset(const Request& request, std::string_view path);
  void respond(int status, const Asset* asset, bool head, bool keep);
  void drain();

  void upgrade(const Request& request, std::string_view query);
  void on_upgraded(error_code ec);
  void read_command();
  void on_read(error_code ec);
  void command(std::string_view text);
  Reply reply_to(std::optional<std::int64_t> id);
  void reply(std::optional<std::int64_t> id, bool ok, std::string_view error);
  void write_fragment();
  void on_written(error_code ec);
  void close(websocket::close_code code);
  void cut();

  Server::Impl& server_;
  websocket::stream<tcp::socket, false> ws_;
  beast::flat_buffer buffer_{kMaxHeader + kMaxCommandBytes};
  std::optional<http::request_parser<http::empty_body>> parser_;
  std::string head_;
  std::array<char, 512> dropped_{};

  int countdown_ = 0;  ///< ticks until the connection is cut; 0 never
  bool counted_ = false, streaming_ = false, writing_ = false;
  Cursor cursor_;
  Frame frame_;
  std::size_t piece_ = 0, offset_ = 0;  ///< of the frame, where the next fragment begins
  int waiting_ = 0;                     ///< ticks since the client took something
  std::deque<std::string> replies_;
  std::size_t pending_ = 0;
  double tokens_ = 0;  ///< commands that are allowed now; below 0 they are refused
};

void Connection::cut() {
  error_code ignored;
  socket().close(ignored);
}

void Connection::tick() {
  if (countdown_ > 0 && --countdown_ == 0) return cut();
  if (!streaming_) return;
  const double rate = server_.options.commands_per_second;
  tokens_ = std::min(rate, tokens_ + rate / kTicksPerSecond);
  if (!writing_ || ++waiting_ < ticks(server_.options.stalled_seconds)) return;
  streaming_ = false;
  server_.count([](ServerStatistics& s) { ++s.stalled; });
  cut();
}

// ---- HTTP ---------------------------------------------------------------------------------------

void Connection::read_request() {
  parser_.emplace();
  parser_->header_limit(kMaxHeader);
  parser_->body_limit(0);
  countdown_ = ticks(server_.options.idle_seconds);
  http::async_read_header(
      socket(), buffer_, *parser_,
      [self = shared_from_this()](error_code ec, std::size_t) { self->on_request(ec); });
}

void Connection::on_request(error_code ec) {
  if (ec == http::error::header_limit || ec == http::error::buffer_overflow)
    return respond(431, nullptr, false, false);
  if (ec == http::error::body_limit) return respond(413, nullptr, false, false);
  if (ec && ec.category() == http::make_error_code(http::error::bad_version).category() &&
      ec != http::error::end_of_stream && ec != http::error::partial_message)
    return respond(400, nullptr, false, false);
  if (ec) return cut();
  const Request& request = parser_->get();
  const std::string_view target(request.target().data(), request.target().size());
  const std::size_t mark = std::min(target.find('?'), target.size());
  const std::string_view path = target.substr(0, mark),
                         query = target.substr(std::min(mark + 1, target.size()));
  if (target.size() > kMaxTarget) return respond(414, nullptr, false, false);
  if (!parser_->is_done()) return respond(413, nullptr, false, false);
  if (const int refusal = permitted(request)) return respond(refusal, nullptr, false, false);
  if (path == "/stream") return upgrade(request, query);
  serve_asset(request, path);
}

/// 0, or why not.
int Connection::permitted(const Request& request) const {
  if (request.count(http::field::host) != 1) return 400;
  if (server_.loopback && !names_loopback(request[http::field::host], server_.bound)) return 403;
  return 0;
}

void Connection::serve_asset(const Request& request, std::string_view path) {
  const bool head = request.method() == http::verb::head;
  if (!head && request.method() != http::verb::get) return respond(405, nullptr, false, false);
  const auto asset = std::find_if(server_.assets.begin(), server_.assets.end(),
                                  [&](const Asset& a) { return a.path == path; });
  if (asset == server_.assets.end()) return respond(404, nullptr, head, request.keep_alive());
  respond(200, &*asset, head, request.keep_alive());
}

void Connection::respond(int status, const Asset* asset, bool head, bool keep) {
  const std::string_view text = asset ? asset->bytes : reason(status);
  head_ = "HTTP/1.1 " + std::to_string(status) + " " + std::string(reason(status)) +
          "\r\nServer: majak\r\nContent-Type: " + (asset ? asset->content_type : "text/plain") +
          "\r\nContent-Length: " + std::to_string(text.size()) +
          "\r\nContent-Security-Policy: " + server_.options.content_security_policy +
          "\r\nX-Content-Type-Options: nosniff\r\nX-Frame-Options: DENY"
          "\r\nReferrer-Policy: no-referrer\r\nCross-Origin-Opener-Policy: same-origin"
          "\r\nCross-Origin-Resource-Policy: same-origin\r\nCache-Control: no-store" +
          (status == 405 ? "\r\nAllow: GET, HEAD" : "") +
          (status == 426 ? "\r\nUpgrade: websocket" : "") +
          (keep ? "\r\n\r\n" : "\r\nConnection: close\r\n\r\n");
  countdown_ = ticks(server_.options.stalled_seconds);
  const std::array<net::const_buffer, 2> message = {
      net::buffer(head_), net::const_buffer(text.data(), head ? 0 : text.size())};
  net::async_write(socket(), message,
                   [self = shared_from_this(), keep](error_code ec, std::size_t) {
                     if (ec) return self->cut();
                     keep ? self->read_request() : self->drain();
                   });
}

/// To close with bytes unread would take the answer away from the client.
void Connection::drain() {
  error_code ignored;
  if (countdown_ > kTicksPerSecond || countdown_ == 0) {
    countdown_ = kTicksPerSecond;
    socket().shutdown(tcp::socket::shutdown_send, ignored);
  }
  socket().async_read_some(net::buffer(dropped_),
                           [self = shared_from_this()](error_code ec, std::size_t) {
                             ec ? self->cut() : self->drain();
                           });
}

// ---- the stream: from the client ----------------------------------------------------------------

/// Only a page that came from here may open it: browsers say the page's origin and the host, and a
/// page cannot change what they say.
void Connection::upgrade(const Request& request, std::string_view query) {
  if (request.method() != http::verb::get) return respond(405, nullptr, false, false);
  const std::string origin = "http://" + std::string(request[http::field::host]);
  const bool ours =
      request.count(http::field::origin) == 1 && request[http::field::origin] == origin;
  const std::string& token = server_.options.token;
  if (!ours || (!token.empty() && !equal(query_value(query, "token"), token))) {
    server_.count([](ServerStatistics& s) { ++s.denied; });
    return respond(403, nullptr, false, false);
  }
  if (!websocket::is_upgrade(request)) return respond(426, nullptr, false, false);
  websocket::stream_base::timeout times{};
  times.handshake_timeout = std::chrono::milliseconds(
      static_cast<int>(1000 * std::min(server_.options.idle_seconds, 1e5)));
  times.idle_timeout = websocket::stream_base::none();
  times.keep_alive_pings = false;
  ws_.set_option(times);
  ws_.set_option(websocket::stream_base::decorator(
      [](websocket::response_type& response) { response.set(http::field::server, "majak"); }));
  ws_.auto_fragment(false);
  ws_.read_message_max(kMaxCommandBytes);
  ws_.async_accept(request, [self = shared_from_this()](error_code ec) { self->on_upgraded(ec); });
}

void Connection::on_upgraded(error_code ec) {
  if (ec) return cut();
  parser_.reset();
  buffer_.clear();  // a client that speaks before it is answered does not speak WebSocket
  countdown_ = 0;
  tokens_ = server_.options.commands_per_second;
  streaming_ = counted_ = true;
  server_.count([](ServerStatistics& s) { ++s.clients; });
  read_command();
  pump();
}

void Connection::read_command() {
  ws_.async_read(buffer_,
                 [self = shared_from_this()](error_code ec, std::size_t) { self->on_read(ec); });
}

void Connection::on_read(error_code ec) {
  if (ec) {
    streaming_ = false;
    return cut();
  }
  if (!ws_.got_text()) return close(websocket::close_code::unknown_data);
  const auto bytes = buffer_.cdata();
  const std::string text(static_cast<const char*>(bytes.data()), bytes.size());
  buffer_.clear();
  buffer_.shrink_to_fit();
  command(text);
  if (streaming_) read_command();
}

void Connection::command(std::string_view text) {
  const ServerOptions& options = server_.options;
  serve::Request request = parse_request(text);
  tokens_ -= 1;
  if (tokens_ < -4 * options.commands_per_second) return close(websocket::close_code::policy_error);
  if (tokens_ < 0) request.error = "too many commands a second";
  if (pending_ >= options.pending_commands)
    request.error = "too many commands wait for their replies";
  if (!server_.on_command) request.error = "this server takes no commands";
  server_.count([&](ServerStatistics& s) { ++(request.error.empty() ? s.commands : s.refused); });
  if (!request.error.empty()) return reply(request.id, false, request.error);
  ++pending_;
  const Reply answer = reply_to(request.id);
  try {
    server_.on_command(std::move(*request.command), answer);
  } catch (const std::exception& e) {
    answer(false, e.what());
  }
}

Reply Connection::reply_to(std::optional<std::int64_t> id) {
  return Reply(std::make_shared<Reply::State>(
      [link = server_.link, client = weak_from_this(), id](bool ok, std::string error) {
        const std::lock_guard lock(link->mutex);
        if (!link->io) return;
        net::post(*link->io, [client, id, ok, error = std::move(error)] {
          const auto self = client.lock();
          if (!self) return;
          --self->pending_;
          self->reply(id, ok, error);
        });
      }));
}

void Connection::reply(std::optional<std::int64_t> id, bool ok, std::string_view error) {
  if (!streaming_) return;
  if (replies_.size() >= kMaxReplies) {
    streaming_ = false;
    return cut();
  }
  replies_.push_back(reply_text(id, ok, error));
  pump();
}

void Connection::close(websocket::close_code code) {
  streaming_ = false;
  countdown_ = 2 * kTicksPerSecond;
  ws_.async_close(code, [self = shared_from_this()](error_code) { self->cut(); });
}

// ---- the stream: to the client ------------------------------------------------------------------

/// At most one message is under way; the next is looked for when it has gone.
void Connection::pump() {
  if (!streaming_ || writing_) return;
  if (!replies_.empty()) {
    auto text = std::make_shared<const std::string>(std::move(replies_.front()));
    replies_.pop_front();
    frame_ = {{text}, text->size(), 0};
    ws_.text(true);
  } else {
    frame_ = server_.hub.next(cursor_);
    ws_.binary(true);
  }
  if (frame_.empty()) return;
  server_.count([&](ServerStatistics& s) {
    s.skipped += frame_.skipped;
    s.most_waiting = std::max(s.most_waiting, frame_.bytes);
  });
  writing_ = true;
  waiting_ = 0;
  piece_ = offset_ = 0;
  write_fragment();
}

/// In fragments, so that one sees whether the client still takes something.
void Connection::write_fragment() {
  const std::string& piece = *frame_.pieces[piece_];
  const std::size_t size = std::min(kFragment, piece.size() - offset_);
  const net::const_buffer bytes(piece.data() + offset_, size);
  offset_ += size;
  if (offset_ == piece.size()) {
    ++piece_;
    offset_ = 0;
  }
  ws_.async_write_some(
      piece_ == frame_.pieces.size(), bytes,
      [self = shared_from_this()](error_code ec, std::size_t) { self->on_written(ec); });
}

void Connection::on_written(error_code ec) {
  if (ec) {  // what reads finds out as well, and ends the connection; else the countdown does
    streaming_ = false;
    if (countdown_ == 0) countdown_ = 2 * kTicksPerSecond;
    return;
  }
  waiting_ = 0;
  if (piece_ < frame_.pieces.size()) return write_fragment();
  server_.count([&](ServerStatistics& s) { ++s.frames, s.bytes += frame_.bytes; });
  frame_ = {};
  writing_ = false;
  pump();
}

}  // namespace

// ---- the server ---------------------------------------------------------------------------------

void Server::Impl::listen() {
  error_code ec;
  const std::string numeric = options.address == "localhost" ? "127.0.0.1" : options.address;
  const net::ip::address address = net::ip::make_address(numeric, ec);
  if (ec)
    throw Error("\"" + options.address +
                "\" is no address; say one as a number, 127.0.0.1 or 0.0.0.0");
  loopback = address.is_loopback();
  bound = bracketed(address);
  if (!plain_token(options.token))
    throw Error("a token has at most 256 letters, digits, '-' and '_'");
  if (!loopback && options.token.empty()) options.token = random_token();

  const tcp::endpoint endpoint(address, options.port);
  acceptor.open(endpoint.protocol(), ec);
  if (!ec) acceptor.set_option(tcp::acceptor::reuse_address(true), ec);
  if (!ec) acceptor.bind(endpoint, ec);
  if (!ec) acceptor.listen(net::socket_base::max_listen_connections, ec);
  const std::string place = "port " + std::to_string(options.port) + " of " + options.address;
  if (ec == net::error::address_in_use)
    throw Error(place + " is taken; choose another, or 0 for any that is free");
  if (ec) throw Error(place + " cannot be opened: " + ec.message());
  port = acceptor.local_endpoint().port();
  url = "http://" + (address.is_unspecified() ? net::ip::host_name() : bound) + ":" +
        std::to_string(port) + "/";
  if (!options.token.empty()) url += "?token=" + options.token;
}

void Server::Impl::start() {
  link->io = &io;
  accept();
  sigset_t all, before;
  sigfillset(&all);  // signals are the program's, not this thread's
  pthread_sigmask(SIG_SETMASK, &all, &before);
  thread = std::thread([this] { run(); });
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  watch = hub.watch([this] { wake(); });
}

void Server::Impl::stop() {
  hub.unwatch(watch);
  {
    const std::lock_guard lock(link->mutex);
    link->io = nullptr;
  }
  io.stop();
  thread.join();
}

/// An exception ends what threw it; its connection goes with its handler.
void Server::Impl::run() {
  for (;;) {
    try {
      io.run();
      return;
    } catch (const std::exception&) {
      count([](ServerStatistics& s) { ++s.faults; });
    }
  }
}

void Server::Impl::accept() {
  acceptor.async_accept([this](error_code ec, tcp::socket socket) {
    if (ec == net::error::operation_aborted) return;
    if (ec) {  // no more descriptors, most likely: try again at the next tick
      accept_failed = true;
      return arm();
    }
    accept();
    accepted(std::move(socket));
  });
}

void Server::Impl::accepted(tcp::socket socket) {
  error_code ignored;
  if (connections.size() >= options.connections) {
    count([](ServerStatistics& s) { ++s.denied; });
    static constexpr std::string_view kFull =
        "HTTP/1.1 503 Service Unavailable\r\nContent-Length: 0\r\nConnection: close\r\n\r\n";
    socket.non_blocking(true, ignored);
    socket.write_some(net::buffer(kFull), ignored);
    return;
  }
  socket.set_option(tcp::no_delay(true), ignored);
  socket.set_option(net::socket_base::keep_alive(true), ignored);
  socket.set_option(net::socket_base::send_buffer_size(static_cast<int>(std::min(
                        options.send_buffer, std::size_t{std::numeric_limits<int>::max()}))),
                    ignored);
  std::make_shared<Connection>(*this, std::move(socket))->read_request();
  arm();
}

/// One timer for all, and none when nobody is connected.
void Server::Impl::arm() {
  if (std::exchange(armed, true)) return;
  timer.expires_after(std::chrono::milliseconds(1000 / kTicksPerSecond));
  timer.async_wait([this](error_code ec) {
    armed = false;
    if (!ec) tick();
  });
}

void Server::Impl::tick() {
  for (Connection* connection : connections) connection->tick();
  if (std::exchange(accept_failed, false)) accept();
  if (!connections.empty()) arm();
}

void Server::Impl::wake() {
  if (!woken.exchange(true)) net::post(io, [this] { pump_all(); });
}

void Server::Impl::pump_all() {
  woken = false;
  for (Connection* connection : connections) connection->pump();
}

Server::Server(ServerOptions options, std::vector<Asset> assets, Hub& hub, OnCommand on_command)
    : impl_(std::make_unique<Impl>(std::move(options), std::move(assets), hub,
                                   std::move(on_command))) {
  impl_->listen();
  impl_->start();
}

Server::~Server() { impl_->stop(); }

const std::string& Server::url() const { return impl_->url; }
std::uint16_t Server::port() const { return impl_->port; }

ServerStatistics Server::statistics() const {
  const std::lock_guard lock(impl_->statistics_mutex);
  return impl_->statistics;
}

}  // namespace majak::serve
