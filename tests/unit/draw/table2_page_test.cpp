// SPDX-License-Identifier: Apache-2.0
#include "majak/draw/table2_page.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace majak::draw {
namespace {

using testing::HasSubstr;
using testing::Not;

eval::Table2 small() {
  eval::Table2 t;
  t.what = "A place & a robot.";
  t.columns = {{"hybrid", "hybrid, p. 36"}};
  t.rows = {{"Maps cycles",
             "closed",
             {{"yes, not nested", "ring 9 of 10", false, "majak compare --only ring"}}},
            {"Raw data", "what is used", {{"yes", "", std::nullopt, ""}}}};
  t.figures.push_back({.method = "hybrid", .runs = 4, .usable = 3, .said = {"no <odometry>"}});
  return t;
}

TEST(Table2Page, HtmlHasWordsMeasurementsAndCommandsEscaped) {
  const std::string html = table2_html(small());
  EXPECT_THAT(html, HasSubstr("A place &amp; a robot."));
  EXPECT_THAT(html, HasSubstr("<td class=\"differs\" title=\"majak compare --only ring\">"
                              "<i>yes, not nested</i>ring 9 of 10</td>"));
  EXPECT_THAT(html, HasSubstr("no &lt;odometry&gt;"));
  EXPECT_THAT(html, Not(HasSubstr("<odometry>")));
}

TEST(Table2Page, Markdown) {
  const std::string text = table2_markdown(small());
  EXPECT_THAT(text, HasSubstr("| Maps cycles | *yes, not nested*: ring 9 of 10 (!) |\n"));
  EXPECT_THAT(text, HasSubstr("| Raw data | *yes*: – |\n"));
  EXPECT_THAT(text, HasSubstr("| hybrid | 3 of 4 |"));
}

TEST(Table2Page, Json) {
  const auto json = nlohmann::json::parse(table2_json(small()));
  const auto& cell = json["rows"][0]["cells"]["hybrid"];
  EXPECT_EQ(cell["word"], "yes, not nested");
  EXPECT_EQ(cell["measured"], "ring 9 of 10");
  EXPECT_EQ(cell["agrees"], false);
  EXPECT_FALSE(json["rows"][1]["cells"]["hybrid"].contains("agrees"));
  EXPECT_EQ(json["figures"][0]["usable"], 3);
}

}  // namespace
}  // namespace majak::draw
