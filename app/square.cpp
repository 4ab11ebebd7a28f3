// SPDX-License-Identifier: Apache-2.0
#include "app/square.hpp"

#include <fmt/core.h>

#include <cmath>

#include <nlohmann/json.hpp>
#include <vector>

#include "majak/core/error.hpp"
#include "majak/io/atomic_file.hpp"
#include "majak/io/byte_stream.hpp"
#include "majak/io/line_reader.hpp"
#include "majak/io/number.hpp"
#include "majak/io/options_file.hpp"
#include "majak/motion/umbmark.hpp"

namespace majak::app {
namespace {

std::vector<motion::SquareRun> read_runs(const std::string& path) {
  io::LineReader lines(io::open_bytes(path).bytes);
  std::vector<motion::SquareRun> runs;
  while (const auto line = lines.next()) {
    const std::string text(line->substr(0, line->find('#')));
    io::Fields fields(text);
    if (fields.at_end()) continue;
    const std::string way(fields.word());
    motion::SquareRun run;
    run.left = way == "left";
    if ((way != "left" && way != "right") || !fields.number(run.x) || !fields.number(run.y) ||
        !fields.at_end() || !std::isfinite(run.x) || !std::isfinite(run.y))
      throw Error(fmt::format(
          "{}:{}: a run is `left x y` or `right x y`: the true end less that of the odometry, m",
          path, lines.line()));
    runs.push_back(run);
  }
  return runs;
}

void print(const motion::Umbmark& u, bool with_track) {
  const auto line = [](const char* what, const Learnt& v, const char* unit, int digits) {
    fmt::print("  {:<34}{:.{}f} +- {:.{}f} {}\n", what, v.value, digits, v.sigma, digits, unit);
  };
  line("turn per turn of the wheels", u.turn_scale, "", 4);
  const Learnt& bend = u.turn_per_metre;
  line("turn per metre, unequal wheels", {degrees(bend.value), degrees(bend.sigma), bend.used},
       "degrees/m", 3);
  if (with_track) {
    line("right wheel over left one", u.wheel_ratio, "", 5);
    line("track", u.track, "m", 4);
  }
  fmt::print("  ends to the left {:.3f}, {:.3f} m, to the right {:.3f}, {:.3f} m off in the mean\n",
             u.centre_left.x(), u.centre_left.y(), u.centre_right.x(), u.centre_right.y());
  fmt::print("  systematic error of this odometry: {:.3f} m\n", u.systematic);
}

std::string json_of(const motion::Umbmark& u, bool with_track) {
  nlohmann::ordered_json json;
  const auto put = [&](const char* name, const Learnt& v) {
    json[name] = {{"value", v.value}, {"sigma", v.sigma}};
  };
  put("turn_scale", u.turn_scale);
  put("turn_per_metre", u.turn_per_metre);
  if (with_track) put("wheel_ratio", u.wheel_ratio), put("track_m", u.track);
  json["systematic_m"] = u.systematic;
  return json.dump(2) + "\n";
}

}  // namespace

void run_square(const SquareOptions& o) {
  const auto runs = read_runs(o.ends);
  motion::Umbmark u;
  try {
    u = motion::umbmark(runs, o.side, o.track);
  } catch (const Error& e) {
    throw Error(fmt::format("{}: {}", o.ends, e.what()));
  }
  if (!o.output.empty()) {
    OptionFields fields;
    motion::describe(fields, u.correction);
    io::write_file_atomically(o.output, io::options_toml(fields));
  }
  if (o.json)
    fmt::print("{}", json_of(u, o.track > 0));
  else
    print(u, o.track > 0);
  if (!o.output.empty() && !o.json) fmt::print("options: {}\n", o.output);
}

}  // namespace majak::app
