// SPDX-License-Identifier: Apache-2.0
// Hub: what clients are to see, held once for all of them. A client is a cursor, so one that is
// slow costs nothing and holds up nobody. Any thread may call anything.
//
//   Hub hub(head);                                    // magic, header, schemas, channels
//   hub.reset({count, [site](std::size_t i) { return record_of(*site, i); }},
//             {{"/run", run}, {"/map", map}, {"/graph", graph, count}});
//   hub.append(record);                               // reliable: every client gets it, in order
//   hub.set("/particles", record);                    // the newest is enough
//
// All bytes are whole MCAP records; the hub does not look into them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

namespace majak::serve {

using Bytes = std::shared_ptr<const std::string>;

/// Numbered records that every client gets, in order. They are made anew for each client, on the
/// server's thread, maybe after reset(): `record` owns what it reads (capture a shared_ptr) and
/// guards what changes. An empty string is passed over; one that throws is passed over and counted.
struct Backlog {
  std::size_t size = 0;
  std::function<std::string(std::size_t)> record{};
};

/// When a slot's value may be sent.
constexpr std::size_t kAtOnce = 0;  ///< it overtakes the backlog: right for what stands by itself
/// Exactly between the records appended before it was set and those after: right for what tells how
/// they are meant.
constexpr std::size_t kInOrder = static_cast<std::size_t>(-1);

/// The newest value under a name.
struct Slot {
  std::string name;
  std::string value;
  std::size_t after = kAtOnce;  ///< or kInOrder, or: not before so many records of the backlog
};

/// Where a client stands.
class Cursor {
  friend class Hub;
  bool greeted_ = false;
  std::uint64_t generation_ = 0;
  std::size_t record_ = 0;
  std::vector<std::uint64_t> seen_;  ///< by slot, which of its changes was sent; 0 none
};

/// Bytes for one message to a client. Large values are shared with the hub, small ones copied
/// together.
struct Frame {
  std::vector<Bytes> pieces;
  std::size_t bytes = 0;
  std::size_t skipped = 0;  ///< values of slots that were replaced before this client got them
  bool empty() const { return bytes == 0; }
};

struct HubStatistics {
  std::size_t records = 0;  ///< of the backlog
  std::size_t kept = 0;     ///< bytes that the hub holds: appended records and values of slots
  std::size_t failed = 0;   ///< records that could not be made
};

class Hub {
 public:
  /// `head` is sent first and once to every client.
  explicit Hub(std::string head);
  ~Hub();
  Hub(const Hub&) = delete;
  Hub& operator=(const Hub&) = delete;

  /// A new generation: every client gets everything anew, slots first in the order given. What was
  /// appended and set before is forgotten.
  void reset(Backlog backlog = {}, std::vector<Slot> slots = {});
  /// The first `size` records can be made now, where it was fewer. Not after append().
  void grow(std::size_t size);
  void append(std::string record);
  /// To a client that has none of the slots yet they go in the order in which they were first set.
  void set(const std::string& name, std::string value, std::size_t after = kAtOnce);

  /// What the client at `cursor` is to get next; the cursor moves on. About `limit` bytes of slots
  /// and as many of the backlog, so that neither starves the other; one value may be larger. Empty:
  /// nothing new.
  Frame next(Cursor& cursor, std::size_t limit = std::size_t{64} << 10);

  HubStatistics statistics() const;

  /// Called, with the hub locked, whenever there is something new; returns at once and does not
  /// call the hub.
  using Watcher = std::function<void()>;
  std::uint64_t watch(Watcher watcher);
  void unwatch(std::uint64_t number);

 private:
  struct Value {
    std::string name;
    Bytes bytes;
    std::size_t after = 0;
    std::uint64_t changes = 0;  ///< how often it was set in this generation
    std::uint64_t order = 0;    ///< among all changes of all slots
  };
  /// One step of next(): bytes, or the number of a record to make.
  struct Step {
    enum class Kind { none, slot, record, make } kind = Kind::none;
    Bytes bytes{};
    std::shared_ptr<const Backlog> made{};
    std::size_t record = 0, skipped = 0;
  };

  struct Due {
    const Value* next = nullptr;
    bool holds_records = false;  ///< one of those that are due has to go before the next record
  };

  Step step(Cursor& cursor, bool slots, bool records);
  void enter_generation(Cursor& cursor) const;
  Due due_slots(const Cursor& cursor) const;
  void put(const std::string& name, std::string value, std::size_t after);
  std::string make(const Step& step);
  void changed();
  std::size_t size() const { return made_->size + appended_.size(); }

  mutable std::mutex mutex_;
  const Bytes head_;
  std::uint64_t generation_ = 1;
  std::shared_ptr<const Backlog> made_;
  std::vector<Bytes> appended_;
  std::vector<Value> slots_;
  std::uint64_t changes_ = 0;
  std::size_t appended_bytes_ = 0, failed_ = 0;
  std::map<std::uint64_t, Watcher> watchers_;
  std::uint64_t watcher_numbers_ = 0;
};

}  // namespace majak::serve
