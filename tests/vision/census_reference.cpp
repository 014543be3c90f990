#include "census_reference.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <utility>

namespace headway::vision::test {

namespace {

constexpr int kNone = -16;

using Costs = std::vector<int>;  // of one pixel, by disparity

int at(const hal::GrayImage& image, int x, int y) {
  x = std::clamp(x, 0, image.width - 1), y = std::clamp(y, 0, image.height - 1);
  return image.pixels[static_cast<std::size_t>(y * image.width + x)];
}

std::vector<bool> comparisons(const hal::GrayImage& image, int x, int y) {
  std::vector<bool> bits;
  const int centre = at(image, x, y);
  for (int dy = -2; dy <= 2; ++dy)
    for (int dx = -2; dx <= 2; ++dx) {
      if (dy < 0 || (dy == 0 && dx < 0))
        bits.push_back(at(image, x + dx, y + dy) > at(image, x - dx, y - dy));
      const bool neighbour = std::max(std::abs(dx), std::abs(dy)) == 1, corner = std::abs(dx * dy) == 4;
      if (neighbour || corner) bits.push_back(at(image, x + dx, y + dy) > centre);
    }
  return bits;
}

int slope(const hal::GrayImage& image, int x, int y) {
  int sobel = 0;
  for (int dy = -1; dy <= 1; ++dy)
    sobel += (dy == 0 ? 2 : 1) * (at(image, x + 1, y + dy) - at(image, x - 1, y + dy));
  return std::clamp(static_cast<int>(std::floor(sobel / 4.0 + 0.5)), -12, 12);
}

class Reference {
 public:
  Reference(const hal::GrayImage& left, const hal::GrayImage& right, DisparityRange range,
            const CensusConfig& config)
      : left_(left), right_(right), range_(range), config_(config) {
    if (config.borders) return;
    first_ = std::clamp(range.lowest + range.count, 0, left.width);
    end_ = std::clamp(left.width + std::min(0, range.lowest), first_, left.width);
  }

  DisparityImage run() {
    find_costs();
    sums_.assign(costs_.size(), Costs(static_cast<std::size_t>(range_.count), 0));
    follow(1, 0), follow(-1, 0), follow(0, 1);
    if (config_.penalties.paths == 4) follow(0, -1);
    find_winners();
    drop_speckles();
    return result();
  }

 private:
  std::size_t index(int x, int y) const { return static_cast<std::size_t>(y * left_.width + x); }

  void find_costs() {
    for (int y = 0; y < left_.height; ++y)
      for (int x = 0; x < left_.width; ++x) {
        const auto bits = comparisons(left_, x, y);
        Costs costs;
        for (int i = 0; i < range_.count; ++i) {
          const int partner = x - range_.lowest - i;
          if (partner < 0 || partner >= left_.width) {
            costs.push_back(kOutsideCost);
            continue;
          }
          const auto other = comparisons(right_, partner, y);
          int cost = std::min(std::abs(slope(left_, x, y) - slope(right_, partner, y)), 12);
          for (std::size_t b = 0; b < bits.size(); ++b) cost += bits[b] != other[b];
          costs.push_back(cost);
        }
        costs_.push_back(costs);
      }
  }

  int jump(int x, int y, int from_x, int from_y) const {
    const SgmPenalties& p = config_.penalties;
    const int step = std::abs(at(left_, x, y) - at(left_, from_x, from_y));
    return std::max(p.p2_least, p.p2 * p.p2_edge / (p.p2_edge + step));
  }

  // All pixels along one direction; a path begins where its pixel before lies outside the columns.
  void follow(int dx, int dy) {
    std::vector<Costs> path(costs_.size());
    for (int j = 0; j < left_.height; ++j)
      for (int i = first_; i < end_; ++i) {
        const int y = dy < 0 ? left_.height - 1 - j : j, x = dx < 0 ? end_ - 1 - (i - first_) : i;
        const int from_x = x - dx, from_y = y - dy;
        const bool begins = from_x < first_ || from_x >= end_ || from_y < 0 || from_y >= left_.height;
        Costs& here = path[index(x, y)];
        here = costs_[index(x, y)];
        if (!begins) step(path[index(from_x, from_y)], jump(x, y, from_x, from_y), here);
        for (std::size_t d = 0; d < here.size(); ++d)
          sums_[index(x, y)][d] = std::min(255, sums_[index(x, y)][d] + here[d]);
      }
  }

  void step(const Costs& before, int p2, Costs& here) const {
    const int least = *std::min_element(before.begin(), before.end());
    for (std::size_t d = 0; d < here.size(); ++d) {
      int best = std::min(before[d], least + p2);
      if (d > 0) best = std::min(best, before[d - 1] + config_.penalties.p1);
      if (d + 1 < here.size()) best = std::min(best, before[d + 1] + config_.penalties.p1);
      here[d] += best - least;
    }
  }

  static std::size_t winner(const Costs& sums) {
    return static_cast<std::size_t>(std::min_element(sums.begin(), sums.end()) - sums.begin());
  }

  // Of a pixel of the right image: the first of the least sums, from the highest disparity down.
  int winner_of_right(int partner, int y) const {
    int best = 255, found = 0;
    for (int i = range_.count - 1; i >= 0; --i) {
      const int x = partner + range_.lowest + i;
      if (x < first_ || x >= end_) continue;
      const int sum = sums_[index(x, y)][static_cast<std::size_t>(i)];
      if (sum < best) best = sum, found = i;
    }
    return found;
  }

