// SPDX-License-Identifier: Apache-2.0
#include "majak/io/ros_messages.hpp"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <limits>
#include <type_traits>

#include "majak/core/error.hpp"

namespace majak::io::ros {

namespace {

template <std::size_t Size>
using Bits = std::conditional_t<
    Size == 1, std::uint8_t,
    std::conditional_t<Size == 2, std::uint16_t,
                       std::conditional_t<Size == 4, std::uint32_t, std::uint64_t>>>;

template <class T>
constexpr bool kNumber = std::is_arithmetic_v<T>;

/// Bytes up to the next multiple of `size`; CDR counts from behind its four bytes of encapsulation.
constexpr std::size_t padding(std::size_t position, std::size_t size) {
  return (size - position % size) % size;
}

class Reader {
 public:
  static constexpr bool kReads = true;

  Reader(std::string_view bytes, Encoding encoding)
      : bytes_(bytes), aligned_(encoding == Encoding::cdr) {
    if (!aligned_) return;
    if (bytes_.size() < 4) throw Error("the message is shorter than its encapsulation");
    const bool plain = bytes_[0] == 0 && (bytes_[1] == 0 || bytes_[1] == 1);
    if (!plain) throw Error("the message is no plain CDR");
    big_endian_ = bytes_[1] == 0;
    bytes_.remove_prefix(4);
  }

  bool ros1() const { return !aligned_; }

  template <class T>
  requires kNumber<T>
  void operator()(T& value) {
    if (aligned_) at_ += padding(at_, sizeof(T));
    need(sizeof(T));
    Bits<sizeof(T)> bits = 0;
    for (std::size_t i = 0; i < sizeof(T); ++i) {
      const std::size_t shift = 8 * (big_endian_ ? sizeof(T) - 1 - i : i);
      bits |= static_cast<Bits<sizeof(T)>>(
          static_cast<Bits<sizeof(T)>>(static_cast<unsigned char>(bytes_[at_ + i])) << shift);
    }
    at_ += sizeof(T);
    value = std::bit_cast<T>(bits);
  }

  template <class T, std::size_t N>
  void operator()(std::array<T, N>& values) {
    for (T& value : values) (*this)(value);
  }

  void operator()(std::string& text) {
    std::uint32_t size = 0;
    (*this)(size);
    need(size);
    text.assign(bytes_.substr(at_, size));
    at_ += size;
    if (aligned_ && !text.empty() && text.back() == '\0') text.pop_back();
  }

  void operator()(std::vector<float>& values) {
    std::uint32_t count = 0;
    (*this)(count);
    if (count > (bytes_.size() - at_) / sizeof(float)) throw_short();
    values.resize(count);
    for (float& value : values) (*this)(value);
  }

  template <class Each>
  void list(std::vector<StampedTransform>& values, Each each) {
    std::uint32_t count = 0;
    (*this)(count);
    values.clear();
    for (std::uint32_t i = 0; i < count; ++i) each(values.emplace_back());
  }

  void stamp(Time& time) {
    std::uint32_t seconds = 0, nanoseconds = 0;
    (*this)(seconds);
    (*this)(nanoseconds);
    const std::int64_t whole =
        aligned_ ? static_cast<std::int64_t>(static_cast<std::int32_t>(seconds)) : seconds;
    time = whole * kSecond + nanoseconds;
  }

 private:
  [[noreturn]] static void throw_short() { throw Error("the message ends early"); }
  void need(std::size_t size) const {
    if (at_ > bytes_.size() || size > bytes_.size() - at_) throw_short();
  }

  std::string_view bytes_;
  std::size_t at_ = 0;
  bool aligned_;
  bool big_endian_ = false;
};

class Writer {
 public:
  static constexpr bool kReads = false;

  explicit Writer(Encoding encoding) : aligned_(encoding == Encoding::cdr) {
    if (aligned_) bytes_.assign("\0\1\0\0", kStart);
  }

  bool ros1() const { return !aligned_; }
  std::string take() { return std::move(bytes_); }

  template <class T>
  requires kNumber<T>
  void operator()(const T& value) {
    if (aligned_) bytes_.append(padding(bytes_.size() - kStart, sizeof(T)), '\0');
    const auto bits = std::bit_cast<Bits<sizeof(T)>>(value);
    for (std::size_t i = 0; i < sizeof(T); ++i)
      bytes_.push_back(static_cast<char>(static_cast<unsigned char>(bits >> (8 * i))));
  }

  template <class T, std::size_t N>
  void operator()(const std::array<T, N>& values) {
    for (const T& value : values) (*this)(value);
  }

  void operator()(const std::string& text) {
    (*this)(count_of(text.size() + (aligned_ ? 1 : 0)));
    bytes_ += text;
    if (aligned_) bytes_.push_back('\0');
  }

  void operator()(const std::vector<float>& values) {
    (*this)(count_of(values.size()));
    for (const float value : values) (*this)(value);
  }

