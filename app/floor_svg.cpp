#include "app/floor_svg.h"

#include <string_view>

#include <fmt/format.h>

#include "hal/angle.h"

namespace headway::app {

namespace {

constexpr double kUnits = 100;  // per metre

std::string hex(const Colour& c) { return fmt::format("#{:02x}{:02x}{:02x}", c[2], c[1], c[0]); }

/// Text that may hold anything, as the content of an element.
std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text)
    out += c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '&' ? "&amp;" : std::string(1, c);
  return out;
}

/// Places metres of the map on the page, whose y points down.
class Page {
 public:
  explicit Page(const nav::FloorGrid& grid) : grid_(grid) {}

  double width() const { return kUnits * grid_.resolution * grid_.width; }
  double height() const { return kUnits * grid_.resolution * grid_.height; }
  double cell() const { return kUnits * grid_.resolution; }
  Eigen::Vector2d at(const Eigen::Vector2d& p) const {
    return {kUnits * (p.x() - grid_.origin.x()), height() - kUnits * (p.y() - grid_.origin.y())};
  }
  std::string point(const Eigen::Vector2d& p) const {
    const Eigen::Vector2d q = at(p);
    return fmt::format("{:.2f},{:.2f}", q.x(), q.y());
  }
  std::string polyline(const std::vector<Eigen::Vector2d>& points) const {
    std::string text = "<polyline points=\"";
    for (const Eigen::Vector2d& p : points) text += point(p) + ' ';
    return text + "\"/>\n";
  }
  /// A rectangle around a pose, its corners rounded by `radius` [m].
  std::string box(const Pose2& pose, double half_depth, double half_width, double radius) const {
    const Eigen::Vector2d c = at(pose.position());
    return fmt::format(
        "<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\" rx=\"{:.2f}\" "
        "transform=\"translate({:.2f} {:.2f}) rotate({:.2f})\"/>\n",
        -kUnits * half_depth, -kUnits * half_width, 2 * kUnits * half_depth, 2 * kUnits * half_width,
        kUnits * radius, c.x(), c.y(), -pose.yaw / kDegree);
  }

 private:
  const nav::FloorGrid& grid_;
};

/// One path of all cells of a kind; a run of cells in a row is one rectangle.
std::string cells(const nav::FloorMap& floor, nav::Floor kind, const Page& page) {
  std::string d;
  const nav::FloorGrid& grid = floor.grid;
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      if (floor.at({x, y}) != kind) continue;
      const int first = x;
      while (x + 1 < grid.width && floor.at({x + 1, y}) == kind) ++x;
      d += fmt::format("M{:.2f} {:.2f}h{:.2f}v{:.2f}h{:.2f}z", first * page.cell(),
                       page.height() - (y + 1) * page.cell(), (x + 1 - first) * page.cell(), page.cell(),
                       -(x + 1 - first) * page.cell());
    }
  }
  return d.empty() ? d : fmt::format("<path d=\"{}\"/>\n", d);
}

std::string group(const char* id, const std::string& style, const std::string& content) {
  if (content.empty()) return {};
  return fmt::format("<g id=\"{}\" style=\"{}\">\n{}</g>\n", id, style, content);
}

std::string stroke(const Colour& colour, double width) {
  return fmt::format("fill:none;stroke:{};stroke-width:{};stroke-linejoin:round", hex(colour), width);
}

std::string feet(const FloorLayers& layers, hal::Foot side, const Page& page) {
  std::string text;
  for (const FootPrint& foot : layers.feet)
    if (foot.foot == side)
      text += page.box(foot.pose, layers.gait.sole_length / 2, layers.gait.sole_width / 2, 0.01);
  return text;
}

/// A ring, and an arrow where a direction is given.
std::string mark(const Eigen::Vector2d& place, std::optional<double> yaw, double radius, const Page& page) {
  const Eigen::Vector2d c = page.at(place);
  std::string text =
      fmt::format("<circle cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"{:.2f}\"/>\n", c.x(), c.y(), kUnits * radius);
  if (!yaw) return text;
  const Pose2 pose{place.x(), place.y(), *yaw};
  return text + page.polyline({place, pose * Eigen::Vector2d(0.35, 0)}) +
         page.polyline({pose * Eigen::Vector2d(0.25, 0.06), pose * Eigen::Vector2d(0.35, 0),
                        pose * Eigen::Vector2d(0.25, -0.06)});
}

}  // namespace

std::string floor_svg(const nav::FloorMap& floor, const FloorLayers& layers, const std::string& title) {
  const Page page(floor.grid);
  std::string bodies;
  const nav::BodyOutline& body = layers.outline;
  const double clear = body.clearance();
  for (const Pose2& base : layers.bodies)
    bodies += page.box(base, body.half_depth + clear, body.half_width + clear, clear);
  const auto line = [&](const std::vector<Eigen::Vector2d>& points) {
    return points.empty() ? std::string() : page.polyline(points);
  };
  const auto filled = [](const Colour& colour) {
    return fmt::format("fill:{};fill-opacity:0.25;stroke:{};stroke-width:1", hex(colour), hex(colour));
  };
  std::string text = fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.2f} {1:.2f}\" width=\"{0:.0f}\" "
      "height=\"{1:.0f}\">\n<title>{2}</title>\n"
      "<rect id=\"unseen\" width=\"{0:.2f}\" height=\"{1:.2f}\" style=\"fill:{3}\"/>\n",
      page.width(), page.height(), escaped(title), hex(colours::kPale));
  text += group("free", "fill:" + hex(colours::kPaper), cells(floor, nav::Floor::kFree, page));
  text += group("blocked", "fill:" + hex(colours::kInk), cells(floor, nav::Floor::kBlocked, page));
  text += group("low", "fill:" + hex(colours::kLow), cells(floor, nav::Floor::kLow, page));
  text += group("bodies",
                fmt::format("fill:{0};fill-opacity:0.06;stroke:{0};stroke-opacity:0.35;stroke-width:0.5",
                            hex(colours::kSkyBlue)),
                bodies);
  text += group("left_feet", filled(colours::kLeftFoot), feet(layers, hal::Foot::kLeft, page));
  text += group("right_feet", filled(colours::kRightFoot), feet(layers, hal::Foot::kRight, page));
  text += group("path", stroke(colours::kPath, 3), line(layers.path));
  text += group("waist", stroke(colours::kPurple, 1.5), line(layers.waist));
  text += group("zmp", stroke(colours::kInk, 1), line(layers.zmp));
  if (layers.start)
    text += group("start", stroke(colours::kInk, 3),
                  mark(layers.start->position(), layers.start->yaw, 0.08, page));
  if (layers.goal)
    text += group("goal", stroke(colours::kVermilion, 4), mark(*layers.goal, layers.goal_yaw, 0.12, page));
  return text + "</svg>\n";
}

}  // namespace headway::app
