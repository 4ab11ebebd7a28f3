// SPDX-License-Identifier: Apache-2.0
// SharedArray: a growing array in pages that its copies share. A copy costs a pointer for each
// page; who writes to a page that others have as well gets a page of its own first. So many
// versions of one thing (the maps of a particle filter) need the memory of one and of what differs.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <utility>
#include <vector>

namespace majak::map {

/// Pages of 2^kPageBits elements. Copies may be read, written and let go of by a thread each.
template <class T, int kPageBits>
class SharedArray {
 public:
  std::size_t size() const { return size_; }
  const T& operator[](std::size_t i) const { return pages_[i >> kPageBits]->values[i & kMask]; }
  /// To write to; the rest of the page may be written to as well. Valid until the next copy.
  T& write(std::size_t i) { return pages_[i >> kPageBits].own().values[i & kMask]; }

  void push_back(const T& value) { resize(size_ + 1, value); }
  void resize(std::size_t size, const T& value) {
    pages_.resize((size + kMask) >> kPageBits);
    for (; size_ < size; ++size_) write(size_) = value;
    size_ = size;
  }
  void clear() { resize(0, {}); }

  /// Of all pages, and of the table of them.
  std::size_t bytes() const { return table_bytes() + pages_.size() * sizeof(Page); }
  /// The same with a page counted by the share of it: over all copies it adds up to what they need
  /// together.
  double share_of_bytes() const {
    double sum = static_cast<double>(table_bytes());
    for (const Handle& page : pages_) sum += sizeof(Page) / static_cast<double>(page->owners);
    return sum;
  }

 private:
  static constexpr std::size_t kMask = (std::size_t{1} << kPageBits) - 1;

  struct Page {
    std::atomic<int> owners = 1;
    std::array<T, kMask + 1> values{};
  };

  class Handle {
   public:
    Handle() : page_(new Page) {}
    Handle(const Handle& other) noexcept : page_(other.page_) {
      page_->owners.fetch_add(1, std::memory_order_relaxed);
    }
    Handle(Handle&& other) noexcept : page_(std::exchange(other.page_, nullptr)) {}
    Handle& operator=(Handle other) noexcept {
      std::swap(page_, other.page_);
      return *this;
    }
    ~Handle() {
      if (page_ && page_->owners.fetch_sub(1, std::memory_order_acq_rel) == 1) delete page_;
    }
    const Page* operator->() const { return page_; }
    // Whoever was the other owner has done reading when the count says that it is gone.
    Page& own() {
      if (page_->owners.load(std::memory_order_acquire) > 1) {
        Handle copy;
        copy.page_->values = page_->values;
        std::swap(page_, copy.page_);
      }
      return *page_;
    }

   private:
    Page* page_;
  };

  std::size_t table_bytes() const { return pages_.capacity() * sizeof(Handle); }

  std::vector<Handle> pages_;
  std::size_t size_ = 0;
};

}  // namespace majak::map
