// SPDX-License-Identifier: Apache-2.0
#include "majak/eval/table2.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <string_view>

#include "majak/eval/statistics.hpp"

namespace majak::eval {
namespace {

using Scores = std::vector<const MappingScore*>;

// The thesis's columns and then ours; the words by row, as in the original where the thesis lost
// some (rows "needs poses" and "changing places").
constexpr const char* kColumns[] = {"ekf-slam",  "lu-milios",      "em",           "incremental-ml",
                                    "hybrid",    "occupancy-grid", "multi-planar", "dogma",
                                    "particles", "graph-slam"};
constexpr std::size_t kThesis = 8;
struct Words {
  const char* row;
  const char* question;
  const char* word[kThesis];
};
const Words kWords[] = {
    {"Representation",
     "what is kept beside the scans, on the usual drive",
     {"landmark locations", "point obstacles", "point obstacles", "landmarks or grids",
      "point obstacles", "occupancy grids", "objects and polygons", "occupancy grids"}},
    {"Uncertainty",
     "are the poses' covariances honest: NEES, 3 if so",
     {"posterior poses and map", "posterior poses and map", "maximum likelihood map",
      "maximum likelihood map", "maximum likelihood map", "posterior map", "maximum likelihood map",
      "posterior map"}},
    {"Convergence",
     "usable maps (rms within 0.5 m) over seeds, and their error",
     {"strong", "none", "weak", "none", "none", "strong", "weak", "weak"}},
    {"Local minima",
     "usable maps where the wheels err 1, 2, 4, 8 times as much as usual",
     {"no", "yes", "yes", "yes", "yes", "no", "yes", "yes"}},
    {"Incremental",
     "CPU a scan at first and at last, and after the last scan",
     {"yes", "no", "no", "yes", "yes", "yes", "no", "no"}},
    {"Needs poses",
     "with less to go by: no wheels; other poses than the true ones",
     {"no", "no", "no", "no", "no", "yes", "yes", "yes"}},
    {"Sensor noise",
     "error with 5 % stray returns, times that without",
     {"Gaussian", "Gaussian", "any", "any", "any", "any", "Gaussian", "any"}},
    {"Maps cycles",
     "drives whose places lie on each other when seen again",
     {"yes", "no", "yes", "no", "yes, not nested", "", "", ""}},
    {"Dimensionality",
     "CPU and memory grow with the way to this power",
     {"~10^3", "unlimited", "unlimited", "unlimited", "unlimited", "unlimited", "unlimited",
      "unlimited"}},
    {"Correspondence",
     "places seen again that lie on each other within 0.2 m",
     {"no", "yes", "yes", "yes", "yes", "yes", "yes", "yes"}},
    {"Raw data", "what of a scan is used", {"no", "yes", "yes", "yes", "yes", "yes", "yes", "yes"}},
    {"Changing places",
     "usable maps with people about, and the error times that without",
     {"limited", "no", "no", "no", "no", "limited", "no", "yes"}},
};

std::string bytes_text(double bytes) {
  return bytes < 1e4   ? fmt::format("{:.0f} B", bytes)
         : bytes < 1e6 ? fmt::format("{:.0f} kB", bytes / 1e3)
                       : fmt::format("{:.1f} MB", bytes / 1e6);
}

std::string metres_text(double m) {
  return m < 0.095 ? fmt::format("{:.1f} cm", 100 * m) : fmt::format("{:.2f} m", m);
}

bool usable(const MappingScore& s) { return s.ran && s.rms <= kUsable; }
/// All places but a few lie on each other when seen again.
bool closed(const MappingScore& s) { return s.ran && s.recognised && *s.recognised >= 0.95; }

template <class Value>
double median_of(const Scores& scores, const Value& value) {
  std::vector<double> values;
  for (const MappingScore* s : scores)
    if (s->ran) values.push_back(value(*s));
  return quantile(std::move(values), 0.5);
}

std::string count_of(const Scores& scores, bool (*good)(const MappingScore&)) {
  const auto n = std::count_if(scores.begin(), scores.end(), [&](auto* s) { return good(*s); });
  return fmt::format("{} of {}", n, scores.size());
}

/// Slope of log(value) over log(size); nothing for fewer than two sizes.
std::optional<double> exponent(const std::vector<std::pair<double, double>>& at) {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0;
  for (const auto& [size, value] : at) {
    if (!(size > 0 && value > 0)) continue;
    const double u = std::log(size), v = std::log(value);
    n += 1, x += u, y += v, xx += u * u, xy += u * v;
  }
  const double spread = n * xx - x * x;
  if (n < 2 || spread < 1e-9) return std::nullopt;
  return (n * xy - x * y) / spread;
}

std::string growth_text(const std::optional<double>& cpu, const std::optional<double>& bytes,
                        const std::string& more) {
  std::string text;
  if (cpu) text += fmt::format("CPU ^{:.1f}", *cpu);
  if (bytes) text += fmt::format("{}memory ^{:.1f}", text.empty() ? "" : ", ", *bytes);
  return text.empty() ? "" : text + more;
}

// ---- Methods that find the poses ---------------------------------------------------------------

/// All runs of one method, by what they were for.
class MethodRuns {
 public:
  MethodRuns(const MappingComparison& comparison, std::size_t method)
      : name(comparison.methods[method]) {
    for (std::size_t i = 0; i < comparison.settings.size(); ++i)
      if (const auto& score = comparison.scores[method][i]) {
        const TrialSetting& s = comparison.settings[i];
        groups_[s.group == "wheels" ? fmt::format("wheels {:g}", s.wheels) : s.group].push_back(
            &*score);
      }
  }
  const Scores& operator[](const std::string& group) const {
    static const Scores none;
    const auto found = groups_.find(group);
    return found == groups_.end() ? none : found->second;
  }
  /// The first runs of "seeds": what others of `count` seeds are compared with.
  Scores same_seeds(std::size_t count) const {
    const Scores& all = (*this)["seeds"];
    return {all.begin(), all.begin() + static_cast<std::ptrdiff_t>(std::min(count, all.size()))};
  }
  const std::map<std::string, Scores>& groups() const { return groups_; }

