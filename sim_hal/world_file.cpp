#include "sim_hal/world_file.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>

#include "hal/angle.h"

namespace headway::sim {

using config::Section;
using Eigen::Vector2d, Eigen::Vector3d;

namespace {

constexpr config::Range kPlace{-500, 500, "m"};
constexpr config::Range kAngle{-360, 360, "deg"};
constexpr config::Range kLength{0.005, 1000, "m"};
constexpr config::Range kShare{0, 1};
constexpr double kStepsOver = 0.08, kRobotHeight = 1.70;  // what is between them is in the way of a robot [m]
constexpr double kLongest = 1e6;                          // that anything moves [s]
constexpr std::size_t kMostThings = 5000;  // a world beyond this is a mistake, and would only be slow

Vector2d vector2(const Section& s, std::string_view key, config::Range allowed = kPlace) {
  const auto v = s.numbers(key, 2, allowed);
  return {v[0], v[1]};
}

Vector3d vector3(const Section& s, std::string_view key, config::Range allowed = kPlace) {
  const auto v = s.numbers(key, 3, allowed);
  return {v[0], v[1], v[2]};
}

// [x, y, yaw_deg]
Pose2 pose(const Section& s, std::string_view key) {
  const auto v = s.numbers(key, 3, kPlace);
  return {v[0], v[1], wrap_angle(v[2] * kDegree)};
}

class Reader {
 public:
  explicit Reader(const Section& file) : file_(file) {}

  World read() {
    count();
    read_head();
    read_textures();
    read_floor_and_walls();
    read_furniture();
    for (const Section& s : file_.sections("moving")) world_.moving.push_back(moving(s));
    file_.finish();
    check();
    return std::move(world_);
  }

 private:
  /// Before any is made: each makes several solids, and an alias costs a file three bytes.
  void count() const {
    std::size_t things = 0;
    for (const char* list : {"textures", "walls", "boxes", "cylinders", "tables", "shelves", "moving"})
      things += file_.sections(list).size();
    if (things > kMostThings)
      file_.fail("", fmt::format("lists {} things, expected at most {}", things, kMostThings));
  }

  void read_head() {
    world_.name = file_.text("name");
    world_.seed = static_cast<std::uint64_t>(file_.integer_or("seed", 1, {0, 2e9}));
    world_.start = pose(file_, "start");
    if (file_.has("goal")) {
      world_.goal = Goal2{vector2(file_, "goal"), std::nullopt};
      if (file_.has("goal_yaw_deg"))
        world_.goal->yaw = wrap_angle(file_.number("goal_yaw_deg", kAngle) * kDegree);
    }
    if (const auto light = file_.section_if("light")) {
      world_.light = vector3(*light, "at");
      world_.ambient = light->number_or("ambient", world_.ambient, kShare);
    }
  }

  void read_textures() {
    const auto list = file_.sections("textures");
    if (!list.empty()) world_.textures.clear();
    for (const Section& s : list) {
      const Texture standard;
      Texture t;
      t.name = s.text("name");
      const std::string kind = s.choice_or("kind", "noise", {"noise", "checker", "plain"});
      t.kind = kind == "noise" ? Texture::Kind::kNoise
                               : (kind == "checker" ? Texture::Kind::kChecker : Texture::Kind::kPlain);
      t.brightness = s.number_or("brightness", standard.brightness, kShare);
      t.contrast = s.number_or("contrast", standard.contrast, kShare);
      t.grain = s.number_or("grain", standard.grain, {0.0005, 10, "m"});
      t.octaves = s.integer_or("octaves", standard.octaves, {1, 12});
      if (find_texture(t.name) >= 0)
        s.fail("name", fmt::format("'{}' is already the name of a texture", t.name));
      world_.textures.push_back(t);
    }
  }

  int find_texture(const std::string& name) const {
    const auto& all = world_.textures;
    const auto found = std::find_if(all.begin(), all.end(), [&](const Texture& t) { return t.name == name; });
    return found == all.end() ? -1 : static_cast<int>(found - all.begin());
  }

