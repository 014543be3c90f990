#include "vision/evaluation.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "hal/error.h"

namespace headway::vision {

namespace {

constexpr float kGross = 2;  // [px] error beyond which a match is one with something else

double share(std::size_t part, std::size_t whole) {
  return whole == 0 ? 0 : static_cast<double>(part) / static_cast<double>(whole);
}

bool partner_inside(const DisparityImage& image, int u, float d) {
  const float partner = static_cast<float>(u) - d;
  return partner >= 0 && partner <= static_cast<float>(image.width - 1);
}

// For each column of one row of the right image, the largest true disparity that lands there: what it sees.
std::vector<float> seen_from_right(const DisparityImage& truth, int v) {
  std::vector<float> seen(static_cast<std::size_t>(truth.width), -std::numeric_limits<float>::infinity());
  for (int u = 0; u < truth.width; ++u) {
    const float d = truth.values[truth.index(u, v)];
    if (std::isnan(d) || !partner_inside(truth, u, d)) continue;
    float& best = seen[static_cast<std::size_t>(std::lround(static_cast<float>(u) - d))];
    best = std::max(best, d);
  }
  return seen;
}

// True when something nearer lands on the partner of (u, v), or beside it (surfaces leave gaps when
// stretched).
bool hidden(const DisparityImage& truth, const std::vector<float>& seen, int u, float d) {
  const long partner = std::lround(static_cast<float>(u) - d);
  for (long c = std::max(0L, partner - 1); c <= std::min<long>(truth.width - 1, partner + 1); ++c)
    if (seen[static_cast<std::size_t>(c)] > d + 1.5F) return true;
  return false;
}

bool near_edge(const DisparityImage& truth, int u, int v) {
  constexpr int kReach = 3;
  const float d = truth.values[truth.index(u, v)];
  for (int row = std::max(0, v - kReach); row <= std::min(truth.height - 1, v + kReach); ++row)
    for (int column = std::max(0, u - kReach); column <= std::min(truth.width - 1, u + kReach); ++column)
      if (std::abs(truth.values[truth.index(column, row)] - d) > kGross) return true;
  return false;
}

// Running sums over the pixels.
struct Counts {
  std::size_t all = 0, known = 0, matched = 0, off_1 = 0, gross = 0;
  std::size_t inliers_covered = 0, hidden = 0, at_edge = 0, elsewhere = 0;
  double squares = 0, z_squares = 0;
  double weight = 0, covered_weight = 0;
  std::vector<float> sigmas, right_weights, wrong_weights;

  void add_error(float error) {
    ++matched;
    off_1 += error > 1;
    gross += error > kGross;
    if (error <= kGross) squares += static_cast<double>(error * error);
  }
  // True when the point lies within 3 sigma.
  bool add_sigma(float error, float sigma, double share_of_one) {
    sigmas.push_back(sigma);
    const bool inside = error <= 3 * sigma;
    weight += share_of_one;
    if (inside) covered_weight += share_of_one;
    if (error > kGross) return inside;
    inliers_covered += inside;
    z_squares += static_cast<double>(error * error / (sigma * sigma));
    return inside;
  }
};

double percentile(std::vector<float>& values, double p) {
  if (values.empty()) return 0;
  const auto place = values.begin() + static_cast<std::ptrdiff_t>(p * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), place, values.end());
  return static_cast<double>(*place);
}

/// How often one of `wrong` is below one of `right`; ties count half.
double auc(std::vector<float>& right, std::vector<float>& wrong) {
  if (right.empty() || wrong.empty()) return 0;
  std::sort(right.begin(), right.end());
  double below = 0;
  for (const float a : wrong) {
    const auto [first, last] = std::equal_range(right.begin(), right.end(), a);
    below += static_cast<double>(right.end() - last) + 0.5 * static_cast<double>(last - first);
  }
  return below / (static_cast<double>(right.size()) * static_cast<double>(wrong.size()));
}

double rms(double squares, std::size_t count) {
  return count == 0 ? 0 : std::sqrt(squares / static_cast<double>(count));
}

MatchQuality summary(Counts& n) {
  const std::size_t inliers = n.matched - n.gross, outside = n.hidden + n.at_edge + n.elsewhere;
  MatchQuality q;
  q.known = n.known, q.matched = n.matched;
  q.density = share(n.matched, n.known), q.density_of_all = share(n.matched, n.all);
  q.bad_1 = share(n.off_1, n.matched), q.bad_2 = share(n.gross, n.matched);
  q.inlier_rms = rms(n.squares, inliers);
  q.outside_hidden = share(n.hidden, outside), q.outside_at_edge = share(n.at_edge, outside);
  q.outside_elsewhere = share(n.elsewhere, outside);
  q.weight_auc = auc(n.right_weights, n.wrong_weights);
  if (n.sigmas.empty()) return q;
  q.coverage_3_sigma = n.weight > 0 ? n.covered_weight / n.weight : 0;
  q.inlier_coverage = share(n.inliers_covered, inliers);
  q.inlier_z_rms = rms(n.z_squares, inliers);
  q.sigma_p10 = percentile(n.sigmas, 0.1), q.sigma_median = percentile(n.sigmas, 0.5);
  q.sigma_p90 = percentile(n.sigmas, 0.9);
  return q;
}

}  // namespace

MatchQuality compare(const DisparityImage& found, const DisparityImage& truth) {
  if (found.width != truth.width || found.height != truth.height)
    throw InputError(fmt::format("the truth has {} x {} px, the disparities {} x {}; expected one size",
                                 truth.width, truth.height, found.width, found.height));
  Counts n;
  for (int v = 0; v < truth.height; ++v) {
    const std::vector<float> seen = seen_from_right(truth, v);
    for (int u = 0; u < truth.width; ++u) {
      const std::size_t i = truth.index(u, v);
      const float d = truth.values[i];
      if (std::isnan(d)) continue;
      ++n.all;
      if (!partner_inside(truth, u, d)) continue;
      ++n.known;
      if (std::isnan(found.values[i])) continue;
      const float error = std::abs(found.values[i] - d);
      n.add_error(error);
      if (!found.weight.empty())
        (error > kGross ? n.wrong_weights : n.right_weights).push_back(found.weight[i]);
      const double weight = found.weight.empty() ? 1 : static_cast<double>(found.weight[i]);
      if (found.sigma.empty() || n.add_sigma(error, found.sigma[i], weight)) continue;
      if (hidden(truth, seen, u, d))
        ++n.hidden;
      else if (near_edge(truth, u, v))
        ++n.at_edge;
      else
        ++n.elsewhere;
    }
  }
  return summary(n);
}

}  // namespace headway::vision
