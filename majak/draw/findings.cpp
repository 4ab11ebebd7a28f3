// SPDX-License-Identifier: Apache-2.0
#include "majak/draw/findings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "majak/core/angle.hpp"
#include "majak/draw/svg.hpp"

namespace majak::draw {

namespace {

constexpr double kSure = 2.0;  ///< sigmas from the nominal value before it is called different

/// As many decimals as the sigma deserves: its first digit, and 3 where it is not known.
std::string rounded(double value, double sigma) {
  const int decimals =
      sigma > 0 ? std::clamp(static_cast<int>(std::ceil(-std::log10(sigma))), 0, 4) : 3;
  return number(value, decimals);
}

std::string with_sigma(double value, double sigma, const char* unit) {
  return sigma > 0
             ? fmt::format("{}{} (±{}{})", rounded(value, sigma), unit, rounded(sigma, sigma), unit)
             : rounded(value, sigma) + unit;
}

bool differs(const Learnt& learnt, double nominal, double least) {
  return learnt.used && std::abs(learnt.value - nominal) > std::max(kSure * learnt.sigma, least);
}

const char* remedy(const Site& site) { return site.used_odometry ? "; this is corrected" : ""; }

void say_lag(const Site& site, std::vector<std::string>& out) {
  const OdometryFindings& o = site.odometry;
  if (!o.lag_s.used) {
    out.push_back("Whether the odometry comes early or late cannot be told from this log.");
  } else if (differs(o.lag_s, 0, 0.01)) {
    const double lag = o.lag_s.value;
    out.push_back(fmt::format("The odometry is {} {}{}.",
                              with_sigma(std::abs(lag), o.lag_s.sigma, " s"),
                              lag > 0 ? "late" : "early", remedy(site)));
  } else {
    out.push_back("Odometry and laser agree in time.");
  }
}

struct ScaleWords {
  const char *what, *few, *many;
};

void say_scale(const Site& site, const Learnt& scale, ScaleWords words,
               std::vector<std::string>& out) {
  if (!scale.used) {
    out.push_back(fmt::format("The scale of its {} cannot be told from this log.", words.what));
  } else if (differs(scale, 1, 0.002)) {
    // true = scale * odometry: above 1 the odometry counts too little.
    out.push_back(
        fmt::format("Its {} come out {} too {}{}.", words.what,
                    with_sigma(100 * std::abs(1 - 1 / scale.value), 100 * scale.sigma, " %"),
                    scale.value > 1 ? words.few : words.many, remedy(site)));
  } else {
    out.push_back(fmt::format("Its {} have the right scale.", words.what));
  }
}

void say_side(const Learnt& l, const char* verb, const char* unit, const char* positive,
              const char* negative, std::vector<std::string>& out) {
  if (!l.used) return;
  out.push_back(fmt::format("The laser {} {} {}.", verb,
                            with_sigma(std::abs(l.value), l.sigma, unit),
                            l.value >= 0 ? positive : negative));
}

void say_mounting(const OdometryFindings& o, std::vector<std::string>& out) {
  say_side(o.laser_x_m, "sits", " m", "ahead of the robot's centre", "behind the robot's centre",
           out);
  say_side(o.laser_y_m, "sits", " m", "left of the robot's centre", "right of the robot's centre",
           out);
  const Learnt& theta = o.laser_theta_rad;
  say_side({degrees(theta.value), degrees(theta.sigma), theta.used}, "looks", " degrees",
           "to the left", "to the right", out);
}

void say_noise(const OdometryFindings& o, std::vector<std::string>& out) {
  out.push_back(fmt::format(
      "So mended it errs by about {} cm after 1 m and {} cm after 10 m, and by {} degrees in a "
      "turn "
      "of 90 degrees.",
      number(100 * o.translation_noise, 1), number(100 * o.translation_noise * std::sqrt(10.0), 1),
      number(degrees(o.rotation_noise * std::sqrt(kPi / 2)), 1)));
}

}  // namespace

std::vector<std::string> odometry_in_words(const Site& site) {
  const OdometryFindings& o = site.odometry;
  const bool there = std::any_of(site.scans.begin(), site.scans.end(),
                                 [](const PosedScan& p) { return p.T_odom_robot.has_value(); });
  const bool told = o.lag_s.used || o.translation_scale.used || o.rotation_scale.used;
  std::vector<std::string> out;
  if (!site.used_odometry) {
    out.push_back(
        fmt::format("{}: the motion comes from the laser alone.",
                    there || told ? "The odometry was not used" : "No odometry was used"));
  } else if (!told) {
    out.push_back(
        "This log does not tell whether the odometry is late or wrong in scale; it is used as it "
        "stands.");
  }
  if (told) say_lag(site, out);
  if (o.reversed_records > 0) {
    out.push_back(fmt::format(
        "{} of its records state the wrong direction of travel (forward while the robot backs, "
        "or the other way round){}.",
        o.reversed_records, site.used_odometry ? "; they are turned round" : ""));
  }
  if (o.jumps > 0) {
    out.push_back(
        fmt::format("{} of its steps {} farther than a robot drives (counters that began "
                    "anew, as a rule){}.",
                    o.jumps, o.jumps == 1 ? "is" : "are",
                    site.used_odometry ? "; there the laser alone tells the motion" : ""));
  }
  if (told) {
    say_scale(site, o.translation_scale, {"distances", "short", "long"}, out);
    say_scale(site, o.rotation_scale, {"turns", "small", "large"}, out);
  }
  say_mounting(o, out);
  if (site.used_odometry && (o.translation_noise > 0 || o.rotation_noise > 0)) say_noise(o, out);
  return out;
}

std::string edits_in_words(const Site& site) {
  if (site.edits.empty()) return "";
  constexpr const char* kOne[kEditKinds] = {"erased area", "wall", "forbidden zone",
                                            "crop",        "turn", "closure switched off"};
  constexpr const char* kMany[kEditKinds] = {"erased areas", "walls", "forbidden zones",
                                             "crops",        "turns", "closures switched off"};
  std::string list;
  for (int kind = 0; kind < kEditKinds; ++kind) {
    const auto n = std::count_if(site.edits.begin(), site.edits.end(), [&](const Edit& edit) {
      return static_cast<int>(edit.kind) == kind;
    });
    if (n > 0)
      list +=
          fmt::format("{}{} {}", list.empty() ? "" : ", ", n, n == 1 ? kOne[kind] : kMany[kind]);
  }
  return fmt::format("{} by hand: {}.",
                     site.edits.size() == 1 ? "1 edit" : fmt::format("{} edits", site.edits.size()),
                     list);
}

std::string verdict_in_words(const Site& site, const io::Figures& f) {
  if (f.scans == 0) return "The log holds no scans, so there is no map.";
  if (f.scans == 1) return "The log holds a single scan: the map is what that scan saw.";
  const auto share = [&](std::size_t n) {
    return number(100.0 * static_cast<double>(n) / static_cast<double>(f.scans), 1);
  };
  std::string text;
  if (f.lost == 0 && f.degraded == 0) text = "Every scan fits the map.";
  if (f.lost > 0)
    text +=
        fmt::format("{} scans ({} %) do not fit the map and are not drawn.", f.lost, share(f.lost));
  if (f.degraded > 0) {
    text += fmt::format(
        "{}{} scans ({} %) saw too little in one direction (a bare corridor, say) and are held "
        "there "
        "by {}.",
        text.empty() ? "" : " ", f.degraded, share(f.degraded),
        site.used_odometry ? "the odometry" : "steady motion");
  }
  if (f.closures > 0) {
    text +=
        fmt::format(" {} {} tie{} places seen again together, and moved no pose by more than {} m.",
                    f.closures, f.closures == 1 ? "loop closure" : "loop closures",
                    f.closures == 1 ? "s" : "", number(f.front_end_shift_max_m, 2));
  } else {
    text += " No place was recognised again, so errors could only grow along the way.";
  }
  if (!site.edits.empty()) text += " " + edits_in_words(site);
  return text;
}

}  // namespace majak::draw