  void find_winners() {
    found_.assign(costs_.size(), kNone);
    for (int y = 0; y < left_.height; ++y)
      for (int x = first_; x < end_; ++x) {
        const Costs& sums = sums_[index(x, y)];
        const std::size_t w = winner(sums);
        int offset = 0;
        if (w > 0 && w + 1 < sums.size()) {
          const int a = sums[w - 1] - sums[w], c = sums[w + 1] - sums[w];
          offset = static_cast<int>(
              std::floor(8.0F * static_cast<float>(a - c) / static_cast<float>(std::max({a, c, 1})) + 0.5F));
        }
        found_[index(x, y)] = 16 * static_cast<int>(w) + offset;
      }
    smooth_ = found_;
    for (int y = 0; y < left_.height; ++y)
      for (int x = 0; x < left_.width; ++x) {
        if (x > 0 && x + 1 < left_.width) smooth_[index(x, y)] = median(x, y);
        if (disagreement(x, y) > config_.left_right_difference) smooth_[index(x, y)] = kNone;
      }
  }

  int median(int x, int y) const {
    std::vector<int> around;
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx)
        around.push_back(found_[index(x + dx, std::clamp(y + dy, 0, left_.height - 1))]);
    std::sort(around.begin(), around.end());
    return around[4];
  }

  bool flat(int x, int y) const {
    const auto bits = comparisons(left_, x, y);
    return std::none_of(bits.begin(), bits.end(), [](bool bit) { return bit; }) && slope(left_, x, y) == 0;
  }

  int disagreement(int x, int y) const {
    if (x < first_ || x >= end_ || flat(x, y)) return 255;
    const int w = static_cast<int>(winner(sums_[index(x, y)])), partner = x - range_.lowest - w;
    return partner < 0 || partner >= left_.width ? 255 : std::abs(winner_of_right(partner, y) - w);
  }

  void drop_speckles() {
    const int step = static_cast<int>(std::lround(16 * config_.speckle_range));
    std::vector<bool> visited(smooth_.size());
    for (std::size_t start = 0; start < smooth_.size(); ++start) {
      if (visited[start] || smooth_[start] < 0) continue;
      std::vector<std::size_t> patch{start};
      visited[start] = true;
      for (std::size_t i = 0; i < patch.size(); ++i) {
        const int x = static_cast<int>(patch[i]) % left_.width, y = static_cast<int>(patch[i]) / left_.width;
        for (const auto& [dx, dy] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
          if (x + dx < 0 || x + dx >= left_.width || y + dy < 0 || y + dy >= left_.height) continue;
          const std::size_t beside = index(x + dx, y + dy);
          if (visited[beside] || smooth_[beside] < 0 || std::abs(smooth_[beside] - smooth_[patch[i]]) > step)
            continue;
          visited[beside] = true;
          patch.push_back(beside);
        }
      }
      if (static_cast<int>(patch.size()) > config_.speckle_size) continue;
      for (const std::size_t i : patch) smooth_[i] = kNone;
    }
  }

  DisparityImage result() const {
    DisparityImage out;
    out.resize(left_.width, left_.height);
    out.ambiguity = out.values;
    for (int y = 0; y < left_.height; ++y)
      for (int x = first_; x < end_; ++x) {
        const std::size_t i = index(x, y);
        if (smooth_[i] < 0) continue;
        const float d = static_cast<float>(range_.lowest) + static_cast<float>(smooth_[i]) / 16;
        const float doubt = disagreement(x, y) > 2 ? 0.95F : 1 - rivals(x) / 16.0F;
        const float ambiguity = std::max(ratio(sums_[i]), doubt);
        const float partner = static_cast<float>(x) - d;
        if (partner < 0 || partner > static_cast<float>(left_.width - 1)) continue;
        if (ambiguity > static_cast<float>(config_.most_ambiguous)) continue;
        out.values[i] = d, out.ambiguity[i] = ambiguity;
      }
    return out;
  }

  // Disparities that lead into the right image.
  float rivals(int x) const {
    int n = 0;
    for (int i = 0; i < range_.count; ++i)
      n += x - range_.lowest - i >= 0 && x - range_.lowest - i < left_.width;
    return static_cast<float>(n);
  }

  static float ratio(const Costs& sums) {
    const int w = static_cast<int>(winner(sums));
    int second = 255;
    for (int d = 0; d < static_cast<int>(sums.size()); ++d)
      if (std::abs(d - w) > 1) second = std::min(second, sums[static_cast<std::size_t>(d)]);
    return static_cast<float>(sums[static_cast<std::size_t>(w)] + 1) / static_cast<float>(second + 1);
  }

  const hal::GrayImage &left_, &right_;
  DisparityRange range_;
  CensusConfig config_;
  int first_ = 0, end_ = left_.width;
  std::vector<Costs> costs_, sums_;
  std::vector<int> found_, smooth_;
};

}  // namespace

DisparityImage census_reference(const hal::GrayImage& left, const hal::GrayImage& right, DisparityRange range,
                                const CensusConfig& config) {
  return Reference(left, right, range, config).run();
}

}  // namespace headway::vision::test
