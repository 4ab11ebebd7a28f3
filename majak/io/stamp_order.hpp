// SPDX-License-Identifier: Apache-2.0
// StampOrder: events of several sensors in the order of their stamps, where a file has them in the
// order of their arrival. An event waits until another is a window later; one that comes later
// still is given out at once, so that memory is bounded and nothing is lost.
#pragma once

#include <algorithm>
#include <cstddef>
#include <map>
#include <optional>
#include <utility>

#include "majak/core/event.hpp"

namespace majak::io {

class StampOrder {
 public:
  explicit StampOrder(Duration window = kSecond, std::size_t most = 4096)
      : window_(window), most_(most) {}

  void add(Event event) {
    const Time time = time_of(event);
    newest_ = newest_ ? std::max(*newest_, time) : time;
    waiting_.emplace(time, std::move(event));
  }

  /// No more events will come: all that wait may go.
  void close() { closed_ = true; }

  /// True when the earliest event need not wait any longer.
  bool ready() const {
    if (waiting_.empty()) return false;
    return closed_ || waiting_.size() > most_ || *newest_ - waiting_.begin()->first >= window_;
  }
  /// The earliest event; only where there is one.
  Event take() {
    Event event = std::move(waiting_.begin()->second);
    waiting_.erase(waiting_.begin());
    return event;
  }

 private:
  Duration window_;
  std::size_t most_;
  std::multimap<Time, Event> waiting_;  ///< equal stamps keep the order of the file
  std::optional<Time> newest_;
  bool closed_ = false;
};

}  // namespace majak::io
