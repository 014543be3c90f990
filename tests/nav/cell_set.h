// A set of cells for oracles: a plain grid of flags around the origin.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <utility>
#include <vector>

namespace headway::nav {

/// Cells with both coordinates in [lowest, lowest + side).
class CellSet {
 public:
  CellSet(int lowest, int side)
      : lowest_(lowest),
        side_(side),
        flags_(static_cast<std::size_t>(side) * static_cast<std::size_t>(side)) {}

  void insert(const Eigen::Vector2i& cell) { flags_.at(index(cell)) = 1; }
  bool contains(const Eigen::Vector2i& cell) const { return flags_.at(index(cell)) != 0; }
  bool includes(const CellSet& other) const {
    for (std::size_t i = 0; i < flags_.size(); ++i) {
      if (other.flags_[i] > flags_[i]) return false;
    }
    return true;
  }
  std::vector<Eigen::Vector2i> cells() const {
    std::vector<Eigen::Vector2i> found;
    for (std::size_t i = 0; i < flags_.size(); ++i) {
      if (flags_[i] == 0) continue;
      const int n = static_cast<int>(i);
      found.emplace_back(lowest_ + n % side_, lowest_ + n / side_);
    }
    return found;
  }

 private:
  std::size_t index(const Eigen::Vector2i& cell) const {
    return static_cast<std::size_t>((cell.y() - lowest_) * side_ + cell.x() - lowest_);
  }

  int lowest_, side_;
  std::vector<char> flags_;
};

}  // namespace headway::nav
