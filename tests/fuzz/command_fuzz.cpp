// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdlib>

#include "majak/serve/command.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace {

using namespace majak::serve;

void require(bool condition) {
  if (!condition) std::abort();
}

bool inside(const majak::Pose2& p) {
  return std::abs(p.x) <= kMaxCoordinate && std::abs(p.y) <= kMaxCoordinate &&
         std::abs(p.theta) <= 3.1415926535897936;
}

void check(const Edit& edit) {
  const bool turns = edit.kind == EditKind::turn || edit.kind == EditKind::upright;
  const std::size_t least = turns ? 0 : edit.kind == EditKind::wall ? 2 : 3;
  require(edit.points.size() >= least && edit.points.size() <= (turns ? 0 : kMaxPoints));
  for (const majak::Vec2& p : edit.points) require(inside({p.x(), p.y(), 0}));
  require(std::abs(edit.radians) <= kMaxRadians);
}

}  // namespace

/// What comes through is in its limits, and nothing is thrown at all.
MAJAK_FUZZ(text) {
  const Request request = parse_request(text);
  require(request.command.has_value() == request.error.empty());
  require(request.error.size() < 200 && request.error.find('\n') == std::string::npos);
  reply_text(request.id, false, text);
  if (!request.command) return;
  if (const auto* edit = std::get_if<Edit>(&*request.command)) check(*edit);
  if (const auto* start = std::get_if<StartPose>(&*request.command)) require(inside(start->pose));
  if (const auto* kidnap = std::get_if<Kidnap>(&*request.command)) require(inside(kidnap->pose));
  if (const auto* localize = std::get_if<Localize>(&*request.command))
    require(!localize->method.empty() && localize->method.size() <= 64);
}
