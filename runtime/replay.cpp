#include "runtime/replay.h"

#include <cstring>
#include <utility>

#include <fmt/format.h>

#include "runtime/recorded_values.h"

namespace headway::runtime {

namespace {

namespace ros = recording::ros;

hal::GrayImage gray(ros::Image image) {
  return {static_cast<int>(image.width), static_cast<int>(image.height), std::move(image.data)};
}

/// Whether its bytes are as many as its size and encoding say.
bool is_whole(const ros::Image& image) {
  constexpr std::uint32_t kLargest = 1 << 15;
  if (image.width > kLargest || image.height > kLargest) return false;
  const std::uint64_t pixels = std::uint64_t{image.width} * image.height;
  if (image.encoding == "mono8") return image.data.size() == pixels;
  return image.encoding == "32FC1" && image.data.size() == pixels * sizeof(float);
}

hal::DepthFrame depth(const ros::Image& image) {
  hal::DepthFrame frame;
  frame.width = static_cast<int>(image.width);
  frame.height = static_cast<int>(image.height);
  frame.depth.resize(image.data.size() / sizeof(float));
  std::memcpy(frame.depth.data(), image.data.data(), image.data.size());
  return frame;
}

template <class Value>
std::string differ(const char* what, const Value& was, const Value& is) {
  return fmt::format("{} was {}, is {}", what, was, is);
}

std::string first_difference(const recorded::MotionOrder& was, const recorded::MotionOrder& is) {
  if (was.look.pan != is.look.pan) return differ("the head's pan [rad]", was.look.pan, is.look.pan);
  if (was.look.tilt != is.look.tilt) return differ("the head's tilt [rad]", was.look.tilt, is.look.tilt);
  if (was.walk != is.walk) return differ("walk (0 stop, 1 plan)", was.walk, is.walk);
  const recorded::StepPlan &a = was.plan, &b = is.plan;
  if (a.session != b.session) return differ("the plan's session", a.session, b.session);
  if (a.first_index != b.first_index) return differ("the plan's first step", a.first_index, b.first_index);
  if (a.steps.size() != b.steps.size()) return differ("the number of steps", a.steps.size(), b.steps.size());
  for (std::size_t i = 0; i < a.steps.size(); ++i)
    if (recording::to_cdr(a.steps[i]) != recording::to_cdr(b.steps[i]))
      return fmt::format("step {} landed at ({}, {}, {}), lands at ({}, {}, {})", a.first_index + i,
                         a.steps[i].landing.x, a.steps[i].landing.y, a.steps[i].landing.yaw,
                         b.steps[i].landing.x, b.steps[i].landing.y, b.steps[i].landing.yaw);
  if (a.newest_frame_ns != b.newest_frame_ns)
    return differ("the plan's newest frame [ns]", a.newest_frame_ns, b.newest_frame_ns);
  if (was.seen_ns != is.seen_ns) return differ("when it saw something last [ns]", was.seen_ns, is.seen_ns);
  if (was.goal != is.goal) return differ("whether a goal is pursued", was.goal, is.goal);
  if (was.goal_after != is.goal_after) return differ("the stops known of", was.goal_after, is.goal_after);
  if (a.complete != b.complete) return differ("whether the plan is complete", a.complete, b.complete);
  return "the walk orders that its steps are part of";
}

}  // namespace

Replay::Replay(const Parts& parts) : parts_(parts) {
  parts_.frames.show(*this);
  parts_.frames.observe([this](const FrameSnapshot& snapshot) {
    floor_sum_ = sum_of(snapshot.mapper.floor());
    if (observer_) observer_(snapshot);
  });
}

void Replay::ends(const MotionOrder* order, const BusReport&, bool) {
  order_.reset();
  if (order != nullptr) order_ = *order;
}

bool Replay::miss(std::string what) {
  if (!result_.missing) result_.missing = std::move(what);
  return false;
}

bool Replay::take(const Row& row) {
  if (result_.missing) return false;
  if (is_picture(row.topic)) {
    pictures_.push_back(recording::from_cdr<ros::Image>(row.cdr));
    return true;
  }
  if (row.topic == Topic::kGoal)
    parts_.mission.set_goal(from_recorded(recording::from_cdr<recorded::Goal>(row.cdr)));
  if (row.topic != Topic::kWork) return true;
  const std::uint32_t expected = next_.value_or(0);
  if (row.sequence != expected)
    return miss(next_ ? fmt::format("{} works before {:.3f} s were dropped or lost", row.sequence - expected,
                                    to_seconds(row.time))
                      : fmt::format("it begins with work {}, expected the first file of a recording that was "
                                    "begun with the program",
                                    row.sequence));
  next_ = row.sequence + 1;
  return work(recording::from_cdr<recorded::Work>(row.cdr));
}

bool Replay::offer_frame(std::uint64_t sequence) {
  const std::size_t wanted = parts_.stereo ? 2 : 1;
  const std::vector<ros::Image> pictures = std::exchange(pictures_, {});
  const auto missing = [&] {
    return miss(fmt::format("the picture of frame {} is not in the recording, or not whole", sequence));
  };
  if (pictures.size() != wanted) return missing();
  for (const ros::Image& picture : pictures)
    if (!is_whole(picture) || (picture.encoding == "mono8") != (parts_.stereo != nullptr)) return missing();
  const Time exposure = ros::time_of(pictures.front().header.stamp);
  if (parts_.stereo) {
    parts_.stereo->offer({exposure, sequence, gray(pictures[0]), gray(pictures[1])});
  } else {
    hal::DepthFrame frame = depth(pictures[0]);
    frame.exposure = exposure;
    frame.sequence = sequence;
    parts_.depth->offer(std::move(frame));
  }
  return true;
}

bool Replay::work(const recorded::Work& work) {
  const Time now{Duration(work.now_ns)};
  if (!work.frame.empty() && !offer_frame(work.frame.front())) return false;
  pictures_.clear();
  bool fits = true;
  for (const recorded::ChestSample& sample : work.chest)
    fits &= parts_.links.chest.push(from_recorded(sample));
  for (const recorded::HeadSample& sample : work.head) fits &= parts_.links.head.push(from_recorded(sample));
  for (const recorded::GoalOrder& order : work.goals) fits &= parts_.links.goals.push(from_recorded(order));
  for (const recorded::LookOrder& order : work.looks) fits &= parts_.links.looks.push(from_recorded(order));
  if (work.level >= kFrameLevels)
    return miss(fmt::format("the work at {:.3f} s is of no level", to_seconds(now)));
  if (!fits) return miss(fmt::format("the work at {:.3f} s took in more than one can", to_seconds(now)));
  if (!work.report.empty()) parts_.links.report.publish(from_recorded(work.report.front()));
  parts_.stopwatch.load(work.stopwatch_ns);
  floor_sum_ = 0;
  parts_.frames.fix_level(static_cast<FrameLevel>(work.level));
  parts_.frames.work(now);
  if (result_.works++ == 0) result_.first = now;
  result_.last = now;
  result_.frames += work.frame.size();
  result_.orders += work.order.size();
  compare(work);
  return true;
}

void Replay::compare(const recorded::Work& work) {
  if (result_.difference) return;
  const auto say = [&](const std::string& what) {
    result_.difference = fmt::format("work {} at {:.3f} s: {}", result_.works - 1,
                                     static_cast<double>(work.now_ns) * 1e-9, what);
  };
  if (work.order.empty() != !order_)
    return say(order_ ? "an order where there was none" : "no order where there was one");
  if (work.floor_sum != floor_sum_) return say("the floor map is another");
  if (!order_) return;
  const recorded::MotionOrder is = to_recorded(*order_);
  if (recording::to_cdr(is) != recording::to_cdr(work.order.front()))
    say(first_difference(work.order.front(), is));
}

}  // namespace headway::runtime
