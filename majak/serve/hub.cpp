// SPDX-License-Identifier: Apache-2.0
#include "majak/serve/hub.hpp"

#include <algorithm>
#include <cassert>
#include <exception>
#include <utility>

namespace majak::serve {
namespace {

/// Values from here on are sent from where they lie, smaller ones are copied together.
constexpr std::size_t kShare = std::size_t{16} << 10;

Bytes share(std::string bytes) { return std::make_shared<const std::string>(std::move(bytes)); }

/// Small pieces one after another in one string.
class Packer {
 public:
  explicit Packer(Frame& frame) : frame_(frame) {}

  void add(const std::string& bytes) {
    together_ += bytes;
    frame_.bytes += bytes.size();
  }
  void add(const Bytes& bytes) {
    if (bytes->size() < kShare) return add(*bytes);
    flush();
    frame_.pieces.push_back(bytes);
    frame_.bytes += bytes->size();
  }
  void flush() {
    if (!together_.empty()) frame_.pieces.push_back(share(std::exchange(together_, {})));
  }

 private:
  Frame& frame_;
  std::string together_;
};

}  // namespace

Hub::Hub(std::string head)
    : head_(share(std::move(head))), made_(std::make_shared<const Backlog>()) {}

Hub::~Hub() { assert(watchers_.empty()); }

// ---- what the program says --------------------------------------------------------------------

void Hub::reset(Backlog backlog, std::vector<Slot> slots) {
  auto made = std::make_shared<const Backlog>(std::move(backlog));
  const std::lock_guard lock(mutex_);
  ++generation_;
  made_.swap(made);
  appended_.clear();
  appended_bytes_ = 0;
  slots_.clear();
  for (Slot& slot : slots) put(slot.name, std::move(slot.value), slot.after);
  changed();
}

void Hub::grow(std::size_t size) {
  const std::lock_guard lock(mutex_);
  assert(appended_.empty());
  if (size <= made_->size) return;
  made_ = std::make_shared<const Backlog>(Backlog{size, made_->record});
  changed();
}

void Hub::append(std::string record) {
  auto bytes = share(std::move(record));
  const std::lock_guard lock(mutex_);
  appended_bytes_ += bytes->size();
  appended_.push_back(std::move(bytes));
  changed();
}

void Hub::set(const std::string& name, std::string value, std::size_t after) {
  const std::lock_guard lock(mutex_);
  put(name, std::move(value), after);
  changed();
}

void Hub::put(const std::string& name, std::string value, std::size_t after) {
  auto slot = std::find_if(slots_.begin(), slots_.end(),
                           [&](const Value& other) { return other.name == name; });
  if (slot == slots_.end()) slot = slots_.insert(slot, Value{name, {}, 0, 0, 0});
  slot->bytes = share(std::move(value));
  slot->after = after == kInOrder ? size() : after;
  ++slot->changes;
  slot->order = ++changes_;
}

void Hub::changed() {
  for (const auto& [number, watcher] : watchers_) watcher();
}

std::uint64_t Hub::watch(Watcher watcher) {
  const std::lock_guard lock(mutex_);
  watchers_.emplace(++watcher_numbers_, std::move(watcher));
  return watcher_numbers_;
}

void Hub::unwatch(std::uint64_t number) {
  const std::lock_guard lock(mutex_);
  watchers_.erase(number);
}

HubStatistics Hub::statistics() const {
  const std::lock_guard lock(mutex_);
  HubStatistics s{size(), head_->size() + appended_bytes_, failed_};
  for (const Value& slot : slots_) s.kept += slot.bytes->size();
  return s;
}

// ---- what a client gets -----------------------------------------------------------------------

Frame Hub::next(Cursor& cursor, std::size_t limit) {
  Frame frame;
  Packer packer(frame);
  if (!std::exchange(cursor.greeted_, true)) packer.add(head_);
  std::size_t slots = 0, records = 0;
  while (slots < limit || records < limit) {
    const Step now = step(cursor, slots < limit, records < limit);
    if (now.kind == Step::Kind::none) break;
    const std::size_t before = frame.bytes;
    if (now.kind == Step::Kind::make) {
      packer.add(make(now));
    } else {
      packer.add(now.bytes);
    }
    (now.kind == Step::Kind::slot ? slots : records) += frame.bytes - before;
    frame.skipped += now.skipped;
  }
  packer.flush();
  return frame;
}

/// A slot that is due goes before the next record. When no more slots fit into the frame, records
/// pass those that may be overtaken and wait for the others.
Hub::Step Hub::step(Cursor& cursor, bool slots, bool records) {
  const std::lock_guard lock(mutex_);
  enter_generation(cursor);
  const Due due = due_slots(cursor);
  if (slots && due.next) {
    std::uint64_t& seen = cursor.seen_[static_cast<std::size_t>(due.next - slots_.data())];
    const std::uint64_t before = std::exchange(seen, due.next->changes);
    return {Step::Kind::slot, due.next->bytes, {}, 0, before > 0 ? seen - before - 1 : 0};
  }
  if (!records || due.holds_records || cursor.record_ >= size()) return {};
  const std::size_t record = cursor.record_++;
  if (record < made_->size) return {Step::Kind::make, {}, made_, record, 0};
  return {Step::Kind::record, appended_[record - made_->size], {}, record, 0};
}

void Hub::enter_generation(Cursor& cursor) const {
  if (cursor.generation_ != generation_) {
    cursor.generation_ = generation_;
    cursor.record_ = 0;
    cursor.seen_.clear();
  }
  cursor.seen_.resize(slots_.size(), 0);
}

/// `next` is the first slot in order of creation that the client has nothing of, else the one that
/// waits longest.
Hub::Due Hub::due_slots(const Cursor& cursor) const {
  Due due;
  bool fresh = false;
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    const Value& slot = slots_[i];
    if (cursor.seen_[i] == slot.changes || slot.after > cursor.record_) continue;
    if (slot.after != kAtOnce) due.holds_records = true;
    if (fresh) continue;
    fresh = cursor.seen_[i] == 0;
    if (fresh || !due.next || slot.order < due.next->order) due.next = &slot;
  }
  return due;
}

std::string Hub::make(const Step& step) {
  try {
    return step.made->record(step.record);
  } catch (const std::exception&) {
    const std::lock_guard lock(mutex_);
    ++failed_;
    return {};
  }
}

}  // namespace majak::serve
