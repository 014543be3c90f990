// Preview control of the zero-moment point (Kajita et al., ICRA 2003): the centre of mass of a cart on a
// table is moved so that the ZMP follows a reference known for a while ahead. All lengths in metres, in any
// frame fixed to the floor; x and y are two equal, independent systems.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

namespace headway::nav {

struct PreviewConfig {
  double com_height = 0.814;  ///< z_c [m]
  double period = 0.005;      ///< T [s]
  double window = 1.6;        ///< how far ahead the reference is known [s]
  double error_weight = 1;    ///< Q_e, on the summed ZMP error
  double state_weight = 0;    ///< Q_x, on each change of position, velocity and acceleration
  double jerk_weight = 1e-6;  ///< R
  double gravity = 9.81;      ///< [m/s^2]

  /// Throws InputError when a value makes no sense.
  void validate() const;
  std::size_t ticks() const;  ///< periods in the window
};

/// Jerk u(k) = -K_e sum_{i<=k} e(i) - K_x x(k) + sum_{j=1..N} f_j p_ref(k+j) (paper, equation 17, with the
/// signs of the preview gains turned). An endless sum of the f_j would equal the position's gain; what is
/// missing after the window is left out of both, so that positions enter only as differences and the place of
/// the origin does not matter.
struct PreviewGains {
  double integral = 0;                ///< K_e
  Eigen::RowVector3d state{0, 0, 0};  ///< K_x, on position, velocity, acceleration
  std::vector<double> preview;        ///< f_1 .. f_N
  double residual = 0;                ///< of the Riccati equation, |error| / |P| (Frobenius)
  double spectral_radius = 0;         ///< of the closed loop
};

/// Solves the discrete Riccati equation of the augmented system (doubling, then Newton steps).
PreviewGains preview_gains(const PreviewConfig& config);

/// The cart on its table. Construction computes the gains; after that no call allocates or throws.
class PreviewControl {
 public:
  explicit PreviewControl(const PreviewConfig& config);

  /// At rest over a point: no motion, no error.
  void rest_at(const Eigen::Vector2d& com) noexcept;
  /// One period on. `ahead` holds the reference of this and the following periods: ahead[0] is where the ZMP
  /// ought to be at the end of this period; at least gains().preview.size() values, further ones are not
  /// looked at.
  void tick(std::span<const Eigen::Vector2d> ahead) noexcept;

  Eigen::Vector2d com() const noexcept { return state_.row(0); }
  Eigen::Vector2d velocity() const noexcept { return state_.row(1); }
  Eigen::Vector2d acceleration() const noexcept { return state_.row(2); }
  /// ZMP of the model: p = c - z_c/g c''.
  Eigen::Vector2d zmp() const noexcept { return com() - height_over_gravity_ * acceleration(); }
  /// Where the cart would come to rest: c + c' sqrt(z_c/g).
  Eigen::Vector2d capture_point() const noexcept;
  const PreviewGains& gains() const noexcept { return gains_; }

 private:
  PreviewGains gains_;
  Eigen::Matrix3d motion_;              ///< A
  Eigen::Vector3d push_;                ///< B
  double height_over_gravity_ = 0;      ///< z_c/g [s^2]
  Eigen::Matrix<double, 3, 2> state_;   ///< rows position, velocity, acceleration; columns x, y
  Eigen::RowVector2d error_sum_{0, 0};  ///< sum of ZMP errors [m]
};

}  // namespace headway::nav
