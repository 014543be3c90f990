#include "sim_hal/scene.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <embree3/rtcore.h>

#include "hal/error.h"
#include "sim_hal/movers.h"

namespace headway::sim {

using Eigen::Vector2d, Eigen::Vector3d, Eigen::Vector3f;

namespace {

constexpr int kSides =
    96;  // of the prism that stands in for a cylinder while searching; the hit itself is exact

// A corner of the quad mesh, in the solid's own frame.
using Corners = std::vector<Vector3d>;
using Quads = std::vector<std::array<unsigned, 4>>;

Corners corners_of(const Solid& s) {
  const double h = (s.top - s.bottom) / 2;
  Corners corners;
  if (s.shape == Shape::kBox) {
    for (const double z : {-h, h})
      for (const auto& [x, y] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}})
        corners.emplace_back(x * s.length / 2, y * s.width / 2, z);
    return corners;
  }
  for (const double z : {-h, h}) {
    for (int i = 0; i < kSides; ++i) {
      const double a = 2 * std::numbers::pi * i / kSides;
      corners.emplace_back(s.radius * std::cos(a), s.radius * std::sin(a), z);
    }
    corners.emplace_back(0, 0, z);
  }
  return corners;
}

Quads quads_of(Shape shape) {
  const unsigned n = shape == Shape::kBox ? 4 : kSides, above = shape == Shape::kBox ? 4 : kSides + 1;
  Quads quads;
  for (unsigned i = 0; i < n; ++i) {
    const unsigned next = (i + 1) % n;
    quads.push_back({i, next, above + next, above + i});
  }
  if (shape == Shape::kBox) {
    quads.push_back({0, 3, 2, 1});
    quads.push_back({4, 5, 6, 7});
    return quads;
  }
  for (unsigned i = 0; i < n; i += 2) {  // caps: two slices of the cake to a quad
    const unsigned next = i + 1, over = (i + 2) % n;
    quads.push_back({n, over, next, i});
    quads.push_back({above + n, above + i, above + next, above + over});
  }
  return quads;
}

// A solid with what every ray needs of it.
struct Placed {
  Shape shape = Shape::kBox;
  float x = 0, y = 0, z = 0, c = 1, s = 0;
  float hx = 0, hy = 0, hz = 0, radius = 0;

  explicit Placed(const Solid& solid)
      : shape(solid.shape),
        x(static_cast<float>(solid.pose.x)),
        y(static_cast<float>(solid.pose.y)),
        z(static_cast<float>(solid.centre_height())),
        c(static_cast<float>(std::cos(solid.pose.yaw))),
        s(static_cast<float>(std::sin(solid.pose.yaw))),
        hx(static_cast<float>(solid.length / 2)),
        hy(static_cast<float>(solid.width / 2)),
        hz(static_cast<float>((solid.top - solid.bottom) / 2)),
        radius(static_cast<float>(solid.radius)) {}

  Vector3f to_own(const Vector3f& p) const {
    const float px = p.x() - x, py = p.y() - y;
    return {c * px + s * py, c * py - s * px, p.z() - z};
  }
  Vector3f turned_to_own(const Vector3f& d) const {
    return {c * d.x() + s * d.y(), c * d.y() - s * d.x(), d.z()};
  }
  Vector3f turned_from_own(const Vector3f& d) const {
    return {c * d.x() - s * d.y(), s * d.x() + c * d.y(), d.z()};
  }
};

