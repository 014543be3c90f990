#include "nav/inverse_depth.h"

#include <array>
#include <cmath>

namespace headway::nav {
namespace {

/// Collinear neighbours this many times `same_surface` apart are still a slope, and not two edges.
constexpr float kSteepest = 6;

struct Sample {
  float w = 0, sigma = 0;
};

/// The mean of the nearest samples, two or more, on one surface; nothing when there are none.
Sample near_cluster(const std::array<Sample, 4>& block, float resolution) {
  float nearest = std::max(std::max(block[0].w, block[1].w), std::max(block[2].w, block[3].w));
  while (nearest > 0) {
    Sample sum;
    int count = 0;
    float next = 0;
    for (const Sample& s : block) {
      if (s.w > nearest || s.w <= 0) continue;
      if (nearest - s.w <= same_surface(nearest, s.sigma, resolution)) {
        sum = {sum.w + s.w, sum.sigma + s.sigma};
        ++count;
      } else {
        next = std::max(next, s.w);
      }
    }
    if (count >= 2) return {sum.w / static_cast<float>(count), sum.sigma / static_cast<float>(count)};
    nearest = next;
  }
  return {};
}

}  // namespace

void invert(const vision::RangeView& view, float least_weight, InverseDepthImage& out) {
  out.reset(view.camera.width, view.camera.height);
  const auto near = static_cast<float>(view.near);
  const bool weighted = !view.weight.empty();
  for (int v = 0; v < out.height; ++v) {
    const float* depth = view.depth.data() + view.index(0, v);
    const float* sigma = view.sigma_depth.data() + view.index(0, v);
    const float* weight = weighted ? view.weight.data() + view.index(0, v) : nullptr;
    float* w = out.w.data() + out.index(0, v);
    float* s = out.sigma.data() + out.index(0, v);
    for (int u = 0; u < out.width; ++u) {
      const bool trusted = !weighted || weight[u] >= least_weight;
      const bool known = depth[u] >= near && sigma[u] >= 0 && trusted;
      const float inverse = 1 / (known ? depth[u] : 1.0F);
      w[u] = known ? inverse : 0.0F;
      s[u] = known ? sigma[u] * inverse * inverse : 0.0F;
    }
  }
}

void halve(const InverseDepthImage& in, float resolution, InverseDepthImage& out) {
  out.reset((in.width + 1) / 2, (in.height + 1) / 2);
  const auto below = static_cast<std::size_t>(in.stride());
  for (int y = 0; y < out.height; ++y) {
    for (int x = 0; x < out.width; ++x) {
      const std::size_t i = in.index(2 * x, 2 * y);  // the ring makes up an odd edge
      const auto at = [&](std::size_t k) { return Sample{in.w[k], in.sigma[k]}; };
      const Sample s = near_cluster({at(i), at(i + 1), at(i + below), at(i + below + 1)}, resolution);
      out.w[out.index(x, y)] = s.w;
      out.sigma[out.index(x, y)] = s.sigma;
    }
  }
}

std::size_t smooth(const InverseDepthImage& in, int supporters, float resolution, InverseDepthImage& out) {
  out.reset(in.width, in.height);
  const std::ptrdiff_t down = in.stride();
  const std::array<std::ptrdiff_t, 4> steps{1, down - 1, down, down + 1};
  std::size_t dropped = 0;
  for (int y = 0; y < in.height; ++y) {
    for (int x = 0; x < in.width; ++x) {
      const std::size_t i = in.index(x, y);
      const float* w = in.w.data() + i;
      if (*w <= 0) continue;
      const float tolerance = same_surface(*w, in.sigma[i], resolution);
      float sum = *w, weight = 1;
      int support = 0;
      for (const std::ptrdiff_t step : steps) {
        const float p = w[step], q = w[-step];
        const float to_p = std::abs(p - *w), to_q = std::abs(q - *w);
        const bool pair =
            p > 0 && q > 0 && std::abs(p + q - 2 * *w) <= 2 * tolerance && to_p <= kSteepest * tolerance;
        if (pair) {
          sum += p + q;
          weight += 2;
          support += 2;
        } else {
          support += (p > 0 && to_p <= tolerance) + (q > 0 && to_q <= tolerance);
        }
      }
      if (support < supporters) {
        ++dropped;
        continue;
      }
      out.w[i] = sum / weight;
      out.sigma[i] = in.sigma[i];
    }
  }
  return dropped;
}

}  // namespace headway::nav
