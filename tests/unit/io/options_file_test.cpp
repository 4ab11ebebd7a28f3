// SPDX-License-Identifier: Apache-2.0
#include "majak/io/options_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>

#include "majak/core/error.hpp"
#include "majak/core/random.hpp"

namespace majak::io {
namespace {

using testing::AllOf;
using testing::HasSubstr;

struct Options {
  double max_range = 30;
  int iterations = 20;
  bool deskew = true;
  double lag = 0;
  double step = 0.5;
};

OptionFields fields_of(Options& o) {
  OptionFields fields;
  fields.add("match.max_range", o.max_range, {"m", "longer beams are not matched", 1, 100});
  fields.add("match.iterations", o.iterations, {"1", "at most so many", 1, 1000});
  fields.add("deskew", o.deskew, {"", "beams have times of their own"});
  fields.add("motion.lag", o.lag, {"s", "the odometry is this much late"});
  fields.add("match.coarse.step", o.step, {"m", "first search", 0.01});
  return fields;
}

std::string error_of(const std::string& toml) {
  Options options;
  OptionFields fields = fields_of(options);
  try {
    apply_options(fields, toml, "my.toml");
  } catch (const Error& e) {
    EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos) << "more than one line";
    EXPECT_EQ(options.max_range, 30) << "half of a bad file was taken";
    return e.what();
  }
  return "no error";
}

TEST(OptionsToml, WritesTablesWithUnitsAndHelp) {
  Options options;
  EXPECT_EQ(options_toml(fields_of(options)), R"(# beams have times of their own
deskew = true

[match]
# longer beams are not matched (m, 1 ... 100)
max_range = 30.0
# at most so many (1 ... 1000)
iterations = 20

[motion]
# the odometry is this much late (s)
lag = 0.0

[match.coarse]
# first search (m, 0.01 ... any)
step = 0.5
)");
}

TEST(OptionsToml, OfNothingIsEmpty) { EXPECT_EQ(options_toml({}), ""); }

TEST(OptionsToml, ReadsBackEveryDoubleExactly) {
  RandomStream random(5);
  std::vector<double> values = {0.1,
                                -0.1,
                                1e-300,
                                1e300,
                                1.0 / 3,
                                5e-324,
                                std::numeric_limits<double>::max(),
                                std::numeric_limits<double>::infinity(),
                                -0.0,
                                123456789.0,
                                1e22,
                                -1e-7};
  for (int i = 0; i < 300; ++i)
    values.push_back(random.normal() * std::exp(random.uniform(-200, 200)));
  for (const double value : values) {
    Options written, read;
    written.lag = value;
    OptionFields to = fields_of(read);
    apply_options(to, options_toml(fields_of(written)), "x");
    EXPECT_EQ(read.lag, value);
    EXPECT_EQ(std::signbit(read.lag), std::signbit(value));
  }
}

TEST(OptionsToml, WritingWhatWasReadGivesTheSameBytes) {
  Options options;
  options.max_range = 0.1 + 0.2 + 5;
  options.deskew = false;
  options.iterations = 7;
  const std::string text = options_toml(fields_of(options));
  Options read;
  OptionFields fields = fields_of(read);
  apply_options(fields, text, "x");
  EXPECT_EQ(options_toml(fields), text);
  EXPECT_FALSE(read.deskew);
}

TEST(ApplyOptions, TakesWhatIsNamedAndLeavesTheRest) {
  Options options;
  OptionFields fields = fields_of(options);
  apply_options(fields, "match.max_range = 12\nmatch.iterations = 0x10\n", "x");
  EXPECT_EQ(options.max_range, 12);
  EXPECT_EQ(options.iterations, 16);
  EXPECT_TRUE(options.deskew);
}

TEST(ApplyOptions, SaysWhereAnUnknownOptionIs) {
  EXPECT_THAT(error_of("[match]\n\nmax_rnge = 3"),
              AllOf(HasSubstr("my.toml:3: option match.max_rnge is unknown")));
  EXPECT_THAT(error_of("max_range = 3"), HasSubstr("there is match.max_range"));
  EXPECT_THAT(error_of("[nonsense]\nx = 1"), HasSubstr("my.toml:2"));
}

TEST(ApplyOptions, SaysWhichTypeIsWanted) {
  EXPECT_THAT(error_of("deskew = 1"), HasSubstr("my.toml:1: option deskew must be true or false"));
  EXPECT_THAT(error_of("[match]\niterations = 1.5"),
              HasSubstr("my.toml:2: option match.iterations must be a whole number"));
  EXPECT_THAT(error_of("[motion]\nlag = \"late\""),
              HasSubstr("option motion.lag must be a number"));
  EXPECT_THAT(error_of("[motion]\nlag = [1]"), HasSubstr("option motion.lag must be a number"));
  EXPECT_THAT(error_of("deskew = \"true\""), HasSubstr("must be true or false"));
  EXPECT_THAT(error_of("match = 3"), HasSubstr("option match is unknown"));
}

TEST(ApplyOptions, SaysTheRange) {
  EXPECT_THAT(error_of("match.max_range = 0.5"),
              HasSubstr("my.toml:1: option match.max_range is 0.5, but must be from 1 to 100 m"));
  EXPECT_THAT(error_of("match.max_range = nan"), HasSubstr("option match.max_range is nan"));
  EXPECT_THAT(error_of("match.iterations = 100000000000"), HasSubstr("must be from 1 to 1000"));
  EXPECT_THAT(error_of("match.coarse.step = 0"), HasSubstr("must be from 0.01 to any"));
}

TEST(ApplyOptions, SaysWhereTheTextIsNoToml) {
  EXPECT_THAT(error_of("[match]\nmax_range = = 3"), HasSubstr("my.toml:2: not valid TOML"));
  EXPECT_THAT(error_of("deskew = true\ndeskew = false"), HasSubstr("my.toml:2"));
  EXPECT_THAT(error_of(std::string("\xff\xfe\0\1", 4)), HasSubstr("my.toml:1"));
  EXPECT_THAT(error_of("\n[i\xEF\xBA\xBF"), HasSubstr("my.toml:2: not valid TOML"));
}

TEST(ApplyOptions, TakesNothingFromAFileWithAnError) {
  error_of("match.max_range = 12\nmatch.iterations = 0");  // checks it
}

TEST(ApplyOption, ReadsOneAssignment) {
  Options options;
  OptionFields fields = fields_of(options);
  apply_option(fields, "match.coarse.step=0.25");
  apply_option(fields, "deskew=false");
  EXPECT_EQ(options.step, 0.25);
  EXPECT_FALSE(options.deskew);
  EXPECT_THROW(apply_option(fields, "deskew"), Error);
  EXPECT_THROW(apply_option(fields, "deskew="), Error);
  EXPECT_THROW(apply_option(fields, "deskew=true\nmatch.iterations=3"), Error);
}

TEST(ApplyOptionsFile, SaysThatAFileCannotBeRead) {
  Options options;
  OptionFields fields = fields_of(options);
  for (const std::string& path :
       {std::string("/nonexistent/options.toml"), std::string(testing::TempDir())}) {
    EXPECT_THROW(apply_options_file(fields, path), Error) << path;
  }
  const std::string path = testing::TempDir() + "/majak_options_test.toml";
  std::ofstream(path) << "deskew = false\n";
  apply_options_file(fields, path);
  EXPECT_FALSE(options.deskew);
  std::remove(path.c_str());
}

}  // namespace
}  // namespace majak::io
