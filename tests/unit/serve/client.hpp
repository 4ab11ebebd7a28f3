// SPDX-License-Identifier: Apache-2.0
// A client by hand, on plain sockets: it blocks, and it can say what no library would.
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

namespace majak::serve::test {

/// Bytes to and from 127.0.0.1.
class Client {
 public:
  explicit Client(std::uint16_t port, int receive_buffer = 0)
      : port_(port), fd_(::socket(AF_INET, SOCK_STREAM, 0)) {
    if (receive_buffer > 0)
      ::setsockopt(fd_, SOL_SOCKET, SO_RCVBUF, &receive_buffer, sizeof receive_buffer);
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(port);
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    connected_ = ::connect(fd_, reinterpret_cast<sockaddr*>(&to), sizeof to) == 0;
  }
  ~Client() { close(); }
  Client(Client&& other) noexcept
      : port_(other.port_),
        fd_(std::exchange(other.fd_, -1)),
        connected_(other.connected_),
        rest_(std::move(other.rest_)) {}
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  bool connected() const { return connected_; }
  void close() {
    if (fd_ >= 0) ::close(fd_);
    fd_ = -1;
  }
  /// False when the other side has closed.
  bool send(std::string_view bytes) const {
    while (!bytes.empty()) {
      const ssize_t n = ::send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (n <= 0) return false;
      bytes.remove_prefix(static_cast<std::size_t>(n));
    }
    return true;
  }
  /// What is there at once or within the time; empty: nothing came, or closed().
  std::string some(int milliseconds = 5000) {
    if (!rest_.empty()) return std::exchange(rest_, {});
    pollfd p{fd_, POLLIN, 0};
    if (::poll(&p, 1, milliseconds) <= 0) return {};
    std::string bytes(65536, '\0');
    const ssize_t n = ::recv(fd_, bytes.data(), bytes.size(), 0);
    closed_ = n <= 0;
    bytes.resize(n > 0 ? static_cast<std::size_t>(n) : 0);
    return bytes;
  }
  bool closed() const { return closed_; }
  /// Waits until the other side closes; false if it does not.
  bool wait_closed(int milliseconds = 5000) {
    while (!closed_)
      if (some(milliseconds).empty() && !closed_) return false;
    return true;
  }

  // ---- HTTP ----

  struct Response {
    int status = 0;
    std::string head, body;
  };
  std::string host() const { return "127.0.0.1:" + std::to_string(port_); }
  Response get(const std::string& target, const std::string& method = "GET",
               const std::string& more = {}) {
    send(method + " " + target + " HTTP/1.1\r\nHost: " + host() + "\r\n" + more + "\r\n");
    return response(method == "HEAD");
  }
  Response response(bool head_only = false) {
    Response r;
    std::string bytes;
    std::size_t end;
    while ((end = bytes.find("\r\n\r\n")) == bytes.npos) {
      const std::string more = some();
      if (more.empty()) return r;
      bytes += more;
    }
    r.head = bytes.substr(0, end + 2);
    r.status = std::stoi(bytes.substr(9, 3));
    rest_ = bytes.substr(end + 4);
    const std::size_t length = r.head.find("Content-Length: ");
    if (head_only || length == r.head.npos) return r;
    const std::size_t size = std::stoul(r.head.substr(length + 16));
    while (r.body.size() < size) {
      const std::string more = some();
      if (more.empty()) return r;
      r.body += more;
    }
    rest_ = r.body.substr(size);
    r.body.resize(size);
    return r;
  }

  // ---- WebSocket ----

  /// The status of the answer; 101: the stream is open.
  int open(const std::string& target = "/stream", const std::string& headers = {}) {
    const std::string own = "Host: " + host() + "\r\nOrigin: http://" + host() + "\r\n";
    send("GET " + target + " HTTP/1.1\r\n" + (headers.empty() ? own : headers) +
         "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Key: "
         "dGhlIHNhbXBsZSBub25jZQ==\r\n"
         "Sec-WebSocket-Version: 13\r\n\r\n");
    const Response r = response();
    // RFC 6455, section 1.3
    if (r.status == 101 && r.head.find("s3pPLMBiTxaQ9kYGzzhZRbK+xOo=") == r.head.npos) return -1;
    return r.status;
  }

  static std::string frame(int first_byte, std::string_view payload, bool masked = true) {
    std::string f(1, static_cast<char>(first_byte));
    const int mask = masked ? 0x80 : 0;
    if (payload.size() < 126) {
      f += static_cast<char>(mask | static_cast<int>(payload.size()));
    } else {
      const int bytes = payload.size() < 65536 ? 2 : 8;
      f += static_cast<char>(mask | (bytes == 2 ? 126 : 127));
      for (int i = bytes - 1; i >= 0; --i) f += static_cast<char>(payload.size() >> (8 * i));
    }
    if (!masked) return f.append(payload);
    const std::string_view key = "\x12\x34\x56\x78";
    f += key;
    for (std::size_t i = 0; i < payload.size(); ++i)
      f += static_cast<char>(payload[i] ^ key[i % 4]);
    return f;
  }
  bool say(std::string_view text) const { return send(frame(0x81, text)); }

  /// A whole message: the opcode of its first frame (1 text, 2 binary, 8 close); 0: none came, -1:
  /// closed.
  struct Message {
    int opcode = 0;
    std::string bytes;
    int code() const {  ///< of a close frame
      return bytes.size() < 2 ? 0
                              : (static_cast<unsigned char>(bytes[0]) << 8) |
                                    static_cast<unsigned char>(bytes[1]);
    }
  };
  Message message(int milliseconds = 5000) {
    Message m;
    for (bool last = false; !last;) {
      std::string head = exactly(2, milliseconds);
      if (head.size() < 2) return {closed_ ? -1 : 0, {}};
      last = head[0] & 0x80;
      if (head[0] & 0x0f) m.opcode = head[0] & 0x0f;
      std::size_t size = static_cast<unsigned char>(head[1]);
      if (size >= 126) {
        const std::string length = exactly(size == 126 ? 2 : 8, milliseconds);
        size = 0;
        for (const char c : length) size = size << 8 | static_cast<unsigned char>(c);
      }
      m.bytes += exactly(size, milliseconds);
    }
    return m;
  }

 private:
  std::string exactly(std::size_t size, int milliseconds) {
    std::string bytes = std::exchange(rest_, {});
    while (bytes.size() < size) {
      const std::string more = some(milliseconds);
      if (more.empty()) return bytes;
      bytes += more;
    }
    rest_ = bytes.substr(size);
    bytes.resize(size);
    return bytes;
  }

  std::uint16_t port_;
  int fd_;
  bool connected_ = false, closed_ = false;
  std::string rest_;
};

}  // namespace majak::serve::test