  std::string name;

 private:
  std::map<std::string, Scores> groups_;
};

std::string representation(const MethodRuns& runs) {
  const Scores& s = runs["seeds"];
  if (s.empty()) return "";
  const double landmarks = median_of(s, [](auto& v) { return double(v.landmarks); });
  const double bytes = median_of(s, [](auto& v) { return double(v.bytes); });
  const double way = median_of(s, [](auto& v) { return v.way; });
  return (landmarks > 0 ? fmt::format("{:.0f} landmarks, ", landmarks) : "") + bytes_text(bytes) +
         fmt::format(" for {:.0f} m", way);
}

std::optional<double> nees_of(const Scores& scores) {
  std::vector<double> values;
  for (const MappingScore* s : scores)
    if (s->nees) values.push_back(*s->nees);
  if (values.empty()) return std::nullopt;
  return quantile(std::move(values), 0.5);
}

void uncertainty(const MethodRuns& runs, Table2Cell& cell) {
  const Scores& s = runs["seeds"];
  if (s.empty()) return;
  const auto nees = nees_of(s);
  cell.measured = nees ? fmt::format("posterior poses: NEES {:.1f}", *nees) : "none kept of poses";
  if (!cell.word.empty()) cell.agrees = nees.has_value() == cell.word.starts_with("posterior");
}

void convergence(const MethodRuns& runs, Table2Cell& cell) {
  const Scores& s = runs["seeds"];
  if (s.empty()) return;
  cell.measured =
      count_of(s, usable) + ", " + metres_text(median_of(s, [](auto& v) { return v.rms; }));
  const auto good = std::count_if(s.begin(), s.end(), [](auto* v) { return usable(*v); });
  const bool sure = good == static_cast<std::ptrdiff_t>(s.size());
  if (cell.word == "strong") cell.agrees = sure;
}

void local_minima(const MethodRuns& runs, Table2Cell& cell) {
  std::string counts;
  bool falls = false;
  const auto share = [](const Scores& s) {
    return static_cast<double>(
               std::count_if(s.begin(), s.end(), [](auto* v) { return usable(*v); })) /
           static_cast<double>(s.size());
  };
  for (const char* group : {"seeds", "wheels 2", "wheels 4", "wheels 8"}) {
    const Scores s = runs[group];
    if (s.empty()) continue;
    counts += (counts.empty() ? "" : ", ") + count_of(s, usable);
    falls = falls || share(s) < 0.8;
  }
  cell.measured = counts;
  if (!runs["wheels 8"].empty() && !cell.word.empty()) cell.agrees = falls == (cell.word == "yes");
}

void incremental(const MethodRuns& runs, Table2Cell& cell) {
  const Scores& s = !runs["size"].empty() ? Scores{runs["size"].back()} : runs["seeds"];
  if (s.empty() || !s.front()->ran) return;
  const bool online = s.front()->online;
  const auto ms = [&](double MappingScore::*part) {
    return 1e3 * median_of(s, [&](auto& v) { return v.*part; });
  };
  cell.measured = online ? "poses on the way" : "no poses on the way";
  if (ms(&MappingScore::cpu) > 0)
    cell.measured +=
        fmt::format(", {:.2f} ms a scan at first, {:.2f} ms at last, {:.2f} s after it",
                    ms(&MappingScore::cpu_first), ms(&MappingScore::cpu_last),
                    1e-3 * ms(&MappingScore::cpu_finish));
  if (!cell.word.empty()) cell.agrees = online == (cell.word == "yes");
}

std::string without_wheels_text(const MethodRuns& runs) {
  const Scores& s = runs["no-wheels"];
  if (s.empty()) return "";
  if (std::none_of(s.begin(), s.end(), [](auto* v) { return v->ran; }))
    return "without wheels: " + s.front()->said;
  return "without wheels usable: " + count_of(s, usable);
}

/// The error of a group times that of the same seeds undisturbed.
std::optional<double> times_worse(const MethodRuns& runs, const char* group) {
  const Scores& s = runs[group];
  const Scores before = runs.same_seeds(s.size());
  if (s.empty() || before.empty()) return std::nullopt;
  const auto rms = [](const MappingScore& v) { return v.rms; };
  const double base = median_of(before, rms);
  if (!(base > 0)) return std::nullopt;
  return median_of(s, rms) / base;
}

void sensor_noise(const MethodRuns& runs, Table2Cell& cell) {
  const auto ratio = times_worse(runs, "stray");
  if (!ratio) return;
  cell.measured = fmt::format("× {:.1f}, usable {}", *ratio, count_of(runs["stray"], usable));
  if (cell.word == "any") cell.agrees = *ratio < 2;
  if (cell.word == "Gaussian") cell.agrees = *ratio >= 2;
}

void cycles(const MethodRuns& runs, Table2Cell& cell) {
  const Scores &ring = runs["ring"], &nested = runs["nested"];
  if (ring.empty()) return;
  cell.measured = "ring " + count_of(ring, closed);
  const Scores& straight = runs["straight"];
  const auto none = [](const MappingScore& s) { return s.no_loop; };
  if (std::any_of(straight.begin(), straight.end(), [&](auto* s) { return none(*s); }))
    cell.measured = "there and back: no loop found, and says so, " + count_of(straight, none) +
                    "; " + cell.measured;
  if (!nested.empty()) cell.measured += ", nested " + count_of(nested, closed);
  const auto most = [](const Scores& s) {
    return 2 * std::count_if(s.begin(), s.end(), [](auto* v) { return closed(*v); }) >
           static_cast<std::ptrdiff_t>(s.size());
  };
  if (cell.word == "yes") cell.agrees = most(ring);
  if (cell.word == "no") cell.agrees = !most(ring);
  if (cell.word == "yes, not nested" && !nested.empty()) cell.agrees = most(ring) && !most(nested);
}

std::string dimensionality(const MethodRuns& runs) {
  std::vector<std::pair<double, double>> cpu, bytes;
  for (const MappingScore* s : runs["size"])
    if (s->ran) {
      cpu.emplace_back(s->way, s->cpu);
      bytes.emplace_back(s->way, static_cast<double>(s->bytes));
    }
  std::string more;
  if (!runs["size"].empty() && runs["size"].back()->ran) {
    const MappingScore& last = *runs["size"].back();
    if (last.landmarks > 0) more = fmt::format("; {} landmarks", last.landmarks);
    if (last.cpu > 0) more += fmt::format("; {:.1f} s for {:.0f} m", last.cpu, last.way);
  }
  return growth_text(exponent(cpu), exponent(bytes), more);
}

void correspondence(const MethodRuns& runs, Table2Cell& cell) {
  double sum = 0, count = 0;
  for (const char* group : {"seeds", "ring"})
    for (const MappingScore* s : runs[group])
      if (s->recognised) sum += *s->recognised, count += 1;
  if (count == 0) return;
  cell.measured = fmt::format("{:.0f} %", 100 * sum / count);
}

std::string raw_data(const MethodRuns& runs) {
  if (runs.name == "ekf-slam") return "corners, trunks and poles";
  return "all returns of key scans";
}

void crowd(const MethodRuns& runs, Table2Cell& cell) {
  const auto ratio = times_worse(runs, "crowd");
  if (!ratio) return;
  cell.measured = fmt::format("{}, × {:.1f}", count_of(runs["crowd"], usable), *ratio);
}

Table2Cell cell_of(std::size_t row, const MethodRuns& runs, const char* word) {
  Table2Cell cell{word, "", std::nullopt, ""};
  switch (row) {
    case 0:
      cell.measured = representation(runs);
      break;
    case 1:
      uncertainty(runs, cell);
      break;
    case 2:
      convergence(runs, cell);
      break;
    case 3:
      local_minima(runs, cell);
      break;
    case 4:
      incremental(runs, cell);
      break;
    case 5:
      cell.measured = without_wheels_text(runs);
      break;
    case 6:
      sensor_noise(runs, cell);
      break;
    case 7:
      cycles(runs, cell);
      break;
    case 8:
      cell.measured = dimensionality(runs);
      break;
    case 9:
      correspondence(runs, cell);
      break;
    case 10:
      cell.measured = raw_data(runs);
      break;
    case 11:
      crowd(runs, cell);
      break;
  }
  return cell;
}

// ---- Maps that are told the poses --------------------------------------------------------------

/// Scores of one map, by what the log was for.
class GivenRuns {
 public:
  GivenRuns(const MappingComparison& comparison, std::size_t map)
      : elements(given_maps()[map].elements) {
    for (std::size_t i = 0; i < comparison.settings.size(); ++i)
      if (const auto& score = comparison.given[map][i])
        groups_[comparison.settings[i].group].push_back(&*score);
  }
  bool empty() const { return groups_.empty(); }
  bool has(const std::string& group) const { return groups_.count(group) > 0; }
  double median(const std::string& group, PosesFrom from,
                const std::function<double(const GivenScore&)>& value) const {
    std::vector<double> values;
    const auto found = groups_.find(group);
    if (found == groups_.end()) return 0;
    for (const auto* s : found->second)
      values.push_back(value((*s)[static_cast<std::size_t>(from)]));
    return quantile(std::move(values), 0.5);
  }
  double error(const std::string& group, PosesFrom from) const {
    return median(group, from, [](const GivenScore& s) { return s.map_error; });
  }
  std::string growth() const {
    std::vector<std::pair<double, double>> cpu, bytes;
    const auto found = groups_.find("size");
    if (found == groups_.end()) return "";
    for (const auto* s : found->second) {
      const GivenScore& score = (*s)[static_cast<std::size_t>(PosesFrom::truth)];
      cpu.emplace_back(score.way, score.cpu);
      bytes.emplace_back(score.way, static_cast<double>(score.bytes));
    }
    return growth_text(exponent(cpu), exponent(bytes), "");
  }

