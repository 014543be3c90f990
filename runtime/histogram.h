// How durations are spread, on a logarithmic scale in memory that never grows. One thread adds, any may look.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "hal/time.h"

namespace headway::runtime {

/// What is told of a spread; all zero of none.
struct Spread {
  std::uint64_t count = 0;
  Duration p50{}, p99{}, p999{}, max{};
};

/// Buckets that are a 32nd of their power of two wide: below 64 ns exact, above too high by less than a 32nd.
/// What lasts longer than 18 minutes counts as that.
class Histogram {
 public:
  /// By one thread only. A negative duration counts as zero.
  void add(Duration d) noexcept {
    const auto value = static_cast<std::uint64_t>(std::clamp<Duration::rep>(d.count(), 0, kLargest));
    raise(buckets_[bucket_of(value)]);
    if (value > max_.load(std::memory_order_relaxed)) max_.store(value, std::memory_order_relaxed);
    raise(count_);
  }

  std::uint64_t count() const noexcept { return count_.load(std::memory_order_relaxed); }
  Duration max() const noexcept { return Duration(max_.load(std::memory_order_relaxed)); }

  /// The least duration that at least this share (0 to 1) of all is not longer than, up to a 32nd too high;
  /// zero of none. What another thread adds meanwhile may count or not.
  Duration quantile(double share) const noexcept {
    std::uint64_t all = 0;
    for (const auto& bucket : buckets_) all += bucket.load(std::memory_order_relaxed);
    const double wanted = share * static_cast<double>(all);
    std::uint64_t so_far = 0;
    for (std::size_t i = 0; i < kBuckets; ++i) {
      const std::uint64_t here = buckets_[i].load(std::memory_order_relaxed);
      so_far += here;
      if (here > 0 && static_cast<double>(so_far) >= wanted)
        return std::min(Duration(static_cast<Duration::rep>(last_of(i))), max());
    }
    return max();
  }

  Spread spread() const noexcept { return {count(), quantile(0.5), quantile(0.99), quantile(0.999), max()}; }

 private:
  static constexpr int kFine = 5;  // a bucket's share of its power of two, as a power of two
  static constexpr std::uint64_t kSteps = 1U << kFine;
  static constexpr int kPowers = 40;
  static constexpr Duration::rep kLargest = (Duration::rep{1} << kPowers) - 1;
  static constexpr std::size_t kBuckets = (kPowers - kFine + 1) * kSteps;

  /// The first 2 kSteps values have a bucket each; each power of two above has kSteps buckets.
  static constexpr std::size_t bucket_of(std::uint64_t value) noexcept {
    const int coarse = std::max(0, static_cast<int>(std::bit_width(value)) - 1 - kFine);
    return static_cast<std::size_t>(static_cast<std::uint64_t>(coarse) * kSteps + (value >> coarse));
  }
  /// The largest value of a bucket.
  static constexpr std::uint64_t last_of(std::size_t bucket) noexcept {
    if (bucket < 2 * kSteps) return bucket;
    const std::uint64_t coarse = bucket / kSteps - 1;
    return ((bucket - coarse * kSteps + 1) << coarse) - 1;
  }

  /// There is one writer: no need for a read-modify-write that others cannot come between.
  static void raise(std::atomic<std::uint64_t>& count) noexcept {
    count.store(count.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  }

  std::array<std::atomic<std::uint64_t>, kBuckets> buckets_{};
  std::atomic<std::uint64_t> max_{0}, count_{0};
};

}  // namespace headway::runtime
