// SPDX-License-Identifier: Apache-2.0
// A method with wheels and satellites on the Victoria Park set, scored on fixes that were held out
// in whole bursts: nothing is aligned afterwards. Folds: every other burst is held out, the first
// and the last one never; one out: each burst by itself. Scored twice: on all fixes, and on those
// that data alone do not cast doubt on.
//   run_victoria_park FOLDER [--method kalman|kalman-laser|ekf-slam|landmark-graph] [NAME=VALUE]...
//                     [--one-out]
#include <fmt/core.h>

#include <algorithm>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include "majak/core/error.hpp"
#include "majak/eval/held_out_fixes.hpp"
#include "majak/eval/path_score.hpp"
#include "majak/io/options_file.hpp"
#include "majak/io/source.hpp"
#include "majak/methods/methods.hpp"

namespace {

using namespace majak;

struct Scored {
  std::vector<eval::PlaceError> errors;
  std::vector<localize::LearntValue> learnt;
  double nis = 0;      // of the fixes, mean
  double largest = 0;  // m, of the online estimates, against the final ones
};

double value_of(const localize::Localization& run, const std::string& name) {
  for (const auto& v : run.learnt)
    if (v.name == name) return v.value;
  return 0;
}

class Park {
 public:
  Park(const std::string& folder, const std::string& method,
       const methods::LocalizeOptions& options)
      : method_(methods::method(method)), options_(options) {
    const auto source = io::open_log(folder);
    while (auto event = source->next()) events_.push_back(std::move(*event));
    fixes_ = eval::reference_fixes(events_, options.kalman.wheelbase);
    for (const eval::ReferenceFix& f : fixes_.fixes)
      reference_.witnesses.push_back({f.time, f.p, static_cast<int>(f.burst), f.sound, {}});
  }
  const eval::ReferenceFixes& fixes() const { return fixes_; }

  Scored score(const std::vector<bool>& held) {
    const localize::Localizer localizer = method_.make(options_);
    std::map<Time, Vec2> online;
    std::size_t fix = 0;
    for (const Event& event : events_) {
      if (std::holds_alternative<GpsFix>(event) && held[fix++]) continue;
      if (const auto e = localizer.add(event)) online[e->time] = e->T_map_robot.translation();
    }
    const auto run = localizer.finish();
    Scored s;
    s.learnt = run.learnt;
    for (const Estimate& e : run.estimates)
      if (const auto o = online.find(e.time); o != online.end())
        s.largest = std::max(s.largest, (o->second - e.T_map_robot.translation()).norm());
    reference_.point = {value_of(run, "antenna ahead"), value_of(run, "antenna to the left")};
    s.errors = eval::score(run.estimates, reference_, held, eval::Against::held_out).errors;
    double used = 0;
    for (const auto& n : run.innovations)
      if (std::string_view(n.sensor) == "gps") s.nis += n.nis, ++used;
    s.nis /= std::max(used, 1.0);
    return s;
  }

 private:
  const methods::Method& method_;
  methods::LocalizeOptions options_;
  std::vector<Event> events_;
  eval::ReferenceFixes fixes_;
  eval::Reference reference_;
};

void print_errors(const std::string& name, const char* which, const eval::Headline& h) {
  fmt::print("{:8} {:5} fixes {:4}  mean {:.3f} ({:.2f} to {:.2f})  median {:.3f}  max {:.2f}\n",
             name, which, h.stats.count, h.mean.mean, h.mean.low, h.mean.high, h.stats.median,
             h.stats.max);
}

void print(const std::string& name, const std::vector<eval::PlaceError>& errors, double nis,
           double largest) {
  print_errors(name, "all", eval::headline(errors, false));
  print_errors(name, "sound", eval::headline(errors));
  fmt::print("         NIS {:.2f}  online off by {:.1f}\n", nis, largest);
  std::fflush(stdout);
}

void folds(Park& park) {
  std::vector<eval::PlaceError> both;
  for (const std::size_t fold : {0, 1}) {
    const Scored s = park.score(eval::hold_out_fold(park.fixes(), fold));
    for (const auto& v : s.learnt)
      fmt::print("   {} {:.4f} +- {:.4f} {}\n", v.name, v.value, v.sigma, v.unit);
    print(fmt::format("fold {}", fold), s.errors, s.nis, s.largest);
    both.insert(both.end(), s.errors.begin(), s.errors.end());
  }
  print_errors("pooled", "sound", eval::headline(both));
}

void one_out(Park& park) {
  Scored all;
  const std::size_t bursts = park.fixes().bursts;
  for (std::size_t b = 1; b + 1 < bursts; ++b) {
    const Scored s = park.score(eval::hold_out_burst(park.fixes(), b));
    fmt::print("   {}:{:.2f}", b, eval::headline(s.errors, false).mean.mean);
    std::fflush(stdout);
    all.errors.insert(all.errors.end(), s.errors.begin(), s.errors.end());
    all.nis += s.nis / static_cast<double>(bursts - 2);
    all.largest = std::max(all.largest, s.largest);
  }
  fmt::print("\n");
  print("one out", all.errors, all.nis, all.largest);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    if (argc < 2)
      throw Error("run_victoria_park FOLDER [--method NAME] [NAME=VALUE ...] [--one-out]");
    methods::LocalizeOptions options;
    OptionFields fields;
    methods::describe(fields, options);
    std::string method = "kalman";
    bool each = false;
    for (int i = 2; i < argc; ++i) {
      const std::string word = argv[i];
      if (word == "--one-out")
        each = true;
      else if (word == "--method" && i + 1 < argc)
        method = argv[++i];
      else
        io::apply_option(fields, word);
    }
    Park park(argv[1], method, options);
    folds(park);
    if (each) one_out(park);
  } catch (const Error& e) {
    fmt::print(stderr, "{}\n", e.what());
    return 1;
  }
}
