// SPDX-License-Identifier: Apache-2.0
#include "majak/io/g2o.hpp"

#include <gmock/gmock.h>
#include <unistd.h>
#include <zlib.h>

#include <filesystem>
#include <limits>

#include "majak/core/error.hpp"
#include "majak/core/random.hpp"
#include "majak/io/atomic_file.hpp"

namespace majak::io {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

G2oGraph parse(const std::string& text) {
  Report report;
  return parse_g2o(text, "g.g2o", report);
}

std::string complaint(const std::string& text) {
  try {
    parse(text);
  } catch (const Error& e) {
    return e.what();
  }
  return "none";
}

const char* const kTriangle =
    "# three poses\n"
    "VERTEX_SE2 10 0 0 0\n"
    "VERTEX_SE2 30 1 1 3.5\n"
    "VERTEX_SE2 20 1e0 -0.5 +1.5707963267948966\r\n"
    "\n"
    "FIX 20\n"
    "EDGE_SE2 10 20 1 0 1.5 1 2 3 40 5 600\n"
    "\t EDGE_SE2  20 30  1 0 -7 1 0 0 1 0 1 ";

TEST(G2o, ReadsVerticesEdgesAndFix) {
  const G2oGraph g = parse(kTriangle);
  EXPECT_EQ(g.ids, (std::vector<std::int64_t>{10, 20, 30}));
  ASSERT_EQ(g.graph.poses.size(), 3u);
  EXPECT_EQ(g.graph.poses[1], (Pose2{1, -0.5, kPi / 2}));
  EXPECT_NEAR(g.graph.poses[2].theta, 3.5 - 2 * kPi, 1e-15);
  EXPECT_EQ(g.graph.fixed, 1);
  EXPECT_TRUE(g.has_poses);
  ASSERT_EQ(g.graph.edges.size(), 2u);
  const graph::Edge& e = g.graph.edges[0];
  EXPECT_EQ(e.from, 0);
  EXPECT_EQ(e.to, 1);
  Mat3 expected;
  expected << 1, 2, 3, 2, 40, 5, 3, 5, 600;
  EXPECT_EQ(e.information, expected);
  EXPECT_FALSE(e.robust);
  EXPECT_NEAR(g.graph.edges[1].T_from_to.theta, -7 + 2 * kPi, 1e-15);
}

TEST(G2o, EdgesAloneMakePoses) {
  const G2oGraph g = parse(
      "EDGE_SE2 5 7 1 0 1.5707963267948966 1 0 0 1 0 1\n"
      "EDGE_SE2 9 7 1 0 0 1 0 0 1 0 1\n");
  EXPECT_FALSE(g.has_poses);
  EXPECT_EQ(g.ids, (std::vector<std::int64_t>{5, 7, 9}));
  EXPECT_NEAR(g.graph.poses[1].x, 1, 1e-15);
  EXPECT_NEAR(g.graph.poses[2].y, -1, 1e-15);
  EXPECT_NEAR(graph::chi2(g.graph), 0, 1e-25);
}

TEST(G2o, OtherRecordsAndFurtherFixesAreCounted) {
  Report report;
  parse_g2o("VERTEX_SE2 0 0 0 0\nVERTEX_XY 1 0 0\nVERTEX_XY 2 0 0\nFIX 0\nFIX 0\n", "g", report);
  ASSERT_EQ(report.entries().size(), 2u);
  EXPECT_EQ(report.entries().at("g2o: VERTEX_XY records are not read").count, 2);
  EXPECT_EQ(report.entries().at("g2o: VERTEX_XY records are not read").first_line, 2);
  EXPECT_EQ(report.entries().at("g2o: FIX after the first is not used").first_line, 5);
}

TEST(G2o, ErrorsSayWhereAndWhat) {
  const std::string v = "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\n";
  EXPECT_THAT(complaint(""), HasSubstr("g.g2o: no VERTEX_SE2"));
  EXPECT_THAT(complaint("FLASER 1 2 3\n"), HasSubstr("no VERTEX_SE2"));
  EXPECT_THAT(complaint(v + "VERTEX_SE2 2 1 0\n"), HasSubstr("g.g2o:3: VERTEX_SE2 ends too early"));
  EXPECT_THAT(complaint(v + "VERTEX_SE2 x 1 0 0\n"),
              HasSubstr("g.g2o:3: VERTEX_SE2: 'x' is not an id"));
  EXPECT_THAT(complaint(v + "VERTEX_SE2 -4 1 0 0\n"), HasSubstr("'-4' is not an id"));
  EXPECT_THAT(complaint(v + "VERTEX_SE2 99999999999999999999 1 0 0\n"), HasSubstr("is not an id"));
  EXPECT_THAT(complaint(v + "VERTEX_SE2 2 1 nan 0\n"), HasSubstr("'nan' is not a finite number"));
  EXPECT_THAT(complaint(v + "VERTEX_SE2 2 1 1e999 0\n"),
              HasSubstr("'1e999' is not a finite number"));
  EXPECT_THAT(complaint(v + "VERTEX_SE2 2 1 1.5x 0\n"), HasSubstr("'1.5x' is not a finite number"));
  EXPECT_THAT(complaint(v + "VERTEX_SE2 1 1 1 0\n"),
              HasSubstr("g.g2o:3: VERTEX_SE2 1 stands in line 2 already"));
  EXPECT_THAT(complaint(v + "EDGE_SE2 0 1 1 0 0 1 0 0 1 0\n"),
              HasSubstr("g.g2o:3: EDGE_SE2 ends too early"));
  EXPECT_THAT(complaint(v + "EDGE_SE2 0 5 1 0 0 1 0 0 1 0 1\n"),
              HasSubstr("g.g2o:3: vertex 5 is not defined"));
  EXPECT_THAT(complaint(v + "EDGE_SE2 1 1 1 0 0 1 0 0 1 0 1\n"),
              HasSubstr("joins vertex 1 to itself"));
  EXPECT_THAT(complaint(v + "FIX 7\n"), HasSubstr("g.g2o:3: vertex 7 is not defined"));
  EXPECT_THAT(complaint(v + "VERTEX_SE2 2 \x7f\xff 0 0\n"), HasSubstr("'\?\?' is not"));
}

TEST(G2o, WhatIsWrittenComesBackExactly) {
  RandomStream random(1);
  graph::PoseGraph g;
  for (int i = 0; i < 20; ++i)
    g.poses.push_back({random.normal() * 1e3, random.normal() * 1e-7, random.uniform(-kPi, kPi)});
  for (int i = 1; i < 20; ++i) {
    Mat3 a;
    for (int k = 0; k < 9; ++k) a(k / 3, k % 3) = random.normal();
    const Mat3 root = a * a.transpose();
    g.edges.push_back(
        {i - 1, i, {random.normal(), 1e-300, -kPi / 7}, 0.5 * (root + root.transpose()), false});
  }
  g.fixed = 3;
  std::vector<std::int64_t> ids;
  for (int i = 0; i < 20; ++i) ids.push_back(100 + 7 * i);
  for (const auto& names : {std::vector<std::int64_t>(), ids}) {
    const G2oGraph back = parse(g2o_text(g, names));
    EXPECT_EQ(back.graph.poses, g.poses);
    EXPECT_EQ(back.graph.fixed, 3);
    EXPECT_EQ(back.ids[2], names.empty() ? 2 : 114);
    ASSERT_EQ(back.graph.edges.size(), g.edges.size());
    for (std::size_t k = 0; k < g.edges.size(); ++k) {
      EXPECT_EQ(back.graph.edges[k].from, g.edges[k].from);
      EXPECT_EQ(back.graph.edges[k].to, g.edges[k].to);
      EXPECT_EQ(back.graph.edges[k].T_from_to, g.edges[k].T_from_to);
      EXPECT_EQ(back.graph.edges[k].information, g.edges[k].information);
    }
  }
}

TEST(G2o, RandomBytesGiveAnErrorOrAGraph) {
  RandomStream random(2);
  for (int k = 0; k < 2000; ++k) {
    std::string text = kTriangle;
    for (int m = 0; m < 3; ++m)
      text[random.below(text.size())] = static_cast<char>(random.below(256));
    text.resize(random.below(text.size() + 1));
    const std::string message = complaint(text);
    EXPECT_EQ(message.find('\n'), std::string::npos);
  }
}

class G2oFile : public testing::Test {
 protected:
  G2oFile() {
    std::string name = (fs::temp_directory_path() / "majak-g2o-XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
  }
  ~G2oFile() override { fs::remove_all(folder_); }

  fs::path packed() const {
    const fs::path path = folder_ / "any-name";
    gzFile file = gzopen(path.c_str(), "wb");
    gzputs(file, kTriangle);
    gzclose(file);
    return path;
  }
  static std::string complaint_of(const fs::path& path) {
    Report report;
    try {
      read_g2o(path, report);
    } catch (const Error& e) {
      return e.what();
    }
    return "none";
  }
  fs::path folder_;
};

TEST_F(G2oFile, PlainAndGzipByContent) {
  Report report;
  write_file_atomically(folder_ / "plain.gz", kTriangle);
  EXPECT_EQ(read_g2o(folder_ / "plain.gz", report).graph.poses.size(), 3u);
  EXPECT_EQ(read_g2o(packed(), report).graph.edges.size(), 2u);
}

TEST_F(G2oFile, WrittenFileIsReadBack) {
  Report report;
  const G2oGraph g = parse(kTriangle);
  write_g2o(folder_ / "a.g2o", g.graph, g.ids);
  EXPECT_EQ(read_g2o(folder_ / "a.g2o", report).graph.poses, g.graph.poses);
}

TEST_F(G2oFile, DamagedGzipAndMissingFileAreErrors) {
  const fs::path path = packed();
  fs::resize_file(path, fs::file_size(path) - 12);
  EXPECT_THAT(complaint_of(path), HasSubstr(path.string()));
  EXPECT_THAT(complaint_of(folder_ / "none"), HasSubstr("none"));
  EXPECT_THAT(complaint_of(folder_), HasSubstr(folder_.string()));
}

}  // namespace
}  // namespace majak::io