// Where a ray that the search says meets the solid enters it: the last of the near sides that it passes.
bool enter(const Placed& p, const Vector3f& origin, const Vector3f& direction, RayHit& hit) {
  const Vector3f o = p.to_own(origin), d = p.turned_to_own(direction);
  const float half[3] = {p.hx, p.hy, p.hz};
  float t = -1;
  Vector3f normal(0, 0, 0);
  for (int axis = p.shape == Shape::kBox ? 0 : 2; axis < 3; ++axis) {
    if (d[axis] == 0) continue;
    const float sign = d[axis] > 0 ? -1.0F : 1.0F;
    const float entry = (sign * half[axis] - o[axis]) / d[axis];
    if (entry <= t) continue;
    t = entry;
    normal = Vector3f::Zero();
    normal[axis] = sign;
  }
  if (p.shape == Shape::kCylinder) {
    const float a = d.x() * d.x() + d.y() * d.y(), b = o.x() * d.x() + o.y() * d.y(),
                k = o.x() * o.x() + o.y() * o.y() - p.radius * p.radius;
    const float discriminant = b * b - a * k;
    // k > 0: outside. Citardauq's form keeps the digits that -b - root would lose.
    if (a > 0 && k > 0 && b < 0 && discriminant >= 0) {
      const float entry = k / (-b + std::sqrt(discriminant));
      if (entry > t) {
        t = entry;
        normal = Vector3f(o.x() + t * d.x(), o.y() + t * d.y(), 0).normalized();
      }
    }
  }
  if (!(t > 0)) return false;
  hit.distance = t;
  hit.own_point = o + t * d;
  hit.normal = p.turned_from_own(normal);
  return true;
}

struct DeviceRelease {
  void operator()(RTCDevice d) const { rtcReleaseDevice(d); }
};
struct SceneRelease {
  void operator()(RTCScene s) const { rtcReleaseScene(s); }
};
using Device = std::unique_ptr<std::remove_pointer_t<RTCDevice>, DeviceRelease>;
using RayScene = std::unique_ptr<std::remove_pointer_t<RTCScene>, SceneRelease>;

}  // namespace

struct Scene::Impl {
  World world;
  WorldState state;
  std::vector<Solid> solids;
  std::vector<Placed> placed;
  Device device;
  RayScene rays;
  unsigned floor_id = 0;

  explicit Impl(World w) : world(std::move(w)), state(initial_state(world)), solids(world.solids()) {
    // One thread: the order of the tree, and with it the answer to a tie, must not depend on the machine's
    // load.
    device.reset(rtcNewDevice("threads=1,set_affinity=0"));
    if (!device) throw Error("Embree cannot be started; check that libembree3 fits this machine");
    rays.reset(rtcNewScene(device.get()));
    rtcSetSceneFlags(rays.get(), RTC_SCENE_FLAG_ROBUST);
    for (std::size_t i = 0; i < solids.size(); ++i) {
      attach(quads_of(solids[i].shape), corners_in_map(solids[i]), static_cast<unsigned>(i));
      placed.emplace_back(solids[i]);
    }
    attach_floor();
    rtcCommitScene(rays.get());
    if (rtcGetDeviceError(device.get()) != RTC_ERROR_NONE) throw Error("Embree refuses the world's geometry");
  }

  static Corners corners_in_map(const Solid& s) {
    Corners corners = corners_of(s);
    for (Vector3d& p : corners) p = s.from_own(p);
    return corners;
  }

  static void fill(float* buffer, const Corners& corners) {
    for (const Vector3d& p : corners)
      for (int axis = 0; axis < 3; ++axis) *buffer++ = static_cast<float>(p[axis]);
  }