  std::string elements;

 private:
  std::map<std::string, std::vector<const std::array<GivenScore, 3>*>> groups_;
};

Table2Cell cell_of(std::size_t row, const GivenRuns& runs, const char* word) {
  Table2Cell cell{word, "", std::nullopt, ""};
  const auto truth = PosesFrom::truth;
  const std::string base = runs.has("seeds") ? "seeds" : "size";
  const auto times = [&](const char* group) {
    const double before = runs.error("seeds", truth);
    return runs.has(group) && before > 0
               ? fmt::format("× {:.1f}", runs.error(group, truth) / before)
               : std::string();
  };
  switch (row) {
    case 0:
      cell.measured = fmt::format(
          "{:.0f} {}, {}", runs.median(base, truth, [](auto& s) { return double(s.elements); }),
          runs.elements,
          bytes_text(runs.median(base, truth, [](auto& s) { return double(s.bytes); })));
      break;
    case 2:
      cell.measured = metres_text(runs.error(base, truth)) + " off the walls, at true poses";
      break;
    case 5: {
      const double right = runs.error(base, truth), wheels = runs.error(base, PosesFrom::wheels);
      cell.measured =
          fmt::format("{} at true poses, {} at graph SLAM's, {} at the wheels'", metres_text(right),
                      metres_text(runs.error(base, PosesFrom::graph_slam)), metres_text(wheels));
      cell.agrees = wheels > 1.5 * right;
      break;
    }
    case 4:
      if (const double cpu = runs.median(base, truth, [](auto& s) { return s.cpu; }); cpu > 0)
        cell.measured = fmt::format("{:.2f} s for the whole log", cpu);
      break;
    case 6:
      cell.measured = times("stray");
      break;
    case 8:
      cell.measured = runs.growth();
      break;
    case 10:
      cell.measured = "all returns";
      break;
    case 11:
      cell.measured = times("crowd");
      break;
    default:
      break;
  }
  return cell;
}

// ---- The table ---------------------------------------------------------------------------------

constexpr const char* kGroups[] = {
    "seeds", "seeds",           "seeds",       "seeds,wheels",
    "size",  "no-wheels,seeds", "seeds,stray", "straight,ring,nested",
    "size",  "seeds,ring",      "seeds",       "seeds,crowd"};

Table2Figures figures_of(const MethodRuns& runs) {
  Table2Figures f;
  f.method = runs.name;
  const Scores& s = runs["seeds"];
  f.runs = s.size();
  f.usable = static_cast<std::size_t>(
      std::count_if(s.begin(), s.end(), [](auto* v) { return usable(*v); }));
  f.rms = median_of(s, [](auto& v) { return v.rms; });
  f.worst = median_of(s, [](auto& v) { return v.worst; });
  f.map_error = median_of(s, [](auto& v) { return v.map_error; });
  if (!s.empty() && s.front()->relation)
    f.relation = median_of(s, [](auto& v) { return v.relation.value_or(0); });
  f.nees = nees_of(s);
  f.ms_a_scan =
      1e3 * median_of(s, [](auto& v) { return v.scans > 0 ? v.cpu / double(v.scans) : 0; });
  f.bytes = median_of(s, [](auto& v) { return double(v.bytes); });
  for (const auto& [group, scores] : runs.groups())
    for (const MappingScore* v : scores)
      if (!v->ran && std::find(f.said.begin(), f.said.end(), v->said) == f.said.end())
        f.said.push_back(v->said);
  return f;
}

}  // namespace

Table2 table2_of(const MappingComparison& comparison, const std::string& command) {
  Table2 table;
  table.what = comparison.what;
  for (const Words& words : kWords) table.rows.push_back({words.row, words.question, {}});
  const auto add = [&](const char* column, const char* in_the_thesis, std::size_t number,
                       const auto& runs) {
    table.columns.push_back({column, in_the_thesis});
    for (std::size_t row = 0; row < table.rows.size(); ++row) {
      const char* word = number < kThesis ? kWords[row].word[number] : "";
      table.rows[row].cells.push_back(cell_of(row, runs, word));
      if (!table.rows[row].cells.back().measured.empty())
        table.rows[row].cells.back().command =
            fmt::format("{} --methods {} --only {}", command, column, kGroups[row]);
    }
  };
  for (std::size_t c = 0; c < std::size(kColumns); ++c) {
    const std::string_view name = kColumns[c];
    for (std::size_t g = 0; g < given_maps().size(); ++g)
      if (const GivenRuns runs(comparison, g); name == given_maps()[g].name && !runs.empty())
        add(kColumns[c], given_maps()[g].in_the_thesis, c, runs);
    for (std::size_t m = 0; m < comparison.methods.size(); ++m)
      if (name == comparison.methods[m]) {
        const MethodRuns runs(comparison, m);
        add(kColumns[c], methods::mapping_method(name).in_the_thesis, c, runs);
        table.figures.push_back(figures_of(runs));
      }
  }
  return table;
}

}  // namespace majak::eval