  int texture(const Section& s) const {
    if (!s.has("texture")) return 0;
    const std::string name = s.text("texture");
    const int index = find_texture(name);
    if (index < 0 || name.empty())
      s.fail("texture",
             fmt::format("'{}' is not a texture of this world; name one from the list 'textures'", name));
    return index;
  }

  void read_floor_and_walls() {
    if (const auto s = file_.section_if("floor")) {
      if (s->has("centre")) world_.floor.centre = vector2(*s, "centre");
      world_.floor.size = vector2(*s, "size", kLength);
      world_.floor.texture = texture(*s);
    }
    if (const auto s = file_.section_if("room")) {
      const Vector2d centre = s->has("centre") ? vector2(*s, "centre") : Vector2d(0, 0);
      const Vector2d size = vector2(*s, "size", kLength);
      add_room(world_, centre, size, s->number("height", kLength), texture(*s));
      // The floor of a room reaches under its walls, unless the file says otherwise.
      if (!file_.has("floor")) world_.floor = {centre, size + Vector2d(0.2, 0.2), world_.floor.texture};
    }
    for (const Section& s : file_.sections("walls")) {
      const Vector2d from = vector2(s, "from"), to = vector2(s, "to");
      if ((to - from).norm() < kLength.lowest)
        s.fail("to", "is the same place as 'from', expected another one");
      add_wall(world_, s.text_or("name", "wall"), from, to, s.number("height", kLength),
               s.number_or("thickness", 0.1, kLength), texture(s));
    }
  }

  void read_furniture() {
    for (const Section& s : file_.sections("boxes"))
      world_.things.push_back({s.text_or("name", "box"),
                               Solid::box(vector3(s, "centre"), vector3(s, "size", kLength),
                                          s.number_or("yaw_deg", 0, kAngle) * kDegree),
                               texture(s)});
    for (const Section& s : file_.sections("cylinders"))
      world_.things.push_back(
          {s.text_or("name", "cylinder"),
           Solid::cylinder(vector3(s, "base"), s.number("radius", kLength), s.number("height", kLength)),
           texture(s)});
    for (const Section& s : file_.sections("tables")) {
      const Vector3d size = vector3(s, "size", {0.15, 100, "m"});
      add_table(world_, s.text_or("name", "table"), pose(s, "at"), size,
                s.choice_or("stands_on", "legs", {"legs", "panels"}) == "panels", texture(s));
    }
    for (const Section& s : file_.sections("shelves"))
      add_shelves(world_, s.text_or("name", "shelves"), pose(s, "at"), vector3(s, "size", {0.1, 100, "m"}),
                  s.integer_or("boards", 4, {1, 50}), texture(s));
  }

  MovingThing moving(const Section& s) const {
    MovingThing m;
    m.thing = {s.text("name"), moving_solid(s), texture(s)};
    m.path = path(s);
    m.thing.solid.pose = m.path.front().pose;
    m.starts.near = m.path.back().pose.position();
    if (const auto when = s.section_if("starts_when")) m.starts = trigger(*when, m.starts.near);
    return m;
  }

  static Solid moving_solid(const Section& s) {
    if (s.has("box") == s.has("cylinder")) s.fail("box", "a moving thing is either a 'box' or a 'cylinder'");
    const Section shape = s.section(s.has("box") ? "box" : "cylinder");
    const double bottom = shape.number_or("bottom", 0, kPlace);
    if (s.has("cylinder"))
      return Solid::cylinder({0, 0, bottom}, shape.number("radius", kLength),
                             shape.number("height", kLength));
    const Vector3d size = vector3(shape, "size", kLength);
    return Solid::box({0, 0, bottom + size.z() / 2}, size);
  }

  static double length(const std::vector<Pose2>& poses) {
    double sum = 0;
    for (std::size_t i = 1; i < poses.size(); ++i)
      sum += (poses[i].position() - poses[i - 1].position()).norm();
    return sum;
  }