  void attach(const Quads& quads, const Corners& corners, unsigned id) {
    const RTCGeometry g = rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_QUAD);
    auto* const vertices = static_cast<float*>(rtcSetNewGeometryBuffer(
        g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), corners.size()));
    auto* indices = static_cast<unsigned*>(rtcSetNewGeometryBuffer(
        g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4, 4 * sizeof(unsigned), quads.size()));
    if (vertices == nullptr || indices == nullptr)
      throw Error("Embree has no memory for the world's geometry");
    fill(vertices, corners);
    for (const auto& q : quads) indices = std::copy(q.begin(), q.end(), indices);
    rtcCommitGeometry(g);
    rtcAttachGeometryByID(rays.get(), g, id);
    rtcReleaseGeometry(g);
  }

  void attach_floor() {
    floor_id = static_cast<unsigned>(solids.size());
    const Vector2d low = world.floor.centre - world.floor.size / 2,
                   high = world.floor.centre + world.floor.size / 2;
    attach({{0, 1, 2, 3}},
           {{low.x(), low.y(), 0}, {high.x(), low.y(), 0}, {high.x(), high.y(), 0}, {low.x(), high.y(), 0}},
           floor_id);
  }

  void place_moving() {
    const std::vector<Pose2> poses = moving_poses(world, state);
    bool moved = false;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const std::size_t index = world.things.size() + i;
      Solid& solid = solids[index];
      const Pose2 &was = solid.pose, &is = poses[i];
      if (was.x == is.x && was.y == is.y && was.yaw == is.yaw) continue;
      solid.pose = is;
      placed[index] = Placed(solid);
      const RTCGeometry g = rtcGetGeometry(rays.get(), static_cast<unsigned>(index));
      fill(static_cast<float*>(rtcGetGeometryBufferData(g, RTC_BUFFER_TYPE_VERTEX, 0)),
           corners_in_map(solid));
      rtcUpdateGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0);
      rtcCommitGeometry(g);
      moved = true;
    }
    if (moved) rtcCommitScene(rays.get());
  }

  // The search says which surface; where exactly is answered here, the same on every machine.
  RayHit exact(unsigned id, float distance, const Vector3f& search_normal, const Vector3f& origin,
               const Vector3f& direction) const {
    RayHit hit;
    if (id == RTC_INVALID_GEOMETRY_ID) return hit;
    hit.distance = distance;
    if (id == floor_id) {
      hit.surface = kFloorSurface;
      if (direction.z() != 0) hit.distance = -origin.z() / direction.z();
      hit.normal = {0, 0, direction.z() < 0 ? 1.0F : -1.0F};
      hit.own_point = origin + hit.distance * direction;
      hit.own_point.z() = 0;
      return hit;
    }
    hit.surface = static_cast<int>(id);
    const Placed& solid = placed[id];
    if (enter(solid, origin, direction, hit)) return hit;
    // From inside, or along an edge by less than a float can tell: as the search found it.
    hit.own_point = solid.to_own(origin + distance * direction);
    hit.normal = (search_normal.dot(direction) > 0 ? Vector3f(-search_normal) : search_normal).normalized();
    return hit;
  }
};

Scene::Scene(World world) : impl_(std::make_unique<Impl>(std::move(world))) {}
Scene::~Scene() = default;
Scene::Scene(Scene&&) noexcept = default;
Scene& Scene::operator=(Scene&&) noexcept = default;

const World& Scene::world() const { return impl_->world; }
const std::vector<Solid>& Scene::solids() const { return impl_->solids; }
const WorldState& Scene::state() const { return impl_->state; }

namespace {

const Thing& thing_of(const World& world, int surface) {
  const auto i = static_cast<std::size_t>(surface);
  return i < world.things.size() ? world.things[i] : world.moving[i - world.things.size()].thing;
}

}  // namespace

int Scene::texture_of(int surface) const {
  if (surface == kFloorSurface) return impl_->world.floor.texture;
  return surface == kNoSurface ? -1 : thing_of(impl_->world, surface).texture;
}

std::string Scene::name_of(int surface) const {
  if (surface == kFloorSurface) return "floor";
  return surface == kNoSurface ? "nothing" : thing_of(impl_->world, surface).name;
}

void Scene::set_state(const WorldState& state) {
  if (state.set_off.size() != impl_->world.moving.size()) throw Error("the state belongs to another world");
  impl_->state = state;
  impl_->place_moving();
}

void Scene::advance(Time now, const Pose2& robot, const Onlooker* onlooker) {
  impl_->state = advanced(impl_->world, std::move(impl_->state), now, robot, onlooker);
  impl_->place_moving();
}

RayHit Scene::cast(const Vector3d& origin, const Vector3d& direction, double farthest) const {
  const Vector3f o = origin.cast<float>(), d = direction.cast<float>();
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRayHit ray{};
  ray.ray.org_x = o.x(), ray.ray.org_y = o.y(), ray.ray.org_z = o.z();
  ray.ray.dir_x = d.x(), ray.ray.dir_y = d.y(), ray.ray.dir_z = d.z();
  ray.ray.tnear = 0;
  ray.ray.tfar = static_cast<float>(farthest);
  ray.ray.mask = ~0U;
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(impl_->rays.get(), &context, &ray);
  return impl_->exact(ray.hit.geomID, ray.ray.tfar, {ray.hit.Ng_x, ray.hit.Ng_y, ray.hit.Ng_z}, o, d);
}

