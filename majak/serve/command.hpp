// SPDX-License-Identifier: Apache-2.0
// What a page may ask for: a JSON object as text, read strictly.
// {"id":1,"do":"switch_closure","from":12,"to":945,"on":false} docs/FORMATS.md lists them. Nothing
// here is believed: numbers are finite and in range, lists have limits, fields that do not belong
// there are refused.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "majak/core/pose2.hpp"

namespace majak::serve {

constexpr std::size_t kMaxCommandBytes = std::size_t{64} << 10;
constexpr std::size_t kMaxPoints = 1000;  ///< of one edit
constexpr double kMaxCoordinate = 1e6;    ///< m, either way
constexpr double kMaxRadians = 6.283185307179587;

/// The closure between two scans, by their numbers in the run.
struct SwitchClosure {
  std::uint32_t from = 0, to = 0;
  bool on = true;
  bool operator==(const SwitchClosure&) const = default;
};

enum class EditKind { erase, forbidden, crop, wall, turn, upright };

struct Edit {
  EditKind kind = EditKind::erase;
  std::vector<Vec2> points{};  ///< m, map frame; erase, forbidden, crop: polygon of 3 or more,
                               ///< wall: line of 2 or more, else none
  double radians = 0;          ///< of turn, counter-clockwise
  bool operator==(const Edit&) const = default;
};

struct Undo {
  bool operator==(const Undo&) const = default;
};
struct Redo {
  bool operator==(const Redo&) const = default;
};
struct WriteFiles {
  bool operator==(const WriteFiles&) const = default;
};

/// A simulated robot drives in the map and is localized.
struct Localize {
  std::string method;  ///< lower-case letters, digits and '-', at most 64; whether there is such a
                       ///< method is not looked at
  bool operator==(const Localize&) const = default;
};
struct StopLocalizing {
  bool operator==(const StopLocalizing&) const = default;
};

struct StartPose {
  Pose2 pose;  ///< map frame
  bool operator==(const StartPose&) const = default;
};
struct Kidnap {
  Pose2 pose;  ///< map frame
  bool operator==(const Kidnap&) const = default;
};

using Command = std::variant<SwitchClosure, Edit, Undo, Redo, WriteFiles, Localize, StopLocalizing,
                             StartPose, Kidnap>;

/// A command, or one sentence that says what is wrong with it. Where the id could be read it is
/// there in either case.
struct Request {
  std::optional<std::int64_t> id;
  std::optional<Command> command;
  std::string error;
};

/// Throws nothing but std::bad_alloc.
Request parse_request(std::string_view text);

/// {"id":1,"ok":true} or {"id":1,"ok":false,"error":"one sentence"}; without an id where there was
/// none.
std::string reply_text(std::optional<std::int64_t> id, bool ok, std::string_view error);

}  // namespace majak::serve
