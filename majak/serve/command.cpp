// SPDX-License-Identifier: Apache-2.0
#include "majak/serve/command.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>

#include "majak/core/error.hpp"

namespace majak::serve {
namespace {

using Json = nlohmann::json;

/// Text from outside, short and printable.
std::string shown(std::string_view text) {
  std::string out = "\"";
  for (const char c : text.substr(0, 32)) out += c >= 0x20 && c < 0x7f && c != '"' ? c : '?';
  return out + (text.size() > 32 ? "...\"" : "\"");
}

/// An object of which every field has to be asked for.
class Fields {
 public:
  Fields(const Json& object, std::string what) : object_(object), what_(std::move(what)) {
    if (!object.is_object()) throw Error(what_ + " is not an object");
  }

  /// Throws Error if there are others than these.
  void only(std::initializer_list<std::string_view> names) const {
    for (const auto& [name, value] : object_.items())
      if (std::find(names.begin(), names.end(), name) == names.end())
        throw Error(what_ + " has a field " + shown(name) + ", which does not belong there");
  }

  const Json& at(const char* name) const {
    const auto field = object_.find(name);
    if (field == object_.end()) throw Error(what_ + " has no field \"" + name + "\"");
    return *field;
  }

  std::string word(const char* name) const {
    const Json& value = at(name);
    const auto* text = value.get_ptr<const std::string*>();
    if (!text) fail(name, "is not a text");
    const bool plain = std::all_of(text->begin(), text->end(), [](char c) {
      return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
    });
    if (text->empty() || text->size() > 64 || !plain)
      fail(name, "is not a word of a-z, 0-9, _ and -");
    return *text;
  }

  std::uint32_t scan(const char* name) const {
    const Json& value = at(name);
    if (!value.is_number_unsigned() ||
        value.get<std::uint64_t>() > std::numeric_limits<std::uint32_t>::max())
      fail(name, "is not the number of a scan");
    return value.get<std::uint32_t>();
  }

  bool truth(const char* name) const {
    const Json& value = at(name);
    if (!value.is_boolean()) fail(name, "is neither true nor false");
    return value.get<bool>();
  }

  double number(const char* name, double limit) const { return number(at(name), name, limit); }

  /// [x, y, theta]
  Pose2 pose(const char* name) const {
    const auto v = numbers<3>(at(name), name, {kMaxCoordinate, kMaxCoordinate, kMaxRadians});
    return {v[0], v[1], wrap_angle(v[2])};
  }

  /// [[x, y], ...]
  std::vector<Vec2> points(const char* name, std::size_t least) const {
    const Json& list = at(name);
    if (!list.is_array() || list.size() < least || list.size() > kMaxPoints)
      fail(name, "is not a list of " + std::to_string(least) + " to " + std::to_string(kMaxPoints) +
                     " points");
    std::vector<Vec2> points;
    points.reserve(list.size());
    for (const Json& point : list) {
      const auto v = numbers<2>(point, name, {kMaxCoordinate, kMaxCoordinate});
      points.emplace_back(v[0], v[1]);
    }
    return points;
  }

 private:
  [[noreturn]] void fail(const char* name, const std::string& why) const {
    throw Error("\"" + std::string(name) + "\" of " + what_ + " " + why);
  }

  double number(const Json& value, const char* name, double limit) const {
    if (!value.is_number()) fail(name, "is not a number");
    const auto number = value.get<double>();
    if (!(std::abs(number) <= limit)) fail(name, "is too large");
    return number;
  }

  template <std::size_t N>
  std::array<double, N> numbers(const Json& list, const char* name,
                                const std::array<double, N>& limits) const {
    if (!list.is_array() || list.size() != N)
      fail(name, "has not " + std::to_string(N) + " numbers where it should");
    std::array<double, N> out{};
    for (std::size_t i = 0; i < N; ++i) out[i] = number(list[i], name, limits[i]);
    return out;
  }

