#include "vision/evaluation.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "hal/error.h"

namespace headway::vision {

namespace {

double share(std::size_t part, std::size_t whole) {
  return whole == 0 ? 0 : static_cast<double>(part) / static_cast<double>(whole);
}

double median(std::vector<float>& values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return static_cast<double>(*middle);
}

}  // namespace

MatchQuality compare(const DisparityImage& found, const DisparityImage& truth) {
  if (found.width != truth.width || found.height != truth.height)
    throw InputError(fmt::format("the truth has {} x {} px, the disparities {} x {}; expected one size",
                                 truth.width, truth.height, found.width, found.height));
  MatchQuality q;
  std::size_t off_1 = 0, off_2 = 0, covered = 0;
  double squares = 0;
  std::vector<float> sigmas;
  for (std::size_t i = 0; i < truth.values.size(); ++i) {
    if (std::isnan(truth.values[i])) continue;
    ++q.known;
    if (std::isnan(found.values[i])) continue;
    ++q.matched;
    const float error = std::abs(found.values[i] - truth.values[i]);
    off_1 += error > 1;
    off_2 += error > 2;
    if (error <= 2) squares += static_cast<double>(error * error);
    if (found.sigma.empty()) continue;
    sigmas.push_back(found.sigma[i]);
    covered += error <= 3 * found.sigma[i];
  }
  q.density = share(q.matched, q.known);
  q.bad_1 = share(off_1, q.matched);
  q.bad_2 = share(off_2, q.matched);
  q.inlier_rms = q.matched == off_2 ? 0 : std::sqrt(squares / static_cast<double>(q.matched - off_2));
  q.coverage_3_sigma = share(covered, sigmas.size());
  q.median_sigma = median(sigmas);
  return q;
}

}  // namespace headway::vision
