// SPDX-License-Identifier: Apache-2.0
#include "majak/io/g2o.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <memory>
#include <optional>

#include "majak/core/error.hpp"
#include "majak/graph/initialize.hpp"
#include "majak/io/atomic_file.hpp"
#include "majak/io/byte_stream.hpp"
#include "majak/io/line_reader.hpp"
#include "majak/io/number.hpp"

namespace majak::io {
namespace {

class Parser {
 public:
  Parser(const std::string& name, Report& report) : name_(name), report_(report) {}

  G2oGraph parse(std::unique_ptr<ByteStream> bytes) {
    LineReader lines(std::move(bytes));
    while (const auto line = lines.next()) {
      line_ = lines.line();
      record(*line);
    }
    // A log with a hole is still a log; a graph with a hole is another graph.
    const Report damage = lines.report();
    if (!damage.empty()) fail(line_, damage.entries().begin()->first);
    return finish();
  }

 private:
  struct Vertex {
    std::int64_t id;
    Pose2 pose;
    std::int64_t line;
  };
  struct RawEdge {
    std::int64_t from, to;
    graph::Edge edge;
    std::int64_t line;
  };

  [[noreturn]] void fail(std::int64_t line, const std::string& what) const {
    throw Error(fmt::format("{}:{}: {}", name_, line, what));
  }

  void record(std::string_view line) {
    Fields words(line);
    const std::string_view tag = words.word();
    if (tag.empty() || tag.front() == '#') return;
    if (tag == "VERTEX_SE2") {
      const std::int64_t id = integer(words, tag);
      vertices_.push_back({id, pose(words, tag), line_});
    } else if (tag == "EDGE_SE2") {
      edge(words, tag);
    } else if (tag == "FIX") {
      const std::int64_t id = integer(words, tag);
      if (fixed_)
        report_.count("g2o: FIX after the first is not used", line_);
      else
        fixed_ = {id, line_};
    } else {
      report_.count(fmt::format("g2o: {} records are not read", printable(tag)), line_);
    }
  }

  void edge(Fields& words, std::string_view tag) {
    RawEdge e{.from = 0, .to = 0, .edge = {}, .line = line_};
    e.from = integer(words, tag);
    e.to = integer(words, tag);
    e.edge.T_from_to = pose(words, tag);
    for (int r = 0; r < 3; ++r)
      for (int c = r; c < 3; ++c)
        e.edge.information(r, c) = e.edge.information(c, r) = number(words, tag);
    if (e.from == e.to) fail(line_, fmt::format("EDGE_SE2 joins vertex {} to itself", e.from));
    edges_.push_back(e);
  }

  std::int64_t integer(Fields& words, std::string_view tag) {
    const std::string_view word = words.word();
    std::int64_t value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size() || value < 0)
      fail(line_, word.empty() ? fmt::format("{} ends too early", tag)
                               : fmt::format("{}: '{}' is not an id", tag, printable(word)));
    return value;
  }

  double number(Fields& words, std::string_view tag) {
    Fields before = words;
    double value = 0;
    if (words.number(value) && std::isfinite(value)) return value;
    const std::string_view word = before.word();
    fail(line_, word.empty()
                    ? fmt::format("{} ends too early", tag)
                    : fmt::format("{}: '{}' is not a finite number", tag, printable(word)));
  }

  Pose2 pose(Fields& words, std::string_view tag) {
    const double x = number(words, tag), y = number(words, tag), theta = number(words, tag);
    return {x, y, wrap_angle(theta)};
  }

  /// A word of the file, fit for a one-line message.
  static std::string printable(std::string_view word) {
    std::string text(word.substr(0, 40));
    for (char& c : text)
      if (c < 0x20 || c > 0x7e) c = '?';
    return text;
  }

