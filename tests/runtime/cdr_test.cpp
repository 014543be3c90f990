// ROS 2 messages as bytes: what was put in comes out, laid out as the standard says, and no bytes do harm.
#include "runtime/recording/cdr.h"

#include <random>
#include <set>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "runtime/recorded_messages.h"
#include "runtime/recording/ros_messages.h"
#include "runtime/topics.h"

namespace headway::recording {
namespace {

std::vector<int> numbers(const std::vector<std::byte>& bytes) {
  std::vector<int> out;
  for (const std::byte b : bytes) out.push_back(std::to_integer<int>(b));
  return out;
}

/// Fills every field with something drawn, lists with up to three values.
struct Draw {
  std::mt19937_64 dice;

  template <class T>
  requires(std::is_arithmetic_v<T>) void fill(T& value) {
    if constexpr (std::is_same_v<T, bool>)
      value = dice() % 2 == 0;
    else if constexpr (std::is_floating_point_v<T>)
      value = static_cast<T>(static_cast<double>(dice()) * 1e-6 - 1e12);
    else
      value = static_cast<T>(dice());
  }
  void fill(std::string& text) {
    text.resize(dice() % 9);
    for (char& c : text) c = static_cast<char>('a' + dice() % 26);
  }
  template <class T, std::size_t N>
  void fill(std::array<T, N>& values) {
    for (T& value : values) fill(value);
  }
  template <class T>
  void fill(std::vector<T>& values) {
    values.resize(dice() % 4);
    for (T& value : values) fill(value);
  }
  template <CdrMessage T>
  void fill(T& message) {
    T::fields(message, [this](const char*, auto& field) { fill(field); });
  }
};

template <CdrMessage T>
void survives(std::uint64_t seed) {
  Draw draw{std::mt19937_64(seed)};
  T message;
  draw.fill(message);
  const std::vector<std::byte> bytes = to_cdr(message);
  RC_ASSERT(to_cdr(from_cdr<T>(bytes)) == bytes);
  // No prefix of it is such a message, and none does harm.
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    try {
      from_cdr<T>(std::span(bytes).first(size));
      RC_FAIL("a message that was cut was taken for whole");
    } catch (const CdrError&) {
    }
  }
}

RC_GTEST_PROP(Cdr, GivesBackWhatWasPutIn, (std::uint64_t seed)) {
  survives<runtime::recorded::Work>(seed);
  survives<runtime::recorded::BusReport>(seed);
  survives<runtime::recorded::Step>(seed);
  survives<runtime::recorded::Goal>(seed);
  survives<runtime::recorded::Mission>(seed);
  survives<ros::Image>(seed);
  survives<ros::CameraInfo>(seed);
  survives<ros::TfMessage>(seed);
  survives<ros::Path>(seed);
  survives<ros::OccupancyGrid>(seed);
  survives<ros::CanFrame>(seed);
}

RC_GTEST_PROP(Cdr, NoBytesDoHarm, (std::vector<std::uint8_t> noise)) {
  noise.insert(noise.begin(), {0, 1, 0, 0});
  const auto bytes = std::as_bytes(std::span(noise));
  const auto read = [&]<class T>(T) {
    try {
      from_cdr<T>(bytes);
    } catch (const CdrError&) {
    }
  };
  read(runtime::recorded::Work{});
  read(ros::Image{});
  read(ros::TfMessage{});
}

TEST(Cdr, LiesInMemoryAsTheStandardSays) {
  // Header, then sec and nanosec (4 bytes each), then the text's length with its closing zero.
  const ros::Header header{{1, 2}, "ab"};
  EXPECT_EQ(numbers(to_cdr(header)),
            (std::vector<int>{0, 1, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 3, 0, 0, 0, 'a', 'b', 0}));
  // A double is aligned to eight bytes from where the message begins, behind its header of four.
  const runtime::recorded::Footstep step{.foot = 1, .landing = {}, .dz = 0, .duration_ns = 5, .clear = 0};
  const std::vector<int> bytes = numbers(to_cdr(step));
  ASSERT_EQ(bytes.size(), 4U + 8 + 3 * 8 + 3 * 8);
  EXPECT_EQ(bytes[4], 1);
  EXPECT_EQ(bytes[4 + 8 + 4 * 8], 5);
}

TEST(Cdr, ALengthThatTheBytesCannotHoldIsRefusedAtOnce) {
  std::vector<std::byte> bytes = to_cdr(ros::TfMessage{});
  for (std::size_t i = 4; i < 8; ++i) bytes[i] = std::byte{0xFF};
  EXPECT_THROW(from_cdr<ros::TfMessage>(bytes), CdrError);
}

TEST(Cdr, BigEndianAndOtherEncodingsAreRefused) {
  std::vector<std::byte> bytes = to_cdr(ros::Time{1, 2});
  bytes[1] = std::byte{0};
  EXPECT_THROW(from_cdr<ros::Time>(bytes), CdrError);
}

TEST(Ros2msg, NamesEachTypeThatAMessageIsMadeOfOnce) {
  EXPECT_EQ(
      ros2msg<ros::PoseStamped>(),
      "std_msgs/Header header\ngeometry_msgs/Pose pose\n" + std::string(80, '=') +
          "\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n" + std::string(80, '=') +
          "\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n" + std::string(80, '=') +
          "\nMSG: geometry_msgs/Pose\ngeometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n" +
          std::string(80, '=') + "\nMSG: geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n" +
          std::string(80, '=') +
          "\nMSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n");
}

TEST(RosTime, HoldsEveryNanosecondBeforeAndAfterTheEpoch) {
  for (const std::int64_t ns :
       {std::int64_t{0}, std::int64_t{1}, std::int64_t{-1}, std::int64_t{999'999'999},
        std::int64_t{1'000'000'000}, std::int64_t{-1'500'000'000}, std::int64_t{123'456'789'012'345'678}}) {
    const headway::Time t{Duration(ns)};
    EXPECT_EQ(ros::time_of(ros::stamp(t)), t);
    EXPECT_LT(ros::stamp(t).nanosec, 1'000'000'000U);
  }
}

TEST(Topics, HaveNamesOfTheirOwnInTheOrderOfTheirNumbers) {
  std::set<std::string_view> names;
  for (const runtime::TopicKind& topic : runtime::kTopics) names.insert(topic.name);
  EXPECT_EQ(names.size(), runtime::kTopics.size());
  EXPECT_EQ(runtime::kind(runtime::Topic::kWork).name, "/headway/work");
  EXPECT_EQ(runtime::kind(runtime::Topic::kDepth).name, "/camera/depth");
  EXPECT_EQ(runtime::kind(runtime::Topic::kMap).name, "/map");
}

}  // namespace
}  // namespace headway::recording