  // Either a speed for the whole path, or a time at each of its places.
  static std::vector<TimedPose> path(const Section& s) {
    const auto places = s.sections("path");
    if (places.empty())
      s.fail("path", "has no places, expected a list of {x, y, yaw_deg} or {t, x, y, yaw_deg}");
    std::vector<Pose2> poses;
    for (const Section& p : places)
      poses.push_back(
          {p.number("x", kPlace), p.number("y", kPlace), p.number_or("yaw_deg", 0, kAngle) * kDegree});
    if (s.has("speed")) {
      const double speed = s.number("speed", {0.001, 20, "m/s"});
      if (const double time = length(poses) / speed; time > kLongest)
        s.fail("speed", fmt::format("{} m/s, at which the path takes {:.3g} s, expected at most {:g} s",
                                    speed, time, kLongest));
      return path_at_speed(poses, speed);
    }
    std::vector<TimedPose> timed;
    for (std::size_t i = 0; i < places.size(); ++i) {
      const Duration t = seconds(i == 0 ? places[i].number_or("t", 0, {0, 0, "s"})
                                        : places[i].number("t", {0, kLongest, "s"}));
      if (!timed.empty() && t <= timed.back().after)
        places[i].fail("t", fmt::format("{} s, expected later than the place before ({} s)", to_seconds(t),
                                        to_seconds(timed.back().after)));
      timed.push_back({t, poses[i]});
    }
    return timed;
  }

  static Trigger trigger(const Section& s, const Vector2d& end_of_path) {
    const int named = s.has("at_time") + s.has("robot_within") + s.has("robot_walked") + s.has("robot_sees");
    if (named != 1)
      s.fail("", "expected one of: at_time (s), robot_within (m), robot_walked (m), robot_sees (m)");
    Trigger t;
    t.near = s.has("of") ? vector2(s, "of") : end_of_path;
    if (s.has("at_time")) {
      t.kind = Trigger::Kind::kAtTime;
      t.value = s.number("at_time", {0, 1e6, "s"});
    } else if (s.has("robot_within")) {
      t.kind = Trigger::Kind::kRobotWithin;
      t.value = s.number("robot_within", {0, 1000, "m"});
    } else if (s.has("robot_sees")) {
      t.kind = Trigger::Kind::kRobotSees;
      t.value = s.number("robot_sees", {0, 1000, "m"});
      t.warning = s.number_or("warning", 0, {0, 1000, "s"});
    } else {
      t.kind = Trigger::Kind::kRobotWalked;
      t.value = s.number("robot_walked", {0, 1e6, "m"});
    }
    return t;
  }

  void check() const {
    const std::size_t solids = world_.things.size() + world_.moving.size();
    if (solids > kMostThings)
      file_.fail("", fmt::format("holds {} solids, expected at most {}", solids, kMostThings));
    const Vector2d start = world_.start.position();
    if (((start - world_.floor.centre).cwiseAbs() - world_.floor.size / 2).maxCoeff() >= 0)
      file_.fail("start",
                 fmt::format("[{}, {}] lies off the floor, expected a place on it", start.x(), start.y()));
    check_goal();
    for (const Solid& s : world_.solids())
      if (floor_distance(s, Solid::cylinder({start.x(), start.y(), 0}, 0.01, 2)) == 0 && s.bottom < 2)
        file_.fail("start",
                   fmt::format("[{}, {}] lies in an obstacle, expected free floor", start.x(), start.y()));
  }

  void check_goal() const {
    if (!world_.goal) return;
    const Vector2d goal = world_.goal->position;
    if (((goal - world_.floor.centre).cwiseAbs() - world_.floor.size / 2).maxCoeff() >= 0)
      file_.fail("goal",
                 fmt::format("[{}, {}] lies outside the floor, expected a place on it", goal.x(), goal.y()));
    if (const Thing* thing = obstacle_at(world_, goal, kStepsOver, kRobotHeight))
      file_.fail("goal", fmt::format("[{}, {}] lies in an obstacle ({}), expected free floor", goal.x(),
                                     goal.y(), thing->name));
  }

  const Section& file_;
  World world_;
};

}  // namespace

World world_from(const Section& section) { return Reader(section).read(); }

World read_world(const std::filesystem::path& file) { return world_from(Section::load(file, "world")); }

}  // namespace headway::sim