  const Json& object_;
  std::string what_;
};

// ---- the commands -----------------------------------------------------------------------------

Edit edit_from(const Json& json) {
  const Fields fields(json, "the edit");
  const std::string kind = fields.word("kind");
  if (kind == "turn") {
    fields.only({"kind", "radians"});
    return {EditKind::turn, {}, fields.number("radians", kMaxRadians)};
  }
  if (kind == "upright") {
    fields.only({"kind"});
    return {EditKind::upright, {}, 0};
  }
  fields.only({"kind", "points"});
  if (kind == "wall") return {EditKind::wall, fields.points("points", 2), 0};
  if (kind == "erase") return {EditKind::erase, fields.points("points", 3), 0};
  if (kind == "forbidden") return {EditKind::forbidden, fields.points("points", 3), 0};
  if (kind == "crop") return {EditKind::crop, fields.points("points", 3), 0};
  throw Error("there is no edit " + shown(kind));
}

template <typename Plain>
Command plain(const Fields& fields) {
  fields.only({"id", "do"});
  return Plain{};
}

Command command_from(const Fields& fields) {
  const std::string name = fields.word("do");
  if (name == "switch_closure") {
    fields.only({"id", "do", "from", "to", "on"});
    return SwitchClosure{fields.scan("from"), fields.scan("to"), fields.truth("on")};
  }
  if (name == "edit") {
    fields.only({"id", "do", "edit"});
    return edit_from(fields.at("edit"));
  }
  if (name == "undo") return plain<Undo>(fields);
  if (name == "redo") return plain<Redo>(fields);
  if (name == "write_files") return plain<WriteFiles>(fields);
  if (name == "stop_localizing") return plain<StopLocalizing>(fields);
  if (name == "localize") {
    fields.only({"id", "do", "method"});
    return Localize{fields.word("method")};
  }
  if (name == "start_pose" || name == "kidnap") {
    fields.only({"id", "do", "pose"});
    const Pose2 pose = fields.pose("pose");
    return name == "kidnap" ? Command{Kidnap{pose}} : Command{StartPose{pose}};
  }
  throw Error("there is no command " + shown(name));
}

// ---- JSON -------------------------------------------------------------------------------------

/// No deeper than a command is, and no field twice: of two, programs disagree which one counts.
class Strictness {
 public:
  bool operator()(int depth, Json::parse_event_t event, const Json& parsed) {
    using Event = Json::parse_event_t;
    if (event == Event::object_start) names_.emplace_back();
    if (event == Event::object_end) names_.pop_back();
    if ((event == Event::object_start || event == Event::array_start) && depth > 3)
      throw Error("the command is nested too deep");
    if (event == Event::key && !names_.back().insert(parsed.get<std::string>()).second)
      throw Error("the command has the field " + shown(parsed.get<std::string>()) + " twice");
    return true;
  }

 private:
  std::vector<std::set<std::string>> names_;
};

Json parse(std::string_view text) {
  if (text.size() > kMaxCommandBytes) throw Error("the command is longer than 64 kB");
  if (const std::size_t nul = text.find('\0'); nul != text.npos)  // the parser would end there
    throw Error("the command is not JSON: byte " + std::to_string(nul + 1));
  Strictness strictness;
  try {
    return Json::parse(text, [&](int depth, Json::parse_event_t event, const Json& parsed) {
      return strictness(depth, event, parsed);
    });
  } catch (const Json::parse_error& e) {
    throw Error("the command is not JSON: byte " + std::to_string(e.byte));
  } catch (const Json::exception&) {  // a number beyond all doubles
    throw Error("the command has a number that is too large");
  }
}

/// An integer that every reader of JSON holds exactly.
std::optional<std::int64_t> id_from(const Json& json) {
  constexpr std::int64_t kLimit = std::int64_t{1} << 53;
  if (!json.is_object() || !json.contains("id")) return {};
  const Json& id = json["id"];
  const bool exact = id.is_number_unsigned()
                         ? id.get<std::uint64_t>() <= std::uint64_t{kLimit}
                         : id.is_number_integer() && id.get<std::int64_t>() >= -kLimit;
  if (!exact) throw Error("\"id\" of the command is not an integer of at most 53 bits");
  return id.get<std::int64_t>();
}

}  // namespace

Request parse_request(std::string_view text) {
  Request request;
  try {
    const Json json = parse(text);
    request.id = id_from(json);
    request.command = command_from(Fields(json, "the command"));
  } catch (const Error& error) {
    request.error = error.what();
  }
  return request;
}

std::string reply_text(std::optional<std::int64_t> id, bool ok, std::string_view error) {
  Json reply = {{"ok", ok}};
  if (id) reply["id"] = *id;
  if (!ok) reply["error"] = error;
  return reply.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace majak::serve
