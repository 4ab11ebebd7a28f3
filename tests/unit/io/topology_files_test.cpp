// SPDX-License-Identifier: Apache-2.0
#include "majak/io/topology_files.hpp"

#include <gmock/gmock.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "majak/core/error.hpp"
#include "tests/support/carved_map.hpp"

namespace majak::io {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

map::Topology wing() {
  return map::build_topology(fixture::carved_map({{0, 0, 12, 1.6},
                                                  {0, 1.8, 5, 6},
                                                  {5.2, 1.8, 12, 6},
                                                  {2, 1.6, 2.9, 1.8},
                                                  {8, 1.6, 8.8, 1.8}}));
}
const std::vector<std::string> kNames{"corridor 1", "Tom & \"Jerry\" <lab>", "room 2"};

fs::path scratch(const std::string& name) { return fs::path(testing::TempDir()) / name; }

TEST(TopologyFiles, GraphmlHasTheGraph) {
  const std::string text = topology_graphml(wing(), kNames);
  const auto count = [&](const std::string& what) {
    int n = 0;
    for (auto at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++n;
    return n;
  };
  EXPECT_EQ(count("<node "), 3);
  EXPECT_EQ(count("</node>"), 3);
  EXPECT_EQ(count("<edge "), 2);
  EXPECT_THAT(text, HasSubstr("Tom &amp; &quot;Jerry&quot; &lt;lab&gt;"));
  EXPECT_EQ(text, topology_graphml(wing(), kNames));
}

TEST(TopologyFiles, NetworkxReadsTheGraph) {
  if (std::system("/usr/bin/python3 -c 'import networkx' 2>/dev/null") != 0)
    GTEST_SKIP() << "python3-networkx is not installed";
  const fs::path file = scratch("rooms.graphml");
  std::ofstream(file) << topology_graphml(wing(), kNames);
  const std::string check =
      "/usr/bin/python3 -c \"import networkx as n; g = n.read_graphml('" + file.string() +
      "'); assert len(g) == 3 and g.number_of_edges() == 2; "
      "assert sum(d['kind'] == 'corridor' for _, d in g.nodes(data=True)) == 1; "
      "assert n.has_path(g, 'r0', 'r2')\"";
  EXPECT_EQ(std::system(check.c_str()), 0);
}

TEST(TopologyFiles, JsonHasEveryCellOnce) {
  const map::Topology t = wing();
  const auto json = nlohmann::json::parse(topology_json(t, kNames));
  ASSERT_EQ(json["rooms"].size(), 3U);
  for (std::size_t r = 0; r < 3; ++r) {
    std::vector<std::uint32_t> cells;
    for (const auto& run : json["rooms"][r]["cells"])
      for (std::uint32_t k = 0; k < run[2].get<std::uint32_t>(); ++k)
        cells.push_back(run[0].get<std::uint32_t>() * static_cast<std::uint32_t>(t.width) +
                        run[1].get<std::uint32_t>() + k);
    EXPECT_EQ(cells, t.rooms[r].cells);
    EXPECT_EQ(json["rooms"][r]["outline"].size(), t.rooms[r].outline.size());
  }
  ASSERT_EQ(json["doors"].size(), 2U);
  EXPECT_NEAR(json["doors"][0]["width"].get<double>(), t.doors[0].width, 1e-4);
  EXPECT_EQ(json["rooms"][1]["name"], kNames[1]);
}

TEST(TopologyFiles, LabelsComeBackAsTheyWere) {
  const fs::path file = scratch("labels.json");
  fs::remove(file);
  EXPECT_TRUE(read_labels(file).empty());
  const std::vector<map::RoomLabel> labels{map::label_at(wing(), {2, 4}, "Küche \"A\""),
                                           {"point", {1.25, -3}, {}}};
  write_labels(file, labels);
  const auto back = read_labels(file);
  ASSERT_EQ(back.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(back[i].text, labels[i].text);
    EXPECT_NEAR((back[i].at - labels[i].at).norm(), 0, 1e-9);
    ASSERT_EQ(back[i].outline.size(), labels[i].outline.size());
    for (std::size_t k = 0; k < back[i].outline.size(); ++k)
      EXPECT_NEAR((back[i].outline[k] - labels[i].outline[k]).norm(), 0, 1e-4);
  }
}

TEST(TopologyFiles, ADamagedFileOfLabelsSaysSo) {
  const fs::path file = scratch("bad_labels.json");
  for (const char* text : {"", "{", "[]", R"({"labels": [{"text": 3}]})",
                           R"({"labels": [{"text": "a", "at": [1]}]})"}) {
    std::ofstream(file) << text;
    EXPECT_THROW(read_labels(file), Error) << text;
  }
}

}  // namespace
}  // namespace majak::io