  template <class Each>
  void list(const std::vector<StampedTransform>& values, Each each) {
    (*this)(count_of(values.size()));
    for (const StampedTransform& value : values) each(value);
  }

  void stamp(Time time) {
    Time seconds = time / kSecond, nanoseconds = time % kSecond;
    if (nanoseconds < 0) {
      --seconds;
      nanoseconds += kSecond;
    }
    const bool fits = aligned_ ? seconds == static_cast<std::int32_t>(seconds)
                               : seconds == static_cast<std::uint32_t>(seconds);
    if (!fits) throw Error("a stamp that ROS cannot write: it is too far from 1970");
    (*this)(static_cast<std::uint32_t>(seconds));
    (*this)(static_cast<std::uint32_t>(nanoseconds));
  }

 private:
  static constexpr std::size_t kStart = 4;  ///< bytes of encapsulation

  static std::uint32_t count_of(std::size_t size) {
    if (size > std::numeric_limits<std::uint32_t>::max())
      throw Error("a message longer than ROS can write");
    return static_cast<std::uint32_t>(size);
  }

  std::string bytes_;
  bool aligned_;
};

// ---- each message, once for reading and writing -------------------------------------------------

/// tf of old ROS 1 names frames with a leading slash.
template <class Wire, class M>
void frame(Wire& wire, M& name) {
  wire(name);
  if constexpr (Wire::kReads) name.erase(0, std::min(name.find_first_not_of('/'), name.size()));
}

template <class Wire, class M>
void header(Wire& wire, M& m) {
  if (wire.ros1()) wire(m.sequence);
  wire.stamp(m.stamp);
  frame(wire, m.frame);
}

template <class Wire, class M>
void transform(Wire& wire, M& m) {
  wire(m.translation);
  wire(m.rotation);
}

template <class Wire, class M>
requires std::is_same_v<std::remove_const_t<M>, LaserScan>
void fields(Wire& wire, M& m) {
  header(wire, m.header);
  wire(m.angle_min);
  wire(m.angle_max);
  wire(m.angle_increment);
  wire(m.time_increment);
  wire(m.scan_time);
  wire(m.range_min);
  wire(m.range_max);
  wire(m.ranges);
  wire(m.intensities);
}

template <class Wire, class M>
requires std::is_same_v<std::remove_const_t<M>, Odometry>
void fields(Wire& wire, M& m) {
  header(wire, m.header);
  frame(wire, m.child_frame);
  transform(wire, m.pose);
  wire(m.pose_covariance);
  wire(m.linear);
  wire(m.angular);
  wire(m.twist_covariance);
}

template <class Wire, class M>
requires std::is_same_v<std::remove_const_t<M>, TransformList>
void fields(Wire& wire, M& m) {
  wire.list(m.transforms, [&wire](auto& t) {
    header(wire, t.header);
    frame(wire, t.child_frame);
    transform(wire, t.transform);
  });
}

template <class Wire, class M>
requires std::is_same_v<std::remove_const_t<M>, NavSatFix>
void fields(Wire& wire, M& m) {
  header(wire, m.header);
  wire(m.status);
  wire(m.service);
  wire(m.latitude);
  wire(m.longitude);
  wire(m.altitude);
  wire(m.covariance);
  wire(m.covariance_type);
}

template <class Wire, class M>
requires std::is_same_v<std::remove_const_t<M>, AckermannDrive>
void fields(Wire& wire, M& m) {
  header(wire, m.header);
  wire(m.steering);
  wire(m.steering_rate);
  wire(m.speed);
  wire(m.acceleration);
  wire(m.jerk);
}

template <class M>
void read(std::string_view bytes, Encoding encoding, M& message) {
  Reader reader(bytes, encoding);
  fields(reader, message);
}

template <class M>
std::string written(const M& message, Encoding encoding) {
  Writer writer(encoding);
  fields(writer, message);
  return writer.take();
}

}  // namespace

void decode(std::string_view b, Encoding encoding, LaserScan& m) { read(b, encoding, m); }
void decode(std::string_view b, Encoding encoding, Odometry& m) { read(b, encoding, m); }
void decode(std::string_view b, Encoding encoding, TransformList& m) { read(b, encoding, m); }
void decode(std::string_view b, Encoding encoding, NavSatFix& m) { read(b, encoding, m); }
void decode(std::string_view b, Encoding encoding, AckermannDrive& m) { read(b, encoding, m); }

std::string encode(const LaserScan& m, Encoding encoding) { return written(m, encoding); }
std::string encode(const Odometry& m, Encoding encoding) { return written(m, encoding); }
std::string encode(const TransformList& m, Encoding encoding) { return written(m, encoding); }
std::string encode(const NavSatFix& m, Encoding encoding) { return written(m, encoding); }
std::string encode(const AckermannDrive& m, Encoding encoding) { return written(m, encoding); }

}  // namespace majak::io::ros
