// SPDX-License-Identifier: Apache-2.0
// Every data set, with default options, with and without odometry: accuracy against relations,
// CPU seconds, the multiple of the bare reading, memory. Writes the CSV and the tables of the
// document between its markers.
//   run_datasets bench/datasets.toml --majak build/majak --data DIR --work DIR --csv F --document F
//                [--only NAME] [--repeat N]
#include <fmt/core.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>

#include "bench/measure.hpp"
#include "majak/core/error.hpp"
#include "majak/eval/relations.hpp"
#include "majak/io/atomic_file.hpp"
#include "majak/io/byte_stream.hpp"
#include "majak/io/site_file.hpp"

namespace majak::bench {
namespace {

namespace fs = std::filesystem;

struct Dataset {
  std::string name, log, relations, place;
};

struct Settings {
  std::string datasets, majak, data, work, csv, document, only;
  int repeat = 1;
};

/// One run of one data set.
struct Row {
  Dataset dataset;
  bool odometry = true;
  Cost info, map;
  std::string failure;  ///< what the program said, when it refused
  std::optional<eval::RelationEvaluation> relations;
  std::size_t poses = 0;
};

std::vector<Dataset> read_datasets(const std::string& path) {
  const toml::table table = toml::parse_file(path);
  std::vector<Dataset> list;
  for (const auto& node : *table["dataset"].as_array()) {
    const toml::table& t = *node.as_table();
    list.push_back({t["name"].value_or(""), t["log"].value_or(""), t["relations"].value_or(""),
                    t["place"].value_or("")});
  }
  return list;
}

/// The log as a plain file: what is measured is mapping, not unpacking.
fs::path unpacked(const fs::path& log, const fs::path& to) {
  if (fs::is_directory(log)) return log;
  if (fs::exists(to)) return to;
  const auto opened = io::open_bytes(log);
  io::AtomicFile file(to);
  std::string buffer(1 << 16, '\0');
  while (const std::size_t n = opened.bytes->read(buffer.data(), buffer.size())) {
    file.write(std::string_view(buffer).substr(0, n));
  }
  file.commit();
  return to;
}

fs::path result_folder(const Row& row, const Settings& s) {
  return fs::path(s.work) / (row.dataset.name + (row.odometry ? "" : "-no-odometry"));
}

/// The cheapest of `repeat` runs: what disturbs only adds.
Cost cheapest(const std::vector<std::string>& command, const fs::path& output, int repeat) {
  Cost best = measure(command, output);
  for (int i = 1; i < repeat && best.exit_code == 0; ++i) {
    const Cost again = measure(command, output);
    if (again.cpu_s < best.cpu_s) best = again;
  }
  return best;
}

Row run(const Dataset& dataset, bool odometry, const Settings& s) {
  Row row;
  row.dataset = dataset;
  row.odometry = odometry;
  const fs::path log =
      unpacked(fs::path(s.data) / dataset.log, fs::path(s.work) / (dataset.name + ".log"));
  const fs::path said = fs::path(s.work) / "said.txt";
  row.info = cheapest({s.majak, "info", log.string()}, said, s.repeat);
  std::vector<std::string> command = {s.majak, "map", log.string(), "-o",
                                      result_folder(row, s).string()};
  if (!odometry) command.emplace_back("--no-odometry");
  row.map = cheapest(command, said, s.repeat);
  if (row.map.exit_code != 0) {
    std::ifstream in(said);
    for (std::string line; std::getline(in, line);) row.failure = line;
    if (row.failure.empty()) row.failure = fmt::format("exit code {}", row.map.exit_code);
  }
  return row;
}

void evaluate(Row& row, const Settings& s) {
  if (!row.failure.empty()) return;
  const fs::path folder = result_folder(row, s);
  Report report;
  const auto trajectory = eval::read_tum((folder / "trajectory.tum").string(), report);
  row.poses = trajectory.size();
  if (row.dataset.relations.empty()) return;
  const Site site = io::read_site(folder / "site.majak");
  const auto relations =
      eval::read_relations((fs::path(s.data) / row.dataset.relations).string(), report);
  row.relations = eval::evaluate_relations_in_both_frames(
      trajectory, site.scans.front().scan.T_robot_laser, relations);
}

std::string csv(const std::vector<Row>& rows) {
  std::string text =
      "dataset,mode,poses,relations,frame,all_m,all_sigma_m,all_deg,all_sigma_deg,short_m,short_"
      "deg,"
      "loop_m,loop_deg,map_cpu_s,info_cpu_s,times_reading,wall_s,peak_mb,failure\n";
  for (const Row& r : rows) {
    text +=
        fmt::format("{},{},{},", r.dataset.name, r.odometry ? "odometry" : "no-odometry", r.poses);
    if (r.relations) {
      const eval::RelationResult& e = r.relations->best();
      text += fmt::format(
          "{},{},{:.5f},{:.5f},{:.4f},{:.4f},{:.5f},{:.4f},{:.5f},{:.4f},", e.all.translation.count,
          r.relations->better == eval::BodyFrame::laser ? "laser" : "robot", e.all.translation.mean,
          e.all.translation.sigma, degrees(e.all.rotation.mean), degrees(e.all.rotation.sigma),
          e.near.translation.mean, degrees(e.near.rotation.mean), e.loop.translation.mean,
          degrees(e.loop.rotation.mean));
    } else {
      text += ",,,,,,,,,,";
    }
    text += fmt::format("{:.2f},{:.3f},{:.1f},{:.2f},{:.0f},\"{}\"\n", r.map.cpu_s, r.info.cpu_s,
                        r.map.cpu_s / std::max(r.info.cpu_s, 1e-3), r.map.wall_s, r.map.peak_mb,
                        r.failure);
  }
  return text;
}

std::string table(const std::vector<Row>& rows) {
  std::string text =
      "| log | odometry | all relations | short (up to 20 s) | loops | frame | CPU s | times "
      "reading | peak MB |\n"
      "|---|---|---|---|---|---|---|---|---|\n";
  const auto cell = [](const eval::RelationErrors& e) {
    return fmt::format("{:.4f} m, {:.2f}°", e.translation.mean, degrees(e.rotation.mean));
  };
  for (const Row& r : rows) {
    text += fmt::format("| {} | {} | ", r.dataset.name, r.odometry ? "yes" : "no");
    if (!r.failure.empty()) {
      text += fmt::format("{} | | | | | | |\n", r.failure);
      continue;
    }
    if (r.relations) {
      const eval::RelationResult& e = r.relations->best();
      text += fmt::format("**{}** | {} | {} | {} |", cell(e.all), cell(e.near), cell(e.loop),
                          r.relations->better == eval::BodyFrame::laser ? "laser" : "robot");
    } else {
      text += "no relations | | | |";
    }
    text += fmt::format(" {:.2f} | {:.1f} | {:.0f} |\n", r.map.cpu_s,
                        r.map.cpu_s / std::max(r.info.cpu_s, 1e-3), r.map.peak_mb);
  }
  return text;
}

/// Replaces what stands between the markers of the document.
void update_document(const std::string& path, const std::string& text) {
  std::stringstream old;
  old << std::ifstream(path).rdbuf();
  std::string document = old.str();
  const std::string begin = "<!-- results: begin -->\n", end = "<!-- results: end -->";
  const std::size_t from = document.find(begin), to = document.find(end);
  if (from == std::string::npos || to == std::string::npos) {
    throw Error(path + ": the markers `results: begin` and `results: end` are missing");
  }
  document.replace(from + begin.size(), to - from - begin.size(), text);
  io::write_file_atomically(path, document);
}

Settings parse(int argc, char** argv) {
  Settings s;
  const char* const folder = std::getenv("MAJAK_DATA");
  s.data = folder != nullptr ? folder : "";
  const std::map<std::string, std::string*> names = {
      {"--majak", &s.majak}, {"--data", &s.data},         {"--work", &s.work},
      {"--csv", &s.csv},     {"--document", &s.document}, {"--only", &s.only}};
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word.rfind("--", 0) != 0) {
      s.datasets = word;
    } else if (i + 1 == argc) {
      throw Error(word + " needs a value");
    } else if (word == "--repeat") {
      s.repeat = std::max(1, std::atoi(argv[++i]));
    } else if (const auto name = names.find(word); name != names.end()) {
      *name->second = argv[++i];
    } else {
      throw Error(word + ": no such option");
    }
  }
  if (s.datasets.empty() || s.majak.empty() || s.work.empty())
    throw Error("see the head of run_datasets.cpp");
  if (!fs::is_directory(s.data)) throw Error("the data folder is absent; set MAJAK_DATA to it");
  return s;
}

void run_all(const Settings& s) {
  fs::create_directories(s.work);
  std::vector<Row> rows;
  for (const Dataset& dataset : read_datasets(s.datasets)) {
    if (!s.only.empty() && dataset.name != s.only) continue;
    for (const bool odometry : {true, false}) {
      rows.push_back(run(dataset, odometry, s));
      fmt::print("{:<14} {:<12} {:6.2f} CPU s {:5.0f} MB {}\n", dataset.name,
                 odometry ? "" : "no odometry", rows.back().map.cpu_s, rows.back().map.peak_mb,
                 rows.back().failure);
      std::fflush(stdout);
    }
  }
  for (Row& row : rows) evaluate(row, s);  // after all measuring: see measure.hpp
  fmt::print("\n{}", table(rows));
  if (!s.only.empty()) return;
  if (!s.csv.empty()) io::write_file_atomically(s.csv, csv(rows));
  if (!s.document.empty()) update_document(s.document, table(rows));
}

}  // namespace
}  // namespace majak::bench

int main(int argc, char** argv) {
  try {
    majak::bench::run_all(majak::bench::parse(argc, argv));
    return 0;
  } catch (const std::exception& e) {
    fmt::print(stderr, "run_datasets: {}\n", e.what());
    return 1;
  }
}