  G2oGraph finish() {
    G2oGraph result;
    result.has_poses = !vertices_.empty();
    if (!result.has_poses) {
      for (const RawEdge& e : edges_)
        for (const std::int64_t id : {e.from, e.to}) result.ids.push_back(id);
      std::sort(result.ids.begin(), result.ids.end());
      result.ids.erase(std::unique(result.ids.begin(), result.ids.end()), result.ids.end());
      result.graph.poses.resize(result.ids.size());
    } else {
      take_vertices(result);
    }
    if (result.ids.empty()) throw Error(name_ + ": no VERTEX_SE2 and no EDGE_SE2 record in it");
    for (RawEdge& e : edges_) {
      e.edge.from = index(result, e.from, e.line);
      e.edge.to = index(result, e.to, e.line);
      result.graph.edges.push_back(e.edge);
    }
    if (fixed_) result.graph.fixed = index(result, fixed_->first, fixed_->second);
    if (!result.has_poses) result.graph.poses = graph::spanning_tree(result.graph);
    return result;
  }

  void take_vertices(G2oGraph& result) {
    std::stable_sort(vertices_.begin(), vertices_.end(),
                     [](const Vertex& a, const Vertex& b) { return a.id < b.id; });
    for (std::size_t k = 0; k < vertices_.size(); ++k) {
      const Vertex& v = vertices_[k];
      if (k > 0 && vertices_[k - 1].id == v.id)
        fail(v.line,
             fmt::format("VERTEX_SE2 {} stands in line {} already", v.id, vertices_[k - 1].line));
      result.ids.push_back(v.id);
      result.graph.poses.push_back(v.pose);
    }
  }

  int index(const G2oGraph& result, std::int64_t id, std::int64_t line) const {
    const auto it = std::lower_bound(result.ids.begin(), result.ids.end(), id);
    if (it == result.ids.end() || *it != id)
      fail(line, fmt::format("vertex {} is not defined by any VERTEX_SE2 record", id));
    return static_cast<int>(it - result.ids.begin());
  }

  std::string name_;
  Report& report_;
  std::int64_t line_ = 0;
  std::vector<Vertex> vertices_;
  std::vector<RawEdge> edges_;
  std::optional<std::pair<std::int64_t, std::int64_t>> fixed_;  ///< id, line
};

}  // namespace

G2oGraph parse_g2o(std::string_view text, const std::string& name, Report& report) {
  return Parser(name, report).parse(open_bytes_in_memory(std::string(text)).bytes);
}

G2oGraph read_g2o(const std::filesystem::path& path, Report& report) {
  return Parser(path.string(), report).parse(open_bytes(path).bytes);
}

std::string g2o_text(const graph::PoseGraph& graph, const std::vector<std::int64_t>& ids) {
  const auto id = [&](int i) {
    return ids.empty() ? std::int64_t{i} : ids.at(static_cast<std::size_t>(i));
  };
  fmt::memory_buffer out;
  const auto to = std::back_inserter(out);
  for (std::size_t i = 0; i < graph.poses.size(); ++i) {
    const Pose2& p = graph.poses[i];
    fmt::format_to(to, "VERTEX_SE2 {} {} {} {}\n", id(static_cast<int>(i)), p.x, p.y, p.theta);
  }
  if (!graph.poses.empty()) fmt::format_to(to, "FIX {}\n", id(graph.fixed));
  for (const graph::Edge& e : graph.edges) {
    const Mat3& o = e.information;
    fmt::format_to(to, "EDGE_SE2 {} {} {} {} {} {} {} {} {} {} {}\n", id(e.from), id(e.to),
                   e.T_from_to.x, e.T_from_to.y, e.T_from_to.theta, o(0, 0), o(0, 1), o(0, 2),
                   o(1, 1), o(1, 2), o(2, 2));
  }
  return fmt::to_string(out);
}

void write_g2o(const std::filesystem::path& path, const graph::PoseGraph& graph,
               const std::vector<std::int64_t>& ids) {
  write_file_atomically(path, g2o_text(graph, ids));
}

}  // namespace majak::io
