// SPDX-License-Identifier: Apache-2.0
#include "majak/methods/methods.hpp"

#include <algorithm>
#include <string>

#include "majak/core/error.hpp"

namespace majak::methods {
namespace {

const Method kMethods[] = {
    {"dead-reckoning", "dead reckoning, p. 15", "odometry, or wheel speed and steering",
     "trajectory with growing covariance",
     [](const LocalizeOptions& o) { return localize::dead_reckoning(o.dead_reckoning, o.start); }},
};

}  // namespace

void describe(OptionFields& fields, LocalizeOptions& o) {
  fields.add("start.x", o.start.x, {"m", "where the robot is at first"});
  fields.add("start.y", o.start.y, {"m", "where the robot is at first"});
  fields.add("start.theta", o.start.theta, {"rad", "its heading, counter-clockwise from x"});
  localize::describe(fields, o.dead_reckoning);
  motion::describe(fields, o.drive);
}

std::span<const Method> methods() { return kMethods; }

const Method& method(std::string_view name) {
  const auto found = std::find_if(std::begin(kMethods), std::end(kMethods),
                                  [&](const Method& m) { return m.name == name; });
  if (found != std::end(kMethods)) return *found;
  std::string names;
  for (const Method& m : kMethods) names += std::string(names.empty() ? "" : ", ") + m.name;
  throw Error("no method " + std::string(name) + "; there are: " + names);
}

}  // namespace majak::methods
