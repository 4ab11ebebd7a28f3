// SPDX-License-Identifier: Apache-2.0
// CarmenReader: a CARMEN log as a Source. docs/FORMATS.md lists the messages and quirks.
#pragma once

#include <deque>
#include <memory>
#include <string>

#include "majak/io/byte_stream.hpp"
#include "majak/io/carmen_habits.hpp"
#include "majak/io/carmen_record.hpp"
#include "majak/io/line_reader.hpp"
#include "majak/io/source.hpp"

namespace majak::io {

class CarmenReader final : public Source {
 public:
  /// `format` is for people: "CARMEN log, gzip".
  CarmenReader(std::unique_ptr<ByteStream> bytes, std::string format);

  std::optional<Event> next() override;
  const Report& report() const override { return report_; }
  const std::string& format() const override { return format_; }

 private:
  struct Waiting {
    CarmenRecord record;
    std::int64_t line = 0;
  };

  bool read_record();
  void watch_window();
  void finish();

  LineReader lines_;
  std::string format_;
  CarmenHabits habits_;
  CarmenRecord record_;
  std::deque<Waiting> window_;
  bool settled_ = false;
  bool finished_ = false;
  Report report_;
};

}  // namespace majak::io
