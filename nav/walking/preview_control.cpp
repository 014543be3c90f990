#include "nav/walking/preview_control.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <string>

#include "hal/error.h"

namespace headway::nav {
namespace {

// The entries of P span eight decades, so the design is computed in the widest type at hand.
using Wide = long double;
using Matrix4 = Eigen::Matrix<Wide, 4, 4>;
using Vector4 = Eigen::Matrix<Wide, 4, 1>;
using RowVector4 = Eigen::Matrix<Wide, 1, 4>;

struct Cart {
  Eigen::Matrix3d a;
  Eigen::Vector3d b;
  Eigen::RowVector3d c;
};

/// Cart on a table, jerk as input (paper, equation 13).
Cart cart(const PreviewConfig& config) {
  const double t = config.period;
  Cart m;
  m.a << 1, t, t * t / 2, 0, 1, t, 0, 0, 1;
  m.b << t * t * t / 6, t * t / 2, t;
  m.c << 1, 0, -config.com_height / config.gravity;
  return m;
}

/// The system with the summed error in front, and its costs.
struct Augmented {
  Matrix4 f, q;
  Vector4 g;
  Wide r;

  explicit Augmented(const PreviewConfig& config) : r(config.jerk_weight) {
    const Cart m = cart(config);
    f.setZero();
    f(0, 0) = 1;
    f.block<1, 3>(0, 1) = (m.c * m.a).cast<Wide>();
    f.block<3, 3>(1, 1) = m.a.cast<Wide>();
    g << Wide((m.c * m.b).value()), m.b.cast<Wide>();
    q.setZero();
    q(0, 0) = config.error_weight;
    q.diagonal().tail<3>().setConstant(config.state_weight);
  }
  Wide weight(const Matrix4& p) const { return r + (g.transpose() * p * g).value(); }
  RowVector4 gain(const Matrix4& p) const { return g.transpose() * p * f / weight(p); }
  Matrix4 closed_loop(const Matrix4& p) const { return f - g * gain(p); }
  /// What the Riccati equation leaves over.
  Matrix4 residual(const Matrix4& p) const {
    return f.transpose() * p * f - p - f.transpose() * p * g * gain(p) + q;
  }
};

/// Structure-preserving doubling: each pass squares what is left of the error.
Matrix4 solve_by_doubling(const Augmented& s) {
  Matrix4 a = s.f, g = s.g * s.g.transpose() / s.r, h = s.q;
  for (int pass = 0; pass < 60; ++pass) {
    const Matrix4 w = (Matrix4::Identity() + g * h).inverse();
    const Matrix4 more = a.transpose() * h * w * a;
    g += a * w * g * a.transpose();
    a = (a * w * a).eval();
    h += more;
    if (more.norm() < Wide(1e-17) * h.norm()) break;
  }
  return (h + h.transpose()) / 2;
}

/// X = A^T X A + R, by doubling.
Matrix4 solve_lyapunov(Matrix4 a, Matrix4 r) {
  for (int pass = 0; pass < 40; ++pass) {
    const Matrix4 more = a.transpose() * r * a;
    r += more;
    a = (a * a).eval();
    if (more.norm() < Wide(1e-18) * r.norm()) break;
  }
  return r;
}

Matrix4 solve_riccati(const Augmented& s) {
  Matrix4 p = solve_by_doubling(s);
  for (int newton = 0; newton < 4; ++newton) {
    const Matrix4 correction = solve_lyapunov(s.closed_loop(p), s.residual(p));
    const Matrix4 next = p + (correction + correction.transpose()) / 2;
    if (!(s.residual(next).norm() < s.residual(p).norm())) break;
    p = next;
  }
  return p;
}

void require(bool ok, const std::string& what) {
  if (!ok) throw InputError("walking.preview: " + what);
}

}  // namespace

void PreviewConfig::validate() const {
  require(com_height > 0.05 && com_height < 10, "com_height must lie between 0.05 and 10 m");
  require(period >= 1e-4 && period <= 0.1, "period must lie between 0.0001 and 0.1 s");
  require(window >= period && window <= 10, "window must last at least one period and at most 10 s");
  require(error_weight > 0 && jerk_weight > 0, "error_weight and jerk_weight must be positive");
  require(state_weight >= 0, "state_weight must not be negative");
  require(gravity > 0, "gravity must be positive");
}

std::size_t PreviewConfig::ticks() const { return static_cast<std::size_t>(std::lround(window / period)); }

PreviewGains preview_gains(const PreviewConfig& config) {
  config.validate();
  const Augmented system(config);
  const Matrix4 p = solve_riccati(system);
  const RowVector4 k = system.gain(p);
  const Matrix4 closed = system.closed_loop(p);

  PreviewGains gains;
  gains.integral = static_cast<double>(k(0));
  gains.state = k.tail<3>().cast<double>();
  gains.residual = static_cast<double>(system.residual(p).norm() / p.norm());
  gains.spectral_radius = closed.cast<double>().eval().eigenvalues().cwiseAbs().maxCoeff();

  // Equation 20: f_1 = K_e, f_{j+1} = (R + G^T P G)^{-1} G^T (A_c^T)^j P I.
  Vector4 x = closed.transpose() * p.col(0);
  gains.preview.push_back(gains.integral);
  for (std::size_t j = 1; j < config.ticks(); ++j) {
    const Wide f = system.g.dot(x) / system.weight(p);
    gains.preview.push_back(static_cast<double>(f));
    x = (closed.transpose() * x).eval();
  }
  return gains;
}

PreviewControl::PreviewControl(const PreviewConfig& config)
    : gains_(preview_gains(config)), height_over_gravity_(config.com_height / config.gravity) {
  const Cart m = cart(config);
  motion_ = m.a;
  push_ = m.b;
  rest_at({0, 0});
}

void PreviewControl::rest_at(const Eigen::Vector2d& com) noexcept {
  state_.setZero();
  state_.row(0) = com.transpose();
  error_sum_.setZero();
}

void PreviewControl::tick(std::span<const Eigen::Vector2d> ahead) noexcept {
  const Eigen::Vector2d here = com();
  Eigen::Vector2d foreseen(0, 0);
  for (std::size_t j = 0; j < gains_.preview.size(); ++j) foreseen += gains_.preview[j] * (ahead[j] - here);

  const Eigen::RowVector2d jerk =
      foreseen.transpose() - gains_.integral * error_sum_ - gains_.state.tail<2>() * state_.bottomRows<2>();
  state_ = (motion_ * state_ + push_ * jerk).eval();
  error_sum_ += (zmp() - ahead[0]).transpose();
}

Eigen::Vector2d PreviewControl::capture_point() const noexcept {
  return com() + std::sqrt(height_over_gravity_) * velocity();
}

}  // namespace headway::nav
