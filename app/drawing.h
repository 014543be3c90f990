// What every picture is made of: colours, text, legends and scale bars on an OpenCV canvas, and PNG files.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

namespace headway::app {

/// Blue, green, red, as everywhere in OpenCV. All canvases are CV_8UC3.
using Colour = cv::Vec3b;

namespace colours {
inline const Colour kBackground{28, 24, 22};  ///< behind images, and where nothing was measured
inline const Colour kPaper{255, 255, 255};
inline const Colour kInk{40, 36, 34};
inline const Colour kLow{66, 134, 196};  // what may be stepped over
inline const Colour kPale{215, 210, 205};
inline const Colour kPath{20, 130, 240}, kLeftFoot{200, 100, 20}, kRightFoot{50, 150, 30};
// Told apart by colour-blind readers as well (Okabe and Ito).
inline const Colour kBlue{178, 114, 0}, kSkyBlue{233, 180, 86}, kGreen{115, 158, 0}, kOrange{0, 159, 230},
    kVermilion{0, 94, 213}, kPurple{167, 121, 204};
}  // namespace colours

/// As OpenCV's drawing functions take it.
cv::Scalar scalar(const Colour& colour);

/// Perceptually uniform colour maps: equal differences look equal, and brightness alone tells the order.
enum class Ramp {
  kViridis,  ///< for depths and heights
  kInferno,  ///< for uncertainties
};
/// `share` is clamped to 0..1.
Colour ramp_colour(Ramp ramp, double share);

/// `a` where share is 0, `b` where it is 1.
Colour mixed(const Colour& a, const Colour& b, double share);

cv::Mat canvas(int width, int height, const Colour& background);

enum class Align { kLeft, kCentre, kRight };
/// Text of about `height` pixels (capitals), standing on the baseline at `at`. Draws ASCII only.
void draw_text(cv::Mat& image, const std::string& text, cv::Point at, const Colour& colour, int height = 11,
               Align align = Align::kLeft);
int text_width(const std::string& text, int height = 11);
/// Words in lines of at most `width` pixels; a word that is wider gets a line of its own.
std::vector<std::string> wrapped(const std::string& text, int width, int height = 11);

/// Steps of 1, 2 or 5 times a power of ten that divide the range into about `wanted` parts.
double tick_step(double range, int wanted);

/// One mark of a legend: at `share` (0..1) of the ramp stands `label`.
struct Tick {
  double share = 0;
  std::string label;
};
/// Marks at round values between `lowest` and `highest`; the labels carry no unit.
std::vector<Tick> linear_ticks(double lowest, double highest, int wanted = 6);
/// Marks at 1, 2 and 5 times powers of ten of lengths [m]; the labels carry mm or m.
std::vector<Tick> logarithmic_length_ticks(double lowest, double highest);

/// The image with a title above it, on as many lines as it takes, and, on its right side, the ramp with its
/// marks.
cv::Mat with_legend(const cv::Mat& image, const std::string& title, Ramp ramp,
                    const std::vector<Tick>& ticks);

/// A line of a legend of things drawn: a patch of colour and what it means.
struct Key {
  Colour colour;
  std::string label;
  enum class Shape { kPatch, kLine, kDot, kFrame } shape = Shape::kPatch;
};
/// Draws keys downwards from `top_left`; returns the height used [px].
int draw_keys(cv::Mat& image, cv::Point top_left, const std::vector<Key>& keys, const Colour& ink);

/// How much room keys take [px].
cv::Size size_of(const std::vector<Key>& keys);

/// A translucent plate of paper, on which text can be read whatever lies behind it.
void draw_plate(cv::Mat& image, const cv::Rect& area);

/// A bar of a round length [m], about `wanted_px` wide, with its label above; `at` is its left end.
void draw_scale_bar(cv::Mat& image, cv::Point at, double px_per_metre, int wanted_px, const Colour& colour);

struct Captioned {
  cv::Mat image;
  std::string caption;
};
/// Pictures side by side, of one height (that of the first), each with its caption below.
cv::Mat strip(const std::vector<Captioned>& pictures);

/// Writes a PNG; it appears whole or not at all. Equal images give equal bytes. Throws as
/// nav::write_whole does, and InputError for an empty image.
void write_png(const cv::Mat& image, const std::filesystem::path& file);

}  // namespace headway::app
