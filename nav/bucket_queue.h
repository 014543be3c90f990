// An open list for whole-numbered costs that never fall: constant time, its memory reused.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

namespace headway::nav {

/// Takes out items by rising key, of equal keys the last one put in first. Keys must not lie below the one
/// last taken.
class BucketQueue {
 public:
  struct Entry {
    std::uint32_t key = 0, item = 0;
  };

  BucketQueue() : heads_(kSpan, kNone) {}

  /// Forgets everything; `lowest` is the least key to come.
  void clear(std::uint32_t lowest) {
    std::fill(heads_.begin(), heads_.begin() + used_, kNone);
    used_ = 0;
    nodes_.clear();
    far_.clear();
    base_ = lowest;
    at_ = 0;
  }

  void push(std::uint32_t key, std::uint32_t item) {
    const std::uint32_t bucket = key - base_;
    if (bucket >= kSpan) {
      far_.push_back({key, item});
      return;
    }
    nodes_.push_back({item, heads_[bucket]});
    heads_[bucket] = static_cast<std::uint32_t>(nodes_.size() - 1);
    used_ = std::max(used_, static_cast<std::ptrdiff_t>(bucket) + 1);
  }

  std::optional<Entry> pop() {
    for (;;) {
      for (; static_cast<std::ptrdiff_t>(at_) < used_; ++at_) {
        std::uint32_t& head = heads_[at_];
        if (head == kNone) continue;
        const Node node = nodes_[head];
        head = node.next;
        return Entry{base_ + at_, node.item};
      }
      if (far_.empty()) return std::nullopt;
      bring_near();
    }
  }

 private:
  static constexpr std::uint32_t kSpan = 1u << 18;
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  struct Node {
    std::uint32_t item, next;
  };

  /// All buckets are empty: move them to where the keys go on.
  void bring_near() {
    moved_.clear();
    std::swap(moved_, far_);
    const auto least = std::min_element(moved_.begin(), moved_.end(),
                                        [](const Entry& a, const Entry& b) { return a.key < b.key; });
    base_ = least->key;
    at_ = 0;
    used_ = 0;
    nodes_.clear();
    for (const Entry& e : moved_) push(e.key, e.item);
  }

  std::vector<std::uint32_t> heads_;
  std::vector<Node> nodes_;
  std::vector<Entry> far_, moved_;
  std::uint32_t base_ = 0, at_ = 0;
  std::ptrdiff_t used_ = 0;
};

}  // namespace headway::nav
