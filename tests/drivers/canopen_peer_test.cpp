// The head's master against CANopen nodes that are not ours (npm's "canopen"): what it writes, they
// understand, and what happens to them ends in the states that docs/faults.md names.
#include "tests/drivers/canopen_peer.h"

#include <cmath>
#include <functional>
#include <map>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "drivers/cia402_head.h"
#include "hal/angle.h"
#include "tests/drivers/scripted_bus.h"

namespace headway::drivers {
namespace {

using hal::HeadHealth;
using hal::cia402::State;
using std::chrono::milliseconds;
using testing::kBusCycle;

constexpr int kPan = 0x11, kTilt = 0x12;

class CanopenPeer : public ::testing::Test {
 protected:
  explicit CanopenPeer(const HeadConfig& config = {}) : head_(bus_, config) {}

  void SetUp() override {
    if (!peer_.is_there())
      GTEST_SKIP() << "node or its package canopen is not installed; scripts/setup installs both";
  }

  void cycle() {
    now_ += kBusCycle;
    bus_.now = now_;
    for (const hal::CanFrame& frame : peer_.step(kBusCycle, now_)) {
      if (to_head_(frame)) head_.receive(frame);
    }
    if (deaf_) return;
    const std::size_t before = bus_.sent.size();
    head_.tick(now_);
    for (std::size_t i = before; i < bus_.sent.size(); ++i) peer_.send(bus_.sent[i]);
  }
  void run(Duration d) {
    for (const Time end = now_ + d; now_ < end;) cycle();
  }
  bool run_until(const std::function<bool()>& done, Duration limit) {
    for (const Time end = now_ + limit; now_ < end && !done();) cycle();
    return done();
  }
  bool run_until(HeadHealth health, Duration limit) {
    return run_until([&] { return head_.state().health == health; }, limit);
  }
  bool start() { return run_until(HeadHealth::kReady, seconds(5)); }
  bool turn(const hal::HeadAngles& target) {
    head_.command(target);
    return run_until([&] { return !head_.state().moving; }, seconds(5));
  }
  int position(int node) { return std::stoi(peer_.ask("position " + std::to_string(node))); }
  void tell(const std::string& order, int node, const std::string& what = "") {
    peer_.tell(order + " " + std::to_string(node) + " " + what);
  }