namespace {

// Fills the rays of an Embree packet; returns which of them count.
std::array<int, RayPacket::kSize> fill_rays(RTCRay16& r, const Vector3f& origin, const RayPacket& rays,
                                            float farthest) {
  std::array<int, RayPacket::kSize> valid;
  for (std::size_t i = 0; i < RayPacket::kSize; ++i) {
    valid[i] = static_cast<int>(i) < rays.count && std::isfinite(rays.dx[i]) ? -1 : 0;
    r.org_x[i] = origin.x(), r.org_y[i] = origin.y(), r.org_z[i] = origin.z();
    r.dir_x[i] = rays.dx[i], r.dir_y[i] = rays.dy[i], r.dir_z[i] = rays.dz[i];
    r.tnear[i] = 0;
    r.tfar[i] = farthest;
    r.time[i] = 0;
    r.mask[i] = ~0U;
    r.id[i] = 0;
    r.flags[i] = 0;
  }
  return valid;
}

RTCIntersectContext coherent_context() {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  return context;
}

}  // namespace

void Scene::cast(const Vector3f& origin, const RayPacket& rays,
                 std::array<RayHit, RayPacket::kSize>& hits) const {
  RTCIntersectContext context = coherent_context();
  RTCRayHit16 r;
  alignas(64) auto valid = fill_rays(r.ray, origin, rays, std::numeric_limits<float>::infinity());
  for (unsigned& id : r.hit.geomID) id = RTC_INVALID_GEOMETRY_ID;
  for (unsigned& id : r.hit.instID[0]) id = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect16(valid.data(), impl_->rays.get(), &context, &r);
  for (std::size_t i = 0; i < RayPacket::kSize; ++i)
    hits[i] = valid[i] == 0 ? RayHit{}
                            : impl_->exact(r.hit.geomID[i], r.ray.tfar[i],
                                           {r.hit.Ng_x[i], r.hit.Ng_y[i], r.hit.Ng_z[i]}, origin,
                                           {rays.dx[i], rays.dy[i], rays.dz[i]});
}

bool Scene::sees(const Vector3d& a, const Vector3d& b, double tolerance) const {
  RayPacket packet;
  packet.count = 1;
  const Vector3f to = (b - a).cast<float>();
  packet.dx[0] = to.x(), packet.dy[0] = to.y(), packet.dz[0] = to.z();
  return sees_points(a.cast<float>(), packet, static_cast<float>(tolerance)) == 1U;
}

std::uint32_t Scene::sees_points(const Vector3f& origin, const RayPacket& to_points, float tolerance) const {
  RTCIntersectContext context = coherent_context();
  RTCRay16 r;
  alignas(64) auto valid = fill_rays(r, origin, to_points, 1.0F - tolerance);
  rtcOccluded16(valid.data(), impl_->rays.get(), &context, &r);
  std::uint32_t seen = 0;
  for (std::size_t i = 0; i < RayPacket::kSize; ++i)
    if (valid[i] != 0 && r.tfar[i] >= 0) seen |= 1U << i;  // an occluded ray has tfar = -infinity
  return seen;
}

std::optional<Contact> Scene::collides(std::span<const Solid> parts,
                                       const Pose2& map_from_base) const noexcept {
  for (std::size_t p = 0; p < parts.size(); ++p) {
    const Solid part = parts[p].moved(map_from_base);
    for (std::size_t s = 0; s < impl_->solids.size(); ++s)
      if (overlap(part, impl_->solids[s])) return Contact{p, s};
  }
  return std::nullopt;
}

bool Scene::occupied(const Vector3d& point) const {
  return point.z() < 0 || std::any_of(impl_->solids.begin(), impl_->solids.end(),
                                      [&](const Solid& s) { return s.contains(point); });
}

double Scene::distance(const Vector3d& origin, const Vector3d& direction) const {
  const Vector3d unit = direction.normalized();
  const RayHit hit = cast(origin, unit);
  return hit.met() ? static_cast<double>(hit.distance) : std::numeric_limits<double>::infinity();
}

}  // namespace headway::sim
