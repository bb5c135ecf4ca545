// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <optional>

namespace sheen {

/// Hands out ranges of a growing address space, first fit; released neighbours melt together.
class RangeAllocator {
 public:
  std::size_t capacity() const { return capacity_; }
  std::size_t used() const { return used_; }

  void extend(std::size_t by) {
    if (by == 0) return;
    insert_free(capacity_, by);
    capacity_ += by;
  }

  /// First address of `size` > 0 units in a row; nothing where no gap is that large.
  std::optional<std::size_t> allocate(std::size_t size) {
    for (auto gap = free_.begin(); gap != free_.end(); ++gap) {
      if (gap->second < size) continue;
      const auto [first, length] = *gap;
      free_.erase(gap);
      if (length > size) free_.emplace(first + size, length - size);
      used_ += size;
      return first;
    }
    return std::nullopt;
  }

  void release(std::size_t first, std::size_t size) {
    insert_free(first, size);
    used_ -= size;
  }

 private:
  void insert_free(std::size_t first, std::size_t size) {
    auto next = free_.lower_bound(first);
    if (next != free_.end() && first + size == next->first) {
      size += next->second;
      next = free_.erase(next);
    }
    if (next != free_.begin()) {
      const auto before = std::prev(next);
      if (before->first + before->second == first) {
        before->second += size;
        return;
      }
    }
    free_.emplace_hint(next, first, size);
  }

  std::map<std::size_t, std::size_t> free_;  ///< first address -> length
  std::size_t capacity_ = 0;
  std::size_t used_ = 0;
};

}  // namespace sheen