  testing::CanopenPeer peer_;
  testing::ScriptedBus bus_;
  Cia402Head head_;
  Time now_ = at_seconds(100);
  bool deaf_ = false;  ///< our program hangs
  std::function<bool(const hal::CanFrame&)> to_head_ = [](const hal::CanFrame&) { return true; };
};

/// The bytes of each object as last written to a node.
std::map<std::string, std::string> written(const testing::ScriptedBus& bus, int node) {
  std::map<std::string, std::string> last;
  for (const hal::CanFrame& f : bus.sent_with(0x600u + static_cast<unsigned>(node))) {
    if (f.data[0] == 0x40) continue;
    std::string bytes;
    for (int i = 0; i < 4 - ((f.data[0] >> 2) & 3); ++i)
      bytes += fmt::format("{:02x}", f.data[static_cast<std::size_t>(4 + i)]);
    last[fmt::format("{:02x}{:02x} {}", f.data[2], f.data[1], f.data[3])] = bytes;
  }
  return last;
}

TEST_F(CanopenPeer, TakesTheWholeSetUpAndReachesOperationEnabled) {
  ASSERT_TRUE(start());
  EXPECT_EQ(head_.pan().state, State::kOperationEnabled);
  EXPECT_EQ(head_.tilt().state, State::kOperationEnabled);
  EXPECT_EQ(head_.pan().boot_ups, 1u);
  for (const int node : {kPan, kTilt}) {
    const auto objects = written(bus_, node);
    EXPECT_EQ(objects.size(), 30u);
    for (const auto& [object, bytes] : objects)
      EXPECT_EQ(peer_.ask(fmt::format("get {} {}", node, object)), bytes) << object << " of " << node;
  }
}

TEST_F(CanopenPeer, TurnsTheHeadWhereItIsToldAndNoFurther) {
  ASSERT_TRUE(start());
  ASSERT_TRUE(turn({0.5, -0.2}));
  EXPECT_EQ(position(kPan), 28648);
  EXPECT_EQ(position(kTilt), -11459);
  EXPECT_NEAR(head_.state().position.pan, 0.5, 2e-5);
  ASSERT_TRUE(turn({3, -3}));
  EXPECT_EQ(position(kPan), 45000);
  EXPECT_EQ(position(kTilt), -30000);
}

class CyclicCanopenPeer : public CanopenPeer {
 protected:
  static HeadConfig cyclic() {
    HeadConfig config;
    config.set_points = SetPointMode::kCyclic;
    return config;
  }
  CyclicCanopenPeer() : CanopenPeer(cyclic()) {}
};

TEST_F(CyclicCanopenPeer, FollowsAndIsNeverToldToJump) {
  tell("push", kPan, "-12345");
  ASSERT_TRUE(start());
  ASSERT_TRUE(turn({0.5, -0.2}));
  run(milliseconds(60));  // the last target counts from the next SYNC on
  EXPECT_EQ(position(kPan), 28648);
  tell("reboot", kPan);
  tell("push", kPan, "4321");
  ASSERT_TRUE(run_until(HeadHealth::kStarting, milliseconds(20)));
  ASSERT_TRUE(start());
  EXPECT_EQ(position(kPan), 4321);
  ASSERT_TRUE(turn({3, -3}));
  run(milliseconds(60));
  EXPECT_EQ(position(kPan), 45000);
  EXPECT_LE(std::stoi(peer_.ask("jump 17")), 1147) << "1 rad/s in 20 ms";
}

TEST_F(CanopenPeer, IsFirstToldToStayWhereItIs) {
  tell("push", kPan, "12345");
  ASSERT_TRUE(start());
  run(seconds(0.5));
  EXPECT_EQ(position(kPan), 12345);
  EXPECT_NEAR(head_.state().position.pan, 12.345 * kDegree, 1e-9);
}

TEST_F(CanopenPeer, ThatRebootsIsSetUpAgainWithoutAJump) {
  ASSERT_TRUE(start());
  ASSERT_TRUE(turn({0.5, 0}));
  tell("reboot", kPan);
  tell("push", kPan, "-4321");
  ASSERT_TRUE(run_until(HeadHealth::kStarting, milliseconds(20)));
  ASSERT_TRUE(start());
  EXPECT_EQ(head_.pan().boot_ups, 2u);
  run(seconds(0.5));
  EXPECT_EQ(position(kPan), -4321);
}

TEST_F(CanopenPeer, ThatSendsAnEmergencyIsAFaultUntilRecovered) {
  ASSERT_TRUE(start());
  tell("emergency", kTilt, "8611");
  ASSERT_TRUE(run_until(HeadHealth::kFault, milliseconds(20)));
  EXPECT_EQ(head_.tilt().failure, DriveFailure::kEmergency);
  EXPECT_EQ(head_.tilt().emergency_code, 0x8611);
  run(seconds(1));
  ASSERT_EQ(head_.state().health, HeadHealth::kFault);
  head_.recover();
  EXPECT_TRUE(start());
}

TEST_F(CanopenPeer, ThatIsSilentIsGoneAfter300MsAndItsTwinHolds) {
  ASSERT_TRUE(start());
  head_.command({0.7, 0.7});
  run(seconds(0.2));
  to_head_ = [](const hal::CanFrame& f) { return f.id != 0x711; };
  run(milliseconds(190));  // the last heartbeat came up to 100 ms ago
  ASSERT_EQ(head_.state().health, HeadHealth::kReady);
  ASSERT_TRUE(run_until(HeadHealth::kFault, milliseconds(120)));
  EXPECT_EQ(head_.pan().failure, DriveFailure::kGone);
  run(milliseconds(20));
  const int held = position(kTilt);
  EXPECT_LT(held, 40000);
  run(seconds(0.5));
  EXPECT_EQ(position(kTilt), held);
  to_head_ = [](const hal::CanFrame&) { return true; };
  EXPECT_TRUE(start());
}

TEST_F(CanopenPeer, ThatLacksAnObjectIsAFaultThatNamesIt) {
  tell("remove", kTilt, "60a8");
  ASSERT_TRUE(run_until(HeadHealth::kFault, seconds(2)));
  EXPECT_EQ(head_.tilt().failure, DriveFailure::kSetupRefused);
  EXPECT_EQ(head_.tilt().object, hal::cia402::object::kSiUnitPosition);
  EXPECT_EQ(head_.tilt().abort_code, 0x06020000u);
}

TEST_F(CanopenPeer, WithAFaultOfItsOwnIsResetOnlyWhenRecovered) {
  ASSERT_TRUE(start());
  tell("fault", kPan);
  ASSERT_TRUE(run_until(HeadHealth::kFault, milliseconds(60)));
  EXPECT_EQ(head_.pan().failure, DriveFailure::kDriveFault);
  run(seconds(0.5));
  EXPECT_EQ(head_.pan().state, State::kFault);
  head_.recover();
  EXPECT_TRUE(start());
}

TEST_F(CanopenPeer, StopsWithin300MsOfOurSilenceAndGoesOnWithoutAJumpWhenRecovered) {
  ASSERT_TRUE(start());
  head_.command({0.7, 0});
  run(seconds(0.1));
  deaf_ = true;
  run(milliseconds(305));  // as its heartbeat watch was set up, from our last heartbeat on
  const int stopped = position(kPan);
  EXPECT_LT(stopped, 30000);
  run(seconds(0.5));
  EXPECT_EQ(position(kPan), stopped);
  deaf_ = false;
  ASSERT_TRUE(run_until(HeadHealth::kFault, milliseconds(60)));
  EXPECT_EQ(head_.pan().failure, DriveFailure::kQuickStopped);
  run(seconds(0.5));
  EXPECT_EQ(head_.pan().state, State::kQuickStopActive) << "nobody here has ordered or ended it";
  head_.recover();
  ASSERT_TRUE(start());
  run(seconds(0.5));
  EXPECT_EQ(position(kPan), stopped);
}

TEST_F(CanopenPeer, HoldsAndWaitsForNobodyWhenWeLeave) {
  ASSERT_TRUE(start());
  head_.command({0.7, 0});
  run(seconds(0.1));
  head_.leave();
  ASSERT_TRUE(run_until([&] { return head_.has_left(); }, milliseconds(200)));
  EXPECT_EQ(peer_.ask("get 17 1016 1"), "00000000");
  const int stopped = position(kPan);
  deaf_ = true;
  run(seconds(0.5));
  EXPECT_NEAR(position(kPan), stopped, 3000) << "on the quick-stop ramp";
  EXPECT_EQ(head_.pan().emergency_code, 0);
}

}  // namespace
}  // namespace headway::drivers
