// SPDX-License-Identifier: Apache-2.0
// Report: what was noticed on the way. The library never prints; it counts here.
#pragma once

#include <cstdint>
#include <map>
#include <string>

namespace majak {

class Report {
 public:
  struct Entry {
    std::int64_t count = 0;
    std::int64_t first_line = 0;  ///< line or record number of the first one, 0 if it has none
  };

  /// One more of `what` (a short sentence without numbers, so that equal ones add up).
  void count(const std::string& what, std::int64_t line = 0) {
    Entry& entry = entries_[what];
    if (entry.count++ == 0) entry.first_line = line;
  }
  void add(const std::string& what, const Entry& more) {
    Entry& entry = entries_[what];
    if (entry.count == 0) entry.first_line = more.first_line;
    entry.count += more.count;
  }

  /// Sorted by text, so that two equal runs give equal bytes.
  const std::map<std::string, Entry>& entries() const { return entries_; }
  bool empty() const { return entries_.empty(); }

 private:
  std::map<std::string, Entry> entries_;
};

}  // namespace majak
